#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "imaging/bit_volume.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr float kUnreached = std::numeric_limits<float>::infinity();

struct Step {
  int di, dj, dk;
  std::ptrdiff_t offset;
  float length;
};

std::vector<Step> steps_to_neighbours(const Grid& grid) {
  std::vector<Step> steps;
  for (int dk = -1; dk <= 1; ++dk) {
    for (int dj = -1; dj <= 1; ++dj) {
      for (int di = -1; di <= 1; ++di) {
        if (di == 0 && dj == 0 && dk == 0) continue;
        const Vec3 along{di * grid.spacing.x, dj * grid.spacing.y, dk * grid.spacing.z};
        const std::ptrdiff_t offset =
            (std::ptrdiff_t{dk} * grid.size[1] + dj) * std::ptrdiff_t{grid.size[0]} + di;
        steps.push_back({di, dj, dk, offset, static_cast<float>(length(along))});
      }
    }
  }
  return steps;
}

/// Fronts that start at the seeds and advance through the mask in order of path length (Dijkstra), kept in
/// buckets no wider than the shortest step, so that a bucket's voxels cannot shorten each other's paths.
class Fronts {
 public:
  Fronts(const LabelVolume& mask, const LabelVolume& seeds, double max_mm)
      : mask_(mask),
        distance_(mask.grid, kUnreached),
        labels_(mask.grid),
        steps_(steps_to_neighbours(mask.grid)) {
    max_ = static_cast<float>(std::min(max_mm, 1e30));
    width_ = std::min_element(steps_.begin(), steps_.end(), [](const Step& a, const Step& b) {
               return a.length < b.length;
             })->length;
    float longest = 0;
    for (const Step& s : steps_) longest = std::max(longest, s.length);
    buckets_.resize(static_cast<std::size_t>(longest / width_) + 3);
    for (std::size_t v = 0; v < seeds.voxels.size(); ++v) {
      if (mask.voxels[v] && seeds.voxels[v]) reach(v, 0, seeds.voxels[v]);
    }
  }

  void advance() {
    std::vector<std::size_t> present;
    for (std::size_t number = 0; waiting_ > 0;) {
      std::vector<std::size_t>& bucket = buckets_[number % buckets_.size()];
      if (bucket.empty()) {
        ++number;
        continue;
      }
      present.swap(bucket);
      waiting_ -= present.size();
      for (const std::size_t voxel : present) {
        // Entries whose path has been shortened since lie in an earlier bucket as well.
        if (bucket_of(distance_.voxels[voxel]) == number) leave(voxel);
      }
      present.clear();
    }
  }

  Volume<float> take_distance() && { return std::move(distance_); }
  LabelVolume take_labels() && { return std::move(labels_); }

 private:
  [[nodiscard]] std::size_t bucket_of(float distance) const {
    return static_cast<std::size_t>(distance / width_);
  }

  void reach(std::size_t voxel, float distance, std::uint8_t label) {
    float& known = distance_.voxels[voxel];
    if (distance < known) {
      known = distance;
      labels_.voxels[voxel] = label;
      buckets_[bucket_of(distance) % buckets_.size()].push_back(voxel);
      ++waiting_;
    } else if (distance == known) {
      labels_.voxels[voxel] = std::min(labels_.voxels[voxel], label);
    }
  }

  void leave(std::size_t voxel) {
    const Index3 n = mask_.grid.size;
    const auto row = static_cast<std::size_t>(n[0]), rows = static_cast<std::size_t>(n[1]);
    const int i = static_cast<int>(voxel % row), j = static_cast<int>(voxel / row % rows),
              k = static_cast<int>(voxel / row / rows);
    const bool at_border = i == 0 || j == 0 || k == 0 || i == n[0] - 1 || j == n[1] - 1 || k == n[2] - 1;
    for (const Step& step : steps_) {
      if (at_border && !mask_.grid.contains(i + step.di, j + step.dj, k + step.dk)) continue;
      const std::size_t next = voxel + static_cast<std::size_t>(step.offset);
      if (!mask_.voxels[next]) continue;
      const float distance = distance_.voxels[voxel] + step.length;
      if (distance <= max_) reach(next, distance, labels_.voxels[voxel]);
    }
  }

  const LabelVolume& mask_;
  Volume<float> distance_;
  LabelVolume labels_;
  std::vector<Step> steps_;
  std::vector<std::vector<std::size_t>> buckets_;  ///< used in a circle
  std::size_t waiting_ = 0;
  float width_ = 1, max_ = 0;
};

bool usable(const LabelVolume& mask, const LabelVolume& seeds) {
  return detail::is_whole(mask) && seeds.voxels.size() == mask.voxels.size();
}

}  // namespace

Volume<float> geodesic_distance(const LabelVolume& mask, const LabelVolume& seeds, double max_mm) {
  if (!usable(mask, seeds)) return {};
  Fronts fronts(mask, seeds, max_mm);
  fronts.advance();
  Volume<float> distance = std::move(fronts).take_distance();
  const auto limit = static_cast<float>(max_mm);
  for (float& d : distance.voxels) d = std::min(d, limit);
  return distance;
}

LabelVolume grow_labels(const LabelVolume& mask, const LabelVolume& seeds, double max_mm) {
  if (!usable(mask, seeds)) return {};
  Fronts fronts(mask, seeds, max_mm);
  fronts.advance();
  return std::move(fronts).take_labels();
}

}  // namespace turgor
