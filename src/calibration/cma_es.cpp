// Covariance matrix adaptation, as in Hansen's tutorial (2016, arXiv:1604.00772), on the unit box.
//
// Samples beyond a bound are mirrored at it, and the distribution learns from where they then are.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "calibration/search.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

constexpr std::uint64_t normal_stream = 3;

// Weights and rates of the tutorial's table 1, without negative weights.
struct Strategy {
  int population = 0;
  Eigen::VectorXd weights;  // of the best, falling, summing to 1
  double mass = 0;          // μ_eff
  double c_sigma = 0, d_sigma = 0, c_c = 0, c_1 = 0, c_mu = 0, expected_norm = 0;
  int lag = 1;  // generations between decompositions of the covariance

  Strategy(int size, int most) {
    const double n = size;
    population = std::min(4 + static_cast<int>(3 * std::log(n)), most);
    const int parents = std::max(1, population / 2);
    weights.resize(parents);
    for (int i = 0; i < parents; ++i) weights[i] = std::log(0.5 * (population + 1)) - std::log(i + 1);
    if (parents == 1) weights[0] = 1;
    weights /= weights.sum();
    mass = 1 / weights.squaredNorm();
    c_sigma = (mass + 2) / (n + mass + 5);
    d_sigma = 1 + 2 * std::max(0.0, std::sqrt((mass - 1) / (n + 1)) - 1) + c_sigma;
    c_c = (4 + mass / n) / (n + 4 + 2 * mass / n);
    c_1 = 2 / ((n + 1.3) * (n + 1.3) + mass);
    c_mu = std::min(1 - c_1, 2 * (0.25 + mass + 1 / mass - 2) / ((n + 2) * (n + 2) + mass));
    lag = std::max(1, static_cast<int>(1 / (10 * n * (c_1 + c_mu))));
    expected_norm = std::sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
  }
};

double mirrored(double place) {
  const double turn = std::abs(std::remainder(place, 2.0));
  return std::clamp(turn, 0.0, 1.0);
}

class Distribution {
 public:
  Distribution(const Eigen::VectorXd& mean, const Strategy& strategy)
      : strategy_(strategy),
        mean_(mean),
        path_sigma_(Eigen::VectorXd::Zero(mean.size())),
        path_c_(path_sigma_),
        deviations_(Eigen::VectorXd::Ones(mean.size())),
        covariance_(Eigen::MatrixXd::Identity(mean.size(), mean.size())),
        axes_(covariance_) {}

  [[nodiscard]] Eigen::VectorXd sample(const RandomStream& random, std::uint64_t first) const {
    Eigen::VectorXd z(mean_.size());
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = random.normal(first + static_cast<std::uint64_t>(i));
    return (mean_ + sigma_ * (axes_ * deviations_.cwiseProduct(z))).unaryExpr(&mirrored);
  }

  // `sorted`: samples, best first.
  void learn(std::span<const Eigen::VectorXd> sorted) {
    const Strategy& s = strategy_;
    const Eigen::Index parents = s.weights.size();
    Eigen::MatrixXd y(mean_.size(), parents);
    for (Eigen::Index i = 0; i < parents; ++i)
      y.col(i) = (sorted[static_cast<std::size_t>(i)] - mean_) / sigma_;
    const Eigen::VectorXd move = y * s.weights;
    mean_ += sigma_ * move;

    const Eigen::VectorXd white =
        axes_ * deviations_.cwiseInverse().cwiseProduct((axes_.transpose() * move).eval());
    path_sigma_ = (1 - s.c_sigma) * path_sigma_ + std::sqrt(s.c_sigma * (2 - s.c_sigma) * s.mass) * white;
    ++generation_;
    const double norm = path_sigma_.norm();
    const double settled = std::sqrt(1 - std::pow(1 - s.c_sigma, 2 * generation_));
    const bool slow = norm / settled < (1.4 + 2 / (static_cast<double>(mean_.size()) + 1)) * s.expected_norm;
    path_c_ *= 1 - s.c_c;
    if (slow) path_c_ += std::sqrt(s.c_c * (2 - s.c_c) * s.mass) * move;

    const double lost = slow ? 0 : s.c_1 * s.c_c * (2 - s.c_c);
    covariance_ *= 1 + lost - s.c_1 - s.c_mu;
    covariance_ +=
        s.c_1 * path_c_ * path_c_.transpose() + s.c_mu * y * s.weights.asDiagonal() * y.transpose();
    sigma_ *= std::exp(std::min(1.0, s.c_sigma / s.d_sigma * (norm / s.expected_norm - 1)));
    if (generation_ >= decomposed_ + s.lag) decompose();
  }
  // All samples failed: nearer to the mean.
  void shrink() { sigma_ *= 0.5; }

  [[nodiscard]] bool collapsed() const {
    const double widest = deviations_.maxCoeff();
    return !(sigma_ * widest > 1e-10) || !(widest < 1e7 * deviations_.minCoeff());
  }

 private:
  void decompose() {
    covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance_);
    decomposed_ = generation_;
    axes_ = solver.eigenvectors();
    deviations_ = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  }

  const Strategy& strategy_;
  Eigen::VectorXd mean_, path_sigma_, path_c_, deviations_;
  Eigen::MatrixXd covariance_, axes_;
  double sigma_ = 0.25;
  int generation_ = 0, decomposed_ = 0;
};

// Best first; failed ones last, ties in order.
std::vector<Eigen::VectorXd> sorted_by(const std::vector<double>& errors,
                                       const std::vector<Eigen::VectorXd>& units) {
  std::vector<std::size_t> order(errors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return errors[a] < errors[b]; });
  std::vector<Eigen::VectorXd> out;
  out.reserve(order.size());
  for (const std::size_t i : order) out.push_back(units[i]);
  return out;
}

}  // namespace

Result<void> search_by_cma_es(Search& search) {
  if (search.left() < 1) return {};
  const Strategy strategy(static_cast<int>(search.space().size()), search.left());
  Distribution distribution(search.best(), strategy);
  const RandomStream random(search.options().seed, normal_stream);
  const auto size = static_cast<std::uint64_t>(search.space().size());
  std::uint64_t next = 0;
  while (search.left() >= strategy.population && !distribution.collapsed()) {
    std::vector<Eigen::VectorXd> units;
    for (int i = 0; i < strategy.population; ++i, next += size)
      units.push_back(distribution.sample(random, next));
    TURGOR_TRY(const std::vector<double> errors, search.evaluate(FitSample::Stage::search, units));
    if (*std::min_element(errors.begin(), errors.end()) < failed_error) {
      distribution.learn(sorted_by(errors, units));
    } else {
      distribution.shrink();
    }
  }
  return {};
}

}  // namespace turgor
