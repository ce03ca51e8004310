// The stiffness of a lattice of cubes times a vector, without a matrix. Internal.
//
// Cells of one material are alike but for two moduli: eight of a row at once are brought to the basis of
// modes, multiplied there (45 of 576 numbers are not zero), and brought back. Layers of cells go to tasks in
// slabs, first those of even number and then the odd ones, so that no two add to one plane and the sums have
// one order.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "fem/dense_cells.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {

/// Called with the values [begin, end) of a plane once their sums are complete; may change the vector that is
/// multiplied there.
using PlaneDone = std::function<void(std::size_t plane, std::size_t begin, std::size_t end)>;

/// Clears `out` and adds to it layer by layer of cells: layer(k) adds to the planes k and k + 1.
template <class T, class Layer>
void in_slabs(const VoxelRows& rows, T* out, const PlaneDone& done, Layer&& layer) {
  const int layers = rows.cells[2], slabs = (layers + rows.slab - 1) / rows.slab;
  const auto begin = [&](int plane) { return rows.planes[static_cast<std::size_t>(plane)]; };
  const auto clear = [&](int plane) { std::fill(out + begin(plane), out + begin(plane + 1), T(0)); };
  const auto finish = [&](int plane) {
    done(static_cast<std::size_t>(plane), begin(plane), begin(plane + 1));
  };
  for (const bool odd : {false, true}) {
    parallel_for(static_cast<std::size_t>((slabs + (odd ? 0 : 1)) / 2), 1, [&](std::size_t s, std::size_t) {
      const int first = (2 * static_cast<int>(s) + (odd ? 1 : 0)) * rows.slab,
                last = std::min(layers, first + rows.slab);
      if (!odd) clear(first);
      for (int k = first; k < last; ++k) {
        const bool shared_above = odd && k + 1 == last && last < layers;
        if (!shared_above) clear(k + 1);
        layer(k);
        if (k > first || odd || first == 0) finish(k);
      }
      if (odd || last == layers) finish(last);
    });
  }
}

template <class T>
class VoxelOperator {
 public:
  /// `shear` and `bulk`: moduli of each cell of the rows, zero where there is none or one with a matrix of
  /// its own. Everything is referred to. `dense` may be null, and is so in double precision.
  VoxelOperator(const VoxelRows& rows, const CubeStiffness& stiffness, const std::vector<T>& shear,
                const std::vector<T>& bulk, const DenseBlocks* dense);
  /// out = K in.
  void apply(const T* in, T* out, const PlaneDone& done) const;

 private:
  void layer(int k, const T* in, T* out) const;

  const VoxelRows* rows_;
  CubeModes<T> shear_, bulk_;
  const std::vector<T>*shear_of_, *bulk_of_;
  const DenseBlocks* dense_;
  std::vector<std::uint8_t> used_;  // of each block of cells: whether any has a modulus
};

}  // namespace turgor::detail
