#include "anatomy/bone_flood.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace turgor {
namespace {

constexpr int kStepHu = 16;
constexpr int kLowestHu = -1024;
constexpr int kLevels = 320;

int level_of(std::int16_t hu) {
  return std::clamp((hu - kLowestHu) / kStepHu, 0, kLevels - 1);
}

/// First in, first out within a level; the densest level first. What comes in above the present level counts
/// as of it.
class LevelQueue {
 public:
  void push(std::size_t voxel, int level) {
    queues_[static_cast<std::size_t>(std::min(level, level_))].push_back(voxel);
  }
  /// False when empty.
  bool pop(std::size_t& voxel) {
    while (level_ >= 0) {
      const auto l = static_cast<std::size_t>(level_);
      if (heads_[l] < queues_[l].size()) {
        voxel = queues_[l][heads_[l]++];
        return true;
      }
      queues_[l] = {};
      --level_;
    }
    return false;
  }

 private:
  std::array<std::vector<std::size_t>, kLevels> queues_;
  std::array<std::size_t, kLevels> heads_{};
  int level_ = kLevels - 1;
};

}  // namespace

LabelVolume flood_by_density(const CtVolume& hu, const LabelVolume& bone, const LabelVolume& markers) {
  const Grid& g = hu.grid;
  LabelVolume labels(g);
  LevelQueue queue;
  for (std::size_t v = 0; v < labels.voxels.size(); ++v) {
    if (bone.voxels[v] == 0 || markers.voxels[v] == 0) continue;
    labels.voxels[v] = markers.voxels[v];
    queue.push(v, level_of(hu.voxels[v]));
  }
  const auto nx = static_cast<std::size_t>(g.size[0]), ny = static_cast<std::size_t>(g.size[1]);
  const auto nz = static_cast<std::size_t>(g.size[2]);
  for (std::size_t v = 0; queue.pop(v);) {
    const std::size_t i = v % nx, j = v / nx % ny, k = v / (nx * ny);
    const auto visit = [&](bool exists, std::size_t w) {
      if (!exists || bone.voxels[w] == 0 || labels.voxels[w] != 0) return;
      labels.voxels[w] = labels.voxels[v];
      queue.push(w, level_of(hu.voxels[w]));
    };
    visit(i > 0, v - 1);
    visit(i + 1 < nx, v + 1);
    visit(j > 0, v - nx);
    visit(j + 1 < ny, v + nx);
    visit(k > 0, v - nx * ny);
    visit(k + 1 < nz, v + nx * ny);
  }
  return labels;
}

}  // namespace turgor
