// The nearest of many points, by a kd-tree (nanoflann behind the curtain). Internal to the module.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor::detail {

struct NearPoint {
  double squared_distance = 0;
  int point = 0;
  bool operator<(const NearPoint& b) const {
    return squared_distance != b.squared_distance ? squared_distance < b.squared_distance : point < b.point;
  }
};

/// Points are copied in. Queries are const and thread-safe.
class NearestPoints {
 public:
  /// At least one point, coordinates finite and their squares too.
  explicit NearestPoints(std::vector<Vec3> points);
  ~NearestPoints();

  /// Fills `found` with as many of the nearest points, nearest first, of equally far ones the lower number;
  /// no longer than there are points.
  void find(const Vec3& at, std::span<NearPoint> found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace turgor::detail
