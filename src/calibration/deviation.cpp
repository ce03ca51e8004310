#include "calibration/deviation.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace turgor {
namespace {

// Rows that count, and their squares, as the sum over all loads with equal noise.
struct Normal {
  Eigen::MatrixXd matrix;  // JᵀJ by unit
  double squares = 0, measured = 0;
};

Result<Normal> normal_at(const Search& search, const FitPoint& point) {
  Normal out{Eigen::MatrixXd::Zero(search.space().size(), search.space().size())};
  for (std::size_t i = 0; i < point.loads.size(); ++i) {
    if (!search.problem().loads[point.loads[i]].fitted) continue;
    TURGOR_TRY(const Eigen::MatrixXd jacobian, point.jacobian(search, i));
    const Misfit& misfit = point.misfits[i];
    // Scales have squares that sum to 1 over points (or forces): brought back to 1 each.
    const double rows = static_cast<double>((misfit.scale.array() > 0).count());
    const double factor = rows / misfit.scale.squaredNorm();
    out.matrix += factor * (jacobian.transpose() * jacobian);
    out.squares += factor * misfit.residual.squaredNorm();
    out.measured += rows - static_cast<double>(misfit.rigid.cols());
  }
  return out;
}

}  // namespace

Result<std::vector<double>> deviation_at(const Search& search, const FitPoint& point) {
  const auto normal = normal_at(search, point);
  if (!normal) {
    if (normal.error().kind == ErrorKind::cancelled) return normal.error();
    return std::vector<double>{};
  }
  const double spare = normal->measured - static_cast<double>(search.space().size());
  if (spare < 1) return std::vector<double>{};
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(normal->matrix);
  const double least = 1e-14 * solver.eigenvalues().cwiseAbs().maxCoeff();
  std::vector<double> out;
  for (Eigen::Index i = 0; i < search.space().size(); ++i) {
    double variance = 0;
    for (Eigen::Index k = 0; k < search.space().size(); ++k) {
      const double part = solver.eigenvectors()(i, k), value = solver.eigenvalues()[k];
      if (value > least) {
        variance += part * part / value;
      } else if (std::abs(part) > 1e-6) {
        variance = failed_error;
      }
    }
    out.push_back(std::isinf(variance)
                      ? variance
                      : std::sqrt(normal->squares / spare * variance) * search.space().range()[i]);
  }
  return out;
}

}  // namespace turgor
