#include "turgor/fem/voxel_elasticity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/elastic_problem.hpp"
#include "fem/element_model.hpp"
#include "fem/element_shapes.hpp"
#include "fem/law_stress.hpp"
#include "fem/rigid_pieces.hpp"
#include "fem/voxel_solver.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/fem/mesh_elasticity.hpp"

namespace turgor {

using detail::VoxelNumbering;
using detail::VoxelOperator;

namespace {

Result<void> check(const VoxelElasticityOptions& o) {
  if (!(o.relative_residual > 0) || !std::isfinite(o.relative_residual))
    return detail::bad_elasticity(fmt::format("the relative residual asked for is {}", o.relative_residual),
                                  "elasticity", "It must lie above 0");
  if (o.newton.load_steps < 1 || o.newton.load_steps > 10000 || o.newton.max_newton_steps < 1)
    return detail::bad_elasticity("the load or Newton steps asked for make no sense", "elasticity",
                                  "Allow at least 1 Newton step and 1 to 10000 load steps");
  if (o.max_iterations < 1 || o.smoothing_steps < 0 || o.smoothing_steps > 20)
    return detail::bad_elasticity("the iterations or smoothing steps asked for make no sense", "elasticity",
                                  "Allow at least 1 iteration and 0 to 20 smoothing steps");
  return {};
}

}  // namespace

struct VoxelElasticity::Parts : detail::VoxelProblem {
  using VoxelProblem::VoxelProblem;
};

VoxelElasticity::VoxelElasticity(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
VoxelElasticity::VoxelElasticity(VoxelElasticity&&) noexcept = default;
VoxelElasticity& VoxelElasticity::operator=(VoxelElasticity&&) noexcept = default;
VoxelElasticity::~VoxelElasticity() = default;

Result<VoxelElasticity> VoxelElasticity::prepare(const SolidMesh& solid, ElasticBody body,
                                                 const ElasticSupports& supports,
                                                 const VoxelElasticityOptions& options, Context& context) {
  const Stage stage(context, "elasticity: set-up");
  TURGOR_CHECK(check(options));
  TURGOR_TRY(VoxelNumbering numbering, VoxelNumbering::of(solid));
  TURGOR_CHECK(detail::check(body, numbering.cubes.size()));
  TURGOR_CHECK(detail::check(supports.nodes, solid.points.size()));
  TURGOR_CHECK(detail::check(supports.contacts, solid.points.size()));
  auto parts = std::make_unique<Parts>(std::move(numbering), std::move(body), options);
  const VoxelNumbering& n = parts->numbering;
  parts->points.assign(solid.points.begin(), solid.points.end());
  TURGOR_CHECK(detail::check_held(
      parts->points, n.cubes, [&](const auto& pair) { n.face_pairs(pair); }, supports.nodes,
      supports.contacts));
  TURGOR_CHECK(context.check());
  parts->spacing = solid.spacing;
  parts->supports = supports;
  parts->set_moduli();
  parts->set_held();
  parts->set_prescribed();
  parts->set_contacts();
  parts->stiffness = std::make_unique<VoxelOperator<double>>(n.rows, detail::cube_stiffness(solid.spacing),
                                                             parts->shear, parts->bulk, nullptr);
  const auto& materials = parts->body.materials;
  if (std::any_of(materials.begin(), materials.end(),
                  [](const ElasticMaterial& m) { return m.law != ElasticLaw::linear; })) {
    parts->laws = std::make_unique<detail::VoxelLaws>(n, parts->body, solid.spacing);
    parts->set_cubes_of();
  }
  TURGOR_CHECK(parts->set_cycle(context));
  return VoxelElasticity(std::move(parts));
}

Result<void> VoxelElasticity::set_displacements(std::span<const Vec3> displacement_mm) {
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts_->supports.nodes.size()));
  for (std::size_t s = 0; s < displacement_mm.size(); ++s)
    parts_->supports.nodes[s].displacement_mm = displacement_mm[s];
  parts_->set_prescribed();
  return {};
}

Result<void> VoxelElasticity::set_contacts(std::span<const Contact> contacts) {
  Parts& parts = *parts_;
  if (contacts.size() != parts.supports.contacts.size())
    return detail::bad_elasticity(
        fmt::format("{} contacts are given for {}", contacts.size(), parts.supports.contacts.size()),
        "contacts", "Give one for each");
  TURGOR_CHECK(detail::check(contacts, parts.points.size()));
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts[c].point != parts.supports.contacts[c].point)
      return detail::bad_elasticity("the node of a contact has changed", fmt::format("contact {}", c),
                                    "Give the nodes that were given first, in their order");
  }
  parts.supports.contacts.assign(contacts.begin(), contacts.end());
  parts.set_contacts();
  return {};
}

Result<ElasticSolution> VoxelElasticity::solve(const ElasticLoad& load, Context& context,
                                               std::span<const Vec3> start) const {
  const Stage stage(context, "elasticity");
  const Parts& parts = *parts_;
  TURGOR_TRY(std::vector<double> force, parts.forces_of(load));
  if (!start.empty()) TURGOR_CHECK(detail::check_displacement(start, parts.points.size()));
  std::vector<double> from(start.empty() ? 0 : parts.numbering.rows.values(), 0);
  if (!start.empty()) parts.numbering.scatter(start, from);
  return detail::VoxelSolver(parts, std::move(force), context).solve(from);
}

namespace {

// Of one cube; false where it is turned over.
bool law_stress(const std::vector<detail::GaussPoint>& points, const std::array<Vec3, 8>& moved,
                const ElasticMaterial& material, ElementStress& out) {
  std::array<detail::Tensor<double>, 8> h{};
  std::array<detail::LawResponse, 8> response;
  double theta = 0;
  for (std::size_t g = 0; g < 8; ++g) {
    for (std::size_t n = 0; n < 8; ++n)
      for (int i = 0; i < 9; ++i) h[g].m[i] += moved[n][i / 3] * points[g].gradient[n][i % 3];
    response[g] = detail::law_response(material, h[g]);
    if (!response[g].valid) return false;
    theta += response[g].theta / 8;
  }
  detail::StressMean mean(material, material.bulk_modulus() * theta);
  for (std::size_t g = 0; g < 8; ++g)
    if (!mean.add(h[g], response[g], 1.0 / 8)) return false;
  out = mean.stress();
  return true;
}

}  // namespace

Result<std::vector<ElementStress>> VoxelElasticity::stress(std::span<const Vec3> displacement_mm) const {
  const Parts& parts = *parts_;
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts.points.size()));
  const auto& cubes = parts.numbering.cubes;
  std::array<Vec3, 8> corner;
  for (std::size_t n = 0; n < 8; ++n)
    for (int a = 0; a < 3; ++a) corner[n][a] = ((detail::kCornerBits[n] >> a) & 1) * parts.spacing;
  std::vector<detail::GaussPoint> points;
  detail::add_gauss_points(corner, points);
  std::vector<ElementStress> out(cubes.size());
  const std::size_t bad = parallel_reduce<std::size_t>(
      cubes.size(), 256, cubes.size(),
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
          std::array<Vec3, 8> moved;
          for (std::size_t n = 0; n < 8; ++n) moved[n] = displacement_mm[at(cubes[e][n])];
          if (!law_stress(points, moved, parts.body.of(e), out[e])) return e;
        }
        return cubes.size();
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (bad < cubes.size()) return detail::turned_over(bad);
  return out;
}

Result<std::vector<Vec3>> VoxelElasticity::internal_forces(std::span<const Vec3> displacement_mm) const {
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts_->points.size()));
  const std::size_t n = parts_->numbering.rows.values();
  std::vector<double> u(n, 0), image(n);
  parts_->numbering.scatter(displacement_mm, u);
  if (parts_->laws == nullptr) {
    parts_->stiffness->apply(u.data(), image.data(), [](std::size_t, std::size_t, std::size_t) {});
  } else if (const auto energy = parts_->laws->forces(u.data(), image.data()); energy.inverted > 0) {
    return detail::bad_elasticity(fmt::format("{} cubes are turned over", energy.inverted), "displacements",
                                  "Give displacements that leave every cube a volume");
  }
  return parts_->numbering.gather(image);
}

}  // namespace turgor
