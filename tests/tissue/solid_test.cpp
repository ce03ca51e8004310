#include "turgor/tissue/solid.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <set>

#include "support/lattice_solid.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

using support::Lattice;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <class T>
std::string fault(const Result<T>& result) {
  return result ? "no error" : result.error().message();
}

double sum(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0);
}

// Every corner of these is odd or even in the end: cubes of both patterns.
const Lattice kBox{3, 2, 4, 2.5, {}};

TEST(Solid, NamesEachEdgeAndTriangleOnce) {
  const auto tetrahedra = support::lattice_tetrahedra(kBox);
  const Solid solid = *make_solid(tetrahedra, 4 * 3 * 5, 2.5);
  std::set<std::array<int, 2>> edges;
  std::set<Index3> triangles;
  for (auto p : tetrahedra) {
    std::sort(p.begin(), p.end());
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = a + 1; b < 4; ++b) {
        edges.insert({p[a], p[b]});
        for (std::size_t c = b + 1; c < 4; ++c) triangles.insert({p[a], p[b], p[c]});
      }
    }
  }
  EXPECT_EQ(solid.edges, std::vector(edges.begin(), edges.end()));
  EXPECT_EQ(solid.triangles, std::vector(triangles.begin(), triangles.end()));
  EXPECT_EQ(solid.tetrahedra, tetrahedra);
  EXPECT_EQ(solid.lattice_mm, 2.5);
  const auto count = [](const auto& v) { return static_cast<int>(v.size()); };
  EXPECT_EQ(60 - count(edges) + count(triangles) - count(tetrahedra), 1) << "Euler's number of a ball";
}

TEST(Solid, IsTheSameOnOneAndTwoThreads) {
  const auto tetrahedra = support::lattice_tetrahedra({20, 20, 20, 1, {}});
  set_thread_count(1);
  const Solid one = *make_solid(tetrahedra, 21 * 21 * 21, 1);
  set_thread_count(2);
  const Solid two = *make_solid(tetrahedra, 21 * 21 * 21, 1);
  set_thread_count(0);
  EXPECT_EQ(one.edges, two.edges);
  EXPECT_EQ(one.triangles, two.triangles);
}

TEST(Solid, NamesWhatCannotBeASolid) {
  EXPECT_NE(fault(make_solid({{0, 1, 2, 4}}, 4)).find("tetrahedron 0 has the corner 4"), std::string::npos);
  EXPECT_NE(fault(make_solid({{0, 1, 2, -1}}, 4)).find("corner -1"), std::string::npos);
  EXPECT_NE(fault(make_solid({{0, 1, 2, 3}, {3, 1, 0, 1}}, 4)).find("tetrahedron 1 has the corner 1 twice"),
            std::string::npos);
  EXPECT_NE(fault(make_solid({{0, 1, 2, 3}}, -7)).find("corner 0 of 0"), std::string::npos);
  EXPECT_NE(fault(make_solid({{0, 1, 2, 3}}, 4, 1.0)).find("five a cube"), std::string::npos);
  EXPECT_NE(fault(make_solid({}, 4, kNan)).find("lattice"), std::string::npos);
  const auto empty = make_solid({}, 0);
  ASSERT_TRUE(static_cast<bool>(empty));
  EXPECT_TRUE(empty->edges.empty() && empty->triangles.empty());
}

TEST(Solid, EachElementStandsForItsPartOfTheVolume) {
  const SpringNetwork net = support::lattice_network(kBox);
  const double volume = 3 * 2 * 4 * std::pow(2.5, 3);
  const SolidStiffness k = stiffness_of(kBox.material);
  const Solid& solid = net.solids.at(0);
  EXPECT_NEAR(sum(solid.edge_nmm), k.length * volume, 1e-12 * volume);
  EXPECT_NEAR(sum(solid.triangle_nmm), k.area * volume, 1e-12 * volume);
  EXPECT_NEAR(sum(solid.tetrahedron_nmm), k.volume * volume, 1e-12 * volume);
  EXPECT_NEAR(sum(net.mass_g), kBox.material.density_g_mm3 * volume, 1e-12 * volume);
  // A tetrahedron alone: a sixth, a quarter, all of it.
  Solid one = *make_solid({{0, 1, 2, 3}}, 4);
  const std::vector<Vec3> rest = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}};
  ASSERT_TRUE(static_cast<bool>(set_stiffness(one, rest, std::array{SolidStiffness{6, 4, 5}})));
  for (const double e : one.edge_nmm) EXPECT_DOUBLE_EQ(e, 1);
  for (const double t : one.triangle_nmm) EXPECT_DOUBLE_EQ(t, 1);
  EXPECT_DOUBLE_EQ(one.tetrahedron_nmm[0], 5);
}

TEST(Solid, SidesTakeTheStiffnessOfTheTetrahedraAroundThem) {
  // Two tetrahedra on one face: what they share has the mean of both, the rest its own.
  Solid solid = *make_solid({{0, 1, 2, 3}, {0, 2, 1, 4}}, 5);
  const std::vector<Vec3> rest = {{0, 0, 0}, {6, 0, 0}, {0, 6, 0}, {0, 0, 1}, {0, 0, -1}};
  const std::array stiffness = {SolidStiffness{1, 2, 3}, SolidStiffness{10, 20, 30}};
  ASSERT_TRUE(static_cast<bool>(set_stiffness(solid, rest, stiffness)));
  for (std::size_t e = 0; e < solid.edges.size(); ++e) {
    const auto [a, b] = solid.edges[e];
    EXPECT_DOUBLE_EQ(solid.edge_nmm[e], b == 3 ? 1 : b == 4 ? 10 : 11) << a << ' ' << b;
  }
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const int last = solid.triangles[t][2];
    EXPECT_DOUBLE_EQ(solid.triangle_nmm[t], 1.5 * (last == 3 ? 2 : last == 4 ? 20 : 22));
  }
  EXPECT_EQ(solid.tetrahedron_nmm, (std::vector<double>{18, 180}));
}

TEST(Solid, StiffnessErrorsNameTheElementAndChangeNothing) {
  const std::vector<Vec3> rest = support::lattice_points(kBox);
  Solid solid = *make_solid(support::lattice_tetrahedra(kBox), static_cast<int>(rest.size()));
  const std::array<SolidStiffness, 2> two = {};
  EXPECT_NE(fault(set_stiffness(solid, rest, two)).find("2 stiffnesses are given for 120"),
            std::string::npos);
  const std::array wild = {SolidStiffness{1, kNan, 1}};
  EXPECT_NE(fault(set_stiffness(solid, rest, wild)).find("stiffness 0 is nan"), std::string::npos);
  const std::array huge = {SolidStiffness{1e308, 1e308, 1e308}};
  EXPECT_NE(fault(set_stiffness(solid, rest, huge)).find("too large"), std::string::npos);
  const std::array fine = {SolidStiffness{1, 1, 1}};
  const std::span<const Vec3> some(rest.data(), 7);
  EXPECT_NE(fault(set_stiffness(solid, some, fine)).find("of 7 points"), std::string::npos);
  Solid turned = solid;
  std::swap(turned.tetrahedra[3][0], turned.tetrahedra[3][1]);
  EXPECT_NE(fault(set_stiffness(turned, rest, fine)).find("tetrahedron 3"), std::string::npos);
  Solid fewer = solid;
  fewer.edges.pop_back();
  EXPECT_NE(fault(set_stiffness(fewer, rest, fine)).find("make_solid"), std::string::npos);
  std::vector<Vec3> lost = rest;
  lost[0].x = kNan;
  EXPECT_NE(fault(set_stiffness(solid, lost, fine)).find("tetrahedron"), std::string::npos);
  EXPECT_EQ(sum(solid.edge_nmm) + sum(solid.triangle_nmm) + sum(solid.tetrahedron_nmm), 0);
}

// The sixty rotations of the icosahedron: averages over them of polynomials up to degree 5 in a direction are
// those over all directions.
std::vector<Mat3> icosahedral_rotations() {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  const std::array generators = {rotation(normalized(Vec3{0, 1, golden}), radians(72)),
                                 rotation(normalized(Vec3{1, 1, 1}), radians(120))};
  std::vector<Mat3> group = {Mat3{}};
  const auto known = [&](const Mat3& m) {
    return std::any_of(group.begin(), group.end(), [&](const Mat3& g) {
      return distance(g.c[0], m.c[0]) + distance(g.c[1], m.c[1]) + distance(g.c[2], m.c[2]) < 1e-6;
    });
  };
  for (std::size_t i = 0; i < group.size(); ++i) {
    for (const Mat3& g : generators) {
      const Mat3 m = g * group[i];
      if (!known(m)) group.push_back(m);
    }
  }
  return group;
}

// Tetrahedra of one odd shape, turned every way.
SpringNetwork turned_every_way(const SolidMaterial& material) {
  const std::array corners = {Vec3{0, 0, 0}, Vec3{2, 0.3, 0.1}, Vec3{0.4, 1.5, -0.2}, Vec3{0.2, 0.5, 1.1}};
  SpringNetwork net;
  std::vector<std::array<int, 4>> tetrahedra;
  for (const Mat3& r : icosahedral_rotations()) {
    const int first = static_cast<int>(net.rest.size());
    tetrahedra.push_back({first, first + 1, first + 2, first + 3});
    for (const Vec3& c : corners) net.rest.push_back(r * c);
  }
  net.mass_g.assign(net.rest.size(), 1);
  net.solids.push_back(*make_solid(std::move(tetrahedra), static_cast<int>(net.rest.size())));
  const std::array stiffness = {stiffness_of(material)};
  EXPECT_TRUE(static_cast<bool>(set_stiffness(net.solids[0], net.rest, stiffness)));
  return net;
}

TEST(Solid, TheGuessHasTheEnergyOfLinearElasticity) {
  ASSERT_EQ(icosahedral_rotations().size(), 60u);
  const double s = 1e-5;
  const Mat3 strain{{Vec3{1, 0.3, -0.2} * s, Vec3{0.3, -0.4, 0.5} * s, Vec3{-0.2, 0.5, 0.7} * s}};
  for (const double share : {0.0, 0.2, 1.0}) {
    const SolidMaterial material{0.015, 0.45, 1e-3, share};
    const SpringNetwork net = turned_every_way(material);
    double volume = 0, squares = 0;
    for (const auto& p : net.solids[0].tetrahedra)
      volume += signed_volume(net.rest[p[0]], net.rest[p[1]], net.rest[p[2]], net.rest[p[3]]);
    for (const Vec3& column : strain.c) squares += dot(column, column);
    const double trace = strain.c[0].x + strain.c[1].y + strain.c[2].z;
    const double mu = 0.015 / (2 * 1.45), lambda = 0.015 * 0.45 / (1.45 * 0.1);
    std::vector<Vec3> strained = net.rest;
    for (Vec3& p : strained) p += strain * p;
    const double expected = 0.5 * volume * (2 * mu * squares + lambda * trace * trace);
    EXPECT_NEAR(NetworkEnergy::prepare(net)->value(strained) / expected, 1, 1e-4) << share;
  }
}

TEST(Solid, ShearAloneFollowsTheMaterialWhateverThePoissonsRatio) {
  const double s = 1e-5;
  for (const double poisson : {0.0, 0.2, 0.49}) {
    const SolidMaterial material{0.1, poisson, 1e-3, 0.3};
    EXPECT_GE(stiffness_of(material).volume, 0);
    const SpringNetwork net = turned_every_way(material);
    std::vector<Vec3> sheared = net.rest;
    for (Vec3& p : sheared) p += Vec3{p.y, p.x, 0} * s;
    double volume = 0;
    for (const auto& p : net.solids[0].tetrahedra)
      volume += signed_volume(net.rest[p[0]], net.rest[p[1]], net.rest[p[2]], net.rest[p[3]]);
    const double mu = 0.1 / (2 * (1 + poisson));
    EXPECT_NEAR(NetworkEnergy::prepare(net)->value(sheared) / (volume * mu * 2 * s * s), 1, 1e-4);
  }
}

}  // namespace
}  // namespace turgor
