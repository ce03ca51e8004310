// Whether supports hold a body against rigid motion. Internal.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/fem/elasticity.hpp"

namespace turgor::detail {

/// Pairs of elements that share a face, one call each.
using FacePairs = std::function<void(const std::function<void(int, int)>& pair)>;

/// Elements that share faces are one rigid piece; pieces that share nodes only are hinged there. Error: a
/// piece that is free to move, by name, place and motion.
Result<void> check_held(std::span<const Vec3> points, std::span<const std::array<int, 8>> elements,
                        const FacePairs& face_pairs, std::span<const NodeSupport> supports);

}  // namespace turgor::detail
