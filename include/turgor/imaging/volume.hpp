// Voxel arrays with their place in the patient.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "turgor/math/vec.hpp"

namespace turgor {

/// Where voxel centres lie: patient point of index (i, j, k) = origin + direction * (i sx, j sy, k sz), in
/// LPS mm. Invariant: size ≥ 1, spacing > 0, direction orthonormal with determinant +1 (never a mirrored
/// patient).
struct Grid {
  Index3 size{1, 1, 1};   ///< voxels along i, j, k; i runs fastest in memory
  Vec3 spacing{1, 1, 1};  ///< mm
  Vec3 origin{0, 0, 0};   ///< centre of voxel (0, 0, 0), mm
  Mat3 direction{};       ///< columns: unit vectors along i, j, k

  [[nodiscard]] std::size_t voxel_count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
           static_cast<std::size_t>(size[2]);
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool contains(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
  }
  /// Continuous index to patient point and back.
  [[nodiscard]] Vec3 to_patient(const Vec3& index) const {
    return origin + direction * Vec3{index.x * spacing.x, index.y * spacing.y, index.z * spacing.z};
  }
  [[nodiscard]] Vec3 to_index(const Vec3& point) const {
    const Vec3 v = direction.transposed() * (point - origin);
    return {v.x / spacing.x, v.y / spacing.y, v.z / spacing.z};
  }
  bool operator==(const Grid& other) const {
    return size == other.size && spacing == other.spacing && origin == other.origin &&
           direction.c == other.direction.c;
  }
};

template <class T>
struct Volume {
  Grid grid;
  std::vector<T> voxels;  ///< grid.voxel_count() values

  Volume() = default;
  explicit Volume(const Grid& g, T value = T{}) : grid(g), voxels(g.voxel_count(), value) {}

  [[nodiscard]] T& at(int i, int j, int k) { return voxels[grid.offset(i, j, k)]; }
  [[nodiscard]] const T& at(int i, int j, int k) const { return voxels[grid.offset(i, j, k)]; }

  /// Trilinear value at a continuous index, clamped to the outermost voxel centres.
  [[nodiscard]] double sample_index(const Vec3& index) const {
    int base[3];
    double f[3];
    for (int a = 0; a < 3; ++a) {
      const double last = grid.size[static_cast<std::size_t>(a)] - 1;
      const double c = index[a] < 0 ? 0 : index[a] > last ? last : index[a];
      base[a] = static_cast<int>(c);
      if (base[a] > last - 1 && base[a] > 0) --base[a];
      f[a] = c - base[a];
    }
    const std::size_t dx = grid.size[0] > 1 ? 1 : 0;
    const std::size_t dy = grid.size[1] > 1 ? static_cast<std::size_t>(grid.size[0]) : 0;
    const std::size_t dz =
        grid.size[2] > 1 ? static_cast<std::size_t>(grid.size[0]) * static_cast<std::size_t>(grid.size[1])
                         : 0;
    const T* p = voxels.data() + grid.offset(base[0], base[1], base[2]);
    const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
    const auto row = [&](const T* q) {
      return mix(static_cast<double>(q[0]), static_cast<double>(q[dx]), f[0]);
    };
    const auto slab = [&](const T* q) { return mix(row(q), row(q + dy), f[1]); };
    return mix(slab(p), slab(p + dz), f[2]);
  }
  /// The same at a patient point (mm, LPS).
  [[nodiscard]] double sample(const Vec3& point) const { return sample_index(grid.to_index(point)); }
};

/// Hounsfield units.
using CtVolume = Volume<std::int16_t>;
/// 0 outside, 1 inside; or one of several labels.
using LabelVolume = Volume<std::uint8_t>;

}  // namespace turgor
