#include "turgor/world/network_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/dynamics/equilibrium_sensitivity.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "fit of a network", std::move(remedy)};
}

/// The constants that each parameter touches, with its weight there.
struct Column {
  std::vector<int> constants;
  std::vector<double> weights;
};

struct Shared {
  NetworkFit fit;
  std::vector<Column> columns;

  [[nodiscard]] Result<std::vector<double>> factors(std::span<const double> parameters) const;
  /// Relative change of a constant per unit of a parameter with the weight `weight` there.
  [[nodiscard]] double relative(double weight, double parameter, double factor) const {
    return fit.logarithmic ? weight / parameter : weight / factor;
  }
};

Result<std::vector<double>> Shared::factors(std::span<const double> parameters) const {
  if (parameters.size() != columns.size())
    return bad(fmt::format("{} parameters are given for {}", parameters.size(), columns.size()),
               "Give one for each column of the weights");
  std::vector<double> values(parameters.begin(), parameters.end());
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k]) || values[k] < 0 || (fit.logarithmic && values[k] == 0))
      return bad(fmt::format("parameter {} is {}", k, values[k]), "Constants are finite and not below 0");
    if (fit.logarithmic) values[k] = std::log(values[k]);
  }
  std::vector<double> out(fit.weights.rows());
  fit.weights.apply(values, out);
  for (std::size_t c = 0; c < out.size(); ++c) {
    if (fit.weights.offsets[c] == fit.weights.offsets[c + 1]) {
      out[c] = 1;
    } else if (fit.logarithmic) {
      out[c] = std::exp(out[c]);
    }
  }
  return out;
}

class NetworkRun final : public ForwardRun {
 public:
  NetworkRun(std::shared_ptr<const Shared> shared, std::size_t load, std::vector<double> parameters,
             std::vector<double> factors, SpringNetwork network, std::vector<Vec3> positions)
      : shared_(std::move(shared)),
        load_(load),
        parameters_(std::move(parameters)),
        factors_(std::move(factors)),
        network_(std::move(network)),
        positions_(std::move(positions)) {}

  Result<void> measure();
  [[nodiscard]] const std::vector<Vec3>& positions() const { return positions_; }
  [[nodiscard]] const Response& response() const override { return response_; }
  [[nodiscard]] Result<DenseMatrix> jacobian(Context& context) const override;
  [[nodiscard]] Result<std::vector<double>> adjoint(std::span<const double> seed,
                                                    Context& context) const override;

 private:
  [[nodiscard]] Result<const EquilibriumSensitivity*> sensitivity(Context& context) const;
  [[nodiscard]] std::vector<std::vector<ConstantChange>> changes() const;
  void fill_column(const EquilibriumSensitivity& sensitivity, std::span<const ConstantChange> change,
                   std::span<const Vec3> shift, std::span<double> column) const;
  [[nodiscard]] std::vector<double> by_parameter(std::span<const double> by_constant) const;

  std::shared_ptr<const Shared> shared_;
  std::size_t load_;
  std::vector<double> parameters_, factors_;
  SpringNetwork network_;
  std::vector<Vec3> positions_;
  Response response_;
  mutable std::mutex mutex_;
  mutable std::optional<EquilibriumSensitivity> sensitivity_;  // made when it is first asked for
};

Result<void> NetworkRun::measure() {
  for (const int p : shared_->fit.points) response_.position_mm.push_back(positions_[at(p)]);
  if (shared_->fit.force_groups.empty()) return {};
  TURGOR_TRY(const NetworkEnergy energy, NetworkEnergy::prepare(network_));
  std::vector<Vec3> forces(positions_.size());
  NetworkEnergy::Workspace workspace;
  energy.forces(positions_, forces, workspace);
  for (const std::vector<int>& group : shared_->fit.force_groups) {
    Vec3 sum;
    for (const int p : group) sum -= forces[at(p)];
    for (const double component : {sum.x, sum.y, sum.z}) response_.force_n.push_back(component);
  }
  return {};
}

Result<const EquilibriumSensitivity*> NetworkRun::sensitivity(Context& context) const {
  const std::lock_guard lock(mutex_);
  if (!sensitivity_) {
    if (std::find(factors_.begin(), factors_.end(), 0.0) != factors_.end())
      return bad("a constant of 0 has no derivative", "Keep the parameters above 0");
    const NetworkLoad& load = shared_->fit.loads[load_];
    TURGOR_TRY(sensitivity_,
               EquilibriumSensitivity::prepare(network_, load.motion, load.loads, positions_, context));
  }
  return &*sensitivity_;
}

std::vector<std::vector<ConstantChange>> NetworkRun::changes() const {
  std::vector<std::vector<ConstantChange>> out(parameters_.size());
  for (std::size_t k = 0; k < out.size(); ++k) {
    const Column& column = shared_->columns[k];
    for (std::size_t i = 0; i < column.constants.size(); ++i) {
      const int c = column.constants[i];
      out[k].push_back({c, shared_->relative(column.weights[i], parameters_[k], factors_[at(c)])});
    }
  }
  return out;
}

void NetworkRun::fill_column(const EquilibriumSensitivity& sensitivity,
                             std::span<const ConstantChange> change, std::span<const Vec3> shift,
                             std::span<double> column) const {
  std::size_t row = 0;
  const auto push = [&](const Vec3& v) {
    for (const double component : {v.x, v.y, v.z}) column[row++] = component;
  };
  for (const int p : shared_->fit.points) push(shift[at(p)]);
  if (shared_->fit.force_groups.empty()) return;
  const std::vector<Vec3> reactions = sensitivity.reactions_along(change, shift);
  for (const std::vector<int>& group : shared_->fit.force_groups) {
    Vec3 sum;
    for (const int p : group) sum += reactions[at(p)];
    push(sum);
  }
}

Result<DenseMatrix> NetworkRun::jacobian(Context& context) const {
  TURGOR_TRY(const EquilibriumSensitivity* const known, sensitivity(context));
  const auto change = changes();
  const std::vector<std::vector<Vec3>> shift = known->along_each(change);
  DenseMatrix out{response_.rows(), change.size(), {}};
  out.values.resize(out.rows * out.columns);
  parallel_for(out.columns, 1, [&](std::size_t k, std::size_t) {
    fill_column(*known, change[k], shift[k], std::span(out.values).subspan(k * out.rows, out.rows));
  });
  return out;
}

std::vector<double> NetworkRun::by_parameter(std::span<const double> by_constant) const {
  std::vector<double> out(parameters_.size());
  parallel_for(out.size(), 1, [&](std::size_t k, std::size_t) {
    const Column& column = shared_->columns[k];
    for (std::size_t i = 0; i < column.constants.size(); ++i) {
      const std::size_t c = at(column.constants[i]);
      out[k] += by_constant[c] * shared_->relative(column.weights[i], parameters_[k], factors_[c]);
    }
  });
  return out;
}

Result<std::vector<double>> NetworkRun::adjoint(std::span<const double> seed, Context& context) const {
  if (seed.size() != response_.rows())
    return bad(fmt::format("a seed of {} numbers is given for {}", seed.size(), response_.rows()),
               "Give one for each number of the response");
  TURGOR_TRY(const EquilibriumSensitivity* const known, sensitivity(context));
  std::vector<Vec3> places(positions_.size()), reactions;
  const double* next = seed.data();
  const auto take = [&] {
    next += 3;
    return Vec3{next[-3], next[-2], next[-1]};
  };
  for (const int p : shared_->fit.points) places[at(p)] += take();
  if (!shared_->fit.force_groups.empty()) reactions.resize(positions_.size());
  for (const std::vector<int>& group : shared_->fit.force_groups) {
    const Vec3 force = take();
    for (const int p : group) reactions[at(p)] += force;
  }
  return by_parameter(known->adjoint(places, reactions));
}

class NetworkModel final : public ForwardModel {
 public:
  explicit NetworkModel(std::shared_ptr<const Shared> shared) : shared_(std::move(shared)) {}
  [[nodiscard]] std::size_t parameter_count() const override { return shared_->columns.size(); }
  [[nodiscard]] std::size_t load_count() const override { return shared_->fit.loads.size(); }
  [[nodiscard]] Result<std::unique_ptr<ForwardRun>> run(std::span<const double> parameters, std::size_t load,
                                                        const ForwardRun* near,
                                                        Context& context) const override;

 private:
  std::shared_ptr<const Shared> shared_;
};

Result<std::unique_ptr<ForwardRun>> NetworkModel::run(std::span<const double> parameters, std::size_t load,
                                                      const ForwardRun* near, Context& context) const {
  const NetworkFit& fit = shared_->fit;
  if (load >= fit.loads.size())
    return bad(fmt::format("there is no load {}", load), "Loads are numbered from 0");
  TURGOR_TRY(std::vector<double> factors, shared_->factors(parameters));
  SpringNetwork network = fit.network;
  scale_constants(network, factors);
  const auto* const neighbour = dynamic_cast<const NetworkRun*>(near);
  // Thousands of runs would fill the caller's list of notices; a failure is told by the error.
  Context quiet({}, {}, [&] { return context.cancelled(); });
  const NetworkLoad& applied = fit.loads[load];
  const std::vector<Vec3>* const start = neighbour != nullptr ? &neighbour->positions() : nullptr;
  TURGOR_TRY(EquilibriumResult rest, applied.rest ? applied.rest(network, fit.options, start, quiet)
                                                  : solve_equilibrium(network, applied.motion, applied.loads,
                                                                      fit.options, quiet, start));
  if (!rest.converged)
    return Error{ErrorKind::not_converged,
                 fmt::format("the body does not come to rest: the relative residual is {:.1e} after {} steps",
                             rest.relative_residual, rest.newton_steps),
                 applied.name, "Use stiffer constants or a smaller load"};
  auto out = std::make_unique<NetworkRun>(shared_, load, std::vector(parameters.begin(), parameters.end()),
                                          std::move(factors), std::move(network), std::move(rest.positions));
  TURGOR_CHECK(out->measure());
  return std::unique_ptr<ForwardRun>(std::move(out));
}

Result<void> check_weights(const ParameterWeights& w, std::size_t constants) {
  if (w.offsets.empty() || w.rows() != constants || w.columns.size() != w.weights.size() ||
      w.offsets.front() != 0 || at(w.offsets.back()) != w.columns.size() ||
      !std::is_sorted(w.offsets.begin(), w.offsets.end()))
    return bad(fmt::format("the weights are not of {} constants", constants),
               "Give a row for each constant of the network");
  if (w.column_count < 0 || at(w.column_count) > w.columns.size())
    return bad(fmt::format("there are {} parameters with {} weights", w.column_count, w.columns.size()),
               "Leave out parameters that touch no constant");
  for (std::size_t i = 0; i < w.columns.size(); ++i) {
    if (w.columns[i] < 0 || w.columns[i] >= w.column_count || !(std::isfinite(w.weights[i])) ||
        w.weights[i] < 0)
      return bad(fmt::format("entry {} of the weights is {} of parameter {}", i, w.weights[i], w.columns[i]),
                 "Weights are at least 0, parameters are numbered from 0");
  }
  return {};
}

Result<void> check_points(std::span<const int> points, std::size_t count) {
  for (const int p : points) {
    if (p < 0 || at(p) >= count)
      return bad(fmt::format("point {} of {} is compared", p, count), "Points are numbered from 0");
  }
  return {};
}

Result<void> check(const NetworkFit& fit) {
  TURGOR_CHECK(validate(fit.network));
  const std::size_t points = fit.network.rest.size();
  TURGOR_CHECK(check_weights(fit.weights, NetworkConstants(fit.network).count()));
  TURGOR_CHECK(check_points(fit.points, points));
  for (const std::vector<int>& group : fit.force_groups) TURGOR_CHECK(check_points(group, points));
  if (fit.loads.empty()) return bad("there are no loads", "Give at least one");
  for (const NetworkLoad& load : fit.loads) {
    TURGOR_CHECK(validate(load.motion, static_cast<int>(points)));
    TURGOR_CHECK(validate(load.loads, points));
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<ForwardModel>> make_forward_model(NetworkFit fit) {
  TURGOR_CHECK(check(fit));
  if (fit.points.empty()) {
    fit.points.resize(fit.network.rest.size());
    std::iota(fit.points.begin(), fit.points.end(), 0);
  }
  auto shared = std::make_shared<Shared>(Shared{std::move(fit), {}});
  const ParameterWeights& w = shared->fit.weights;
  shared->columns.resize(at(w.column_count));
  for (std::size_t c = 0; c < w.rows(); ++c) {
    for (int i = w.offsets[c]; i < w.offsets[c + 1]; ++i) {
      Column& column = shared->columns[at(w.columns[at(i)])];
      column.constants.push_back(static_cast<int>(c));
      column.weights.push_back(w.weights[at(i)]);
    }
  }
  return std::unique_ptr<ForwardModel>(std::make_unique<NetworkModel>(std::move(shared)));
}

}  // namespace turgor
