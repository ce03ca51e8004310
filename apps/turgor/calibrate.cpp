// turgor calibrate: the constants of an interactive model, fitted to finite elements (Morris 2006, section
// 3).
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>

#include "mpi_farm.hpp"
#include "subcommands.hpp"
#include "terminal.hpp"
#include "turgor/commands/problem.hpp"
#include "turgor/core/file.hpp"
#include "turgor/render/calibration_report.hpp"
#include "turgor/render/face_calibration_report.hpp"

namespace turgor {
namespace {

using Clock = std::chrono::steady_clock;

/// Faults of the problem as a whole are told by its file; those of a command have their place already.
Error placed(Error error, const std::filesystem::path& file) {
  const std::string name = file.string();
  if (error.kind == ErrorKind::cancelled || error.where.starts_with(name)) return error;
  error.where = error.where.empty() ? name : name + ", " + error.where;
  return error;
}

/// How far the search is and the best error so far: a line that is redrawn on a terminal; elsewhere a line
/// whenever the error has fallen by a tenth.
class SearchProgress {
 public:
  explicit SearchProgress(const FitOptions& fit)
      : total_(1 + fit.coarse_samples + fit.budget), unit_(fit.measure == ErrorMeasure::force ? "N" : "mm") {}

  void show(const FitSample& sample) {
    ++count_;
    if (terminal_) {
      if (Clock::now() - drawn_ < std::chrono::milliseconds(80)) return;
      drawn_ = Clock::now();
      fmt::print(stderr, "\r\033[K{}; Ctrl-C stops and keeps it", text(sample.best));
      std::fflush(stderr);
    } else if (std::isfinite(sample.best) && sample.best < 0.9 * told_) {
      told_ = sample.best;
      fmt::print(stderr, "{}\n", text(sample.best));
    }
  }
  void end() const {
    if (terminal_) fmt::print(stderr, "\r\033[K");
  }

 private:
  [[nodiscard]] std::string text(double best) const {
    return fmt::format("Sample {} of at most {}, best error {}", count_, total_,
                       std::isfinite(best) ? fmt::format("{:.4g} {}", best, unit_) : "none yet");
  }

  const bool terminal_ = ::isatty(STDERR_FILENO) != 0;
  int count_ = 0, total_;
  const char* unit_;
  double told_ = std::numeric_limits<double>::infinity();
  Clock::time_point drawn_;
};

Result<Fit> search(const CalibrationProblem& problem, const FitOptions& options, SampleFarm* farm,
                   Context& context) {
  const Stage stage(context, "searching");
  SearchProgress progress(options);
  // Its own progress says more than that of the stages within.
  Context inner(
      {},
      [&](const Notice& n) {
        n.severity == Severity::warning ? context.warning(n.text) : context.notice(n.text);
      },
      [&] { return context.cancelled(); });
  auto fit = calibrate(problem, options, inner, farm,
                       [&](const FitSample& sample, std::span<const double>) { progress.show(sample); });
  progress.end();
  // Asked to stop the search, the program still says what it has found.
  if (fit && fit->stopped) take_stop_request();
  return fit;
}

SampleError sample_error(const CalibrationCase& problem) {
  return make_sample_error(problem.problem(), problem.options().fit.measure);
}

/// The case of a problem file, with what the command line says of the search.
Result<CalibrationCase> prepare(const Invocation& arguments, const Problem& problem, Context& context) {
  const std::filesystem::path file = arguments.path("problem");
  auto options = calibration_options(problem, context);
  if (!options) return placed(options.error(), file);
  apply_search_flags(arguments, options->fit);
  auto prepared = CalibrationCase::prepare(*std::move(options), context);
  if (!prepared) return placed(prepared.error(), file);
  return prepared;
}

/// A process that only works on samples: silent, and nothing of it is written.
Result<void> help_out(const Invocation& arguments, MpiProcesses& processes) {
  Context silent;
  const auto problem = read_problem(arguments.path("problem"));
  // The first process meets the same fault, and tells it; a face it calibrates alone.
  if (!problem || is_face(*problem)) return {};
  const auto prepared = prepare(arguments, *problem, silent);
  if (!prepared) return {};
  return processes.work(sample_error(*prepared));
}

Result<void> calibrate_face(const Invocation& arguments, const Problem& problem,
                            const std::string& command_line, Context& context) {
  const std::filesystem::path file = arguments.path("problem"), folder = arguments.path("output");
  auto read = face_problem(problem, context);
  if (!read) return placed(read.error(), file);
  apply_search_flags(arguments, read->fit);
  auto prepared = face_moves(*read, context);
  if (!prepared) return placed(prepared.error(), file);
  TURGOR_TRY(const FaceFit face, make_face_fit(prepared->moves, read->model));
  auto fit = search(face.problem, read->fit, nullptr, context);
  if (!fit) return placed(fit.error(), file);
  TURGOR_TRY(const FaceOutcome outcome,
             outcome_of(prepared->moves, face, *std::move(fit), prepared->solvers, context));
  const FaceCalibrationResults results{prepared->moves,
                                       face,
                                       read->fit,
                                       outcome,
                                       {program_version, command_line, problem.name, problem.text()}};
  TURGOR_CHECK(
      write_folder(folder, [&](const auto& path) { return write_face_calibration(results, path, context); }));
  for (std::size_t m = 0; m < prepared->moves.size(); ++m) {
    const FaceMove& move = prepared->moves[m];
    const SkinDistance before = lower_third_distance(move, outcome.uncalibrated[m]),
                       after = lower_third_distance(move, outcome.calibrated[m]);
    fmt::print(
        "{:<16} {:<9} mean {:.2f} mm, 95 % {:.2f} mm before; {:.2f} mm, {:.2f} mm after; of {:.2f} mm\n",
        move.name, move.held_out ? "held out" : "fitted", before.mean, before.percentile_95, after.mean,
        after.percentile_95, reference_movement(move).mean);
  }
  fmt::print("report: {}\n", (folder / "report.html").string());
  return {};
}

}  // namespace

Result<void> run_calibrate(const Invocation& arguments, const std::string& command_line, Context& context) {
  TURGOR_TRY(const auto processes, MpiProcesses::join());
  if (processes->rank() > 0) return help_out(arguments, *processes);
  const std::filesystem::path folder = arguments.path("output");
  TURGOR_TRY(const Problem problem, read_problem(arguments.path("problem")));
  TURGOR_CHECK(check_output_folder(folder));
  if (is_face(problem)) return calibrate_face(arguments, problem, command_line, context);
  TURGOR_TRY(const CalibrationCase prepared, prepare(arguments, problem, context));
  const auto farm = processes->count() > 1 ? processes->make_farm(sample_error(prepared)) : nullptr;
  auto fit = search(prepared.problem(), prepared.options().fit, farm.get(), context);
  if (!fit) return placed(fit.error(), arguments.path("problem"));
  TURGOR_TRY(const CalibrationOutcome outcome, outcome_of(prepared, *std::move(fit), context));
  const CalibrationResults results{
      prepared, outcome, {program_version, command_line, problem.name, problem.text()}};
  TURGOR_CHECK(
      write_folder(folder, [&](const auto& path) { return write_calibration(results, path, context); }));
  fmt::print("{}", calibration_summary(results));
  if (outcome.fit.stopped) fmt::print("stopped on request: this is the best found until then\n");
  fmt::print("report: {}\n", (folder / "report.html").string());
  return {};
}

}  // namespace turgor
