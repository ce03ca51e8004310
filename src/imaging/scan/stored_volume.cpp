#include "imaging/scan/stored_volume.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "turgor/core/parallel.hpp"

namespace turgor::scan_io {
namespace {

/// Below this many voxels of displacement over the whole stack, axes count as orthogonal: files store
/// directions with six or seven digits.
constexpr double kShearTolerance = 0.1;

struct Frame {
  Mat3 direction;  // of either handedness
  Vec3 spacing;
};

Result<void> check_axes(const StoredVolume& stored, const std::filesystem::path& path) {
  if (!is_finite(stored.origin)) {
    return bad_file(path, "its origin is not a number", "Export the scan again");
  }
  for (int a = 0; a < 3; ++a) {
    const double step = length(stored.axes[a]);
    if (!std::isfinite(step) || step < 1e-4 || step > 1e3) {
      return bad_file(path, fmt::format("its voxel spacing along axis {} is {:g} mm", a + 1, step),
                      "Export the scan again with spacings in millimetres");
    }
  }
  const Mat3 unit{{normalized(stored.axes[0]), normalized(stored.axes[1]), normalized(stored.axes[2])}};
  if (std::abs(unit.determinant()) < 0.2) {
    return bad_file(path, "its axes are nearly parallel, so the voxels have no place in space",
                    "Export the scan again with its orientation");
  }
  for (const int n : stored.size) {
    if (n < 2) {
      return bad_file(path,
                      fmt::format("holds {} × {} × {} voxels, which is not a volume", stored.size[0],
                                  stored.size[1], stored.size[2]),
                      "Name a scan with at least two voxels along each axis");
    }
  }
  return {};
}

/// Orthonormal axes nearest to the stored ones, keeping the first and the plane of the first two.
Frame orthogonal_frame(const StoredVolume& stored) {
  const Vec3 u = normalized(stored.axes[0]);
  const Vec3 v = normalized(stored.axes[1] - u * dot(u, stored.axes[1]));
  Vec3 w = cross(u, v);
  if (dot(w, stored.axes[2]) < 0) w = -w;
  return {Mat3{{u, v, w}}, Vec3{length(stored.axes[0]), length(stored.axes[1]), length(stored.axes[2])}};
}

/// How far, in voxels, the stored stack departs from `frame` at its far ends.
double shear_in_voxels(const StoredVolume& stored, const Frame& frame) {
  double worst = 0;
  for (int a = 0; a < 3; ++a) {
    const Vec3 along = frame.direction.c[a] * length(stored.axes[a]);
    const Vec3 apart = (stored.axes[a] - along) * (stored.size[a] - 1.0);
    for (int b = 0; b < 3; ++b) {
      worst = std::max(worst, std::abs(dot(apart, frame.direction.c[b])) / frame.spacing[b]);
    }
  }
  return worst;
}

/// Writes a row that lies parallel to the stored rows: eight of them blended with constant weights.
void resample_row(const StoredVolume& stored, const Vec3& start, int count, std::int16_t* out) {
  const auto last = [&](int a) { return static_cast<double>(stored.size[a] - 1); };
  constexpr double slack = 1e-6;
  for (int a = 1; a < 3; ++a) {
    if (start[a] < -slack || start[a] > last(a) + slack) {
      std::fill(out, out + count, kAirHu);
      return;
    }
  }
  int base[3];
  double weight[3];
  for (int a = 0; a < 3; ++a) {
    const double c = a == 0 ? start[a] : std::clamp(start[a], 0.0, last(a));
    const double floor = std::floor(c + slack);
    base[a] = static_cast<int>(floor);
    weight[a] = c - floor > slack ? c - floor : 0.0;
  }
  const auto row = [&](int j, int k) {
    j = std::min(j, stored.size[1] - 1), k = std::min(k, stored.size[2] - 1);
    return stored.voxels.data() + (static_cast<std::size_t>(k) * static_cast<std::size_t>(stored.size[1]) +
                                   static_cast<std::size_t>(j)) *
                                      static_cast<std::size_t>(stored.size[0]);
  };
  const std::int16_t* rows[4] = {row(base[1], base[2]), row(base[1] + 1, base[2]), row(base[1], base[2] + 1),
                                 row(base[1] + 1, base[2] + 1)};
  const double share[4] = {(1 - weight[1]) * (1 - weight[2]), weight[1] * (1 - weight[2]),
                           (1 - weight[1]) * weight[2], weight[1] * weight[2]};
  const auto at = [&](int i) {
    return share[0] * rows[0][i] + share[1] * rows[1][i] + share[2] * rows[2][i] + share[3] * rows[3][i];
  };
  const int next = weight[0] > 0 ? 1 : 0;
  for (int n = 0; n < count; ++n) {
    const int i = base[0] + n;
    if (i < 0 || i + next >= stored.size[0]) {
      out[n] = kAirHu;
    } else {
      out[n] =
          static_cast<std::int16_t>(std::floor((1 - weight[0]) * at(i) + weight[0] * at(i + next) + 0.5));
    }
  }
}

/// The same for labels, which have no blends.
void nearest_row(const StoredVolume& stored, const Vec3& start, int count, std::int16_t* out) {
  const int j = static_cast<int>(std::lround(start.y)), k = static_cast<int>(std::lround(start.z));
  const bool there = j >= 0 && k >= 0 && j < stored.size[1] && k < stored.size[2];
  const auto first = static_cast<int>(std::lround(start.x));
  for (int n = 0; n < count; ++n) {
    const int i = first + n;
    out[n] = 0;
    if (there && i >= 0 && i < stored.size[0]) {
      const auto row = static_cast<std::size_t>(k) * static_cast<std::size_t>(stored.size[1]) +
                       static_cast<std::size_t>(j);
      out[n] = stored.voxels[row * static_cast<std::size_t>(stored.size[0]) + static_cast<std::size_t>(i)];
    }
  }
}

/// The sheared stack on an orthogonal grid that covers it. Rows stay parallel, so each new row is a blend of
/// stored rows with constant weights.
Result<void> resample_sheared(StoredVolume& stored, bool labels, const std::filesystem::path& path) {
  const Frame frame = orthogonal_frame(stored);
  const Mat3 to_frame = frame.direction.transposed();
  const Mat3 stored_axes{{stored.axes[0], stored.axes[1], stored.axes[2]}};
  // Along each new axis the stored step's own share of it, so that slices are kept where only they slide.
  Vec3 spacing;
  for (int a = 0; a < 3; ++a) spacing[a] = dot(stored.axes[a], frame.direction.c[a]);
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 index{(corner & 1) != 0 ? stored.size[0] - 1.0 : 0,
                     (corner & 2) != 0 ? stored.size[1] - 1.0 : 0,
                     (corner & 4) != 0 ? stored.size[2] - 1.0 : 0};
    box.extend(to_frame * (stored_axes * index));
  }
  std::array<std::int64_t, 3> wanted{};
  for (int a = 0; a < 3; ++a) {
    // Grid lines pass through the stored origin, so unsheared directions keep their samples.
    box.lower[a] = std::floor(box.lower[a] / spacing[a] + 1e-6) * spacing[a];
    wanted[static_cast<std::size_t>(a)] =
        static_cast<std::int64_t>(std::ceil((box.upper[a] - box.lower[a]) / spacing[a] - 1e-6)) + 1;
  }
  TURGOR_TRY(const Index3 size, checked_size(wanted, path));
  if (voxel_count(size) > 8 * voxel_count(stored.size)) {
    return bad_file(path, "its slices slide so far over each other that no sensible grid covers them",
                    "Check the slice positions, or resample the scan to an orthogonal grid");
  }
  const Mat3 to_stored = stored_axes.inverse();
  std::vector<std::int16_t> voxels(voxel_count(size));
  const auto rows = static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  parallel_for(rows, 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const std::size_t k = r / static_cast<std::size_t>(size[1]),
                        j = r - k * static_cast<std::size_t>(size[1]);
      const Vec3 offset{0, static_cast<double>(j) * spacing.y, static_cast<double>(k) * spacing.z};
      const Vec3 p = frame.direction * (box.lower + offset);
      const auto resample = labels ? nearest_row : resample_row;
      resample(stored, to_stored * p, size[0], voxels.data() + r * static_cast<std::size_t>(size[0]));
    }
  });
  stored.origin += frame.direction * box.lower;
  stored.size = size;
  stored.voxels = std::move(voxels);
  for (int a = 0; a < 3; ++a) stored.axes[a] = frame.direction.c[a] * spacing[a];
  return {};
}

/// Which stored axis runs along each patient axis, and whether backwards: the signed permutation of largest
/// trace. It always leaves determinant +1: among the 24 rotations of a cube some has a trace above 1.9 with
/// any rotation, while no improper one exceeds 1.
struct AxisOrder {
  std::array<int, 3> source{0, 1, 2};
  std::array<bool, 3> flipped{};
};
AxisOrder anatomical_order(const Mat3& direction) {
  static constexpr std::array<std::array<int, 3>, 6> orders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};
  AxisOrder best;
  double best_trace = -1;
  for (const auto& order : orders) {
    double trace = 0;
    for (int a = 0; a < 3; ++a) trace += std::abs(direction.c[order[a]][a]);
    if (trace > best_trace + 1e-9) best_trace = trace, best.source = order;
  }
  for (int a = 0; a < 3; ++a) best.flipped[a] = direction.c[best.source[a]][a] < 0;
  return best;
}

std::vector<std::int16_t> reorder(std::vector<std::int16_t> voxels, const Index3& size,
                                  const AxisOrder& order) {
  if (order.source == std::array<int, 3>{0, 1, 2} && order.flipped == std::array<bool, 3>{}) return voxels;
  const std::array<std::ptrdiff_t, 3> stored_step{1, size[0], std::ptrdiff_t{size[0]} * size[1]};
  std::array<std::ptrdiff_t, 3> step{};
  std::ptrdiff_t first = 0;
  std::array<std::size_t, 3> count{};
  for (int a = 0; a < 3; ++a) {
    step[a] = stored_step[order.source[a]];
    count[a] = static_cast<std::size_t>(size[order.source[a]]);
    if (order.flipped[a]) first += step[a] * (size[order.source[a]] - 1), step[a] = -step[a];
  }
  std::vector<std::int16_t> out(voxels.size());
  parallel_for(count[1] * count[2], 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const auto j = static_cast<std::ptrdiff_t>(r % count[1]), k = static_cast<std::ptrdiff_t>(r / count[1]);
      const std::int16_t* from = voxels.data() + first + j * step[1] + k * step[2];
      std::int16_t* to = out.data() + r * count[0];
      if (step[0] == 1) {
        std::memcpy(to, from, count[0] * sizeof *to);
      } else {
        for (std::size_t i = 0; i < count[0]; ++i) to[i] = from[static_cast<std::ptrdiff_t>(i) * step[0]];
      }
    }
  });
  return out;
}

void warn_of_losses(const ValueLosses& losses, const std::filesystem::path& path, Context& context) {
  if (losses.clamped > 0) {
    context.warning(fmt::format("{}: {} voxels lie beyond -32768..32767 HU and were clamped.", path.string(),
                                losses.clamped));
  }
  if (losses.not_finite > 0) {
    context.warning(
        fmt::format("{}: {} voxels are not numbers and count as air.", path.string(), losses.not_finite));
  }
}

}  // namespace

Error bad_file(const std::filesystem::path& path, std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), path.string(), std::move(remedy)};
}

std::size_t voxel_count(const Index3& size) {
  return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
         static_cast<std::size_t>(size[2]);
}

Result<Index3> checked_size(const std::array<std::int64_t, 3>& size, const std::filesystem::path& path) {
  constexpr std::int64_t max_axis = 1 << 20;
  std::uint64_t product = 1;
  bool fits = true;
  for (const std::int64_t n : size) {
    if (n < 1) {
      return bad_file(path, fmt::format("its size {} × {} × {} is not positive", size[0], size[1], size[2]),
                      "Export the scan again");
    }
    fits = fits && n <= max_axis;
    if (fits) product *= static_cast<std::uint64_t>(n);
    fits = fits && product <= kMaxVoxels;
  }
  if (!fits) {
    return bad_file(
        path,
        fmt::format("its size {} × {} × {} is beyond the 4 Gi voxels accepted", size[0], size[1], size[2]),
        "Crop or resample the scan, or export it again if its header is damaged");
  }
  return Index3{static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(size[2])};
}

Result<Scan> to_canonical(StoredVolume stored, const std::filesystem::path& path, Context& context,
                          bool labels) {
  TURGOR_CHECK(check_axes(stored, path));
  stored.info.stored_left_handed = dot(stored.axes[0], cross(stored.axes[1], stored.axes[2])) < 0;
  if (labels && stored.losses.clamped + stored.losses.not_finite > 0) {
    return bad_file(path, "holds labels beyond -32768 to 32767", "Renumber the labels from 1");
  }
  warn_of_losses(stored.losses, path, context);
  if (shear_in_voxels(stored, orthogonal_frame(stored)) > kShearTolerance) {
    TURGOR_CHECK(resample_sheared(stored, labels, path));
  }
  TURGOR_CHECK(context.check());
  const Frame frame = orthogonal_frame(stored);
  const AxisOrder order = anatomical_order(frame.direction);
  Scan scan;
  scan.info = std::move(stored.info);
  Grid& grid = scan.hu.grid;
  grid.origin = stored.origin;
  for (int a = 0; a < 3; ++a) {
    const int s = order.source[a];
    const Vec3 axis = frame.direction.c[s];
    grid.size[a] = stored.size[s];
    grid.spacing[a] = frame.spacing[s];
    grid.direction.c[a] = order.flipped[a] ? -axis : axis;
    if (order.flipped[a]) grid.origin += axis * (frame.spacing[s] * (stored.size[s] - 1));
  }
  scan.hu.voxels = reorder(std::move(stored.voxels), stored.size, order);
  return scan;
}

}  // namespace turgor::scan_io
