#include "world/solve_round.hpp"

#include <fmt/format.h>

namespace turgor {

Result<void> check_usable(Solver solver, const EquilibriumResult& equilibrium, double usable_residual) {
  if (equilibrium.converged || equilibrium.relative_residual < usable_residual) return {};
  const double lower_ratio = solver == Solver::network ? 0.3 : 0.45;
  return Error{ErrorKind::bad_input,
               fmt::format("the tissue found no equilibrium (relative residual {:.1e} after {} steps)",
                           equilibrium.relative_residual, equilibrium.newton_steps),
               std::string(name_of(solver)),
               fmt::format("Move the bones less, or lower Poisson's ratio (solver {} -poisson {:g})",
                           name_of(solver), lower_ratio)};
}

}  // namespace turgor
