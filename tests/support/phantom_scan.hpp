// Scans of the phantom, each made once for all tests of a program.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <tuple>

#include "turgor/anatomy/phantom.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor::test {

/// Ends the test program with the error where a step fails.
template <class T>
T require(Result<T> result) {
  if (!result) {
    ADD_FAILURE() << result.error().message();
    std::abort();
  }
  return *std::move(result);
}

inline PhantomParameters phantom_parameters(double voxel_mm, bool condyles_touch = false) {
  PhantomParameters parameters;
  parameters.voxel_mm = parameters.slice_mm = voxel_mm;
  parameters.condyles_touch = condyles_touch;
  return parameters;
}

inline const Scan& phantom_scan(double voxel_mm, bool condyles_touch = false) {
  static std::map<std::tuple<double, bool>, Scan> scans;
  const auto key = std::make_tuple(voxel_mm, condyles_touch);
  if (const auto found = scans.find(key); found != scans.end()) return found->second;
  Context context;
  Scan scan;
  scan.hu = require(require(Phantom::create(phantom_parameters(voxel_mm, condyles_touch))).scan(context));
  return scans.emplace(key, std::move(scan)).first->second;
}

}  // namespace turgor::test
