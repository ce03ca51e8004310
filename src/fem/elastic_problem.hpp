// What both solvers ask of a problem, and the forces of a load. Internal.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/fem/elasticity.hpp"

namespace turgor::detail {

/// Numbers beyond this are no displacement in mm, force in N or stress in MPa.
inline constexpr double kBeyondReach = 1e30;

Error bad_elasticity(std::string what, std::string where, std::string remedy);
Result<void> check(const ElasticBody& body, std::size_t elements);
Result<void> check(std::span<const NodeSupport> supports, std::size_t points);
/// Of points, planes, stiffness and adhesion; at most one contact a node.
Result<void> check(std::span<const Contact> contacts, std::size_t points);
/// Energy of a contact, N·mm, the force on its node, N, and d²E/dd² of its distance, N/mm. Touching presses.
struct ContactResponse {
  double energy = 0;
  Vec3 force_n;
  double slope = 0;
};
ContactResponse respond(const Contact& contact, const Vec3& place_mm);
Result<void> check_displacement(std::span<const Vec3> displacement_mm, std::size_t expected);
/// Adds forces at points and those of loaded faces, consistent with bilinear displacements.
Result<void> add_point_and_surface_loads(std::span<const Vec3> points, const ElasticLoad& load,
                                         std::vector<Vec3>& force_n);

}  // namespace turgor::detail
