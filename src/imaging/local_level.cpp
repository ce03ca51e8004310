#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "imaging/bit_volume.hpp"
#include "turgor/imaging/isosurface.hpp"

namespace turgor {
namespace {

/// Samples a profile takes per smallest voxel edge, and the most it takes on either side.
constexpr double kSamplesPerVoxel = 3;
constexpr int kMostSamples = 48;
/// A plateau begins where the slope has faded to this part of the step's steepest. For a blurred edge the
/// value is then within 3 % of the plateau, by the same amount on both sides, so that their middle stays.
constexpr float kFadedSlope = 0.15F;
/// A slope that has weakened to the first part of the steepest and then grows by the second belongs to
/// another step.
constexpr float kWeakSlope = 0.6F, kNextStep = 0.1F;
/// Steps of less than this (HU) are not told from noise, whose standard deviation is about 12 HU.
constexpr float kLeastStep = 100;
/// Steps it takes to tell the blur of a scan.
constexpr std::size_t kLeastSteps = 50;
constexpr float kRootTwoPi = 2.5066283F;

/// Sums over the edges at each point of the other end's value; an edge inside a surface is met from both its
/// triangles.
template <class T>
std::vector<T> sum_over_neighbours(const TriMesh& mesh, const std::vector<T>& values) {
  std::vector<T> sums(values.size(), T{});
  for (const Index3& t : mesh.triangles) {
    const auto a = static_cast<std::size_t>(t[0]), b = static_cast<std::size_t>(t[1]),
               c = static_cast<std::size_t>(t[2]);
    sums[a] += values[b] + values[c];
    sums[b] += values[c] + values[a];
    sums[c] += values[a] + values[b];
  }
  return sums;
}

/// Unit normals by area, averaged once more over the neighbours: profiles of neighbouring points must not
/// cross.
std::vector<Vec3> smooth_normals(const TriMesh& mesh) {
  std::vector<Vec3> normals(mesh.points.size());
  for (const Index3& t : mesh.triangles) {
    const Vec3 n = triangle_normal(mesh, t);
    for (const int p : t) normals[static_cast<std::size_t>(p)] += n;
  }
  const auto for_each_point = [&](auto&& update) {
    parallel_for(normals.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t p = begin; p < end; ++p) update(p);
    });
  };
  for_each_point([&](std::size_t p) { normals[p] = normalized(normals[p]); });
  const std::vector<Vec3> around = sum_over_neighbours(mesh, normals);
  for_each_point([&](std::size_t p) { normals[p] = normalized(normals[p] * 4.0 + around[p]); });
  return normals;
}

/// Values along a normal from inside (first) to outside; sample `centre` is the point itself. Outwards it
/// ends after `reach` samples; inwards it goes half as far again, to see the other side of a thin plate.
struct Profile {
  float values[5 * kMostSamples / 2 + 1];
  int centre, reach;
  double step_mm;

  [[nodiscard]] int count() const { return centre + reach + 1; }
  /// How much the value falls outwards around sample m.
  [[nodiscard]] float fall(int m) const { return values[m - 1] - values[m + 1]; }
};

class ProfileSampler {
 public:
  ProfileSampler(const CtVolume& volume, double reach_mm) : volume_(volume) {
    const Vec3 s = volume.grid.spacing;
    const double wanted = std::min({s.x, s.y, s.z}) / kSamplesPerVoxel;
    reach_ = std::clamp(static_cast<int>(std::ceil(reach_mm / wanted)), 2, kMostSamples);
    step_mm_ = reach_mm / reach_;
  }

  [[nodiscard]] Profile sample(const Vec3& point, const Vec3& normal) const {
    Profile profile;
    profile.centre = reach_ + reach_ / 2;
    profile.reach = reach_;
    profile.step_mm = step_mm_;
    const Vec3 middle = volume_.grid.to_index(point);
    const Vec3 step = volume_.grid.to_index(point + normal * step_mm_) - middle;
    const bool within =
        inside(middle - step * double(profile.centre)) && inside(middle + step * double(reach_));
    for (int m = 0; m < profile.count(); ++m) {
      const Vec3 at = middle + step * double(m - profile.centre);
      profile.values[m] = within ? trilinear(at) : static_cast<float>(volume_.sample_index(at));
    }
    return profile;
  }

 private:
  [[nodiscard]] bool inside(const Vec3& index) const {
    const Index3& n = volume_.grid.size;
    return index.x >= 0 && index.y >= 0 && index.z >= 0 && index.x < n[0] - 1 && index.y < n[1] - 1 &&
           index.z < n[2] - 1;
  }
  /// As Volume::sample_index, without its clamping.
  [[nodiscard]] float trilinear(const Vec3& index) const {
    const int i = static_cast<int>(index.x), j = static_cast<int>(index.y), k = static_cast<int>(index.z);
    const auto fx = static_cast<float>(index.x - i), fy = static_cast<float>(index.y - j),
               fz = static_cast<float>(index.z - k);
    const std::int16_t* p = volume_.voxels.data() + volume_.grid.offset(i, j, k);
    const auto nx = static_cast<std::size_t>(volume_.grid.size[0]);
    const auto row = [fx](const std::int16_t* q) {
      const auto a = static_cast<float>(q[0]);
      return a + (static_cast<float>(q[1]) - a) * fx;
    };
    const auto plane = [&](const std::int16_t* q) {
      const float a = row(q);
      return a + (row(q + nx) - a) * fy;
    };
    const float a = plane(p);
    return a + (plane(p + nx * static_cast<std::size_t>(volume_.grid.size[1])) - a) * fz;
  }

  const CtVolume& volume_;
  int reach_;
  double step_mm_;
};

/// Sample at which the value falls outwards the steepest within `most` samples of the middle; nearer ones are
/// preferred, so that the skin does not draw the surface of a bone close under it. -1 where nothing falls.
int steepest_fall(const Profile& profile, int most) {
  int best = -1;
  float best_score = 0;
  const int first = std::max(profile.centre - most, 1),
            last = std::min(profile.centre + most, profile.count() - 2);
  for (int m = first; m <= last; ++m) {
    const float away = static_cast<float>(m - profile.centre) / static_cast<float>(most + 1);
    const float score = profile.fall(m) * (1 - 0.75F * away * away);
    if (score > best_score) best_score = score, best = m;
  }
  return best;
}

/// Walks from the steepest sample in one direction to the plateau: where the slope has faded, or where it is
/// least before the next step (as in thin soft tissue between air and bone).
int plateau(const Profile& profile, int steepest, int direction) {
  const float full = profile.fall(steepest);
  float least = full;
  int at = steepest;
  const int first = profile.centre - profile.reach, last = profile.centre + profile.reach;
  for (int m = steepest + direction; m > first && m < last; m += direction) {
    const float slope = profile.fall(m);
    if (slope < least) least = slope, at = m;
    if (slope <= kFadedSlope * full) return m;
    if (least < kWeakSlope * full && slope > least + kNextStep * full) return at;
  }
  return direction < 0 ? first : last;
}

/// What a profile says of the surface there, in mm.
struct Step {
  float at = 0;     ///< along the normal, outwards positive: where the value is midway between the plateaus
  float blur = 0;   ///< standard deviation of the Gaussian that would give an edge this slope
  float width = 0;  ///< to where the value falls below that level again on the inside; 0 where it does not
  bool clear = false;
};

/// Position in samples of the crossing of `level` between samples m and m + 1.
float crossing(const Profile& profile, int m, float level) {
  const float a = profile.values[m], b = profile.values[m + 1];
  return static_cast<float>(m) + (a - level) / (a - b);
}

Step find_step(const Profile& profile, double most_mm) {
  Step step;
  const auto spacing = static_cast<float>(profile.step_mm);
  const int most = std::max(1, static_cast<int>(std::ceil(most_mm / profile.step_mm)));
  const int steepest = steepest_fall(profile, most);
  if (steepest < 0) return step;
  const int inner = plateau(profile, steepest, -1), outer = plateau(profile, steepest, 1);
  const float high = profile.values[inner], low = profile.values[outer], level = 0.5F * (high + low);
  if (high - low < kLeastStep) return step;
  const auto centre = static_cast<float>(profile.centre);
  float nearest = std::numeric_limits<float>::infinity();
  for (int m = inner; m < outer; ++m) {
    if (profile.values[m] < level || profile.values[m + 1] >= level) continue;
    const float at = crossing(profile, m, level);
    if (std::abs(at - centre) < std::abs(nearest - centre)) nearest = at;
  }
  if (std::isinf(nearest)) return step;
  step.clear = true;
  step.at = (nearest - centre) * spacing;
  step.blur = (high - low) * 2 * spacing / (kRootTwoPi * profile.fall(steepest));
  for (int m = inner; m > 0; --m) {
    if (profile.values[m - 1] >= level) continue;
    step.width = (nearest - crossing(profile, m - 1, level)) * spacing;
    break;
  }
  return step;
}

/// How far outside its true face a thin plate blurred by a Gaussian crosses half of its own peak. The plate
/// of half width a has the profile Φ(x + a) - Φ(x - a) (x and a in standard deviations), whose peak is lower
/// than the plate's own value, so the half lies too far out; the more the thinner the plate.
class PlateExcess {
 public:
  PlateExcess() {
    for (int n = 0; n < kEntries; ++n) {
      const double half = half_width_seen(n * kStep);
      table_[static_cast<std::size_t>(n)] = {half, half - n * kStep};
    }
  }
  /// `half_seen`: half of the width at half of the peak. All in standard deviations.
  [[nodiscard]] double operator()(double half_seen) const {
    const auto after = std::lower_bound(table_.begin(), table_.end(), half_seen,
                                        [](const Entry& e, double value) { return e.half_seen < value; });
    if (after == table_.end()) return 0;
    // Thinner than that the width seen hardly changes with the plate's, so noise would decide.
    if (after - table_.begin() <= kThinnest) return table_[kThinnest].excess;
    const Entry &a = *(after - 1), &b = *after;
    return a.excess + (b.excess - a.excess) * (half_seen - a.half_seen) / (b.half_seen - a.half_seen);
  }

 private:
  struct Entry {
    double half_seen, excess;
  };
  static constexpr int kEntries = 61, kThinnest = 10;
  static constexpr double kStep = 0.05;

  static double part_below(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
  /// Bisection for the x where the profile of half width a is half of its peak.
  static double half_width_seen(double a) {
    a = std::max(a, 1e-3);
    const auto profile = [a](double x) { return part_below(x + a) - part_below(x - a); };
    double low = 0, high = a + 3;
    for (int n = 0; n < 50; ++n) {
      const double middle = 0.5 * (low + high);
      (profile(middle) > 0.5 * profile(0) ? low : high) = middle;
    }
    return low;
  }
  std::array<Entry, kEntries> table_;
};

/// The blur of the scan: what the sharper quarter of the steps without another side show (the others are
/// widened by gradual tissue and oblique voxels). 0 where there are too few.
double scan_blur(const std::vector<Step>& steps) {
  std::vector<float> blurs;
  for (const Step& s : steps) {
    if (s.clear && s.width == 0) blurs.push_back(s.blur);
  }
  if (blurs.size() < kLeastSteps || 20 * blurs.size() < steps.size()) return 0;
  const auto quarter = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() / 4);
  std::nth_element(blurs.begin(), quarter, blurs.end());
  return *quarter;
}

std::vector<double> shifts_of(const std::vector<Step>& steps, double max_shift_mm) {
  const double blur = scan_blur(steps);
  const PlateExcess excess;
  std::vector<double> shifts(steps.size(), 0.0);
  for (std::size_t p = 0; p < steps.size(); ++p) {
    if (!steps[p].clear) continue;
    double shift = steps[p].at;
    if (blur > 0 && steps[p].width > 0) shift -= blur * excess(0.5 * steps[p].width / blur);
    shifts[p] = std::clamp(shift, -max_shift_mm, max_shift_mm);
  }
  return shifts;
}

/// A sum and the number of its terms.
struct Sum {
  double value = 0, terms = 0;
  Sum& operator+=(const Sum& other) { return value += other.value, terms += other.terms, *this; }
  friend Sum operator+(Sum a, const Sum& b) { return a += b; }
};

/// One step of averaging among the points that move, against noise in single profiles.
void smooth_shifts(const TriMesh& mesh, const std::vector<Step>& steps, std::vector<double>& shifts) {
  std::vector<Sum> moves(steps.size());
  for (std::size_t p = 0; p < steps.size(); ++p) moves[p] = {shifts[p], steps[p].clear ? 1.0 : 0.0};
  const std::vector<Sum> around = sum_over_neighbours(mesh, moves);
  for (std::size_t p = 0; p < shifts.size(); ++p) {
    if (!steps[p].clear || around[p].terms == 0) continue;
    shifts[p] = 0.5 * (shifts[p] + around[p].value / around[p].terms);
  }
}

}  // namespace

int refine_to_local_level(TriMesh& mesh, const CtVolume& volume, double reach_mm, double max_shift_mm) {
  if (!detail::is_whole(volume) || !(reach_mm > 0) || !(max_shift_mm > 0)) return 0;
  if (std::isinf(reach_mm) || std::isinf(max_shift_mm)) return 0;
  const std::vector<Vec3> normals = smooth_normals(mesh);
  const ProfileSampler sampler(volume, std::max(reach_mm, max_shift_mm));
  std::vector<Step> steps(mesh.points.size());
  parallel_for(mesh.points.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (normals[p] == Vec3{}) continue;
      steps[p] = find_step(sampler.sample(mesh.points[p], normals[p]), max_shift_mm);
    }
  });
  std::vector<double> shifts = shifts_of(steps, max_shift_mm);
  smooth_shifts(mesh, steps, shifts);
  int moved = 0;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (!steps[p].clear) continue;
    mesh.points[p] += normals[p] * shifts[p];
    ++moved;
  }
  return moved;
}

}  // namespace turgor
