#include "turgor/dynamics/equilibrium.hpp"

#include <fmt/format.h>

#include <cmath>

#include "dynamics/equilibrium_detail.hpp"
#include "dynamics/motion_check.hpp"
#include "dynamics/newton.hpp"

namespace turgor {
namespace {

// Before the last load step there is no use in a sharp answer.
constexpr double kIntermediateResidual = 1e-2;

Error bad(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "equilibrium", std::move(remedy)};
}

Result<void> check(const std::vector<Vec3>& start, std::size_t points) {
  if (start.size() != points) {
    return bad(fmt::format("the start has {} positions for {} points", start.size(), points),
               "Give one position per point");
  }
  for (std::size_t i = 0; i < points; ++i) {
    if (!is_within_reach(start[i])) {
      return bad(fmt::format("the start position of point {} is not a finite number of millimetres", i),
                 "Start from rest instead");
    }
  }
  return {};
}

// Where every prescribed point is to end; free points at rest.
std::vector<Vec3> final_positions(const SpringNetwork& network, const PrescribedMotion& motion) {
  std::vector<Vec3> targets = network.rest;
  for (std::size_t i = 0; i < motion.moved.size(); ++i) targets[motion.moved[i]] = motion.positions[i];
  return targets;
}

Error too_large() {
  return bad("the prescribed motion or the loads stretch elements beyond what can be computed",
             "Check the transform that moves the points, and the sizes of the loads");
}

bool acts(const Loads& l) {
  return !l.force_n.empty() || l.gravity_mm_ms2 != Vec3{} || !l.barriers.empty() || !l.grabs.empty();
}

}  // namespace

Result<void> validate(const Loads& loads, std::size_t point_count) {
  if (!loads.force_n.empty() && loads.force_n.size() != point_count) {
    return bad(fmt::format("{} forces are given for {} points", loads.force_n.size(), point_count),
               "Give one for each point, or none");
  }
  for (std::size_t i = 0; i < loads.force_n.size(); ++i) {
    if (!is_finite(loads.force_n[i]))
      return bad(fmt::format("the force on point {} is not finite", i), "Give it in newtons");
  }
  if (!is_finite(loads.gravity_mm_ms2)) return bad("gravity is not finite", "Give an acceleration in mm/ms²");
  TURGOR_CHECK(detail::check_barriers(loads.barriers, point_count));
  for (const Grab& grab : loads.grabs) TURGOR_CHECK(validate(grab, point_count));
  return {};
}

namespace detail {

Result<void> check_options(const EquilibriumOptions& o) {
  if (!(o.relative_residual > 0) || !std::isfinite(o.relative_residual)) {
    return bad(fmt::format("the relative residual asked for is {}", o.relative_residual),
               "It must lie above 0");
  }
  if (o.max_newton_steps < 1) return bad("no Newton steps are allowed", "Allow at least 1");
  if (o.load_steps < 1) return bad("the motion is applied in no load step", "Ask for at least 1");
  return {};
}

EquilibriumResult result_of(const Newton& newton, const NetworkEnergy& energy, EquilibriumState state,
                            const EquilibriumOptions& options, bool converged, Context& context) {
  EquilibriumResult result;
  result.residual_n = newton.largest_free_force(state);
  result.relative_residual = newton.relative_residual(state);
  result.reaction_n = newton.reaction_norm(state);
  result.energy_nmm = state.energy;
  result.newton_steps = newton.steps();
  result.linear_iterations = newton.linear_iterations();
  result.inverted_volumes = energy.inverted_volumes(state.positions);
  result.converged = converged;
  if (!converged) {
    context.warning(fmt::format(
        "no equilibrium after {} Newton steps: the relative residual is {:.1e}, {:.1e} was asked for",
        result.newton_steps, result.relative_residual, options.relative_residual));
  }
  if (const int n = energy.coincident_springs(state.positions); n > 0) {
    context.warning(fmt::format("{} springs have coincident ends and exert no force", n));
  }
  result.positions = std::move(state.positions);
  return result;
}

}  // namespace detail

Result<EquilibriumResult> solve_equilibrium(const SpringNetwork& network, const PrescribedMotion& motion,
                                            const EquilibriumOptions& options, Context& context,
                                            const std::vector<Vec3>* start) {
  return solve_equilibrium(network, motion, Loads{}, options, context, start);
}

Result<EquilibriumResult> solve_equilibrium(const SpringNetwork& network, const PrescribedMotion& motion,
                                            const Loads& loads, const EquilibriumOptions& options,
                                            Context& context, const std::vector<Vec3>* start) {
  const Stage stage(context, "equilibrium");
  TURGOR_CHECK(detail::check_options(options));
  TURGOR_TRY(const NetworkEnergy energy, NetworkEnergy::prepare(network));
  TURGOR_CHECK(validate(motion, energy.point_count()));
  TURGOR_CHECK(validate(loads, network.rest.size()));
  if (start != nullptr) TURGOR_CHECK(check(*start, network.rest.size()));
  Newton newton(energy, cluster_free_points(network, energy, motion, BlockCg::kClusterPoints),
                !network.solids.empty());
  PointTerms terms(network, energy, newton.unknowns());
  terms.set_loads(loads);
  const bool singular = acts(loads) && motion.moved.empty() && motion.fixed.empty();
  newton.restart(acts(loads) ? &terms : nullptr, singular ? Newton::kSingularDamping : 0);
  EquilibriumState state;
  state.positions = start != nullptr ? *start : network.rest;
  if (!newton.evaluate(state)) return too_large();

  const std::vector<Vec3> targets = final_positions(network, motion);
  const std::vector<Vec3> origin = state.positions;
  bool converged = false;
  for (int step = 1; step <= options.load_steps; ++step) {
    const bool last = step == options.load_steps;
    std::vector<Vec3> towards = targets;
    for (std::size_t i = 0; !last && i < towards.size(); ++i) {
      towards[i] = lerp(origin[i], targets[i], static_cast<double>(step) / options.load_steps);
    }
    TURGOR_TRY(const bool finite, newton.predict(state, towards, context));
    if (!finite) return too_large();
    const double tolerance = last ? options.relative_residual : kIntermediateResidual;
    TURGOR_TRY(converged, newton.descend(state, tolerance, options.max_newton_steps, context));
  }
  return detail::result_of(newton, energy, std::move(state), options, converged, context);
}

}  // namespace turgor
