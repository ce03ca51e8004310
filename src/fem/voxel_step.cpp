#include "fem/voxel_step.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::detail {
namespace {

// Of contacts whose state differs from the preconditioner's, before that is built anew: sooner where it
// serves many iterations, as for a small residual.
constexpr double kMostDiffering = 0.05, kMostDifferingRoughly = 0.2, kRoughResidual = 1e-3;
// Of conjugate gradients under laws that are not linear, in which what is left has to halve, or it is
// better to linearise anew.
constexpr int kPatience = 30;
// Residual, relative to loads and reactions, beyond which the energy is made convex cube by cube from the
// first.
constexpr double kFar = 0.05;
// Beginnings anew of one step for contacts.
constexpr int kMostTouches = 10;

}  // namespace

VoxelStep::VoxelStep(const VoxelProblem& problem, Context& context)
    : problem_(problem), context_(context), slope_(problem.contacts.size()), cycle_(problem.multigrid.get()) {
  if (cycle_ != nullptr) work_.emplace(*cycle_);
  for (auto* v : {&step_, &left_, &direction_, &image_}) v->resize(problem.numbering.rows.values());
}

Result<void> VoxelStep::meet(const VoxelState& state) {
  state_ = &state;
  return cycle_ == nullptr ? touch() : Result<void>{};
}

Result<void> VoxelStep::linearise(const VoxelState& state) {
  state_ = &state;
  convex_ = false;
  std::fill(step_.begin(), step_.end(), 0.0);
  if (problem_.laws != nullptr) {
    warp_ = nodal_deformations(problem_, state.u);
    matrices_.resize(problem_.laws->matrices_size());
    problem_.laws->linearise(state.u.data(), matrices_);
    convex_ = state.norm > kFar * state.reference;
    if (convex_) problem_.laws->convexify(matrices_);
  }
  left_ = state.residual, left_norm_ = state.norm;
  return touch();
}

// Contacts as they are after the step, and a cycle for them.
Result<void> VoxelStep::touch() {
  for (std::size_t i = 0; i < slope_.size(); ++i) {
    const LatticeContact& c = problem_.contacts[i];
    slope_[i] = c.slope(c.distance(state_->u) + c.along(step_));
  }
  return prepare_cycle();
}

// How many of the planes are not as the cycle was built with; those are to hold from now on.
std::size_t VoxelStep::differing(std::vector<NodePlane>& planes) const {
  const std::vector<NodePlane>& built = cycle_->level(0).planes;
  std::size_t out = 0, b = 0;
  for (NodePlane& p : planes) {
    while (b < built.size() && built[b].node.value < p.node.value) ++out, ++b;
    const bool known = b < built.size() && built[b].node.value == p.node.value;
    bool same = known && built[b].holds == p.holds;
    if (same) {
      float turn = 0;
      for (std::size_t a = 0; a < 3; ++a) turn += built[b].normal[a] * p.normal[a];
      same = turn > 0.98F;
    }
    if (!same) ++out, p.holds = true;
    if (known) ++b;
  }
  return out + built.size() - b;
}

// A preconditioner for the contacts that are closed after the step: few that differ are set right on the
// finest lattice alone.
Result<void> VoxelStep::prepare_cycle() {
  if (problem_.contacts.empty()) return {};
  std::vector<NodePlane> planes = problem_.planes_of(slope_, warp_);
  const bool roughly = problem_.options.relative_residual > kRoughResidual;
  const double most = cycle_ == nullptr || cycle_->level_count() == 1 ? 0
                      : roughly                                       ? kMostDifferingRoughly
                                                                      : kMostDiffering;
  const auto count = static_cast<double>(problem_.contacts.size());
  const std::vector<NodePlane> built = planes;
  if (cycle_ == nullptr || static_cast<double>(differing(planes)) > most * count) {
    TURGOR_TRY(own_cycle_, problem_.cycle_with(built, context_));
    cycle_ = &*own_cycle_;
    work_.emplace(*cycle_);
  } else {
    work_->planes() = std::move(planes);
  }
  list_holding();
  return {};
}

// What the finest lattice's planes hold, with the stiffness there.
void VoxelStep::list_holding() {
  holding_.clear();
  if (cycle_->level_count() == 1) return;
  const std::vector<float>& scaling = cycle_->level(0).scaling;
  const double unit = problem_.unit();
  for (const NodePlane& p : work_->planes()) {
    if (!p.holds) continue;
    LatticeContact c = problem_.contacts_in(p.node.value, p.node.value + 1)[0];
    double diagonal = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const std::size_t i = c.node.component(a);
      if (problem_.held[i] != 0) c.normal[static_cast<int>(a)] = 0;
      if (scaling[i] != 0) diagonal = unit / static_cast<double>(scaling[i]);
    }
    c.stiffness_n_mm = diagonal + static_cast<double>(p.stiffness) * unit;
    c.normal = normalized(c.normal);
    holding_.push_back(c);
  }
}

// Values by the transposes of the nodes' deformations (`back`), or by those themselves.
template <class T>
void VoxelStep::warp_nodes(bool back, std::vector<T>& values) const {
  parallel_for(warp_.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const NodePlace& p = problem_.numbering.nodes[n];
      if (p.stride == 0) continue;
      const Vec3 v{static_cast<double>(values[p.component(0)]), static_cast<double>(values[p.component(1)]),
                   static_cast<double>(values[p.component(2)])};
      const Mat3& f = warp_[n];
      const Vec3 warped = back ? Vec3{dot(f.c[0], v), dot(f.c[1], v), dot(f.c[2], v)} : f * v;
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = p.component(c);
        values[i] = problem_.held[i] != 0 ? T(0) : static_cast<T>(warped[static_cast<int>(c)]);
      }
    }
  });
}

// The cycle of what is left; returns its product with that. The cycle is linear; it is given vectors of
// length 1 so that single precision holds any forces. What planes hold of a node's motion is left to a
// division, as it hardly acts on the rest; in double precision, as stiff planes feel every digit.
double VoxelStep::precondition() {
  std::vector<double>& z = image_;
  const double scale = 1 / left_norm_;
  std::vector<float>& right = work_->residual();
  std::vector<double> along(holding_.size());
  for (std::size_t i = 0; i < along.size(); ++i) {
    along[i] = holding_[i].along(left_);
    holding_[i].add(-along[i], left_);
  }
  problem_.for_planes([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) right[i] = static_cast<float>(scale * left_[i]);
  });
  warp_nodes(true, right);
  // What is free of planes leans into them in the frames at rest.
  if (!holding_.empty() && !warp_.empty()) project(work_->planes(), right.data());
  cycle_->cycle(*work_);
  const std::vector<float>& result = work_->result();
  const double back = left_norm_ / problem_.unit();
  problem_.for_planes([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) z[i] = back * static_cast<double>(result[i]);
  });
  warp_nodes(false, z);
  for (std::size_t i = 0; i < along.size(); ++i) {
    const LatticeContact& c = holding_[i];
    c.add(along[i], left_);
    c.add(along[i] / c.stiffness_n_mm - c.along(z), z);
  }
  return problem_.sum(
      [&](std::size_t begin, std::size_t end) { return inner(left_.data(), z.data(), begin, end); });
}

// out = second derivatives · in; the products with `in` by planes.
void VoxelStep::multiply(const std::vector<double>& in, std::vector<double>& out,
                         std::vector<double>* products) {
  const auto done = [&](std::size_t plane, std::size_t begin, std::size_t end) {
    for (const LatticeContact& c : problem_.contacts_in(begin, end))
      c.add(slope_[static_cast<std::size_t>(&c - problem_.contacts.data())] * c.along(in), out);
    if (products != nullptr) (*products)[plane] = inner(in.data(), out.data(), begin, end);
  };
  if (problem_.laws != nullptr)
    problem_.laws->apply(matrices_, in.data(), out.data(), done);
  else
    problem_.stiffness->apply(in.data(), out.data(), done);
}

// What contacts do otherwise after the step than conjugate gradients reckon with: beyond that there is no use
// in solving on.
double VoxelStep::mismatch() const {
  double square = 0;
  for (std::size_t i = 0; i < slope_.size(); ++i) {
    const LatticeContact& c = problem_.contacts[i];
    const double d = c.distance(state_->u) + c.along(step_), other = (c.slope(d) - slope_[i]) * d;
    square += other * other;
  }
  return std::sqrt(square);
}

double VoxelStep::begin() {
  multiply(step_, image_, nullptr);
  for (std::size_t i = 0; i < slope_.size(); ++i) {
    const LatticeContact& c = problem_.contacts[i];
    const double d = c.distance(state_->u);
    c.add((slope_[i] - c.slope(d)) * d, image_);
  }
  left_norm_ = std::sqrt(problem_.sum([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      left_[i] = problem_.held[i] != 0 ? 0 : state_->residual[i] - image_[i];
    return inner(left_.data(), left_.data(), begin, end);
  }));
  return left_norm_;
}

Result<VoxelStep::Stop> VoxelStep::conjugate_gradients(double target, double reach) {
  const std::vector<std::uint8_t>& held = problem_.held;
  std::vector<double> parts(problem_.numbering.rows.planes.size() - 1);
  double rho_before = 1;
  const int most = problem_.options.max_iterations + (problem_.laws != nullptr ? iterations_ : 0);
  double least = left_norm_;
  int idle = 0;
  for (bool first = true; left_norm_ > target; first = false) {
    if (iterations_ >= most) return Stop::idle;
    TURGOR_CHECK(context_.check());
    const double rho = precondition();
    if (!(rho > 0)) return Stop::idle;
    const double beta = first ? 0 : rho / rho_before;
    rho_before = rho;
    problem_.for_planes([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        direction_[i] = image_[i] + (first ? 0 : beta * direction_[i]);
    });
    multiply(direction_, image_, &parts);
    double curvature = 0;
    for (const double part : parts) curvature += part;
    if (!(curvature > 0)) return Stop::curved;
    const double alpha = rho / curvature;
    ++iterations_;
    left_norm_ = std::sqrt(problem_.sum([&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        step_[i] += alpha * direction_[i];
        left_[i] = held[i] != 0 ? 0 : left_[i] - alpha * image_[i];
      }
      return inner(left_.data(), left_.data(), begin, end);
    }));
    if (problem_.laws != nullptr && farthest() > reach) return Stop::idle;
    if (!slope_.empty() && mismatch() > left_norm_) return Stop::contacts;
    idle = left_norm_ < 0.5 * least ? 0 : idle + 1;
    if (idle == 0) least = left_norm_;
    if (problem_.laws != nullptr && idle >= kPatience) return Stop::idle;
  }
  return Stop::reached;
}

// The greatest component of the step.
double VoxelStep::farthest() const {
  return problem_.greatest([&](std::size_t begin, std::size_t end) {
    double most = 0;
    for (std::size_t i = begin; i < end; ++i) most = std::max(most, std::abs(step_[i]));
    return most;
  });
}

Result<void> VoxelStep::minimise(double target, double reach) {
  const std::vector<double> start = step_;
  const int before = iterations_;
  for (int touches = 0;;) {
    TURGOR_TRY(const Stop stop, conjugate_gradients(target, reach));
    if (stop == Stop::contacts && touches < kMostTouches) {
      ++touches;
    } else if (stop == Stop::curved && problem_.laws != nullptr && !convex_) {
      convex_ = true;
      problem_.laws->convexify(matrices_);
      step_ = start;
    } else {
      // Downhill is as far as a step goes that finds no minimum from the first (Steihaug 1983).
      for (std::size_t i = 0; stop == Stop::curved && iterations_ == before && i < step_.size(); ++i)
        step_[i] += direction_[i];
      return {};
    }
    TURGOR_CHECK(touch());
    begin();
  }
}

}  // namespace turgor::detail
