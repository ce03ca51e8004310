// The energy of a spring network as a function of the positions of its points: value, forces, stiffness.
//
// Elements are evaluated in parallel into arrays of their own, then every point gathers its elements in a
// fixed order: no two threads write the same place, and the sums have the same bits on any number of threads.
//
//     springs (grouped by law)   areas, volumes           points
//     [ T n | T n | T n | … ]    [ f1 f2 f3 | … ]   ─►    f[i] = Σ ± T n + Σ fc     (incidence lists)
//
// Solids are lowered to the same elements: their edges to Hookean springs of stiffness k_d/D0, their
// triangles to areas, their tetrahedra to volumes of modulus k_v/V0. What has the constant 0 is left out.
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

/// K of corners a, b = stretch g_a g_bᵀ + stress ∂²A/∂x_a∂x_b, with the gradient g_a = ½ n × edge_a and
/// ∂²A/∂x_a∂x_b = (edge_a · edge_b)/(4 A) n nᵀ ∓ ½ [n]×, minus where b follows a.
struct AreaStiffness {
  Vec3 normal;     ///< n, unit; zero where the triangle is flat
  Vec3 edge[3];    ///< opposite to each corner, anticlockwise, mm
  double stretch;  ///< d²E/dA², N/mm³
  double stress;   ///< dE/dA, N/mm
  double bend;     ///< stress/(4 A), N/mm³
};

/// One linearisation: the blocks of all elements, in the order of the NetworkEnergy that made it.
/// `projection` 0 is the Hessian as it is; 1 makes it positive semi-definite element by element, so that a
/// Newton step descends: springs lose the negative transverse stiffness of compression; volumes keep their
/// stiffness along the gradient of V, and their term p ∂²V is replaced, pair of corners by pair, by the
/// nearest semi-definite one; areas likewise theirs along and across the plane. Between, it is the mean of
/// both.
struct ElementStiffness {
  double projection = 0;
  std::vector<SpringStiffness> springs;
  std::vector<AreaStiffness> areas;
  std::vector<VolumeStiffness> volumes;
  std::vector<double> contacts;  ///< along the normal, N/mm
};

/// The block of corners a and b of one volume, N/mm.
Mat3 volume_block(const VolumeStiffness& volume, int a, int b, double projection);
/// The block of corners a and b of one area, N/mm.
Mat3 area_block(const AreaStiffness& area, int a, int b, double projection);

/// Prepared once for a network; every member is const and may be called from several threads with workspaces
/// of their own. Spans are of length point_count(), mm and N.
class NetworkEnergy {
 public:
  /// Forces of single elements, kept by the caller so that repeated calls allocate nothing.
  struct Workspace {
    std::vector<Vec3> spring_force, area_force, volume_force;
  };

  /// Errors: those of validate().
  static Result<NetworkEnergy> prepare(const SpringNetwork& network);

  /// A new rest length above 0 for a spring of the network.
  void set_rest_length(int spring, double rest_length_mm);
  /// Norm of the forces that a strain of 1 would make in every element, N.
  [[nodiscard]] double unit_force() const;

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

  /// An element at a point: number · corners + corner. Springs have two corners, areas three, volumes four.
  struct Incidence {
    std::vector<int> offsets, entries;
  };
  struct SpringEnds {
    int a, b;
  };
  struct Corners {
    int p[4];
  };
  struct Triangle {
    int p[3];
  };
  [[nodiscard]] const Incidence& spring_incidence() const { return spring_incidence_; }
  [[nodiscard]] const Incidence& area_incidence() const { return area_incidence_; }
  [[nodiscard]] const Incidence& volume_incidence() const { return volume_incidence_; }
  [[nodiscard]] const std::vector<SpringEnds>& spring_ends() const { return ends_; }
  [[nodiscard]] const std::vector<Triangle>& area_corners() const { return triangles_; }
  [[nodiscard]] const std::vector<Corners>& volume_corners() const { return corners_; }
  [[nodiscard]] const std::vector<Contact>& contacts() const { return contacts_; }
  /// Number of the contact of a point, -1 where it has none.
  [[nodiscard]] int contact_at(int point) const {
    return contact_of_point_.empty() ? -1 : contact_of_point_[static_cast<std::size_t>(point)];
  }

 private:
  // A piece of the element arrays small enough to balance, large enough to schedule.
  enum class Kind : std::uint8_t { springs, areas, volumes };
  struct Range {
    Kind kind;
    SpringLaw law;
    int begin, end;
  };

  NetworkEnergy() = default;
  void add_springs(const SpringNetwork& network);
  void add_spring(int a, int b, double rest_length_mm, double stiffness_n);
  void add_areas(const SpringNetwork& network);
  void add_volumes(const SpringNetwork& network);
  void add_volume(const VolumeElement& element);
  void add_ranges(Kind kind, SpringLaw law, int first, int last);
  void prepare_incidence(int points);
  void fit(Workspace& workspace) const;
  double element_forces(std::span<const Vec3> positions, Workspace* workspace) const;
  [[nodiscard]] double spring_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const;
  [[nodiscard]] double area_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const;
  [[nodiscard]] double volume_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const;
  void linearise_springs(const Range& range, std::span<const Vec3> positions,
                         ElementStiffness& stiffness) const;
  void linearise_areas(const Range& range, std::span<const Vec3> positions,
                       ElementStiffness& stiffness) const;
  void linearise_volumes(const Range& range, std::span<const Vec3> positions,
                         ElementStiffness& stiffness) const;
  void multiply_springs(const Range& range, const ElementStiffness& stiffness, std::span<const Vec3> v,
                        Vec3* out) const;
  void prepare_contacts(const SpringNetwork& network);
  [[nodiscard]] double add_contacts(std::span<const Vec3> positions, std::span<Vec3> forces) const;
  void gather(const Workspace& workspace, std::span<Vec3> forces) const;

  std::vector<SpringEnds> ends_;  // sorted by law, otherwise as in the network; then those of solids
  std::vector<double> rest_length_, stiffness_;
  std::vector<int> place_of_spring_;  // of the network's springs among those
  std::vector<Triangle> triangles_;
  std::vector<AreaElement> area_materials_;
  std::vector<Corners> corners_;
  std::vector<VolumeElement> materials_;
  std::vector<Contact> contacts_;
  std::vector<int> contact_of_point_;  // empty where there are none
  std::vector<Range> ranges_;
  Incidence spring_incidence_, area_incidence_, volume_incidence_;
};

}  // namespace turgor
