#include "dynamics/point_terms.hpp"

#include <array>
#include <cmath>
#include <functional>

#include "tissue/incidence.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr std::size_t kGrain = 1024;

Mat3 outer(const Vec3& a, const Vec3& b) {
  return Mat3{{a * b.x, a * b.y, a * b.z}};
}

void add_diagonal(Mat3& m, double k) {
  m.c[0].x += k;
  m.c[1].y += k;
  m.c[2].z += k;
}

}  // namespace

PointTerms::PointTerms(const SpringNetwork& network, const NetworkEnergy& energy,
                       std::span<const int> unknowns)
    : rest_(network.rest),
      mass_g_(network.mass_g),
      row_of_point_(network.rest.size(), -1),
      is_held_(network.rest.size(), 0) {
  for (std::size_t row = 0; row < unknowns.size(); ++row)
    row_of_point_[at(unknowns[row])] = static_cast<int>(row);
  for (const int p : unknowns) {
    visit_neighbours(energy, p, [&](int /*neighbour*/) { is_held_[at(p)] = 1; });
    if (energy.contact_at(p) >= 0) is_held_[at(p)] = 1;
  }
  update();
}

void PointTerms::set_loads(Loads loads) {
  loads_ = std::move(loads);
  barriers_of_ = {loads_.barriers, rest_.size()};
  update();
}

void PointTerms::set_inertia(const Inertia* inertia) {
  inertia_ = inertia;
  update();
}

void PointTerms::update() {
  acts_.assign(rest_.size(), 0);
  double square = 0;
  for (std::size_t p = 0; p < rest_.size(); ++p) {
    acts_[p] = static_cast<char>(row_of_point_[p] >= 0 && (inertia_ != nullptr || is_held_[p] != 0));
    if (acts_[p] == 0) continue;
    square += squared_length(constant_force(p));
    if (inertia_ == nullptr) continue;
    const double per_length = mass_g_[p] / (inertia_->dt_ms * inertia_->dt_ms);
    square += squared_length((inertia_->ahead[p] - inertia_->from[p]) * per_length);
  }
  scale_ = std::sqrt(square);
}

Vec3 PointTerms::constant_force(std::size_t point) const {
  const Vec3 weight = loads_.gravity_mm_ms2 * mass_g_[point];
  return loads_.force_n.empty() ? weight : weight + loads_.force_n[point];
}

double PointTerms::point_terms(int point, const Vec3& x, Vec3& force) const {
  const std::size_t p = at(point);
  const Vec3 constant = constant_force(p);
  force += constant;
  double energy = -dot(constant, x - rest_[p]);
  barriers_of_.visit(point, [&](int b) {
    const BarrierResponse r = respond(loads_.barriers[at(b)], x);
    force += r.force;
    energy += r.energy;
  });
  if (inertia_ != nullptr) {
    const double dt = inertia_->dt_ms, k = mass_g_[p] / (dt * dt), c = inertia_->damping_g_ms / dt;
    const Vec3 off = x - inertia_->ahead[p], moved = x - inertia_->from[p];
    force -= off * k + moved * c;
    energy += 0.5 * (k * squared_length(off) + c * squared_length(moved));
  }
  return energy;
}

double PointTerms::add_forces(std::span<const Vec3> positions, std::span<Vec3> forces) const {
  double energy = parallel_sum(positions.size(), kGrain, [&](std::size_t p) {
    return acts_[p] != 0 ? point_terms(static_cast<int>(p), positions[p], forces[p]) : 0.0;
  });
  for (const Grab& grab : loads_.grabs) {
    const GrabResponse r = respond(grab, positions);
    energy += r.energy;
    for (std::size_t i = 0; i < grab.points.size(); ++i) {
      if (acts(grab.points[i])) forces[at(grab.points[i])] += r.force * grab.weights[i];
    }
  }
  return energy;
}

void PointTerms::add_stiffness(std::span<const Vec3> positions, StiffnessMatrix& matrix) const {
  const auto& unknowns = matrix.unknowns();
  parallel_for(unknowns.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const int point = unknowns[row];
      if (!acts(point)) continue;
      Mat3 block{{Vec3{}, Vec3{}, Vec3{}}};
      barriers_of_.visit(point, [&](int b) {
        const BarrierResponse r = respond(loads_.barriers[at(b)], positions[at(point)]);
        const Vec3 n = normalized(r.force);
        const Mat3 along = outer(n * r.slope, n);
        for (std::size_t c = 0; c < 3; ++c) block.c[c] += along.c[c];
      });
      if (inertia_ != nullptr) {
        const double dt = inertia_->dt_ms;
        add_diagonal(block, mass_g_[at(point)] / (dt * dt) + inertia_->damping_g_ms / dt);
      }
      matrix.add_to_diagonal(static_cast<int>(row), block);
    }
  });
}

std::vector<CoupledStiffness> PointTerms::coupled(std::span<const Vec3> positions) const {
  std::vector<CoupledStiffness> terms;
  for (const Grab& grab : loads_.grabs) {
    CoupledStiffness term;
    for (std::size_t i = 0; i < grab.points.size(); ++i) {
      if (!acts(grab.points[i])) continue;
      term.rows.push_back(row_of_point_[at(grab.points[i])]);
      term.weights.push_back(grab.weights[i]);
    }
    // k up to the limit; beyond, the force turns but does not grow: limit/d across it.
    const GrabResponse r = respond(grab, positions);
    const double force = length(r.force);
    term.stiffness = Mat3{{Vec3{}, Vec3{}, Vec3{}}};
    const bool gives_way = r.energy > 0 && force * force < 1.999999 * r.energy * grab.stiffness_n_mm;
    if (gives_way) {
      const double distance = r.energy / force + 0.5 * force / grab.stiffness_n_mm, across = force / distance;
      const Vec3 n = r.force / force;
      term.stiffness = outer(n * -across, n);
      add_diagonal(term.stiffness, across);
    } else {
      add_diagonal(term.stiffness, grab.stiffness_n_mm);
    }
    if (!term.rows.empty()) terms.push_back(std::move(term));
  }
  return terms;
}

}  // namespace turgor
