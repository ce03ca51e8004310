// What acts on single points beside their network: energies, forces and stiffness of loads and of inertia.
// Internal to the module.
#pragma once

#include <span>
#include <vector>

#include "dynamics/block_cg.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/tissue/network_energy.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace turgor {

/// Implicit Euler's own terms: m |x − y|²/(2 dt²) + c |x − x⁰|²/(2 dt), y = x⁰ + v⁰ dt.
struct Inertia {
  std::vector<Vec3> from, ahead;  ///< x⁰ and y
  double dt_ms = 1;
  double damping_g_ms = 0;  ///< c
};

/// Loads act on free points that some element holds; with inertia on every free point. What prescribed points
/// carry is not counted.
class PointTerms {
 public:
  /// `unknowns`: the free points, in the order of the rows.
  PointTerms(const SpringNetwork& network, const NetworkEnergy& energy, std::span<const int> unknowns);

  void set_loads(Loads loads);
  /// None: at rest.
  void set_inertia(const Inertia* inertia);

  /// Adds the forces; returns the energy, work against constant forces counted from rest.
  double add_forces(std::span<const Vec3> positions, std::span<Vec3> forces) const;
  /// Adds positive semi-definite blocks to the diagonal, of barriers along their force only.
  void add_stiffness(std::span<const Vec3> positions, StiffnessMatrix& matrix) const;
  /// Of grabs, exactly; semi-definite too.
  [[nodiscard]] std::vector<CoupledStiffness> coupled(std::span<const Vec3> positions) const;
  /// Norm of the constant loads and of the forces that would stop all motion within the step, N.
  [[nodiscard]] double scale() const { return scale_; }

 private:
  [[nodiscard]] Vec3 constant_force(std::size_t point) const;
  double point_terms(int point, const Vec3& x, Vec3& force) const;
  [[nodiscard]] bool acts(int point) const { return acts_[static_cast<std::size_t>(point)] != 0; }
  void update();

  std::vector<Vec3> rest_;
  std::vector<double> mass_g_;
  std::vector<int> row_of_point_;     // −1: prescribed
  std::vector<char> is_held_, acts_;  // by some element; now
  Loads loads_;
  const Inertia* inertia_ = nullptr;
  double scale_ = 0;
  BarriersOfPoints barriers_of_;
};

}  // namespace turgor
