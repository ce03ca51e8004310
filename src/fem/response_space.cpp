#include "turgor/fem/response_space.hpp"

#include <Eigen/QR>
#include <algorithm>

#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

Error other_length(const char* what) {
  return {ErrorKind::bad_input, std::string("another number of ") + what + " than before", "response space",
          "Keep one space for each body and its supports"};
}

double product(std::span<const Vec3> a, std::span<const Vec3> b) {
  return parallel_sum(a.size(), 4096, [&](std::size_t i) { return dot(a[i], b[i]); });
}

}  // namespace

ResponseSpace::ResponseSpace(std::size_t capacity) : capacity_(std::max<std::size_t>(capacity, 1)) {}

Result<void> ResponseSpace::add(std::span<const Vec3> held_mm, std::span<const Vec3> displacement_mm) {
  if (!known_.empty()) {
    if (known_.front().held.size() != held_mm.size()) return other_length("supports");
    if (known_.front().displacement.size() != displacement_mm.size()) return other_length("displacements");
  }
  if (known_.size() == capacity_) known_.pop_front();
  known_.push_back({{held_mm.begin(), held_mm.end()}, {displacement_mm.begin(), displacement_mm.end()}});
  return {};
}

Result<std::vector<Vec3>> ResponseSpace::start(std::span<const Vec3> held_mm) const {
  if (known_.empty()) return std::vector<Vec3>{};
  const Known& last = known_.back();
  if (last.held.size() != held_mm.size()) return other_length("supports");
  // The last solution, and the way from it to each of the others.
  const auto away = [&](std::size_t k) {
    std::vector<Vec3> difference = known_[k].held;
    for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= last.held[i];
    return difference;
  };
  const auto others = static_cast<Eigen::Index>(known_.size()) - 1;
  std::vector<std::vector<Vec3>> ways;
  for (Eigen::Index k = 0; k < others; ++k) ways.push_back(away(static_cast<std::size_t>(k)));
  std::vector<Vec3> wanted(held_mm.begin(), held_mm.end());
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] -= last.held[i];
  Eigen::MatrixXd gram(others, others);
  Eigen::VectorXd right(others);
  for (Eigen::Index a = 0; a < others; ++a) {
    right[a] = product(ways[static_cast<std::size_t>(a)], wanted);
    for (Eigen::Index b = 0; b < others; ++b)
      gram(a, b) = product(ways[static_cast<std::size_t>(a)], ways[static_cast<std::size_t>(b)]);
  }
  // Ways that say the same share the answer.
  Eigen::VectorXd share = Eigen::VectorXd::Zero(others);
  if (others > 0) {
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    constexpr double kSame = 1e-10;
    solver.setThreshold(kSame);
    share = solver.compute(gram).solve(right);
  }
  std::vector<Vec3> start = last.displacement;
  for (Eigen::Index k = 0; k < others; ++k) {
    const std::vector<Vec3>& other = known_[static_cast<std::size_t>(k)].displacement;
    for (std::size_t i = 0; i < start.size(); ++i) start[i] += (other[i] - last.displacement[i]) * share[k];
  }
  return start;
}

}  // namespace turgor
