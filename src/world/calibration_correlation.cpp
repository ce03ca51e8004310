#include <algorithm>
#include <cmath>

#include "turgor/world/calibration_case.hpp"

namespace turgor {
namespace {

/// Of each edge the mean logarithm of Young's modulus over the tetrahedra that share it.
std::vector<double> log_moduli(const CalibrationCase& problem) {
  const Solid& solid = problem.elements();
  std::vector<double> sum(solid.edges.size()), count(solid.edges.size());
  for (std::size_t t = 0; t < solid.tetrahedra.size(); ++t) {
    const double modulus = std::log(problem.reference_body().of(t / 5).youngs_modulus_mpa);
    std::array<int, 4> points = solid.tetrahedra[t];
    std::ranges::sort(points);
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b) {
        const auto edge = std::ranges::lower_bound(solid.edges, std::array{points[a], points[b]});
        const auto e = static_cast<std::size_t>(edge - solid.edges.begin());
        sum[e] += modulus, count[e] += 1;
      }
    }
  }
  for (std::size_t e = 0; e < sum.size(); ++e) sum[e] /= count[e];
  return sum;
}

void subtract_mean(std::vector<double>& values) {
  double mean = 0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (double& v : values) v -= mean;
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

std::optional<double> modulus_correlation(const CalibrationCase& problem, const SolidConstants& stiffness) {
  std::vector<double> moduli = log_moduli(problem), learned;
  for (const double k : stiffness[0]) learned.push_back(std::log(k));
  subtract_mean(moduli);
  subtract_mean(learned);
  // Rounding alone is no difference.
  const double least = 1e-12 * static_cast<double>(moduli.size());
  const double of_moduli = product(moduli, moduli), of_learned = product(learned, learned);
  if (!(of_moduli > least) || !(of_learned > least)) return std::nullopt;
  return product(moduli, learned) / std::sqrt(of_moduli * of_learned);
}

}  // namespace turgor
