// The program's own sub-commands.
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
constexpr Parameter kThreads{
    .name = "threads",
    .type = ValueType::integer,
    .range = between(0, 1024),
    .fallback = "0",
    .help = "threads to work with; 0 is one per core. The results do not depend on it",
};

constexpr Parameter output(std::string_view help) {
  return {
      .name = "output",
      .alias = "o",
      .type = ValueType::folder,
      .label = "DIR",
      .required = true,
      .help = help,
  };
}

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

constexpr std::string_view kSolvers[] = {"chain", "network"};
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
        .choices = kSolvers,
        .fallback = "chain network",
        .repeatable = true,
        .help = "chain: the mass-spring chain; network: the layered spring network at equilibrium",
    },
    {
        .name = "quality",
        .type = ValueType::choice,
        .choices = kQualities,
        .fallback = "normal",
        .help = "size of surfaces, tissue model and pictures",
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
    {"predict phantom -plan setback.turgor -o result -solver chain -alpha 0.7 -quality draft",
     "a quick look with the chain alone"}};

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

constexpr Parameter kSearch{
    .name = "search",
    .type = ValueType::folder,
    .count = {1, any_number},
    .help = "folders to look through for objects and included scripts",
};
constexpr Parameter kSamples{
    .name = "samples",
    .type = ValueType::integer,
    .range = between(1, 256),
    .fallback = "8",
    .help = "rays a pixel of pictures",
};
constexpr Parameter kRunParameters[] = {
    {
        .name = "script",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "commands of a scene",
    },
    output("folder for pictures, states, recording and result.json"),
    {
        .name = "at",
        .range = between(-1e12, 1e12),
        .count = {1, any_number},
        .label = "TIME...",
        .help = "times of the simulation at which pictures and measures are taken, besides start and end",
    },
    {
        .name = "movie",
        .range = above_up_to(0, 1e9),
        .label = "INTERVAL",
        .help =
            "a frame at every interval of the simulation's time; an MP4 of them where ffmpeg is installed",
    },
    {
        .name = "fps",
        .type = ValueType::integer,
        .range = between(1, 120),
        .fallback = "25",
        .help = "frames a second of the movie",
    },
    {
        .name = "sheet",
        .type = ValueType::flag,
        .help = "all pictures on one sheet too, sheet.png, each under its time",
    },
    {
        .name = "size",
        .type = ValueType::integer,
        .range = between(16, 8192),
        .count = {2, 2},
        .label = "WIDTH HEIGHT",
        .help = "of pictures and movie in pixels, where the script does not say; else 960 by 720",
    },
    kSamples,
    {
        .name = "states",
        .type = ValueType::flag,
        .help = "write the state of the tissue with every picture",
    },
    kSearch,
    kThreads,
};
constexpr Example kRunExamples[] = {
    {"run wound_closure.bolio -o out/wound -at 5 10 40", "pictures at these times"},
    {"run balldrape.bolio -o out/drape -movie 0.5", "with a movie"},
    {"run twitch.bolio -o out/twitch -at 2 5 12 30 -sheet -size 480 360", "small, on one sheet"}};
constexpr Parameter kShellParameters[] = {
    {
        .name = "script",
        .type = ValueType::path,
        .positional = true,
        .help = "commands to begin with",
    },
    {
        .name = "output",
        .alias = "o",
        .type = ValueType::folder,
        .label = "DIR",
        .help = "folder for what `picture` and `state` write; else the working folder",
    },
    {
        .name = "record",
        .type = ValueType::path,
        .help = "script to write at the end that does the same again",
    },
    kSamples,
    kSearch,
    kThreads,
};
constexpr Example kShellExamples[] = {{"shell", "an empty scene"},
                                      {"shell twitch.bolio -record session.turgor", "goes on from a script"}};

constexpr Parameter skin_number(std::string_view name, std::string_view fallback, Range range,
                                std::string_view help) {
  return {
      .name = name,
      .range = range,
      .fallback = fallback,
      .help = help,
  };
}
constexpr Parameter kSkinParameters[] = {
    output("folder for plots, curves as tables, and skin.json"),
    skin_number("lax", "0.7", above_up_to(0, 1e4), "stiffness of elastin, N/cm per strain"),
    skin_number("stiff", "12", between(0, 1e4),
                "stiffness of taut collagen along Langer's lines, N/cm per strain"),
    skin_number("anisotropy", "2", above_up_to(0, 100), "of collagen along over across Langer's lines"),
    skin_number("transition", "0.35", between(0, 5), "strain from which collagen acts along the lines"),
    skin_number("transition_across", "0.55", between(0, 5), "the same across them"),
    {
        .name = "langer",
        .unit = Unit::deg,
        .range = between(-180, 180),
        .fallback = "0",
        .help = "angle between Langer's lines and the strip",
    },
    skin_number("rest_tension", "0", between(0, 100), "tension at strain 0, N/cm"),
    kThreads,
};
constexpr Example kSkinExamples[] = {
    {"skin -o out/skin", "the experiments of figures 2-1 to 2-5"},
    {"skin -o out/tense -rest_tension 0.2 -langer 90", "across the lines, under tension"}};

constexpr std::string_view kFills[] = {"crossings", "winding"};
constexpr Parameter kMeshParameters[] = {
    {
        .name = "surface",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "a surface: PLY, STL, OBJ or OFF, in mm",
    },
    {
        .name = "resolution",
        .type = ValueType::integer,
        .range = between(1, 1024),
        .fallback = "30",
        .help = "voxels along the longest axis",
    },
    {
        .name = "output",
        .alias = "o",
        .type = ValueType::path,
        .label = "FILE",
        .required = true,
        .help =
            "file to write: .ele (TetGen, with .node and .face beside it), .vtu, .msh (Gmsh), .inp (Abaqus, "
            "CalculiX) or .solid (plain binary)",
    },
    {
        .name = "no_border",
        .type = ValueType::flag,
        .help = "only voxels whose centre lies inside, not all that the surface touches",
    },
    {
        .name = "fill",
        .type = ValueType::choice,
        .choices = kFills,
        .fallback = "crossings",
        .help =
            "how inside is told: crossings of the grid lines, for closed surfaces; or the winding number, "
            "which closes any opening but needs triangles that agree on what is outside",
    },
    {
        .name = "hexahedra",
        .type = ValueType::flag,
        .help = "write the cubes instead of five tetrahedra for each",
    },
    kThreads,
};
constexpr Example kMeshExamples[] = {
    {"mesh bunny.ply -resolution 75 -o out/bunny.vtu", "a solid of about half a million tetrahedra"},
    {"mesh skull.stl -resolution 40 -fill winding -hexahedra -o out/skull.inp",
     "an open surface as cubes for CalculiX"}};

constexpr Example kVersionExamples[] = {{"version", "the version of the program and its libraries"}};

constexpr CommandDeclaration kCommands[] = {
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
    {
        .name = "run",
        .group = "Scenes",
        .summary = "Run a script of a scene to its end",
        .description = "Objects, tissue, muscles, sutures and views as commands. Writes pictures, the states "
                       "asked for, a "
                       "recording that gives the same bits when it is run, and result.json.",
        .parameters = kRunParameters,
        .examples = kRunExamples,
    },
    {
        .name = "shell",
        .group = "Scenes",
        .summary = "A console for scenes",
        .description =
            "Commands with completion and history; a command that lacks something asks for it. Ctrl-C ends a "
            "simulation, not the shell.",
        .parameters = kShellParameters,
        .examples = kShellExamples,
    },
    {
        .name = "skin",
        .group = "Scenes",
        .summary = "Pull a strip of skin: load, hysteresis, relaxation, creep, pre-conditioning",
        .description = "The experiments that Pieper (1989) shows in figures 2-1 to 2-5, on a strip of 5 cm "
                       "by 1 cm of the "
                       "program's own skin, as plots and tables.",
        .parameters = kSkinParameters,
        .examples = kSkinExamples,
    },
    {
        .name = "mesh",
        .group = "Solids",
        .summary = "Fill a surface with tetrahedra or cubes",
        .description =
            "Voxels inside the surface, and those it touches, each split into five tetrahedra that share "
            "whole "
            "faces with their neighbours (Morris 2006, section 2). Points and faces of the surface are "
            "marked "
            "in the file. Shells within shells are cavities, what overlaps is joined. Holes of up to one "
            "voxel "
            "or 0.15 of the longest axis are closed; a wider one is an error that says where it is.",
        .parameters = kMeshParameters,
        .examples = kMeshExamples,
    },
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

}  // namespace

const CommandTable& program_commands() {
  static constexpr CommandTable table{
      .name = "program", .title = "Commands of the program", .prefix = "turgor ", .commands = kCommands};
  return table;
}

}  // namespace turgor
