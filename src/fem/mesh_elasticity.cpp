#include "turgor/fem/mesh_elasticity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/elastic_problem.hpp"
#include "fem/element_model.hpp"
#include "fem/mesh_equilibrium.hpp"
#include "fem/mesh_newton.hpp"
#include "fem/rigid_pieces.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

using detail::ElementModel;
using detail::MeshEquilibrium;
using detail::MeshState;

using Face = std::array<int, 4>;  // corners of an element; −1: of a triangle

std::span<const Face> faces_of(std::size_t corners) {
  static constexpr Face hexahedron[] = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                        {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  static constexpr Face prism[] = {{0, 1, 2, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  static constexpr Face tetrahedron[] = {{0, 1, 2, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}};
  if (corners == 8) return hexahedron;
  if (corners == 6) return prism;
  return tetrahedron;
}

void face_pairs(const ElementMesh& mesh, const std::function<void(int, int)>& pair) {
  std::vector<std::pair<Face, int>> all;  // as sorted points, with the element behind
  for (std::size_t e = 0; e < mesh.size(); ++e) {
    const std::span<const int> corners = detail::corners_of(mesh, e);
    for (const Face& face : faces_of(corners.size())) {
      Face key{};
      for (std::size_t n = 0; n < 4; ++n) key[n] = face[n] < 0 ? -1 : corners[at(face[n])];
      std::sort(key.begin(), key.end());
      all.emplace_back(key, static_cast<int>(e));
    }
  }
  std::sort(all.begin(), all.end());
  for (std::size_t f = 1; f < all.size(); ++f)
    if (all[f].first == all[f - 1].first) pair(all[f - 1].second, all[f].second);
}

Result<void> check(const MeshElasticityOptions& options) {
  if (options.relative_residual > 0 && options.relative_residual < 1 && options.newton.load_steps >= 1 &&
      options.newton.load_steps <= 1'000'000 && options.newton.max_newton_steps >= 1)
    return {};
  return detail::bad_elasticity("the options of Newton's method are out of range", "elasticity of a mesh",
                                "Give a residual above 0 and below 1, and one step or more");
}

Result<void> check(const ElementMesh& mesh, const ElasticSupports& supports) {
  TURGOR_CHECK(detail::check(supports.nodes, mesh.points.size()));
  TURGOR_CHECK(detail::check(supports.contacts, mesh.points.size()));
  return detail::check_held(
      mesh.points, mesh.size(), [&](std::size_t e) { return detail::corners_of(mesh, e); },
      [&](const auto& pair) { face_pairs(mesh, pair); }, supports.nodes, supports.contacts);
}

Result<std::vector<Vec3>> load_of(const ElementMesh& mesh, const ElementModel& model,
                                  const ElasticLoad& load) {
  std::vector<Vec3> force(mesh.points.size());
  TURGOR_CHECK(detail::add_point_and_surface_loads(mesh.points, load, force));
  model.add_gravity(load.gravity_mm_ms2, force);
  for (std::size_t p = 0; p < force.size(); ++p)
    if (!is_finite(force[p]))
      return detail::bad_elasticity("the load is beyond all numbers", fmt::format("point {}", p),
                                    "Give smaller forces");
  return force;
}

// One system: all laws linear, no contacts.
Result<ElasticSolution> solve_linear(MeshEquilibrium& equilibrium, std::size_t points) {
  const MeshState rest = equilibrium.evaluate(std::vector<Vec3>(points), 1);
  std::vector<Vec3> moves = equilibrium.with_prescribed(rest.displacement_mm, 1);
  const auto step = equilibrium.newton_step(rest, moves, MeshEquilibrium::Tangent::exact);
  if (!step || !step->stable)
    return Error{ErrorKind::internal, "the stiffness cannot be factored", "elasticity of a mesh", ""};
  const MeshState state = equilibrium.evaluate(equilibrium.moved(std::move(moves), step->step, 1), 1);
  ElasticSolution out;
  if (step->right.norm() > 0) out.relative_residual = state.unbalanced.norm() / step->right.norm();
  out.displacement_mm = state.displacement_mm;
  out.reaction_n = equilibrium.reactions(state, 1);
  out.strain_energy_nmm = state.elements.energy_nmm;
  return out;
}

Result<ElasticSolution> solve_by_newton(MeshEquilibrium& equilibrium, std::vector<Vec3> start, bool at_once,
                                        const MeshElasticityOptions& options, Context& context) {
  detail::MeshNewton newton(equilibrium, options, context);
  TURGOR_TRY(auto outcome, newton.run(std::move(start), at_once));
  const MeshState state = equilibrium.evaluate(std::move(outcome.displacement_mm), 1);
  ElasticSolution out;
  out.newton_steps = outcome.steps;
  out.converged = outcome.obstacle.empty();
  const double left = state.unbalanced.norm();
  if (left > 0) out.relative_residual = left / std::max(state.carried_n, left * 1e-300);
  out.displacement_mm = state.displacement_mm;
  out.reaction_n = equilibrium.reactions(state, 1);
  out.strain_energy_nmm = state.elements.energy_nmm;
  if (!out.converged)
    context.warning(fmt::format(
        "The elastic mesh has not come to rest: after {} Newton steps and at {:.3g} of the load {}; the "
        "residual is {:.2g} of the forces",
        out.newton_steps, outcome.part, outcome.obstacle, out.relative_residual));
  return out;
}

}  // namespace

Result<ElasticSolution> solve_mesh(const ElementMesh& mesh, const ElasticBody& body,
                                   const ElasticSupports& supports, const ElasticLoad& load,
                                   const MeshElasticityOptions& options, Context& context,
                                   std::span<const Vec3> start) {
  const Stage stage(context, "elasticity of a mesh");
  TURGOR_CHECK(check(options));
  TURGOR_TRY(const ElementModel model, ElementModel::prepare(mesh, body));
  TURGOR_CHECK(check(mesh, supports));
  TURGOR_TRY(const std::vector<Vec3> load_n, load_of(mesh, model, load));
  if (!start.empty()) TURGOR_CHECK(detail::check_displacement(start, mesh.points.size()));
  TURGOR_CHECK(context.check());
  MeshEquilibrium equilibrium(mesh, model, supports, load_n);
  if (model.linear() && supports.contacts.empty()) return solve_linear(equilibrium, mesh.points.size());
  std::vector<Vec3> from(start.begin(), start.end());
  from.resize(mesh.points.size());
  return solve_by_newton(equilibrium, std::move(from), !start.empty(), options, context);
}

Result<std::vector<ElementStress>> mesh_stress(const ElementMesh& mesh, const ElasticBody& body,
                                               std::span<const Vec3> displacement_mm) {
  TURGOR_TRY(const ElementModel model, ElementModel::prepare(mesh, body));
  TURGOR_CHECK(detail::check_displacement(displacement_mm, mesh.points.size()));
  const detail::ElementState state = model.evaluate(displacement_mm);
  if (!state.valid()) return detail::turned_over(state.first_turned_over);
  return model.stress(displacement_mm, state);
}

Result<ElasticForces> mesh_forces(const ElementMesh& mesh, const ElasticBody& body,
                                  std::span<const Vec3> displacement_mm) {
  TURGOR_TRY(const ElementModel model, ElementModel::prepare(mesh, body));
  TURGOR_CHECK(detail::check_displacement(displacement_mm, mesh.points.size()));
  detail::ElementState state = model.evaluate(displacement_mm);
  if (!state.valid()) return detail::turned_over(state.first_turned_over);
  return ElasticForces{state.energy_nmm, std::move(state.force_n)};
}

Result<std::vector<Vec3>> mesh_load(const ElementMesh& mesh, const ElasticBody& body,
                                    const ElasticLoad& load) {
  TURGOR_TRY(const ElementModel model, ElementModel::prepare(mesh, body));
  return load_of(mesh, model, load);
}

}  // namespace turgor
