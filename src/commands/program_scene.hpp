// The program's commands about scenes, skin and solids.
#pragma once

#include "program_parameters.hpp"
#include "scene_parameters.hpp"

namespace turgor::commands {

inline constexpr Parameter kSearch{
    .name = "search",
    .type = ValueType::folder,
    .count = {1, any_number},
    .help = "folders to look through for objects and included scripts",
};
inline constexpr Parameter kSamples{
    .name = "samples",
    .type = ValueType::integer,
    .range = between(1, 256),
    .fallback = "8",
    .help = "rays a pixel of pictures",
};
inline constexpr Parameter kRunParameters[] = {
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
inline constexpr Example kRunExamples[] = {
    {"run wound_closure.bolio -o out/wound -at 5 10 40", "pictures at these times"},
    {"run balldrape.bolio -o out/drape -movie 0.5", "with a movie"},
    {"run twitch.bolio -o out/twitch -at 2 5 12 30 -sheet -size 480 360", "small, on one sheet"}};
inline constexpr Parameter kShellParameters[] = {
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
inline constexpr Example kShellExamples[] = {
    {"shell", "an empty scene"}, {"shell twitch.bolio -record session.turgor", "goes on from a script"}};

inline constexpr Parameter kSkinParameters[] = {
    output("folder for plots, curves as tables, and skin.json"),
    number("lax", "0.7", above_up_to(0, 1e4), "stiffness of elastin, N/cm per strain"),
    number("stiff", "12", between(0, 1e4),
           "stiffness of taut collagen along Langer's lines, N/cm per strain"),
    number("anisotropy", "2", above_up_to(0, 100), "of collagen along over across Langer's lines"),
    number("transition", "0.35", between(0, 5), "strain from which collagen acts along the lines"),
    number("transition_across", "0.55", between(0, 5), "the same across them"),
    {
        .name = "langer",
        .unit = Unit::deg,
        .range = between(-180, 180),
        .fallback = "0",
        .help = "angle between Langer's lines and the strip",
    },
    number("rest_tension", "0", between(0, 100), "tension at strain 0, N/cm"),
    kThreads,
};
inline constexpr Example kSkinExamples[] = {
    {"skin -o out/skin", "the experiments of figures 2-1 to 2-5"},
    {"skin -o out/tense -rest_tension 0.2 -langer 90", "across the lines, under tension"}};

inline constexpr std::string_view kFills[] = {"crossings", "winding"};
inline constexpr Parameter kMeshParameters[] = {
    {
        .name = "surface",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "a surface in mm: PLY, STL, OBJ, OFF, VTK (.vtk, .vtp, the surface cells of .vtu) or glTF "
                "(.glb, .gltf; in metres); with -label, -above or -below a scan",
    },
    {
        .name = "resolution",
        .type = ValueType::integer,
        .range = between(1, 1024),
        .fallback = "30",
        .help = "voxels along the longest axis; of a scan its own smallest spacing is the fallback",
    },
    {
        .name = "label",
        .type = ValueType::integer,
        .range = between(-32768, 32767),
        .count = {1, any_number},
        .help = "of a label map in NIfTI, NRRD or MetaImage: mesh the voxels that have one of these labels",
    },
    {
        .name = "above",
        .type = ValueType::integer,
        .unit = Unit::hu,
        .range = between(-32768, 32767),
        .help = "of a scan: mesh where the interpolated value is at least this",
    },
    {
        .name = "below",
        .type = ValueType::integer,
        .unit = Unit::hu,
        .range = between(-32768, 32767),
        .help = "of a scan: mesh where the interpolated value is at most this",
    },
    {
        .name = "spacing",
        .unit = Unit::mm,
        .range = above_up_to(0, 1000),
        .help = "edge of a voxel of a scan's part, instead of -resolution",
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
    {
        .name = "graded",
        .type = ValueType::integer,
        .range = between(1, 4),
        .label = "LEVELS",
        .help = "coarser within, over so many doublings of the size; voxels of -resolution along the surface",
    },
    {
        .name = "smooth",
        .unit = Unit::deg,
        .range = between(0, 90),
        .fallback = "0",
        .help =
            "with -graded: coarse along the surface too where it faces within this angle of one direction, "
            "which grows it there by up to a coarse cell",
    },
    {
        .name = "fine",
        .type = ValueType::box,
        .repeatable = true,
        .help = "with -graded: voxels of -resolution throughout this box",
    },
    {
        .name = "leak_picture",
        .type = ValueType::path,
        .label = "PNG",
        .help = "picture of where a surface leaks, drawn when it is too open to be meshed",
    },
    kThreads,
};
inline constexpr Example kMeshExamples[] = {
    {"mesh bunny.ply -resolution 75 -o out/bunny.vtu", "a solid of about half a million tetrahedra"},
    {"mesh skull.stl -resolution 40 -fill winding -hexahedra -o out/skull.inp",
     "an open surface as cubes for CalculiX"},
    {"mesh labels.nii.gz -label 3 4 -spacing 1.5 -o out/tongue.vtu", "two labels of a segmentation together"},
    {"mesh head -above 300 -resolution 120 -o out/bone.msh", "bone of a CT"},
    {"mesh liver.glb -resolution 80 -graded 3 -fine 0 0 0 20 20 20 -o out/liver.vtu",
     "fine along the surface and in a box, coarse within"}};
inline constexpr std::string_view kMeshPart[] = {"label", "above"};
inline constexpr std::string_view kMeshLabel[] = {"label", "below"};
inline constexpr std::string_view kMeshSize[] = {"resolution", "spacing"};
inline constexpr std::string_view kMeshCells[] = {"hexahedra", "graded"};
inline constexpr Rule kMeshRules[] = {{Rule::at_most_one, kMeshPart},
                                      {Rule::at_most_one, kMeshLabel},
                                      {Rule::at_most_one, kMeshSize},
                                      {Rule::at_most_one, kMeshCells}};

inline constexpr CommandDeclaration kSceneProgramCommands[] = {
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
        .summary = "Fill a surface, or a part of a scan, with tetrahedra or cubes",
        .description =
            "Voxels inside the surface, and those it touches, each split into five tetrahedra that share "
            "whole "
            "faces with their neighbours (Morris 2006, section 2). Points and faces of the surface are "
            "marked "
            "in the file. Shells within shells are cavities, what overlaps is joined. Holes of up to one "
            "voxel "
            "or 0.15 of the longest axis are closed; a wider one is an error that says where it is. Labels "
            "and "
            "thresholds of a scan are resampled to cubes along the patient's axes.",
        .parameters = kMeshParameters,
        .rules = kMeshRules,
        .examples = kMeshExamples,
    },
};

}  // namespace turgor::commands
