#include "turgor/dynamics/equilibrium_sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/constant_forces.hpp"
#include "dynamics/point_terms.hpp"
#include "dynamics/stiffness_factors.hpp"
#include "tissue/incidence.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kGrain = 4096;
// Sides solved at a time: what they take is bounded, whatever their number.
constexpr std::size_t kBatch = 64;
// Of the differences that tell how a barrier's force changes: of its size.
constexpr double kBarrierStep = 1e-5;

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "sensitivity of an equilibrium", std::move(remedy)};
}

/// The points that K is about, ascending: free ones that an element or a contact holds.
std::vector<int> unknowns_of(const NetworkEnergy& energy, const PrescribedMotion& motion) {
  std::vector<char> unknown(at(energy.point_count()), 0);
  for (int p = 0; p < energy.point_count(); ++p) {
    visit_neighbours(energy, p, [&](int /*neighbour*/) { unknown[at(p)] = 1; });
    if (energy.contact_at(p) >= 0) unknown[at(p)] = 1;
  }
  for (const int p : motion.moved) unknown[at(p)] = 0;
  for (const int p : motion.fixed) unknown[at(p)] = 0;
  std::vector<int> out;
  for (int p = 0; p < energy.point_count(); ++p)
    if (unknown[at(p)] != 0) out.push_back(p);
  return out;
}

// −∂f/∂x, by central differences: the curvature of a barrier depends on the feature of it that is nearest.
Mat3 stiffness_of(const Barrier& barrier, const Vec3& x) {
  const double size = barrier.shape == Barrier::Shape::sphere ? barrier.radius_mm : barrier.scale_mm;
  const double step = kBarrierStep * size;
  Mat3 k;
  for (int j = 0; j < 3; ++j) {
    Vec3 ahead = x, behind = x;
    ahead[j] += step;
    behind[j] -= step;
    k.c[at(j)] = (respond(barrier, behind).force - respond(barrier, ahead).force) / (2 * step);
  }
  const Mat3 t = k.transposed();
  for (std::size_t j = 0; j < 3; ++j) k.c[j] = (k.c[j] + t.c[j]) * 0.5;
  return k;
}

void add_barriers(const Loads& loads, std::span<const Vec3> positions, std::span<const int> row_of_point,
                  StiffnessMatrix& matrix) {
  for (const Barrier& barrier : loads.barriers) {
    const auto add = [&](int point) {
      const Vec3& x = positions[at(point)];
      if (row_of_point[at(point)] >= 0 && respond(barrier, x).force != Vec3{})
        matrix.add_to_diagonal(row_of_point[at(point)], stiffness_of(barrier, x));
    };
    for (const int p : barrier.points) add(p);
    if (!barrier.points.empty()) continue;
    for (const int p : matrix.unknowns()) add(p);
  }
}

}  // namespace

NetworkConstants::NetworkConstants(const SpringNetwork& network)
    : springs(network.springs.size()),
      volumes(springs + network.volumes.size()),
      areas(volumes + network.areas.size()) {
  std::size_t last = areas;
  for (const Solid& solid : network.solids) {
    const std::size_t edges = last + solid.edges.size(), triangles = edges + solid.triangles.size();
    last = triangles + solid.tetrahedra.size();
    solids.push_back({edges, triangles, last});
  }
}

void scale_constants(SpringNetwork& network, std::span<const double> factors) {
  const double* factor = factors.data();
  for (Spring& spring : network.springs) spring.stiffness_n *= *factor++;
  for (VolumeElement& volume : network.volumes) {
    volume.modulus_mpa *= *factor;
    volume.inversion_guard_mpa *= *factor++;
  }
  for (AreaElement& area : network.areas) area.stiffness_nmm *= *factor++;
  for (Solid& solid : network.solids) {
    for (auto* const constants : {&solid.edge_nmm, &solid.triangle_nmm, &solid.tetrahedron_nmm})
      for (double& k : *constants) k *= *factor++;
  }
}

struct EquilibriumSensitivity::Parts {
  NetworkEnergy energy;
  ElementStiffness stiffness;
  std::vector<int> unknowns, row_of_point;
  std::vector<ElementForce> forces;
  std::optional<StiffnessFactors> factors = std::nullopt;

  /// K v of the network alone, at every point.
  [[nodiscard]] std::vector<Vec3> multiply(std::span<const Vec3> v) const {
    std::vector<Vec3> out(v.size());
    NetworkEnergy::Workspace workspace;
    energy.multiply(stiffness, v, out, workspace);
    return out;
  }
  void add_force(const ConstantChange& change, std::span<Vec3> by_point) const {
    const ElementForce& e = forces[at(change.constant)];
    for (int c = 0; c < e.corners; ++c) by_point[at(e.point[at(c)])] += e.force_n[at(c)] * change.relative;
  }
  [[nodiscard]] std::vector<Vec3> rows_of(std::span<const Vec3> by_point) const {
    std::vector<Vec3> out(unknowns.size());
    for (std::size_t row = 0; row < out.size(); ++row) out[row] = by_point[at(unknowns[row])];
    return out;
  }
  [[nodiscard]] std::vector<Vec3> points_of(std::span<const Vec3> by_row) const {
    std::vector<Vec3> out(row_of_point.size());
    for (std::size_t row = 0; row < by_row.size(); ++row) out[at(unknowns[row])] = by_row[row];
    return out;
  }
};

EquilibriumSensitivity::EquilibriumSensitivity(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
EquilibriumSensitivity::EquilibriumSensitivity(EquilibriumSensitivity&&) noexcept = default;
EquilibriumSensitivity& EquilibriumSensitivity::operator=(EquilibriumSensitivity&&) noexcept = default;
EquilibriumSensitivity::~EquilibriumSensitivity() = default;

Result<EquilibriumSensitivity> EquilibriumSensitivity::prepare(const SpringNetwork& network,
                                                               const PrescribedMotion& motion,
                                                               const Loads& loads,
                                                               std::span<const Vec3> positions,
                                                               Context& context) {
  TURGOR_TRY(NetworkEnergy energy, NetworkEnergy::prepare(network));
  TURGOR_CHECK(validate(motion, energy.point_count()));
  TURGOR_CHECK(validate(loads, network.rest.size()));
  if (positions.size() != network.rest.size() ||
      !std::all_of(positions.begin(), positions.end(), is_within_reach))
    return bad("the positions are not those of the network's points", "Give those of an equilibrium");
  auto parts = std::make_unique<Parts>(Parts{std::move(energy), {}, {}, {}, {}});
  parts->unknowns = unknowns_of(parts->energy, motion);
  parts->row_of_point.assign(positions.size(), -1);
  for (std::size_t row = 0; row < parts->unknowns.size(); ++row)
    parts->row_of_point[at(parts->unknowns[row])] = static_cast<int>(row);
  parts->energy.linearise(positions, 0, parts->stiffness);
  StiffnessMatrix matrix(parts->energy, parts->unknowns);
  matrix.assemble(parts->energy, parts->stiffness);
  add_barriers(loads, positions, parts->row_of_point, matrix);
  PointTerms terms(network, parts->energy, parts->unknowns);
  terms.set_loads(loads);
  TURGOR_CHECK(context.check());
  parts->factors = StiffnessFactors::of(matrix, terms.coupled(positions));
  if (!parts->factors)
    return Error{ErrorKind::not_converged,
                 "the body could move there without force, or would rather be elsewhere",
                 "sensitivity of an equilibrium", "Hold it, or let it come to rest first"};
  TURGOR_CHECK(context.check());
  parts->forces = forces_of_constants(network, positions);
  return EquilibriumSensitivity(std::move(parts));
}

std::vector<std::vector<Vec3>> EquilibriumSensitivity::along_each(
    std::span<const std::vector<ConstantChange>> changes) const {
  std::vector<std::vector<Vec3>> out(changes.size());
  for (std::size_t first = 0; first < out.size(); first += kBatch) {
    const auto batch = std::span(out).subspan(first, std::min(kBatch, out.size() - first));
    parallel_for(batch.size(), 1, [&](std::size_t i, std::size_t) {
      std::vector<Vec3> force(parts_->row_of_point.size());
      for (const ConstantChange& change : changes[first + i]) parts_->add_force(change, force);
      batch[i] = parts_->rows_of(force);
    });
    parts_->factors->solve(batch);
    parallel_for(batch.size(), 1,
                 [&](std::size_t i, std::size_t) { batch[i] = parts_->points_of(batch[i]); });
  }
  return out;
}

std::vector<Vec3> EquilibriumSensitivity::along(std::span<const double> change) const {
  std::vector<ConstantChange> changes;
  for (std::size_t c = 0; c < change.size(); ++c)
    if (change[c] != 0) changes.push_back({static_cast<int>(c), change[c]});
  return std::move(along_each({&changes, 1}).front());
}

// What holds a point is minus the network's force on it.
std::vector<Vec3> EquilibriumSensitivity::reactions_along(std::span<const ConstantChange> change,
                                                          std::span<const Vec3> shift) const {
  std::vector<Vec3> force(shift.size()), out = parts_->multiply(shift);
  for (const ConstantChange& c : change) parts_->add_force(c, force);
  for (std::size_t p = 0; p < out.size(); ++p) out[p] -= force[p];
  return out;
}

// With r = −f of the network, dr = K dx − ∂f/∂p: a seed s of reactions is one of K s on positions and of −s
// on the forces themselves.
std::vector<double> EquilibriumSensitivity::adjoint(std::span<const Vec3> seed,
                                                    std::span<const Vec3> reaction_seed) const {
  std::vector<Vec3> sum(seed.begin(), seed.end());
  if (!reaction_seed.empty()) {
    const std::vector<Vec3> product = parts_->multiply(reaction_seed);
    for (std::size_t p = 0; p < sum.size(); ++p) sum[p] += product[p];
  }
  std::vector<Vec3> side = parts_->rows_of(sum);
  parts_->factors->solve({&side, 1});
  std::vector<Vec3> weight = parts_->points_of(side);
  for (std::size_t p = 0; p < reaction_seed.size(); ++p) weight[p] -= reaction_seed[p];
  std::vector<double> out(parts_->forces.size());
  parallel_for(out.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      const ElementForce& e = parts_->forces[c];
      for (std::size_t k = 0; k < at(e.corners); ++k) out[c] += dot(weight[at(e.point[k])], e.force_n[k]);
    }
  });
  return out;
}

}  // namespace turgor
