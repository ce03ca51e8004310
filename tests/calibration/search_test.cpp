// How a calibration goes: samples in order, stops, threads, seeds, farms, and what it refuses.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "calibration/analytic_problems.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

using namespace testing_models;

TEST(Calibrate, SamplesAndListenerTellTheSearchInOrder) {
  for (const FitMethod method : all_methods) {
    const Valley valley;
    std::vector<FitSample> told;
    const Fit fit = fit_of(valley.problem, options_of(method, 150), nullptr,
                           [&](const FitSample& sample, std::span<const double> best) {
                             told.push_back(sample);
                             EXPECT_EQ(best.size(), std::isfinite(sample.best) ? 2U : 0U);
                           });
    ASSERT_EQ(told.size(), fit.samples.size());
    EXPECT_LE(fit.samples.size(), 1U + 20U + 150U) << name_of(method);
    EXPECT_GT(fit.samples.size(), 21U) << name_of(method);
    double best = infinity;
    int failed = 0;
    for (std::size_t i = 0; i < told.size(); ++i) {
      best = std::min(best, told[i].error);
      failed += std::isinf(told[i].error) ? 1 : 0;
      EXPECT_EQ(told[i].best, best);
      EXPECT_EQ(told[i].error, fit.samples[i].error);
      EXPECT_EQ(told[i].stage, i == 0   ? FitSample::Stage::guess
                               : i < 21 ? FitSample::Stage::coarse
                                        : FitSample::Stage::search);
    }
    EXPECT_EQ(fit.failed, failed);
    EXPECT_NEAR(fit.error, best, 1e-12 * best);
  }
}

TEST(Calibrate, RandomSamplesGoOnUntilTheBodyRests) {
  // Rest in a hundredth of the space alone, away from guess and a single coarse sample.
  const FormulaModel model(1, 1, [](std::span<const double> p, std::size_t) -> std::optional<Formula> {
    if (std::abs(p[0] - 0.737) > 0.005) return std::nullopt;
    return points_from({p[0], 0, 0}, {{1}, {0}, {0}}, 1);
  });
  const CalibrationProblem problem{&model, {linear(0, 1, 0.1)}, {{"", {{{0.737, 0, 0}}, {}}, {}}}};
  for (const FitMethod method : all_methods) {
    FitOptions options = options_of(method);
    options.coarse_samples = 1;
    const Fit fit = fit_of(problem, options);
    EXPECT_NEAR(fit.parameters[0], 0.737, 1e-3) << name_of(method);
    EXPECT_TRUE(std::isinf(fit.guess_error));
  }
}

TEST(Calibrate, ABodyThatNeverRestsIsAnErrorThatSaysWhy) {
  const FormulaModel model(1, 1,
                           [](std::span<const double>, std::size_t) { return std::optional<Formula>{}; });
  const CalibrationProblem problem{&model, {linear(0, 1, 0.1)}, {{"", {{{0, 0, 0}}, {}}, {}}}};
  Context context;
  const auto fit = calibrate(problem, options_of(FitMethod::cma_es, 30), context);
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().kind, ErrorKind::not_converged);
  EXPECT_NE(fit.error().message().find("51 sets"), std::string::npos) << fit.error().message();
  EXPECT_NE(fit.error().message().find("the body swings on"), std::string::npos);
}

TEST(Calibrate, AStopKeepsTheBestAtAnyTime) {
  for (const FitMethod method : all_methods) {
    for (const int after : {1, 5, 23, 26}) {
      const Valley valley;
      Context context({}, {}, [&] { return valley.model.runs >= after; });
      const auto fit = calibrate(valley.problem, options_of(method, 1000), context);
      ASSERT_TRUE(fit) << name_of(method) << ' ' << after;
      EXPECT_TRUE(fit->stopped) << name_of(method) << ' ' << after;
      EXPECT_LE(valley.model.runs, after + 2) << "and is prompt";
      EXPECT_LE(fit->error, fit->guess_error);
      EXPECT_NEAR(fit->error, fit->samples.back().best, 1e-12);
    }
    const Valley valley;
    Context stopped({}, {}, [] { return true; });
    const auto fit = calibrate(valley.problem, options_of(method), stopped);
    ASSERT_FALSE(fit);
    EXPECT_EQ(fit.error().kind, ErrorKind::cancelled) << "there is nothing to keep yet";
  }
}

TEST(Calibrate, IsTheSameBitsOnAnyNumberOfThreads) {
  // Runs have parallel loops of their own, within those over samples.
  const FormulaModel model(2, 1, [](std::span<const double> p, std::size_t) {
    const double sum =
        parallel_sum(1000, 10, [&](std::size_t i) { return p[0] / static_cast<double>(i + 1); });
    return rosenbrock(std::vector<double>{p[0] + 1e-9 * sum, p[1]});
  });
  for (const FitMethod method : all_methods) {
    Valley valley;
    valley.problem.model = &model;
    std::vector<Fit> fits;
    for (const int threads : {1, 2, 4}) {
      set_thread_count(threads);
      fits.push_back(fit_of(valley.problem, options_of(method, 300)));
      set_thread_count(0);
    }
    for (const Fit& fit : fits) {
      EXPECT_EQ(fit.parameters, fits[0].parameters) << name_of(method);
      EXPECT_EQ(fit.error, fits[0].error);
      ASSERT_EQ(fit.samples.size(), fits[0].samples.size());
      for (std::size_t i = 0; i < fit.samples.size(); ++i)
        EXPECT_EQ(fit.samples[i].error, fits[0].samples[i].error) << name_of(method) << ' ' << i;
    }
  }
}

TEST(Calibrate, SeedsDecideTheSearch) {
  for (const FitMethod method : {FitMethod::cma_es, FitMethod::annealing}) {
    const Valley valley;
    FitOptions options = options_of(method, 100);
    const Fit first = fit_of(valley.problem, options);
    options.seed = 2;
    EXPECT_NE(fit_of(valley.problem, options).parameters, first.parameters);
  }
}

TEST(Calibrate, AFarmDoesTheSamplesAndItsFaultEndsTheSearch) {
  class CountingFarm : public SampleFarm {
   public:
    CountingFarm(std::unique_ptr<SampleFarm> inner, int until) : inner_(std::move(inner)), until_(until) {}
    [[nodiscard]] int width() const override { return 3; }
    Result<std::vector<double>> errors(std::span<const std::vector<double>> parameters,
                                       Context& context) override {
      done += static_cast<int>(parameters.size());
      if (done > until_) return Error{ErrorKind::system, "a process is gone"};
      return inner_->errors(parameters, context);
    }
    int done = 0;

   private:
    std::unique_ptr<SampleFarm> inner_;
    int until_;
  };
  for (const FitMethod method : {FitMethod::cma_es, FitMethod::annealing}) {
    const Valley valley;
    const Fit alone = fit_of(valley.problem, options_of(method, 200));
    CountingFarm farm(make_thread_farm(make_sample_error(valley.problem, ErrorMeasure::distance)), 10000);
    const Fit farmed = fit_of(valley.problem, options_of(method, 200), &farm);
    EXPECT_EQ(alone.parameters, farmed.parameters);
    EXPECT_EQ(farm.done + 1, static_cast<int>(farmed.samples.size()));
    CountingFarm broken(make_thread_farm(make_sample_error(valley.problem, ErrorMeasure::distance)), 90);
    Context context;
    const auto fit = calibrate(valley.problem, options_of(method, 200), context, &broken);
    ASSERT_FALSE(fit);
    EXPECT_EQ(fit.error().kind, ErrorKind::system);
  }
}

TEST(Calibrate, ATinyBudgetIsKept) {
  for (const FitMethod method : all_methods) {
    const Valley valley;
    FitOptions options = options_of(method, 1);
    options.coarse_samples = 0;
    const Fit fit = fit_of(valley.problem, options);
    EXPECT_EQ(fit.samples.size(), 2U) << name_of(method);
    EXPECT_LE(fit.error, fit.guess_error);
  }
}

TEST(Calibrate, WhatCannotBeUsedIsAnError) {
  const auto refused = [](const auto& spoil) {
    Chain chain;
    FitOptions options;
    spoil(chain.problem, options);
    Context context;
    const auto fit = calibrate(chain.problem, options, context);
    return !fit && fit.error().kind == ErrorKind::bad_input && chain.model.runs < 4;
  };
  using P = CalibrationProblem;
  using O = FitOptions;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](P& p, O&) { p.model = nullptr; }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters.pop_back(); }));
  EXPECT_TRUE(refused([](P& p, O&) { p.loads.pop_back(); }));
  EXPECT_TRUE(refused([](P& p, O&) {
    for (auto& load : p.loads) load.fitted = false;
  }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0].low = 0; }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0].high = infinity; }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0].guess = nan; }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0].guess = 100; }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0] = linear(-1.7e308, 1.7e308, 0); }));
  EXPECT_TRUE(refused([](P& p, O&) { p.parameters[0] = linear(1, 1, 1); }));
  EXPECT_TRUE(refused([](P& p, O&) { p.loads[0].reference.position_mm.pop_back(); }));
  EXPECT_TRUE(refused([](P& p, O&) { p.loads[0].weight = {1, 2}; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.budget = 0; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.budget = 2147483647; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.coarse_samples = -1; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.coarse_samples = 2147483647; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.chains = 0; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.regularisation = -1; }));
  EXPECT_TRUE(refused([](P&, O& o) { o.regularisation = nan; }));
}

}  // namespace
}  // namespace turgor
