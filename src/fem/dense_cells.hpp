// Cells of a lattice that have matrices of their own, where coarse ones are cut by the boundary. Internal.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fem/cube_element.hpp"
#include "fem/voxel_rows.hpp"
#include "turgor/geometry/bulk_array.hpp"

namespace turgor::detail {

struct DenseCell {
  int i = 0, j = 0, k = 0;
  int matrix = 0;
  std::array<NodePlace, 8> corners;  ///< by bits x 1, y 2, z 4
};

/// By layers: cells layers[k] to layers[k + 1] − 1 are in layer k.
struct DenseCells {
  std::vector<DenseCell> cells;
  std::vector<int> layers;
  /// kCubeUnknowns² each. In double precision, unlike all else below the finest level: rigid motions must be
  /// free of energy to far below the softest bending of a slender body.
  BulkArray<double> matrices;

  [[nodiscard]] const double* matrix(int number) const {
    return matrices.data() + static_cast<std::size_t>(number) * kCubeUnknowns * kCubeUnknowns;
  }
};

/// The same cells as they are multiplied: eight side by side, the upper halves of their matrices in single
/// precision, a quarter of the bytes. Where nothing is held rigid motions have rows of their own there, of
/// zeros: no rounding gives them energy. Where something is held each corner keeps its row, as little may be
/// left of some.
class DenseBlocks {
 public:
  /// `cells` is referred to, but for the matrices.
  explicit DenseBlocks(const DenseCells& cells);
  /// Adds the forces of a layer's cells.
  void add(int layer, const float* in, float* out) const;

 private:
  static constexpr std::size_t kWide = 8;
  struct Block {
    std::size_t count = 0;
    std::array<int, kWide> cells{};
    bool moves = false;  // rows of modes
  };
  const DenseCells* cells_;
  std::vector<std::size_t> first_;  // block of each layer
  std::vector<Block> blocks_;
  BulkArray<float> matrices_;
};

}  // namespace turgor::detail
