#include "turgor/dynamics/surface_contact.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "dynamics/crossing.hpp"
#include "support/soft_blocks.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

using support::add_block;
using support::Block;

Vec3 random_vector(const RandomStream& random, std::uint64_t i) {
  return {2 * random.uniform(3 * i) - 1, 2 * random.uniform(3 * i + 1) - 1,
          2 * random.uniform(3 * i + 2) - 1};
}

SurfaceContact contact_of(const MotionModel& model) {
  std::vector<double> inverse(model.network.rest.size());
  for (std::size_t i = 0; i < inverse.size(); ++i)
    inverse[i] = model.mobile[i] != 0 ? 1 / model.network.mass_g[i] : 0;
  auto contact = SurfaceContact::prepare(*model.contact, model.network.rest, inverse);
  EXPECT_TRUE(static_cast<bool>(contact));
  return *contact;
}

std::vector<Vec3> forces_of(const SurfaceContact& contact, const std::vector<Vec3>& x) {
  SurfaceContact::Workspace w;
  std::vector<Vec3> forces(x.size());
  for (const ContactTouch& t : contact.find(x, w))
    for (int i = 0; i < 4; ++i)
      forces[t.points[i]] += t.normal * (t.weights[i] * contact.model().stiffness_n_mm * t.depth_mm);
  return forces;
}

/// A large block below, a small one somewhere in its upper side, both a little out of shape.
MotionModel two_blocks(std::uint64_t seed) {
  const RandomStream random(seed);
  MotionModel model;
  add_block(model, {{4, 4, 2}, 2.0, {0, 0, -4}});
  Block small{{1, 1, 1}, 2.0, {-1, -1, -1}};
  const Vec3 axis = normalized(random_vector(random, 0));
  small.place = RigidTransform::translate({4 + 3 * random.uniform(10), 3 + 2 * random.uniform(11), 1.4}) *
                RigidTransform{rotation(axis, 3 * random.uniform(12)), {}};
  add_block(model, small);
  model.contact->stiffness_n_mm = 0.8;
  return model;
}

struct Compared {
  int smooth = 0, kinks = 0;
};

/// Forces at x against differences of the energy, where another nearest face does not make a kink.
Compared compare_gradient(const SurfaceContact& contact, std::vector<Vec3> x) {
  Compared compared;
  const std::vector<Vec3> forces = forces_of(contact, x);
  const double energy = contact.energy(x);
  Vec3 sum, moment;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sum += forces[i], moment += cross(x[i], forces[i]);
    for (int axis = 0; axis < 3 && forces[i] != Vec3{}; ++axis) {
      const double h = 1e-5, here = x[i][axis];
      x[i][axis] = here - h;
      const double below = contact.energy(x);
      x[i][axis] = here + h;
      const double above = contact.energy(x);
      x[i][axis] = here;
      if (std::abs(above - 2 * energy + below) / (h * h) > 50) {
        ++compared.kinks;
        continue;
      }
      ++compared.smooth;
      EXPECT_NEAR(forces[i][axis], -(above - below) / (2 * h), 1e-6) << i;
    }
  }
  EXPECT_LT(length(sum), 1e-12);
  EXPECT_LT(length(moment), 1e-11);
  return compared;
}

TEST(SurfaceContact, ForcesAreTheNegativeGradientOfTheEnergyAndKeepMomentum) {
  int smooth = 0, kinks = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const MotionModel model = two_blocks(seed);
    std::vector<Vec3> x = model.network.rest;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += random_vector(RandomStream(seed), 100 + i) * 0.1;
    const Compared compared = compare_gradient(contact_of(model), x);
    smooth += compared.smooth, kinks += compared.kinks;
  }
  EXPECT_GT(smooth, 300);
  EXPECT_LT(kinks, smooth / 50);
}

/// A U of two arms along x, one cell thick, and the gap between them.
Block u_bar(int length, int gap, double spacing) {
  Block u{{length, 1, gap + 2}, spacing, {0, 0, 0}, {}, true, 0.05, 1e-3, true};
  for (int i = 1; i < length; ++i)
    for (int k = 1; k <= gap; ++k) u.left_out.push_back({i, 0, k});
  return u;
}

TEST(SurfaceContact, ForcesOfSelfContactAreTheNegativeGradientToo) {
  int smooth = 0;
  for (const int gap : {1, 4}) {  // narrower than twice the thickness, and wider
    MotionModel model;
    add_block(model, u_bar(6, gap, 0.6));
    std::vector<Vec3> x = model.network.rest;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (x[i].x > 1 && x[i].z > 1.5 * 0.6) x[i].z -= (gap == 1 ? 0.3 : 1.9) * std::min(1.0, x[i].x / 3);
      x[i] += random_vector(RandomStream(8), i) * 0.05;
    }
    smooth += compare_gradient(contact_of(model), x).smooth;
  }
  EXPECT_GT(smooth, 100);
}

TEST(SurfaceContact, APointBehindAFaceIsPushedOutAsItCame) {
  MotionModel model;
  add_block(model, {{4, 4, 4}, 2.0, {0, 0, 0}});
  const int probe = add_block(model, {{1, 1, 1}, 0.1, {20, 0, 0}});
  const SurfaceContact contact = contact_of(model);
  std::vector<Vec3> x = model.network.rest;
  for (double depth = -0.9; depth < 1; depth += 0.2) {
    for (const Vec3& place : {Vec3{3.3, 4.1, 8 - depth}, Vec3{8 - depth, 4.7, 3.1}}) {
      for (int i = 0; i < 8; ++i)
        x[probe + i] = place + (model.network.rest[probe + i] - model.network.rest[probe]);
      SurfaceContact::Workspace w;
      bool found = false;
      for (const ContactTouch& t : contact.find(x, w)) {
        if (t.points[0] != probe) continue;
        found = true;
        EXPECT_NEAR(t.gap_mm, -depth, 1e-12);
        EXPECT_GT(place.z > 5 ? t.normal.z : t.normal.x, 1 - 1e-12);
      }
      EXPECT_TRUE(found) << depth;
    }
  }
}

TEST(SurfaceContact, OverEdgesAndCornersTheNearestPointCounts) {
  MotionModel model;
  add_block(model, {{2, 2, 2}, 2.0, {0, 0, 0}});
  const int probe = add_block(model, {{1, 1, 1}, 0.1, {20, 0, 0}});
  const SurfaceContact contact = contact_of(model);
  std::vector<Vec3> x = model.network.rest;
  for (const auto& [place, gap] : {std::pair{Vec3{4.3, 2.1, 4.4}, 0.5}, {Vec3{4.2, 4.3, 4.6}, 0.7}}) {
    for (int i = 0; i < 8; ++i)
      x[probe + i] = place + (model.network.rest[probe + i] - model.network.rest[probe]);
    SurfaceContact::Workspace w;
    for (const ContactTouch& t : contact.find(x, w))
      if (t.points[0] == probe) EXPECT_NEAR(t.gap_mm, gap, 1e-12);
    EXPECT_FALSE(w.touches().empty());
  }
}

TEST(SurfaceContact, PartsThatLieTogetherAtRestAreNoContact) {
  MotionModel model;
  add_block(model, {{6, 2, 2}, 0.4, {0, 0, 0}, {}, true, 0.05, 1e-3, true});
  const SurfaceContact contact = contact_of(model);
  EXPECT_EQ(contact.energy(model.network.rest), 0);
  std::vector<Vec3> x = model.network.rest;
  for (Vec3& p : x) p *= 0.8;
  EXPECT_EQ(contact.energy(x), 0);
  for (Vec3& p : x) p.z *= 0.2;
  EXPECT_EQ(contact.energy(x), 0);
}

TEST(SurfaceContact, ANarrowGapActsFromItsWidthAtRestOn) {
  MotionModel model;  // the gap is 0.5 mm wide
  add_block(model, u_bar(6, 1, 0.5));
  const SurfaceContact contact = contact_of(model);
  EXPECT_EQ(contact.energy(model.network.rest), 0);
  std::vector<Vec3> x = model.network.rest;
  for (Vec3& p : x)
    if (p.x > 2.9 && p.z > 0.75) p.z -= 0.2;  // the end of the upper arm
  EXPECT_GT(contact.energy(x), 0);
  SurfaceContact::Workspace w;
  for (const ContactTouch& t : contact.find(x, w)) EXPECT_LE(t.depth_mm, 0.2 + 1e-9);
}

void run(const TimeStepper& stepper, MotionState& state, double dt, int steps,
         Integrator integrator = Integrator::heun, const std::function<void()>& look = {}) {
  Context context;
  TimeStepper::Workspace w;
  for (int i = 0; i < steps; ++i) {
    const auto report = stepper.step(state, dt, integrator, context, w);
    ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
    if (look) look();
  }
}

TimeStepper stepper_of(const MotionModel& model) {
  auto stepper = TimeStepper::prepare(model);
  EXPECT_TRUE(static_cast<bool>(stepper)) << stepper.error().message();
  return *std::move(stepper);
}

TEST(ContactMotion, StackedCubesRestWithTheirWeightBetweenThem) {
  MotionModel model;
  add_block(model, {{4, 4, 1}, 2.0, {-2, -2, -2}, {}, false});
  const int lower = add_block(model, {{2, 2, 2}, 2.0, {0.3, 0.2, 0.3}});
  const int upper = add_block(model, {{2, 2, 2}, 2.0, {0.6, 0.7, 4.9}});
  const int end = static_cast<int>(model.network.rest.size());
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.damping_g_ms = 1e-4;
  model.contact->thickness_mm = 0.5;
  model.contact->stiffness_n_mm = 0.02;
  for (const Integrator integrator : {Integrator::heun, Integrator::euler, Integrator::verlet}) {
    const TimeStepper stepper = stepper_of(model);
    MotionState state = stepper.rest();
    run(stepper, state, 1, 600, integrator);
    const ContactMeasures m = stepper.contact_measures(state);
    ASSERT_EQ(m.pairs.size(), 2u);
    const double weight = 0.0098 * support::mass(model, upper, end);
    EXPECT_NEAR(m.pairs[1].force_on_a_n.z, -weight, 1e-3 * weight);
    EXPECT_NEAR(m.pairs[0].force_on_a_n.z, -2 * weight, 1e-3 * weight);
    EXPECT_EQ(m.deepest_mm, 0);
    double fastest = 0;
    for (const Vec3& v : state.velocity) fastest = std::max(fastest, length(v));
    EXPECT_LT(fastest, 1e-5);
    EXPECT_NEAR(support::mean(model, state.position, lower, upper).x, 2.3, 0.05);
  }
}

TEST(ContactMotion, ABlockOnAnInclineSticksBelowTheAngleOfFrictionAndSlidesAbove) {
  for (const double angle : {10.0, 16.0, 25.0, 35.0}) {
    MotionModel model;
    add_block(model, {{10, 4, 1}, 2.0, {-4, -2, -2}, {}, false});
    const int first = add_block(model, {{2, 2, 1}, 2.0, {0.3, 0.2, 0.36}});
    const int end = static_cast<int>(model.network.rest.size());
    const double tilt = radians(angle), g = 0.0098;
    model.gravity_mm_ms2 = Vec3{std::sin(tilt), 0, -std::cos(tilt)} * g;
    model.contact->thickness_mm = 0.4;
    model.contact->stiffness_n_mm = 0.02;
    model.contact->friction = 0.35;  // 19.3°
    const TimeStepper stepper = stepper_of(model);
    MotionState state = stepper.rest();
    run(stepper, state, 0.2, 250);
    const double v0 = support::mean(model, state.velocity, first, end).x;
    run(stepper, state, 0.2, 200);
    const double v1 = support::mean(model, state.velocity, first, end).x;
    const double wanted = g * (std::sin(tilt) - 0.35 * std::cos(tilt));
    if (wanted > 0) {
      EXPECT_NEAR((v1 - v0) / 40, wanted, 0.05 * wanted);
    } else {
      EXPECT_LT(std::abs(v1), 1.2e-3);
    }
  }
}

TEST(ContactMotion, KeepsMomentumAndGainsNoEnergy) {
  MotionModel model;
  add_block(model, {{3, 3, 2}, 2.0, {0, 0, -4}});
  const int second = add_block(model, {{2, 2, 2}, 2.0, {1.3, 0.8, 1.3}});
  model.contact->stiffness_n_mm = 0.02;
  const TimeStepper stepper = stepper_of(model);
  for (const double speed : {0.02, 0.3, 3.0}) {
    MotionState state = stepper.rest();
    for (std::size_t i = second; i < state.velocity.size(); ++i)
      state.velocity[i] = Vec3{0.4, 0.1, -1} * speed;
    const Vec3 before = support::momentum(model, state.velocity);
    const double energy = stepper.kinetic(state.velocity);
    double most = 0;
    run(stepper, state, 0.1, static_cast<int>(60 / speed), Integrator::heun,
        [&] { most = std::max(most, stepper.kinetic(state.velocity) + stepper.potential(state.position)); });
    EXPECT_LT(distance(support::momentum(model, state.velocity), before), 1e-12);
    const int end = static_cast<int>(state.velocity.size());
    const double parting = support::mean(model, state.velocity, second, end).z -
                           support::mean(model, state.velocity, 0, second).z;
    EXPECT_LT(most, 1.01 * energy);
    EXPECT_LT(parting, 0.55 * speed);  // what the blocks' own springs give back
    EXPECT_GT(parting, 0);
  }
}

/// A fixed cube of 8 mm, its upper side at z = 0, and single points of 1 g above.
MotionModel floor_and_points(const std::vector<Vec3>& points) {
  MotionModel model;
  add_block(model, {{1, 1, 1}, 8.0, {-4, -4, -8}, {}, false});
  for (const Vec3& p : points) {
    model.network.rest.push_back(p);
    model.network.mass_g.push_back(1);
    model.mobile.push_back(1);
  }
  return model;
}

TEST(ContactMotion, WhatStrikesHardlyReboundsAndSlowerTheFasterItIs) {
  // A tetrahedron without springs: its corners are four masses that know nothing of each other.
  MotionModel model = floor_and_points({{1, 1, 2}, {-1, 1, 2.2}, {1, -1.5, 2.4}, {0, 0, 3}});
  const int first = static_cast<int>(model.network.rest.size()) - 4;
  model.contact->surfaces.push_back({{{first, first + 2, first + 1},
                                      {first, first + 1, first + 3},
                                      {first + 1, first + 2, first + 3},
                                      {first, first + 3, first + 2}},
                                     false});
  model.contact->friction = 0;
  model.contact->stiffness_n_mm = 0.1;
  const TimeStepper stepper = stepper_of(model);
  for (const double speed : {0.01, 0.1, 1.0, 10.0, 1000.0}) {
    MotionState state = stepper.rest();
    for (int i = 0; i < 3; ++i) state.velocity[first + i] = {0, 0, -speed};
    run(stepper, state, std::min(0.5, 20 / speed), 2 + static_cast<int>(12 / std::min(speed, 1.0)));
    for (int i = 0; i < 3; ++i) {
      EXPECT_GT(state.position[first + i].z, 0);
      EXPECT_LT(state.velocity[first + i].z, 0.18 * speed);
      EXPECT_GT(state.velocity[first + i].z, -1e-9);
    }
  }
}

/// Points that are within the sheet, or beyond it: next to faces that look away from `side` at rest.
int points_beyond(const MotionModel& model, const std::vector<Vec3>& x, int first, const Vec3& side) {
  const auto& triangles = model.contact->surfaces[0].triangles;
  TriMesh sheet;
  sheet.points.assign(x.begin(), x.begin() + first);
  sheet.triangles.assign(triangles.begin(), triangles.end());
  const SurfaceQuery query(sheet);
  int beyond = 0;
  for (std::size_t p = first; p < x.size(); ++p) {
    const auto nearest = query.nearest(x[p]);
    if (!nearest) return 100;
    const Index3& t = triangles[nearest->triangle];
    const auto& rest = model.network.rest;
    const Vec3 normal = cross(rest[t[1]] - rest[t[0]], rest[t[2]] - rest[t[0]]);
    beyond += query.inside(x[p]) || dot(normal, side) < -0.5 * length(normal) ? 1 : 0;
  }
  return beyond;
}

TEST(ContactMotion, SmallFastBodiesDoNotTunnelThroughThinSheets) {
  const RandomStream random(17);
  for (const bool mobile : {false, true}) {
    MotionModel model;
    add_block(model, {{12, 12, 1}, 0.8, {-4.8, -4.8, -0.8}, {}, mobile, 0.5});
    const int first = add_block(model, {{1, 1, 1}, 1.0, {-0.5, -0.5, -0.5}, {}, true, 0.2});
    const int end = static_cast<int>(model.network.rest.size());
    model.contact->thickness_mm = 0.2;
    model.contact->stiffness_n_mm = 0.05;
    const TimeStepper stepper = stepper_of(model);
    Context context;
    TimeStepper::Workspace w;
    int held = 0;
    for (std::uint64_t trial = 0; trial < 40; ++trial) {
      Vec3 to = random_vector(random, 2 * trial);
      to.z = -std::abs(to.z) - 0.3;
      to = normalized(to);
      const bool from_below = trial % 2 == 1;
      if (from_below) to.z = -to.z;
      const double speed =
          2 * std::pow(50, random.uniform(1000 + trial));  // in half a step 5 to 250 thicknesses
      const Mat3 turn =
          rotation(normalized(random_vector(random, 2 * trial + 1)), 3 * random.uniform(2000 + trial));
      const Vec3 side{0, 0, from_below ? -1.0 : 1.0}, middle{0, 0, -0.4};
      const Vec3 start = middle - to * (4 / std::abs(to.z));
      MotionState state = stepper.rest();
      for (int p = first; p < end; ++p) {
        state.position[p] = start + turn * state.position[p];
        state.velocity[p] = to * speed;
      }
      const Vec3 before = support::momentum(model, state.velocity);
      for (double t = 0; t < 6 / (speed * std::abs(to.z)); t += 1.0 / speed) {
        const auto report = stepper.step(state, 1.0 / speed, Integrator::heun, context, w);
        ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
        held += report->held_points;
      }
      EXPECT_EQ(points_beyond(model, state.position, first, side), 0)
          << mobile << ' ' << trial << ' ' << speed;
      if (mobile)
        EXPECT_LT(distance(support::momentum(model, state.velocity), before), 1e-9 * length(before));
    }
    EXPECT_EQ(held, 0);
  }
}

/// Light tissue between the floor and a mass a million times its own: impulses alone would take long.
TEST(ContactMotion, WhatIsCrushedByAHeavyMassIsHeld) {
  MotionModel model;
  add_block(model, {{4, 4, 1}, 1.0, {-2, -2, -1}, {}, false});
  add_block(model, {{1, 1, 1}, 0.5, {-0.2, -0.3, 0.1}});
  const int heavy = add_block(model, {{2, 2, 1}, 1.0, {-1.1, -0.9, 0.7}, {}, true, 0.05, 1e3});
  model.contact->thickness_mm = 0.1;
  model.contact->stiffness_n_mm = 0.01;
  const TimeStepper stepper = stepper_of(model);
  MotionState state = stepper.rest();
  for (std::size_t i = heavy; i < state.velocity.size(); ++i) state.velocity[i] = {0, 0, -10};
  Context context;
  int held = 0;
  for (int i = 0; i < 4; ++i) {
    const auto report = stepper.step(state, 0.1, Integrator::heun, context);
    ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
    held += report->held_points;
    for (const Vec3& p : state.position) ASSERT_TRUE(is_finite(p));
    for (std::size_t p = 50; p < state.position.size(); ++p) EXPECT_GT(state.position[p].z, 0);
  }
  EXPECT_GT(held, 0);
}

TEST(ContactMotion, TheArmsOfABarPulledTogetherDoNotPassThroughEachOther) {
  MotionModel model;
  Block u{{8, 2, 5}, 1.0, {0, 0, 0}, {}, true, 0.02, 1e-3, true};
  for (int i = 1; i < 8; ++i)
    for (int j = 0; j < 2; ++j)
      for (int k = 1; k < 4; ++k) u.left_out.push_back({i, j, k});
  add_block(model, u);
  const auto& rest = model.network.rest;
  std::vector<int> lower, upper;  // the facing sides of the arms
  for (int p = 0; p < static_cast<int>(rest.size()); ++p) {
    if (rest[p].x < 4) continue;
    if (rest[p].z == 1) lower.push_back(p);
    if (rest[p].z == 4) upper.push_back(p);
  }
  ASSERT_EQ(lower.size(), upper.size());
  for (std::size_t i = 0; i < lower.size(); ++i)
    model.network.springs.push_back({lower[i], upper[i], 0.01, 1e-3, SpringLaw::hookean, SpringKind::fibre});
  model.damping_g_ms = 1e-3;
  model.contact->thickness_mm = 0.3;
  model.contact->stiffness_n_mm = 0.05;
  const TimeStepper stepper = stepper_of(model);
  MotionState state = stepper.rest();
  double least = 1e9;
  run(stepper, state, 0.5, 120, Integrator::heun, [&] {
    for (std::size_t i = 0; i < lower.size(); ++i)
      least = std::min(least, state.position[upper[i]].z - state.position[lower[i]].z);
  });
  const ContactMeasures m = stepper.contact_measures(state);
  EXPECT_GT(least, 0);
  EXPECT_LT(least, 0.3);
  EXPECT_GT(m.contacts, 0);
  EXPECT_EQ(m.deepest_mm, 0);
}

TEST(ContactMotion, SameBitsOnAnyNumberOfThreadsAndWithAnyWorkspace) {
  MotionModel model;
  add_block(model, {{10, 10, 1}, 1.0, {-5, -5, -1}, {}, true, 0.05, 1e-3, true});
  const int second = add_block(model, {{5, 5, 3}, 1.0, {-2.2, -2.3, 0.8}, {}, true, 0.05, 1e-3, true});
  model.contact->thickness_mm = 0.5;
  model.contact->stiffness_n_mm = 0.02;
  const TimeStepper stepper = stepper_of(model);
  MotionState start = stepper.rest();
  for (std::size_t i = second; i < start.velocity.size(); ++i) start.velocity[i] = {0.3, 0.1, -1};
  start.velocity[second] = {0, 1, -4};
  std::vector<MotionState> ends;
  for (const int threads : {1, 2, 2}) {
    set_thread_count(threads);
    MotionState state = start;
    Context context;
    TimeStepper::Workspace kept;
    for (int i = 0; i < 12; ++i) {
      TimeStepper::Workspace fresh;
      fresh.guess_ms = kept.guess_ms;
      ASSERT_TRUE(static_cast<bool>(
          stepper.step(state, 0.1, Integrator::heun, context, ends.size() == 2 ? fresh : kept)));
      if (ends.size() == 2) kept.guess_ms = fresh.guess_ms;
    }
    ends.push_back(state);
  }
  set_thread_count(0);
  EXPECT_GT(stepper.contact_measures(ends[0]).contacts, 0);
  for (const MotionState& end : ends) {
    EXPECT_EQ(end.position, ends[0].position);
    EXPECT_EQ(end.velocity, ends[0].velocity);
  }
}

TEST(ContactMotion, StepsOfChosenLengthComeToRestOnTheFloorToo) {
  MotionModel model;
  add_block(model, {{2, 2, 1}, 4.0, {-4, -4, -4}, {}, false});
  const int first = add_block(model, {{2, 2, 1}, 2.0, {-1.8, -2.1, 1}});
  const int end = static_cast<int>(model.network.rest.size());
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.damping_g_ms = 1e-4;
  model.contact->thickness_mm = 0.5;
  model.contact->stiffness_n_mm = 0.02;
  const TimeStepper stepper = stepper_of(model);
  MotionState state = stepper.rest();
  Context context;
  const auto report = stepper.advance(state, 400, {}, context);
  ASSERT_TRUE(static_cast<bool>(report)) << report.error().message();
  EXPECT_EQ(report->held_points, 0);
  const double weight = 0.0098 * support::mass(model, first, end);
  EXPECT_NEAR(stepper.contact_measures(state).pairs.at(0).normal_n, weight, 0.01 * weight);
  EXPECT_LT(length(support::momentum(model, state.velocity)), 1e-3 * support::mass(model, first, end));
}

TEST(ContactMotion, WhereContactIsTooSoftForTheLoadTheStopHolds) {
  for (const double stiffness : {0.0, 1e-7}) {
    MotionModel model;
    add_block(model, {{2, 2, 1}, 4.0, {-4, -4, -4}, {}, false});
    const int first = add_block(model, {{2, 2, 1}, 2.0, {-1.8, -2.1, 0.3}});
    model.gravity_mm_ms2 = {0, 0, -0.0098};
    model.damping_g_ms = 1e-4;
    model.contact->thickness_mm = 0.5;
    model.contact->stiffness_n_mm = stiffness;
    const TimeStepper stepper = stepper_of(model);
    MotionState state = stepper.rest();
    double lowest = 1;
    run(stepper, state, 0.2, 500, Integrator::heun, [&] {
      for (std::size_t p = first; p < state.position.size(); ++p)
        lowest = std::min(lowest, state.position[p].z);
    });
    EXPECT_GT(lowest, 0);
    EXPECT_LT(length(support::momentum(model, state.velocity)),
              3e-3 * support::mass(model, first, static_cast<int>(state.position.size())));
  }
}

TEST(ContactMotion, APileOfTumblingCubesLosesEnergyAndNothingGetsInside) {
  const RandomStream random(5);
  MotionModel model;
  add_block(model, {{8, 8, 1}, 4.0, {-16, -16, -4}, {}, false});
  for (int b = 0; b < 4; ++b) {
    const auto seed = static_cast<std::uint64_t>(b);
    Block block{{2, 2, 2}, 2.0, {-2, -2, -2}, {}, true, 0.05, 1e-3, true};
    const Mat3 turn = rotation(normalized(random_vector(random, 20 + seed)), 3 * random.uniform(30 + seed));
    block.place = {turn, {2 * random.uniform(seed), 2 * random.uniform(10 + seed), 4 + 7.5 * b}};
    add_block(model, block);
  }
  model.gravity_mm_ms2 = {0, 0, -0.0098};
  model.contact->thickness_mm = 0.5;
  model.contact->stiffness_n_mm = 0.02;
  const TimeStepper stepper = stepper_of(model);
  MotionState state = stepper.rest();
  double before = stepper.potential(state.position);
  const double unit = std::abs(before);
  int contacts = 0;
  for (int i = 0; i < 20; ++i) {
    run(stepper, state, 0.5, 20);
    const ContactMeasures m = stepper.contact_measures(state);
    contacts += m.contacts;
    EXPECT_EQ(m.deepest_mm, 0) << i;
    const double now = stepper.kinetic(state.velocity) + stepper.potential(state.position);
    EXPECT_LT(now, before + 1e-4 * unit) << i;
    before = now;
  }
  EXPECT_GT(contacts, 100);
}

TEST(ContactMotion, AWorkspaceServesOneModelAfterAnother) {
  MotionModel model = two_blocks(3);
  const SurfaceContact one = contact_of(model);
  const std::vector<Vec3> x = model.network.rest;
  SurfaceContact::Workspace w;
  const std::size_t touches = one.find(x, w).size();
  EXPECT_GT(touches, 0u);
  {
    MotionModel apart = two_blocks(3);
    apart.contact->surfaces.pop_back();
    EXPECT_EQ(contact_of(apart).find(x, w).size(), 0u);
  }
  EXPECT_EQ(one.find(x, w).size(), touches);
  std::vector<Vec3> away = x;
  for (std::size_t i = 45; i < x.size(); ++i) away[i].z += 1e8;
  (void)one.find(away, w);
  EXPECT_EQ(one.find(x, w).size(), touches);
}

TEST(ContactMotion, DegenerateShapesAndWildPositionsStayFinite) {
  MotionModel model = two_blocks(2);
  const SurfaceContact contact = contact_of(model);
  const int small = 75;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto check = [&](std::vector<Vec3> x, bool finite) {
    for (const Vec3& f : forces_of(contact, x)) EXPECT_TRUE(!finite || is_finite(f));
    std::vector<Vec3> to = x, v(x.size());
    for (std::size_t i = small; i < x.size(); ++i) to[i].z -= 3, v[i].z -= 3;
    SurfaceContact::Workspace w;
    contact.find(x, w);
    contact.slow(w, 0.1, 0.1, to, v);
    contact.stop(x, to, v, w);
    for (std::size_t i = 0; i < x.size() && finite; ++i)
      EXPECT_TRUE(is_finite(to[i]) && is_finite(v[i])) << i;
  };
  const std::vector<Vec3>& rest = model.network.rest;
  ASSERT_EQ(rest.size(), 83u);
  check(rest, true);
  std::vector<Vec3> x = rest;
  for (std::size_t i = small; i < x.size(); ++i) x[i] = {4, 4, 0};  // all in one corner of the lower block
  check(x, true);
  x = rest;
  for (Vec3& p : x) p = {1, 2, 3};
  check(x, true);
  for (Vec3& p : x) p = Vec3{p.x, 0, 0} * 1e9;
  check(x, true);
  x = rest;
  x[small] = {nan, 0, 0};
  check(x, false);
  for (Vec3& p : x) p = {nan, nan, nan};
  check(x, false);
}

TEST(SurfaceContact, WildModelsAreNamed) {
  const MotionModel good = two_blocks(1);
  const auto message = [&](const std::function<void(ContactModel&)>& damage) {
    MotionModel model = good;
    damage(*model.contact);
    const auto made = TimeStepper::prepare(model);
    return made ? std::string{} : made.error().message();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(message([](ContactModel&) {}), "");
  EXPECT_EQ(message([](ContactModel& m) { m.surfaces.clear(); }), "");
  for (const double wild : {nan, inf, -1.0}) {
    EXPECT_NE(message([&](ContactModel& m) { m.thickness_mm = wild; }), "");
    EXPECT_NE(message([&](ContactModel& m) { m.stiffness_n_mm = wild; }), "");
    EXPECT_NE(message([&](ContactModel& m) { m.friction = wild; }), "");
    EXPECT_NE(message([&](ContactModel& m) { m.stick_mm_ms = wild; }), "");
    EXPECT_NE(message([&](ContactModel& m) { m.damping = wild; }), "");
  }
  EXPECT_NE(message([](ContactModel& m) { m.thickness_mm = 1e308; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.stiffness_n_mm = 1e308; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.thickness_mm = 0; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.stick_mm_ms = 0; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.surfaces[0].triangles[3][1] = 1000; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.surfaces[0].triangles[3][1] = -1; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.surfaces[0].triangles[3] = {1, 1, 2}; }), "");
  EXPECT_NE(message([](ContactModel& m) { m.surfaces[1] = m.surfaces[0]; }), "");
}

TEST(Crossing, RootsOfCubicsAreFound) {
  const auto roots_of = [](double a, double b, double c) {
    return cubic_roots({-a * b * c, a * b + b * c + c * a, -(a + b + c), 1});
  };
  const Roots three = roots_of(0.9, 0.2, 0.5);
  ASSERT_EQ(three.count, 3);
  EXPECT_NEAR(three.t[0], 0.2, 1e-12);
  EXPECT_NEAR(three.t[1], 0.5, 1e-12);
  EXPECT_NEAR(three.t[2], 0.9, 1e-12);
  EXPECT_EQ(roots_of(-3, 0.4, 7).count, 1);
  EXPECT_EQ(roots_of(-3, 4, 7).count, 0);
  EXPECT_NEAR(cubic_roots({-0.25, 1, 0, 0}).t[0], 0.25, 1e-12);
  EXPECT_EQ(cubic_roots({-0.09, 0, 1, 0}).count, 1);
  EXPECT_EQ(cubic_roots({0, 0, 0, 0}).count, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_LE(cubic_roots({nan, nan, nan, nan}).count, 3);
}

TEST(Crossing, AgreesWithSmallSteps) {
  const RandomStream random(9);
  int crossed = 0;
  for (std::uint64_t i = 0; i < 1500; ++i) {
    std::array<Vec3, 4> from, to;
    for (std::uint64_t j = 0; j < 4; ++j) {
      from[j] = random_vector(random, 8 * i + j);
      to[j] = from[j] + random_vector(random, 8 * i + 4 + j);
    }
    const auto found = first_crossing(from, to, 0);
    double time = 2;
    bool before = false;
    constexpr int kSteps = 2000;
    for (int s = 0; s <= kSteps && time > 1; ++s) {
      const double t = static_cast<double>(s) / kSteps;
      std::array<Vec3, 4> x;
      for (std::size_t j = 0; j < 4; ++j) x[j] = lerp(from[j], to[j], t);
      const Vec3 n = cross(x[2] - x[1], x[3] - x[1]);
      const bool front = dot(x[0] - x[1], n) > 0;
      if (s > 0 && before && !front) {
        const double v = dot(cross(x[0] - x[1], x[3] - x[1]), n), w = dot(cross(x[2] - x[1], x[0] - x[1]), n);
        if (v >= 0 && w >= 0 && v + w <= squared_length(n)) time = t;
      }
      before = front;
    }
    if (time <= 1) {
      ++crossed;
      ASSERT_TRUE(found) << i;
      EXPECT_NEAR(found->time, time, 1.1 / kSteps);
    }
    if (!found) continue;
    Vec3 gap, normal = found->normal;
    for (std::size_t j = 0; j < 4; ++j) gap += lerp(from[j], to[j], found->time) * found->weights[j];
    EXPECT_LT(length(gap), 1e-9);
    EXPECT_NEAR(length(normal), 1, 1e-12);
  }
  EXPECT_GT(crossed, 20);
}

}  // namespace
}  // namespace turgor
