// Commands of a scene that make and change objects.
#pragma once

#include "scene_parameters.hpp"

namespace turgor::commands {

inline constexpr Parameter kObject = named("object", "name of an object");

inline constexpr Parameter kInstanceObject[] = {
    {
        .name = "file",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "object file (.object), mesh file, or primitive: grid.N.M, wiregrid.N.M, sphere, cube, line, "
                "fusiform",
    },
    named("name", "name of the new object; else the last part of the file's name", false),
};
inline constexpr Example kInstanceObjectExamples[] = {
    {"instance_object grid.10.10 sheet", "a sheet of 10 by 10 points"},
    {"instance_object skull.ply", "a surface from a file"}};
inline constexpr Parameter kSaveObject[] = {
    kObject,
    {
        .name = "file",
        .type = ValueType::path,
        .required = true,
        .positional = true,
        .help = "object file to write",
    },
};
inline constexpr Example kSaveObjectExamples[] = {
    {"save_object ball ball.object", "to be read by instance_object"}};

inline constexpr Parameter kEditXform[] = {
    kObject,
    numbers("t", 3, "X Y Z", "translation"),
    numbers("r", 3, "X Y Z", "rotation about x, then y, then z, degrees"),
    numbers("s", 3, "X Y Z", "scale along the object's own axes"),
    numbers("origin", 3, "X Y Z", "local origin, about which it is rotated and scaled"),
    on_off("relative", "change the present transform instead of replacing it"),
};
inline constexpr Example kEditXformExamples[] = {
    {"edit_xform floor -t 0 0 -0.25 -s 4 4 1", "below, and four times as wide"}};
inline constexpr Parameter kObjectOnly[] = {kObject};
inline constexpr Example kHardenExamples[] = {
    {"harden sheet", "its vertices take the transform, which becomes none"}};

inline constexpr Parameter kColours[] = {
    kObject,
    on_off("faceted", "shade each polygon flat"),
    on_off("smooth", "shade across polygons"),
    on_off("curved", "draw the smooth surface that the polygons approximate"),
    on_off("flat", "draw the polygons themselves, not a curved surface"),
    numbers("diff", 3, "R G B", "diffuse colour, 0 to 1", {}, kColour),
    numbers("high", 3, "R G B", "colour of the highlight, 0 to 1", {}, kColour),
    {
        .name = "spec",
        .range = between(0, 10000),
        .help = "exponent of the highlight: the larger, the smaller the highlight",
    },
    numbers("wire", 3, "R G B", "draw the edges too, in this colour", {}, kColour),
    on_off("no_wire", "draw no edges"),
    {
        .name = "line_width",
        .range = above_up_to(0, 100),
        .help = "thickness of lines and edges, times the usual one",
    },
    {
        .name = "opacity",
        .range = between(0, 1),
        .help = "0 is invisible, 1 solid",
    },
};
inline constexpr std::string_view kShadings[] = {"faceted", "smooth"};
inline constexpr std::string_view kCurves[] = {"curved", "flat"};
inline constexpr std::string_view kWires[] = {"wire", "no_wire"};
inline constexpr Rule kColoursRules[] = {
    {Rule::at_most_one, kShadings}, {Rule::at_most_one, kCurves}, {Rule::at_most_one, kWires}};
inline constexpr Example kColoursExamples[] = {
    {"colors ball -smooth -wire .05 .05 .05", "with its edges in dark grey"}};

inline constexpr Parameter kVisible[] = {kObject, on_off("on", "show it"), on_off("off", "hide it")};
inline constexpr std::string_view kOnOff[] = {"on", "off"};
inline constexpr Rule kVisibleRules[] = {{Rule::at_most_one, kOnOff}};
inline constexpr Example kVisibleExamples[] = {{"visible sheet -off", "hide it"},
                                               {"visible sheet", "the other way round"}};
inline constexpr Example kTriangulateExamples[] = {
    {"triangulate skin.face.sheet", "its polygons are drawn as triangles"}};
inline constexpr Example kDeleteExamples[] = {{"delete_object ball", "with what depends on it"}};
inline constexpr std::string_view kListed[] = {"objects", "constraints", "worlds", "viewports",
                                               "tissue",  "muscles",     "grabs"};
inline constexpr Parameter kList[] = {{
    .name = "what",
    .type = ValueType::choice,
    .choices = kListed,
    .fallback = "objects",
    .positional = true,
    .help = "what to list",
}};
inline constexpr Example kListExamples[] = {{"list tissue", "samples, springs and measures of every flesh"}};

inline constexpr CommandDeclaration kSceneObjectCommands[] = {
    {
        .name = "instance_object",
        .group = "Objects",
        .summary = "Put an object from a file or a primitive into the world",
        .description =
            "Looks for the file, then along the search paths, last in the program's own library; says where "
            "it was found where that is not the place named.",
        .parameters = kInstanceObject,
        .examples = kInstanceObjectExamples,
    },
    {
        .name = "save_object",
        .group = "Objects",
        .summary = "Write an object to an object file",
        .parameters = kSaveObject,
        .examples = kSaveObjectExamples,
    },
    {
        .name = "edit_xform",
        .group = "Objects",
        .summary = "Place, turn and scale an object",
        .description = "The object is scaled, then turned, about its local origin, then moved.",
        .parameters = kEditXform,
        .examples = kEditXformExamples,
    },
    {
        .name = "harden",
        .group = "Objects",
        .summary = "Apply an object's transform to its vertices",
        .parameters = kObjectOnly,
        .examples = kHardenExamples,
    },
    {
        .name = "colors",
        .group = "Objects",
        .summary = "Set how an object looks",
        .parameters = kColours,
        .rules = kColoursRules,
        .examples = kColoursExamples,
    },
    {
        .name = "visible",
        .group = "Objects",
        .summary = "Show or hide an object",
        .description = "Without -on or -off it changes from one to the other.",
        .parameters = kVisible,
        .rules = kVisibleRules,
        .examples = kVisibleExamples,
    },
    {
        .name = "triangulate",
        .group = "Objects",
        .summary = "Draw an object's polygons as triangles",
        .parameters = kObjectOnly,
        .examples = kTriangulateExamples,
    },
    {
        .name = "delete_object",
        .group = "Objects",
        .summary = "Take an object out of all worlds",
        .parameters = kObjectOnly,
        .examples = kDeleteExamples,
    },
    {
        .name = "list",
        .group = "Objects",
        .summary = "List what the scene holds",
        .parameters = kList,
        .examples = kListExamples,
    },
};

}  // namespace turgor::commands
