#include "anatomy/tissue_levels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "anatomy/coarse_grid.hpp"
#include "turgor/imaging/histogram.hpp"

namespace turgor {
namespace {

constexpr int kLowest = -1200, kHighest = 32767;
constexpr double kSmallestBodyMl = 100;
constexpr double kSmallestBoneMl = 20;
constexpr double kLeastAirFraction = 0.002;

double count_between(const Histogram& h, int from, int to) {
  double sum = 0;
  for (int v = from; v <= to; ++v) sum += static_cast<double>(h.count(v));
  return sum;
}

Histogram part(const Histogram& h, int from, int to) {
  Histogram out{from, {}};
  for (int v = from; v <= to; ++v) out.counts.push_back(h.count(v));
  return out;
}

double peak_between(const Histogram& h, int from, int to) {
  constexpr int kHalfWidth = 10;
  return part(h, from, to).mode(kHalfWidth).value_or((from + to) / 2);
}

/// Standard deviation of the peak, from the place above it where the count has halved. (Below lies fat.)
double peak_sigma(const Histogram& h, double peak) {
  const int top = static_cast<int>(peak);
  const auto smoothed = [&](int v) { return count_between(h, v - 3, v + 3); };
  int v = top;
  while (v < top + 500 && smoothed(v) > 0.5 * smoothed(top)) ++v;
  constexpr double kHalfWidthPerSigma = 1.17741;
  return std::max(1.0, (v - top) / kHalfWidthPerSigma);
}

/// Levels lie between integers, so no voxel is ever exactly on one.
double between_integers(double level) {
  return std::floor(level) + 0.5;
}

}  // namespace

Result<TissueLevels> measure_air_and_soft_tissue(const CtVolume& hu) {
  const Histogram h = histogram(hu, kLowest, kHighest);
  if (count_between(h, -300, kHighest) * voxel_ml(hu.grid) < kSmallestBodyMl) {
    return Error{.what = "the scan shows no skin: it holds hardly anything but air",
                 .remedy = "Check that it is a CT in Hounsfield units, or choose another series"};
  }
  const double voxels = static_cast<double>(hu.voxels.size());
  const double air = voxels - count_between(h, -700, kHighest);
  if (air < kLeastAirFraction * voxels) {
    return Error{
        .what = "the scan shows no skin: there is no air around the body",
        .remedy =
            "Check that it is a CT in Hounsfield units (air near -1000) and not cropped to the inside "
            "of the head"};
  }
  TissueLevels levels;
  levels.air = peak_between(h, -1100, -850);
  levels.soft = peak_between(h, -30, 150);
  levels.soft_sigma = peak_sigma(h, levels.soft);
  levels.skin_level = between_integers(0.5 * (levels.air + levels.soft));
  return levels;
}

Result<void> measure_bone(const CtVolume& hu, const LabelVolume& body, const HeadOptions& options,
                          TissueLevels& levels) {
  const Histogram h = histogram(hu, -200, kHighest, &body);
  const int clearly_bone = static_cast<int>(std::max(400.0, levels.soft + 8 * levels.soft_sigma));
  const double clearly_bone_ml = count_between(h, clearly_bone, kHighest) * voxel_ml(hu.grid);
  if (clearly_bone_ml > kSmallestBoneMl) {
    levels.bone = part(h, clearly_bone, kHighest).quantile(0.5).value_or(clearly_bone);
  }
  levels.bone_level = options.bone_threshold_hu;
  if (options.refine_bone_threshold) {
    const double quarter = levels.soft + 0.25 * (levels.bone - levels.soft);
    const double above_noise = levels.soft + 5 * levels.soft_sigma;
    levels.bone_level = std::min(std::max(quarter, above_noise), 0.5 * (levels.soft + levels.bone));
  }
  levels.bone_level = between_integers(levels.bone_level);
  const double bone_ml = count_between(h, static_cast<int>(levels.bone_level), kHighest) * voxel_ml(hu.grid);
  if (clearly_bone_ml < kSmallestBoneMl || bone_ml < kSmallestBoneMl) {
    const bool none_clear = clearly_bone_ml < kSmallestBoneMl;
    return Error{
        .what = fmt::format("the scan shows no bone: only {:.0f} ml of the body lie above {:.0f} HU",
                            none_clear ? clearly_bone_ml : bone_ml,
                            none_clear ? double(clearly_bone) : levels.bone_level),
        .remedy = "Check that it is a CT of a head in Hounsfield units, or lower the bone threshold"};
  }
  return {};
}

}  // namespace turgor
