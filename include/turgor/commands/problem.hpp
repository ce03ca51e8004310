// A problem of calibration: its commands, read into what world/calibration_case.hpp takes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turgor/commands/plan.hpp"
#include "turgor/commands/script.hpp"
#include "turgor/core/context.hpp"
#include "turgor/core/error.hpp"
#include "turgor/world/calibration_case.hpp"
#include "turgor/world/face_fit.hpp"

namespace turgor {

/// A problem read and checked by its declarations. Loads take the forces that follow them; of settings the
/// last one counts; else the order does not matter.
struct Problem {
  std::string name;  ///< file name
  std::vector<Invocation> commands;

  /// The commands, one a line, in canonical form.
  [[nodiscard]] std::string text() const;
};
Result<Problem> read_problem(const std::filesystem::path& path);

/// Reads the surface that the problem names. Errors carry file, line and column: no body or two; no
/// reference; two loads of one name; a force before any load; a surface that cannot be read.
Result<CalibrationOptions> calibration_options(const Problem& problem, Context& context);

/// A face and moves of its bones, to which its layered network is fitted.
struct FaceProblem {
  struct Load {
    std::string name;
    bool held_out = false;
    Plan plan;
    std::string where;  ///< of its declaration
  };
  std::filesystem::path scan;
  Quality quality = Quality::normal;
  std::vector<Load> loads;
  std::optional<ElasticMaterial> reference;  ///< else that of the plans
  FaceFitOptions model;
  FitOptions fit;
};
/// Whether the body is a face; else calibration_options() are the problem's.
bool is_face(const Problem& problem);
/// Errors carry file, line and column: no load, or one without a plan; a plan that cannot be read; a command
/// that a face does not know.
Result<FaceProblem> face_problem(const Problem& problem, Context& context);

/// The moves and the references, in the order of the loads, and the options of all predictions.
struct FaceMoves {
  std::vector<FaceMove> moves;
  SolverOptions solvers;
};
/// Errors: those of opening the patient, carrying out the plans and predicting; no load that is fitted.
Result<FaceMoves> face_moves(const FaceProblem& problem, Context& context);

/// What a calibration of a face has left in its calibration.json. Errors: a file that is not one.
Result<LayerFactors> read_layer_factors(const std::filesystem::path& path);

/// Flags of the search given on the command line go before the problem's. `program` is an invocation of
/// calibrate.
void apply_search_flags(const Invocation& program, FitOptions& fit);

}  // namespace turgor
