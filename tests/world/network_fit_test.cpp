#include "turgor/world/network_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "support/lattice_solid.hpp"
#include "support/layered_slab.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/world/layered_fit.hpp"
#include "turgor/world/solid_fit.hpp"

namespace turgor {
namespace {

const support::Lattice kLattice{4, 3, 3, 5.0, {0.02, 0.45, 1e-3, 0.2}};

SolidMesh block_mesh() {
  SolidMesh mesh;
  for (const Vec3& p : support::lattice_points(kLattice)) mesh.points.push_back(p);
  for (const auto& t : support::lattice_tetrahedra(kLattice)) mesh.tetrahedra.push_back(t);
  mesh.spacing = kLattice.edge_mm;
  return mesh;
}

NetworkLoad press(const char* name, const Vec3& force) {
  NetworkLoad load;
  load.name = name;
  const int points = kLattice.point(kLattice.nx, kLattice.ny, kLattice.nz) + 1;
  for (int p = 0; p < kLattice.point(0, 0, 1); ++p) load.motion.fixed.push_back(p);
  load.loads.force_n.resize(at(points));
  for (int p = kLattice.point(0, 0, kLattice.nz); p < points; ++p) load.loads.force_n[at(p)] = force;
  return load;
}

// Two loads with supports of their own.
std::vector<NetworkLoad> two_loads() {
  std::vector<NetworkLoad> loads{press("press", {0.005, 0, -0.03}), press("pull", {0, 0.02, 0.02})};
  loads[1].motion.moved.assign(loads[1].motion.fixed.begin() + 10, loads[1].motion.fixed.end());
  loads[1].motion.fixed.resize(10);
  for (const int p : loads[1].motion.moved)
    loads[1].motion.positions.push_back(support::lattice_points(kLattice)[at(p)] + Vec3{0, 0, -0.5});
  return loads;
}

SolidFit block_fit(const Index3& nodes) {
  auto fit = make_solid_fit(block_mesh(), {kLattice.material, nodes}, two_loads());
  EXPECT_TRUE(static_cast<bool>(fit)) << (fit ? "" : fit.error().message());
  fit->fit.options.relative_residual = 1e-12;
  fit->fit.force_groups = {{0, 1, 2, 3}, {7, 12}};
  return *std::move(fit);
}

std::vector<double> guess_of(const GroupedParameters& grouped) {
  std::vector<double> out;
  for (std::size_t k = 0; k < grouped.parameters.size(); ++k)
    out.push_back(grouped.parameters[k].guess * (1 + 0.1 * static_cast<double>(k % 3)));
  return out;
}

std::unique_ptr<ForwardModel> model_of(const NetworkFit& fit) {
  auto model = make_forward_model(fit);
  EXPECT_TRUE(static_cast<bool>(model)) << (model ? "" : model.error().message());
  return *std::move(model);
}

std::unique_ptr<ForwardRun> run(const ForwardModel& model, const std::vector<double>& parameters,
                                std::size_t load, const ForwardRun* near = nullptr) {
  Context context;
  auto out = model.run(parameters, load, near, context);
  EXPECT_TRUE(static_cast<bool>(out)) << (out ? "" : out.error().message());
  return *std::move(out);
}

std::vector<double> flat(const Response& response) {
  std::vector<double> out;
  for (const Vec3& p : response.position_mm) out.insert(out.end(), {p.x, p.y, p.z});
  out.insert(out.end(), response.force_n.begin(), response.force_n.end());
  return out;
}

// Every column against central differences, and the adjoint against its transpose.
void expect_derivatives(const ForwardModel& model, const std::vector<double>& parameters, std::size_t load) {
  Context context;
  const auto middle = run(model, parameters, load);
  const auto jacobian = middle->jacobian(context);
  ASSERT_TRUE(static_cast<bool>(jacobian)) << jacobian.error().message();
  ASSERT_EQ(jacobian->rows, middle->response().rows());
  ASSERT_EQ(jacobian->columns, parameters.size());
  std::vector<double> seed;
  for (std::size_t i = 0; i < jacobian->rows; ++i) seed.push_back(2 * RandomStream(3).uniform(i) - 1);
  const auto adjoint = middle->adjoint(seed, context);
  ASSERT_TRUE(static_cast<bool>(adjoint));
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const double step = 1e-4 * parameters[k];
    std::vector<double> ahead = parameters, behind = parameters;
    ahead[k] += step;
    behind[k] -= step;
    const std::vector<double> a = flat(run(model, ahead, load, middle.get())->response()),
                              b = flat(run(model, behind, load, middle.get())->response());
    double error = 0, size = 0, transposed = 0, terms = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double measured = (a[i] - b[i]) / (2 * step), known = jacobian->values[k * jacobian->rows + i];
      error += (measured - known) * (measured - known);
      size += measured * measured;
      transposed += seed[i] * known;
      terms += std::abs(seed[i] * known);
    }
    EXPECT_LT(std::sqrt(error), 1e-4 * std::sqrt(size)) << "parameter " << k;
    EXPECT_NEAR((*adjoint)[k], transposed, 1e-9 * terms) << "parameter " << k;
  }
}

TEST(NetworkFit, JacobianAndAdjointAreTheDerivativesOfSolids) {
  for (const bool logarithmic : {true, false}) {
    SolidFit fit = block_fit({2, 1, 2});
    fit.fit.logarithmic = logarithmic;
    const auto model = model_of(fit.fit);
    ASSERT_EQ(model->load_count(), 2U);
    ASSERT_EQ(model->parameter_count(), 12U);
    for (std::size_t load = 0; load < 2; ++load) expect_derivatives(*model, guess_of(fit.parameters), load);
  }
}

TEST(NetworkFit, ProportionalConstantsHaveAFactorAtEachNodeAndOneOfEachKind) {
  SolidFitOptions options{kLattice.material, {2, 1, 2}};
  options.proportional = true;
  auto fit = make_solid_fit(block_mesh(), options, two_loads());
  ASSERT_TRUE(static_cast<bool>(fit)) << fit.error().message();
  ASSERT_EQ(fit->parameters.parameters.size(), 7U);
  EXPECT_EQ(fit->parameters.parameters[3].name, "stiffness at node (1, 0, 1)");
  EXPECT_EQ(fit->parameters.parameters[6].name, "k_v");
  EXPECT_EQ(fit->parameters.group, (std::vector<int>{0, 0, 0, 0, 1, 2, 3}));
  fit->fit.options.relative_residual = 1e-12;
  const auto model = model_of(fit->fit);
  expect_derivatives(*model, guess_of(fit->parameters), 0);
  // Twice as stiff throughout, or twice the constants.
  const SolidStiffness k = stiffness_of(kLattice.material);
  const auto stiff = run(*model, {2, 2, 2, 2, k.length, k.area, k.volume}, 0),
             same = run(*model, {1, 1, 1, 1, 2 * k.length, 2 * k.area, 2 * k.volume}, 0);
  for (std::size_t p = 0; p < stiff->response().position_mm.size(); ++p)
    EXPECT_LT(distance(stiff->response().position_mm[p], same->response().position_mm[p]), 1e-9);
}

TEST(NetworkFit, JacobianAndAdjointAreTheDerivativesOfLayeredTissue) {
  support::SlabOptions options;
  options.nx = 5, options.ny = 6, options.volumes = true;
  const support::Slab slab = support::make_slab(options);
  NetworkLoad load;
  load.name = "pull";
  for (int c = 0; c < slab.columns; ++c) {
    if (c % 5 == 0) {
      load.motion.moved.push_back(c);
      load.motion.positions.push_back(slab.network.rest[at(c)] + Vec3{0.2, 0.7, 0.4});
    } else {
      load.motion.fixed.push_back(c);
    }
  }
  LayeredFitOptions layers;
  for (const Spring& s : slab.network.springs)
    layers.spring_layer.push_back(std::min(s.a, s.b) / slab.columns);
  for (const VolumeElement& v : slab.network.volumes)
    layers.volume_layer.push_back(*std::min_element(v.p, v.p + 4) / slab.columns);
  auto fit = make_layered_fit(slab.network, layers, {load});
  ASSERT_TRUE(static_cast<bool>(fit)) << fit.error().message();
  // Membranes of layers 1 and 2, verticals and diagonals of 0 and 1, volumes of 0 and 1.
  ASSERT_EQ(fit->parameters.parameters.size(), 8U);
  EXPECT_EQ(fit->parameters.parameters[0].name, "vertical springs of layer 0");
  EXPECT_EQ(fit->parameters.parameters[2].name, "volumes of layer 0");
  fit->fit.options.relative_residual = 1e-12;
  fit->fit.force_groups = {load.motion.moved};
  const auto model = model_of(fit->fit);
  expect_derivatives(*model, guess_of(fit->parameters), 0);
}

TEST(NetworkFit, ParametersAreThoseOfTheClosedFormAtFirst) {
  const SolidFit fit = block_fit({1, 1, 1});
  const SolidStiffness k = stiffness_of(kLattice.material);
  ASSERT_EQ(fit.parameters.parameters.size(), 3U);
  EXPECT_EQ(fit.parameters.parameters[0].name, "k_d");
  EXPECT_EQ(fit.parameters.parameters[0].unit, "MPa");
  Context context;
  const SpringNetwork plain = support::lattice_network(kLattice);
  const NetworkLoad load = two_loads()[0];
  EquilibriumOptions options;
  options.relative_residual = 1e-12;
  const auto expected = solve_equilibrium(plain, load.motion, load.loads, options, context);
  const auto model = model_of(fit.fit);
  const auto found = run(*model, {k.length, k.area, k.volume}, 0);
  for (std::size_t p = 0; p < plain.rest.size(); ++p)
    EXPECT_LT(distance(found->response().position_mm[p], expected->positions[p]), 1e-7);
  // What is held feels what is pushed: the base carries the load.
  NetworkFit whole = fit.fit;
  whole.force_groups = {load.motion.fixed};
  whole.points = {3, 3, 60};
  const auto base = run(*model_of(whole), {k.length, k.area, k.volume}, 0);
  ASSERT_EQ(base->response().position_mm.size(), 3U);
  EXPECT_EQ(base->response().position_mm[2], found->response().position_mm[60]);
  EXPECT_NEAR(base->response().force_n[2], 20 * 0.03, 1e-8);
}

TEST(NetworkFit, ARunDependsOnItsParametersAloneAndNearOnlyHastensIt) {
  SolidFit fit = block_fit({2, 2, 2});
  fit.fit.options.relative_residual = 1e-9;
  const auto model = model_of(fit.fit);
  const std::vector<double> parameters = guess_of(fit.parameters);
  std::vector<Vec3> places[2];
  std::vector<double> jacobians[2], adjoints[2];
  Context context;
  for (int threads = 1; threads <= 2; ++threads) {
    set_thread_count(threads);
    const auto one = run(*model, parameters, 0);
    places[threads - 1] = one->response().position_mm;
    jacobians[threads - 1] = one->jacobian(context)->values;
    adjoints[threads - 1] = *one->adjoint(std::vector<double>(one->response().rows(), 1.0), context);
  }
  set_thread_count(0);
  EXPECT_EQ(places[0], places[1]);
  EXPECT_EQ(jacobians[0], jacobians[1]);
  EXPECT_EQ(adjoints[0], adjoints[1]);

  // Many runs at once do not disturb each other.
  std::vector<std::vector<Vec3>> same(8);
  parallel_for(same.size(), 1, [&](std::size_t i, std::size_t) {
    Context own;
    const auto other = model->run(parameters, 0, nullptr, own);
    if (other) same[i] = (*other)->response().position_mm;
  });
  for (const auto& each : same) EXPECT_EQ(each, places[0]);

  std::vector<double> beside = parameters;
  for (double& p : beside) p *= 1.5;
  const auto near = run(*model, beside, 0);
  const auto warm = run(*model, parameters, 0, near.get());
  for (std::size_t p = 0; p < places[0].size(); ++p)
    EXPECT_LT(distance(warm->response().position_mm[p], places[0][p]), 1e-5);
}

TEST(NetworkFit, ABodyThatDoesNotComeToRestIsAFailureOfItsOwnKind) {
  SolidFit fit = block_fit({1, 1, 1});
  fit.fit.options.max_newton_steps = 2;
  const auto model = model_of(fit.fit);
  Context context;
  const auto failed = model->run(std::vector<double>{1e-5, 1e-5, 1e-5}, 0, nullptr, context);
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().kind, ErrorKind::not_converged);
  EXPECT_NE(failed.error().message().find("press"), std::string::npos);
  EXPECT_TRUE(context.notices().empty());

  Context stopped({}, {}, [] { return true; });
  const auto cancelled = model->run(guess_of(fit.parameters), 0, nullptr, stopped);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().kind, ErrorKind::cancelled);
}

TEST(NetworkFit, WhatCannotBeUsedIsRefused) {
  const SolidFit fit = block_fit({1, 1, 1});
  const auto model = model_of(fit.fit);
  Context context;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const std::vector<double>& parameters :
       {std::vector<double>{1, 1}, {1, 1, nan}, {1, 1, 0}, {1, 1, -1}, {1, 1, 1e308}})
    EXPECT_FALSE(model->run(parameters, 0, nullptr, context));
  EXPECT_FALSE(model->run(guess_of(fit.parameters), 2, nullptr, context));
  const auto one = run(*model, guess_of(fit.parameters), 0);
  EXPECT_FALSE(one->adjoint(std::vector<double>(5), context));

  const auto refused = [&](auto&& spoil) {
    NetworkFit other = fit.fit;
    spoil(other);
    return !make_forward_model(std::move(other));
  };
  EXPECT_TRUE(refused([](NetworkFit& f) { f.loads.clear(); }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.points = {100000}; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.force_groups = {{-1}}; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.weights.offsets.pop_back(); }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.weights.columns[5] = 3; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.weights.column_count = 2'000'000'000; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.weights.column_count = -1; }));
  EXPECT_TRUE(refused([&](NetworkFit& f) { f.weights.weights[5] = nan; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.loads[0].motion.fixed = {5, 3}; }));
  EXPECT_TRUE(refused([](NetworkFit& f) { f.network.mass_g.clear(); }));
  EXPECT_FALSE(make_solid_fit(block_mesh(), {{0.02, 0.5, 1e-3, 0.2}, {1, 1, 1}}, two_loads()));
  EXPECT_FALSE(make_solid_fit(block_mesh(), {kLattice.material, {0, 1, 1}}, two_loads()));
  EXPECT_FALSE(make_solid_fit({}, {kLattice.material, {1, 1, 1}}, two_loads()));
  EXPECT_FALSE(make_layered_fit(support::make_slab({}).network, {{1, 2, 3}, {}, {1, 1, 1}}, two_loads()));
}

TEST(NetworkFit, GroupsHaveParametersWhereTheyHaveInfluence) {
  support::SlabOptions options;
  options.nx = 5, options.ny = 6;
  const SpringNetwork network = support::make_slab(options).network;
  std::vector<int> group(network.springs.size(), -1);
  // One group lies at low y only.
  for (std::size_t s = 0; s < group.size(); ++s) {
    const bool low =
        network.rest[at(network.springs[s].a)].y < 4 && network.rest[at(network.springs[s].b)].y < 4;
    group[s] = low ? 1 : s % 2 == 0 ? 0 : -1;
  }
  const auto grouped =
      make_grouped_parameters(network, group, {{"upper", "N", 2}, {"lower", "N", 3}}, {1, 4, 1}, 10);
  ASSERT_TRUE(static_cast<bool>(grouped)) << grouped.error().message();
  ASSERT_EQ(grouped->parameters.size(), 6U);
  EXPECT_EQ(grouped->parameters[4].name, "lower at node (0, 0, 0)");
  EXPECT_EQ(grouped->parameters[5].low, 0.3);
  EXPECT_EQ(grouped->group, (std::vector<int>{0, 0, 0, 0, 1, 1}));
  const ParameterWeights& w = grouped->weights;
  ASSERT_EQ(w.rows(), network.springs.size());
  for (std::size_t s = 0; s < group.size(); ++s) {
    double sum = 0;
    for (int i = w.offsets[s]; i < w.offsets[s + 1]; ++i) {
      sum += w.weights[at(i)];
      EXPECT_EQ(grouped->group[at(w.columns[at(i)])], group[s]);
    }
    EXPECT_NEAR(sum, group[s] < 0 ? 0 : 1, 1e-12);
  }
  EXPECT_FALSE(make_grouped_parameters(network, {}, {{"all", "", 1}}, {1, 1, 1}));
  EXPECT_FALSE(make_grouped_parameters(network, group, {{"all", "", 1}}, {1, 1, 1}));
  EXPECT_FALSE(make_grouped_parameters(network, group, {{"a", "", 1}, {"b", "", -1}}, {1, 1, 1}));
  EXPECT_FALSE(make_grouped_parameters(network, group, {{"a", "", 1}, {"b", "", 1}}, {1, 1, 1}, 1));
}

TEST(NetworkFit, ALoadThatComesToRestInItsOwnWayGivesTheSameBits) {
  Context context;
  SolidFit plain = block_fit({1, 1, 1}), own = block_fit({1, 1, 1});
  int calls = 0;
  for (NetworkLoad& load : own.fit.loads) {
    load.rest = [&calls, motion = load.motion, loads = load.loads](
                    SpringNetwork& network, const EquilibriumOptions& options, const std::vector<Vec3>* start,
                    Context& inner) {
      ++calls;
      return solve_equilibrium(network, motion, loads, options, inner, start);
    };
  }
  const std::vector<double> guess = guess_of(plain.parameters);
  const auto a = make_forward_model(std::move(plain.fit)), b = make_forward_model(std::move(own.fit));
  ASSERT_TRUE(a && b);
  const auto one = (*a)->run(guess, 1, nullptr, context), two = (*b)->run(guess, 1, nullptr, context);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(calls, 1);
  EXPECT_TRUE((*one)->response().position_mm == (*two)->response().position_mm);
  EXPECT_EQ((*one)->jacobian(context)->values, (*two)->jacobian(context)->values);
}

}  // namespace
}  // namespace turgor
