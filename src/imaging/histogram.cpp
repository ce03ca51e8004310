#include "turgor/imaging/histogram.hpp"

#include <algorithm>
#include <limits>

#include "imaging/bit_volume.hpp"

namespace turgor {

std::size_t Histogram::total() const {
  std::size_t sum = 0;
  for (const std::size_t c : counts) sum += c;
  return sum;
}

double Histogram::mean() const {
  double sum = 0;
  for (std::size_t b = 0; b < counts.size(); ++b)
    sum += static_cast<double>(counts[b]) * static_cast<double>(b);
  const std::size_t n = total();
  return n ? lower + sum / static_cast<double>(n) : 0;
}

std::optional<int> Histogram::quantile(double fraction) const {
  const std::size_t n = total();
  if (n == 0) return std::nullopt;
  const double wanted = std::max(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(n), 1.0);
  std::size_t sum = 0, b = 0;
  for (; b + 1 < counts.size(); ++b) {
    sum += counts[b];
    if (static_cast<double>(sum) >= wanted) break;
  }
  return lower + static_cast<int>(b);
}

std::optional<int> Histogram::mode(int half_width) const {
  const int n = static_cast<int>(counts.size()), reach = std::max(half_width, 0);
  std::size_t window = 0, best_count = 0;
  int best = -1;
  for (int entering = 0; entering < n + reach; ++entering) {
    if (entering < n) window += counts[static_cast<std::size_t>(entering)];
    const int leaving = entering - 2 * reach - 1, middle = entering - reach;
    if (leaving >= 0) window -= counts[static_cast<std::size_t>(leaving)];
    if (middle >= 0 && window > best_count) best_count = window, best = middle;
  }
  if (best < 0) return std::nullopt;
  return lower + best;
}

Histogram histogram(const CtVolume& volume, int lower, int upper, const LabelVolume* mask) {
  using Limits = std::numeric_limits<std::int16_t>;
  Histogram result;
  result.lower = std::max<int>(lower, Limits::min());
  const int last = std::min<int>(upper, Limits::max());
  if (last < result.lower) return result;
  result.counts.assign(static_cast<std::size_t>(last - result.lower + 1), 0);
  if (mask && mask->voxels.size() != volume.voxels.size()) return result;
  const auto bins = static_cast<unsigned>(result.counts.size());
  using Counts = std::vector<std::size_t>;
  result.counts = parallel_reduce<Counts>(
      volume.voxels.size(), 1 << 20, result.counts,
      [&](std::size_t begin, std::size_t end) {
        Counts part(bins, 0);
        for (std::size_t v = begin; v < end; ++v) {
          const auto bin = static_cast<unsigned>(volume.voxels[v] - result.lower);
          if (bin < bins && (!mask || mask->voxels[v])) ++part[bin];
        }
        return part;
      },
      [](Counts sum, const Counts& part) {
        for (std::size_t b = 0; b < sum.size(); ++b) sum[b] += part[b];
        return sum;
      });
  return result;
}

std::optional<double> otsu_level(const Histogram& histogram, int lower, int upper) {
  const int first = std::max(lower, histogram.lower);
  const int last = static_cast<int>(
      std::min<long long>(upper, histogram.lower + static_cast<long long>(histogram.counts.size()) - 1));
  double total = 0, moment = 0;
  for (int v = first; v <= last; ++v) {
    const auto c = static_cast<double>(histogram.count(v));
    total += c;
    moment += c * (v - first);
  }
  double below = 0, moment_below = 0, best = 0;
  int best_first = 0, best_last = -1;
  for (int v = first; v < last; ++v) {
    const auto c = static_cast<double>(histogram.count(v));
    below += c;
    moment_below += c * (v - first);
    const double above = total - below;
    if (below == 0 || above == 0) continue;
    const double gap = moment_below / below - (moment - moment_below) / above,
                 between = below * above * gap * gap;
    if (between > best) best = between, best_first = v;
    if (between == best) best_last = v;
  }
  if (best_last < best_first || best == 0) return std::nullopt;
  return 0.5 * (best_first + best_last) + 1;
}

}  // namespace turgor
