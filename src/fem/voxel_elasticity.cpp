#include "turgor/fem/voxel_elasticity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/elastic_problem.hpp"
#include "fem/rigid_pieces.hpp"
#include "fem/voxel_multigrid.hpp"
#include "fem/voxel_numbering.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {

using detail::CubeStiffness;
using detail::VoxelLevel;
using detail::VoxelMultigrid;
using detail::VoxelNumbering;
using detail::VoxelOperator;

namespace {

// Restarts from the true residual, where rounding has made that of the iteration too small.
constexpr int kMostRestarts = 5;

Result<void> check(const VoxelElasticityOptions& o) {
  if (!(o.relative_residual > 0) || !std::isfinite(o.relative_residual))
    return detail::bad_elasticity(fmt::format("the relative residual asked for is {}", o.relative_residual),
                                  "elasticity", "It must lie above 0");
  if (o.max_iterations < 1 || o.smoothing_steps < 0 || o.smoothing_steps > 20)
    return detail::bad_elasticity("the iterations or smoothing steps asked for make no sense", "elasticity",
                                  "Allow at least 1 iteration and 0 to 20 smoothing steps");
  return {};
}

// Near incompressibility the smoother has to do more, as coarse lattices are too stiff.
int smoothing_steps_for(const ElasticBody& body) {
  double largest = 0;
  for (const ElasticMaterial& m : body.materials) largest = std::max(largest, m.poissons_ratio);
  return largest <= 0.4 ? 4 : largest <= 0.46 ? 5 : largest < 0.48 ? 6 : 8;
}

}  // namespace

struct VoxelElasticity::Parts {
  Parts(VoxelNumbering n, ElasticBody b, const VoxelElasticityOptions& o)
      : numbering(std::move(n)), body(std::move(b)), options(o) {}

  VoxelNumbering numbering;
  ElasticBody body;
  VoxelElasticityOptions options;
  double spacing = 1;
  std::vector<Vec3> points;
  std::vector<NodeSupport> supports;
  std::vector<double> shear, bulk;  // of each cell, MPa
  std::vector<std::uint8_t> held;   // of each value; also what belongs to no node
  std::vector<double> prescribed;   // of each value, 0 where it is not held
  std::unique_ptr<VoxelOperator<double>> stiffness;
  std::unique_ptr<VoxelMultigrid> multigrid;

  void set_moduli();
  void set_held();
  void set_prescribed();
  [[nodiscard]] std::unique_ptr<VoxelLevel> finest_level() const;
  [[nodiscard]] Result<std::vector<double>> forces_of(const ElasticLoad& load) const;
  template <class Loop>
  void for_planes(Loop&& loop) const;
  template <class Term>
  [[nodiscard]] double sum(Term&& term) const;
  void multiply(const std::vector<double>& in, std::vector<double>& out) const;
  double residual_of(const std::vector<double>& force, const std::vector<double>& u,
                     std::vector<double>& image, std::vector<double>& r) const;
  [[nodiscard]] double rounding_of(const std::vector<double>& u) const;
  struct Progress;
  Result<void> iterate(Progress& progress, double target, Context& context) const;
};

void VoxelElasticity::Parts::set_moduli() {
  shear.assign(numbering.rows.cell_count, 0);
  bulk.assign(numbering.rows.cell_count, 0);
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
    const ElasticMaterial m = body.of(c);
    shear[numbering.cell(c)] = m.shear_modulus();
    bulk[numbering.cell(c)] = m.bulk_modulus();
  }
}

void VoxelElasticity::Parts::set_held() {
  held.assign(numbering.rows.values(), 1);
  for (const detail::NodePlace& p : numbering.nodes)
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c) held[p.component(c)] = 0;
  for (const NodeSupport& s : supports) {
    const detail::NodePlace& p = numbering.nodes[at(s.node)];
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c)
      if (s.held[c]) held[p.component(c)] = 1;
  }
}

void VoxelElasticity::Parts::set_prescribed() {
  prescribed.assign(numbering.rows.values(), 0);
  for (const NodeSupport& s : supports) {
    const detail::NodePlace& p = numbering.nodes[at(s.node)];
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c)
      if (s.held[c]) prescribed[p.component(c)] = s.displacement_mm[static_cast<int>(c)];
  }
}

// In single precision, moduli relative to the largest.
std::unique_ptr<VoxelLevel> VoxelElasticity::Parts::finest_level() const {
  auto level = std::make_unique<VoxelLevel>();
  level->rows = numbering.rows;
  level->spans = numbering.spans;
  level->stiffness = detail::cube_stiffness(1);
  const double largest = std::max(*std::max_element(shear.begin(), shear.end()), 1e-300);
  const auto relative = [&](double m) { return static_cast<float>(m / largest); };
  level->shear.resize(shear.size());
  level->bulk.resize(bulk.size());
  std::transform(shear.begin(), shear.end(), level->shear.begin(), relative);
  std::transform(bulk.begin(), bulk.end(), level->bulk.begin(), relative);
  level->held_cell.assign(numbering.rows.cell_count, 0);
  std::vector<std::uint8_t> node_held(numbering.nodes.size(), 0);
  for (const NodeSupport& s : supports)
    if (s.held[0] || s.held[1] || s.held[2]) node_held[at(s.node)] = 1;
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
    for (const int node : numbering.cubes[c])
      if (node_held[at(node)] != 0) level->held_cell[numbering.cell(c)] = 1;
  }
  level->finish(held);
  return level;
}

Result<std::vector<double>> VoxelElasticity::Parts::forces_of(const ElasticLoad& load) const {
  std::vector<Vec3> force(points.size());
  TURGOR_CHECK(detail::add_point_and_surface_loads(points, load, force));
  if (load.gravity_mm_ms2 != Vec3{}) {
    const double eighth = spacing * spacing * spacing / 8;
    for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
      const Vec3 weight = load.gravity_mm_ms2 * (eighth * body.of(c).density_g_mm3);
      for (const int node : numbering.cubes[c]) force[at(node)] += weight;
    }
  }
  std::vector<double> values(numbering.rows.values(), 0);
  numbering.scatter(force, values);
  return values;
}

// Ranges of values that do not depend on the number of threads.
template <class Loop>
void VoxelElasticity::Parts::for_planes(Loop&& loop) const {
  const auto& planes = numbering.rows.planes;
  parallel_for(planes.size() - 1, static_cast<std::size_t>(numbering.rows.slab),
               [&](std::size_t begin, std::size_t end) { loop(planes[begin], planes[end]); });
}

template <class Term>
double VoxelElasticity::Parts::sum(Term&& term) const {
  const auto& planes = numbering.rows.planes;
  return parallel_reduce<double>(
      planes.size() - 1, static_cast<std::size_t>(numbering.rows.slab), 0.0,
      [&](std::size_t begin, std::size_t end) { return term(planes[begin], planes[end]); }, std::plus<>());
}

void VoxelElasticity::Parts::multiply(const std::vector<double>& in, std::vector<double>& out) const {
  stiffness->apply(in.data(), out.data(), [](std::size_t, std::size_t, std::size_t) {});
}

namespace {

// Four sums side by side, so that additions do not wait for one another.
double inner(const double* a, const double* b, std::size_t begin, std::size_t end) {
  double s[4] = {};
  std::size_t i = begin;
  for (; i + 4 <= end; i += 4)
    for (std::size_t l = 0; l < 4; ++l) s[l] += a[i + l] * b[i + l];
  for (; i < end; ++i) s[0] += a[i] * b[i];
  return (s[0] + s[1]) + (s[2] + s[3]);
}

}  // namespace

// r = f − K u over what is not held; returns its length.
double VoxelElasticity::Parts::residual_of(const std::vector<double>& force, const std::vector<double>& u,
                                           std::vector<double>& image, std::vector<double>& r) const {
  multiply(u, image);
  return std::sqrt(sum([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) r[i] = held[i] != 0 ? 0 : force[i] - image[i];
    return inner(r.data(), r.data(), begin, end);
  }));
}

// What rounding of the displacements alone leaves of a residual.
double VoxelElasticity::Parts::rounding_of(const std::vector<double>& u) const {
  const std::vector<float>& scaling = multigrid->level(0).scaling;
  const double unit = spacing * *std::max_element(shear.begin(), shear.end());
  return 2 * std::numeric_limits<double>::epsilon() * unit *
         std::sqrt(sum([&](std::size_t begin, std::size_t end) {
           double square = 0;
           for (std::size_t i = begin; i < end; ++i) {
             const double force = scaling[i] != 0 ? u[i] / static_cast<double>(scaling[i]) : 0;
             square += force * force;
           }
           return square;
         }));
}

struct VoxelElasticity::Parts::Progress {
  std::vector<double> u, r, p, image;
  VoxelMultigrid::Work work;
  double residual = 0;  // ‖r‖
  int iterations = 0;
};

// Conjugate gradients from u with the residual r, until it is `target` long.
Result<void> VoxelElasticity::Parts::iterate(Progress& g, double target, Context& context) const {
  double rho_before = 1;
  std::vector<double> parts(numbering.rows.planes.size() - 1);
  for (bool first = true; g.residual > target && g.iterations < options.max_iterations; first = false) {
    TURGOR_CHECK(context.check());
    // The cycle is linear; it is given vectors of length 1 so that single precision holds any forces.
    const double scale = 1 / g.residual;
    std::vector<float>& right = g.work.residual();
    for_planes([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) right[i] = static_cast<float>(scale * g.r[i]);
    });
    multigrid->cycle(g.work);
    const std::vector<float>& z = g.work.result();
    const double rho = g.residual * sum([&](std::size_t begin, std::size_t end) {
                         double s = 0;
                         for (std::size_t i = begin; i < end; ++i) s += g.r[i] * static_cast<double>(z[i]);
                         return s;
                       });
    if (!(rho > 0)) break;
    const double beta = first ? 0 : rho / rho_before;
    rho_before = rho;
    for_planes([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        g.p[i] = g.residual * static_cast<double>(z[i]) + beta * g.p[i];
    });
    stiffness->apply(g.p.data(), g.image.data(), [&](std::size_t plane, std::size_t begin, std::size_t end) {
      parts[plane] = inner(g.p.data(), g.image.data(), begin, end);
    });
    double curvature = 0;
    for (const double part : parts) curvature += part;
    if (!(curvature > 0)) break;
    const double alpha = rho / curvature;
    ++g.iterations;
    g.residual = std::sqrt(sum([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        g.u[i] += alpha * g.p[i];
        g.r[i] = held[i] != 0 ? 0 : g.r[i] - alpha * g.image[i];
      }
      return inner(g.r.data(), g.r.data(), begin, end);
    }));
  }
  return {};
}

VoxelElasticity::VoxelElasticity(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
VoxelElasticity::VoxelElasticity(VoxelElasticity&&) noexcept = default;
VoxelElasticity& VoxelElasticity::operator=(VoxelElasticity&&) noexcept = default;
VoxelElasticity::~VoxelElasticity() = default;

Result<VoxelElasticity> VoxelElasticity::prepare(const SolidMesh& solid, ElasticBody body,
                                                 std::span<const NodeSupport> supports,
                                                 const VoxelElasticityOptions& options, Context& context) {
  const Stage stage(context, "elasticity: set-up");
  TURGOR_CHECK(check(options));
  TURGOR_TRY(VoxelNumbering numbering, VoxelNumbering::of(solid));
  TURGOR_CHECK(detail::check(body, numbering.cubes.size()));
  TURGOR_CHECK(detail::check(supports, solid.points.size()));
  auto parts = std::make_unique<Parts>(std::move(numbering), std::move(body), options);
  const VoxelNumbering& n = parts->numbering;
  parts->points.assign(solid.points.begin(), solid.points.end());
  TURGOR_CHECK(detail::check_held(
      parts->points, n.cubes, [&](const auto& pair) { n.face_pairs(pair); }, supports));
  TURGOR_CHECK(context.check());
  parts->spacing = solid.spacing;
  parts->supports.assign(supports.begin(), supports.end());
  parts->set_moduli();
  parts->set_held();
  parts->set_prescribed();
  parts->stiffness = std::make_unique<VoxelOperator<double>>(n.rows, detail::cube_stiffness(solid.spacing),
                                                             parts->shear, parts->bulk, nullptr);
  const int steps = options.smoothing_steps > 0 ? options.smoothing_steps : smoothing_steps_for(parts->body);
  TURGOR_TRY(VoxelMultigrid multigrid,
             VoxelMultigrid::build(parts->finest_level(), parts->held, steps, context));
  parts->multigrid = std::make_unique<VoxelMultigrid>(std::move(multigrid));
  return VoxelElasticity(std::move(parts));
}

Result<void> VoxelElasticity::set_displacements(std::span<const Vec3> displacement_mm) {
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts_->supports.size()));
  for (std::size_t s = 0; s < displacement_mm.size(); ++s)
    parts_->supports[s].displacement_mm = displacement_mm[s];
  parts_->set_prescribed();
  return {};
}

Result<ElasticSolution> VoxelElasticity::solve(const ElasticLoad& load, Context& context,
                                               std::span<const Vec3> start) const {
  const Stage stage(context, "elasticity");
  const Parts& parts = *parts_;
  TURGOR_TRY(const std::vector<double> force, parts.forces_of(load));
  if (!start.empty()) TURGOR_CHECK(detail::check_displacement(start, parts.points.size()));
  const std::size_t n = parts.numbering.rows.values();
  Parts::Progress g{parts.prescribed, std::vector<double>(n), std::vector<double>(n), std::vector<double>(n),
                    VoxelMultigrid::Work(*parts.multigrid)};
  g.residual = parts.residual_of(force, g.u, g.image, g.r);
  const double whole = g.residual;
  double target = parts.options.relative_residual * whole;
  if (!start.empty() && whole > 0) {
    std::vector<double>& u = g.u;
    parts.numbering.scatter(start, u);
    for (std::size_t i = 0; i < n; ++i) u[i] = parts.held[i] != 0 ? parts.prescribed[i] : u[i];
    g.residual = parts.residual_of(force, u, g.image, g.r);
  }
  for (int restart = 0; restart < kMostRestarts && g.residual > target; ++restart) {
    std::fill(g.p.begin(), g.p.end(), 0.0);
    TURGOR_CHECK(parts.iterate(g, target, context));
    g.residual = parts.residual_of(force, g.u, g.image, g.r);
    target = std::max(target, parts.rounding_of(g.u));
  }
  ElasticSolution out;
  out.displacement_mm = parts.numbering.gather(g.u);
  out.iterations = g.iterations;
  out.relative_residual = whole > 0 ? g.residual / whole : 0;
  out.converged = g.residual <= target;
  if (!out.converged) {
    context.warning(fmt::format("elasticity: relative residual {:.2g} after {} iterations, {:.2g} asked for",
                                out.relative_residual, out.iterations, parts.options.relative_residual));
  }
  out.strain_energy_nmm = 0.5 * parts.sum([&](std::size_t begin, std::size_t end) {
    return inner(g.u.data(), g.image.data(), begin, end);
  });
  for (std::size_t i = 0; i < n; ++i) g.r[i] = parts.held[i] != 0 ? g.image[i] - force[i] : 0;
  out.reaction_n = parts.numbering.gather(g.r);
  return out;
}

Result<std::vector<ElementStress>> VoxelElasticity::stress(std::span<const Vec3> displacement_mm) const {
  const Parts& parts = *parts_;
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts.points.size()));
  const auto& cubes = parts.numbering.cubes;
  std::vector<ElementStress> out(cubes.size());
  const double slope = 1 / (4 * parts.spacing);
  parallel_for(cubes.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      std::array<Vec3, 3> along{};  // ∂u/∂x, ∂u/∂y, ∂u/∂z at the centre, which are the means
      for (std::size_t n = 0; n < 8; ++n) {
        const Vec3& u = displacement_mm[at(cubes[e][n])];
        for (std::size_t a = 0; a < 3; ++a)
          along[a] += u * (((detail::kCornerBits[n] >> a) & 1) != 0 ? slope : -slope);
      }
      SymmetricTensor& s = out[e].strain;
      s = {along[0].x,
           along[1].y,
           along[2].z,
           0.5 * (along[1].x + along[0].y),
           0.5 * (along[2].y + along[1].z),
           0.5 * (along[0].z + along[2].x)};
      out[e].stress_mpa = stress_of(s, parts.body.of(e));
    }
  });
  return out;
}

Result<std::vector<Vec3>> VoxelElasticity::internal_forces(std::span<const Vec3> displacement_mm) const {
  TURGOR_CHECK(detail::check_displacement(displacement_mm, parts_->points.size()));
  const std::size_t n = parts_->numbering.rows.values();
  std::vector<double> u(n, 0), image(n);
  parts_->numbering.scatter(displacement_mm, u);
  parts_->multiply(u, image);
  return parts_->numbering.gather(image);
}

}  // namespace turgor
