// The real head CT of the Debian package invesalius-examples, where it is installed.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace turgor::test {

inline std::filesystem::path example_scan() {
  if (const char* given = std::getenv("TURGOR_EXAMPLE_SCAN")) return given;
  return "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
}

}  // namespace turgor::test

/// Skips the test with a reason where the scan is not there.
#define TURGOR_NEED_EXAMPLE_SCAN()                                     \
  if (!std::filesystem::exists(turgor::test::example_scan()))          \
  GTEST_SKIP() << "the package invesalius-examples is not installed (" \
               << turgor::test::example_scan().string() << ')'
