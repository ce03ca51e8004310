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

/// Points of an element.
using ElementCorners = std::function<std::span<const int>(std::size_t element)>;

/// Elements that share faces are one rigid piece; pieces that share nodes only are hinged there. Contacts
/// that press or draw hold their node across their plane: whether a load presses the body on, only solving
/// tells. Error: a piece that is free to move, by name, place and motion.
Result<void> check_held(std::span<const Vec3> points, std::size_t elements, const ElementCorners& corners,
                        const FacePairs& face_pairs, std::span<const NodeSupport> supports,
                        std::span<const Contact> contacts = {});
inline Result<void> check_held(std::span<const Vec3> points, std::span<const std::array<int, 8>> elements,
                               const FacePairs& face_pairs, std::span<const NodeSupport> supports,
                               std::span<const Contact> contacts = {}) {
  return check_held(
      points, elements.size(), [&](std::size_t e) -> std::span<const int> { return elements[e]; }, face_pairs,
      supports, contacts);
}

}  // namespace turgor::detail
