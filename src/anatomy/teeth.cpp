#include "anatomy/teeth.hpp"

#include <algorithm>
#include <cmath>

#include "anatomy/coarse_grid.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/imaging/histogram.hpp"
#include "turgor/imaging/isosurface.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

/// Enamel is denser than any bone but the petrous, which lies further back than this part of the cavity's
/// length.
constexpr double kArchDepth = 0.34;
constexpr double kHalfArchMm = 45;
constexpr double kSmallestToothMl = 0.04;
/// A tooth holds enamel (or a filling), denser than the level by this factor.
constexpr double kEnamel = 1.2;

/// Above the densest bone of the vault, where there are no teeth.
double tooth_level(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium) {
  const Index3 n = body.hu.grid.size;
  const int middle = static_cast<int>(body.hu.grid.to_index(cranium.centre).z);
  const VoxelBox vault{{0, 0, middle}, {n[0] - 1, n[1] - 1, n[2] - 1}};
  const LabelVolume solid = crop(body.solid, vault);
  const Histogram h = histogram(crop(body.hu, vault), static_cast<int>(levels.bone_level), 4000, &solid);
  constexpr double kDensest = 0.995, kMargin = 1.03;
  return std::clamp(kMargin * h.quantile(kDensest).value_or(1500), 1250.0, 2200.0);
}

/// Clears the components of which no voxel reaches the level.
void remove_components_below(LabelVolume& mask, const CtVolume& hu, double level) {
  const Components parts = connected_components(mask);
  std::vector<bool> reaches(parts.sizes.size() + 1, false);
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    if (hu.voxels[v] >= level) reaches[static_cast<std::size_t>(parts.labels.voxels[v])] = true;
  }
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    if (!reaches[static_cast<std::size_t>(parts.labels.voxels[v])]) mask.voxels[v] = 0;
  }
}

/// What lies near teeth, weighed by its density: enamel counts most, a partly filled gap little, air nothing.
struct WeighedPoint {
  Vec3 point;
  double weight;
};

std::vector<WeighedPoint> weigh(const LabelVolume& teeth, const CtVolume& hu) {
  constexpr double kAroundMm = 2.5, kNothingHu = 700, kMostHu = 3000;
  const VoxelBox box = bounding_box(teeth, 4);
  if (box.empty()) return {};
  const LabelVolume near = dilate(crop(teeth, box), kAroundMm);
  const Grid& g = near.grid;
  std::vector<WeighedPoint> points;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        if (near.at(i, j, k) == 0) continue;
        const double value = hu.at(i + box.lower[0], j + box.lower[1], k + box.lower[2]);
        const double weight = std::clamp(value, kNothingHu, kMostHu) - kNothingHu;
        if (weight > 0) points.push_back({g.to_patient({double(i), double(j), double(k)}), weight});
      }
    }
  }
  return points;
}

/// Mass of the teeth along a direction, in bins of `kBinMm`.
constexpr double kBinMm = 0.5;
struct Profile {
  double first = 0;  ///< height of the first bin's lower edge
  std::vector<double> mass;
};

Profile profile_along(const std::vector<WeighedPoint>& points, const Vec3& up) {
  double low = 1e9, high = -1e9;
  for (const auto& [p, weight] : points) {
    const double h = dot(p, up);
    low = std::min(low, h);
    high = std::max(high, h);
  }
  Profile profile{low, std::vector<double>(static_cast<std::size_t>((high - low) / kBinMm) + 2, 0.0)};
  for (const auto& [p, weight] : points)
    profile.mass[static_cast<std::size_t>((dot(p, up) - low) / kBinMm)] += weight;
  return profile;
}

struct Valley {
  double depth = 0;  ///< how much less mass it holds than the lower of its two banks, times the part of it
                     ///< that is missing
  double height = 0;
};

/// Each bin becomes the mean of those within a voxel's extent, or the layers of voxels would leave a comb.
void spread_over_voxels(Profile& profile, int voxel_bins) {
  const int n = static_cast<int>(profile.mass.size());
  std::vector<double> spread(profile.mass.size(), 0.0);
  for (int b = 0; b < n; ++b) {
    for (int d = -voxel_bins; d <= voxel_bins; ++d) {
      // A window of 2 v bins: the two outermost count half.
      const double weight = std::abs(d) == voxel_bins ? 0.5 : 1.0;
      if (b + d >= 0 && b + d < n) {
        spread[static_cast<std::size_t>(b)] +=
            weight * profile.mass[static_cast<std::size_t>(b + d)] / (2 * voxel_bins);
      }
    }
  }
  profile.mass = std::move(spread);
}

Valley deepest_valley(const Profile& profile, int voxel_bins) {
  const int n = static_cast<int>(profile.mass.size());
  std::vector<double> sums(static_cast<std::size_t>(n) + 1, 0.0);
  for (int b = 0; b < n; ++b) {
    sums[static_cast<std::size_t>(b) + 1] =
        sums[static_cast<std::size_t>(b)] + profile.mass[static_cast<std::size_t>(b)];
  }
  const auto mean = [&](int from, int to) {  // of bins from … to - 1, zero beyond the ends
    const int a = std::clamp(from, 0, n), b = std::clamp(to, 0, n);
    return (sums[static_cast<std::size_t>(b)] - sums[static_cast<std::size_t>(a)]) / (to - from);
  };
  constexpr int kBank = 8;  // 4 mm of crowns on either side
  const int half = voxel_bins;
  double highest = 0;
  for (int b = 0; b < n; ++b) highest = std::max(highest, mean(b, b + kBank));
  constexpr double kLeastBank = 0.4;
  std::vector<double> depths(static_cast<std::size_t>(n) + 1, 0.0);
  for (int b = half; b <= n - half; ++b) {
    double below = 0, above = 0;
    for (int gap = half; gap <= half + 8; ++gap) {
      below = std::max(below, mean(b - gap - kBank, b - gap));
      above = std::max(above, mean(b + gap, b + gap + kBank));
    }
    const double bank = std::min(below, above), missing = bank - mean(b - half, b + half);
    // Between crown and root there are shallow valleys too, and a root or two hold little.
    if (bank > kLeastBank * highest && missing > 0)
      depths[static_cast<std::size_t>(b)] = missing * missing / bank;
  }
  const auto deepest = std::max_element(depths.begin(), depths.end());
  // The middle of the floor, where the rows stand apart.
  constexpr double kFloor = 0.97;
  auto first = deepest, last = deepest;
  while (first != depths.begin() && *(first - 1) > kFloor * *deepest) --first;
  while (last + 1 != depths.end() && *(last + 1) > kFloor * *deepest) ++last;
  const double middle = 0.5 * static_cast<double>((first - depths.begin()) + (last - depths.begin()));
  return {*deepest, profile.first + middle * kBinMm};
}

Vec3 tilted_up(double pitch_deg, double roll_deg) {
  return rotation({1, 0, 0}, radians(pitch_deg)) * (rotation({0, 1, 0}, radians(roll_deg)) * Vec3{0, 0, 1});
}

}  // namespace

LabelVolume find_teeth(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium) {
  const double level = tooth_level(body, levels, cranium);
  const double back = cranium.cavity.lower.y + kArchDepth * cranium.cavity.size().y;
  LabelVolume dense(body.hu.grid);
  const Grid& g = dense.grid;
  parallel_for(static_cast<std::size_t>(g.size[2]), 2, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          const std::size_t v = g.offset(i, j, k);
          if (body.hu.voxels[v] < level || body.solid.voxels[v] == 0) continue;
          const Vec3 p = g.to_patient({double(i), double(j), double(k)});
          dense.voxels[v] =
              p.y < back && p.z < cranium.centre.z - 30 && std::abs(p.x - cranium.centre.x) < kHalfArchMm;
        }
      }
    }
  });
  dense = remove_small_components(dense, static_cast<std::size_t>(std::ceil(kSmallestToothMl / voxel_ml(g))));
  remove_components_below(dense, body.hu, kEnamel * level);
  return dense;
}

std::optional<Plane> find_occlusal_plane(const LabelVolume& teeth, const CtVolume& hu) {
  const std::vector<WeighedPoint> points = weigh(teeth, hu);
  if (static_cast<double>(points.size()) * voxel_ml(teeth.grid) < 1.0) return std::nullopt;
  const Vec3 s = teeth.grid.spacing;
  const int voxel_bins = std::max(1, static_cast<int>(std::lround(0.5 * s.z / kBinMm)));
  Valley best;
  double best_pitch = 0, best_roll = 0;
  const auto search = [&](double pitch, double roll) {
    Profile profile = profile_along(points, tilted_up(pitch, roll));
    spread_over_voxels(profile, voxel_bins);
    const Valley valley = deepest_valley(profile, voxel_bins);
    if (valley.depth > best.depth) best = valley, best_pitch = pitch, best_roll = roll;
  };
  for (int pitch = -30; pitch <= 30; pitch += 3) {
    for (int roll = -9; roll <= 9; roll += 3) search(pitch, roll);
  }
  for (double step : {1.5, 0.75}) {
    const double pitch = best_pitch, roll = best_roll;
    for (int dp = -1; dp <= 1; ++dp) {
      for (int dr = -1; dr <= 1; ++dr) search(pitch + dp * step, roll + dr * step);
    }
  }
  if (best.depth <= 0) return std::nullopt;
  return Plane{tilted_up(best_pitch, best_roll), best.height};
}

TriMesh teeth_surface(const ScannedBody& body, const LabelVolume& teeth, int triangles) {
  const VoxelBox box = bounding_box(teeth, 3);
  if (box.empty()) return {};
  const LabelVolume part = crop(teeth, box);
  const CtVolume hu = crop(body.hu, box);
  std::int16_t least = 32767;
  for (std::size_t v = 0; v < part.voxels.size(); ++v) {
    if (part.voxels[v]) least = std::min(least, hu.voxels[v]);
  }
  TriMesh mesh = smooth(isosurface_of_label(hu, least - 0.5, part, 1, true), 6, 0.2);
  return static_cast<int>(mesh.triangles.size()) > triangles ? decimate(mesh, triangles) : mesh;
}

}  // namespace turgor
