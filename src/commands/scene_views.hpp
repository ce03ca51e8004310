// Commands of a scene about worlds, viewports, cameras and lights, and what is written out.
#pragma once

#include "scene_objects.hpp"

namespace turgor::commands {

inline constexpr Parameter kWorld[] = {named("world", "name; a new one is made")};
inline constexpr Example kWorldExamples[] = {{"world closeup", "objects made from now on stand in it"}};
inline constexpr Parameter kPost[] = {kObject, word_flag("world", "NAME", "world; else the current one")};
inline constexpr Example kPostExamples[] = {{"post ball -world closeup", "shown in this world too"}};
inline constexpr Example kUnpostExamples[] = {{"unpost ball -world closeup", "no longer shown in it"}};

inline constexpr std::string_view kStyles[] = {"shaded", "wire"};
inline constexpr Parameter kViewport[] = {
    named("viewport", "name; a new one covers those before it"),
    numbers("at", 4, "LEFT BOTTOM RIGHT TOP",
            "its place on the screen, in fractions from the lower left corner", {}, between(-10, 10)),
    word_flag("camera", "NAME", "a camera object"),
    word_flag("world", "NAME", "the world that it shows"),
    {
        .name = "style",
        .type = ValueType::choice,
        .choices = kStyles,
        .help = "shaded, or edges alone",
    },
    on_off("stereo", "red for the left eye, green for the right one"),
    on_off("mono", "no longer in stereo"),
    {
        .name = "eyes",
        .range = between(0, 0.5),
        .help = "distance of the eyes in stereo, as a fraction of the distance to the target",
    },
    on_off("title", "with a bar that shows its name"),
    on_off("border", "with a border"),
    on_off("plain", "without title and border"),
    on_off("on", "show it"),
    on_off("off", "hide it"),
    on_off("remove", "remove it"),
};
inline constexpr std::string_view kStereo[] = {"stereo", "mono"};
inline constexpr Rule kViewportRules[] = {{Rule::at_most_one, kOnOff}, {Rule::at_most_one, kStereo}};
inline constexpr Example kViewportExamples[] = {
    {"viewport top -at 0.7 0.7 1 1 -camera above -border -title", "a second view in the corner"},
    {"viewport main -stereo", "red and green stereo"}};

inline constexpr Parameter kScreen[] = {
    {
        .name = "size",
        .type = ValueType::integer,
        .range = between(16, 8192),
        .count = {2, 2},
        .label = "WIDTH HEIGHT",
        .help = "of pictures, in pixels",
    },
    numbers("background", 3, "R G B", "colour behind all, 0 to 1", {}, kColour),
};
inline constexpr std::string_view kScreenFlags[] = {"size", "background"};
inline constexpr Rule kScreenRules[] = {{Rule::at_least_one, kScreenFlags}};
inline constexpr Example kScreenExamples[] = {{"screen -size 640 480", "smaller pictures"}};

inline constexpr Parameter kCamera[] = {
    named("camera", "name; a new one is made"),
    numbers("eye", 3, "X Y Z", "where it stands"),
    numbers("look_at", 3, "X Y Z", "what it looks at"),
    numbers("up", 3, "X Y Z", "what is up in the picture", "0 0 1"),
    {
        .name = "fov",
        .range = between(0, 160),
        .help = "vertical opening angle in degrees; 0: orthographic",
    },
    {
        .name = "height",
        .range = above_up_to(0, 1e6),
        .help = "of the picture at the target, where orthographic",
    },
};
inline constexpr Example kCameraExamples[] = {
    {"camera camera -eye 1 -2 1.5 -look_at 0 0 0 -fov 30", "from the front, above"}};
inline constexpr Parameter kLight[] = {
    named("light", "name; a new one is made"),
    numbers("from", 3, "X Y Z", "direction that it comes from", "0.3 -0.5 1"),
    numbers("colour", 3, "R G B", "0 to 1", "1 1 1", kColour),
    number("strength", "1", between(0, 100), "1 lights a white surface fully"),
};
inline constexpr Example kLightExamples[] = {{"light sun -from 1 0 1", "from the right, above"}};

inline constexpr Parameter kPicture[] = {named("name", "of the file, without extension")};
inline constexpr Example kPictureExamples[] = {{"picture closed", "closed.png in the output folder"}};
inline constexpr Example kStateExamples[] = {
    {"state closed", "closed.state and closed.vtu in the output folder"}};
inline constexpr Parameter kRestore[] = {{
    .name = "file",
    .type = ValueType::path,
    .required = true,
    .positional = true,
    .help = "a file that `state` wrote, of a scene built by the same commands",
}};
inline constexpr Example kRestoreExamples[] = {{"restore out/closed.state", "every sample as it was then"}};

inline constexpr Parameter kTopic[] = {{
    .name = "topic",
    .type = ValueType::command,
    .count = {1, 2},
    .positional = true,
    .help = "a command",
}};
inline constexpr Example kHelpSceneExamples[] = {{"help simulate", "what it does, and its flags"}};
inline constexpr Parameter kMenu[] = {{
    .name = "number",
    .type = ValueType::integer,
    .range = between(1, 1000),
    .positional = true,
    .help = "of an entry; it asks for what it needs",
}};
inline constexpr Example kMenuExamples[] = {{"menu", "all commands, numbered"}};
inline constexpr Parameter kRecord[] = {{
    .name = "file",
    .type = ValueType::path,
    .required = true,
    .positional = true,
    .help = "script to write",
}};
inline constexpr Example kRecordExamples[] = {
    {"record session.turgor", "what was done so far, to be run again"}};
inline constexpr Example kQuitExamples[] = {{"quit", "the rest of the script is left out"}};

inline constexpr CommandDeclaration kSceneViewCommands[] = {
    {
        .name = "world",
        .group = "Views",
        .summary = "Choose the world that new objects stand in",
        .parameters = kWorld,
        .examples = kWorldExamples,
    },
    {
        .name = "post",
        .group = "Views",
        .summary = "Show an object in a world",
        .parameters = kPost,
        .examples = kPostExamples,
    },
    {
        .name = "unpost",
        .group = "Views",
        .summary = "Take an object out of a world",
        .parameters = kPost,
        .examples = kUnpostExamples,
    },
    {
        .name = "viewport",
        .group = "Views",
        .summary = "Make or change a viewport",
        .parameters = kViewport,
        .rules = kViewportRules,
        .examples = kViewportExamples,
    },
    {
        .name = "screen",
        .group = "Views",
        .summary = "Set size and background of the screen",
        .parameters = kScreen,
        .rules = kScreenRules,
        .examples = kScreenExamples,
    },
    {
        .name = "camera",
        .group = "Views",
        .summary = "Make or place a camera",
        .description =
            "The camera named 'camera' is there from the start and belongs to the viewport 'main'.",
        .parameters = kCamera,
        .examples = kCameraExamples,
    },
    {
        .name = "light",
        .group = "Views",
        .summary = "Make or place a light",
        .description = "A world without lights is lit as in a studio.",
        .parameters = kLight,
        .examples = kLightExamples,
    },
    {
        .name = "picture",
        .group = "Output",
        .summary = "Write the screen as a picture",
        .parameters = kPicture,
        .examples = kPictureExamples,
    },
    {
        .name = "state",
        .group = "Output",
        .summary = "Write the state of the tissue",
        .description = "Time, places and velocities, exactly, to be restored; and a mesh for ParaView.",
        .parameters = kPicture,
        .examples = kStateExamples,
    },
    {
        .name = "restore",
        .group = "Output",
        .summary = "Restore a state of the tissue",
        .parameters = kRestore,
        .examples = kRestoreExamples,
    },
    {
        .name = "help",
        .group = "Console",
        .summary = "Explain the commands, or one of them",
        .parameters = kTopic,
        .examples = kHelpSceneExamples,
    },
    {
        .name = "menu",
        .group = "Console",
        .summary = "Choose a command by its number",
        .parameters = kMenu,
        .examples = kMenuExamples,
    },
    {
        .name = "record",
        .group = "Console",
        .summary = "Write everything executed so far as a script",
        .description = "Running it gives the same bits.",
        .parameters = kRecord,
        .examples = kRecordExamples,
    },
    {
        .name = "quit",
        .group = "Console",
        .summary = "End the session",
        .examples = kQuitExamples,
    },
};

}  // namespace turgor::commands
