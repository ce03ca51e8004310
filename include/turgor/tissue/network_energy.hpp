// The energy of a spring network as a function of the positions of its points: value, forces, stiffness.
//
// Elements are evaluated in parallel into arrays of their own, then every point gathers its elements in a
// fixed order: no two threads write the same place, and the sums have the same bits on any number of threads.
//
//     springs (grouped by law)   volumes                  points
//     [ T n | T n | T n | … ]    [ f1 f2 f3 | … ]   ─►    f[i] = Σ ± T n + Σ fc     (incidence lists)
#pragma once

#include <span>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// K = axial n nᵀ + transverse (1 − n nᵀ) between the two ends, N/mm.
struct SpringStiffness {
  Vec3 direction;  ///< n, unit; zero where the ends coincide
  double axial, transverse;
};

/// K of corners a, b = bulk g_a g_bᵀ + stress ∂²V/∂x_a∂x_b.
struct VolumeStiffness {
  Vec3 gradient[4];  ///< g, ∂V/∂x per corner, mm²
  Vec3 edge[3];      ///< from corner 0 to corners 1, 2, 3, mm
  double bulk;       ///< d²E/dV², MPa/mm³
  double stress;     ///< dE/dV, MPa
};

/// One linearisation: the blocks of all elements, in the order of the NetworkEnergy that made it.
/// `projection` 0 is the Hessian as it is; 1 makes it positive semi-definite element by element, so that a
/// Newton step descends: springs lose the negative transverse stiffness of compression; volumes keep their
/// stiffness along the gradient of V, and their term p ∂²V is replaced, pair of corners by pair, by the
/// nearest semi-definite one. Between, it is the mean of both.
struct ElementStiffness {
  double projection = 0;
  std::vector<SpringStiffness> springs;
  std::vector<VolumeStiffness> volumes;
  std::vector<double> contacts;  ///< along the normal, N/mm
};

/// The block of corners a and b of one volume, N/mm.
Mat3 volume_block(const VolumeStiffness& volume, int a, int b, double projection);

/// Prepared once for a network; every member is const and may be called from several threads with workspaces
/// of their own. Spans are of length point_count(), mm and N.
class NetworkEnergy {
 public:
  /// Forces of single elements, kept by the caller so that repeated calls allocate nothing.
  struct Workspace {
    std::vector<Vec3> spring_force, volume_force;
  };

  /// Errors: those of validate().
  static Result<NetworkEnergy> prepare(const SpringNetwork& network);

  [[nodiscard]] int point_count() const { return static_cast<int>(spring_incidence_.offsets.size()) - 1; }
  /// N·mm.
  [[nodiscard]] double value(std::span<const Vec3> positions) const;
  /// Fills `forces` with the exact negative gradient; returns the energy.
  double forces(std::span<const Vec3> positions, std::span<Vec3> forces, Workspace& workspace) const;
  /// Per-element blocks of the Hessian at `positions`; `projection` from 0 to 1.
  void linearise(std::span<const Vec3> positions, double projection, ElementStiffness& stiffness) const;
  /// `out` = K v: the Hessian times a displacement, element by element.
  void multiply(const ElementStiffness& stiffness, std::span<const Vec3> v, std::span<Vec3> out,
                Workspace& workspace) const;

  /// Springs whose ends coincide at `positions`: they have no direction and exert no force.
  [[nodiscard]] int coincident_springs(std::span<const Vec3> positions) const;
  /// Volumes that are flat or inverted at `positions`.
  [[nodiscard]] int inverted_volumes(std::span<const Vec3> positions) const;

  /// An element at a point: number · corners + corner. Springs have two corners, volumes four.
  struct Incidence {
    std::vector<int> offsets, entries;
  };
  struct SpringEnds {
    int a, b;
  };
  struct Corners {
    int p[4];
  };
  [[nodiscard]] const Incidence& spring_incidence() const { return spring_incidence_; }
  [[nodiscard]] const Incidence& volume_incidence() const { return volume_incidence_; }
  [[nodiscard]] const std::vector<SpringEnds>& spring_ends() const { return ends_; }
  [[nodiscard]] const std::vector<Corners>& volume_corners() const { return corners_; }
  [[nodiscard]] const std::vector<Contact>& contacts() const { return contacts_; }
  /// Number of the contact of a point, -1 where it has none.
  [[nodiscard]] int contact_at(int point) const {
    return contact_of_point_.empty() ? -1 : contact_of_point_[static_cast<std::size_t>(point)];
  }

 private:
  // A piece of the element arrays small enough to balance, large enough to schedule.
  struct Range {
    bool volumes;
    SpringLaw law;
    int begin, end;
  };

  NetworkEnergy() = default;
  void split(const SpringNetwork& network);
  [[nodiscard]] double spring_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const;
  [[nodiscard]] double volume_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const;
  void prepare_contacts(const SpringNetwork& network);
  [[nodiscard]] double add_contacts(std::span<const Vec3> positions, std::span<Vec3> forces) const;
  void gather(const Workspace& workspace, std::span<Vec3> forces) const;

  std::vector<SpringEnds> ends_;  // sorted by law, otherwise as in the network
  std::vector<double> rest_length_, stiffness_;
  std::vector<Corners> corners_;
  std::vector<VolumeElement> materials_;
  std::vector<Contact> contacts_;
  std::vector<int> contact_of_point_;  // empty where there are none
  std::vector<Range> ranges_;
  Incidence spring_incidence_, volume_incidence_;
};

}  // namespace turgor
