// What a calibration finds: parameters, errors and deviations.
#include "turgor/calibration/calibrate.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "calibration/analytic_problems.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

using namespace testing_models;

TEST(Calibrate, EachMethodFindsTheSpringsOfAChain) {
  for (const FitMethod method : all_methods) {
    const Chain chain;
    const Fit fit = fit_of(chain.problem, options_of(method, 4000));
    const bool derivatives = method == FitMethod::gauss_newton || method == FitMethod::gradient;
    // As docs/models.md states them: of the search alone, and the worst stiffness at its end.
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i)
      worst = std::max(worst, std::abs(fit.parameters[i] / chain.truth[i] - 1));
    const std::string name(name_of(method));
    RecordProperty(name + "_samples", static_cast<int>(std::ranges::count(
                                          fit.samples, FitSample::Stage::search, &FitSample::stage)));
    RecordProperty(name + "_worst", fmt::format("{:.1e}", worst));
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(fit.parameters[i] / chain.truth[i], 1, derivatives ? 1e-5 : 0.03) << name_of(method);
    EXPECT_LT(fit.error, 1e-2 * fit.guess_error) << name_of(method);
    EXPECT_FALSE(fit.stopped);
  }
}

TEST(Calibrate, NewtonsWayIsShort) {
  const Chain chain;
  const Fit fit = fit_of(chain.problem, options_of(FitMethod::gauss_newton));
  EXPECT_LT(fit.error, 1e-12);
  EXPECT_LT(fit.samples.size(), 21U + 20U);
}

TEST(Calibrate, EachMethodFindsTheEndOfAValleyWithFailuresAcross) {
  for (const FitMethod method : all_methods) {
    const Valley valley;
    const Fit fit = fit_of(valley.problem, options_of(method, 6000));
    // Moves along one coordinate at a time are slow in a curved valley.
    const double tolerance = method == FitMethod::annealing ? 0.2 : 1e-3;
    EXPECT_NEAR(fit.parameters[0], 1, tolerance) << name_of(method);
    EXPECT_NEAR(fit.parameters[1], 1, 2 * tolerance) << name_of(method);
    EXPECT_GT(fit.failed, 0) << name_of(method);
  }
}

TEST(Calibrate, AnExponentialFitIsFoundByShapeOfItsCurve) {
  // y = a exp(−b t) at t = 0 … 3, x = t, turned and moved as a whole: shape alone.
  const auto curve = [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    std::vector<double> values;
    std::vector<std::vector<double>> gradients;
    for (int i = 0; i < 13; ++i) {
      const double t = 0.25 * i, e = std::exp(-p[1] * t);
      values.insert(values.end(), {t, p[0] * e, 0.1 * i * i});
      gradients.insert(gradients.end(), {{0, 0}, {e, -t * p[0] * e}, {0, 0}});
    }
    return points_from(values, gradients, 2);
  };
  const FormulaModel model(2, 1, curve);
  Response reference = curve(std::vector<double>{3, 1.5}, 0)->response;
  const auto motion = RigidTransform::rotate_about({1, 2, 3}, normalized(Vec3{3, 1, 1}), 0.8);
  for (Vec3& p : reference.position_mm) p = motion.point(p);
  const CalibrationProblem problem{
      &model, {logarithmic(0.1, 100, 0.5), logarithmic(0.01, 10, 0.3)}, {{"", reference, {}}}};
  for (const FitMethod method : {FitMethod::gauss_newton, FitMethod::gradient, FitMethod::cma_es}) {
    FitOptions options = options_of(method);
    options.measure = ErrorMeasure::shape;
    const Fit fit = fit_of(problem, options);
    EXPECT_NEAR(fit.parameters[0], 3, 1e-4) << name_of(method);
    EXPECT_NEAR(fit.parameters[1], 1.5, 1e-4) << name_of(method);
  }
}

TEST(Calibrate, ForcesAreFittedWhereTheyAreMeasured) {
  Chain chain;
  for (auto& p : chain.problem.parameters) p.low = 0.4, p.guess = 1;
  for (const FitMethod method : {FitMethod::gauss_newton, FitMethod::gradient}) {
    FitOptions options = options_of(method);
    options.measure = ErrorMeasure::force;
    const Fit fit = fit_of(chain.problem, options);
    double compliance = 0;
    for (const double k : fit.parameters) compliance += 1 / k;
    EXPECT_NEAR(compliance, 1 / 2.0 + 1 / 0.5 + 1 / 8.0, 1e-6) << name_of(method);
    EXPECT_TRUE(fit.deviation.empty()) << "two forces for three springs";
    EXPECT_DOUBLE_EQ(fit.loads[0].reference, 1 / 2.625);
  }
}

TEST(Calibrate, BoundsHoldToTheLastBit) {
  for (const FitMethod method : all_methods) {
    Chain chain;
    chain.problem.parameters[1] = logarithmic(0.7, 50, 1);
    const Fit fit = fit_of(chain.problem, options_of(method));
    EXPECT_GE(fit.parameters[1], 0.7) << name_of(method);
    EXPECT_NEAR(fit.parameters[1], 0.7, 0.02) << name_of(method);
    if (method == FitMethod::gauss_newton) {
      EXPECT_EQ(fit.parameters[1], 0.7);
    }
  }
}

TEST(Calibrate, SeveralLoadsAreFittedToTheMeanOfTheirErrors) {
  // Errors √((p − a)² + c²)/√1 of two loads pull with other weight than their squares do.
  const auto formula = [](std::span<const double> p, std::size_t load) -> std::optional<Formula> {
    return points_from(
        load == 0 ? std::vector<double>{p[0], 0.1, 0} : std::vector<double>{3 * p[0] - 6, 4, 0},
        load == 0 ? std::vector<std::vector<double>>{{1}, {0}, {0}}
                  : std::vector<std::vector<double>>{{3}, {0}, {0}},
        1);
  };
  const FormulaModel model(1, 2, formula);
  const CalibrationProblem problem{
      &model, {linear(-5, 5, 4)}, {{"", {{{0, 0, 0}}, {}}, {}}, {"", {{{0, 0, 0}}, {}}, {}}}};
  double best = 0, least = infinity;
  for (int i = 0; i <= 500000; ++i) {
    const double p = 4e-6 * i, error = 0.5 * (std::hypot(p, 0.1) + std::hypot(3 * p - 6, 4));
    if (error < least) least = error, best = p;
  }
  for (const FitMethod method : {FitMethod::gauss_newton, FitMethod::gradient, FitMethod::cma_es}) {
    const Fit fit = fit_of(problem, options_of(method));
    // Newton's way ends where steps gain less than a thousandth of the error.
    const bool ends_early = method == FitMethod::gauss_newton;
    EXPECT_NEAR(fit.parameters[0], best, ends_early ? 5e-3 : 2e-5) << name_of(method);
    EXPECT_NEAR(fit.error, least, ends_early ? 1e-5 : 1e-9) << name_of(method);
  }
}

// Two parameters whose sum is known far better than their difference: the whole step goes out of opposite
// bounds, and ends uphill when it is put there.
TEST(Calibrate, NewtonsWayGoesOnWhereBoundsSpoilAWholeStep) {
  const auto formula = [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    return points_from({p[0] + p[1] - 1.8, 0.1 * (p[0] - p[1] - 5), 0}, {{1, 1}, {0.1, -0.1}, {0, 0}}, 2);
  };
  const FormulaModel model(2, 1, formula);
  const CalibrationProblem problem{
      &model, {linear(0, 1, 0.9), linear(0, 1, 0.9)}, {{"", {{{0, 0, 0}}, {}}, {}}}};
  FitOptions options = options_of(FitMethod::gauss_newton);
  options.coarse_samples = 0;
  const Fit fit = fit_of(problem, options);
  EXPECT_EQ(fit.parameters[0], 1);
  EXPECT_NEAR(fit.parameters[1], 0.76 / 1.01, 1e-3);
}

TEST(Calibrate, NewtonsWayEndsWhereStepsGainNothing) {
  // The error falls towards 1 for ever.
  const auto formula = [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    return points_from({1 + std::exp(-p[0]), 0, 0}, {{-std::exp(-p[0])}, {0}, {0}}, 1);
  };
  const FormulaModel model(1, 1, formula);
  const CalibrationProblem problem{&model, {linear(0, 40, 0)}, {{"", {{{0, 0, 0}}, {}}, {}}}};
  FitOptions options = options_of(FitMethod::gauss_newton);
  options.coarse_samples = 0;
  const Fit fit = fit_of(problem, options);
  EXPECT_LT(fit.error, 1.001);
  EXPECT_LT(fit.samples.size(), 15U);
}

TEST(Calibrate, RegularisationHoldsNearTheGuess) {
  const Chain chain;
  const auto objective = [&](const std::vector<double>& k, double weight) {
    double error = 0, distance = 0;
    for (std::size_t load = 0; load < 2; ++load)
      error +=
          *response_error(chain.problem.loads[load], spring_chain(k, load).response, ErrorMeasure::distance) /
          2;
    for (const double one : k) distance += std::log(one) * std::log(one);
    return error + weight * distance;
  };
  for (const FitMethod method : {FitMethod::gauss_newton, FitMethod::gradient}) {
    FitOptions options = options_of(method);
    options.regularisation = 0.3;
    const Fit fit = fit_of(chain.problem, options);
    const double least = objective(fit.parameters, 0.3);
    EXPECT_GT(fit.error, 0.01) << name_of(method);
    for (std::size_t i = 0; i < 3; ++i) {
      for (const double factor : {0.99, 1.01}) {
        auto other = fit.parameters;
        other[i] *= factor;
        EXPECT_GT(objective(other, 0.3), least) << name_of(method);
      }
    }
  }
}

TEST(Calibrate, LoadsThatAreNotFittedAreMeasuredAndTheGuessToo) {
  Chain chain;
  for (auto& load : chain.problem.loads) load.rest_mm = {{10, 0, 0}, {20, 1, 0}, {30, 0, 0}};
  const Fit fit = fit_of(chain.problem, options_of(FitMethod::gauss_newton));
  ASSERT_EQ(fit.loads.size(), 3U);
  for (std::size_t load = 0; load < 3; ++load) {
    const auto before =
        response_error(chain.problem.loads[load], spring_chain(std::vector<double>(3, 1.0), load).response,
                       ErrorMeasure::distance);
    EXPECT_NEAR(fit.loads[load].before, *before, 1e-12);
    EXPECT_LT(fit.loads[load].after, 1e-10);
  }
  EXPECT_NEAR(fit.guess_error, (fit.loads[0].before + fit.loads[1].before) / 2, 1e-12);
  // Load 0: tensions 3, 1, 1 on 2, 0.5, 8.
  EXPECT_NEAR(fit.loads[0].reference, std::sqrt((1.5 * 1.5 + 3.5 * 3.5 + 3.625 * 3.625) / 3), 1e-12);
}

// y = p₀ + p₁ t with noise: variances in closed form.
TEST(Calibrate, DeviationIsThatOfLinearRegression) {
  constexpr int points = 40;
  const auto line = [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    Formula out(2);
    for (int i = 0; i < points; ++i) out.response.force_n.push_back(p[0] + p[1] * 0.1 * i);
    out.jacobian.rows = points;
    out.jacobian.values.assign(points, 1.0);
    for (int i = 0; i < points; ++i) out.jacobian.values.push_back(0.1 * i);
    return out;
  };
  const FormulaModel model(2, 1, line);
  Response reference;
  const RandomStream random(5);
  double mean_t = 0, mean_y = 0, tt = 0, ty = 0, squares = 0;
  for (std::uint64_t i = 0; i < points; ++i)
    reference.force_n.push_back(2 + 0.7 * 0.1 * static_cast<double>(i) + 0.05 * random.normal(i));
  for (int i = 0; i < points; ++i) {
    mean_t += 0.1 * i / points;
    mean_y += reference.force_n[static_cast<std::size_t>(i)] / points;
  }
  for (int i = 0; i < points; ++i) {
    const double t = 0.1 * i - mean_t;
    tt += t * t;
    ty += t * (reference.force_n[static_cast<std::size_t>(i)] - mean_y);
  }
  const double slope = ty / tt, offset = mean_y - slope * mean_t;
  for (int i = 0; i < points; ++i) {
    const double r = reference.force_n[static_cast<std::size_t>(i)] - offset - slope * 0.1 * i;
    squares += r * r;
  }
  const double noise = std::sqrt(squares / (points - 2));

  const CalibrationProblem problem{&model, {linear(-10, 10, 0), linear(-10, 10, 0)}, {{"", reference, {}}}};
  FitOptions options = options_of(FitMethod::gauss_newton);
  options.measure = ErrorMeasure::force;
  const Fit fit = fit_of(problem, options);
  EXPECT_NEAR(fit.parameters[0], offset, 1e-8);
  EXPECT_NEAR(fit.parameters[1], slope, 1e-8);
  ASSERT_EQ(fit.deviation.size(), 2U);
  EXPECT_NEAR(fit.deviation[0], noise * std::sqrt(1.0 / points + mean_t * mean_t / tt), 1e-8);
  EXPECT_NEAR(fit.deviation[1], noise / std::sqrt(tt), 1e-8);
}

TEST(Calibrate, DeviationOfAnIdleParameterIsInfinite) {
  const FormulaModel model(2, 1, [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    return points_from({p[0], 2 * p[0], 0.5}, {{1, 0}, {2, 0}, {0, 0}}, 2);
  });
  const CalibrationProblem problem{
      &model, {logarithmic(0.1, 10, 1), logarithmic(0.1, 10, 1)}, {{"", {{{2, 4.1, 0}}, {}}, {}}}};
  const Fit fit = fit_of(problem, options_of(FitMethod::gauss_newton));
  ASSERT_EQ(fit.deviation.size(), 2U);
  EXPECT_NEAR(fit.parameters[0], 2.04, 1e-8);
  // Of p: residual √((0.04² + 0.02² + 0.5²)/(3 − 2)) over √5; of its logarithm that over p.
  EXPECT_NEAR(fit.deviation[0], std::sqrt((0.0016 + 0.0004 + 0.25) / 5) / 2.04, 1e-8);
  EXPECT_EQ(fit.deviation[1], infinity);
}

TEST(Calibrate, AModelWithoutDerivativesIsFittedByTheOthersWithoutDeviation) {
  const FormulaModel model(
      2, 1, [](std::span<const double> p, std::size_t) { return rosenbrock(p); }, false);
  CalibrationProblem problem = Valley().problem;
  problem.model = &model;
  for (const FitMethod method : all_methods) {
    Context context;
    const auto fit = calibrate(problem, options_of(method, 500), context);
    const bool needed = method == FitMethod::gauss_newton || method == FitMethod::gradient;
    EXPECT_EQ(static_cast<bool>(fit), !needed) << name_of(method);
    if (fit) {
      EXPECT_TRUE(fit->deviation.empty());
    }
  }
}

// As many as three constants on 9 × 3 × 3 nodes: time goes into samples, not into the search.
TEST(Calibrate, HundredsOfParametersAreFitted) {
  constexpr std::size_t count = 243;
  const FormulaModel model(count, 1,
                           [](std::span<const double> k, std::size_t load) { return spring_chain(k, load); });
  std::vector<double> truth;
  for (std::size_t i = 0; i < count; ++i) truth.push_back(std::exp(std::sin(0.1 * static_cast<double>(i))));
  CalibrationProblem problem{&model, {}, {{"", spring_chain(truth, 0).response, {}}}};
  problem.parameters.assign(count, logarithmic(0.05, 50, 1));
  for (const FitMethod method : all_methods) {
    const Fit fit = fit_of(problem, options_of(method, 300));
    const double part = method == FitMethod::gauss_newton ? 1e-8 : method == FitMethod::gradient ? 1e-3 : 1;
    EXPECT_LT(fit.error, part * fit.guess_error) << name_of(method);
  }
}

}  // namespace
}  // namespace turgor
