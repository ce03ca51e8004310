// A phantom scanned coarsely and built into a head once for all tests of a program.
#pragma once

#include <gtest/gtest.h>

#include "turgor/anatomy/head.hpp"
#include "turgor/anatomy/phantom.hpp"

namespace turgor::test {

struct PhantomCase {
  PhantomParameters parameters;
  Phantom phantom;
  Head head;
  Landmarks landmarks;
};

/// Voxels of 1.2 mm; ends the test program with the error where a step fails.
inline const PhantomCase& phantom_case() {
  static const PhantomCase instance = [] {
    PhantomParameters parameters;
    parameters.voxel_mm = parameters.slice_mm = 1.2;
    Context context;
    auto require = [](auto&& result) -> decltype(auto) {
      if (!result) {
        ADD_FAILURE() << result.error().message();
        std::abort();
      }
      return *std::forward<decltype(result)>(result);
    };
    Phantom phantom = require(Phantom::create(parameters));
    Scan scan;
    scan.hu = require(phantom.scan(context));
    Head head = require(build_head(scan, {}, context));
    Landmarks landmarks = find_landmarks(head, context);
    return PhantomCase{parameters, std::move(phantom), std::move(head), std::move(landmarks)};
  }();
  return instance;
}

}  // namespace turgor::test
