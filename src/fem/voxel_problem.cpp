#include "fem/voxel_problem.hpp"

#include <algorithm>

#include "fem/elastic_problem.hpp"
#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

// A plane holds its node, for the preconditioner, where it is stiffer than the node's own cubes are.
constexpr double kHolds = 1;
// Of the mean deformation about a node, below which it is left aside.
constexpr double kLeastVolume = 0.05;

// Near incompressibility the smoother has to do more, as coarse lattices are too stiff. Where each system is
// solved to a tenth alone, as of laws that are not linear, cheaper cycles are quicker.
Smoothing smoothing_of(const VoxelProblem& problem) {
  if (problem.options.smoothing_steps > 0) return {problem.options.smoothing_steps, 1};
  if (problem.laws != nullptr) return {4, 1};
  double largest = 0;
  for (const ElasticMaterial& m : problem.body.materials) largest = std::max(largest, m.poissons_ratio);
  return {largest <= 0.4 ? 4 : largest <= 0.46 ? 5 : largest < 0.48 ? 6 : 8, 3};
}

}  // namespace

void VoxelProblem::set_moduli() {
  shear.assign(numbering.rows.cell_count, 0);
  bulk.assign(numbering.rows.cell_count, 0);
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
    const ElasticMaterial m = body.of(c);
    shear[numbering.cell(c)] = m.shear_modulus();
    bulk[numbering.cell(c)] = m.bulk_modulus();
  }
}

void VoxelProblem::set_held() {
  held.assign(numbering.rows.values(), 1);
  for (const NodePlace& p : numbering.nodes)
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c) held[p.component(c)] = 0;
  for (const NodeSupport& s : supports.nodes) {
    const NodePlace& p = numbering.nodes[at(s.node)];
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c)
      if (s.held[c]) held[p.component(c)] = 1;
  }
}

void VoxelProblem::set_prescribed() {
  prescribed.assign(numbering.rows.values(), 0);
  for (const NodeSupport& s : supports.nodes) {
    const NodePlace& p = numbering.nodes[at(s.node)];
    for (std::size_t c = 0; c < 3 && p.stride > 0; ++c)
      if (s.held[c]) prescribed[p.component(c)] = s.displacement_mm[static_cast<int>(c)];
  }
}

void VoxelProblem::set_contacts() {
  contacts.clear();
  if (supports.contacts.empty()) return;
  std::vector<std::size_t> cell_of(points.size(), 0);
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c)
    for (const int node : numbering.cubes[c]) cell_of[at(node)] = numbering.cell(c);
  for (const Contact& c : supports.contacts) {
    const NodePlace& p = numbering.nodes[at(c.point)];
    if (p.stride == 0) continue;
    const Vec3 n = normalized(c.normal);
    contacts.push_back({p, c.point, cell_of[at(c.point)], n, c.offset_mm - dot(n, points[at(c.point)]),
                        c.stiffness_n_mm, c.adhesion_n_mm});
  }
  std::sort(contacts.begin(), contacts.end(),
            [](const LatticeContact& a, const LatticeContact& b) { return a.node.value < b.node.value; });
}

void VoxelProblem::set_cubes_of() {
  first_cube.assign(points.size() + 1, 0);
  for (const auto& cube : numbering.cubes)
    for (const int node : cube) ++first_cube[at(node) + 1];
  for (std::size_t n = 0; n < points.size(); ++n) first_cube[n + 1] += first_cube[n];
  cubes_of.resize(first_cube.back());
  std::vector<std::size_t> next(first_cube.begin(), first_cube.end() - 1);
  for (std::size_t e = 0; e < numbering.cubes.size(); ++e)
    for (const int node : numbering.cubes[e]) cubes_of[next[at(node)]++] = static_cast<int>(e);
}

std::span<const LatticeContact> VoxelProblem::contacts_in(std::size_t begin, std::size_t end) const {
  const auto before = [](const LatticeContact& c, std::size_t value) { return c.node.value < value; };
  const auto first = std::lower_bound(contacts.begin(), contacts.end(), begin, before);
  return {first, std::lower_bound(first, contacts.end(), end, before)};
}

double VoxelProblem::unit() const {
  return spacing * std::max(*std::max_element(shear.begin(), shear.end()), 1e-300);
}

std::vector<NodePlane> VoxelProblem::planes_of(const std::vector<double>& slopes,
                                               const std::vector<Mat3>& warp) const {
  std::vector<NodePlane> planes;
  const CubeStiffness cube = cube_stiffness(spacing);
  const double of_shear = matrix_of(cube.shear)[0], of_bulk = matrix_of(cube.bulk)[0], per_unit = 1 / unit();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LatticeContact& c = contacts[i];
    const double slope = slopes[i];
    Vec3 free = c.normal;  // what of the normal is not held
    for (std::size_t a = 0; a < 3; ++a)
      if (held[c.node.component(a)] != 0) free[static_cast<int>(a)] = 0;
    const double part = squared_length(free);
    if (!(slope * part > 0) || part < 1e-6) continue;
    const Vec3 n = warp.empty() ? normalized(free) : normalized(warp[at(c.point)].transposed() * free);
    const double own = of_shear * shear[c.cell] + of_bulk * bulk[c.cell];
    NodePlane plane{c.node, c.cell, {}, static_cast<float>(std::min(slope * part * per_unit, 1e15)), false};
    for (std::size_t a = 0; a < 3; ++a) plane.normal[a] = static_cast<float>(n[static_cast<int>(a)]);
    plane.holds = slope * part > kHolds * own;
    planes.push_back(plane);
  }
  return planes;
}

// In single precision, moduli relative to the largest.
Result<VoxelMultigrid> VoxelProblem::cycle_with(std::vector<NodePlane> planes, const Context& context) const {
  auto level = std::make_unique<VoxelLevel>();
  level->rows = numbering.rows;
  level->spans = numbering.spans;
  level->stiffness = cube_stiffness(1);
  level->planes = std::move(planes);
  const double largest = std::max(*std::max_element(shear.begin(), shear.end()), 1e-300);
  const auto relative = [&](double m) { return static_cast<float>(m / largest); };
  level->shear.resize(shear.size());
  level->bulk.resize(bulk.size());
  std::transform(shear.begin(), shear.end(), level->shear.begin(), relative);
  std::transform(bulk.begin(), bulk.end(), level->bulk.begin(), relative);
  level->held_cell.assign(numbering.rows.cell_count, 0);
  std::vector<bool> special(numbering.rows.values(), false);  // nodes that are held or on a plane
  for (const NodeSupport& s : supports.nodes)
    if (s.held[0] || s.held[1] || s.held[2]) special[numbering.nodes[at(s.node)].value] = true;
  for (const NodePlane& p : level->planes) special[p.node.value] = true;
  for (std::size_t c = 0; c < numbering.cubes.size(); ++c) {
    for (const int node : numbering.cubes[c])
      if (special[numbering.nodes[at(node)].value]) level->held_cell[numbering.cell(c)] = 1;
  }
  level->finish(held);
  return VoxelMultigrid::build(std::move(level), held, smoothing_of(*this), context);
}

// Once all else is set. Of contacts only a solution knows which are closed.
Result<void> VoxelProblem::set_cycle(const Context& context) {
  if (!contacts.empty()) return {};
  TURGOR_TRY(VoxelMultigrid made, cycle_with({}, context));
  multigrid = std::make_unique<VoxelMultigrid>(std::move(made));
  return {};
}

std::vector<Mat3> nodal_deformations(const VoxelProblem& problem, const std::vector<double>& u) {
  const VoxelNumbering& n = problem.numbering;
  const double slope = 1 / (4 * problem.spacing);
  std::vector<Mat3> of_cube(n.cubes.size());
  parallel_for(of_cube.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      Mat3 f;
      for (std::size_t c = 0; c < 8; ++c) {
        const NodePlace& p = n.nodes[at(n.cubes[e][c])];
        const Vec3 moved{u[p.component(0)], u[p.component(1)], u[p.component(2)]};
        for (std::size_t a = 0; a < 3; ++a)
          f.c[a] += moved * (((kCornerBits[c] >> a) & 1) != 0 ? slope : -slope);
      }
      of_cube[e] = f;
    }
  });
  std::vector<Mat3> out(n.nodes.size());
  parallel_for(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const NodePlace& p = n.nodes[i];
      if (p.stride == 0 || problem.held[p.component(0)] != 0 || problem.held[p.component(1)] != 0 ||
          problem.held[p.component(2)] != 0)
        continue;
      Mat3 sum{{Vec3{}, Vec3{}, Vec3{}}};
      int count = 0;
      for (std::size_t k = problem.first_cube[i]; k < problem.first_cube[i + 1]; ++k, ++count)
        for (std::size_t a = 0; a < 3; ++a) sum.c[a] += of_cube[at(problem.cubes_of[k])].c[a];
      for (Vec3& column : sum.c) column /= count;
      if (sum.determinant() > kLeastVolume) out[i] = sum;
    }
  });
  return out;
}

Result<std::vector<double>> VoxelProblem::forces_of(const ElasticLoad& load) const {
  std::vector<Vec3> force(points.size());
  TURGOR_CHECK(add_point_and_surface_loads(points, load, force));
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

}  // namespace turgor::detail
