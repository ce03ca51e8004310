// Parameters of the solvers, shared by `turgor predict`, by a plan's `solver ...` and by the reference of a
// problem.
#pragma once

#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

inline constexpr Parameter kAlpha{
    .name = "alpha",
    .range = between(0, 1),
    .fallback = "0.8",
    .help =
        "chain: weight of the rigid movement, from 0 (elastic) to 1 (rigid), for springs along the layers; "
        "Duysak and Zhang 2005, section 3.2",
};
inline constexpr Parameter kColumnAlpha{
    .name = "column_alpha",
    .range = between(0, 1),
    .fallback = "0.97",
    .help = "chain: the same for springs across the layers, vertical and diagonal",
};
inline constexpr Parameter kBeta{
    .name = "beta",
    .range = between(0, 100),
    .fallback = "2",
    .help = "chain: slope of the deformation; Duysak and Zhang 2005, section 3.3",
};
inline constexpr Parameter kMaxStretch{
    .name = "max_stretch",
    .unit = Unit::fraction,
    .range = between(0, 5),
    .fallback = "0.5",
    .help = "chain: greatest lengthening of a spring, as a part of its rest length",
};
inline constexpr Parameter kMaxCompression{
    .name = "max_compression",
    .unit = Unit::fraction,
    .range = between(0, 0.95),
    .fallback = "0.5",
    .help = "chain: greatest shortening of a spring, as a part of its rest length",
};
inline constexpr std::string_view kFixedPointKinds[] = {"inert", "hold"};
inline constexpr Parameter kFixedPoints{
    .name = "fixed_points",
    .type = ValueType::choice,
    .choices = kFixedPointKinds,
    .fallback = "hold",
    .help =
        "chain: inert: they never move and never act, as printed; hold: they hold the tissue above them, as "
        "bone "
        "does",
};
inline constexpr Parameter kSemiActivePasses{
    .name = "semi_active_passes",
    .type = ValueType::integer,
    .range = between(0, 100),
    .fallback = "1",
    .help = "chain: times that springs between two points of one step are brought back within their limits",
};
inline constexpr Parameter kResidual{
    .name = "residual",
    .range = between(1e-12, 0.1),
    .fallback = "1e-4",
    .help = "network: the equilibrium is reached when the force left is this part of the force at the start",
};
inline constexpr Parameter kMaxSteps{
    .name = "max_steps",
    .type = ValueType::integer,
    .range = between(1, 100'000),
    .fallback = "200",
    .help = "network: most Newton steps before the run is reported as not converged",
};
inline constexpr Parameter kLoadSteps{
    .name = "load_steps",
    .type = ValueType::integer,
    .range = between(1, 1000),
    .fallback = "1",
    .help = "network: parts in which the movement of the bone is applied",
};
inline constexpr Parameter kPoisson{
    .name = "poisson",
    .range = between(0.25, 0.49),
    .fallback = "0.45",
    .help =
        "network: Poisson's ratio of the tissue, from 0.25 (springs alone) to 0.49 (nearly incompressible)",
};
inline constexpr Parameter kCubeSpacing{
    .name = "spacing",
    .unit = Unit::mm,
    .range = between(0.5, 10),
    .fallback = "2",
    .help = "edge of the cubes; 3 mm at draft quality, 1.5 mm at fine",
};
// The names of fem/elastic_material.hpp; a test holds the two together.
inline constexpr std::string_view kElasticLawNames[] = {"linear", "corotational", "st_venant_kirchhoff",
                                                        "neo_hookean", "mooney_rivlin"};
inline constexpr Parameter kCubeLaw{
    .name = "law",
    .type = ValueType::choice,
    .choices = kElasticLawNames,
    .label = "LAW",
    .fallback = "mooney_rivlin",
    .help =
        "of fem, stress against strain: linear, corotational, st_venant_kirchhoff, neo_hookean or "
        "mooney_rivlin; alike for small strains",
};
inline constexpr Parameter kCubeModulus{
    .name = "modulus",
    .unit = Unit::mpa,
    .range = above_up_to(0, 10),
    .fallback = "0.0149",
    .help = "Young's modulus at small strain, of the whole face; six times c10 of Nazari et al. 2010",
};
inline constexpr Parameter kCubeC20{
    .name = "c20",
    .unit = Unit::mpa,
    .range = between(0, 10),
    .fallback = "0.001175",
    .help = "of the law mooney_rivlin, which stiffens by it; Nazari et al. 2010",
};
inline constexpr Parameter kCubePoisson{
    .name = "poisson",
    .range = between(0, 0.499),
    .fallback = "0.49",
    .help = "Poisson's ratio; at most 0.45 for solid, whose tetrahedra lock",
};
inline constexpr Parameter kCubeResidual{
    .name = "residual",
    .range = between(1e-9, 0.1),
    .fallback = "0.02",
    .help =
        "of fem: the equilibrium is reached when the force left is this part of the reactions; 0.02 leaves "
        "0.02 mm",
};

}  // namespace turgor::commands
