#include "calibration/search_space.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {
namespace {

double scaled(const FitParameter& parameter, double value) {
  return parameter.logarithmic ? std::log(value) : value;
}

}  // namespace

SearchSpace::SearchSpace(std::span<const FitParameter> parameters)
    : declared_(parameters), low_(parameters.size()), range_(parameters.size()) {
  for (Eigen::Index i = 0; i < size(); ++i) {
    const FitParameter& p = declared_[static_cast<std::size_t>(i)];
    low_[i] = scaled(p, p.low);
    range_[i] = scaled(p, p.high) - low_[i];
  }
}

Eigen::VectorXd SearchSpace::unit(std::span<const double> parameters) const {
  Eigen::VectorXd out(size());
  for (Eigen::Index i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    out[i] = std::clamp((scaled(declared_[k], parameters[k]) - low_[i]) / range_[i], 0.0, 1.0);
  }
  return out;
}

std::vector<double> SearchSpace::parameters(const Eigen::VectorXd& unit) const {
  std::vector<double> out(declared_.size());
  for (Eigen::Index i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const FitParameter& p = declared_[k];
    const double value = low_[i] + unit[i] * range_[i];
    out[k] = std::clamp(p.logarithmic ? std::exp(value) : value, p.low, p.high);
  }
  return out;
}

Eigen::VectorXd SearchSpace::slope(std::span<const double> parameters) const {
  Eigen::VectorXd out = range_;
  for (Eigen::Index i = 0; i < size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (declared_[k].logarithmic) out[i] *= parameters[k];
  }
  return out;
}

}  // namespace turgor
