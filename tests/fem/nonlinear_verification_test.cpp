// Large strains and meshes of any element against closed forms and the literature: docs/verification.md has
// the numbers.
#include <gtest/gtest.h>

#include <map>

#include "fem/element_meshes.hpp"
#include "fem/voxel_bodies.hpp"

namespace turgor {
namespace {

void report(const std::string& what, double value) {
  std::printf("    %-72s %.8g\n", what.c_str(), value);
}

ElasticMaterial neo_hookean(double ratio) {
  return {.youngs_modulus_mpa = 0.015, .poissons_ratio = ratio, .law = ElasticLaw::neo_hookean};
}

// Any affine displacement on distorted elements, linear and by half of its length.
TEST(MeshVerification, PatchTestIsExact) {
  const auto affine = [](const Vec3& p) {
    return Vec3{0.5 * p.x + 0.2 * p.y, -0.1 * p.z - 0.2 * p.y, 0.3 * p.x + 0.05 * p.z};
  };
  for (const ElementKind kind : kElementKinds) {
    ElementMesh mesh = box_mesh(kind, {3, 3, 3}, {3, 3, 3});
    ElasticSupports supports;
    hold(
        supports.nodes, mesh,
        [](const Vec3& p) {
          return std::min({p.x, p.y, p.z}) < 0.5 || std::max({p.x, p.y, p.z}) > 2.5;
        },
        kAll, affine);
    const auto moves = random_displacement(mesh.points.size(), 0.5);
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
      const Vec3 x = mesh.points[p];
      if (std::min({x.x, x.y, x.z}) > 0.5 && std::max({x.x, x.y, x.z}) < 2.5) mesh.points[p] += moves[p];
    }
    for (const double ratio : {0.3, 0.499}) {
      for (const ElasticLaw law : {ElasticLaw::linear, ElasticLaw::neo_hookean}) {
        ElasticMaterial material = neo_hookean(ratio);
        material.law = law;
        const ElasticSolution s = solved(mesh, body_of(material), supports, {});
        double worst = 0;
        for (std::size_t p = 0; p < mesh.points.size(); ++p)
          worst = std::max(worst, length(s.displacement_mm[p] - affine(mesh.points[p])));
        report(
            std::string(name_of(kind)) + ", " + std::string(name_of(law)) + ", nu " + std::to_string(ratio),
            worst);
        EXPECT_LT(worst, 1e-10);
        const auto stress = mesh_stress(mesh, body_of(material), s.displacement_mm);
        ASSERT_TRUE(stress);
        for (const ElementStress& e : *stress)
          EXPECT_NEAR(von_mises(e.stress_mpa), von_mises(stress->front().stress_mpa), 1e-10);
      }
    }
  }
}

// Cauchy stress along a principal axis of stretch λ: 2 W' J^(−5/3) (λ² − I/3) + K (J − 1).
double principal_stress(const ElasticMaterial& m, const std::array<double, 3>& stretch, std::size_t axis) {
  double squares = 0, j = 1;
  for (const double s : stretch) squares += s * s, j *= s;
  const double c20 = m.law == ElasticLaw::mooney_rivlin ? m.c20_mpa : 0;
  const double slope = 0.5 * m.shear_modulus() + 2 * c20 * (squares * std::pow(j, -2.0 / 3) - 3);
  return 2 * slope * std::pow(j, -5.0 / 3) * (stretch[axis] * stretch[axis] - squares / 3) +
         m.bulk_modulus() * (j - 1);
}

// With the first `pulled` axes at the stretch, that of the others at which they carry nothing (bisection).
std::array<double, 3> free_across(const ElasticMaterial& m, double stretch, std::size_t pulled) {
  double low = 0.1, high = 6;
  std::array<double, 3> all{};
  for (int i = 0; i < 200; ++i) {
    const double across = 0.5 * (low + high);
    for (std::size_t a = 0; a < 3; ++a) all[a] = a < pulled ? stretch : across;
    (principal_stress(m, all, 2) > 0 ? high : low) = across;
  }
  return all;
}

TEST(MeshVerification, PulledOneWayAndTwoWaysIsTheClosedForm) {
  const ElasticMaterial face = ElasticMaterial::mooney_rivlin(2.5e-3, 1.175e-3, 0.49);
  double worst_stretch = 0, worst_force = 0;
  for (const ElementKind kind : kElementKinds) {
    const ElementMesh mesh = box_mesh(kind, {2, 2, 2}, {1, 1, 1});
    for (const ElasticMaterial& material : {neo_hookean(0.3), neo_hookean(0.499), face}) {
      for (const std::size_t pulled : {1U, 2U}) {
        for (const double stretch : {0.5, 0.8, 1.6, 2.0}) {
          ElasticSupports supports{symmetry_planes(mesh), {}};
          for (std::size_t a = 0; a < pulled; ++a) {
            Held held{};
            held[a] = true;
            const int axis = static_cast<int>(a);
            hold(
                supports.nodes, mesh, [&](const Vec3& p) { return p[axis] > 1 - 1e-9; }, held,
                [&](const Vec3&) {
                  return Vec3{1, 1, 1} * (stretch - 1);
                });
          }
          const ElasticSolution s = solved(mesh, body_of(material), supports, {});
          const auto exact = free_across(material, stretch, pulled);
          double force = 0;
          for (std::size_t p = 0; p < mesh.points.size(); ++p) {
            const Vec3& x = mesh.points[p];
            const Vec3 moved{(exact[0] - 1) * x.x, (exact[1] - 1) * x.y, (exact[2] - 1) * x.z};
            worst_stretch = std::max(worst_stretch, length(s.displacement_mm[p] - moved));
            if (x.x > 1 - 1e-9) force += s.reaction_n[p].x;
          }
          const double expected = principal_stress(material, exact, 0) * exact[1] * exact[2];
          worst_force = std::max(worst_force, std::abs(force / expected - 1));
          const auto stress = mesh_stress(mesh, body_of(material), s.displacement_mm);
          ASSERT_TRUE(stress);
          EXPECT_NEAR(stress->front().stress_mpa.xx, principal_stress(material, exact, 0), 1e-9);
          EXPECT_NEAR(stress->front().strain.xx, std::log(stretch), 1e-9);
        }
      }
    }
  }
  report("stretch across, worst error", worst_stretch);
  report("force, worst relative error", worst_force);
  EXPECT_LT(worst_stretch, 1e-7);
  EXPECT_LT(worst_force, 1e-7);
}

// A material of its own for each element: none shares its mean with another.
void set_apart(ElasticBody& body, const ElementMesh& mesh) {
  body.materials.resize(mesh.size(), body.materials[0]);
  for (std::size_t e = 0; e < mesh.size(); ++e) body.material.push_back(static_cast<std::uint8_t>(e));
}

// Cook's membrane (Cook 1974) in plane strain, n by n by 1 cubes; `apart`: each element alone takes its mean.
struct Cook {
  ElementMesh mesh;
  ElasticSupports supports;
  ElasticLoad load;
  std::size_t corner = 0;
};
Cook cooks_membrane(ElementKind kind, int n, double traction) {
  Cook cook;
  cook.mesh = box_mesh(kind, {n, n, 1}, [&](const Vec3& p) {
    return Vec3{48 * p.x, 44 * p.x + p.y * (44 * (1 - p.x) + 16 * p.x), p.z * 48 / n};
  });
  hold(cook.supports.nodes, cook.mesh, [](const Vec3&) { return true; }, {false, false, true});
  hold_base(cook.supports.nodes, cook.mesh, 0);
  const auto number = [&](int j, int k) { return (k * (n + 1) + j) * (n + 1) + n; };
  for (int j = 0; j < n; ++j)
    cook.load.surfaces.push_back(
        {{number(j, 0), number(j + 1, 0), number(j + 1, 1), number(j, 1)}, {0, traction, 0}, 0});
  cook.corner = at(number(n, 0));
  return cook;
}
double cooks_corner(ElementKind kind, int n, ElasticBody body, double traction, bool apart = false) {
  const Cook cook = cooks_membrane(kind, n, traction);
  if (apart) set_apart(body, cook.mesh);
  return solved(cook.mesh, body, cook.supports, cook.load).displacement_mm[cook.corner].y;
}

TEST(MeshVerification, CooksMembraneOfPrismsAndTetrahedraDoesNotLock) {
  const ElasticBody body = body_of(250, 0.4999);
  constexpr double converged = 7.77;  // of hexahedra, extrapolated: ElasticVerification.CooksMembrane…
  for (const ElementKind kind : {ElementKind::prisms, ElementKind::tetrahedra}) {
    std::map<int, double> corner;
    for (const int n : {6, 12, 24}) {
      corner[n] = cooks_corner(kind, n, body, 6.25);
      report("corner at nu 0.4999, mm, " + std::string(name_of(kind)) + ", cubes a side " + std::to_string(n),
             corner[n]);
    }
    const double locked = cooks_corner(kind, 6, body, 6.25, true);
    report("the same without averaging, 6 a side", locked);
    EXPECT_LT(locked, 0.5 * corner[6]);
    for (const int n : {12, 24}) EXPECT_GT((converged - corner[n / 2]) / (converged - corner[n]), 1.8) << n;
    EXPECT_NEAR(corner[24] / converged, 1, 0.08);
  }
}

// Neo-Hookean, μ 80.1938 and K 400889.8 MPa (ν 0.4999), traction 6.25.
TEST(MeshVerification, CooksMembraneAtLargeStrains) {
  ElasticMaterial material{.poissons_ratio = 0.4999, .law = ElasticLaw::neo_hookean};
  material.youngs_modulus_mpa = 2 * 80.1938 * 1.4999;
  constexpr double converged =
      6.92;  // of hexahedra, extrapolated from 6.619, 6.814, 6.884 of 8, 16, 32 a side
  for (const ElementKind kind : kElementKinds) {
    std::map<int, double> corner;
    for (const int n : {6, 12}) {
      corner[n] = cooks_corner(kind, n, body_of(material), 6.25);
      report("corner, neo-Hookean, mm, " + std::string(name_of(kind)) + ", cubes a side " + std::to_string(n),
             corner[n]);
    }
    EXPECT_GT((converged - corner[6]) / (converged - corner[12]), 1.8);
    EXPECT_NEAR(corner[12] / converged, 1, kind == ElementKind::hexahedra ? 0.03 : 0.2);
  }
}

// A cube of rubber between plates that hold it, pressed by a tenth of its height: the force on the plates.
double bonded_force(ElementKind kind, int n, ElasticBody body, bool apart = false) {
  const ElementMesh mesh = box_mesh(kind, {n, n, n}, {1, 1, 1});
  ElasticSupports supports;
  hold_ends(supports.nodes, mesh, 2, {0, 0, -0.1});
  if (apart) set_apart(body, mesh);
  const ElasticSolution s = solved(mesh, body, supports, {});
  double force = 0;
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    if (mesh.points[p].z < 1e-9) force += s.reaction_n[p].z;
  return force;
}

TEST(MeshVerification, ANearlyIncompressibleBlockBetweenPlatesDoesNotLock) {
  for (const ElasticLaw law : {ElasticLaw::linear, ElasticLaw::neo_hookean}) {
    ElasticMaterial material = neo_hookean(0.499);
    material.law = law, material.youngs_modulus_mpa = 1;
    std::map<ElementKind, std::map<int, double>> force;
    for (const ElementKind kind : kElementKinds) {
      for (const int n : {3, 6}) {
        force[kind][n] = bonded_force(kind, n, body_of(material));
        report("force, N, " + std::string(name_of(law)) + ", " + name_of(kind) + ", cubes a side " +
                   std::to_string(n),
               force[kind][n]);
      }
    }
    const double converged = law == ElasticLaw::linear ? 0.1246 : 0.1394;  // of hexahedra, extrapolated
    EXPECT_NEAR(force[ElementKind::hexahedra][6] / converged, 1, 0.02);
    EXPECT_NEAR(force[ElementKind::prisms][6] / converged, 1, 0.03);
    EXPECT_NEAR(force[ElementKind::tetrahedra][6] / converged, 1, 0.17);
    EXPECT_GT(
        (force[ElementKind::tetrahedra][3] - converged) / (force[ElementKind::tetrahedra][6] - converged),
        2.3);
    if (law != ElasticLaw::linear) continue;
    const double locked = bonded_force(ElementKind::tetrahedra, 3, body_of(material), true);
    report("tetrahedra without averaging, 3 a side", locked);
    EXPECT_GT(locked, 8 * converged);
  }
}

// A cantilever bent far by a force at its end: the elastica (Mattiasson 1981, table 1), P L² / E I = 1, 2, 5.
TEST(MeshVerification, ACantileverBentFarIsTheElastica) {
  constexpr double length_mm = 20, e = 10, inertia = 1.0 / 12;
  struct Row {
    double load, down, back;
  };
  for (const ElasticLaw law : {ElasticLaw::corotational, ElasticLaw::st_venant_kirchhoff}) {
    for (const Row& row : {Row{1, 0.30172, 0.05643}, Row{2, 0.49346, 0.16064}, Row{5, 0.71379, 0.38763}}) {
      const ElementMesh mesh = box_mesh(ElementKind::hexahedra, {80, 1, 4}, {length_mm, 0.25, 1});
      ElasticSupports supports;
      // Held in its plane, for it would buckle out of it.
      hold(supports.nodes, mesh, [](const Vec3&) { return true; }, {false, true, false});
      hold_base(supports.nodes, mesh, 0);
      ElasticLoad load;
      std::vector<std::size_t> end;
      for (std::size_t p = 0; p < mesh.points.size(); ++p)
        if (mesh.points[p].x > length_mm - 1e-9) end.push_back(p);
      const double force = row.load * e * inertia * 0.25 / (length_mm * length_mm);
      for (const std::size_t p : end)
        load.forces.push_back({static_cast<int>(p), {0, 0, -force / static_cast<double>(end.size())}});
      const ElasticBody body = body_of({.youngs_modulus_mpa = e, .poissons_ratio = 0, .law = law});
      const ElasticSolution s = solved(mesh, body, supports, load);
      Vec3 tip;
      for (const std::size_t p : end) tip += s.displacement_mm[p] / static_cast<double>(end.size());
      report(std::string(name_of(law)) + ", P L^2 / E I " + std::to_string(row.load) + ", down / elastica's",
             -tip.z / length_mm / row.down);
      report("    Newton steps", s.newton_steps);
      EXPECT_NEAR(-tip.z / length_mm, row.down, 0.02 * row.down);
      EXPECT_NEAR(-tip.x / length_mm, row.back, 0.03 * row.back);
      EXPECT_LE(s.newton_steps, 40);
    }
  }
}

}  // namespace
}  // namespace turgor
