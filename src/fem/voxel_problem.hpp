// An elastic body on a lattice as its solution needs it: numbered, checked, with what holds it. Internal.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "fem/voxel_laws.hpp"
#include "fem/voxel_multigrid.hpp"
#include "fem/voxel_numbering.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/voxel_elasticity.hpp"

namespace turgor::detail {

/// A contact in terms of displacements: the node's distance from the plane is n·u − offset.
struct LatticeContact {
  NodePlace node;
  int point = 0;
  std::size_t cell = 0;  ///< one that has the node
  Vec3 normal;
  double offset_mm = 0, stiffness_n_mm = 0, adhesion_n_mm = 0;

  [[nodiscard]] double along(const std::vector<double>& values) const {
    return normal.x * values[node.component(0)] + normal.y * values[node.component(1)] +
           normal.z * values[node.component(2)];
  }
  void add(double amount, std::vector<double>& values) const {
    for (std::size_t c = 0; c < 3; ++c) values[node.component(c)] += amount * normal[static_cast<int>(c)];
  }
  [[nodiscard]] double distance(const std::vector<double>& u) const { return along(u) - offset_mm; }
  /// Touching presses.
  [[nodiscard]] double slope(double distance) const { return distance > 0 ? adhesion_n_mm : stiffness_n_mm; }
};

/// Four sums side by side, so that additions do not wait for one another.
inline double inner(const double* a, const double* b, std::size_t begin, std::size_t end) {
  double s[4] = {};
  std::size_t i = begin;
  for (; i + 4 <= end; i += 4)
    for (std::size_t l = 0; l < 4; ++l) s[l] += a[i + l] * b[i + l];
  for (; i < end; ++i) s[0] += a[i] * b[i];
  return (s[0] + s[1]) + (s[2] + s[3]);
}

struct VoxelProblem {
  VoxelProblem(VoxelNumbering n, ElasticBody b, const VoxelElasticityOptions& o)
      : numbering(std::move(n)), body(std::move(b)), options(o) {}

  VoxelNumbering numbering;
  ElasticBody body;
  VoxelElasticityOptions options;
  double spacing = 1;
  std::vector<Vec3> points;
  ElasticSupports supports;
  std::vector<double> shear, bulk;       // of each cell, MPa
  std::vector<std::uint8_t> held;        // of each value; also what belongs to no node
  std::vector<double> prescribed;        // of each value, 0 where it is not held
  std::vector<LatticeContact> contacts;  // by rising value of their nodes
  std::vector<int> cubes_of;             // cubes about node n: first_cube[n] to first_cube[n + 1] − 1
  std::vector<std::size_t> first_cube;
  std::unique_ptr<VoxelOperator<double>> stiffness;
  std::unique_ptr<VoxelLaws> laws;            // where any law is not linear
  std::unique_ptr<VoxelMultigrid> multigrid;  // where there are no contacts

  void set_moduli();
  void set_held();
  void set_prescribed();
  void set_contacts();
  void set_cubes_of();
  /// MPa · mm: what forces of the multigrid cycle are relative to.
  [[nodiscard]] double unit() const;
  /// The planes of contacts as the preconditioner sees them, of these slopes.
  /// `warp` of each node, or empty: the planes of a body that is deformed by it, seen at rest.
  [[nodiscard]] std::vector<NodePlane> planes_of(const std::vector<double>& slopes,
                                                 const std::vector<Mat3>& warp = {}) const;
  [[nodiscard]] Result<VoxelMultigrid> cycle_with(std::vector<NodePlane> planes,
                                                  const Context& context) const;
  Result<void> set_cycle(const Context& context);
  [[nodiscard]] Result<std::vector<double>> forces_of(const ElasticLoad& load) const;
  /// The contacts of a range of values.
  [[nodiscard]] std::span<const LatticeContact> contacts_in(std::size_t begin, std::size_t end) const;

  /// Ranges of values that do not depend on the number of threads.
  template <class Loop>
  void for_planes(Loop&& loop) const {
    const auto& planes = numbering.rows.planes;
    parallel_for(planes.size() - 1, static_cast<std::size_t>(numbering.rows.slab),
                 [&](std::size_t begin, std::size_t end) { loop(planes[begin], planes[end]); });
  }
  template <class Term>
  [[nodiscard]] double sum(Term&& term) const {
    const auto& planes = numbering.rows.planes;
    return parallel_reduce<double>(
        planes.size() - 1, static_cast<std::size_t>(numbering.rows.slab), 0.0,
        [&](std::size_t begin, std::size_t end) { return term(planes[begin], planes[end]); }, std::plus<>());
  }
  template <class Term>
  [[nodiscard]] double greatest(Term&& term) const {
    const auto& planes = numbering.rows.planes;
    return parallel_reduce<double>(
        planes.size() - 1, static_cast<std::size_t>(numbering.rows.slab), 0.0,
        [&](std::size_t begin, std::size_t end) { return term(planes[begin], planes[end]); },
        [](double a, double b) { return std::max(a, b); });
  }
};

/// Mean deformation gradient of the cubes about each node; 1 where a part of its components is held.
std::vector<Mat3> nodal_deformations(const VoxelProblem& problem, const std::vector<double>& u);

}  // namespace turgor::detail
