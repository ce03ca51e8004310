// The force of every element of a network by itself. Internal to the module.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/tissue/network.hpp"

namespace turgor {

/// On the corners of an element; each force is linear in its constant, so that it is also the force per
/// relative change of it.
struct ElementForce {
  int corners = 0;
  std::array<int, 4> point{};
  std::array<Vec3, 4> force_n{};
};

/// In the order of NetworkConstants.
std::vector<ElementForce> forces_of_constants(const SpringNetwork& network, std::span<const Vec3> positions);

}  // namespace turgor
