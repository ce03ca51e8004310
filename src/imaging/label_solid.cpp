#include "turgor/imaging/label_solid.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kValues = 1 << 16;
constexpr std::size_t kNamed = 20;  ///< labels in an error at most
constexpr double kHair = 1e-6;      ///< of a voxel

std::size_t slot(int value) {
  return at(value + 32768);
}

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "", std::move(remedy)};
}

/// Which values belong to the part.
class Wanted {
 public:
  explicit Wanted(const LabelOptions& options) : by_label_(!options.labels.empty()) {
    if (by_label_) {
      for (const int label : options.labels) {
        if (label >= -32768 && label <= 32767) wanted_[slot(label)] = true;
      }
    } else {
      low_ = options.above.value_or(-32768), high_ = options.below.value_or(32767);
      for (int v = std::max(low_, -32768); v <= std::min(high_, 32767); ++v) wanted_[slot(v)] = true;
    }
  }
  [[nodiscard]] bool by_label() const { return by_label_; }
  [[nodiscard]] bool voxel(std::int16_t value) const { return wanted_[slot(value)]; }
  [[nodiscard]] bool between(double value) const { return value >= low_ && value <= high_; }

 private:
  std::vector<bool> wanted_ = std::vector<bool>(kValues);
  bool by_label_;
  int low_ = 0, high_ = 0;
};

std::vector<bool> values_of(const CtVolume& scan) {
  std::vector<bool> present(kValues);
  for (const std::int16_t v : scan.voxels) present[slot(v)] = true;
  return present;
}

Error absent(const CtVolume& scan, int label) {
  const std::vector<bool> present = values_of(scan);
  std::vector<int> labels;
  for (int v = -32768; v <= 32767; ++v) {
    if (present[slot(v)] && v != 0) labels.push_back(v);
  }
  const bool more = labels.size() > kNamed;
  const std::size_t count = labels.size();
  labels.resize(std::min(count, kNamed));
  return bad(fmt::format("no voxel has the label {}", label),
             labels.empty() ? "The scan has no labels but 0: give another file"
             : more
                 ? fmt::format("Give one of the {} labels there are: {}, ...", count, fmt::join(labels, ", "))
                 : fmt::format("Give labels that there are: {}", fmt::join(labels, ", ")));
}

Result<void> check_options(const CtVolume& scan, const LabelOptions& o) {
  const bool threshold = o.above || o.below;
  if (o.labels.empty() != threshold)
    return bad("either labels or a threshold select a part of a scan", "Give one of the two");
  if (threshold && o.above.value_or(-32768) > o.below.value_or(32767))
    return bad(fmt::format("no value lies above {} and below {} HU", *o.above, *o.below), "Exchange the two");
  const int most = VoxelOptions::max_resolution;
  if (o.resolution < 0 || o.resolution > most)
    return bad(fmt::format("the resolution {} cannot be used", o.resolution),
               fmt::format("Give 1 to {} voxels along the longest axis", most));
  if (!(o.spacing_mm >= 0) || !std::isfinite(o.spacing_mm))
    return bad(fmt::format("the spacing {:g} mm cannot be used", o.spacing_mm), "Give a length above 0");
  if (o.resolution > 0 && o.spacing_mm > 0)
    return bad("resolution and spacing both give the size of a voxel", "Give one of the two");
  if (o.labels.empty()) return {};
  const std::vector<bool> present = values_of(scan);
  for (const int label : o.labels) {
    if (label < -32768 || label > 32767 || !present[slot(label)]) return absent(scan, label);
  }
  return {};
}

Error nothing_within(const CtVolume& scan) {
  const auto [low, high] = std::minmax_element(scan.voxels.begin(), scan.voxels.end());
  return bad("no voxel lies within the threshold",
             fmt::format("The values of the scan are {} to {} HU: give a threshold among them", *low, *high));
}

/// Of the voxels that belong to the part, each a box, along the patient's axes. A row needs its first and
/// last only.
Box3 box_of(const CtVolume& scan, const Wanted& wanted) {
  const Grid& grid = scan.grid;
  const auto rows = at(grid.size[1]) * at(grid.size[2]);
  Box3 box = parallel_reduce<Box3>(
      rows, 256, {},
      [&](std::size_t begin, std::size_t end) {
        Box3 part;
        for (std::size_t r = begin; r < end; ++r) {
          const std::int16_t* row = scan.voxels.data() + r * at(grid.size[0]);
          const auto belongs = [&](std::int16_t v) { return wanted.voxel(v); };
          const auto* const first = std::find_if(row, row + grid.size[0], belongs);
          if (first == row + grid.size[0]) continue;
          const std::int16_t* last = row + grid.size[0] - 1;
          while (!belongs(*last)) --last;
          const std::size_t j = r % at(grid.size[1]), k = r / at(grid.size[1]);
          const auto place = [&](const std::int16_t* voxel) {
            return grid.to_patient(
                {static_cast<double>(voxel - row), static_cast<double>(j), static_cast<double>(k)});
          };
          part.extend(place(first)), part.extend(place(last));
        }
        return part;
      },
      [](Box3 a, const Box3& b) {
        if (!b.empty()) a.extend(b.lower), a.extend(b.upper);
        return a;
      });
  if (box.empty()) return box;
  for (int a = 0; a < 3; ++a) {
    double half = 0;
    for (std::size_t c = 0; c < 3; ++c)
      half += 0.5 * std::abs(grid.direction.c[c][a]) * grid.spacing[static_cast<int>(c)];
    box.lower[a] -= half, box.upper[a] += half;
  }
  return box;
}

/// Empty cubes about the box, and `more_mm` further; their lattice is that of the box.
Result<VoxelGrid> empty_grid(const Box3& box, double more_mm, const LabelOptions& options, const Vec3& own) {
  const Vec3 extent = box.size();
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double spacing = options.resolution > 0   ? longest / options.resolution
                         : options.spacing_mm > 0 ? options.spacing_mm
                                                  : std::min({own.x, own.y, own.z});
  const double most = VoxelOptions::max_resolution;
  if (longest / spacing > most + 0.5)
    return bad(fmt::format("voxels of {:.3g} mm would be {:.0f} along {:.4g} mm", spacing, longest / spacing,
                           longest),
               fmt::format("Give a spacing of {:.3g} mm or more, or a resolution up to {:.0f}",
                           longest / most, most));
  const int more = 1 + static_cast<int>(std::ceil(more_mm / spacing));
  Index3 size{};
  Vec3 lower;
  for (int a = 0; a < 3; ++a) {
    const int count = std::max(1, static_cast<int>(std::ceil(extent[a] / spacing - kHair))) + 2 * more;
    size[at(a)] = count;
    lower[a] = box.lower[a] + 0.5 * (extent[a] - count * spacing);
  }
  VoxelGrid grid(size);
  grid.lower = lower, grid.spacing = spacing;
  return grid;
}

/// Whether the scan's value at a continuous index belongs to the part. Voxels reach half a voxel beyond their
/// centres, and so does the scan.
bool belongs(const CtVolume& scan, const Wanted& wanted, const Vec3& index) {
  Index3 nearest{};
  for (int a = 0; a < 3; ++a) {
    const double c = std::floor(index[a] + 0.5 + kHair);
    if (!(c >= 0 && c < scan.grid.size[at(a)])) return false;
    nearest[at(a)] = static_cast<int>(c);
  }
  if (wanted.by_label()) return wanted.voxel(scan.at(nearest[0], nearest[1], nearest[2]));
  return wanted.between(scan.sample_index(index));
}

/// Sets the cubes, all but the outermost.
void fill(const CtVolume& scan, const Wanted& wanted, VoxelGrid& grid) {
  const auto rows = at(grid.size[1] - 2) * at(grid.size[2] - 2);
  parallel_for(rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      const int j = 1 + static_cast<int>(r % at(grid.size[1] - 2));
      const int k = 1 + static_cast<int>(r / at(grid.size[1] - 2));
      for (int i = 1; i + 1 < grid.size[0]; ++i) {
        const Vec3 centre = grid.lower + Vec3{i + 0.5, j + 0.5, k + 0.5} * grid.spacing;
        if (belongs(scan, wanted, scan.grid.to_index(centre))) grid.set(i, j, k);
      }
    }
  });
}

}  // namespace

Result<VoxelGrid> label_voxels(const CtVolume& scan, const LabelOptions& options) {
  TURGOR_CHECK(check_options(scan, options));
  const Wanted wanted(options);
  const Box3 box = box_of(scan, wanted);
  if (box.empty()) return nothing_within(scan);
  const Vec3 own = scan.grid.spacing;
  // Interpolated values cross the threshold up to the next voxel's centre.
  const double more = wanted.by_label() ? 0 : 0.5 * (own.x + own.y + own.z);
  TURGOR_TRY(VoxelGrid grid, empty_grid(box, more, options, own));
  fill(scan, wanted, grid);
  if (grid.count() > 0) return grid;
  return bad("the centre of no voxel lies in the part", "Give a higher resolution or a smaller spacing");
}

}  // namespace turgor
