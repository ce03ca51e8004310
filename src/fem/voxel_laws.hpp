// The energy of large strains of a lattice of cubes, its gradient and its second derivatives. Internal.
//
// Eight cubes of a row at once, or four in double precision. In the basis of modes of fem/cube_element.hpp
// the gradient of mode s along axis i, in s, is a sign pattern of the 2×2×2 Gauss points, that of s without
// i: sums over the points are Walsh transforms, and translations drop out exactly. Stiffness: for each cube
// the packed matrix of its 21 modes other than translations, in single precision.
#pragma once

#include <cstdint>
#include <vector>

#include "fem/voxel_numbering.hpp"
#include "fem/voxel_operator.hpp"
#include "turgor/fem/elasticity.hpp"
#include "turgor/geometry/bulk_array.hpp"

namespace turgor::detail {

class VoxelLaws {
 public:
  /// `rows`: referred to.
  VoxelLaws(const VoxelNumbering& numbering, const ElasticBody& body, double spacing);

  struct Energy {
    double strain = 0;
    std::size_t inverted = 0;  ///< cubes without an energy; above 0 the rest says nothing
  };
  /// out = gradient of the energy at u.
  Energy forces(const double* u, double* out) const;

  /// Packed matrices, kPacked numbers of eight cubes each.
  using Matrices = BulkArray<float>;
  static constexpr std::size_t kModes = 21, kPacked = kModes * (kModes + 1) / 2;
  [[nodiscard]] std::size_t matrices_size() const { return blocks_ * kPacked * kBlockCells; }
  void linearise(const double* u, Matrices& matrices) const;
  /// Makes the cubes convex that bend downwards: their matrices take the absolute values of their eigenvalues
  /// (Chen et al. 2024, "Stabler neo-Hookean simulation"). Returns how many.
  std::size_t convexify(Matrices& matrices) const;
  /// out = stiffness · in.
  void apply(const Matrices& matrices, const double* in, double* out, const PlaneDone& done) const;

 private:
  template <class Block>
  void for_blocks(int k, Block&& block) const;

  const VoxelRows* rows_;
  double spacing_;
  std::vector<double> shear_, bulk_, c20_;  // of each cell; 0: none there
  std::vector<std::uint8_t> law_;           // of each cell: 1 + number of its law, 0: none there
  std::vector<std::uint8_t> laws_in_;       // of each block: bit for each law
  std::vector<int> number_;                 // of each block, −1: no cells in it
  std::size_t blocks_ = 0;
};

}  // namespace turgor::detail
