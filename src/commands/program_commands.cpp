// The program's own sub-commands.
#include <algorithm>
#include <array>

#include "problem_parameters.hpp"
#include "program_parameters.hpp"
#include "program_scene.hpp"
#include "solver_parameters.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor {
namespace {

constexpr std::string_view kScanHelp =
    "a DICOM folder or one of its files, NIfTI, NRRD, MetaImage, or an InVesalius .inv3 project";

constexpr Parameter kScan{
    .name = "scan",
    .type = ValueType::path,
    .required = true,
    .positional = true,
    .help = kScanHelp,
};
constexpr Parameter kSeries{
    .name = "series",
    .type = ValueType::text,
    .label = "UID",
    .help = "the DICOM series to read where the folder holds several; the largest CT otherwise",
};
using commands::kThreads;
using commands::output;

constexpr Parameter kInfoParameters[] = {
    kScan,
    kSeries,
    {
        .name = "json",
        .type = ValueType::flag,
        .help = "print JSON instead of text",
    },
};
constexpr Example kInfoExamples[] = {
    {"info scans/patient", "what is in a DICOM folder"},
    {"info Cranium.inv3 -json", "the same of a project, for another program"}};

constexpr Parameter kPhantomParameters[] = {
    output("folder to write the DICOM series, the labels and the thickness map to"),
    {
        .name = "size",
        .range = between(0.7, 1.3),
        .fallback = "1",
        .help = "scale of the whole head",
    },
    {
        .name = "jaw_protrusion",
        .unit = Unit::mm,
        .range = between(-12, 12),
        .fallback = "0",
        .help = "chin and lower teeth forward (above 0, prognathic) or back (below 0, retruded)",
    },
    {
        .name = "thickness",
        .range = between(0.6, 1.6),
        .fallback = "1",
        .help = "scale of the soft tissue's thickness",
    },
    {
        .name = "voxel",
        .unit = Unit::mm,
        .range = between(0.4, 3),
        .fallback = "1",
        .help = "spacing within a slice",
    },
    {
        .name = "slice",
        .unit = Unit::mm,
        .range = between(0.4, 5),
        .fallback = "1",
        .help = "spacing of the slices",
    },
    {
        .name = "noise",
        .unit = Unit::hu,
        .range = between(0, 100),
        .fallback = "12",
        .help = "standard deviation of the noise",
    },
    {
        .name = "blur",
        .unit = Unit::mm,
        .range = between(0, 2),
        .fallback = "0.5",
        .help = "standard deviation of the scanner's point spread",
    },
    {
        .name = "seed",
        .type = ValueType::integer,
        .range = at_least(0),
        .fallback = "1",
        .help = "of the noise; the same seed gives the same bits",
    },
    {
        .name = "no_holder",
        .type = ValueType::flag,
        .help = "leave the head holder out",
    },
    {
        .name = "condyles_touch",
        .type = ValueType::flag,
        .help = "make the joint space narrower than a voxel, as it is in many scans",
    },
};
constexpr Example kPhantomExamples[] = {
    {"phantom -o phantom", "an average head of 1 mm voxels"},
    {"phantom -o prognathic -jaw_protrusion 6 -condyles_touch", "a patient for a mandibular setback"}};

constexpr Parameter kBuildParameters[] = {
    kScan,
    output("folder to write the surfaces, the tissue model, the pictures and the report to"),
    {
        .name = "plan",
        .type = ValueType::path,
        .label = "PLAN",
        .help =
            "a script of plan commands; its corrections of head and tissue are used, its operations left out",
    },
    kSeries,
    kThreads};
constexpr Example kBuildExamples[] = {{"build scans/patient -o head", "surfaces and tissue of a patient"}};

constexpr std::string_view kSolverNames[] = {"chain", "network", "solid", "fem"};
constexpr std::string_view kQualities[] = {"draft", "normal", "fine"};
constexpr Parameter kPredictParameters[] = {
    kScan,
    {
        .name = "plan",
        .type = ValueType::path,
        .label = "PLAN",
        .required = true,
        .help = "a script of plan commands: what is corrected, cut and moved",
    },
    output("folder to write the predicted face, the pictures and report.html to"),
    kSeries,
    {
        .name = "solver",
        .type = ValueType::choice,
        .choices = kSolverNames,
        .fallback = "chain network",
        .repeatable = true,
        .help = "chain: the mass-spring chain; network: the layered spring network at equilibrium; solid: "
                "cubes of "
                "soft tissue as Morris's tetrahedra; fem: the same cubes by a constitutive law; the report "
                "shows the "
                "face of the first of fem, network, solid, chain",
    },
    {
        .name = "quality",
        .type = ValueType::choice,
        .choices = kQualities,
        .fallback = "normal",
        .help = "size of surfaces, tissue model and pictures",
    },
    {
        .name = "constants",
        .type = ValueType::path,
        .label = "FILE",
        .help = "network: calibration.json of `turgor calibrate` on a face: factors of its constants",
    },
    kThreads,
    commands::kAlpha,
    commands::kColumnAlpha,
    commands::kBeta,
    commands::kMaxStretch,
    commands::kMaxCompression,
    commands::kFixedPoints,
    commands::kSemiActivePasses,
    commands::kResidual,
    commands::kMaxSteps,
    commands::kLoadSteps,
    commands::kPoisson,
};
constexpr Example kPredictExamples[] = {
    {"predict scans/patient -plan setback.turgor -o result", "everything, with both solvers"},
    {"predict phantom -plan setback.turgor -o result -solver fem -solver network -solver solid -solver chain",
     "all four solvers, compared with one another"},
    {"predict phantom -plan setback.turgor -o result -solver chain -alpha 0.7 -quality draft",
     "a quick look with the chain alone"}};

constexpr Parameter kCalibrateParameters[] = {
    {
        .name = "problem",
        .type = ValueType::path,
        .label = "PROBLEM",
        .required = true,
        .positional = true,
        .help = "a script of problem commands: body, loads, reference, model, method",
    },
    output("folder to write the calibrated constants, the pictures and report.html to"),
    {
        .name = "method",
        .type = ValueType::choice,
        .choices = commands::kFitMethods,
        .help = "goes before the problem's own, as do all of the following",
    },
    commands::before_problem(commands::kBudget),
    commands::before_problem(commands::kCoarse),
    commands::before_problem(commands::kChains),
    commands::before_problem(commands::kSeed),
    kThreads};
constexpr Example kCalibrateExamples[] = {
    {"calibrate examples/calibration/gear.problem -o out/gear", "a gear, to its finite elements"},
    {"calibrate cube.problem -o out/cube -method annealing -budget 4000", "the method of the paper"}};

constexpr Parameter kHelpParameters[] = {
    {
        .name = "topic",
        .type = ValueType::command,
        .count = {1, 2},
        .label = "COMMAND",
        .positional = true,
        .help = "a command of the program or of a plan, or language for the notation of scripts",
    },
};
constexpr Example kHelpExamples[] = {{"help", "all commands"}, {"help le_fort_1", "one command of a plan"}};

constexpr std::string_view kFormats[] = {"md", "json", "bash", "zsh", "fish"};
constexpr Parameter kCommandsParameters[] = {
    {
        .name = "format",
        .type = ValueType::choice,
        .choices = kFormats,
        .required = true,
        .help =
            "md: the reference as Markdown; json: a JSON Schema; bash, zsh, fish: completion for that shell",
    },
};
constexpr Example kCommandsExamples[] = {
    {"commands -format bash",
     "completion: to be written to ~/.local/share/bash-completion/completions/turgor"},
    {"commands -format json", "the schema, for programs that write plans"}};

constexpr Example kVersionExamples[] = {{"version", "the version of the program and its libraries"}};

constexpr CommandDeclaration kHeadCommands[] = {
    {
        .name = "info",
        .group = "Scans",
        .summary = "Say what a scan holds",
        .description =
            "Lists the series of a folder and, of the one chosen, its size, spacing, orientation in "
            "the patient, "
            "range of Hounsfield numbers and whatever is doubtful about it. Writes nothing.",
        .parameters = kInfoParameters,
        .examples = kInfoExamples,
    },
    {
        .name = "phantom",
        .group = "Scans",
        .summary = "Write a head phantom as a DICOM CT series",
        .description = "A head modelled with smooth implicit shapes, of known truth: its labels and the "
                       "exact thickness of "
                       "its soft tissue are written beside it.",
        .parameters = kPhantomParameters,
        .examples = kPhantomExamples,
    },
    {
        .name = "build",
        .group = "Faces",
        .summary = "Build head and tissue from a scan, without an operation",
        .description = "Finds skin, skull, mandible, teeth, airway and landmarks, builds the layered tissue "
                       "between skin "
                       "and bone, and reports all of it.",
        .parameters = kBuildParameters,
        .examples = kBuildExamples,
    },
    {
        .name = "predict",
        .group = "Faces",
        .summary = "Predict the face after the operation that a plan describes",
        .description = "Builds head and tissue from the scan, runs the plan, and lets the soft tissue follow "
                       "the moved bone. "
                       "A parameter of a solver given here goes before the plan's own.",
        .parameters = kPredictParameters,
        .examples = kPredictExamples,
    },
};

constexpr CommandDeclaration kCalibrateCommands[] = {{
    .name = "calibrate",
    .group = "Calibration",
    .summary = "Fit the constants of an interactive model to finite elements",
    .description =
        "Solves the problem's loads on its reference, and searches for the constants with which the "
        "interactive "
        "model comes to rest in the same places (Morris 2006, section 3). Stopped with Ctrl-C it reports the "
        "best found so far.",
    .parameters = kCalibrateParameters,
    .examples = kCalibrateExamples,
}};

constexpr CommandDeclaration kOwnCommands[] = {
    {
        .name = "help",
        .group = "The program",
        .summary = "Explain the program or one command",
        .parameters = kHelpParameters,
        .examples = kHelpExamples,
    },
    {
        .name = "commands",
        .group = "The program",
        .summary = "Print all commands for programs and shells",
        .parameters = kCommandsParameters,
        .examples = kCommandsExamples,
    },
    {
        .name = "version",
        .group = "The program",
        .summary = "Print the version",
        .examples = kVersionExamples,
    },
};

constexpr auto kCommands = [] {
  using commands::kSceneProgramCommands;
  std::array<CommandDeclaration, std::size(kHeadCommands) + std::size(kSceneProgramCommands) +
                                     std::size(kCalibrateCommands) + std::size(kOwnCommands)>
      all;
  auto next = std::ranges::copy(kHeadCommands, all.begin()).out;
  next = std::ranges::copy(kSceneProgramCommands, next).out;
  next = std::ranges::copy(kCalibrateCommands, next).out;
  std::ranges::copy(kOwnCommands, next);
  return all;
}();

}  // namespace

const CommandTable& program_commands() {
  static constexpr CommandTable table{
      .name = "program", .title = "Commands of the program", .prefix = "turgor ", .commands = kCommands};
  return table;
}

}  // namespace turgor
