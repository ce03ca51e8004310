#include "fem/elastic_problem.hpp"

#include <fmt/format.h>

#include <cmath>

#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

bool within_reach(const Vec3& v) {
  return std::abs(v.x) < kBeyondReach && std::abs(v.y) < kBeyondReach && std::abs(v.z) < kBeyondReach;
}

bool is_point(int node, std::size_t points) {
  return node >= 0 && at(node) < points;
}

// Two by two Gauss points of the face; exact for flat parallelograms under constant loads.
void add_surface_load(std::span<const Vec3> points, const SurfaceLoad& load, std::vector<Vec3>& force_n) {
  constexpr std::array<int, 4> sign_x{-1, 1, 1, -1}, sign_y{-1, -1, 1, 1};
  const double gauss = 1 / std::sqrt(3.0);
  for (std::size_t g = 0; g < 4; ++g) {
    const double xi = sign_x[g] * gauss, eta = sign_y[g] * gauss;
    Vec3 along_x, along_y;
    std::array<double, 4> shape{};
    for (std::size_t n = 0; n < 4; ++n) {
      const double fx = 1 + sign_x[n] * xi, fy = 1 + sign_y[n] * eta;
      shape[n] = 0.25 * fx * fy;
      along_x += points[at(load.corners[n])] * (0.25 * sign_x[n] * fy);
      along_y += points[at(load.corners[n])] * (0.25 * sign_y[n] * fx);
    }
    const Vec3 area = cross(along_x, along_y);
    const Vec3 force = load.traction_mpa * length(area) - area * load.pressure_mpa;
    for (std::size_t n = 0; n < 4; ++n) force_n[at(load.corners[n])] += force * shape[n];
  }
}

}  // namespace

Error bad_elasticity(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

Result<void> check(const ElasticBody& body, std::size_t elements) {
  if (body.materials.empty() || body.materials.size() > 256)
    return bad_elasticity(fmt::format("there are {} materials", body.materials.size()), "elastic body",
                          "Give 1 to 256");
  for (const ElasticMaterial& m : body.materials) TURGOR_CHECK(check(m));
  for (const std::size_t given : {body.material.size(), body.modulus_factor.size()}) {
    if (given == 0 || given == elements) continue;
    return bad_elasticity(fmt::format("{} values are given for {} elements", given, elements), "elastic body",
                          "Give one for each element, or none");
  }
  for (std::size_t e = 0; e < body.material.size(); ++e) {
    if (body.material[e] < body.materials.size()) continue;
    return bad_elasticity(fmt::format("there is no material {}", body.material[e]),
                          fmt::format("element {}", e),
                          fmt::format("Name one of 0 to {}", body.materials.size() - 1));
  }
  for (std::size_t e = 0; e < body.modulus_factor.size(); ++e) {
    if (body.modulus_factor[e] >= 1e-12 && body.modulus_factor[e] <= 1e12) continue;
    return bad_elasticity(fmt::format("the factor of Young's modulus is {:g}", body.modulus_factor[e]),
                          fmt::format("element {}", e), "It must lie between 1e-12 and 1e12");
  }
  return {};
}

Result<void> check(std::span<const NodeSupport> supports, std::size_t points) {
  for (std::size_t s = 0; s < supports.size(); ++s) {
    if (!is_point(supports[s].node, points))
      return bad_elasticity(fmt::format("there is no node {}", supports[s].node),
                            fmt::format("support {}", s), "Name a node of the body");
    if (!within_reach(supports[s].displacement_mm))
      return bad_elasticity("the displacement is not a number of millimetres", fmt::format("support {}", s),
                            "Give finite numbers");
  }
  return {};
}

Result<void> check(std::span<const Contact> contacts, std::size_t points) {
  std::vector<bool> taken(points, false);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    const auto bad = [&](std::string what, std::string remedy) {
      return bad_elasticity(std::move(what), fmt::format("contact {}", i), std::move(remedy));
    };
    if (!is_point(c.point, points))
      return bad(fmt::format("there is no node {}", c.point), "Name a node of the body");
    if (taken[at(c.point)])
      return bad(fmt::format("node {} has two contacts", c.point), "Give a node one at most");
    taken[at(c.point)] = true;
    if (!(std::abs(length(c.normal) - 1) < 1e-6) || !(std::abs(c.offset_mm) < kBeyondReach))
      return bad("the plane has no unit normal, or no offset",
                 "Give finite numbers and a normal of length 1");
    const auto is_stiffness = [](double k) { return k >= 0 && k < kBeyondReach; };
    if (!is_stiffness(c.stiffness_n_mm) || !is_stiffness(c.adhesion_n_mm))
      return bad(
          fmt::format("the stiffness is {:g} and the adhesion {:g} N/mm", c.stiffness_n_mm, c.adhesion_n_mm),
          "Both must be 0 or more");
  }
  return {};
}

ContactResponse respond(const Contact& contact, const Vec3& place_mm) {
  const double d = dot(contact.normal, place_mm) - contact.offset_mm;
  const double k = d > 0 ? contact.adhesion_n_mm : contact.stiffness_n_mm;
  return {0.5 * k * d * d, contact.normal * (-k * d), k};
}

Result<void> check_displacement(std::span<const Vec3> displacement_mm, std::size_t expected) {
  if (displacement_mm.size() != expected)
    return bad_elasticity(fmt::format("{} displacements are given for {}", displacement_mm.size(), expected),
                          "displacements", "Give one for each");
  for (std::size_t i = 0; i < expected; ++i) {
    if (!within_reach(displacement_mm[i]))
      return bad_elasticity("the displacement is not a number of millimetres",
                            fmt::format("displacement {}", i), "Give finite numbers");
  }
  return {};
}

Result<void> add_point_and_surface_loads(std::span<const Vec3> points, const ElasticLoad& load,
                                         std::vector<Vec3>& force_n) {
  if (!within_reach(load.gravity_mm_ms2))
    return bad_elasticity("gravity is not a finite acceleration", "load", "Give finite numbers");
  for (std::size_t f = 0; f < load.forces.size(); ++f) {
    const NodeForce& force = load.forces[f];
    if (!is_point(force.node, points.size()) || !within_reach(force.force_n))
      return bad_elasticity(fmt::format("the force on node {} cannot be applied", force.node),
                            fmt::format("force {}", f), "Give a node of the body and finite numbers");
    force_n[at(force.node)] += force.force_n;
  }
  for (std::size_t s = 0; s < load.surfaces.size(); ++s) {
    const SurfaceLoad& surface = load.surfaces[s];
    bool good = within_reach(surface.traction_mpa) && std::abs(surface.pressure_mpa) < kBeyondReach;
    for (const int node : surface.corners) good = good && is_point(node, points.size());
    if (!good)
      return bad_elasticity("the load on a face cannot be applied", fmt::format("surface load {}", s),
                            "Give four nodes of the body and finite numbers");
    add_surface_load(points, surface, force_n);
  }
  return {};
}

}  // namespace turgor::detail
