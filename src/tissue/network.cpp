#include "turgor/tissue/network.hpp"

#include <fmt/format.h>

#include <string>

namespace turgor {
namespace {

Error broken(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "spring network", std::move(remedy)};
}

bool at_least_zero(double x) {
  return std::isfinite(x) && x >= 0;
}
bool above_zero(double x) {
  return std::isfinite(x) && x > 0;
}

Result<void> check_points(const SpringNetwork& network) {
  if (network.mass_g.size() != network.rest.size()) {
    return broken(
        fmt::format("there are {} points but {} masses", network.rest.size(), network.mass_g.size()),
        "Give each point one mass");
  }
  for (std::size_t i = 0; i < network.rest.size(); ++i) {
    if (!is_within_reach(network.rest[i])) {
      return broken(fmt::format("the rest position of point {} is not a finite number of millimetres", i),
                    "Coordinates reach to 1e9 mm");
    }
    if (!at_least_zero(network.mass_g[i])) {
      return broken(fmt::format("the mass of point {} is {} g", i, network.mass_g[i]),
                    "A mass must be a finite number of at least 0");
    }
  }
  return {};
}

Result<void> check_springs(const SpringNetwork& network) {
  const int points = static_cast<int>(network.rest.size());
  for (std::size_t i = 0; i < network.springs.size(); ++i) {
    const Spring& s = network.springs[i];
    if (s.a < 0 || s.b < 0 || s.a >= points || s.b >= points) {
      return broken(fmt::format("spring {} joins points {} and {} of {}", i, s.a, s.b, points),
                    "Point numbers start at 0");
    }
    if (s.a == s.b) return broken(fmt::format("spring {} joins point {} to itself", i, s.a), "Remove it");
    if (!above_zero(s.rest_length_mm)) {
      return broken(fmt::format("the rest length of spring {} is {} mm", i, s.rest_length_mm),
                    "Merge coincident points, or give it a length above 0");
    }
    if (!at_least_zero(s.stiffness_n)) {
      return broken(fmt::format("the stiffness of spring {} is {} N", i, s.stiffness_n),
                    "A stiffness must be a finite number of at least 0");
    }
    if (s.law > SpringLaw::hookean) {
      return broken(fmt::format("spring {} has the unknown law {}", i, static_cast<int>(s.law)),
                    "The laws are linear, exponential, logarithmic, square, collagen and hookean");
    }
  }
  return {};
}

// Corners of an element are points of the network, all different; `named` tells which element it is.
template <std::size_t corners, class Name>
Result<void> check_corners(const std::array<int, corners>& p, std::size_t points, Name&& named) {
  for (std::size_t corner = 0; corner < corners; ++corner) {
    if (p[corner] < 0 || static_cast<std::size_t>(p[corner]) >= points) {
      return broken(fmt::format("{} has the corner {} of {} points", named(), p[corner], points),
                    "Point numbers start at 0");
    }
    for (std::size_t other = 0; other < corner; ++other) {
      if (p[corner] == p[other])
        return broken(fmt::format("{} has the corner {} twice", named(), p[corner]), "Remove it");
    }
  }
  return {};
}

Result<void> check_volumes(const SpringNetwork& network) {
  for (std::size_t i = 0; i < network.volumes.size(); ++i) {
    const VolumeElement& v = network.volumes[i];
    TURGOR_CHECK(
        check_corners(std::to_array(v.p), network.rest.size(), [&] { return fmt::format("volume {}", i); }));
    if (!above_zero(v.rest_volume_mm3)) {
      return broken(fmt::format("the rest volume of volume {} is {} mm³", i, v.rest_volume_mm3),
                    "Swap two corners of an inverted element, remove a flat one");
    }
    if (!at_least_zero(v.modulus_mpa) || !at_least_zero(v.inversion_guard_mpa)) {
      return broken(fmt::format("volume {} has the modulus {} MPa and the inversion guard {} MPa", i,
                                v.modulus_mpa, v.inversion_guard_mpa),
                    "Both must be finite numbers of at least 0");
    }
  }
  return {};
}

Result<void> check_areas(const SpringNetwork& network) {
  for (std::size_t i = 0; i < network.areas.size(); ++i) {
    const AreaElement& a = network.areas[i];
    TURGOR_CHECK(
        check_corners(std::to_array(a.p), network.rest.size(), [&] { return fmt::format("area {}", i); }));
    if (!above_zero(a.rest_area_mm2)) {
      return broken(fmt::format("the rest area of area {} is {} mm²", i, a.rest_area_mm2),
                    "Remove a flat triangle");
    }
    if (!at_least_zero(a.stiffness_nmm)) {
      return broken(fmt::format("the stiffness of area {} is {} N·mm", i, a.stiffness_nmm),
                    "It must be a finite number of at least 0");
    }
  }
  return {};
}

// One kind of a solid's elements, `size` telling the rest length, area or volume of one.
template <std::size_t corners, class Size>
Result<void> check_elements(const std::vector<std::array<int, corners>>& elements,
                            const std::vector<double>& constants, std::size_t points, const char* kind,
                            std::size_t solid, Size&& size) {
  if (elements.size() != constants.size()) {
    return broken(fmt::format("solid {} has {} of kind {} but {} constants for them", solid, elements.size(),
                              kind, constants.size()),
                  "Give each one constant");
  }
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto name = [&] { return fmt::format("{} {} of solid {}", kind, i, solid); };
    const auto& p = elements[i];
    TURGOR_CHECK(check_corners(p, points, name));
    const double rest = size(p);
    if (!above_zero(rest)) {
      return broken(fmt::format("the size of {} at rest is {}", name(), rest),
                    "Swap two corners of an inverted tetrahedron, merge or remove what is flat");
    }
    if (!at_least_zero(constants[i]) || !std::isfinite(constants[i] / rest / rest)) {
      return broken(fmt::format("the constant of {} is {} N·mm", name(), constants[i]),
                    "It must be a finite number of at least 0, and not too large for so small an element");
    }
  }
  return {};
}

Result<void> check_solids(const SpringNetwork& network) {
  const std::vector<Vec3>& x = network.rest;
  for (std::size_t s = 0; s < network.solids.size(); ++s) {
    const Solid& solid = network.solids[s];
    TURGOR_CHECK(
        check_elements(solid.tetrahedra, solid.tetrahedron_nmm, x.size(), "tetrahedron", s,
                       [&](const auto& p) { return signed_volume(x[p[0]], x[p[1]], x[p[2]], x[p[3]]); }));
    TURGOR_CHECK(check_elements(solid.edges, solid.edge_nmm, x.size(), "edge", s,
                                [&](const auto& p) { return distance(x[p[0]], x[p[1]]); }));
    TURGOR_CHECK(check_elements(
        solid.triangles, solid.triangle_nmm, x.size(), "triangle", s,
        [&](const auto& p) { return 0.5 * length(cross(x[p[1]] - x[p[0]], x[p[2]] - x[p[0]])); }));
  }
  return {};
}

Result<void> check_contacts(const SpringNetwork& network) {
  int last = -1;
  for (std::size_t i = 0; i < network.contacts.size(); ++i) {
    const Contact& c = network.contacts[i];
    if (c.point <= last || c.point >= static_cast<int>(network.rest.size())) {
      return broken(fmt::format("contact {} is of point {}, after {} of {} points", i, c.point, last,
                                network.rest.size()),
                    "Sort contacts by point and give a point one at most");
    }
    last = c.point;
    if (!(std::abs(length(c.normal) - 1) < 1e-6) || !std::isfinite(c.offset_mm)) {
      return broken(fmt::format("the plane of contact {} has no unit normal or no finite offset", i),
                    "Normalise it");
    }
    if (!at_least_zero(c.stiffness_n_mm) || !at_least_zero(c.adhesion_n_mm)) {
      return broken(fmt::format("the stiffness of contact {} is {} N/mm, its adhesion {} N/mm", i,
                                c.stiffness_n_mm, c.adhesion_n_mm),
                    "Both must be finite numbers of at least 0");
    }
  }
  return {};
}

}  // namespace

Result<void> validate(const SpringNetwork& network) {
  TURGOR_CHECK(check_points(network));
  TURGOR_CHECK(check_springs(network));
  TURGOR_CHECK(check_areas(network));
  TURGOR_CHECK(check_volumes(network));
  TURGOR_CHECK(check_solids(network));
  return check_contacts(network);
}

}  // namespace turgor
