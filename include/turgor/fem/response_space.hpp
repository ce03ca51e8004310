// Where to begin a solution from, once others of the same body are known: small displacements add up, so a
// bone that goes on in a direction it has been moved in costs next to nothing.
#pragma once

#include <deque>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// The last solutions of one body under one load: what held it, and its displacements. Their affine
/// combinations solve the body exactly for the same combinations of what holds it, as long as its law is
/// linear and its contacts stay as they are; otherwise they are a start.
class ResponseSpace {
 public:
  /// `capacity` ≥ 1 solutions are kept, the oldest goes first: six for a bone's directions and turns, and
  /// one.
  explicit ResponseSpace(std::size_t capacity = 7);

  /// `held_mm`: displacements of the supports, in their order; `displacement_mm`: of each node. The rest
  /// of a body without load, all zeros, is a solution too. Errors: lengths other than before.
  Result<void> add(std::span<const Vec3> held_mm, std::span<const Vec3> displacement_mm);
  /// The combination whose held displacements come nearest to `held_mm` in the sense of least squares; empty
  /// where nothing is known. Error: another length than before.
  [[nodiscard]] Result<std::vector<Vec3>> start(std::span<const Vec3> held_mm) const;
  [[nodiscard]] std::size_t size() const { return known_.size(); }

 private:
  struct Known {
    std::vector<Vec3> held, displacement;
  };
  std::size_t capacity_;
  std::deque<Known> known_;
};

}  // namespace turgor
