#include "fem/voxel_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace turgor::detail {
namespace {

// Of a linear system: steps anew from the true residual, where rounding has made that of the iteration too
// small.
constexpr int kMostRestarts = 5;
constexpr int kMostHalvings = 30;
// Wolfe's conditions.
constexpr double kDecrease = 1e-4, kFlatter = 0.9;
// Of the residual: left by the prediction of a load step, and by Newton's method between load steps.
constexpr double kPrediction = 1e-2, kBetween = 0.02;
// Forces out of balance after a prediction, relative to those that it takes: beyond that it is too far.
constexpr double kMostCurved = 6;
constexpr double kLeastPart = 1.0 / 1024;

}  // namespace

VoxelSolver::VoxelSolver(const VoxelProblem& problem, std::vector<double> force, Context& context)
    : problem_(problem), force_(std::move(force)), context_(context), step_(problem, context) {
  const std::size_t n = problem.numbering.rows.values();
  for (VoxelState* s : {&state_, &trial_}) s->u.resize(n), s->internal.resize(n), s->residual.resize(n);
}

void VoxelSolver::evaluate(VoxelState& s) const {
  const std::vector<std::uint8_t>& held = problem_.held;
  VoxelLaws::Energy large;
  if (problem_.laws != nullptr)
    large = problem_.laws->forces(s.u.data(), s.internal.data());
  else
    problem_.stiffness->apply(s.u.data(), s.internal.data(), [](std::size_t, std::size_t, std::size_t) {});
  struct Sums {
    double strain = 0, work = 0, contact = 0, residual = 0, reference = 0;
  };
  const auto& planes = problem_.numbering.rows.planes;
  const Sums sums = parallel_reduce<Sums>(
      planes.size() - 1, static_cast<std::size_t>(problem_.numbering.rows.slab), {},
      [&](std::size_t first, std::size_t last) {
        const std::size_t begin = planes[first], end = planes[last];
        Sums out;
        for (std::size_t i = begin; i < end; ++i) {
          s.residual[i] = held[i] != 0 ? 0 : force_[i] - s.internal[i];
          const double reaction = held[i] != 0 ? force_[i] - s.internal[i] : 0;
          out.reference += force_[i] * force_[i] + reaction * reaction;
        }
        for (const LatticeContact& c : problem_.contacts_in(begin, end)) {
          const double d = c.distance(s.u), push = -c.slope(d) * d;
          out.contact -= 0.5 * push * d, out.reference += push * push;
          for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t i = c.node.component(a);
            if (held[i] == 0) s.residual[i] += push * c.normal[static_cast<int>(a)];
          }
        }
        out.strain = 0.5 * inner(s.u.data(), s.internal.data(), begin, end);
        out.work = inner(s.u.data(), force_.data(), begin, end);
        out.residual = inner(s.residual.data(), s.residual.data(), begin, end);
        return out;
      },
      [](const Sums& a, const Sums& b) {
        return Sums{a.strain + b.strain, a.work + b.work, a.contact + b.contact, a.residual + b.residual,
                    a.reference + b.reference};
      });
  s.inverted = large.inverted;
  s.strain_energy = problem_.laws != nullptr ? large.strain : sums.strain;
  if (!std::isfinite(s.strain_energy + sums.residual)) s.inverted = std::max<std::size_t>(s.inverted, 1);
  s.potential = s.strain_energy + sums.contact - sums.work;
  s.norm = std::sqrt(sums.residual), s.reference = std::sqrt(sums.reference);
}

// What rounding of the displacements alone leaves of a residual.
double VoxelSolver::rounding() const {
  if (!step_.has_cycle()) return 0;
  const std::vector<float>& scaling = step_.finest().scaling;
  const std::vector<double>& u = state_.u;
  const double unit = problem_.unit();
  double contacts = 0;
  for (const LatticeContact& c : problem_.contacts) {
    double size = std::abs(c.offset_mm);
    for (std::size_t a = 0; a < 3; ++a) size += std::abs(u[c.node.component(a)]);
    const double force = c.slope(c.distance(u)) * size;
    contacts += force * force;
  }
  return 2 * std::numeric_limits<double>::epsilon() *
         std::sqrt(contacts + unit * unit * problem_.sum([&](std::size_t begin, std::size_t end) {
           double square = 0;
           for (std::size_t i = begin; i < end; ++i) {
             const double force = scaling[i] != 0 ? u[i] / static_cast<double>(scaling[i]) : 0;
             square += force * force;
           }
           return square;
         }));
}

void VoxelSolver::move_to(double t) {
  const std::vector<double>& step = step_.step();
  problem_.for_planes([&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) trial_.u[i] = state_.u[i] + t * step[i];
  });
  evaluate(trial_);
  turned_over_ = std::max(turned_over_, trial_.inverted);
}

// Along the step to where the energy has fallen enough (Wolfe's conditions; by the slope alone where rounding
// hides the energy). False: it does not fall.
bool VoxelSolver::line_search() {
  const auto slope_at = [&](const VoxelState& s) {
    return -problem_.sum([&](std::size_t begin, std::size_t end) {
      return inner(s.residual.data(), step_.step().data(), begin, end);
    });
  };
  const double downhill = slope_at(state_);
  if (!(downhill < 0)) return false;
  const double noise = 1e-13 * (std::abs(state_.potential) + state_.strain_energy);
  double t = 1;
  for (int halving = 0; halving < kMostHalvings; ++halving) {
    move_to(t);
    if (trial_.inverted > 0) {
      t *= 0.5;
      continue;
    }
    const double slope = slope_at(trial_);
    const bool falls = trial_.potential <= state_.potential + kDecrease * t * downhill;
    const bool flat = trial_.potential <= state_.potential + noise && std::abs(slope) <= -kFlatter * downhill;
    if (falls || flat) {
      std::swap(state_, trial_);
      return true;
    }
    const double by_slope = slope > 0 ? downhill / (downhill - slope) : 0.5;
    t *= std::clamp(by_slope, 0.1, 0.5);
  }
  return false;
}

// How much of the residual a step may leave: the less, the better the last one did (Eisenstat and Walker
// 1996), and no less than is asked for at the end.
double VoxelSolver::forcing() const {
  if (problem_.laws == nullptr) return is_linear() ? target_ : 0.7 * target_;
  const double ratio = norm_before_ > 0 ? state_.norm / norm_before_ : 1;
  return std::max(0.5 * target_, std::clamp(0.9 * ratio * ratio, 1e-3, 0.1) * state_.norm);
}

// Newton's method, until the residual is as small as asked for; false where it does not fall so far.
Result<bool> VoxelSolver::correct(double relative) {
  const bool linear = is_linear();
  const int most = linear ? kMostRestarts : problem_.options.newton.max_newton_steps;
  const auto set_target = [&] {
    target_ = std::max(relative * (linear ? whole_ : std::max(whole_, state_.reference)), rounding());
  };
  if (!linear) set_target();
  norm_before_ = 0;
  bool falls = true;
  for (int step = 0; falls && state_.norm > target_ && (linear ? step : newton_steps_) < most; ++step) {
    if (problem_.laws == nullptr && step_.iterations() >= problem_.options.max_iterations) break;
    TURGOR_CHECK(step_.linearise(state_));
    TURGOR_CHECK(step_.minimise(forcing(), problem_.spacing));
    norm_before_ = state_.norm;
    if (linear) {
      move_to(1);
      std::swap(state_, trial_);
    } else {
      ++newton_steps_;
      falls = line_search();
    }
    set_target();
  }
  return state_.norm <= target_;
}

Result<ElasticSolution> VoxelSolver::solve(const std::vector<double>& start) {
  if (problem_.laws != nullptr) return solve_large(start);
  state_.u = problem_.prescribed;
  evaluate(state_);
  whole_ = std::sqrt(problem_.sum([&](std::size_t begin, std::size_t end) {
    double square = 0;  // of the residual without contacts
    for (std::size_t i = begin; i < end; ++i) {
      const double r = problem_.held[i] != 0 ? 0 : force_[i] - state_.internal[i];
      square += r * r;
    }
    return square;
  }));
  target_ = problem_.options.relative_residual * whole_;
  if (!start.empty() && (whole_ > 0 || !problem_.contacts.empty())) {
    for (std::size_t i = 0; i < start.size(); ++i)
      state_.u[i] = problem_.held[i] != 0 ? problem_.prescribed[i] : start[i];
    evaluate(state_);
  }
  const bool far = state_.norm > problem_.options.relative_residual * std::max(whole_, state_.reference);
  if (far) TURGOR_CHECK(step_.meet(state_));
  TURGOR_CHECK(correct(problem_.options.relative_residual));
  const ElasticSolution out = solution();
  if (!out.converged) {
    context_.warning(fmt::format("elasticity: relative residual {:.2g} after {} iterations, {:.2g} asked for",
                                 out.relative_residual, out.iterations, problem_.options.relative_residual));
  }
  return out;
}

// Moves what is held by a part of what it has yet to go, and the rest as the present stiffness has it follow;
// returns the part of the part that no cube is turned over by.
Result<double> VoxelSolver::predict(double part) {
  bool moves = false;
  for (std::size_t i = 0; i < problem_.held.size() && !moves; ++i)
    moves = problem_.held[i] != 0 && problem_.prescribed[i] != state_.u[i];
  if (!moves) return 1;
  TURGOR_CHECK(step_.linearise(state_));
  std::vector<double>& step = step_.step();
  for (std::size_t i = 0; i < step.size(); ++i)
    if (problem_.held[i] != 0) step[i] = part * (problem_.prescribed[i] - state_.u[i]);
  TURGOR_CHECK(step_.minimise(kPrediction * step_.begin(), std::numeric_limits<double>::infinity()));
  std::vector<double> bent(step.size());
  step_.bend(bent);
  const double forces = std::sqrt(problem_.sum([&](std::size_t begin, std::size_t end) {
    double square = 0;
    for (std::size_t i = begin; i < end; ++i) square += problem_.held[i] != 0 ? bent[i] * bent[i] : 0;
    return square;
  }));
  for (double t = 1; t > kLeastPart; t *= 0.5) {
    move_to(t);
    if (trial_.inverted > 0 || trial_.norm - state_.norm > kMostCurved * t * forces) continue;
    std::swap(state_, trial_);
    return t;
  }
  return 0;
}

// Load steps, each of a prediction and Newton's method, as large as converges.
Result<ElasticSolution> VoxelSolver::solve_large(const std::vector<double>& start) {
  const double relative = problem_.options.relative_residual;
  const std::vector<double> whole = force_;
  bool from_rest = start.empty();
  if (!from_rest) {
    state_.u = start;
    evaluate(state_);
    from_rest = state_.inverted > 0;
    if (from_rest) std::fill(state_.u.begin(), state_.u.end(), 0.0);
  }
  TURGOR_CHECK(step_.meet(state_));
  const auto apply_load = [&](double load) {
    for (std::size_t i = 0; i < whole.size(); ++i) force_[i] = (from_rest ? load : 1) * whole[i];
    evaluate(state_);
  };
  double done = 0, part = 1.0 / problem_.options.newton.load_steps;
  while (done < 1) {
    part = std::min(part, 1 - done);
    const std::vector<double> before = state_.u;
    apply_load(done + part);
    TURGOR_TRY(const double moved, predict(part / (1 - done)));
    part *= moved;
    if (moved > 0) {
      if (moved < 1) apply_load(done + part);
      const bool last = done + part > 1 - 1e-9;
      TURGOR_TRY(const bool good, correct(last ? relative : std::max(relative, kBetween)));
      if (good) {
        done = last ? 1 : done + part;
        continue;
      }
      if (newton_steps_ >= problem_.options.newton.max_newton_steps || part * 0.5 < kLeastPart) break;
      state_.u = before;
      part *= 0.5;
    }
    context_.progress(done);
    if (part < kLeastPart) break;
  }
  ElasticSolution out = solution();
  out.converged = done == 1;
  if (!out.converged) {
    context_.warning(fmt::format(
        "elasticity: relative residual {:.2g} after {} Newton steps, {:.2g} asked for, with {:.1f} % of the "
        "load applied; {} cubes turned over on the way",
        out.relative_residual, newton_steps_, relative, 100 * done, turned_over_));
  }
  return out;
}

ElasticSolution VoxelSolver::solution() const {
  ElasticSolution out;
  out.displacement_mm = problem_.numbering.gather(state_.u);
  out.iterations = step_.iterations(), out.newton_steps = newton_steps_;
  const double whole = is_linear() ? whole_ : std::max(whole_, state_.reference);
  out.relative_residual = whole > 0 ? state_.norm / whole : 0;
  out.converged = state_.norm <= target_;
  out.strain_energy_nmm = state_.strain_energy;
  std::vector<double> reaction(state_.u.size(), 0);
  for (const LatticeContact& c : problem_.contacts) {
    const double d = c.distance(state_.u);
    c.add(-c.slope(d) * d, reaction);
  }
  for (std::size_t i = 0; i < reaction.size(); ++i)
    if (problem_.held[i] != 0) reaction[i] = state_.internal[i] - force_[i];
  out.reaction_n = problem_.numbering.gather(reaction);
  return out;
}

}  // namespace turgor::detail
