#include "turgor/dynamics/equilibrium_sensitivity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "support/lattice_solid.hpp"
#include "support/layered_slab.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

struct Body {
  SpringNetwork network;
  PrescribedMotion motion;
  Loads loads;
};

EquilibriumOptions sharp() {
  EquilibriumOptions options;
  options.relative_residual = 1e-12;
  return options;
}

std::vector<Vec3> at_rest(const Body& body, const SpringNetwork& network,
                          const std::vector<Vec3>* start = nullptr) {
  Context context;
  const auto result = solve_equilibrium(network, body.motion, body.loads, sharp(), context, start);
  EXPECT_TRUE(result && result->converged) << (result ? "" : result.error().message());
  return result ? result->positions : network.rest;
}

EquilibriumSensitivity sensitivity_of(const Body& body, const std::vector<Vec3>& positions) {
  Context context;
  auto out = EquilibriumSensitivity::prepare(body.network, body.motion, body.loads, positions, context);
  EXPECT_TRUE(static_cast<bool>(out)) << (out ? "" : out.error().message());
  return *std::move(out);
}

std::vector<double> random_change(const SpringNetwork& network, std::uint64_t seed) {
  const RandomStream random(seed);
  std::vector<double> change(NetworkConstants(network).count());
  for (std::size_t c = 0; c < change.size(); ++c) change[c] = 2 * random.uniform(c) - 1;
  return change;
}

std::vector<Vec3> random_vectors(std::size_t count, std::uint64_t seed) {
  const RandomStream random(seed);
  std::vector<Vec3> out(count);
  for (std::size_t i = 0; i < 3 * count; ++i) out[i / 3][static_cast<int>(i % 3)] = 2 * random.uniform(i) - 1;
  return out;
}

std::vector<Vec3> moved_by(const Body& body, const std::vector<double>& change, double step,
                           const std::vector<Vec3>& start) {
  std::vector<double> factors;
  for (const double c : change) factors.push_back(1 + step * c);
  SpringNetwork network = body.network;
  scale_constants(network, factors);
  return at_rest(body, network, &start);
}

double norm(const std::vector<Vec3>& v) {
  double sum = 0;
  for (const Vec3& a : v) sum += squared_length(a);
  return std::sqrt(sum);
}
std::vector<Vec3> difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b, double per = 1) {
  std::vector<Vec3> out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = (a[i] - b[i]) / per;
  return out;
}
double product(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

// One random direction in the space of all constants: the derivative by formula, by differences of two
// solves, and by the adjoint.
void expect_derivative(const Body& body, double tolerance) {
  const std::vector<Vec3> rest = at_rest(body, body.network);
  const EquilibriumSensitivity sensitivity = sensitivity_of(body, rest);
  const std::vector<double> change = random_change(body.network, 7);
  const std::vector<Vec3> along = sensitivity.along(change);
  constexpr double step = 1e-4;
  const std::vector<Vec3> measured =
      difference(moved_by(body, change, step, rest), moved_by(body, change, -step, rest), 2 * step);
  ASSERT_GT(norm(measured), 1e-3);
  EXPECT_LT(norm(difference(along, measured)), tolerance * norm(measured));

  const std::vector<Vec3> seed = random_vectors(rest.size(), 11);
  const std::vector<double> adjoint = sensitivity.adjoint(seed);
  double left = 0, size = 0;
  for (std::size_t c = 0; c < change.size(); ++c)
    left += adjoint[c] * change[c], size += std::abs(adjoint[c] * change[c]);
  EXPECT_NEAR(left, product(seed, along), 1e-10 * size);
}

Body layered(SpringLaw law) {
  support::SlabOptions options;
  options.nx = 6, options.ny = 7;
  options.law = law;
  options.volumes = true;
  const support::Slab slab = support::make_slab(options);
  Body body{slab.network, {}, {}};
  for (int c = 0; c < slab.columns; ++c) {
    if (3 * c < slab.columns) {
      body.motion.moved.push_back(c);
      body.motion.positions.push_back(slab.network.rest[at(c)] + Vec3{0.3, 0.8, 1.1});
    } else {
      body.motion.fixed.push_back(c);
    }
  }
  // Taut: some laws have no stiffness at rest.
  for (Spring& s : body.network.springs) s.rest_length_mm *= 0.9;
  return body;
}

Body block() {
  const support::Lattice lattice{4, 3, 3, 5.0, {0.02, 0.45, 1e-3, 0.2}};
  Body body{support::lattice_network(lattice), {}, {}};
  for (int p = 0; p < lattice.point(0, 0, 1); ++p) body.motion.fixed.push_back(p);
  body.loads.force_n.resize(body.network.rest.size());
  for (int i = 0; i <= lattice.nx; ++i)
    for (int j = 0; j <= lattice.ny; ++j)
      body.loads.force_n[at(lattice.point(i, j, lattice.nz))] = {0.02, -0.01, -0.03};
  return body;
}

std::vector<int> top_of(const Body& body, double z) {
  std::vector<int> out;
  for (std::size_t p = 0; p < body.network.rest.size(); ++p)
    if (body.network.rest[p].z > z) out.push_back(static_cast<int>(p));
  return out;
}

TEST(EquilibriumSensitivity, IsTheDerivativeForEachLawOfSprings) {
  for (const SpringLaw law : kSpringLaws) {
    SCOPED_TRACE(static_cast<int>(law));
    expect_derivative(layered(law), 1e-5);
  }
}

TEST(EquilibriumSensitivity, IsTheDerivativeForSolids) {
  expect_derivative(block(), 1e-5);
}

TEST(EquilibriumSensitivity, IsTheDerivativeForAreasAndGuardedVolumes) {
  Body body = block();
  const auto& x = body.network.rest;
  for (const Index3& t : body.network.solids[0].triangles) {
    const double area = 0.5 * length(cross(x[at(t[1])] - x[at(t[0])], x[at(t[2])] - x[at(t[0])]));
    body.network.areas.push_back({{t[0], t[1], t[2]}, 0.95 * area, 0.4});
  }
  for (const auto& t : body.network.solids[0].tetrahedra) {
    const double v = signed_volume(x[at(t[0])], x[at(t[1])], x[at(t[2])], x[at(t[3])]);
    body.network.volumes.push_back({{t[0], t[1], t[2], t[3]}, v, 0.01, 0.02});
  }
  expect_derivative(body, 1e-5);
}

TEST(EquilibriumSensitivity, IsTheDerivativeUnderGrabs) {
  Body body = block();
  const std::vector<int> top = top_of(body, 14);
  const std::vector<double> weights(top.size(), 1.0 / static_cast<double>(top.size()));
  body.loads.grabs.push_back({top, weights, {14, 4, 16}, 0.05, 1e9});
  expect_derivative(body, 1e-5);
  body.loads.grabs[0].limit_n = 0.1;  // gives way
  expect_derivative(body, 1e-5);
}

TEST(EquilibriumSensitivity, IsTheDerivativeUnderBarriersAndContacts) {
  Body body = block();
  Barrier sphere;
  sphere.centre = {10, 7, 22};
  sphere.radius_mm = 9;
  sphere.stiffness_n = 0.4;
  body.loads.barriers.push_back(sphere);
  Barrier plane;
  plane.shape = Barrier::Shape::plane;
  plane.plane = {{-1, 0, 0}, -19};
  plane.stiffness_n = 0.1;
  plane.law = SpringLaw::exponential;
  body.loads.barriers.push_back(plane);
  for (const int p : top_of(body, 9)) {
    if (body.network.rest[at(p)].y == 0) body.network.contacts.push_back({p, {0, 1, 0}, 0.1, 0.05, 0.02});
  }
  expect_derivative(body, 1e-5);
}

TEST(EquilibriumSensitivity, ReactionsChangeAsTheyDoBetweenSolves) {
  const Body body = block();
  const std::vector<Vec3> rest = at_rest(body, body.network);
  const EquilibriumSensitivity sensitivity = sensitivity_of(body, rest);
  const std::vector<double> change = random_change(body.network, 3);
  std::vector<ConstantChange> changes;
  for (std::size_t c = 0; c < change.size(); ++c) changes.push_back({static_cast<int>(c), change[c]});
  const std::vector<Vec3> reactions = sensitivity.reactions_along(changes, sensitivity.along(change));
  constexpr double step = 1e-4;
  const auto reactions_at = [&](double s) {
    std::vector<double> factors;
    for (const double c : change) factors.push_back(1 + s * c);
    SpringNetwork network = body.network;
    scale_constants(network, factors);
    const auto energy = NetworkEnergy::prepare(network);
    NetworkEnergy::Workspace workspace;
    std::vector<Vec3> forces(rest.size());
    energy->forces(at_rest(body, network, &rest), forces, workspace);
    return forces;
  };
  const std::vector<Vec3> measured = difference(reactions_at(-step), reactions_at(step), 2 * step);
  double error = 0, size = 0;
  for (const int p : body.motion.fixed) {
    error += squared_length(reactions[at(p)] - measured[at(p)]);
    size += squared_length(measured[at(p)]);
  }
  EXPECT_LT(std::sqrt(error), 1e-5 * std::sqrt(size));

  // Elsewhere the loads are all that holds.
  const std::vector<Vec3> seed = random_vectors(rest.size(), 5), none(rest.size());
  const std::vector<double> adjoint = sensitivity.adjoint(none, seed);
  double left = 0;
  for (std::size_t c = 0; c < change.size(); ++c) left += adjoint[c] * change[c];
  EXPECT_NEAR(left, product(seed, reactions), 1e-10 * norm(seed) * norm(reactions));
}

TEST(EquilibriumSensitivity, HasTheSameBitsOnAnyNumberOfThreads) {
  const Body body = block();
  const std::vector<Vec3> rest = at_rest(body, body.network);
  std::vector<std::vector<ConstantChange>> changes(75);
  for (int c = 0; c < static_cast<int>(NetworkConstants(body.network).count()); ++c)
    changes[at(c) % changes.size()].push_back({c, 0.5 + c % 3});
  std::vector<std::vector<Vec3>> along[2];
  for (int threads = 1; threads <= 2; ++threads) {
    set_thread_count(threads);
    along[threads - 1] = sensitivity_of(body, rest).along_each(changes);
  }
  set_thread_count(0);
  EXPECT_EQ(along[0], along[1]);
  std::vector<double> last(NetworkConstants(body.network).count(), 0.0);
  for (const ConstantChange& c : changes[70]) last[at(c.constant)] = c.relative;
  EXPECT_EQ(sensitivity_of(body, rest).along(last), along[0][70]);
}

TEST(EquilibriumSensitivity, SaysWhereABodyIsNotAtStableRest) {
  Body body = block();
  Context context;
  body.motion.fixed.clear();
  const auto loose =
      EquilibriumSensitivity::prepare(body.network, body.motion, body.loads, body.network.rest, context);
  ASSERT_FALSE(loose);
  EXPECT_NE(loose.error().message().find("could move there without force"), std::string::npos);

  // A compressed straight line of springs buckles.
  SpringNetwork line;
  for (int i = 0; i < 3; ++i) line.rest.push_back(Vec3{0.8 * i, 0, 0});
  line.mass_g.assign(3, 1);
  for (int i = 0; i < 2; ++i) line.springs.push_back({i, i + 1, 1, 1, SpringLaw::hookean, SpringKind::fibre});
  EXPECT_FALSE(EquilibriumSensitivity::prepare(line, {{}, {}, {0, 2}}, {}, line.rest, context));
  for (Spring& s : line.springs) s.rest_length_mm = 0.7;  // taut
  EXPECT_TRUE(EquilibriumSensitivity::prepare(line, {{}, {}, {0, 2}}, {}, line.rest, context));

  const std::vector<Vec3> wild(3, Vec3{NAN, 0, 0});
  EXPECT_FALSE(EquilibriumSensitivity::prepare(line, {{}, {}, {0, 2}}, {}, wild, context));
  EXPECT_FALSE(EquilibriumSensitivity::prepare(line, {{}, {}, {0, 7}}, {}, line.rest, context));
}

}  // namespace
}  // namespace turgor
