// What a script, the console or a device may say to a scene: the table of all its commands.
#include <algorithm>
#include <array>

#include "scene_constraints.hpp"
#include "scene_objects.hpp"
#include "scene_solids.hpp"
#include "scene_tissue.hpp"
#include "scene_views.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor {
namespace {

constexpr auto kSceneCommands = [] {
  using namespace commands;
  std::array<CommandDeclaration, std::size(kSceneObjectCommands) + std::size(kSceneTissueCommands) +
                                     std::size(kSceneSolidCommands) + std::size(kSceneConstraintCommands) +
                                     std::size(kSceneViewCommands)>
      all;
  auto next = std::ranges::copy(kSceneObjectCommands, all.begin()).out;
  next = std::ranges::copy(kSceneTissueCommands, next).out;
  next = std::ranges::copy(kSceneSolidCommands, next).out;
  next = std::ranges::copy(kSceneConstraintCommands, next).out;
  std::ranges::copy(kSceneViewCommands, next);
  return all;
}();

}  // namespace

const CommandTable& scene_commands() {
  static constexpr CommandTable table{
      .name = "scene", .title = "Commands of a scene", .prefix = "", .commands = kSceneCommands};
  return table;
}

}  // namespace turgor
