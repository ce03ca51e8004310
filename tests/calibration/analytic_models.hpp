// Forward models whose responses and derivatives are formulas.
#pragma once

#include <atomic>
#include <cmath>
#include <functional>
#include <optional>

#include "turgor/calibration/calibrate.hpp"

namespace turgor::testing_models {

/// A response and its derivatives, rows of a Jacobian by parameter.
struct Formula {
  Response response;
  DenseMatrix jacobian;

  explicit Formula(std::size_t parameters) { jacobian.columns = parameters; }
};

/// Fills a formula from scalars in order, three to a point, with their gradients.
inline Formula points_from(const std::vector<double>& values,
                           const std::vector<std::vector<double>>& gradients, std::size_t parameters) {
  Formula out(parameters);
  const std::size_t points = (values.size() + 2) / 3;
  out.response.position_mm.resize(points);
  out.jacobian.rows = 3 * points;
  out.jacobian.values.assign(3 * points * parameters, 0.0);
  for (std::size_t row = 0; row < values.size(); ++row) {
    out.response.position_mm[row / 3][static_cast<int>(row % 3)] = values[row];
    for (std::size_t p = 0; p < parameters; ++p)
      out.jacobian.values[p * 3 * points + row] = gradients[row][p];
  }
  return out;
}

class FormulaRun : public ForwardRun {
 public:
  FormulaRun(Formula formula, bool differentiable)
      : formula_(std::move(formula)), differentiable_(differentiable) {}
  [[nodiscard]] const Response& response() const override { return formula_.response; }
  [[nodiscard]] Result<DenseMatrix> jacobian(Context& /*context*/) const override {
    if (!differentiable_) return Error{ErrorKind::bad_input, "no derivatives"};
    return formula_.jacobian;
  }
  [[nodiscard]] Result<std::vector<double>> adjoint(std::span<const double> seed,
                                                    Context& context) const override {
    TURGOR_TRY(const DenseMatrix j, jacobian(context));
    std::vector<double> out(j.columns, 0.0);
    for (std::size_t c = 0; c < j.columns; ++c) {
      for (std::size_t r = 0; r < j.rows; ++r) out[c] += j.values[c * j.rows + r] * seed[r];
    }
    return out;
  }

 private:
  Formula formula_;
  bool differentiable_;
};

/// `formula` gives nothing where the body does not come to rest.
class FormulaModel : public ForwardModel {
 public:
  using Function = std::function<std::optional<Formula>(std::span<const double>, std::size_t load)>;
  FormulaModel(std::size_t parameters, std::size_t loads, Function formula, bool differentiable = true)
      : parameters_(parameters),
        loads_(loads),
        formula_(std::move(formula)),
        differentiable_(differentiable) {}

  [[nodiscard]] std::size_t parameter_count() const override { return parameters_; }
  [[nodiscard]] std::size_t load_count() const override { return loads_; }
  [[nodiscard]] Result<std::unique_ptr<ForwardRun>> run(std::span<const double> parameters, std::size_t load,
                                                        const ForwardRun* /*near*/,
                                                        Context& context) const override {
    TURGOR_CHECK(context.check());
    ++runs;
    auto formula = formula_(parameters, load);
    if (!formula) return Error{ErrorKind::not_converged, "the body swings on"};
    return std::unique_ptr<ForwardRun>(std::make_unique<FormulaRun>(*std::move(formula), differentiable_));
  }

  mutable std::atomic<int> runs{0};

 private:
  std::size_t parameters_, loads_;
  Function formula_;
  bool differentiable_;
};

/// Springs in a row from a wall, of the stiffnesses given (N/mm): load `l` pulls at node l mod n and at the
/// end. Places are those along the row; the measured force is what holds the end at 1 mm.
inline Formula spring_chain(std::span<const double> stiffness, std::size_t load) {
  const std::size_t n = stiffness.size();
  Formula out(n);
  out.response.position_mm.resize(n);
  out.jacobian.rows = 3 * n + 1;
  out.jacobian.values.assign(out.jacobian.rows * n, 0.0);
  const std::size_t pulled = load % n;
  double place = 0, compliance = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double tension = i <= pulled ? 3 : 1;
    place += 10 + tension / stiffness[i];
    compliance += 1 / stiffness[i];
    out.response.position_mm[i] = {place, static_cast<double>(i % 2), 0};
    for (std::size_t p = 0; p <= i; ++p) {
      const double pull = p <= pulled ? 3 : 1;
      out.jacobian.values[p * out.jacobian.rows + 3 * i] = -pull / (stiffness[p] * stiffness[p]);
    }
  }
  out.response.force_n = {1 / compliance};
  for (std::size_t p = 0; p < n; ++p)
    out.jacobian.values[p * out.jacobian.rows + 3 * n] =
        1 / (compliance * compliance * stiffness[p] * stiffness[p]);
  return out;
}

/// Rosenbrock's valley as a residual (1 − x, 10 (y − x²)), with its least at (1, 1); no rest where x + y is
/// less than −½ nor in a disc that lies across the valley's wall.
inline std::optional<Formula> rosenbrock(std::span<const double> p) {
  const double x = p[0], y = p[1];
  if (x + y < -0.5 || (x - 0.2) * (x - 0.2) + (y - 0.8) * (y - 0.8) < 0.04) return std::nullopt;
  return points_from({1 - x, 10 * (y - x * x), 0}, {{-1, 0}, {-20 * x, 10}, {0, 0}}, 2);
}

inline FitParameter linear(double low, double high, double guess) {
  return {"p", "", low, high, guess, false};
}
inline FitParameter logarithmic(double low, double high, double guess) {
  return {"k", "N/mm", low, high, guess, true};
}

}  // namespace turgor::testing_models
