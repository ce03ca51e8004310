#include "turgor/dynamics/prescribed_motion.hpp"

#include <fmt/format.h>

#include "turgor/tissue/network.hpp"

namespace turgor {
namespace {

Error broken(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "prescribed motion", std::move(remedy)};
}

Result<void> check_numbers(std::span<const int> points, int point_count, const char* name) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i] < 0 || points[i] >= point_count) {
      return broken(fmt::format("the {} point {} is not one of the {} points", name, points[i], point_count),
                    "Point numbers start at 0");
    }
    if (i > 0 && points[i] <= points[i - 1]) {
      return broken(fmt::format("the {} points are not ascending at point {}", name, points[i]),
                    "Sort them and name each once");
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const PrescribedMotion& motion, int point_count) {
  if (motion.moved.size() != motion.positions.size()) {
    return broken(fmt::format("{} points are moved but {} positions given", motion.moved.size(),
                              motion.positions.size()),
                  "Give each moved point one position");
  }
  TURGOR_CHECK(check_numbers(motion.moved, point_count, "moved"));
  TURGOR_CHECK(check_numbers(motion.fixed, point_count, "fixed"));
  for (std::size_t i = 0; i < motion.positions.size(); ++i) {
    if (!is_within_reach(motion.positions[i])) {
      return broken(fmt::format("the position of the moved point {} is not a finite number of millimetres",
                                motion.moved[i]),
                    "Check the transform that moves it; coordinates reach to 1e9 mm");
    }
  }
  std::size_t f = 0;
  for (const int m : motion.moved) {
    while (f < motion.fixed.size() && motion.fixed[f] < m) ++f;
    if (f < motion.fixed.size() && motion.fixed[f] == m) {
      return broken(fmt::format("point {} is both moved and fixed", m), "Name it once");
    }
  }
  return {};
}

}  // namespace turgor
