#include "turgor/tissue/network.hpp"

#include <fmt/format.h>

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
    if (s.law > SpringLaw::collagen) {
      return broken(fmt::format("spring {} has the unknown law {}", i, static_cast<int>(s.law)),
                    "The laws are linear, exponential, logarithmic, square and collagen");
    }
  }
  return {};
}

Result<void> check_volumes(const SpringNetwork& network) {
  const int points = static_cast<int>(network.rest.size());
  for (std::size_t i = 0; i < network.volumes.size(); ++i) {
    const VolumeElement& v = network.volumes[i];
    for (int corner = 0; corner < 4; ++corner) {
      if (v.p[corner] < 0 || v.p[corner] >= points) {
        return broken(fmt::format("volume {} has the corner {} of {} points", i, v.p[corner], points),
                      "Point numbers start at 0");
      }
      for (int other = 0; other < corner; ++other) {
        if (v.p[corner] == v.p[other]) {
          return broken(fmt::format("volume {} has the corner {} twice", i, v.p[corner]), "Remove it");
        }
      }
    }
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
  TURGOR_CHECK(check_volumes(network));
  return check_contacts(network);
}

}  // namespace turgor
