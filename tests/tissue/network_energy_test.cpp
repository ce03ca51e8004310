#include "turgor/tissue/network_energy.hpp"

#include <gtest/gtest.h>

#include "support/layered_slab.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/tissue/stiffness_matrix.hpp"

namespace turgor {
namespace {

// A slab with springs of all laws, guarded volumes, areas and a solid, and positions shaken so that springs
// are stretched and compressed and some volumes are inverted.
struct Shaken {
  SpringNetwork network;
  std::vector<Vec3> positions;
};

double area_of(const std::vector<Vec3>& x, const int* p) {
  return 0.5 * length(cross(x[p[1]] - x[p[0]], x[p[2]] - x[p[0]]));
}

// Over the points of the volumes, every other one of each.
void add_areas_and_solid(SpringNetwork& net) {
  std::vector<std::array<int, 4>> tetrahedra;
  for (std::size_t i = 0; i < net.volumes.size(); ++i) {
    const int* p = net.volumes[i].p;
    if (i % 2 == 0) tetrahedra.push_back({p[0], p[1], p[2], p[3]});
    if (i % 2 == 1) net.areas.push_back({{p[0], p[2], p[3]}, 1.3 * area_of(net.rest, p), 0.8});
  }
  net.solids.push_back(*make_solid(std::move(tetrahedra), static_cast<int>(net.rest.size())));
  const std::array stiffness = {stiffness_of({0.1, 0.4, 1e-3, 0.5})};
  EXPECT_TRUE(static_cast<bool>(set_stiffness(net.solids[0], net.rest, stiffness)));
}

// As Morris (2006, section 4.1) writes them.
double solid_energy(const SpringNetwork& net, const Solid& solid, const std::vector<Vec3>& x) {
  const auto part = [](double k, double now, double rest) {
    return 0.5 * k * (now - rest) * (now - rest) / (rest * rest);
  };
  const auto volume = [](const std::vector<Vec3>& y, const std::array<int, 4>& p) {
    return signed_volume(y[p[0]], y[p[1]], y[p[2]], y[p[3]]);
  };
  double sum = 0;
  for (std::size_t i = 0; i < solid.edges.size(); ++i) {
    const auto [a, b] = solid.edges[i];
    sum += part(solid.edge_nmm[i], distance(x[a], x[b]), distance(net.rest[a], net.rest[b]));
  }
  for (std::size_t i = 0; i < solid.triangles.size(); ++i) {
    const int* p = solid.triangles[i].data();
    sum += part(solid.triangle_nmm[i], area_of(x, p), area_of(net.rest, p));
  }
  for (std::size_t i = 0; i < solid.tetrahedra.size(); ++i) {
    const auto& p = solid.tetrahedra[i];
    sum += part(solid.tetrahedron_nmm[i], volume(x, p), volume(net.rest, p));
  }
  return sum;
}

Shaken make_shaken(int nx, int ny, double amplitude_mm) {
  support::SlabOptions options;
  options.nx = nx;
  options.ny = ny;
  options.volumes = true;
  Shaken shaken{support::make_slab(options).network, {}};
  for (std::size_t i = 0; i < shaken.network.springs.size(); ++i) {
    shaken.network.springs[i].law = kSpringLaws[i % kSpringLaws.size()];
  }
  for (VolumeElement& v : shaken.network.volumes) v.inversion_guard_mpa = 0.5;
  add_areas_and_solid(shaken.network);
  const RandomStream random(11);
  // Planes through every third point at rest: about half of them are crossed.
  const RandomStream directions(5);
  for (std::size_t i = 0; i < shaken.network.rest.size(); i += 3) {
    const Vec3 n = normalized(
        Vec3{directions.normal(3 * i), directions.normal(3 * i + 1), directions.normal(3 * i + 2)});
    shaken.network.contacts.push_back(
        {static_cast<int>(i), n, dot(n, shaken.network.rest[i]), 0.7, i % 2 == 0 ? 0.0 : 0.3});
  }
  shaken.positions = shaken.network.rest;
  for (std::size_t i = 0; i < shaken.positions.size(); ++i) {
    shaken.positions[i] +=
        Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)} * amplitude_mm;
  }
  return shaken;
}

std::vector<Vec3> random_field(std::size_t n, std::uint64_t seed) {
  const RandomStream random(seed);
  std::vector<Vec3> v(n);
  for (std::size_t i = 0; i < n; ++i)
    v[i] = {random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)};
  return v;
}

double inner(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

std::vector<Vec3> moved(const std::vector<Vec3>& x, const std::vector<Vec3>& v, double t) {
  std::vector<Vec3> y = x;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += v[i] * t;
  return y;
}

std::vector<Vec3> forces_at(const NetworkEnergy& energy, const std::vector<Vec3>& x) {
  NetworkEnergy::Workspace workspace;
  std::vector<Vec3> f(x.size());
  energy.forces(x, f, workspace);
  return f;
}

TEST(NetworkEnergy, IsTheSumOfItsElements) {
  const Shaken s = make_shaken(4, 5, 1.0);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  double sum = 0;
  for (const Spring& spring : s.network.springs) {
    sum += respond(spring, distance(s.positions[spring.a], s.positions[spring.b])).energy;
  }
  for (const VolumeElement& v : s.network.volumes) {
    sum += respond(v, signed_volume(s.positions[v.p[0]], s.positions[v.p[1]], s.positions[v.p[2]],
                                    s.positions[v.p[3]]))
               .energy;
  }
  for (const AreaElement& a : s.network.areas) {
    const double strain = area_of(s.positions, a.p) / a.rest_area_mm2 - 1;
    sum += 0.5 * a.stiffness_nmm * strain * strain;
  }
  sum += solid_energy(s.network, s.network.solids.at(0), s.positions);
  int crossed = 0;
  for (const Contact& c : s.network.contacts) {
    const double depth = dot(c.normal, s.positions[c.point]) - c.offset_mm;
    sum += 0.5 * (depth < 0 ? c.stiffness_n_mm : c.adhesion_n_mm) * depth * depth;
    if (depth < 0) ++crossed;
  }
  EXPECT_GT(crossed, 0);
  EXPECT_GT(energy.inverted_volumes(s.positions), 0) << "the test must reach inverted elements";
  EXPECT_NEAR(energy.value(s.positions) / sum, 1, 1e-13);
}

TEST(NetworkEnergy, ForcesAreItsNegativeGradient) {
  const Shaken s = make_shaken(4, 5, 0.8);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  const std::vector<Vec3> f = forces_at(energy, s.positions);
  const double h = 1e-5;
  for (std::size_t i = 0; i < s.positions.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> high = s.positions, low = s.positions;
      high[i][axis] += h;
      low[i][axis] -= h;
      const double slope = (energy.value(high) - energy.value(low)) / (2 * h);
      EXPECT_NEAR(f[i][axis], -slope, 1e-6 * (1 + std::abs(slope))) << i << ' ' << axis;
    }
  }
}

TEST(NetworkEnergy, StiffnessIsTheSlopeOfTheForces) {
  const Shaken s = make_shaken(4, 5, 0.8);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  NetworkEnergy::Workspace workspace;
  ElementStiffness k;
  energy.linearise(s.positions, 0.0, k);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const std::vector<Vec3> v = random_field(s.positions.size(), seed);
    std::vector<Vec3> product(v.size());
    energy.multiply(k, v, product, workspace);
    const double h = 1e-6;
    const std::vector<Vec3> high = forces_at(energy, moved(s.positions, v, h)),
                            low = forces_at(energy, moved(s.positions, v, -h));
    for (std::size_t i = 0; i < v.size(); ++i) {
      const Vec3 slope = (high[i] - low[i]) / (2 * h);
      EXPECT_LT(distance(product[i], -slope), 1e-5 * (1 + length(slope))) << i;
    }
  }
}

TEST(NetworkEnergy, ProjectedStiffnessIsSemiDefiniteAndNoSofterThanTheExactOne) {
  const Shaken s = make_shaken(4, 5, 1.0);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  NetworkEnergy::Workspace workspace;
  ElementStiffness exact, projected;
  energy.linearise(s.positions, 0.0, exact);
  energy.linearise(s.positions, 1.0, projected);
  double lowest_exact = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    // Fields on a single element reach its negative directions, which a field on all points averages away.
    std::vector<Vec3> v(s.positions.size());
    const auto& corners = energy.volume_corners()[seed % energy.volume_corners().size()];
    const std::vector<Vec3> local = random_field(4, seed);
    for (int c = 0; c < 4; ++c) v[corners.p[c]] = local[static_cast<std::size_t>(c)];
    std::vector<Vec3> ke(v.size()), kp(v.size());
    energy.multiply(exact, v, ke, workspace);
    energy.multiply(projected, v, kp, workspace);
    EXPECT_GE(inner(v, kp), -1e-10);
    EXPECT_GE(inner(v, kp) - inner(v, ke), -1e-10);
    lowest_exact = std::min(lowest_exact, inner(v, ke));
  }
  EXPECT_LT(lowest_exact, -1e-3) << "the exact stiffness must be indefinite here, or the test says nothing";
}

TEST(NetworkEnergy, ProjectedElementsAloneAreSemiDefinite) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const std::vector<Vec3> x = random_field(4, seed), v = random_field(4, seed + 1000);
    SpringNetwork net;
    net.rest = x;
    net.mass_g.assign(4, 1);
    net.volumes.push_back({{0, 1, 2, 3}, 0.7, 1.0, seed % 2 == 0 ? 0.0 : 3.0});
    net.springs.push_back({0, 1, 2.0, 1.0, kSpringLaws[static_cast<std::size_t>(seed) % kSpringLaws.size()],
                           SpringKind::membrane});
    if (seed % 3 != 0) net.volumes.clear();
    if (seed % 3 != 1) net.areas.push_back({{1, 2, 3}, seed % 2 == 0 ? 0.2 : 5.0, 1.0});
    const NetworkEnergy energy = *NetworkEnergy::prepare(net);
    ElementStiffness k;
    energy.linearise(x, 1.0, k);
    NetworkEnergy::Workspace workspace;
    std::vector<Vec3> kv(4);
    energy.multiply(k, v, kv, workspace);
    EXPECT_GE(inner(v, kv), -1e-12) << seed;
  }
}

TEST(NetworkEnergy, DoesNotChangeUnderRigidMotionAndItsForcesTurnAlong) {
  Shaken s = make_shaken(5, 6, 0.8);
  s.network.contacts.clear();
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  const RigidTransform t = RigidTransform::translate({40, -20, 7}) *
                           RigidTransform::rotate_about({1, 2, 3}, normalized(Vec3{1, -2, 0.5}), 1.1);
  std::vector<Vec3> turned;
  for (const Vec3& p : s.positions) turned.push_back(t.point(p));
  EXPECT_NEAR(energy.value(turned) / energy.value(s.positions), 1, 1e-12);
  const std::vector<Vec3> f = forces_at(energy, s.positions), g = forces_at(energy, turned);
  double largest = 0;
  for (const Vec3& v : f) largest = std::max(largest, length(v));
  for (std::size_t i = 0; i < f.size(); ++i) EXPECT_LT(distance(t.direction(f[i]), g[i]), 1e-11 * largest);
}

TEST(NetworkEnergy, InternalForcesKeepLinearAndAngularMomentum) {
  Shaken s = make_shaken(8, 9, 0.8);
  s.network.contacts.clear();
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  const std::vector<Vec3> f = forces_at(energy, s.positions);
  Vec3 sum, moment;
  double scale = 0;
  for (std::size_t i = 0; i < f.size(); ++i) {
    sum += f[i];
    moment += cross(s.positions[i], f[i]);
    scale += length(f[i]);
  }
  EXPECT_GT(scale, 1.0);
  EXPECT_LT(length(sum), 1e-13 * scale);
  EXPECT_LT(length(moment), 1e-13 * scale * 60) << "arms of up to 60 mm";
}

TEST(NetworkEnergy, CoincidentEndsExertNoForceAndAreCounted) {
  Shaken s = make_shaken(4, 5, 0.2);
  s.network.solids.clear();
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  EXPECT_EQ(energy.coincident_springs(s.positions), 0);
  s.positions[s.network.springs[3].a] = s.positions[s.network.springs[3].b];
  EXPECT_EQ(energy.coincident_springs(s.positions), 1);
  EXPECT_TRUE(std::isfinite(energy.value(s.positions)));
  for (const Vec3& f : forces_at(energy, s.positions)) EXPECT_TRUE(is_finite(f));
  ElementStiffness k;
  energy.linearise(s.positions, 0.0, k);
  for (const SpringStiffness& spring : k.springs)
    EXPECT_TRUE(is_finite(spring.direction * spring.transverse));
}

// A tetrahedron of each energy of a solid alone.
struct Tetrahedron {
  SpringNetwork network;
  explicit Tetrahedron(const SolidStiffness& stiffness) {
    network.rest = {{0, 0, 0}, {2, 0.1, 0}, {0.3, 1.8, 0.2}, {0.4, 0.5, 1.6}};
    network.mass_g.assign(4, 1);
    network.solids.push_back(*make_solid({{0, 1, 2, 3}}, 4));
    EXPECT_TRUE(static_cast<bool>(set_stiffness(network.solids[0], network.rest, std::array{stiffness})));
  }
};
constexpr std::array kEachEnergy = {SolidStiffness{1, 0, 0}, SolidStiffness{0, 1, 0},
                                    SolidStiffness{0, 0, 1}};

TEST(NetworkEnergy, EachEnergyOfASolidHasItsForcesAndStiffnessInvertedAndFlatToo) {
  for (const SolidStiffness& only : kEachEnergy) {
    const Tetrahedron t(only);
    const NetworkEnergy energy = *NetworkEnergy::prepare(t.network);
    // Stretched, flat, inverted.
    for (const double height : {1.7, 0.0, -1.2}) {
      std::vector<Vec3> x = t.network.rest;
      for (Vec3& p : x) p = {1.1 * p.x, p.y - 0.2 * p.x, height * p.z};
      if (height == 0) x[3] = {0.5, 0.6, 0}, x[2].z = 0;
      const std::vector<Vec3> f = forces_at(energy, x);
      NetworkEnergy::Workspace workspace;
      ElementStiffness k;
      energy.linearise(x, 0, k);
      const double h = 1e-6;
      for (std::size_t i = 0; i < 12; ++i) {
        std::vector<Vec3> unit(4), product(4);
        unit[i / 3][static_cast<int>(i % 3)] = 1;
        const std::vector<Vec3> high = moved(x, unit, h), low = moved(x, unit, -h);
        EXPECT_NEAR(inner(f, unit), -(energy.value(high) - energy.value(low)) / (2 * h), 1e-8);
        energy.multiply(k, unit, product, workspace);
        const std::vector<Vec3> fh = forces_at(energy, high), fl = forces_at(energy, low);
        for (std::size_t p = 0; p < 4; ++p)
          EXPECT_LT(distance(product[p], (fl[p] - fh[p]) / (2 * h)), 1e-7) << height << ' ' << p;
      }
    }
  }
}

TEST(NetworkEnergy, WhatHasNoAreaOrLengthHasNoForceAndIsFinite) {
  for (const SolidStiffness& only : {kEachEnergy[0], kEachEnergy[1]}) {
    const Tetrahedron t(only);
    const NetworkEnergy energy = *NetworkEnergy::prepare(t.network);
    for (const Vec3& along : {Vec3{}, Vec3{1, 0, 0}, Vec3{1e-170, 0, 0}}) {
      // All in one point; on a line, where triangles alone have no force.
      const std::vector<Vec3> x = {{}, along, along * 2, along * 3};
      const bool has_force = only.length > 0 && along != Vec3{};
      NetworkEnergy::Workspace workspace;
      ElementStiffness k;
      for (const double projection : {0.0, 1.0}) {
        energy.linearise(x, projection, k);
        std::vector<Vec3> product(4);
        energy.multiply(k, {{{1, 2, 3}, {-1, 1, 0}, {}, {5, 1, 1}}}, product, workspace);
        for (const Vec3& p : product) EXPECT_TRUE(is_finite(p));
      }
      for (const Vec3& f : forces_at(energy, x)) {
        EXPECT_TRUE(is_finite(f));
        if (!has_force) EXPECT_EQ(length(f), 0);
      }
      EXPECT_TRUE(std::isfinite(energy.value(x)));
    }
  }
}

TEST(NetworkEnergy, ADrivenSpringHasItsNewLength) {
  Shaken s = make_shaken(4, 5, 0.5);
  NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  for (const int spring : {0, 3, 17}) {
    s.network.springs[static_cast<std::size_t>(spring)].rest_length_mm *= 0.7;
    energy.set_rest_length(spring, s.network.springs[static_cast<std::size_t>(spring)].rest_length_mm);
  }
  EXPECT_EQ(energy.value(s.positions), NetworkEnergy::prepare(s.network)->value(s.positions));
}

TEST(NetworkEnergy, HasTheSameBitsOnOneAndTwoThreads) {
  const Shaken s = make_shaken(40, 50, 0.8);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  std::vector<int> unknowns;
  for (int i = 0; i < energy.point_count(); i += 1 + i % 2) unknowns.push_back(i);
  struct Outcome {
    double value;
    std::vector<Vec3> forces;
    std::vector<Mat3> blocks;
  };
  const auto run = [&](int threads) {
    set_thread_count(threads);
    ElementStiffness k;
    energy.linearise(s.positions, 1.0, k);
    StiffnessMatrix matrix(energy, unknowns);
    matrix.assemble(energy, k);
    return Outcome{energy.value(s.positions), forces_at(energy, s.positions), matrix.blocks()};
  };
  const Outcome one = run(1), two = run(2);
  set_thread_count(0);
  EXPECT_EQ(one.value, two.value);
  EXPECT_TRUE(one.forces == two.forces);
  ASSERT_EQ(one.blocks.size(), two.blocks.size());
  for (std::size_t i = 0; i < one.blocks.size(); ++i) ASSERT_EQ(one.blocks[i].c, two.blocks[i].c);
}

TEST(StiffnessMatrix, IsTheElementByElementProductRestrictedToTheUnknownPoints) {
  const Shaken s = make_shaken(5, 6, 0.8);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  std::vector<int> unknowns;  // every third point is held; the order of the rest is reversed
  for (int i = energy.point_count() - 1; i >= 0; --i) {
    if (i % 3 != 0) unknowns.push_back(i);
  }
  StiffnessMatrix matrix(energy, unknowns);
  for (const double projection : {0.0, 1.0}) {
    ElementStiffness k;
    energy.linearise(s.positions, projection, k);
    matrix.assemble(energy, k);
    std::vector<Vec3> v = random_field(s.positions.size(), 3), expected(v.size());
    for (std::size_t i = 0; i < v.size(); i += 3) v[i] = {};
    NetworkEnergy::Workspace workspace;
    energy.multiply(k, v, expected, workspace);
    for (int row = 0; row < matrix.rows(); ++row) {
      Vec3 sum;
      for (int e = matrix.offsets()[row]; e < matrix.offsets()[row + 1]; ++e) {
        sum += matrix.blocks()[e] * v[unknowns[matrix.columns()[e]]];
      }
      EXPECT_LT(distance(sum, expected[unknowns[row]]), 1e-11 * (1 + length(sum)));
    }
  }
}

TEST(StiffnessMatrix, IsSymmetricWithADiagonalBlockInEveryRow) {
  const Shaken s = make_shaken(5, 6, 0.8);
  const NetworkEnergy energy = *NetworkEnergy::prepare(s.network);
  std::vector<int> unknowns;
  for (int i = 0; i < energy.point_count(); i += 2) unknowns.push_back(i);
  StiffnessMatrix matrix(energy, unknowns);
  ElementStiffness k;
  energy.linearise(s.positions, 0.0, k);
  matrix.assemble(energy, k);
  const auto block = [&](int row, int column) -> const Mat3* {
    for (int e = matrix.offsets()[row]; e < matrix.offsets()[row + 1]; ++e) {
      if (matrix.columns()[e] == column) return &matrix.blocks()[e];
    }
    return nullptr;
  };
  for (int row = 0; row < matrix.rows(); ++row) {
    EXPECT_EQ(matrix.columns()[matrix.diagonal()[row]], row);
    for (int e = matrix.offsets()[row]; e < matrix.offsets()[row + 1]; ++e) {
      const Mat3* twin = block(matrix.columns()[e], row);
      ASSERT_NE(twin, nullptr);
      const Mat3 t = twin->transposed();
      for (std::size_t j = 0; j < 3; ++j) EXPECT_LT(distance(matrix.blocks()[e].c[j], t.c[j]), 1e-12);
    }
  }
}

}  // namespace
}  // namespace turgor
