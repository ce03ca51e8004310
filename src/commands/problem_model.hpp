// Commands of a problem: what the body is made of, the model that is fitted, and how.
#pragma once

#include "problem_body.hpp"
#include "problem_parameters.hpp"
#include "solver_parameters.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor::commands {

inline constexpr Parameter kYoung{
    .name = "modulus",
    .unit = Unit::mpa,
    .range = above_up_to(0, 1e6),
    .required = true,
    .help = "Young's modulus at small strain",
};
inline constexpr Parameter kReferenceParameters[] = {
    {
        .name = "law",
        .type = ValueType::choice,
        .choices = kElasticLawNames,
        .label = "LAW",
        .fallback = "linear",
        .help = "of the material; all are Hooke's for small strains",
    },
    kYoung,
    {
        .name = "poisson",
        .range = {.low = -1, .high = 0.5, .low_open = true, .high_open = true},
        .required = true,
        .help = "Poisson's ratio",
    },
    {
        .name = "c20",
        .unit = Unit::mpa,
        .range = between(0, 1e6),
        .fallback = "0",
        .help = "of mooney_rivlin: by which it stiffens (Nazari et al. 2010)",
    },
    kInBox,
    kInSphere,
    kBeyondPlane,
};
inline constexpr Example kReferenceExamples[] = {
    {"reference -modulus 50kPa -poisson 0.45", "everywhere"},
    {"reference -modulus 1MPa -poisson 0.45 -box 0 0 0 40 40 20", "and harder below"}};

constexpr Parameter grid(std::string_view help) {
  return {
      .name = "grid",
      .type = ValueType::integer,
      .range = between(1, 1000),
      .count = {3, 3},
      .label = "NX NY NZ",
      .fallback = "1 1 1",
      .help = help,
  };
}
inline constexpr Parameter kTetrahedraParameters[] = {
    grid("nodes over the body that have constants, interpolated between them; 1: constant along that axis"),
    {
        .name = "proportional",
        .type = ValueType::flag,
        .help =
            "one factor of k_d, k_a and k_v together at each node, and their proportion throughout: a third "
            "of the parameters, which few loads tell apart better",
    },
    {
        .name = "residual",
        .range = between(1e-12, 0.01),
        .fallback = "1e-7",
        .help = "rest is reached when the force left is this part of the reactions",
    },
};
inline constexpr Example kTetrahedraExamples[] = {
    {"model tetrahedra", "homogeneous: three constants"},
    {"model tetrahedra -grid 5 5 3", "75 nodes with three constants each (Morris 2006, section 3.6)"}};

inline constexpr Parameter kLayeredNetworkParameters[] = {
    grid("nodes over the face that have factors, interpolated between them; 1: constant along that axis"),
};
inline constexpr Example kLayeredNetworkExamples[] = {
    {"model network", "one factor for each layer and kind"},
    {"model network -grid 3 1 3", "from side to side and from top to bottom"}};

inline constexpr Parameter kGuessParameters[] = {
    kYoung,
    {
        .name = "poisson",
        .range = {.low = 0, .high = 0.5, .high_open = true},
        .fallback = "0.45",
        .help = "Poisson's ratio",
    },
    {
        .name = "area_share",
        .unit = Unit::fraction,
        .range = between(0, 1),
        .fallback = "0.2",
        .help = "of the shear stiffness that triangles carry, not edges",
    },
};
inline constexpr Example kGuessExamples[] = {
    {"guess -modulus 0.1 -poisson 0.45", "the constants that such a material has on average"}};

inline constexpr Parameter kBoundsParameters[] = {
    {
        .name = "low",
        .range = above_up_to(0, 1),
        .fallback = "0.01",
        .help = "least value of a constant, times its guess",
    },
    {
        .name = "high",
        .range = {.low = 1, .high = 1e6},
        .fallback = "100",
        .help = "greatest value of a constant, times its guess",
    },
};
inline constexpr Example kBoundsExamples[] = {
    {"bounds -low 0.1 -high 10", "within ten times the guess either way"}};

inline constexpr std::string_view kMeasures[] = {"distance", "shape", "force"};
inline constexpr Parameter kMeasureParameters[] = {
    {
        .name = "what",
        .type = ValueType::choice,
        .choices = kMeasures,
        .label = "distance|shape|force",
        .required = true,
        .positional = true,
        .help = "distance: of points; shape: of points after the rigid motion that brings them nearest; "
                "force: on points that loads displace",
    },
};
inline constexpr Example kMeasureExamples[] = {
    {"measure distance", "as in Morris 2006"},
    {"measure shape", "blind to movements of the body as a whole"}};

inline constexpr Parameter kMethodParameters[] = {
    {
        .name = "name",
        .type = ValueType::choice,
        .choices = kFitMethods,
        .label = "METHOD",
        .required = true,
        .positional = true,
        .help = "gauss_newton: damped, with exact derivatives; gradient: L-BFGS on the adjoint's gradient; "
                "cma_es: covariance matrix adaptation; annealing: simulated annealing, as in the paper",
    },
    kCoarse,
    kBudget,
    kChains,
    kSeed,
    {
        .name = "regularisation",
        .range = between(0, 1e6),
        .fallback = "0",
        .help = "of gauss_newton and gradient: weight of the squared logarithmic distance to the guess",
    },
};
inline constexpr Example kMethodExamples[] = {
    {"method gauss_newton -budget 50", "few iterations suffice"},
    {"method annealing -budget 4000 -chains 8", "global, and slow"}};

inline constexpr Parameter kViewParameters[] = {
    {
        .name = "from",
        .type = ValueType::direction,
        .label = "X Y Z",
        .required = true,
        .positional = true,
        .help = "from the body to the viewer",
    },
};
inline constexpr Example kViewExamples[] = {{"view 0 0 1", "from above"}};

inline constexpr CommandDeclaration kProblemModelCommands[] = {
    {
        .name = "reference",
        .group = "Reference and model",
        .summary = "Say what the body is made of",
        .description = "Solved with finite elements on the cubes: what the model is calibrated to. Without a "
                       "region everywhere; later ones go before earlier ones.",
        .parameters = kReferenceParameters,
        .examples = kReferenceExamples,
    },
    {
        .name = "model tetrahedra",
        .group = "Reference and model",
        .summary = "Calibrate tetrahedra that keep lengths, areas and volumes",
        .description = "The model of Morris 2006, section 4.1, on the five tetrahedra of each cube.",
        .parameters = kTetrahedraParameters,
        .examples = kTetrahedraExamples,
    },
    {
        .name = "model network",
        .group = "Reference and model",
        .summary = "Calibrate the layered network of a face",
        .description =
            "Factors of its springs and volumes, by layer and kind; the network as predict makes it "
            "is the guess.",
        .parameters = kLayeredNetworkParameters,
        .examples = kLayeredNetworkExamples,
    },
    {
        .name = "guess",
        .group = "Reference and model",
        .summary = "Set the uncalibrated model by the words of engineers",
        .description = "Where not given: the modulus of the first reference, and Poisson's ratio 0.45.",
        .parameters = kGuessParameters,
        .examples = kGuessExamples,
    },
    {
        .name = "bounds",
        .group = "The search",
        .summary = "Set how far constants may go from the guess",
        .parameters = kBoundsParameters,
        .examples = kBoundsExamples,
    },
    {
        .name = "measure",
        .group = "The search",
        .summary = "Say what the error is",
        .description = "Root mean square over points, averaged over the loads.",
        .parameters = kMeasureParameters,
        .examples = kMeasureExamples,
    },
    {
        .name = "method",
        .group = "The search",
        .summary = "Choose how to search, and how long",
        .parameters = kMethodParameters,
        .examples = kMethodExamples,
    },
    {
        .name = "view",
        .group = "The search",
        .summary = "Say from where the report's pictures show the body",
        .parameters = kViewParameters,
        .examples = kViewExamples,
    },
};

}  // namespace turgor::commands
