#include <fmt/format.h>

#include <algorithm>

#include "subcommands.hpp"
#include "terminal.hpp"
#include "turgor/commands/plan.hpp"
#include "turgor/commands/problem.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/results.hpp"

namespace turgor {
namespace {

Quality quality_of(const Invocation& arguments) {
  const std::string& word = arguments.word("quality");
  return word == "draft" ? Quality::draft : word == "fine" ? Quality::fine : Quality::normal;
}

// The main one wherever it runs comes first.
std::vector<Solver> solvers_of(const Invocation& arguments) {
  const std::vector<std::string>& asked = arguments.words("solver");
  std::vector<Solver> out;
  for (const Solver solver : {Solver::fem, Solver::network, Solver::solid, Solver::chain})
    if (std::find(asked.begin(), asked.end(), name_of(solver)) != asked.end()) out.push_back(solver);
  return out;
}

void print_summary(const std::vector<Prediction>& predictions, const std::filesystem::path& folder) {
  for (const Prediction& p : predictions) {
    for (const SoftToHard& r : p.ratios) {
      fmt::print("{:<8} {:<18} {:6.2f} mm of {:5.2f} mm ({:.2f})\n", name_of(p.solver), r.soft, r.soft_mm,
                 r.hard_mm, r.ratio());
    }
  }
  fmt::print("report: {}\n", (folder / "report.html").string());
}

// Faults of the plan as a whole are told by its file.
Error named(Error error, const std::filesystem::path& plan) {
  if (error.where == "plan") error.where = plan.string();
  return error;
}

// Single steps on the surfaces of a large scan take longer than a user who wants to stop will wait.
Result<PatientCase> open_case(const Invocation& arguments, const CaseOptions& options, Context& context) {
  const StopAtOnce stop_at_once;
  return PatientCase::open(arguments.path("scan"), options, context);
}

Result<std::vector<Prediction>> predict_all(const Invocation& arguments, const PatientCase& patient,
                                            const SolverOptions& solvers, Context& context) {
  std::vector<Prediction> predictions;
  for (const Solver solver : solvers_of(arguments)) {
    auto prediction = predict(patient, solver, solvers, context);
    if (prediction) {
      predictions.push_back(*std::move(prediction));
    } else if (predictions.empty() || prediction.error().kind == ErrorKind::cancelled) {
      return prediction.error();
    } else {
      // The main solver has answered: the other one is for comparison.
      context.warning(fmt::format("{} gave no usable answer and is left out: {}", name_of(solver),
                                  prediction.error().message()));
    }
  }
  return predictions;
}

}  // namespace

Result<void> run_predict(const Invocation& arguments, const std::string& command_line, Context& context) {
  const std::filesystem::path folder = arguments.path("output"), plan_file = arguments.path("plan");
  TURGOR_TRY(const Plan plan, read_plan(plan_file));
  TURGOR_CHECK(check_output_folder(folder));
  CaseOptions options;
  SolverOptions solvers;
  apply_settings(plan, quality_of(arguments), options, solvers);
  apply_solver_flags(arguments, options, solvers);
  if (arguments.given("constants")) {
    TURGOR_TRY(solvers.factors, read_layer_factors(arguments.path("constants")));
  }
  if (arguments.given("series")) options.scan.series = arguments.word("series");

  auto patient = open_case(arguments, options, context);
  if (!patient) return named(patient.error(), plan_file);
  TURGOR_CHECK(apply_operations(plan, *patient));
  const auto predictions = predict_all(arguments, *patient, solvers, context);
  if (!predictions) return named(predictions.error(), plan_file);
  const CaseResults results{
      *patient, *predictions, {program_version, command_line, plan.name, plan.text(), solvers}};
  TURGOR_CHECK(write_folder(folder, [&](const auto& path) { return write_results(results, path, context); }));
  print_summary(*predictions, folder);
  return {};
}

Result<void> run_build(const Invocation& arguments, const std::string& command_line, Context& context) {
  const std::filesystem::path folder = arguments.path("output");
  Plan plan;
  if (arguments.given("plan")) {
    TURGOR_TRY(plan, read_plan(arguments.path("plan")));
  }
  TURGOR_CHECK(check_output_folder(folder));
  CaseOptions options;
  SolverOptions solvers;
  apply_settings(plan, Quality::normal, options, solvers);
  if (arguments.given("series")) options.scan.series = arguments.word("series");
  const auto patient = open_case(arguments, options, context);
  if (!patient) {
    return arguments.given("plan") ? named(patient.error(), arguments.path("plan")) : patient.error();
  }
  const std::vector<Prediction> none;
  const CaseResults results{*patient, none, {program_version, command_line, plan.name, plan.text(), solvers}};
  TURGOR_CHECK(write_folder(folder, [&](const auto& path) { return write_results(results, path, context); }));
  fmt::print("report: {}\n", (folder / "report.html").string());
  return {};
}

}  // namespace turgor
