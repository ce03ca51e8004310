// A surgical plan: its commands carried out on a patient.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/commands/script.hpp"
#include "turgor/core/error.hpp"
#include "turgor/world/patient_case.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

/// Size of surfaces and tissue model.
enum class Quality : std::uint8_t { draft, normal, fine };

/// A plan read and checked. Settings (head, tissue, solvers) hold for the whole run wherever they stand;
/// operations are carried out in order.
struct Plan {
  std::string name;  ///< file name; empty: no plan
  std::vector<Invocation> commands;

  /// The commands, one a line, in canonical form.
  [[nodiscard]] std::string text() const;
};
Result<Plan> read_plan(const std::filesystem::path& path);

/// What the plan's settings make of the defaults.
void apply_settings(const Plan& plan, Quality quality, CaseOptions& options, SolverOptions& solvers);
/// Solver parameters given on the command line go before the plan's. `program` is an invocation of predict.
void apply_solver_flags(const Invocation& program, CaseOptions& options, SolverOptions& solvers);

/// Carries out the operations in order. Errors carry file, line and column of the command.
Result<void> apply_operations(const Plan& plan, PatientCase& patient);

}  // namespace turgor
