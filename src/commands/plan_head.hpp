// Plan commands that correct the head and shape its tissue.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

constexpr Parameter positional_plane(std::string_view help) {
  return {
      .name = "plane",
      .type = ValueType::plane,
      .label = "X Y Z NX NY NZ",
      .required = true,
      .positional = true,
      .help = help,
  };
}

// The names of anatomy/landmarks.hpp; a test holds the two together.
inline constexpr std::string_view kLandmarks[] = {
    "nasion",         "ans",
    "a_point",        "b_point",
    "pogonion",       "menton",
    "upper_incisor",  "lower_incisor",
    "gonion_left",    "gonion_right",
    "condylion_left", "condylion_right",
    "orbitale_left",  "orbitale_right",
    "zygion_left",    "zygion_right",
    "soft_nasion",    "pronasale",
    "subnasale",      "labrale_superius",
    "stomion",        "labrale_inferius",
    "soft_a_point",   "soft_b_point",
    "soft_pogonion",  "soft_menton",
    "cheilion_left",  "cheilion_right",
    "alare_left",     "alare_right",
};
inline constexpr Parameter kLandmarkParameters[] = {
    {
        .name = "name",
        .type = ValueType::choice,
        .choices = kLandmarks,
        .label = "NAME",
        .required = true,
        .positional = true,
        .help = "which landmark",
    },
    {
        .name = "point",
        .type = ValueType::point,
        .label = "X Y Z",
        .required = true,
        .positional = true,
        .help = "where it is",
    },
};
inline constexpr Example kLandmarkExamples[] = {
    {"landmark pogonion 0.4 -92.1 -61.5", "the chin's foremost point, corrected"}};

inline constexpr Parameter kBoneThresholdParameters[] = {
    {
        .name = "level",
        .unit = Unit::hu,
        .range = between(50, 2000),
        .required = true,
        .positional = true,
        .help = "Hounsfield number from which a voxel is bone",
    },
    {
        .name = "fixed",
        .type = ValueType::flag,
        .help = "use the level as it stands, without automatic refinement",
    },
};
inline constexpr Example kBoneThresholdExamples[] = {
    {"bone_threshold 300", "start from 300 HU"}, {"bone_threshold 226 -fixed", "226 HU and nothing else"}};

inline constexpr Parameter kSurfacesParameters[] = {
    {
        .name = "skin",
        .type = ValueType::integer,
        .range = between(1000, 2'000'000),
        .fallback = "60000",
        .help = "triangles of the skin after reduction",
    },
    {
        .name = "bone",
        .type = ValueType::integer,
        .range = between(1000, 2'000'000),
        .fallback = "90000",
        .help = "triangles of all bones after reduction",
    },
    {
        .name = "smoothing",
        .range = between(0, 3),
        .fallback = "1",
        .help = "0 is none; it does not shrink",
    },
};
inline constexpr Example kSurfacesExamples[] = {{"surfaces -skin 20000 -bone 30000", "coarser surfaces"}};

inline constexpr Parameter kOcclusalParameters[] = {
    positional_plane("a point between the rows of teeth, and the normal, upwards")};
inline constexpr Example kOcclusalExamples[] = {
    {"occlusal_plane 0 -70 -48 0 0.1 1", "the bite, tilted a little"}};

inline constexpr Parameter kMidsagittalParameters[] = {
    positional_plane("a point of the plane, and the normal, to the patient's left")};
inline constexpr Example kMidsagittalExamples[] = {
    {"midsagittal_plane 1.5 0 0 1 0 0", "1.5 mm to the left of the origin"}};

inline constexpr std::string_view kCentres[] = {"upper", "lower"};
inline constexpr Parameter kCentreParameters[] = {
    {
        .name = "which",
        .type = ValueType::choice,
        .choices = kCentres,
        .label = "upper|lower",
        .required = true,
        .positional = true,
        .help = "upper: for the skin above the lips; lower: for the skin below",
    },
    {
        .name = "point",
        .type = ValueType::point,
        .label = "X Y Z",
        .required = true,
        .positional = true,
        .help = "the centre",
    },
};
inline constexpr Example kCentreExamples[] = {{"centre lower 0 -40 -60", "within the lower jaw"}};

inline constexpr Parameter kLevelParameters[] = {
    {
        .name = "z",
        .unit = Unit::mm,
        .range = between(-10'000, 10'000),
        .label = "Z",
        .required = true,
        .positional = true,
        .help = "height, upwards",
    },
};
inline constexpr Example kLipExamples[] = {{"lip_level -47.5", "the height at which the lips meet"}};
inline constexpr Example kBoneLevelExamples[] = {{"bone_level 35", "no tissue above 35 mm"}};

inline constexpr std::string_view kLayerKinds[] = {"fractions", "thickness"};
inline constexpr Rule kLayerRules[] = {{Rule::exactly_one, kLayerKinds}};
inline constexpr Parameter kLayersParameters[] = {
    {
        .name = "fractions",
        .unit = Unit::fraction,
        .range = between(0.01, 1),
        .count = {3, 3},
        .label = "SKIN SMAS DEEP",
        .help = "shares of the whole thickness; they are scaled to add up to 1",
    },
    {
        .name = "thickness",
        .unit = Unit::mm,
        .range = above_up_to(0, 50),
        .count = {3, 3},
        .label = "SKIN SMAS DEEP",
        .help = "thickness of each layer; thinned in proportion where bone is nearer than their sum, and the "
                "deep layer takes "
                "the rest where it is farther",
    },
};
inline constexpr Example kLayersExamples[] = {{"layers -fractions 0.2 0.3 0.5", "proportions"},
                                              {"layers -thickness 1.8 3 6", "skin of 1.8 mm"}};

inline constexpr Parameter kTissuePointsParameters[] = {
    {
        .name = "count",
        .type = ValueType::integer,
        .range = between(100, 1'000'000),
        .required = true,
        .positional = true,
        .help = "columns of points to aim for; the skin is reduced to as many vertices",
    },
};
inline constexpr Example kTissuePointsExamples[] = {
    {"tissue_points 2628", "as many as in Duysak and Zhang 2005"}};

inline constexpr std::string_view kLayerNames[] = {"skin", "smas", "deep"};
inline constexpr std::string_view kLaws[] = {"linear", "exponential", "logarithmic", "square"};
inline constexpr std::string_view kMaterialFlags[] = {"modulus", "law"};
inline constexpr Rule kMaterialRules[] = {{Rule::at_least_one, kMaterialFlags}};
inline constexpr Parameter kMaterialParameters[] = {
    {
        .name = "layer",
        .type = ValueType::choice,
        .choices = kLayerNames,
        .label = "skin|smas|deep",
        .required = true,
        .positional = true,
        .help = "which layer",
    },
    {
        .name = "modulus",
        .unit = Unit::mpa,
        .range = above_up_to(0, 10),
        .help = "Young's modulus at small strain; as it was where not given",
    },
    {
        .name = "law",
        .type = ValueType::choice,
        .choices = kLaws,
        .help = "force against strain of its springs (Pieper 1989, section 3.2.1); as it was where not given",
    },
};
inline constexpr Example kMaterialExamples[] = {
    {"material skin -modulus 35kPa", "skin of 0.035 MPa"},
    {"material smas -law exponential", "SMAS that stiffens when stretched"}};

inline constexpr Parameter kUnderminingParameters[] = {{
    .name = "distance",
    .unit = Unit::mm,
    .range = between(0, 50),
    .required = true,
    .positional = true,
    .help = "on either side of the gap between bones that move differently; 10 mm where not set",
}};
inline constexpr Example kUnderminingExamples[] = {
    {"undermining 15mm", "wide access to the bone"},
    {"undermining 0", "the tissue stays on the bone up to the cut"}};

inline constexpr Parameter kVestibuleParameters[] = {
    {
        .name = "distance",
        .unit = Unit::mm,
        .range = between(0, 30),
        .help = "tissue this near to teeth is not attached, but slides; 4 mm where not set",
    },
    {
        .name = "adhesion",
        .range = between(0, 100),
        .help = "force in newtons that draws a column of sliding mucosa back to its bone, for each "
                "millimetre of gap; "
                "0.1 where not set",
    },
};
inline constexpr Example kVestibuleExamples[] = {{"vestibule -adhesion 0", "lips may lift off the teeth"}};

inline constexpr CommandDeclaration kHeadCommands[] = {
    {
        .name = "landmark",
        .group = "Corrections of the head",
        .summary = "Put a landmark where it belongs",
        .description =
            "Goes before the landmark found automatically; the named operations set their planes by it.",
        .parameters = kLandmarkParameters,
        .examples = kLandmarkExamples,
    },
    {
        .name = "bone_threshold",
        .group = "Corrections of the head",
        .summary = "Set the level of bone",
        .parameters = kBoneThresholdParameters,
        .examples = kBoneThresholdExamples,
    },
    {
        .name = "surfaces",
        .group = "Corrections of the head",
        .summary = "Set the size and smoothing of the surfaces",
        .parameters = kSurfacesParameters,
        .examples = kSurfacesExamples,
    },
    {
        .name = "occlusal_plane",
        .group = "Corrections of the head",
        .summary = "Say where upper and lower teeth meet",
        .description =
            "Cuts a mandible free that touches the skull in the scan. The plane of a person standing upright "
            "has a normal near 0 0 1.",
        .parameters = kOcclusalParameters,
        .examples = kOcclusalExamples,
    },
    {
        .name = "midsagittal_plane",
        .group = "Corrections of the head",
        .summary = "Say where the plane of symmetry is",
        .description = "Forward, left and out of the named operations are measured from it.",
        .parameters = kMidsagittalParameters,
        .examples = kMidsagittalExamples,
    },
    {
        .name = "centre",
        .group = "Tissue",
        .summary = "Set a centre that the rays through the tissue aim at",
        .description =
            "Every skin vertex aims at one of two centres, and its column of tissue ends where the ray meets "
            "bone (Duysak and Zhang 2005, section 2).",
        .parameters = kCentreParameters,
        .examples = kCentreExamples,
    },
    {
        .name = "lip_level",
        .group = "Tissue",
        .summary = "Set the height that parts upper and lower rays",
        .parameters = kLevelParameters,
        .examples = kLipExamples,
    },
    {
        .name = "bone_level",
        .group = "Tissue",
        .summary = "Set the height above which no tissue is built",
        .parameters = kLevelParameters,
        .examples = kBoneLevelExamples,
    },
    {
        .name = "layers",
        .group = "Tissue",
        .summary = "Set the thickness of skin, SMAS and deep layer",
        .parameters = kLayersParameters,
        .rules = kLayerRules,
        .examples = kLayersExamples,
    },
    {
        .name = "tissue_points",
        .group = "Tissue",
        .summary = "Set the size of the tissue model",
        .parameters = kTissuePointsParameters,
        .examples = kTissuePointsExamples,
    },
    {
        .name = "undermining",
        .group = "Tissue",
        .summary = "Set how far tissue is taken off bone beside a cut",
        .description = "Undermined tissue follows neither bone; it slides on both.",
        .parameters = kUnderminingParameters,
        .examples = kUnderminingExamples,
    },
    {
        .name = "vestibule",
        .group = "Tissue",
        .summary = "Set where lips and cheeks slide over the teeth, and how they cling to them",
        .parameters = kVestibuleParameters,
        .examples = kVestibuleExamples,
    },
    {
        .name = "material",
        .group = "Tissue",
        .summary = "Set the stiffness of a layer",
        .parameters = kMaterialParameters,
        .rules = kMaterialRules,
        .examples = kMaterialExamples,
    },
};

}  // namespace turgor::commands
