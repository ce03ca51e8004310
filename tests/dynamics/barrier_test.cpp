#include "turgor/dynamics/barrier.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "turgor/core/random.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

constexpr std::array kShapes = {Barrier::Shape::sphere, Barrier::Shape::plane, Barrier::Shape::depth_map,
                                Barrier::Shape::mesh};

/// A ball of radius 10 mm about (1, 2, 3), as a mesh of many flat faces.
TriMesh ball() {
  constexpr int rings = 12, sectors = 20;
  TriMesh mesh;
  const auto add = [&](double polar, double azimuth) {
    mesh.points.push_back(Vec3{1, 2, 3} + Vec3{std::sin(polar) * std::cos(azimuth),
                                               std::sin(polar) * std::sin(azimuth), std::cos(polar)} *
                                              10.0);
  };
  add(0, 0);
  for (int r = 1; r < rings; ++r)
    for (int s = 0; s < sectors; ++s) add(radians(180.0 * r / rings), radians(360.0 * s / sectors));
  add(radians(180), 0);
  const int last = static_cast<int>(mesh.points.size()) - 1;
  const auto at = [&](int ring, int sector) { return 1 + (ring - 1) * sectors + sector % sectors; };
  for (int s = 0; s < sectors; ++s) {
    mesh.triangles.push_back({0, at(1, s), at(1, s + 1)});
    mesh.triangles.push_back({last, at(rings - 1, s + 1), at(rings - 1, s)});
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      mesh.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  return mesh;
}

/// A cube of 20 mm about (1, 2, 3): on the ball a point would slide off.
TriMesh box() {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.points.push_back(Vec3{1, 2, 3} + Vec3{i % 2 * 2.0 - 1, i / 2 % 2 * 2.0 - 1, i / 4 * 2.0 - 1} * 10.0);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A hilly map, turned, stretched and moved.
HeightField hills() {
  HeightField map;
  map.nx = 9, map.ny = 7;
  for (int j = 0; j < map.ny; ++j)
    for (int i = 0; i < map.nx; ++i)
      map.height.push_back(1.5 + std::sin(1.1 * i) + 0.7 * std::cos(0.8 * i * j));
  map.linear =
      rotation(normalized(Vec3{1, 2, 0.5}), 0.7) * Mat3{{Vec3{2, 0, 0}, Vec3{0.3, 1.5, 0}, Vec3{0, 0, 3}}};
  map.origin = {-6, -4, 1};
  return map;
}

Barrier make(Barrier::Shape shape) {
  Barrier b;
  b.shape = shape;
  b.centre = {1, 2, 3};
  b.radius_mm = 10;
  b.plane = Plane::through({1, 2, 3}, normalized(Vec3{1, -2, 2}));
  b.scale_mm = 2;
  b.stiffness_n = 0.6;
  if (shape == Barrier::Shape::depth_map) b.depth_map = std::make_shared<const HeightField>(hills());
  if (shape == Barrier::Shape::mesh) b.mesh = std::make_shared<const SurfaceQuery>(ball());
  return b;
}

Vec3 random_point(const RandomStream& random, std::uint64_t i) {
  return Vec3{1, 2, 3} +
         Vec3{random.uniform(3 * i) - 0.5, random.uniform(3 * i + 1) - 0.5, random.uniform(3 * i + 2) - 0.5} *
             26.0;
}

TEST(Barrier, ForceIsTheNegativeGradientOfTheEnergyForEveryShapeAndLaw) {
  const RandomStream random(5);
  for (const Barrier::Shape shape : kShapes) {
    for (const SpringLaw law :
         {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic, SpringLaw::square}) {
      for (const bool clings : {false, true}) {
        Barrier b = make(shape);
        b.law = law;
        b.clings = clings;
        int smooth = 0, trials = 0;
        for (std::uint64_t i = 0; i < 60; ++i) {
          const Vec3 p = random_point(random, i);
          const BarrierResponse r = respond(b, p);
          if (r.energy == 0) continue;
          ++trials;
          const double h = 1e-5;
          Vec3 slope, curve;
          for (int axis = 0; axis < 3; ++axis) {
            Vec3 low = p, high = p;
            low[axis] -= h, high[axis] += h;
            const double below = respond(b, low).energy, above = respond(b, high).energy;
            slope[axis] = (above - below) / (2 * h);
            curve[axis] = (above - 2 * r.energy + below) / (h * h);
          }
          // Across the edge of a cell or the border of two nearest triangles the energy has a kink.
          if (length(curve) > 100 * (1 + r.stiffness)) continue;
          ++smooth;
          EXPECT_LT(distance(r.force, -slope), 1e-5 * (1 + length(slope)))
              << static_cast<int>(shape) << ' ' << static_cast<int>(law) << ' ' << i;
        }
        EXPECT_GT(trials, 5) << static_cast<int>(shape);
        EXPECT_GE(smooth, trials - 2);
      }
    }
  }
}

TEST(Barrier, StiffnessBoundsTheRateOfChangeOfTheForce) {
  const RandomStream random(6);
  for (const Barrier::Shape shape : kShapes) {
    Barrier b = make(shape);
    b.clings = true;
    for (std::uint64_t i = 0; i < 80; ++i) {
      const Vec3 p = random_point(random, i);
      const BarrierResponse r = respond(b, p);
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 q = p;
        q[axis] += 1e-6;
        const double change = distance(respond(b, q).force, r.force) / 1e-6;
        if (change > 1e3) continue;  // another nearest triangle, another cell
        EXPECT_LT(change, 1.01 * r.stiffness + 1e-6) << static_cast<int>(shape) << ' ' << i;
      }
    }
  }
}

TEST(Barrier, SlopeIsTheRateOfChangeOfTheForceAlongItself) {
  const RandomStream random(7);
  for (const Barrier::Shape shape : {Barrier::Shape::sphere, Barrier::Shape::plane, Barrier::Shape::mesh}) {
    for (const SpringLaw law : {SpringLaw::linear, SpringLaw::exponential}) {
      Barrier b = make(shape);
      b.law = law;
      int trials = 0;
      for (std::uint64_t i = 0; i < 80; ++i) {
        const Vec3 p = random_point(random, i);
        const BarrierResponse r = respond(b, p);
        if (r.energy == 0) continue;
        const Vec3 n = normalized(r.force);
        const double h = 1e-6, change = dot(respond(b, p - n * h).force - respond(b, p + n * h).force, n);
        EXPECT_NEAR(change / (2 * h), r.slope, 1e-5 * (1 + r.slope)) << static_cast<int>(shape) << ' ' << i;
        EXPECT_LE(r.slope, r.stiffness);
        ++trials;
      }
      EXPECT_GT(trials, 5);
    }
  }
}

TEST(Barrier, AMeshedBallActsAsThePlaneOfItsNearestFace) {
  Barrier b = make(Barrier::Shape::mesh);
  const BarrierResponse inside = respond(b, {1, 2, 8.5});
  EXPECT_GT(inside.force.z, 0);
  EXPECT_NEAR(length(inside.force), 0.6 * 4.5 / 2, 0.1);
  EXPECT_EQ(respond(b, {1, 2, 15}).force, Vec3{});
  b.clings = true;
  EXPECT_NEAR(respond(b, {1, 2, 15}).force.z, -0.6 * 2 / 2, 1e-9);  // above the pole
}

TEST(Barrier, ADepthMapInterpolatesBetweenItsSamplesAndEndsAtItsBorder) {
  Barrier b = make(Barrier::Shape::depth_map);
  HeightField map;
  map.nx = 2, map.ny = 2;
  map.height = {0, 1, 2, 5};
  map.origin = {10, 0, 0};
  b.depth_map = std::make_shared<const HeightField>(map);
  const double height = 0.25 * (0 + 1 + 2 + 5);
  EXPECT_EQ(respond(b, {10.5, 0.5, height + 0.01}).energy, 0);
  const BarrierResponse r = respond(b, {10.5, 0.5, height - 1});  // strain 1/2
  EXPECT_NEAR(r.force.z, 0.3, 1e-12);
  EXPECT_NEAR(r.force.x, -0.3 * 2, 1e-12);  // slopes 2 and 3 there
  EXPECT_NEAR(r.force.y, -0.3 * 3, 1e-12);
  EXPECT_EQ(respond(b, {9.9, 0.5, -5}).energy, 0);
  EXPECT_EQ(respond(b, {10.5, 1.1, -5}).energy, 0);
}

TEST(Barrier, LetsGoBeyondItsThresholdAndClingsNoFartherThanItsReach) {
  for (const Barrier::Shape shape : {Barrier::Shape::sphere, Barrier::Shape::plane, Barrier::Shape::mesh}) {
    Barrier b = make(shape);
    b.clings = true;
    b.plane = Plane::through({1, 2, 13}, {0, 0, 1});
    b.threshold_mm = 3;
    b.reach_mm = 4;
    EXPECT_GT(respond(b, {1, 2, 10.5}).force.z, 0) << static_cast<int>(shape);
    EXPECT_EQ(respond(b, {1, 2, 9.5}).force, Vec3{}) << static_cast<int>(shape);
    EXPECT_LT(respond(b, {1, 2, 16.5}).force.z, 0) << static_cast<int>(shape);
    EXPECT_EQ(respond(b, {1, 2, 17.5}).force, Vec3{}) << static_cast<int>(shape);
  }
}

TEST(Barrier, ADrapedPointComesToRestWhereTheForceBalancesItsWeight) {
  for (const Barrier::Shape shape : {Barrier::Shape::depth_map, Barrier::Shape::mesh}) {
    MotionModel model;
    model.network.rest = {{1, 2, 20}};
    model.network.mass_g = {2};
    model.gravity_mm_ms2 = {0, 0, -0.0098};
    model.damping_g_ms = 0.1;
    Barrier b = make(shape);
    if (shape == Barrier::Shape::mesh) b.mesh = std::make_shared<const SurfaceQuery>(box());
    if (shape == Barrier::Shape::depth_map) {
      HeightField flat;
      flat.nx = flat.ny = 5;
      flat.height.assign(25, 13);
      flat.origin = {-1, 0, 0};
      b.depth_map = std::make_shared<const HeightField>(flat);
    }
    model.barriers = {b};
    const auto stepper = TimeStepper::prepare(model);
    ASSERT_TRUE(static_cast<bool>(stepper));
    MotionState state = stepper->rest();
    Context context;
    TimeStepper::Workspace w;
    for (int i = 0; i < 2000; ++i)
      ASSERT_TRUE(static_cast<bool>(stepper->step(state, 1, Integrator::heun, context, w)));
    EXPECT_NEAR(state.position[0].z, 13 - 2 * 2 * 0.0098 / 0.6, 1e-6) << static_cast<int>(shape);
    EXPECT_LT(length(state.velocity[0]), 1e-7);
  }
}

TEST(Barrier, ActsOnThePointsOfItsListAlone) {
  MotionModel model;
  model.network.rest = {{0, 0, -1}, {5, 0, -1}, {9, 0, -1}};
  model.network.mass_g = {1, 1, 1};
  Barrier floor;
  floor.shape = Barrier::Shape::plane;
  floor.points = {2, 0};
  Barrier everyone = floor;
  everyone.points.clear();
  everyone.stiffness_n = 0.25;
  model.barriers = {floor, everyone};
  auto stepper = TimeStepper::prepare(model);
  ASSERT_TRUE(static_cast<bool>(stepper));
  std::vector<Vec3> f(3);
  stepper->forces(stepper->rest(), f);
  EXPECT_EQ(f[0].z, 1.25);
  EXPECT_EQ(f[1].z, 0.25);
  EXPECT_EQ(f[2].z, 1.25);
  EXPECT_EQ(stepper->potential(model.network.rest), 2 * 0.5 + 3 * 0.125);
  model.barriers[0].points = {3};
  EXPECT_FALSE(static_cast<bool>(stepper->set_barriers(model.barriers)));
  EXPECT_FALSE(static_cast<bool>(TimeStepper::prepare(model)));
  stepper->forces(stepper->rest(), f);
  EXPECT_EQ(f[2].z, 1.25);
  floor.points = {1};
  ASSERT_TRUE(static_cast<bool>(stepper->set_barriers({floor})));
  stepper->forces(stepper->rest(), f);
  EXPECT_EQ(f[0].z, 0);
  EXPECT_EQ(f[1].z, 1);
}

TEST(Barrier, WildOnesAreNamed) {
  const auto message = [](Barrier::Shape shape, const std::function<void(Barrier&)>& damage) {
    Barrier b = make(shape);
    damage(b);
    const auto valid = validate(b);
    return valid ? std::string{} : valid.error().message();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with_map = [](const std::function<void(HeightField&)>& damage) {
    return [damage](Barrier& b) {
      HeightField map = hills();
      damage(map);
      b.depth_map = std::make_shared<const HeightField>(map);
    };
  };
  for (const Barrier::Shape shape : kShapes) {
    EXPECT_EQ(message(shape, [](Barrier&) {}), "");
    EXPECT_NE(message(shape, [&](Barrier& b) { b.stiffness_n = nan; }), "");
    EXPECT_NE(message(shape, [](Barrier& b) { b.threshold_mm = -1; }), "");
    EXPECT_NE(message(shape, [&](Barrier& b) { b.reach_mm = nan; }), "");
    EXPECT_NE(message(shape, [](Barrier& b) { b.law = SpringLaw::collagen; }), "");
  }
  const auto shape = Barrier::Shape::depth_map;
  EXPECT_NE(message(shape, [](Barrier& b) { b.depth_map = nullptr; }), "");
  EXPECT_NE(message(shape, with_map([](HeightField& m) { m.nx = 1; })), "");
  EXPECT_NE(message(shape, with_map([](HeightField& m) { m.height.pop_back(); })), "");
  EXPECT_NE(message(shape, with_map([&](HeightField& m) { m.height[3] = nan; })), "");
  EXPECT_NE(message(shape, with_map([](HeightField& m) { m.linear.c[1] = m.linear.c[0]; })), "");
  EXPECT_NE(message(Barrier::Shape::mesh, [](Barrier& b) { b.mesh = nullptr; }), "");
}

TEST(Barrier, IsFiniteFarAway) {
  for (const Barrier::Shape shape : kShapes) {
    Barrier b = make(shape);
    b.clings = true;
    for (const Vec3& p : {Vec3{1e9, -1e9, 1e9}, Vec3{1, 2, 3}, Vec3{-1e9, 0, 0}}) {
      const BarrierResponse r = respond(b, p);
      EXPECT_TRUE(std::isfinite(r.energy) && is_finite(r.force) && std::isfinite(r.stiffness))
          << static_cast<int>(shape);
    }
  }
}

}  // namespace
}  // namespace turgor
