// Surfaces to voxels to tetrahedra.
#include "turgor/geometry/voxel_solid.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <string>

#include "geometry/shapes.hpp"
#include "geometry/solid_checks.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

using test::expect_conforming;
using testing::box;
using testing::reversed;
using testing::sphere;
using testing::torus;

VoxelOptions options(int resolution, bool border = false) {
  VoxelOptions o;
  o.resolution = resolution, o.border = border;
  return o;
}

VoxelGrid voxels_of(const TriMesh& surface, const VoxelOptions& o) {
  auto grid = voxelise(surface, o);
  EXPECT_TRUE(grid) << (grid ? "" : grid.error().message());
  return grid ? *std::move(grid) : VoxelGrid({1, 1, 1});
}

std::string error_of(const TriMesh& surface, const VoxelOptions& o) {
  const auto grid = voxelise(surface, o);
  if (grid) return {};
  EXPECT_EQ(grid.error().kind, ErrorKind::bad_input);
  return grid.error().message();
}

SolidMesh solid_from(const VoxelGrid& grid) {
  auto solid = solid_of(grid);
  EXPECT_TRUE(solid);
  return solid ? *std::move(solid) : SolidMesh{};
}

Vec3 centre_of(const VoxelGrid& g, int i, int j, int k) {
  return g.lower + Vec3{i + 0.5, j + 0.5, k + 0.5} * g.spacing;
}

/// Counts the voxels that differ from inside(centre), leaving out those nearer than `skin` spacings to where
/// it changes.
template <class Distance>
int differences(const VoxelGrid& g, double skin, const Distance& distance) {
  int wrong = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) {
        const double d = distance(centre_of(g, i, j, k));
        if (std::abs(d) > skin * g.spacing && (d < 0) != g.test(i, j, k)) ++wrong;
      }
    }
  }
  return wrong;
}

double volume_of(const VoxelGrid& g) {
  return static_cast<double>(g.count()) * g.spacing * g.spacing * g.spacing;
}

TriMesh turned(const TriMesh& mesh, std::uint64_t seed) {
  const RandomStream random(seed);
  const Vec3 axis = normalized(Vec3{random.normal(0), random.normal(1), random.normal(2)});
  return transformed(mesh, RigidTransform::rotate_about({}, axis, 6 * random.uniform(3)));
}

double volume_of(const SolidMesh& s, const std::array<int, 4>& t) {
  const Vec3& a = s.points[at(t[0])];
  return dot(cross(s.points[at(t[1])] - a, s.points[at(t[2])] - a), s.points[at(t[3])] - a) / 6;
}

/// A grid of voxels set at random.
VoxelGrid random_voxels(const Index3& size, double part) {
  VoxelGrid g(size);
  const RandomStream random(5);
  std::uint64_t n = 0;
  for (int k = 1; k < size[2] - 1; ++k)
    for (int j = 1; j < size[1] - 1; ++j)
      for (int i = 1; i < size[0] - 1; ++i)
        if (random.uniform(n++) < part) g.set(i, j, k);
  return g;
}

TEST(VoxelSolid, NeighboursShareWholeFacesAndTheRestIsTheSurface) {
  expect_conforming(solid_from(voxels_of(sphere(10, 3), options(13))));
  expect_conforming(solid_from(voxels_of(torus(10, 3, 40, 20), options(75, true))));
  for (const double part : {0.05, 0.5, 0.95}) expect_conforming(solid_from(random_voxels({140, 7, 9}, part)));
}

TEST(VoxelSolid, TetrahedraFillTheCubesAndAreTheRightWayRound) {
  const VoxelGrid grid = random_voxels({70, 6, 5}, 0.5);
  const SolidMesh solid = solid_from(grid);
  ASSERT_EQ(solid.tetrahedra.size(), 5 * grid.count());
  for (std::size_t c = 0; c < grid.count(); ++c) {
    for (std::size_t t = 0; t < 4; ++t)
      EXPECT_NEAR(volume_of(solid, solid.tetrahedra[5 * c + t]), 1.0 / 6, 1e-12);
    EXPECT_NEAR(volume_of(solid, solid.tetrahedra[5 * c + 4]), 1.0 / 3, 1e-12);
  }
}

TEST(VoxelSolid, CubesShareThePointsOfTheirFiveTetrahedra) {
  const VoxelGrid grid = random_voxels({70, 6, 5}, 0.4);
  const SolidMesh solid = solid_from(grid);
  const auto cubes = hexahedra(solid);
  ASSERT_EQ(5 * cubes.size(), solid.tetrahedra.size());
  const Vec3 corner[8] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                          {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  std::size_t c = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        if (!grid.test(i, j, k)) continue;
        for (std::size_t n = 0; n < 8; ++n)
          ASSERT_LT(distance(solid.points[at(cubes[c][n])], Vec3{1.0 * i, 1.0 * j, 1.0 * k} + corner[n]),
                    1e-12);
        for (std::size_t t = 5 * c; t < 5 * c + 5; ++t)
          for (const int p : solid.tetrahedra[t])
            ASSERT_NE(std::find(cubes[c].begin(), cubes[c].end(), p), cubes[c].end());
        ++c;
      }
    }
  }
  EXPECT_EQ(c, cubes.size());
}

TEST(VoxelSolid, NoPointIsStoredTwiceOrUnused) {
  const SolidMesh solid = solid_from(voxels_of(sphere(10, 3), options(67)));
  std::vector<bool> used(solid.points.size());
  for (const auto& t : solid.tetrahedra)
    for (const int p : t) used[at(p)] = true;
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  const auto before = [](const Vec3& a, const Vec3& b) {
    return std::array{a.z, a.y, a.x} < std::array{b.z, b.y, b.x};
  };
  EXPECT_TRUE(std::is_sorted(solid.points.begin(), solid.points.end(), before));
  EXPECT_EQ(std::adjacent_find(solid.points.begin(), solid.points.end()), solid.points.end());
}

TEST(Voxelise, FindsTheInsideOfABallAndARing) {
  const VoxelGrid ball = voxels_of(sphere(10, 5), options(61));
  EXPECT_EQ(differences(ball, 0.1, [](const Vec3& p) { return length(p) - 10; }), 0);
  const VoxelGrid ring = voxels_of(torus(10, 3, 200, 100), options(90));
  EXPECT_EQ(
      differences(ring, 0.1, [](const Vec3& p) { return std::hypot(std::hypot(p.x, p.y) - 10, p.z) - 3; }),
      0);
}

TEST(Voxelise, VolumeConvergesToTheSurfaces) {
  const TriMesh surface = turned(torus(10, 4, 60, 30), 3);
  const double volume = enclosed_volume(surface);
  double last = 3;
  for (const int n : {10, 20, 40, 80, 160}) {
    const double plain = std::abs(volume_of(voxels_of(surface, options(n))) / volume - 1);
    const double border = volume_of(voxels_of(surface, options(n, true))) / volume - 1;
    EXPECT_LT(plain, 4.0 / (n * std::sqrt(n))) << n;  // what is cut off is as often added
    EXPECT_GT(border, plain);
    EXPECT_LT(border, 0.62 * last) << n;  // halved as the voxels are
    last = border;
  }
}

TEST(Voxelise, LinesThroughCornersAndEdgesDoNotLeak) {
  // The octahedron's corners and edges lie on grid lines and on voxel centres wherever n is odd.
  const TriMesh octahedron = sphere(1, 0), cube = box({-1, -1, -1}, {1, 1, 1});
  for (int n = 3; n < 70; ++n) {
    const VoxelGrid g = voxels_of(octahedron, options(n));
    EXPECT_EQ(
        differences(g, 1e-3, [](const Vec3& p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z) - 1; }),
        0)
        << n;
    EXPECT_EQ(voxels_of(cube, options(n)).count(), at(n) * at(n) * at(n));
  }
  // Points on a lattice of quarters, each a tie for some n.
  TriMesh steps = sphere(1, 3);
  for (Vec3& p : steps.points)
    p = {std::round(4 * p.x) / 4, std::round(4 * p.y) / 4, std::round(4 * p.z) / 4};
  for (int n = 3; n < 70; ++n) {
    VoxelOptions o = options(n);
    o.largest_hole = 0;
    (void)voxels_of(steps, o);
  }
}

TEST(Voxelise, TurnedSurfacesNeverLeak) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const TriMesh mesh = turned(torus(10, 3, 30, 15), seed);
    const VoxelGrid g = voxels_of(mesh, options(10 + static_cast<int>(seed)));
    EXPECT_EQ(g.closed_holes, 0);
    EXPECT_NEAR(volume_of(g) / enclosed_volume(mesh), 1, 0.15);
  }
}

TEST(Voxelise, BorderVoxelsAreThoseThatTheSurfaceTouches) {
  const TriMesh mesh = turned(torus(10, 4, 30, 15), 2);
  const VoxelGrid inside = voxels_of(mesh, options(40)), all = voxels_of(mesh, options(40, true));
  const RandomStream random(9);
  for (std::size_t n = 0; n < 200'000; ++n) {
    const Index3& t = mesh.triangles[n % mesh.triangles.size()];
    const double u = std::sqrt(random.uniform(2 * n)), v = random.uniform(2 * n + 1);
    const Vec3 p = mesh.points[at(t[0])] * (1 - u) + mesh.points[at(t[1])] * (u * (1 - v)) +
                   mesh.points[at(t[2])] * (u * v);
    const Vec3 i = (p - all.lower) / all.spacing;
    ASSERT_TRUE(all.test(static_cast<int>(i.x), static_cast<int>(i.y), static_cast<int>(i.z)));
  }
  const SurfaceQuery query(mesh);
  for (int k = 0; k < all.size[2]; ++k) {
    for (int j = 0; j < all.size[1]; ++j) {
      for (int i = 0; i < all.size[0]; ++i) {
        if (inside.test(i, j, k)) ASSERT_TRUE(all.test(i, j, k));
        if (!all.test(i, j, k) || inside.test(i, j, k)) continue;
        ASSERT_LT(query.nearest(centre_of(all, i, j, k))->distance,
                  std::sqrt(0.75) * all.spacing * (1 + 1e-6));
      }
    }
  }
}

TEST(Voxelise, FacingDoesNotMatter) {
  const TriMesh mesh = turned(torus(10, 3, 40, 20), 1);
  const VoxelGrid wanted = voxels_of(mesh, options(50));
  TriMesh mixed = mesh;
  const RandomStream random(2);
  for (std::size_t t = 0; t < mixed.triangles.size(); ++t)
    if (random.uniform(t) < 0.5) std::swap(mixed.triangles[t][0], mixed.triangles[t][1]);
  EXPECT_EQ(voxels_of(reversed(mesh), options(50)).bits, wanted.bits);
  EXPECT_EQ(voxels_of(mixed, options(50)).bits, wanted.bits);
}

TEST(Voxelise, RepeatedPointsAndTrianglesDoNotMatter) {
  const TriMesh mesh = turned(torus(10, 3, 40, 20), 1);
  const VoxelGrid wanted = voxels_of(mesh, options(50));
  TriMesh soup;  // each triangle with points of its own
  for (const Index3& t : mesh.triangles) {
    const int p = static_cast<int>(soup.points.size());
    for (const int c : t) soup.points.push_back(mesh.points[at(c)]);
    soup.triangles.push_back({p, p + 1, p + 2});
  }
  soup.triangles.push_back({0, 0, 1});  // one without area
  EXPECT_EQ(voxels_of(soup, options(50)).bits, wanted.bits);
  EXPECT_EQ(voxels_of(append(mesh, mesh), options(50)).bits, wanted.bits);
}

TEST(Voxelise, WhatOverlapsIsJoined) {
  const TriMesh two = append(sphere(10, 4), sphere(8, 4, {9, 1, 0.5}));
  const auto joined = [](const Vec3& p) { return std::min(length(p) - 10, length(p - Vec3{9, 1, 0.5}) - 8); };
  EXPECT_EQ(differences(voxels_of(two, options(61)), 0.3, joined), 0);
  EXPECT_EQ(differences(voxels_of(append(two, sphere(9, 4, {3, -2, 1})), options(61)), 0.3,
                        [&](const Vec3& p) {
                          return std::min(joined(p), length(p - Vec3{3, -2, 1}) - 9);
                        }),
            0);
  // One shell that passes through itself: a horn bent so far round that its ends lie in each other.
  TriMesh horn = sphere(1, 6);
  for (Vec3& p : horn.points) {
    const double angle = 3.6 * p.z, radius = 10 + 3 * p.x;
    p = {radius * std::cos(angle), radius * std::sin(angle), 3 * p.y};
  }
  const auto bent = [](const Vec3& p) {
    double least = 1e9;
    for (const int turn : {-1, 0, 1}) {
      const double along = (std::atan2(p.y, p.x) + turn * 2 * std::numbers::pi) / 3.6;
      if (std::abs(along) < 1)
        least =
            std::min(least, std::hypot(std::hypot(p.x, p.y) - 10, p.z) - 3 * std::sqrt(1 - along * along));
    }
    return least;
  };
  EXPECT_EQ(differences(voxels_of(horn, options(61)), 0.4, bent), 0);
}

TEST(Voxelise, NestedShellsAreCavitiesHoweverTheyFace) {
  const TriMesh outer = sphere(10, 4), inner = sphere(6, 4, {1, 0, 0}), core = sphere(2, 4, {1.5, 0, 0});
  const auto hollow = [](const Vec3& p) { return std::max(length(p) - 10, 6 - length(p - Vec3{1, 0, 0})); };
  for (const TriMesh& cavity : {inner, reversed(inner)}) {
    EXPECT_EQ(differences(voxels_of(append(outer, cavity), options(61)), 0.3, hollow), 0);
    EXPECT_EQ(differences(voxels_of(append(append(outer, cavity), core), options(61)), 0.3,
                          [&](const Vec3& p) {
                            return std::min(hollow(p), length(p - Vec3{1.5, 0, 0}) - 2);
                          }),
              0);
  }
}

TEST(Voxelise, HolesSmallerThanAVoxelDoNotLeak) {
  const TriMesh whole = turned(sphere(10, 5), 4);
  VoxelOptions o = options(20);
  o.largest_hole = 0;
  const VoxelGrid wanted = voxels_of(whole, o);
  TriMesh torn{whole.points, {}};
  for (std::size_t t = 0; t < whole.triangles.size(); ++t)
    if (t % 97 != 0) torn.triangles.push_back(whole.triangles[t]);
  const VoxelGrid closed = voxels_of(torn, o);
  EXPECT_GT(closed.closed_holes, 50);
  EXPECT_EQ(closed.bits, wanted.bits);
}

TEST(Voxelise, OpenSurfacesAreAnErrorThatSaysWhere) {
  TriMesh bowl = sphere(10, 4);
  std::erase_if(bowl.triangles, [&](const Index3& t) {
    return bowl.points[at(t[0])].z + bowl.points[at(t[1])].z + bowl.points[at(t[2])].z > 0;
  });
  const std::string message = error_of(bowl, options(30));
  EXPECT_NE(message.find("hole of 20 x 20 x 0 mm"), std::string::npos) << message;
  EXPECT_NE(message.find("winding"), std::string::npos) << message;
  VoxelOptions o = options(30);
  o.fill = VoxelOptions::Fill::winding;
  EXPECT_NEAR(volume_of(voxels_of(bowl, o)) / (2 * std::numbers::pi / 3 * 1000), 1, 0.25);
  // A tube without its lids, a quarter as wide as long.
  const auto tube = [](const Vec3& p) { return std::abs(p.z) < 19.9; };
  TriMesh pipe = sphere(5, 4);
  for (Vec3& p : pipe.points) p.z *= 4;
  std::erase_if(pipe.triangles, [&](const Index3& t) {
    return !tube(pipe.points[at(t[0])]) || std::abs(pipe.points[at(t[1])].z) > 14;
  });
  EXPECT_NE(error_of(pipe, options(60)).find("hole of"), std::string::npos);
}

TEST(Voxelise, WindingAgreesWithCrossingsOnClosedSurfaces) {
  const TriMesh mesh = turned(torus(10, 3, 60, 30), 7);
  VoxelOptions o = options(40);
  const VoxelGrid wanted = voxels_of(mesh, o);
  o.fill = VoxelOptions::Fill::winding;
  const VoxelGrid found = voxels_of(mesh, o), turned_out = voxels_of(reversed(mesh), o);
  EXPECT_EQ(found.bits, wanted.bits);
  EXPECT_EQ(turned_out.bits, wanted.bits);
}

/// Winding number by the sum of all triangles' solid angles.
double winding_number(const TriMesh& mesh, const Vec3& q) {
  double sum = 0;
  for (const Index3& t : mesh.triangles) {
    const Vec3 a = mesh.points[at(t[0])] - q, b = mesh.points[at(t[1])] - q, c = mesh.points[at(t[2])] - q;
    const double x = length(a), y = length(b), z = length(c);
    sum += std::atan2(dot(a, cross(b, c)), x * y * z + dot(a, b) * z + dot(b, c) * x + dot(c, a) * y);
  }
  return sum / (2 * std::numbers::pi);
}

TEST(Voxelise, WindingClosesOpeningsAsTheSumOverAllTrianglesDoes) {
  TriMesh torn = append(turned(sphere(10, 3), 3), reversed(sphere(3, 2, {1, 2, 0})));
  std::erase_if(torn.triangles, [&](const Index3& t) {
    const Vec3& p = torn.points[at(t[0])];
    return length(p) > 9 && (p.z > 4 || p.x < -7);
  });
  VoxelOptions o = options(30);
  EXPECT_NE(error_of(torn, o).find("hole of"), std::string::npos);
  o.fill = VoxelOptions::Fill::winding;
  const VoxelGrid g = voxels_of(torn, o);
  int wrong = 0;
  for (int k = 1; k < g.size[2] - 1; ++k) {
    for (int j = 1; j < g.size[1] - 1; ++j) {
      for (int i = 1; i < g.size[0] - 1; ++i) {
        const double winding = std::abs(winding_number(torn, centre_of(g, i, j, k)));
        if (std::abs(winding - 0.5) > 0.02 && (winding > 0.5) != g.test(i, j, k)) ++wrong;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
}

TEST(Voxelise, WildInputIsAClearError) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(),
                   inf = std::numeric_limits<double>::infinity();
  const TriMesh good = sphere(10, 2);
  const auto with_point = [&](const Vec3& p) {
    TriMesh mesh = good;
    mesh.points[3] = p;
    return mesh;
  };
  for (const bool border : {false, true}) {
    const VoxelOptions o = options(20, border);
    EXPECT_NE(error_of({}, o).find("no triangles"), std::string::npos);
    EXPECT_NE(error_of(with_point({nan, 0, 0}), o).find("finite"), std::string::npos);
    EXPECT_NE(error_of(with_point({0, -inf, 0}), o).find("finite"), std::string::npos);
    EXPECT_NE(error_of(with_point({0, 0, 1e308}), o).find("spans"), std::string::npos);
    EXPECT_NE(error_of({std::vector<Vec3>(3, Vec3{1, 1, 1}), {{0, 1, 2}}}, o).find("spans"),
              std::string::npos);
    EXPECT_NE(error_of({{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}}, o).find("triangle 0"), std::string::npos);
    EXPECT_NE(error_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, -1}}}, o).find("triangle 0"),
              std::string::npos);
    EXPECT_NE(error_of({{{0, 0, 0}, {9, 1, 0}, {2, 8, 3}}, {{0, 1, 2}}}, o).find("open"), std::string::npos);
    EXPECT_NE(error_of(good, options(0, border)).find("resolution 0"), std::string::npos);
    EXPECT_NE(error_of(good, options(1 << 30, border)).find("resolution"), std::string::npos);
  }
  // An unused point may lie anywhere.
  TriMesh stray = good;
  stray.points.push_back({nan, 1e308, inf});
  EXPECT_EQ(voxels_of(stray, options(20)).bits, voxels_of(good, options(20)).bits);
  // A plate that no voxel's centre lies in.
  const TriMesh plate = box({0, 0, 0}, {10, 10, 0.001});
  EXPECT_NE(error_of(append(plate, sphere(0.01, 1, {5, 5, 3})), options(10)).find("no voxel"),
            std::string::npos);
  EXPECT_EQ(voxels_of(plate, options(10, true)).count(), 100U);
}

TEST(Voxelise, HeapsOfLooseTrianglesEndOrCanBeStopped) {
  const RandomStream random(11);
  for (const double size : {0.02, 0.3}) {
    TriMesh heap;
    for (int t = 0; t < 20'000; ++t) {
      const auto number = [&](int n) { return random.uniform(static_cast<std::uint64_t>(12 * t + n)); };
      const Vec3 place{number(0), number(1), number(2)};
      for (int c = 1; c < 4; ++c)
        heap.points.push_back(place + Vec3{number(3 * c), number(3 * c + 1), number(3 * c + 2)} * size);
      heap.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    for (const int n : {1, 10, 60}) (void)voxelise(heap, options(n, true));
    VoxelOptions o = options(60);
    o.fill = VoxelOptions::Fill::winding;
    const Context stopped({}, {}, [] { return true; });
    const auto none = voxelise(heap, o, stopped);
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().kind, ErrorKind::cancelled);
  }
}

TEST(Voxelise, SameBitsOnOneThreadAndTwo) {
  const TriMesh mesh = turned(append(torus(10, 3, 200, 100), sphere(4, 5, {10, 0, 0})), 8);
  const auto run = [&](int threads) {
    set_thread_count(threads);
    VoxelGrid grid = voxels_of(mesh, options(90, true));
    SolidMesh solid = solid_from(grid);
    set_thread_count(0);
    return std::pair(std::move(grid), std::move(solid));
  };
  const auto [one, solid_one] = run(1);
  const auto [two, solid_two] = run(2);
  EXPECT_EQ(one.bits, two.bits);
  EXPECT_TRUE(solid_one.points == solid_two.points);
  EXPECT_TRUE(solid_one.tetrahedra == solid_two.tetrahedra);
  EXPECT_TRUE(solid_one.surface_triangles == solid_two.surface_triangles);
  EXPECT_TRUE(solid_one.surface_cells == solid_two.surface_cells);
  EXPECT_TRUE(solid_one.on_surface == solid_two.on_surface);
}

/// The four inputs of the paper, where they are at hand.
TEST(Voxelise, MeshesThePapersInputs) {
  struct Input {
    const char* file;
    int resolution;
    double paper_tetrahedra;
  };
  const auto folder = std::filesystem::path(TURGOR_SOURCE_DIR).parent_path() / "shared" / "data" / "meshes";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no shared/data/meshes beside the project";
  for (const Input& input :
       {Input{"bunny.ply", 30, 35840}, Input{"bunny.ply", 75, 478140}, Input{"gear.ply", 30, 20780},
        Input{"gear.ply", 75, 271350}, Input{"happy_15535.ply", 30, 10100},
        Input{"happy_15535.ply", 75, 126610}, Input{"dragon_vrip_res2.ply", 30, 12750},
        Input{"dragon_vrip_res2.ply", 75, 158370}}) {
    const auto surface = read_mesh(folder / input.file);
    ASSERT_TRUE(surface) << surface.error().message();
    const SolidMesh solid = solid_from(voxels_of(*surface, options(input.resolution, true)));
    EXPECT_NEAR(static_cast<double>(solid.tetrahedra.size()) / input.paper_tetrahedra, 1, 0.12) << input.file;
  }
}

}  // namespace
}  // namespace turgor
