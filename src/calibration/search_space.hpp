// The parameters as searched: each on 0 to 1 between its bounds, by its logarithm where so declared.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "turgor/calibration/forward_model.hpp"

namespace turgor {

class SearchSpace {
 public:
  explicit SearchSpace(std::span<const FitParameter> parameters);

  [[nodiscard]] Eigen::Index size() const { return low_.size(); }
  [[nodiscard]] Eigen::VectorXd unit(std::span<const double> parameters) const;
  /// Within the bounds, to the last bit.
  [[nodiscard]] std::vector<double> parameters(const Eigen::VectorXd& unit) const;
  /// ∂ parameter / ∂ unit at those parameters.
  [[nodiscard]] Eigen::VectorXd slope(std::span<const double> parameters) const;
  /// ∂ logarithm of the parameter (or parameter, where not logarithmic) / ∂ unit: the same everywhere.
  [[nodiscard]] const Eigen::VectorXd& range() const { return range_; }

 private:
  std::span<const FitParameter> declared_;
  Eigen::VectorXd low_, range_;
};

}  // namespace turgor
