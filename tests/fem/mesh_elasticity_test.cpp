#include "turgor/fem/mesh_elasticity.hpp"

#include <limits>

#include "fem/element_meshes.hpp"
#include "fem/element_model.hpp"
#include "fem/voxel_bodies.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

ElasticMaterial material_of(ElasticLaw law, double ratio = 0.45) {
  return {.youngs_modulus_mpa = 0.015, .poissons_ratio = ratio, .law = law, .c20_mpa = 0.005};
}

// Two by two by two cubes out of shape.
ElementMesh distorted(ElementKind kind) {
  ElementMesh mesh = box_mesh(kind, {2, 2, 2}, {2, 2, 2});
  const auto moves = random_displacement(mesh.points.size(), 0.3);
  for (std::size_t p = 0; p < mesh.points.size(); ++p) mesh.points[p] += moves[p];
  return mesh;
}

// Two materials, and a factor of each element.
ElasticBody mixed_body(const ElementMesh& mesh, ElasticLaw law) {
  ElasticBody body{{material_of(law), material_of(law, 0.3)}, {}, {}};
  const RandomStream random(4);
  for (std::size_t e = 0; e < mesh.size(); ++e) {
    body.material.push_back(e % 3 == 0 ? 1 : 0);
    body.modulus_factor.push_back(0.5 + random.uniform(e));
  }
  return body;
}

TEST(MeshElasticity, ForcesAreTheGradientOfTheEnergy) {
  constexpr double step = 1e-5;
  for (const ElementKind kind : kElementKinds) {
    const ElementMesh mesh = distorted(kind);
    for (const ElasticLaw law : kElasticLaws) {
      const ElasticBody body = mixed_body(mesh, law);
      auto u = random_displacement(mesh.points.size(), 0.35);
      for (std::size_t p = 0; p < u.size(); ++p) u[p] += Vec3{mesh.points[p].z, 0, -mesh.points[p].x};
      const auto here = mesh_forces(mesh, body, u);
      ASSERT_TRUE(here) << here.error().message();
      for (std::size_t p = 0; p < u.size(); p += 2) {
        for (int c = 0; c < 3; ++c) {
          auto more = u, less = u;
          more[p][c] += step, less[p][c] -= step;
          const double slope =
              (mesh_forces(mesh, body, more)->energy_nmm - mesh_forces(mesh, body, less)->energy_nmm) /
              (2 * step);
          EXPECT_NEAR(slope, here->force_n[p][c], 1e-9) << name_of(kind) << " " << name_of(law);
        }
      }
    }
  }
}

TEST(MeshElasticity, StiffnessIsTheDerivativeOfTheForces) {
  constexpr double step = 1e-6;
  for (const ElementKind kind : kElementKinds) {
    const ElementMesh mesh = distorted(kind);
    for (const ElasticLaw law : kElasticLaws) {
      const auto model = detail::ElementModel::prepare(mesh, mixed_body(mesh, law));
      ASSERT_TRUE(model);
      const auto u = random_displacement(mesh.points.size(), 0.2);
      const auto direction = random_displacement(mesh.points.size(), 1);
      const detail::ElementState state = model->evaluate(u);
      ASSERT_TRUE(state.valid());
      std::vector<Vec3> change(u.size()), more = u, less = u;
      model->add_stiffness(u, state, false, [&](int a, int b, const Eigen::Matrix3d& block) {
        const Vec3& d = direction[at(b)];
        const Eigen::Vector3d force = block * Eigen::Vector3d(d.x, d.y, d.z);
        change[at(a)] += {force.x(), force.y(), force.z()};
      });
      for (std::size_t p = 0; p < u.size(); ++p)
        more[p] += direction[p] * step, less[p] -= direction[p] * step;
      const auto ahead = model->evaluate(more).force_n, behind = model->evaluate(less).force_n;
      for (std::size_t p = 0; p < u.size(); ++p)
        EXPECT_LT(length((ahead[p] - behind[p]) / (2 * step) - change[p]), 1e-9 * norm(change) + 1e-9)
            << name_of(kind) << " " << name_of(law);
    }
  }
}

// A turn by 90°: one face is turned, by a path on which it is squeezed to 0.7, and the body follows.
TEST(MeshElasticity, ATurnedBodyIsFreeOfStress) {
  const auto turned = [](const Vec3& p) { return Vec3{-p.x - p.y, p.x - p.y, 0}; };
  for (const ElementKind kind : kElementKinds) {
    const ElementMesh mesh = box_mesh(kind, {2, 2, 2}, {1, 1, 1});
    ElasticSupports supports;
    hold(
        supports.nodes, mesh, [](const Vec3& p) { return p.z < 1e-9; }, kAll, turned);
    for (const ElasticLaw law : kElasticLaws) {
      if (law == ElasticLaw::linear) continue;
      const ElasticBody body = body_of(material_of(law));
      MeshElasticityOptions options;
      options.newton.load_steps = 8;
      const ElasticSolution s = solved(mesh, body, supports, {}, options);
      EXPECT_LT(s.strain_energy_nmm, 1e-17) << name_of(kind) << " " << name_of(law);
      for (std::size_t p = 0; p < mesh.points.size(); ++p)
        EXPECT_LT(length(s.displacement_mm[p] - turned(mesh.points[p])), 1e-9)
            << name_of(kind) << " " << name_of(law);
      const auto stress = mesh_stress(mesh, body, s.displacement_mm);
      ASSERT_TRUE(stress);
      for (const ElementStress& e : *stress) EXPECT_LT(von_mises(e.stress_mpa), 1e-10);
    }
  }
}

TEST(MeshElasticity, SmallLoadsAreHookesForEveryLaw) {
  for (const ElementKind kind : kElementKinds) {
    const ElementMesh mesh = box_mesh(kind, {8, 2, 2}, {8, 2, 2});
    ElasticSupports supports;
    hold_base(supports.nodes, mesh, 0);
    ElasticLoad load;
    load.forces = {{static_cast<int>(mesh.points.size()) - 1, {0, 0, 1e-9}}};
    const ElasticSolution reference = solved(mesh, body_of(material_of(ElasticLaw::linear)), supports, load);
    EXPECT_EQ(reference.newton_steps, 0);
    for (const ElasticLaw law : kElasticLaws) {
      const ElasticSolution s = solved(mesh, body_of(material_of(law)), supports, load);
      EXPECT_LT(distance(s.displacement_mm, reference.displacement_mm),
                1e-5 * norm(reference.displacement_mm))
          << name_of(kind) << " " << name_of(law);
      EXPECT_LT(distance(s.reaction_n, reference.reaction_n), 1e-5 * norm(reference.reaction_n));
    }
  }
}

// A block of the unit cube pressed on a plane; contacts as stiff as the area around each node asks.
std::vector<Contact> bed(const ElementMesh& mesh, int n, double stiffness_mpa_mm, double adhesion) {
  std::vector<Contact> contacts;
  for (int p = 0; p < static_cast<int>(mesh.points.size()); ++p) {
    const Vec3& x = mesh.points[at(p)];
    if (x.z > 1e-9) continue;
    const auto side = [&](double v) { return v < 1e-9 || v > 1 - 1e-9 ? 0.5 / n : 1.0 / n; };
    const double area = side(x.x) * side(x.y);
    contacts.push_back({p, {0, 0, 1}, 0, stiffness_mpa_mm * area, adhesion * area});
  }
  return contacts;
}

TEST(MeshElasticity, ABlockPressedOnAPlaneSlidesOnIt) {
  constexpr int n = 2;
  constexpr double pressure = 0.001, bedding = 0.05, adhesion = 0.02;
  const ElasticMaterial material = material_of(ElasticLaw::linear);
  ElementMesh mesh = box_mesh(ElementKind::hexahedra, {n, n, n}, {1, 1, 1});
  std::vector<NodeSupport> sides = symmetry_planes(mesh);
  for (NodeSupport& s : sides) s.held[2] = false;
  ElasticLoad load;
  const auto top = [&](double traction) {
    load.surfaces.clear();
    for (const auto& e : mesh.hexahedra)
      if (mesh.points[at(e[4])].z > 1 - 1e-9)
        load.surfaces.push_back({{e[4], e[5], e[6], e[7]}, {0, 0, traction}, 0});
  };
  const auto expect = [&](double traction, double stiffness) {
    top(traction);
    const ElasticSolution s = solved(mesh, body_of(material), {sides, bed(mesh, n, bedding, adhesion)}, load);
    EXPECT_GT(s.newton_steps, 0);
    double carried = 0;
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
      const Vec3 x = mesh.points[p];
      const double strain = traction / material.youngs_modulus_mpa;
      const Vec3 exact{-material.poissons_ratio * strain * x.x, -material.poissons_ratio * strain * x.y,
                       traction / stiffness + strain * x.z};
      EXPECT_LT(length(s.displacement_mm[p] - exact), 1e-12);
      carried += s.reaction_n[p].z;
    }
    EXPECT_NEAR(carried, -traction, 1e-15);
  };
  expect(-pressure, bedding);
  expect(pressure, adhesion);
}

// A plank on a bed without adhesion, its end lifted: it leaves the bed there and stays on it elsewhere.
TEST(MeshElasticity, ContactsOpenWhereTheBodyIsLifted) {
  const ElementMesh mesh = box_mesh(ElementKind::hexahedra, {20, 1, 2}, {20, 1, 1});
  ElasticSupports supports;
  hold_base(supports.nodes, mesh, 0);
  for (int p = 0; p < static_cast<int>(mesh.points.size()); ++p)
    if (mesh.points[at(p)].z < 1e-9 && mesh.points[at(p)].x > 0.5)
      supports.contacts.push_back({p, {0, 0, 1}, 0, 0.01, 0});
  ElasticLoad load;
  load.gravity_mm_ms2 = {0, 0, -0.00981};
  for (int p = 0; p < static_cast<int>(mesh.points.size()); ++p)
    if (mesh.points[at(p)].x > 20 - 1e-9) load.forces.push_back({p, {0, 0, 8e-6}});
  for (const ElasticLaw law : {ElasticLaw::linear, ElasticLaw::neo_hookean}) {
    const ElasticSolution s = solved(mesh, body_of(material_of(law)), supports, load);
    int open = 0, closed = 0;
    Vec3 total;
    for (const Contact& c : supports.contacts) {
      const double distance = s.displacement_mm[at(c.point)].z;
      (distance > 0 ? open : closed)++;
      EXPECT_NEAR(s.reaction_n[at(c.point)].z, distance > 0 ? 0 : -0.01 * distance, 1e-15);
    }
    for (const Vec3& r : s.reaction_n) total += r;
    EXPECT_GT(open, 4);
    EXPECT_GT(closed, 4);
    EXPECT_NEAR(total.z, 20 * 1.04e-3 * 0.00981 - 6 * 8e-6, 1e-10);
  }
}

TEST(MeshElasticity, WhatCannotComeToRestIsSaid) {
  const ElementMesh mesh = box_mesh(ElementKind::hexahedra, {2, 2, 2}, {1, 1, 1});
  ElasticSupports supports;
  hold_ends(supports.nodes, mesh, 2, {0, 0, -1.5});  // through itself
  for (const ElasticLaw law : {ElasticLaw::neo_hookean, ElasticLaw::mooney_rivlin}) {
    Context context;
    const auto s = solve_mesh(mesh, body_of(material_of(law)), supports, {}, {}, context);
    ASSERT_TRUE(s) << s.error().message();
    EXPECT_FALSE(s->converged);
    ASSERT_EQ(context.notices().size(), 1U);
    EXPECT_NE(context.notices()[0].text.find("turn over"), std::string::npos) << context.notices()[0].text;
    for (const Vec3& u : s->displacement_mm) EXPECT_TRUE(is_finite(u));
    EXPECT_TRUE(std::isfinite(s->relative_residual));
  }
  // Pulled off a plane that does not draw.
  ElasticSupports loose{symmetry_planes(mesh), bed(mesh, 2, 0.05, 0)};
  for (NodeSupport& s : loose.nodes) s.held[2] = false;
  Context context;
  ElasticLoad load;
  load.gravity_mm_ms2 = {0, 0, 0.00981};
  const auto s = solve_mesh(mesh, body_of(material_of(ElasticLaw::neo_hookean)), loose, load, {}, context);
  ASSERT_TRUE(s) << s.error().message();
  EXPECT_FALSE(s->converged);
  ASSERT_EQ(context.notices().size(), 1U);
  EXPECT_NE(context.notices()[0].text.find("nothing holds it"), std::string::npos)
      << context.notices()[0].text;
}

TEST(MeshElasticity, GoesOnFromAnEarlierSolution) {
  const ElementMesh mesh = box_mesh(ElementKind::tetrahedra, {3, 2, 2}, {3, 2, 2});
  ElasticSupports supports;
  hold_ends(supports.nodes, mesh, 0, {1.5, 0, 0.5});
  const ElasticBody body = body_of(material_of(ElasticLaw::mooney_rivlin));
  const ElasticSolution first = solved(mesh, body, supports, {});
  EXPECT_GT(first.newton_steps, 2);
  Context context;
  const auto again = solve_mesh(mesh, body, supports, {}, {}, context, first.displacement_mm);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->newton_steps, 0);
  EXPECT_LT(distance(again->displacement_mm, first.displacement_mm), 1e-12);
}

TEST(MeshElasticity, SameBitsOnAnyNumberOfThreads) {
  const ElementMesh mesh = box_mesh(ElementKind::prisms, {5, 5, 4}, {5, 5, 4});
  ElasticSupports supports;
  hold_base(supports.nodes, mesh, 2);
  ElasticLoad load;
  load.gravity_mm_ms2 = {0.1, 0, -0.2};
  std::vector<ElasticSolution> all;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    all.push_back(solved(mesh, body_of(material_of(ElasticLaw::neo_hookean)), supports, load));
  }
  set_thread_count(0);
  for (const ElasticSolution& s : all) {
    EXPECT_EQ(s.displacement_mm, all[0].displacement_mm);
    EXPECT_EQ(s.relative_residual, all[0].relative_residual);
  }
}

TEST(MeshElasticity, ATriangleIsAFaceThatNamesItsLastCornerTwice) {
  const ElementMesh mesh = box_mesh(ElementKind::tetrahedra, {1, 1, 1}, {1, 1, 1});
  const auto force = mesh_load(mesh, {}, {{}, {{{0, 1, 2, 2}, {0, 0, 6}, 0}}, {}});
  ASSERT_TRUE(force);
  for (const std::size_t p : {0U, 1U, 2U}) EXPECT_NEAR((*force)[p].z, 1, 1e-14);
}

class BadMeshInput : public testing::Test {
 protected:
  BadMeshInput() { hold_base(supports_.nodes, mesh_, 2); }
  void expect_error(const char* what) {
    Context context;
    const auto s = solve_mesh(mesh_, body_, supports_, load_, options_, context, start_);
    ASSERT_FALSE(s) << what;
    EXPECT_FALSE(s.error().what.empty());
    EXPECT_FALSE(s.error().remedy.empty()) << s.error().message();
  }
  ElementMesh mesh_ = box_mesh(ElementKind::prisms, {1, 1, 1}, {1, 1, 1});
  ElasticBody body_ = body_of(material_of(ElasticLaw::neo_hookean));
  ElasticSupports supports_;
  ElasticLoad load_;
  MeshElasticityOptions options_;
  std::vector<Vec3> start_;
};

TEST_F(BadMeshInput, Mesh) {
  const ElementMesh good = mesh_;
  mesh_.prisms[1][2] = 99;
  expect_error("no such point");
  mesh_ = good;
  std::swap(mesh_.prisms[0][0], mesh_.prisms[0][1]);
  expect_error("turned over");
  mesh_ = good;
  mesh_.points[7].x = std::nan("");
  expect_error("not a number");
  mesh_.points[7].x = 1e308;
  expect_error("beyond numbers");
  mesh_ = {};
  expect_error("empty");
}

TEST_F(BadMeshInput, Contacts) {
  const double nan = std::nan("");
  for (const Contact& bad :
       {Contact{99, {0, 0, 1}, 0, 1, 0}, Contact{-1, {0, 0, 1}, 0, 1, 0}, Contact{4, {0, 0, 2}, 0, 1, 0},
        Contact{4, {0, 0, nan}, 0, 1, 0}, Contact{4, {0, 0, 1}, nan, 1, 0}, Contact{4, {0, 0, 1}, 0, -1, 0},
        Contact{4, {0, 0, 1}, 0, 1, nan}, Contact{4, {0, 0, 1}, 1e308, 1, 0}}) {
    supports_.contacts = {bad};
    expect_error("contact");
  }
  supports_.contacts = {{4, {0, 0, 1}, 0, 1, 0}, {4, {0, 1, 0}, 0, 1, 0}};
  expect_error("two contacts of a node");
  // Pressed on a plane alone it may still slide.
  supports_.nodes.clear();
  supports_.contacts.clear();
  for (int p = 0; p < 4; ++p) supports_.contacts.push_back({p, {0, 0, 1}, 0, 1, 1});
  expect_error("free to slide");
}

TEST_F(BadMeshInput, OptionsLoadsAndStarts) {
  const double nan = std::nan("");
  const auto with = [&](const MeshElasticityOptions& options) {
    options_ = options;
    expect_error("options");
  };
  with({0, {}});
  with({nan, {}});
  with({1e-9, {0, 100}});
  with({1e-9, {1, 0}});
  options_ = {};
  load_.forces = {{0, {nan, 0, 0}}};
  expect_error("load");
  load_ = {};
  start_.resize(3);
  expect_error("start");
  start_.assign(8, Vec3{});
  start_[7].z = -5;
  expect_error("start that turns elements over");
  start_.clear();
  body_.materials[0].c20_mpa = -1;
  expect_error("material");
}

TEST_F(BadMeshInput, WildNumbersEndInAnErrorOrInNumbers) {
  mesh_.points.push_back({5, 5, 5});  // of no element
  const ElasticSupports held = supports_;
  for (const ElasticLaw law : kElasticLaws) {
    body_.materials[0].law = law;
    for (const double wild : {1e-300, 1e10, 1e29, -1e29, 1e154, 1e308}) {
      for (int where = 0; where < 4; ++where) {
        supports_ = held, load_ = {};
        body_.materials[0].youngs_modulus_mpa = where == 3 ? std::abs(wild) : 0.015;
        if (where == 0) supports_.nodes.push_back({7, {true, false, true}, {wild, 0, wild}});
        if (where == 1) load_.forces = {{6, {wild, 0, -wild}}, {8, {1, 1, 1}}};
        if (where == 2) supports_.contacts = {{7, {0, 0, 1}, wild, 1e3, 1}, {8, {0, 0, 1}, 0, 1, 1}};
        if (where == 3) load_.gravity_mm_ms2 = {1, 0, -1};
        Context context;
        options_.newton.max_newton_steps = 30;
        const auto s = solve_mesh(mesh_, body_, supports_, load_, options_, context);
        if (!s) continue;
        EXPECT_TRUE(std::isfinite(s->relative_residual) && std::isfinite(s->strain_energy_nmm))
            << name_of(law) << " " << wild << " " << where;
        for (const Vec3& u : s->displacement_mm)
          EXPECT_TRUE(is_finite(u)) << name_of(law) << " " << wild << " " << where;
        for (const Vec3& r : s->reaction_n)
          EXPECT_TRUE(is_finite(r)) << name_of(law) << " " << wild << " " << where;
        EXPECT_EQ(s->displacement_mm[8], Vec3{});
      }
    }
  }
}

TEST_F(BadMeshInput, ForcesAndStressOfWhatIsTurnedOver) {
  std::vector<Vec3> u(8);
  u[7].z = -5;
  EXPECT_FALSE(mesh_forces(mesh_, body_, u));
  EXPECT_FALSE(mesh_stress(mesh_, body_, u));
  body_.materials[0].law = ElasticLaw::st_venant_kirchhoff;  // has energy there, but no Cauchy stress
  EXPECT_TRUE(mesh_forces(mesh_, body_, u));
  EXPECT_FALSE(mesh_stress(mesh_, body_, u));
  for (const ElasticLaw law : kElasticLaws) {
    body_.materials[0].law = law;
    for (const double wild : {1e29, -1e29, 1e308, std::nan("")}) {
      std::fill(u.begin(), u.end(), Vec3{});
      u[5].x = wild;
      const auto forces = mesh_forces(mesh_, body_, u);
      if (forces) EXPECT_TRUE(std::isfinite(forces->energy_nmm) && is_finite(forces->force_n[5]));
      const auto stress = mesh_stress(mesh_, body_, u);
      if (stress) EXPECT_TRUE(std::isfinite(von_mises(stress->front().stress_mpa)));
    }
  }
}

}  // namespace
}  // namespace turgor
