#include "turgor/world/calibration_case.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "world/calibration_parts.hpp"

namespace turgor {
namespace {

RestRegion beyond(const Vec3& point, const Vec3& normal) {
  RestRegion region;
  region.beyond = Plane::through(point, normal);
  region.where = "t.problem:3:7";
  return region;
}

RestRegion ball(const Vec3& centre, double radius) {
  RestRegion region;
  region.centre = centre, region.radius_mm = radius;
  return region;
}

/// 4 by 2 by 2 cubes of 5 mm, held at x = 0, pulled and bent at x = 20.
CalibrationOptions bar() {
  CalibrationOptions o;
  o.body = BoxBody{{{0, 0, 0}, {20, 10, 10}}, 5};
  o.held = {beyond({0, 0, 0}, {-1, 0, 0})};
  o.reference = {{{.youngs_modulus_mpa = 0.05, .poissons_ratio = 0.4}, {}}};
  const auto at_end = [](const Vec3& force) {
    return CalibrationForce{CalibrationForce::Kind::force, force, beyond({20, 0, 0}, {1, 0, 0})};
  };
  o.loads = {{"pull", false, {at_end({0.2, 0, 0})}, "t.problem:5:1"},
             {"bend", true, {at_end({0, 0, -0.02})}, "t.problem:7:1"}};
  o.model.guess.youngs_modulus_mpa = 0.02;
  o.model.guess.poissons_ratio = 0.3;
  o.fit.coarse_samples = 4;
  o.fit.budget = 20;
  return o;
}

Result<CalibrationCase> prepared(CalibrationOptions options) {
  Context context;
  return CalibrationCase::prepare(std::move(options), context);
}

TEST(CalibrationCase, FillsABoxAndHoldsItsSide) {
  const auto c = prepared(bar());
  ASSERT_TRUE(c) << c.error().message();
  EXPECT_EQ(c->mesh().tetrahedra.size(), 5u * 16);
  EXPECT_EQ(c->mesh().points.size(), 5u * 3 * 3);
  EXPECT_EQ(c->held().size(), 9u);
  Box3 box;
  for (const Vec3& p : c->mesh().points) box.extend(p);
  EXPECT_EQ(box.upper, (Vec3{20, 10, 10}));
  EXPECT_EQ(box.lower, (Vec3{0, 0, 0}));
}

TEST(CalibrationCase, ForcesTractionsAndPressuresAddUp) {
  CalibrationOptions o = bar();
  using Kind = CalibrationForce::Kind;
  const RestRegion end = beyond({20, 0, 0}, {1, 0, 0}), top = beyond({0, 0, 10}, {0, 0, 1});
  o.loads = {{"force", false, {{Kind::force, {0.1, 0.2, 0.3}, ball({20, 5, 5}, 6)}}, ""},
             {"traction", false, {{Kind::traction, {0, 1e-3, 0}, end}}, ""},
             {"pressure", false, {{Kind::pressure, {1e-3, 0, 0}, top}}, ""}};
  const auto c = prepared(o);
  ASSERT_TRUE(c) << c.error().message();
  const auto total = [&](std::size_t l) {
    Vec3 sum;
    for (const Vec3& f : c->loads()[l].force_n) sum += f;
    return sum;
  };
  EXPECT_LT(distance(total(0), {0.1, 0.2, 0.3}), 1e-12);
  EXPECT_LT(distance(total(1), {0, 1e-3 * 100, 0}), 1e-12);
  EXPECT_LT(distance(total(2), {0, 0, -1e-3 * 200}), 1e-12);
}

TEST(CalibrationCase, TheReferenceIsThatOfTheFiniteElements) {
  const auto c = prepared(bar());
  ASSERT_TRUE(c) << c.error().message();
  // N L / (E A) = 0.8 mm, less what the held end keeps from narrowing.
  double mean = 0, count = 0;
  for (std::size_t p = 0; p < c->mesh().points.size(); ++p) {
    if (c->mesh().points[p].x < 19) continue;
    mean += c->loads()[0].reference[p].x - 20, ++count;
  }
  EXPECT_NEAR(mean / count, 0.8, 0.08);
}

TEST(CalibrationCase, MistakesNameThePlaceAndTheRemedy) {
  const auto expect = [](const CalibrationOptions& o, const std::string& where, const std::string& what) {
    const auto c = prepared(o);
    ASSERT_FALSE(c) << what;
    EXPECT_EQ(c.error().where, where);
    EXPECT_NE(c.error().what.find(what), std::string::npos) << c.error().message();
    EXPECT_FALSE(c.error().remedy.empty());
  };
  CalibrationOptions o = bar();
  o.held = {beyond({-1, 0, 0}, {-1, 0, 0})};
  expect(o, "t.problem:3:7", "no points");
  o.held.clear();
  expect(o, "", "nothing holds");
  o.held = {RestRegion{}};
  expect(o, "", "all points");
  o = bar();
  o.loads[0].forces.clear();
  expect(o, "t.problem:5:1", "has no force");
  o = bar();
  o.loads[0].held_out = true;
  expect(o, "", "no load to calibrate with");
  o = bar();
  o.loads[0].forces[0].vector = {};
  expect(o, "t.problem:5:1", "does not move the body");
  o = bar();
  o.reference[0].region = beyond({10, 0, 0}, {1, 0, 0});
  expect(o, "", "no reference material");
  o = bar();
  o.fit.measure = ErrorMeasure::force;
  expect(o, "", "no force is measured");
  o = bar();
  o.loads[0].forces[0].kind = CalibrationForce::Kind::displacement;
  o.loads[0].forces[0].region = beyond({0, 0, 0}, {-1, 0, 0});
  expect(o, "t.problem:3:7", "only points that are held");
  o = bar();
  o.body = BoxBody{{{0, 0, 0}, {1e30, 1, 1}}, 1e-3};
  expect(o, "", "cubes");
  o.body = BoxBody{{{0, 0, 0}, {1, 1, 1}}, std::nan("")};
  expect(o, "", "cubes");
}

TEST(CalibrationCase, EveryElementHasItsStiffness) {
  CalibrationOptions o = bar();
  const auto c = prepared(o);
  ASSERT_TRUE(c) << c.error().message();
  ASSERT_EQ(c->problem().parameters.size(), 3u);
  const SolidConstants uniform = c->stiffness(std::array{0.1, 0.02, 0.3});
  ASSERT_EQ(uniform[0].size(), c->elements().edges.size());
  ASSERT_EQ(uniform[2].size(), c->mesh().tetrahedra.size());
  for (const double k : uniform[0]) EXPECT_NEAR(k, 0.1, 1e-12);
  for (const double k : uniform[1]) EXPECT_NEAR(k, 0.02, 1e-12);
  for (const double k : uniform[2]) EXPECT_NEAR(k, 0.3, 1e-12);
  const FitParameter& first = c->problem().parameters[0];
  EXPECT_EQ(first.name, "k_d");
  EXPECT_DOUBLE_EQ(first.low, 0.01 * first.guess);
  EXPECT_DOUBLE_EQ(first.high, 100 * first.guess);
}

TEST(CalibrationCase, InOneProportionNodesScaleAllConstants) {
  CalibrationOptions o = bar();
  o.model.grid = {3, 1, 1};
  o.model.proportional = true;
  const auto c = prepared(o);
  ASSERT_TRUE(c) << c.error().message();
  ASSERT_EQ(c->problem().parameters.size(), 3u + 3u);
  std::vector<double> parameters = c->guess();
  const SolidConstants guess = c->stiffness(parameters);
  for (std::size_t node = 0; node < 3; ++node) parameters[node] *= 2;
  const SolidConstants doubled = c->stiffness(parameters);
  const SolidStiffness closed = stiffness_of(o.model.guess);
  EXPECT_NEAR(guess[0][0], closed.length, 1e-12);
  EXPECT_NEAR(guess[1][0], closed.area, 1e-12);
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (std::size_t e = 0; e < guess[kind].size(); ++e)
      EXPECT_NEAR(doubled[kind][e], 2 * guess[kind][e], 1e-12 * doubled[kind][e]);
  }
}

TEST(CalibrationCase, ProbesPressWhereOtherLoadsMoveLittle) {
  CalibrationOptions o = bar();
  o.body = BoxBody{{{0, 0, 0}, {40, 10, 10}}, 2.5};
  o.held = {beyond({0, 0, 0}, {-1, 0, 0}), beyond({40, 0, 0}, {1, 0, 0})};
  // Held at both ends and pressed near one of them: the other half is still.
  o.loads = {{"press", false, {{CalibrationForce::Kind::force, {0, 0, -0.05}, ball({10, 5, 10}, 3)}}, ""}};
  o.probes = {.loads = 2, .held_out = true, .candidates = 24, .depth = 0.04};
  const auto c = prepared(o);
  ASSERT_TRUE(c) << c.error().message();
  ASSERT_EQ(c->loads().size(), 3u);
  const PreparedLoad& probe = c->loads()[1];
  EXPECT_EQ(probe.name, "probe 1");
  EXPECT_TRUE(probe.held_out);
  Vec3 sum, place;
  double count = 0, deepest = 0;
  for (std::size_t p = 0; p < probe.force_n.size(); ++p) {
    if (probe.force_n[p] == Vec3{}) continue;
    sum += probe.force_n[p], place += c->mesh().points[p], ++count;
  }
  place /= count;
  EXPECT_GT(place.x, 20);
  EXPECT_GT(dot(sum, Vec3{20, 5, 5} - place), 0) << "into the body";
  for (std::size_t p = 0; p < probe.reference.size(); ++p)
    deepest = std::max(deepest, distance(probe.reference[p], c->mesh().points[p]));
  EXPECT_NEAR(deepest, 0.04 * 40, 0.02);
  const auto again = prepared(o);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->loads()[2].force_n, c->loads()[2].force_n);
}

TEST(CalibrationCase, GaussNewtonBringsTheBarToItsReference) {
  const auto c = prepared(bar());
  ASSERT_TRUE(c) << c.error().message();
  Context context;
  auto fit = calibrate(c->problem(), c->options().fit, context);
  ASSERT_TRUE(fit) << fit.error().message();
  EXPECT_LT(fit->error, 0.1 * fit->guess_error);
  const auto outcome = outcome_of(*c, *std::move(fit), context);
  ASSERT_TRUE(outcome) << outcome.error().message();
  ASSERT_EQ(outcome->loads.size(), 2u);
  EXPECT_EQ(outcome->stiffness[2].size(), c->mesh().tetrahedra.size());
  EXPECT_LT(outcome->fit.loads[1].after, outcome->fit.loads[1].before) << "carries over";
  double squares = 0;
  for (std::size_t p = 0; p < c->mesh().points.size(); ++p) {
    const double d = distance(outcome->loads[0].calibrated[p], c->loads()[0].reference[p]);
    squares += d * d;
  }
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(c->mesh().points.size())), outcome->fit.error,
              0.05 * outcome->fit.error);
}

TEST(CalibrationCase, TheSameOnAnyNumberOfThreads) {
  CalibrationOptions o = bar();
  o.probes.loads = 1;
  o.fit.method = FitMethod::cma_es;
  std::vector<std::vector<double>> found;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    const auto c = prepared(o);
    ASSERT_TRUE(c) << c.error().message();
    Context context;
    const auto fit = calibrate(c->problem(), o.fit, context);
    ASSERT_TRUE(fit) << fit.error().message();
    found.push_back(fit->parameters);
  }
  set_thread_count(0);
  EXPECT_EQ(found[0], found[1]);
}

TEST(CalibrationCase, MeasuresTheForceOnDisplacedPoints) {
  CalibrationOptions o = bar();
  o.loads = {{"press",
              false,
              {{CalibrationForce::Kind::displacement, {-1, 0, 0}, beyond({20, 0, 0}, {1, 0, 0})}},
              ""}};
  o.fit.measure = ErrorMeasure::force;
  const auto c = prepared(o);
  ASSERT_TRUE(c) << c.error().message();
  const auto& force = c->problem().loads[0].reference.force_n;
  ASSERT_EQ(force.size(), 3u);
  // E A / L times 1 mm, and what the held ends add.
  EXPECT_LT(force[0], -0.25);
  EXPECT_GT(force[0], -0.35);
  Context context;
  const auto fit = calibrate(c->problem(), o.fit, context);
  ASSERT_TRUE(fit) << fit.error().message();
  EXPECT_LT(fit->error, 0.01 * fit->guess_error);
}

}  // namespace
}  // namespace turgor
