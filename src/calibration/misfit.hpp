// The difference of a response to its reference as a residual for least squares.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "turgor/calibration/calibrate.hpp"

namespace turgor {

/// |residual|² is the square of the error. Of places: component k of point i at 3 i + k, each times the root
/// of the point's share of the weights; of forces: each divided by the root of their number.
struct Misfit {
  ErrorMeasure measure = ErrorMeasure::distance;
  Eigen::VectorXd residual;
  Eigen::VectorXd scale;  ///< the factor of each row
  Eigen::Matrix3d rotation =
      Eigen::Matrix3d::Identity();  ///< of shape: what brings the response to the reference
  Eigen::MatrixXd rigid;            ///< of shape: orthonormal, what rigid motion adds to the residual

  /// Infinite where the response is not finite.
  [[nodiscard]] double error() const;
  /// ∂ residual / ∂ parameters from ∂ response / ∂ parameters. Of shape without what rigid motion takes up:
  /// gradient exact, the alignment's own second order left out.
  [[nodiscard]] Eigen::MatrixXd jacobian(const DenseMatrix& response) const;
  /// ∂ error / ∂ response, of the length `rows`; zero where the error is.
  [[nodiscard]] std::vector<double> error_gradient(std::size_t rows) const;
};

/// Errors: those of response_error.
Result<Misfit> misfit_of(const ReferenceLoad& load, const Response& response, ErrorMeasure measure);

}  // namespace turgor
