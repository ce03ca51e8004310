// Against CalculiX, an independent solver (Debian's calculix-ccx).
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "fem/voxel_bodies.hpp"
#include "turgor/geometry/mesh_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

class Calculix : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v ccx > /dev/null 2>&1") != 0) GTEST_SKIP() << "calculix-ccx is not installed";
    folder_ = fs::temp_directory_path() / ("turgor_calculix_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  /// Displacements of the corners that CalculiX finds with quadratic elements (C3D20R, which do not lock).
  /// Nodes in the middle of edges are held as far as both ends are.
  [[nodiscard]] std::vector<Vec3> displacements(const ElementMesh& mesh, const ElasticMaterial& material,
                                                std::vector<NodeSupport> supports,
                                                const ElasticLoad& load) const {
    std::ofstream out(folder_ / "case.inp");
    out.precision(16);
    std::vector<Vec3> points = mesh.points;
    const auto elements = with_middles(mesh, points, supports);
    out << "*NODE, NSET=ALL\n";
    for (std::size_t p = 0; p < points.size(); ++p)
      out << p + 1 << ", " << points[p].x << ", " << points[p].y << ", " << points[p].z << "\n";
    out << "*ELEMENT, TYPE=C3D20R, ELSET=BODY\n";
    for (std::size_t e = 0; e < elements.size(); ++e) {
      out << e + 1;
      for (std::size_t n = 0; n < 20; ++n) out << (n == 10 ? ",\n" : ", ") << elements[e][n] + 1;
      out << "\n";
    }
    out << "*MATERIAL, NAME=M\n*ELASTIC\n"
        << material.youngs_modulus_mpa << ", " << material.poissons_ratio << "\n";
    out << "*DENSITY\n"
        << material.density_g_mm3 << "\n*SOLID SECTION, ELSET=BODY, MATERIAL=M\n*STEP\n*STATIC\n";
    out << "*BOUNDARY\n";
    for (const NodeSupport& s : supports)
      for (int c = 0; c < 3; ++c)
        if (s.held[static_cast<std::size_t>(c)])
          out << s.node + 1 << ", " << c + 1 << ", " << c + 1 << ", " << s.displacement_mm[c] << "\n";
    const double g = length(load.gravity_mm_ms2);
    const Vec3 d = normalized(load.gravity_mm_ms2);
    if (g > 0) out << "*DLOAD\nBODY, GRAV, " << g << ", " << d.x << ", " << d.y << ", " << d.z << "\n";
    out << "*NODE PRINT, NSET=ALL\nU\n*END STEP\n";
    out.close();
    const std::string command = "cd '" + folder_.string() + "' && OMP_NUM_THREADS=1 ccx case > ccx.log 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return read(mesh.points.size(), points.size());
  }

 private:
  static std::vector<std::array<int, 20>> with_middles(const ElementMesh& mesh, std::vector<Vec3>& points,
                                                       std::vector<NodeSupport>& supports) {
    constexpr int edges[12][2] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                  {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
    const auto both = [](const std::array<bool, 3>& a, const std::array<bool, 3>& b) {
      return std::array{a[0] && b[0], a[1] && b[1], a[2] && b[2]};
    };
    std::map<int, std::vector<NodeSupport>> held;
    for (const NodeSupport& s : supports) held[s.node].push_back(s);
    std::map<std::array<int, 2>, int> middles;
    std::vector<std::array<int, 20>> elements;
    for (const auto& element : mesh.hexahedra) {
      std::array<int, 20> nodes{};
      std::copy(element.begin(), element.end(), nodes.begin());
      for (std::size_t e = 0; e < 12; ++e) {
        const int a = element[static_cast<std::size_t>(edges[e][0])],
                  b = element[static_cast<std::size_t>(edges[e][1])];
        const auto [at, added] =
            middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(points.size()));
        nodes[8 + e] = at->second;
        if (!added) continue;
        points.push_back((points[static_cast<std::size_t>(a)] + points[static_cast<std::size_t>(b)]) * 0.5);
        for (const NodeSupport& x : held[a])
          for (const NodeSupport& y : held[b])
            supports.push_back({at->second, both(x.held, y.held), x.displacement_mm});
      }
      elements.push_back(nodes);
    }
    return elements;
  }

  [[nodiscard]] std::vector<Vec3> read(std::size_t points, std::size_t all) const {
    std::vector<Vec3> u(points);
    std::ifstream in(folder_ / "case.dat");
    std::size_t found = 0;
    for (std::string line; std::getline(in, line);) {
      std::istringstream fields(line);
      std::size_t node = 0;
      Vec3 v;
      if (!(fields >> node >> v.x >> v.y >> v.z) || node < 1 || node > all) continue;
      if (node <= points) u[node - 1] = v;
      ++found;
    }
    EXPECT_EQ(found, all);
    return u;
  }
  fs::path folder_;
};

using Inside = std::function<bool(int, int, int)>;

SolidMesh refined(const Index3& n, int parts, const Inside& inside) {
  return voxel_body({n[0] * parts, n[1] * parts, n[2] * parts}, 1.0 / parts,
                    [&](int i, int j, int k) { return inside(i / parts, j / parts, k / parts); });
}

// The values at the points of `few` among those of `many`.
std::vector<Vec3> at_points_of(const SolidMesh& few, const SolidMesh& many, const std::vector<Vec3>& values) {
  const auto key = [](const Vec3& p) {
    return std::array{std::lround(p.x * 240), std::lround(p.y * 240), std::lround(p.z * 240)};
  };
  std::map<std::array<long, 3>, Vec3> by_place;
  for (std::size_t p = 0; p < many.points.size(); ++p) by_place[key(many.points[p])] = values[p];
  std::vector<Vec3> out;
  for (const Vec3& p : few.points) out.push_back(by_place.at(key(p)));
  return out;
}

// √ of the energy of u − reference over that of the reference, both taken as trilinear between the points.
double energy_difference(const ElementMesh& mesh, const ElasticBody& body, const std::vector<Vec3>& u,
                         const std::vector<Vec3>& reference) {
  std::vector<Vec3> difference;
  for (std::size_t p = 0; p < u.size(); ++p) difference.push_back(u[p] - reference[p]);
  const auto energy = [&](const std::vector<Vec3>& v) { return mesh_forces(mesh, body, v)->energy_nmm; };
  return std::sqrt(energy(difference) / energy(reference));
}

// On three planes it slides, on a fourth it is pulled: nothing is singular.
TEST_F(Calculix, AgreesOnASmoothProblem) {
  const auto all = [](int, int, int) { return true; };
  const SolidMesh theirs = refined({3, 2, 4}, 2, all), ours = refined({3, 2, 4}, 8, all);
  const auto supports_of = [](const SolidMesh& solid) {
    std::vector<NodeSupport> supports;
    for (std::size_t p = 0; p < solid.points.size(); ++p) {
      const Vec3& x = solid.points[p];
      const bool top = x.z > 4 - 1e-9;
      const std::array<bool, 3> held{x.x < 1e-9, x.y < 1e-9, x.z < 1e-9 || top};
      if (held[0] || held[1] || held[2])
        supports.push_back({static_cast<int>(p), held, {0, 0, top ? 0.001 : 0}});
    }
    return supports;
  };
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.00981, 0.005, -0.02};
  for (const double ratio : {0.0, 0.3, 0.45, 0.49}) {
    const ElasticBody body = body_of(0.015, ratio, 1.04e-3);
    const auto u =
        at_points_of(theirs, ours, solved(ours, body, supports_of(ours), load, 1e-8).displacement_mm);
    const auto reference = displacements(hexahedra_of(theirs), body.materials[0], supports_of(theirs), load);
    const double difference = distance(u, reference) / norm(reference);
    const double energy = energy_difference(hexahedra_of(theirs), body, u, reference);
    std::printf("    nu %.2f: displacements differ by %.3g, in the energy norm by %.3g\n", ratio, difference,
                energy);
    EXPECT_LT(difference, 0.005) << ratio;
    EXPECT_LT(energy, ratio < 0.46 ? 0.01 : 0.02) << ratio;
  }
}

// Re-entrant edges, which neither resolves: both converge slowly to the same.
TEST_F(Calculix, AgreesOnAnIrregularBody) {
  const auto inside = [](int i, int j, int k) {
    return !(i >= 2 && i < 4 && j == 1) && !(k == 5 && i < 3) && !(i >= 4 && k >= 4 && j == 0);
  };
  const SolidMesh theirs = refined({6, 3, 8}, 2, inside), ours = refined({6, 3, 8}, 6, inside);
  const auto supports_of = [](const SolidMesh& solid) {
    auto supports = supports_where(solid, [](const Vec3& p) { return p.z < 1e-9; });
    for (NodeSupport s :
         supports_where(solid, [](const Vec3& p) { return p.z > 8 - 1e-9; }, {false, false, true})) {
      s.displacement_mm.z = 0.05;
      supports.push_back(s);
    }
    return supports;
  };
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.00981, 0.002, 0};
  const ElasticBody body = body_of(0.015, 0.45, 1.04e-3);
  const auto u =
      at_points_of(theirs, ours, solved(ours, body, supports_of(ours), load, 1e-8).displacement_mm);
  const auto reference = displacements(hexahedra_of(theirs), body.materials[0], supports_of(theirs), load);
  const double difference = distance(u, reference) / norm(reference);
  std::printf("    irregular body: displacements differ by %.3g\n", difference);
  EXPECT_LT(difference, 0.03);
}

// The cubes of a surface, 1 mm each; outside where it is not there.
Inside cubes_of(const std::string& name, int resolution, Index3& size) {
  const fs::path file = fs::path(TURGOR_SOURCE_DIR) / "../shared/data/meshes" / name;
  if (!fs::exists(file)) return {};
  const auto surface = read_mesh(file);
  EXPECT_TRUE(surface) << surface.error().message();
  VoxelOptions options;
  options.resolution = resolution;
  auto grid = voxelise(*surface, options);
  EXPECT_TRUE(grid) << grid.error().message();
  size = grid->size;
  return [grid = *std::move(grid)](int i, int j, int k) { return grid.test(i, j, k); };
}

struct Agreement {
  double vertices = 0;  // largest difference of those that move by more than a tenth of the largest
  double energy = 0;    // norm of the difference over that of the reference
};

Agreement agreement(const SolidMesh& at, const ElasticBody& body, const std::vector<Vec3>& u,
                    const std::vector<Vec3>& reference) {
  Agreement out{0, energy_difference(hexahedra_of(at), body, u, reference)};
  double largest = 0;
  for (const Vec3& v : reference) largest = std::max(largest, length(v));
  for (std::size_t p = 0; p < u.size(); ++p) {
    if (length(reference[p]) > 0.1 * largest)
      out.vertices = std::max(out.vertices, distance(u[p], reference[p]) / length(reference[p]));
  }
  return out;
}

class CalculixSurface : public Calculix, public testing::WithParamInterface<std::pair<std::string, int>> {};

// Held below, pushed sideways by its weight: gear and bunny, E 100 kPa, ν 0.45. Compared at the corners of
// the cubes; each is parted in 4³ of their quadratic elements and 12³ of ours, as its edges are re-entrant.
TEST_P(CalculixSurface, Agrees) {
  const auto& [name, resolution] = GetParam();
  Index3 size;
  const Inside inside = cubes_of(name, resolution, size);
  if (!inside) GTEST_SKIP() << name << " is looked for in ../shared/data/meshes, which is not there";
  const int up = name == "bunny.ply" ? 1 : 2;
  const auto supports_of = [&](const SolidMesh& solid) {
    double lowest = 1e300;
    for (const Vec3& p : solid.points) lowest = std::min(lowest, p[up]);
    return supports_where(solid, [&](const Vec3& p) { return p[up] < lowest + 1.001; });
  };
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.00981, 0.002, -0.005};
  const ElasticBody body = body_of(0.1, 0.45, 1.04e-3);
  const SolidMesh theirs = refined(size, 4, inside), ours = refined(size, 12, inside),
                  base = refined(size, 1, inside);
  std::printf("    %s: %zu cubes, theirs %zu, ours %zu\n", name.c_str(), base.tetrahedra.size() / 5,
              theirs.tetrahedra.size() / 5, ours.tetrahedra.size() / 5);
  const auto fine = solved(ours, body, supports_of(ours), load, 1e-8).displacement_mm;
  const auto found = displacements(hexahedra_of(theirs), body.materials[0], supports_of(theirs), load);
  const Agreement a =
      agreement(base, body, at_points_of(base, ours, fine), at_points_of(base, theirs, found));
  std::printf("    at %zu points: %.3g at vertices, %.3g in the energy norm\n", base.points.size(),
              a.vertices, a.energy);
  EXPECT_LT(a.vertices, 0.02);
  EXPECT_LT(a.energy, 0.01);
}
INSTANTIATE_TEST_SUITE_P(Meshes, CalculixSurface,
                         testing::Values(std::pair<std::string, int>("gear.ply", 9),
                                         std::pair<std::string, int>("bunny.ply", 8)));

}  // namespace
}  // namespace turgor
