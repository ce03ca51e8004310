// Commands of a scene that bind things to each other, and to devices.
#pragma once

#include "scene_objects.hpp"

namespace turgor::commands {

inline constexpr Parameter kLink[] = {
    named("link", "the object that is stretched"),
    named("from", "object at its one end"),
    named("to", "object at its other end"),
    on_off("volume", "keep the link's volume: it thins as it lengthens"),
};
inline constexpr Example kLinkExamples[] = {
    {"link rod ball cube -volume", "a rubber band between two objects"}};
inline constexpr Parameter kParent[] = {named("child", "object that is taken along"),
                                        named("parent", "object that it follows")};
inline constexpr Example kParentExamples[] = {
    {"parent hand arm", "the hand keeps its place relative to the arm"}};
inline constexpr Example kStandInExamples[] = {{"stand_in skull", "its bounding box is drawn instead"}};

inline constexpr Parameter kPath = named("path", "object whose points are the path");
inline constexpr Parameter kFrames =
    whole("frames", "100", between(1, 1000000), "from the first point to the last");
inline constexpr Parameter kLoop = on_off("loop", "start again at the end");
inline constexpr Parameter kObjectPath[] = {kObject, kPath, kFrames, kLoop};
inline constexpr Example kObjectPathExamples[] = {
    {"mv_obj_path ball track -frames 50", "along the polyline, at constant speed"}};
inline constexpr Parameter kViewportName = named("viewport", "a viewport, whose camera is meant");
inline constexpr Parameter kCameraPath[] = {kViewportName, kPath, kFrames, kLoop};
inline constexpr Example kCameraPathExamples[] = {
    {"mv_vp_path main track -frames 200 -loop", "the eye goes round"}};
inline constexpr Parameter kMoveBy[] = {
    kObject,
    numbers("by", 3, "X Y Z", "shift", "0 0 0"),
    number("turn", "0", between(-1e6, 1e6), "angle in degrees"),
    numbers("axis", 3, "X Y Z", "what it turns about", "0 0 1"),
    {
        .name = "about",
        .range = between(-1e9, 1e9),
        .count = {3, 3},
        .label = "X Y Z",
        .help = "a point on the axis; else the object's centre",
    },
    kFrames,
};
inline constexpr Example kMoveByExamples[] = {
    {"mv_obj_by plate -turn 60 -axis 0 0 1 -frames 100", "turns by 60 degrees in 100 frames"},
    {"mv_obj_by hand -by 0 -10 0 -frames 50", "a shift"}};

inline constexpr Parameter kTrack[] = {
    kViewportName,
    word_flag("eye", "OBJECT", "gives the place of the camera"),
    word_flag("look_at", "OBJECT", "what the camera looks at"),
};
inline constexpr std::string_view kTrackFlags[] = {"eye", "look_at"};
inline constexpr Rule kTrackRules[] = {{Rule::at_least_one, kTrackFlags}};
inline constexpr Example kTrackExamples[] = {
    {"vp_track_obj main -look_at ball", "stays, and turns to the ball"}};

inline constexpr Parameter kBobblot[] = {kObject,
                                         named("sample", "point sample: a name, or FLESH:LAYER:NUMBER")};
inline constexpr Example kBobblotExamples[] = {
    {"bobblot ball tip", "the object's centre follows the sample"}};
inline constexpr Parameter kBlotbob[] = {named("sample", "point sample: a name, or FLESH:LAYER:NUMBER"),
                                         kObject};
inline constexpr Example kBlotbobExamples[] = {
    {"blotbob tip ball", "the sample follows the object's centre"}};

inline constexpr Parameter kDevice[] = {
    named("device", "name"),
    {
        .name = "value",
        .range = between(-1e9, 1e9),
        .count = {3, 3},
        .label = "X Y Z",
        .positional = true,
        .help = "what it reads now",
    },
    {
        .name = "file",
        .type = ValueType::path,
        .help = "readings to play: lines of time x y z, sampled once a frame",
    },
};
inline constexpr Example kDeviceExamples[] = {{"device hand 0.1 0 0.4", "one reading"},
                                              {"device hand -file hand.txt", "readings over time"}};
inline constexpr Parameter kFollow[] = {kObject, named("device", "a device")};
inline constexpr Example kFollowExamples[] = {
    {"follow_device ball hand", "its centre goes where the device reads"}};
inline constexpr Parameter kRemoveConstraint[] = {
    named("constraint", "name, as `list constraints` shows it")};
inline constexpr Example kRemoveConstraintExamples[] = {
    {"remove_constraint link.1", "the objects stay as they are"}};

inline constexpr CommandDeclaration kSceneConstraintCommands[] = {
    {
        .name = "link",
        .group = "Constraints",
        .summary = "Stretch an object between two others",
        .parameters = kLink,
        .examples = kLinkExamples,
    },
    {
        .name = "parent",
        .group = "Constraints",
        .summary = "Let an object follow another one",
        .parameters = kParent,
        .examples = kParentExamples,
    },
    {
        .name = "stand_in",
        .group = "Constraints",
        .summary = "Show an object by its bounding box",
        .parameters = kObjectOnly,
        .examples = kStandInExamples,
    },
    {
        .name = "mv_obj_path",
        .group = "Constraints",
        .summary = "Move an object along a polyline",
        .parameters = kObjectPath,
        .examples = kObjectPathExamples,
    },
    {
        .name = "mv_obj_by",
        .group = "Constraints",
        .summary = "Move and turn an object over some frames",
        .parameters = kMoveBy,
        .examples = kMoveByExamples,
    },
    {
        .name = "mv_vp_path",
        .group = "Constraints",
        .summary = "Move a viewport's camera along a polyline",
        .parameters = kCameraPath,
        .examples = kCameraPathExamples,
    },
    {
        .name = "vp_track_obj",
        .group = "Constraints",
        .summary = "Let a viewport's camera follow objects",
        .parameters = kTrack,
        .rules = kTrackRules,
        .examples = kTrackExamples,
    },
    {
        .name = "bobblot",
        .group = "Constraints",
        .summary = "Let an object follow a point sample",
        .parameters = kBobblot,
        .examples = kBobblotExamples,
    },
    {
        .name = "blotbob",
        .group = "Constraints",
        .summary = "Let a point sample follow an object",
        .parameters = kBlotbob,
        .examples = kBlotbobExamples,
    },
    {
        .name = "device",
        .group = "Constraints",
        .summary = "Give or play the readings of a device",
        .parameters = kDevice,
        .examples = kDeviceExamples,
    },
    {
        .name = "follow_device",
        .group = "Constraints",
        .summary = "Let an object follow a device",
        .parameters = kFollow,
        .examples = kFollowExamples,
    },
    {
        .name = "remove_constraint",
        .group = "Constraints",
        .summary = "Remove a constraint",
        .parameters = kRemoveConstraint,
        .examples = kRemoveConstraintExamples,
    },
};

}  // namespace turgor::commands
