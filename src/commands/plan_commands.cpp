// What a surgical plan may say: the table of all its commands.
#include <algorithm>
#include <array>

#include "plan_bone.hpp"
#include "plan_head.hpp"
#include "solver_parameters.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor {
namespace {

constexpr Parameter kChainParameters[] = {
    commands::kAlpha,           commands::kColumnAlpha,    commands::kBeta,
    commands::kMaxStretch,      commands::kMaxCompression, commands::kFixedPoints,
    commands::kSemiActivePasses};
constexpr Example kChainExamples[] = {
    {"solver chain -alpha 0.6 -max_stretch 30%", "bends more and stretches less than by default"}};
constexpr Parameter kNetworkParameters[] = {commands::kResidual, commands::kMaxSteps, commands::kLoadSteps,
                                            commands::kPoisson};
constexpr Example kNetworkExamples[] = {
    {"solver network -residual 1e-8 -load_steps 4", "a large movement, precisely"}};
constexpr Parameter kFemParameters[] = {commands::kCubeSpacing, commands::kCubeLaw,
                                        commands::kCubeModulus, commands::kCubeC20,
                                        commands::kCubePoisson, commands::kCubeResidual};
constexpr Example kFemExamples[] = {{"solver fem -spacing 1.5mm", "finer cubes"},
                                    {"solver fem -law linear -modulus 15kPa", "Hooke's law"}};

constexpr CommandDeclaration kSolverCommands[] = {
    {
        .name = "solver chain",
        .group = "Solvers",
        .summary = "Set the parameters of the mass-spring chain",
        .description =
            "Moved points drag their neighbours, each once (Duysak and Zhang 2005, section 3). Fast, and not "
            "an equilibrium.",
        .parameters = kChainParameters,
        .examples = kChainExamples,
    },
    {
        .name = "solver network",
        .group = "Solvers",
        .summary = "Set the parameters of the spring network's equilibrium",
        .description = "The positions at which every free point's force vanishes.",
        .parameters = kNetworkParameters,
        .examples = kNetworkExamples,
    },
    {
        .name = "solver fem",
        .group = "Solvers",
        .summary = "Set the cubes of soft tissue and their law",
        .description = "For the solvers fem and solid, which share the cubes and their moduli.",
        .parameters = kFemParameters,
        .examples = kFemExamples,
    },
};

constexpr auto kPlanCommands = [] {
  using commands::kBoneCommands;
  using commands::kHeadCommands;
  std::array<CommandDeclaration,
             std::size(kHeadCommands) + std::size(kBoneCommands) + std::size(kSolverCommands)>
      all;
  auto next = std::ranges::copy(kHeadCommands, all.begin()).out;
  next = std::ranges::copy(kBoneCommands, next).out;
  std::ranges::copy(kSolverCommands, next);
  return all;
}();

}  // namespace

const CommandTable& plan_commands() {
  static constexpr CommandTable table{
      .name = "plan", .title = "Commands of a plan", .prefix = "", .commands = kPlanCommands};
  return table;
}

}  // namespace turgor
