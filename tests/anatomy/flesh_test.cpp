#include "turgor/anatomy/flesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "support/grid_surface.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {
namespace {

using support::make_grid;

Flesh make_flesh(const Polyhedron& source, const FleshOptions& options = {}) {
  auto flesh = flesh_out(source, options);
  EXPECT_TRUE(flesh) << flesh.error().message();
  return *flesh;
}

FleshNetwork network_of(const Flesh& flesh) {
  auto network = make_network(flesh);
  EXPECT_TRUE(network) << network.error().message();
  return *network;
}

FleshOptions with_volumes() {
  FleshOptions options;
  options.volume_modulus_mpa = 0.3;
  options.inversion_guard_mpa = 0.5;
  return options;
}

std::map<SpringKind, int> count_kinds(const SpringNetwork& network) {
  std::map<SpringKind, int> count;
  for (const Spring& s : network.springs) ++count[s.kind];
  return count;
}

std::vector<Vec3> forces_at(const SpringNetwork& network, const std::vector<Vec3>& positions) {
  const auto energy = NetworkEnergy::prepare(network);
  EXPECT_TRUE(energy);
  std::vector<Vec3> forces(positions.size());
  NetworkEnergy::Workspace workspace;
  energy->forces(positions, forces, workspace);
  return forces;
}

std::vector<Vec3> shaken(std::vector<Vec3> positions, double amplitude_mm, std::uint64_t seed) {
  const RandomStream random(seed);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] +=
        Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)} * amplitude_mm;
  }
  return positions;
}

double mass_of(const Flesh& flesh) {
  double sum = 0;
  for (const FleshSample& s : flesh.samples) sum += s.mass_g;
  return sum;
}

TEST(FleshOut, BuildsLayersAlongVertexNormals) {
  Polyhedron tent;
  tent.points = {{0, 0, 0}, {1, 0, 0}, {1, 4, 0}, {0, 4, 0}, {0, 0, -1}, {1, 0, -1}};
  tent.add_polygon(std::array{0, 1, 2, 3});
  tent.add_polygon(std::array{0, 4, 5, 1});
  FleshOptions options;
  options.thickness = {{2}, {1, 2, 3, 4, 5, 6}, {1}};
  options.mass_g = 0.5;
  options.fix_bone = true;
  const Flesh flesh = make_flesh(tent, options);
  EXPECT_EQ(flesh.layers, 4);
  EXPECT_EQ(flesh.samples[0].rest, tent.points[0]);
  const Vec3 n = normalized(Vec3{0, -1, 1});
  EXPECT_LT(distance(flesh.samples[at(flesh.sample(1, 1))].rest, tent.points[1] + n * 2), 1e-14);
  EXPECT_LT(distance(flesh.samples[at(flesh.sample(2, 1))].rest, tent.points[1] + n * 4), 1e-14);
  EXPECT_LT(distance(flesh.samples[at(flesh.sample(3, 2))].rest, tent.points[2] + Vec3{0, 0, 6}), 1e-14);
  EXPECT_FALSE(flesh.samples[5].mobile);
  EXPECT_TRUE(flesh.samples[6].mobile);
  EXPECT_DOUBLE_EQ(mass_of(flesh), 4 * 6 * 0.5);
}

TEST(FleshOut, SheetWithTheFusiformWoundHas522Samples) {
  Flesh flesh = make_flesh(make_grid(13, 14));
  ASSERT_TRUE(remove_columns(flesh, support::wound_columns()));
  EXPECT_EQ(flesh.columns(), 174);
  EXPECT_EQ(flesh.samples.size(), 522u);
  // Sutures of the thesis join the rims: (70, 71), (81, 82), (91, 92), (102, 103).
  const auto place = [&](int column) { return flesh.surface.points[at(column)]; };
  EXPECT_EQ(place(70), (Vec3{5, 5, 0}));
  EXPECT_EQ(place(71), (Vec3{7, 5, 0}));
  EXPECT_EQ(place(81), (Vec3{4, 6, 0}));
  EXPECT_EQ(place(82), (Vec3{8, 6, 0}));
  EXPECT_EQ(place(91), (Vec3{4, 7, 0}));
  EXPECT_EQ(place(92), (Vec3{8, 7, 0}));
  EXPECT_EQ(place(102), (Vec3{5, 8, 0}));
  EXPECT_EQ(place(103), (Vec3{7, 8, 0}));
  EXPECT_TRUE(make_network(flesh));
}

TEST(FleshOut, SaysWhatIsWrong) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const struct {
    std::function<void(Polyhedron&, FleshOptions&)> damage;
    std::string says;
  } cases[] = {
      {[](Polyhedron& p, FleshOptions&) { p = {}; }, "no polygons"},
      {[](Polyhedron& p, FleshOptions&) { p.points.push_back({}); }, "no polygon uses point 9"},
      {[&](Polyhedron& p, FleshOptions&) { p.points[1].x = nan; }, "point 1 is not a finite number"},
      {[](Polyhedron& p, FleshOptions&) { p.points[1].x = 1e308; }, "point 1 lies farther"},
      {[](Polyhedron& p, FleshOptions&) { p.corners[0] = 77; }, "names point 77"},
      {[](Polyhedron& p, FleshOptions&) { p.points.assign(9, {}); }, "point 0 has no normal"},
      {[](Polyhedron&, FleshOptions& o) {
         o.thickness = {{1}, {1, 2}};
       },
       "has 2 values for 9 points"},
      {[](Polyhedron&, FleshOptions& o) { o.thickness = {{}}; }, "has 0 values"},
      {[](Polyhedron&, FleshOptions& o) { o.thickness = {{-1}}; }, "thickness above layer 0 is -1"},
      {[&](Polyhedron&, FleshOptions& o) {
         o.thickness = {{1}, {nan}};
       },
       "thickness above layer 1 is nan"},
      {[](Polyhedron&, FleshOptions& o) { o.thickness = {{1e308}}; }, "rest position of sample 9"},
      {[](Polyhedron&, FleshOptions& o) { o.thickness.assign(3'000'000, {1}); },
       "more than 20000000 samples"},
      {[](Polyhedron&, FleshOptions& o) { o.mass_g = 0; }, "mass of a sample is 0"},
      {[&](Polyhedron&, FleshOptions& o) { o.stiffness_n = inf; }, "stiffness inf"},
      {[](Polyhedron&, FleshOptions& o) { o.volume_modulus_mpa = -1; }, "volume modulus -1"},
      {[](Polyhedron&, FleshOptions& o) { o.law = static_cast<SpringLaw>(9); }, "law 9"},
  };
  for (const auto& [damage, says] : cases) {
    Polyhedron source = make_grid(3, 3);
    FleshOptions options;
    damage(source, options);
    const auto result = flesh_out(source, options);
    ASSERT_FALSE(result) << says;
    EXPECT_NE(result.error().message().find(says), std::string::npos) << result.error().message();
  }
}

TEST(Flesh, ValidateNamesTheFault) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    std::function<void(Flesh&)> damage;
    std::string says;
  } cases[] = {
      {[](Flesh& f) { f.layers = 0; }, "0 layers"},
      {[](Flesh& f) { f.layers = 2'000'000'000; }, "more than 20000000 samples"},
      {[](Flesh& f) { f.samples.pop_back(); }, "26 samples are not 3 layers of 9 columns"},
      {[](Flesh& f) { f.samples[4].growth = 0; }, "sample 4 has mass 1 g, growth 0"},
      {[&](Flesh& f) { f.samples[4].stiffness = nan; }, "stiffness nan"},
      {[](Flesh& f) { f.samples[4].spacing = -1; }, "spacing -1"},
      {[](Flesh& f) { f.samples[20].rest.z = 1e300; }, "rest position of sample 20"},
      {[](Flesh& f) { f.samples[2].rest.z = 3; }, "sample 2 of layer 0"},
      {[](Flesh& f) {
         f.surface.lines = {{0, 1}};
       },
       "loose lines"},
  };
  for (const auto& [damage, says] : cases) {
    Flesh flesh = make_flesh(make_grid(3, 3));
    damage(flesh);
    const auto result = make_network(flesh);
    ASSERT_FALSE(result) << says;
    EXPECT_NE(result.error().message().find(says), std::string::npos) << result.error().message();
  }
}

TEST(FleshNetwork, OfAGridHasTheSpringsThatTheConstructionNames) {
  const int nx = 10, ny = 10, layers = 3;
  const FleshNetwork flesh = network_of(make_flesh(make_grid(nx, ny)));
  const int membranes = (nx - 1) * ny + nx * (ny - 1);
  // Both diagonals of every square, and straight on over every point between two others.
  const int plates = 2 * (nx - 1) * (ny - 1) + (nx - 2) * ny + nx * (ny - 2);
  auto count = count_kinds(flesh.network);
  EXPECT_EQ(count[SpringKind::membrane], layers * membranes);
  EXPECT_EQ(count[SpringKind::plate], layers * plates);
  EXPECT_EQ(count[SpringKind::vertical], (layers - 1) * nx * ny);
  EXPECT_EQ(count[SpringKind::diagonal], (layers - 1) * 2 * (membranes + plates));
  std::set<std::pair<int, int>> pairs;
  for (std::size_t i = 0; i < flesh.network.springs.size(); ++i) {
    const Spring& s = flesh.network.springs[i];
    EXPECT_TRUE(pairs.emplace(std::min(s.a, s.b), std::max(s.a, s.b)).second) << "each pair once";
    const int low = std::min(s.a, s.b) / (nx * ny), high = std::max(s.a, s.b) / (nx * ny);
    EXPECT_EQ(flesh.layer_of_spring[i], low);
    const bool within = s.kind == SpringKind::membrane || s.kind == SpringKind::plate;
    EXPECT_EQ(high, within ? low : low + 1);
  }
  EXPECT_TRUE(flesh.network.volumes.empty());
}

TEST(FleshNetwork, MembraneWinsWhereAPlateJoinsTheSamePair) {
  // In a triangle every two points are joined by an edge and lie beyond the third.
  Polyhedron triangle;
  triangle.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.add_polygon(std::array{0, 1, 2});
  auto count = count_kinds(network_of(make_flesh(triangle)).network);
  EXPECT_EQ(count[SpringKind::membrane], 9);
  EXPECT_EQ(count[SpringKind::plate], 0);
}

TEST(FleshNetwork, IsAtRestAsBuiltAndItsForcesAreTheGradientOfItsEnergy) {
  Polyhedron source = make_grid(5, 4);
  for (Vec3& p : source.points) p.z = 0.1 * p.x * p.x - 0.05 * p.x * p.y;
  FleshOptions options = with_volumes();
  for (const SpringLaw law :
       {SpringLaw::linear, SpringLaw::exponential, SpringLaw::logarithmic, SpringLaw::square}) {
    options.law = law;
    const SpringNetwork network = network_of(make_flesh(source, options)).network;
    EXPECT_EQ(network.volumes.size(), 2u * 8u * 12u);
    for (const Vec3& f : forces_at(network, network.rest)) EXPECT_LT(length(f), 1e-12);
    const std::vector<Vec3> x = shaken(network.rest, 0.2, 3), f = forces_at(network, x);
    const auto energy = NetworkEnergy::prepare(network);
    const double h = 1e-5;
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        std::vector<Vec3> up = x, down = x;
        up[i][axis] += h;
        down[i][axis] -= h;
        const double slope = (energy->value(up) - energy->value(down)) / (2 * h);
        EXPECT_NEAR(f[i][axis], -slope, 1e-5 * (1 + std::abs(slope))) << "sample " << i;
      }
    }
  }
}

TEST(FleshNetwork, HonoursGrowthStiffnessAndSpacing) {
  Flesh flesh = make_flesh(make_grid(4, 4), with_volumes());
  const SpringNetwork plain = network_of(flesh).network;
  flesh.samples[0].growth = 1.5;
  flesh.samples[0].stiffness = 3;
  flesh.samples[1].spacing = 0.5;
  const SpringNetwork edited = network_of(flesh).network;
  for (std::size_t i = 0; i < plain.springs.size(); ++i) {
    const Spring &before = plain.springs[i], &after = edited.springs[i];
    const bool grown = before.a == 0 || before.b == 0, dense = before.a == 1 || before.b == 1;
    EXPECT_DOUBLE_EQ(after.rest_length_mm, before.rest_length_mm * (grown ? 1.25 : 1));
    const double spacing = dense ? 0.75 : 1;
    EXPECT_DOUBLE_EQ(after.stiffness_n, before.stiffness_n * (grown ? 2 : 1) * spacing *
                                            (before.kind == SpringKind::vertical ? spacing : 1));
  }
  // Grown alike everywhere it is at rest at its larger size.
  for (FleshSample& s : flesh.samples) s.growth = 1.2;
  const SpringNetwork larger = network_of(flesh).network;
  std::vector<Vec3> x = larger.rest;
  for (Vec3& p : x) p *= 1.2;
  for (const Vec3& f : forces_at(larger, x)) EXPECT_LT(length(f), 1e-12);
  // A stiffness of 0 takes the springs away.
  for (FleshSample& s : flesh.samples) s.stiffness = 0;
  for (const Spring& s : network_of(flesh).network.springs) EXPECT_EQ(s.stiffness_n, 0);
}

TEST(FleshNetwork, IsTheSameForAnyNumberOfThreads) {
  const Flesh flesh = make_flesh(make_grid(90, 80));
  const SpringNetwork many = network_of(flesh).network;
  set_thread_count(1);
  const SpringNetwork one = network_of(flesh).network;
  set_thread_count(0);
  ASSERT_EQ(many.springs.size(), one.springs.size());
  for (std::size_t i = 0; i < one.springs.size(); ++i) {
    EXPECT_TRUE(many.springs[i].a == one.springs[i].a && many.springs[i].b == one.springs[i].b &&
                many.springs[i].rest_length_mm == one.springs[i].rest_length_mm);
  }
}

TEST(FleshNetwork, RefusesAFanWithMoreSpringsThanFit) {
  Polyhedron fan;
  fan.points.push_back({0, 0, 0});
  const int n = 20000;
  for (int i = 0; i < n; ++i) fan.points.push_back({std::cos(6.28 * i / n), std::sin(6.28 * i / n), 0});
  for (int i = 1; i < n; ++i) fan.add_polygon(std::array{0, i, i + 1});
  const auto result = make_network(make_flesh(fan));
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().what.find("springs"), std::string::npos);
}

TEST(FleshNetwork, SaysWhereThickTissueIsTurnedOver) {
  // A bowl fleshed inwards past its centre.
  Polyhedron bowl = make_grid(5, 5);
  for (Vec3& p : bowl.points) p.z = 0.5 * ((p.x - 2) * (p.x - 2) + (p.y - 2) * (p.y - 2));
  FleshOptions options = with_volumes();
  options.thickness = {{8}};
  const Flesh flesh = make_flesh(bowl, options);
  EXPECT_GT(inverted_prisms(flesh,
                            [&] {
                              std::vector<Vec3> x;
                              for (const FleshSample& s : flesh.samples) x.push_back(s.rest);
                              return x;
                            }()),
            0);
  const auto result = make_network(flesh);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().what.find("turned over at column"), std::string::npos);
}

TEST(FleshVolumes, PushASqueezedPrismBackAndRightAnInvertedOne) {
  Polyhedron triangle;
  triangle.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  triangle.add_polygon(std::array{0, 1, 2});
  FleshOptions options = with_volumes();
  options.thickness = {{1}};
  options.stiffness_n = 0;  // volumes alone
  const Flesh flesh = make_flesh(triangle, options);
  const SpringNetwork network = network_of(flesh).network;
  ASSERT_EQ(network.volumes.size(), 6u) << "one at each corner";
  for (const VolumeElement& v : network.volumes) EXPECT_NEAR(v.rest_volume_mm3, 2.0 / 3, 1e-14);
  EXPECT_EQ(inverted_prisms(flesh, network.rest), 0);
  double last = 0;
  for (const double height : {0.5, 0.1, 0.0, -0.5, -1.0}) {
    std::vector<Vec3> x = network.rest;
    for (std::size_t i = 3; i < 6; ++i) x[i].z = height;
    EXPECT_EQ(inverted_prisms(flesh, x), height > 0 ? 0 : 1);
    const std::vector<Vec3> f = forces_at(network, x);
    double lift = 0;
    for (std::size_t i = 3; i < 6; ++i) lift += f[i].z;
    EXPECT_GT(lift, last) << "the deeper, the stronger it is pushed back, at height " << height;
    last = lift;
  }
}

TEST(FleshVolumes, StandAtTheCornersOfTrianglesAndConvexQuadrilaterals) {
  Polyhedron hexagons;
  for (int i = 0; i < 6; ++i) hexagons.points.push_back({std::cos(1.0472 * i), std::sin(1.0472 * i), 0});
  hexagons.points.push_back({2, 1, 0});
  hexagons.points.push_back({2, 0, 0});
  hexagons.add_polygon(std::array{0, 1, 2, 3, 4, 5});
  hexagons.add_polygon(std::array{1, 0, 7, 6});
  const Flesh flesh = make_flesh(hexagons, with_volumes());
  EXPECT_EQ(network_of(flesh).network.volumes.size(), 2u * (4u * 6u + 8u)) << "a hexagon is four triangles";
  EXPECT_EQ(prism_count(flesh), 2 * (4 + 1));
}

TEST(FleshVolumes, CountTheVolumeOfAPrismOnce) {
  Polyhedron triangle, square;
  triangle.points = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  triangle.add_polygon(std::array{0, 1, 2});
  square.points = {{0, 0, 0}, {1, 0, 0}, {1, 2, 0}, {0, 2, 0}};
  square.add_polygon(std::array{0, 1, 2, 3});
  FleshOptions options = with_volumes();
  options.thickness = {{1}};
  options.stiffness_n = 0;                               // volumes alone
  for (const Polyhedron& source : {triangle, square}) {  // both of volume 2
    const SpringNetwork network = network_of(make_flesh(source, options)).network;
    const auto energy = NetworkEnergy::prepare(network);
    ASSERT_TRUE(static_cast<bool>(energy));
    std::vector<Vec3> x = network.rest;
    for (Vec3& p : x) p.z *= 1.01;
    const double expected = 0.5 * options.volume_modulus_mpa * 2 * 0.01 * 0.01;
    EXPECT_NEAR(energy->value(x), expected, 1e-9 * expected);
  }
}

TEST(FleshVolumes, FavourNoDiagonal) {
  // A square sheet squeezed at all corners alike pushes back at all corners alike.
  FleshOptions options = with_volumes();
  const SpringNetwork network = network_of(make_flesh(make_grid(2, 2), options)).network;
  std::vector<Vec3> x = network.rest;
  for (Vec3& p : x) p.z *= 0.8;
  const std::vector<Vec3> f = forces_at(network, x);
  for (std::size_t i = 1; i < 4; ++i) EXPECT_NEAR(f[i].z, f[0].z, 1e-12);
}

TEST(FleshEdits, RemoveColumnsRenumbersAndKeepsWhatSamplesCarry) {
  Flesh flesh = make_flesh(make_grid(4, 3));
  for (std::size_t i = 0; i < flesh.samples.size(); ++i)
    flesh.samples[i].growth = 1 + 0.01 * static_cast<double>(i);
  const Flesh before = flesh;
  std::vector<bool> remove(12, false);
  remove[1] = true;  // column 0 and its polygon go with it
  const auto map = remove_columns(flesh, remove);
  ASSERT_TRUE(map);
  EXPECT_TRUE(validate(flesh));
  EXPECT_EQ(flesh.surface.polygon_count(), 4);
  EXPECT_EQ(flesh.columns(), 10);
  EXPECT_EQ(map->new_of_old[0], -1);
  EXPECT_EQ(map->new_of_old[1], -1);
  ASSERT_EQ(map->origin.size(), flesh.samples.size());
  for (std::size_t i = 0; i < flesh.samples.size(); ++i) {
    EXPECT_EQ(map->origin[i][0], map->origin[i][1]);
    EXPECT_EQ(map->new_of_old[at(map->origin[i][0])], static_cast<int>(i));
    EXPECT_EQ(flesh.samples[i].growth, before.samples[at(map->origin[i][0])].growth);
    EXPECT_EQ(flesh.samples[i].rest, before.samples[at(map->origin[i][0])].rest);
  }
}

TEST(FleshEdits, RemovePolygonsLeavesTheRim) {
  Flesh flesh = make_flesh(make_grid(4, 4));
  std::vector<bool> remove(9, false);
  remove[4] = true;  // the middle
  ASSERT_TRUE(remove_polygons(flesh, remove));
  EXPECT_EQ(flesh.columns(), 16);
  EXPECT_EQ(flesh.surface.polygon_count(), 8);
  remove.assign(8, false);
  remove[0] = true;  // a corner column goes with it
  const auto map = remove_polygons(flesh, remove);
  ASSERT_TRUE(map);
  EXPECT_EQ(flesh.columns(), 15);
  EXPECT_EQ(map->new_of_old[0], -1);
  EXPECT_EQ(map->new_of_old[1], 0);
}

TEST(FleshEdits, RefuseWrongListsAndLeavingNothing) {
  Flesh flesh = make_flesh(make_grid(3, 3));
  EXPECT_FALSE(remove_columns(flesh, std::vector<bool>(8, false)));
  EXPECT_FALSE(remove_polygons(flesh, std::vector<bool>(9, false)));
  EXPECT_FALSE(remove_polygons(flesh, std::vector<bool>(4, true)));
  std::vector<bool> middle(9, false);
  middle[4] = true;
  const auto result = remove_columns(flesh, middle);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().what.find("no polygon would be left"), std::string::npos);
  EXPECT_EQ(flesh.columns(), 9) << "unchanged";
}

TEST(PolygonStrain, IsThatOfTheMostStrainedEdgeOfTheSkin) {
  Flesh flesh = make_flesh(make_grid(3, 2));
  std::vector<Vec3> x = network_of(flesh).network.rest;
  EXPECT_EQ(polygon_strain(flesh, x), (std::vector<double>{0, 0}));
  x[at(flesh.sample(2, 2))].x = 3;     // of the second square alone
  x[at(flesh.sample(0, 0))].x = -100;  // bone does not count
  EXPECT_EQ(polygon_strain(flesh, x)[0], 0);
  EXPECT_DOUBLE_EQ(polygon_strain(flesh, x)[1], 1);
  x[at(flesh.sample(2, 2))].x = 1.5;  // half as long is as strained as twice as long
  EXPECT_DOUBLE_EQ(polygon_strain(flesh, x)[1], 1);
}

}  // namespace
}  // namespace turgor
