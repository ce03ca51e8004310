// Against closed forms: docs/verification.md has the numbers.
#include <gtest/gtest.h>

#include <map>
#include <numbers>

#include "fem/voxel_bodies.hpp"

namespace turgor {
namespace {

using std::numbers::pi;

void report(const char* what, double value) {
  std::printf("    %-64s %.6g\n", what, value);
}

std::vector<NodeSupport> held_surface(const SolidMesh& solid) {
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < solid.points.size(); ++p)
    if (solid.on_surface[p] != 0) supports.push_back({static_cast<int>(p), {true, true, true}, {}});
  return supports;
}

using Field = std::function<Vec3(const Vec3&)>;

// Relative error over the nodes of a unit cube of n³ cubes that carries the body force −div σ of `exact`.
double manufactured_error(int n, double ratio, const Field& exact, const Field& minus_divergence) {
  const double h = 1.0 / n;
  const SolidMesh solid = voxel_box({n, n, n}, h);
  ElasticLoad load;
  std::vector<Vec3> expected;
  for (std::size_t p = 0; p < solid.points.size(); ++p) {
    expected.push_back(exact(solid.points[p]));
    if (solid.on_surface[p] == 0)
      load.forces.push_back({static_cast<int>(p), minus_divergence(solid.points[p]) * (h * h * h)});
  }
  const ElasticSolution s = solved(solid, body_of(1, ratio), held_surface(solid), load, 1e-8);
  return distance(s.displacement_mm, expected) / norm(expected);
}

TEST(ElasticVerification, ManufacturedSolutionConvergesWithTheSquareOfTheSpacing) {
  const ElasticMaterial material{1, 0.3, 0};
  const double mu = material.shear_modulus(), lambda = material.lame_lambda();
  const auto exact = [](const Vec3& p) {
    return Vec3{1, 2, -1} * (std::sin(pi * p.x) * std::sin(pi * p.y) * std::sin(pi * p.z));
  };
  const auto force = [&](const Vec3& p) {
    const double sx = std::sin(pi * p.x), sy = std::sin(pi * p.y), sz = std::sin(pi * p.z);
    const double cx = std::cos(pi * p.x), cy = std::cos(pi * p.y), cz = std::cos(pi * p.z);
    const Vec3 gradient_of_divergence =
        Vec3{-sx * sy * sz + 2 * cx * cy * sz - cx * sy * cz, cx * cy * sz - 2 * sx * sy * sz - sx * cy * cz,
             cx * sy * cz + 2 * sx * cy * cz + sx * sy * sz} *
        (pi * pi);
    return exact(p) * (3 * pi * pi * mu) - gradient_of_divergence * (lambda + mu);
  };
  double before = 0;
  for (const int n : {8, 16, 32}) {
    const double error = manufactured_error(n, 0.3, exact, force);
    report(("nu 0.3, relative error at spacing 1/" + std::to_string(n)).c_str(), error);
    if (before > 0) EXPECT_NEAR(before / error, 4, 0.4);
    before = error;
  }
  EXPECT_LT(before, 0.005);
}

// A field that keeps volumes, as the ratio goes to ½: no locking.
TEST(ElasticVerification, NearIncompressibilityDoesNotLock) {
  const auto s = [](double t, int derivative) {
    const double a = 2 * pi * t;
    switch (derivative) {
      case 0:
        return 0.5 * (1 - std::cos(a));
      case 1:
        return pi * std::sin(a);
      case 2:
        return 2 * pi * pi * std::cos(a);
      default:
        return -4 * pi * pi * pi * std::sin(a);
    }
  };
  const auto exact = [&](const Vec3& p) {
    return Vec3{s(p.x, 0) * s(p.y, 1) * s(p.z, 0), -s(p.x, 1) * s(p.y, 0) * s(p.z, 0), 0};
  };
  for (const double ratio : {0.3, 0.45, 0.49, 0.499}) {
    const double mu = ElasticMaterial{1, ratio, 0}.shear_modulus();
    const auto force = [&](const Vec3& p) {
      const double x = s(p.x, 2) * s(p.y, 1) * s(p.z, 0) + s(p.x, 0) * s(p.y, 3) * s(p.z, 0) +
                       s(p.x, 0) * s(p.y, 1) * s(p.z, 2);
      const double y = s(p.x, 3) * s(p.y, 0) * s(p.z, 0) + s(p.x, 1) * s(p.y, 2) * s(p.z, 0) +
                       s(p.x, 1) * s(p.y, 0) * s(p.z, 2);
      return Vec3{-x, y, 0} * mu;
    };
    const double coarse = manufactured_error(10, ratio, exact, force);
    const double fine = manufactured_error(20, ratio, exact, force);
    report(("nu " + std::to_string(ratio) + ", relative error at spacing 1/20").c_str(), fine);
    EXPECT_NEAR(coarse / fine, 4, 0.5) << ratio;
    EXPECT_LT(fine, 0.03) << ratio;
  }
}

// Timoshenko's beam: F L³ / (3 E I) + F L / (κ G A), κ = 5/6.
TEST(ElasticVerification, CantileverIsTimoshenkosBeam) {
  constexpr double length_mm = 20, side = 2, e = 100, force = 0.1;
  double error = 1;
  for (const int across : {4, 8, 12}) {
    const double h = side / across;
    const SolidMesh solid = voxel_box({across * 10, across, across}, h);
    ElasticLoad load;
    for (const auto& cube : hexahedra(solid)) {
      if (solid.points[static_cast<std::size_t>(cube[1])].x < length_mm - 1e-9) continue;
      load.surfaces.push_back({{cube[1], cube[2], cube[6], cube[5]}, {0, 0, force / (side * side)}, 0});
    }
    const ElasticSolution s = solved(
        solid, body_of(e, 0), supports_where(solid, [](const Vec3& p) { return p.x < 1e-9; }), load, 1e-7);
    double tip = 0, count = 0;
    for (std::size_t p = 0; p < solid.points.size(); ++p)
      if (solid.points[p].x > length_mm - 1e-9) tip += s.displacement_mm[p].z, count += 1;
    const double inertia = std::pow(side, 4) / 12;
    const double expected = force * std::pow(length_mm, 3) / (3 * e * inertia) +
                            force * length_mm / (5.0 / 6 * e / 2 * side * side);
    error = tip / count / expected - 1;
    report(("tip against the beam's, less 1, cubes across " + std::to_string(across)).c_str(), error);
  }
  EXPECT_LT(std::abs(error), 0.01);
}

// Cook's membrane (Cook 1974) in plane strain, E 250, ν 0.4999, shear 6.25 a unit of the right edge.
double cooks_corner(int n, double ratio) {
  ElementMesh mesh;
  const auto number = [&](int i, int j, int k) { return (k * (n + 1) + j) * (n + 1) + i; };
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const double x = static_cast<double>(i) / n, y = static_cast<double>(j) / n;
        mesh.points.push_back({48 * x, 44 * x + y * (44 * (1 - x) + 16 * x), static_cast<double>(k)});
      }
  ElasticLoad load;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh.hexahedra.push_back({number(i, j, 0), number(i + 1, j, 0), number(i + 1, j + 1, 0),
                                number(i, j + 1, 0), number(i, j, 1), number(i + 1, j, 1),
                                number(i + 1, j + 1, 1), number(i, j + 1, 1)});
    }
    load.surfaces.push_back(
        {{number(n, j, 0), number(n, j + 1, 0), number(n, j + 1, 1), number(n, j, 1)}, {0, 6.25, 0}, 0});
  }
  std::vector<NodeSupport> supports;
  for (int p = 0; p < static_cast<int>(mesh.points.size()); ++p) {
    supports.push_back({p, {false, false, true}, {}});
    if (mesh.points[static_cast<std::size_t>(p)].x == 0) supports.push_back({p, {true, true, true}, {}});
  }
  const ElasticSolution s = solved(mesh, body_of(250, ratio), {supports, {}}, load);
  return s.displacement_mm[static_cast<std::size_t>(number(n, n, 0))].y;
}

TEST(ElasticVerification, CooksMembraneDoesNotLock) {
  std::map<int, double> corner;
  for (const int n : {4, 8, 16, 32, 64}) {
    corner[n] = cooks_corner(n, 0.4999);
    report(("corner at nu 0.4999, mm, elements a side " + std::to_string(n)).c_str(), corner[n]);
  }
  EXPECT_NEAR(corner[8] / corner[64], 1, 0.06);
  EXPECT_NEAR(corner[16] / corner[64], 1, 0.02);
  EXPECT_NEAR(corner[32] / corner[64], 1, 0.007);
}

// Any linear displacement on distorted hexahedra.
TEST(ElasticVerification, PatchTestOfDistortedHexahedra) {
  ElementMesh mesh = hexahedra_of(voxel_box({4, 4, 4}, 1));
  const auto moves = random_displacement(mesh.points.size(), 0.5);
  const auto linear = [](const Vec3& p) {
    return Vec3{0.1 * p.x + 0.2 * p.y, -0.1 * p.z, 0.3 * p.x + 0.05 * p.z};
  };
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const Vec3 x = mesh.points[p];
    const bool outside = std::min({x.x, x.y, x.z}) < 0.5 || std::max({x.x, x.y, x.z}) > 3.5;
    if (outside)
      supports.push_back({static_cast<int>(p), {true, true, true}, linear(x)});
    else
      mesh.points[p] += moves[p];
  }
  const ElasticBody body = body_of(10, 0.49);
  const ElasticSolution s = solved(mesh, body, {supports, {}}, {});
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    EXPECT_LT(length(s.displacement_mm[p] - linear(mesh.points[p])), 1e-12);
  const SymmetricTensor expected = stress_of({0.1, 0, 0.05, 0.1, -0.05, 0.15}, body.materials[0]);
  const auto stress = mesh_stress(mesh, body, s.displacement_mm);
  ASSERT_TRUE(stress);
  for (const ElementStress& e : *stress) {
    EXPECT_NEAR(e.stress_mpa.xx, expected.xx, 1e-9);
    EXPECT_NEAR(e.stress_mpa.xy, expected.xy, 1e-9);
  }
}

// Lamé's thick sphere: inner radius 1, outer 2, pressure within.
double lame(double r, double e, double ratio, double pressure) {
  return pressure / (e * 7) * ((1 - 2 * ratio) * r + (1 + ratio) * 8 / (2 * r * r));
}

std::vector<NodeSupport> symmetric_octant(std::span<const Vec3> points) {
  std::vector<NodeSupport> supports;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::array<bool, 3> held{points[p].x < 1e-9, points[p].y < 1e-9, points[p].z < 1e-9};
    if (held[0] || held[1] || held[2]) supports.push_back({static_cast<int>(p), held, {}});
  }
  return supports;
}

// An octant of three patches of n² columns of n hexahedra.
ElementMesh sphere_octant(int n, std::vector<SurfaceLoad>& inner) {
  ElementMesh mesh;
  std::map<std::array<long, 3>, int> known;
  const auto point = [&](int patch, int i, int j, int k) {
    const double u = std::tan(pi / 4 * i / n), v = std::tan(pi / 4 * j / n),
                 r = 1 + static_cast<double>(k) / n;
    const Vec3 on = normalized(Vec3{1, u, v}) * r;
    const Vec3 p = patch == 0 ? on : patch == 1 ? Vec3{on.z, on.x, on.y} : Vec3{on.y, on.z, on.x};
    const std::array<long, 3> key{std::lround(p.x * 1e8), std::lround(p.y * 1e8), std::lround(p.z * 1e8)};
    const auto [at, added] = known.try_emplace(key, static_cast<int>(mesh.points.size()));
    if (added) mesh.points.push_back(p);
    return at->second;
  };
  for (int patch = 0; patch < 3; ++patch)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k) {
          const auto at = [&](int a, int b, int c) { return point(patch, i + a, j + b, k + c); };
          mesh.hexahedra.push_back({at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1),
                                    at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)});
          if (k == 0) inner.push_back({{at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)}, {}, 1});
        }
  return mesh;
}

TEST(ElasticVerification, PressurisedSphereIsLames) {
  for (const double ratio : {0.3, 0.499}) {
    double before = 0;
    for (const int n : {2, 4, 8}) {
      std::vector<SurfaceLoad> inner;
      const ElementMesh mesh = sphere_octant(n, inner);
      const ElasticSolution s =
          solved(mesh, body_of(10, ratio), {symmetric_octant(mesh.points), {}}, {{}, inner, {}});
      double error = 0, whole = 0;
      for (std::size_t p = 0; p < mesh.points.size(); ++p) {
        const double r = length(mesh.points[p]), exact = lame(r, 10, ratio, 1);
        error += squared_length(s.displacement_mm[p] - mesh.points[p] * (exact / r));
        whole += exact * exact;
      }
      error = std::sqrt(error / whole);
      report(
          ("nu " + std::to_string(ratio) + ", relative error, elements through the wall " + std::to_string(n))
              .c_str(),
          error);
      if (before > 0) EXPECT_LT(error, before / 3);
      before = error;
    }
    EXPECT_LT(before, 0.01);
  }
}

// The same of voxels: pressure acts on the steps of the cavity; the outer steps are free.
TEST(ElasticVerification, VoxelSphereConvergesToLames) {
  double before = 1;
  for (const int n : {8, 16, 32}) {
    const double h = 2.0 / n;
    const auto in_wall = [&](int i, int j, int k) {
      const double r = length(Vec3{i + 0.5, j + 0.5, k + 0.5} * h);
      return r > 1 && r < 2;
    };
    const SolidMesh solid = voxel_body({n, n, n}, h, in_wall);
    const auto in_cavity = [&](const Vec3& centre) { return length(centre) < 1; };
    ElasticLoad load;
    constexpr int low[3][4] = {{0, 3, 7, 4}, {0, 1, 5, 4}, {0, 1, 2, 3}};
    for (const auto& cube : hexahedra(solid)) {
      const Vec3 centre = solid.points[static_cast<std::size_t>(cube[0])] + Vec3{h, h, h} * 0.5;
      for (int a = 0; a < 3; ++a) {
        Vec3 step;
        step[a] = h;
        const Vec3 beyond = centre - step;
        if (beyond[a] < 0 || !in_cavity(beyond)) continue;
        Vec3 push;
        push[a] = 1;
        const auto& f = low[a];
        const auto c = [&](int number) { return cube[static_cast<std::size_t>(number)]; };
        load.surfaces.push_back({{c(f[0]), c(f[1]), c(f[2]), c(f[3])}, push, 0});
      }
    }
    const ElasticSolution s = solved(solid, body_of(10, 0.45), symmetric_octant(solid.points), load, 1e-6);
    double error = 0, whole = 0;
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const double r = length(solid.points[p]);
      if (r < 1.2 || r > 1.8) continue;
      const double exact = lame(r, 10, 0.45, 1);
      error += squared_length(s.displacement_mm[p] - solid.points[p] * (exact / r));
      whole += exact * exact;
    }
    error = std::sqrt(error / whole);
    report(("relative error in the middle of the wall, voxels a radius " + std::to_string(n)).c_str(), error);
    if (before < 1) EXPECT_NEAR(before / error, 2, 0.2);
    before = error;
  }
  EXPECT_LT(before, 0.035);
}

}  // namespace
}  // namespace turgor
