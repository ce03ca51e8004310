#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "turgor/anatomy/head.hpp"
#include "turgor/anatomy/phantom.hpp"
#include "turgor/anatomy/tissue_network.hpp"
#include "turgor/commands/script.hpp"
#include "turgor/dynamics/chain.hpp"
#include "turgor/dynamics/equilibrium.hpp"

namespace turgor {
namespace {

Invocation parsed(std::string_view line, const CommandTable& table) {
  const auto invocations = parse_script_text(line, "t", table);
  EXPECT_TRUE(invocations) << invocations.error().message();
  return invocations ? invocations->front() : Invocation{};
}

TEST(Declarations, AreWellFormed) {
  for (const CommandTable* table : command_tables()) {
    const auto valid = validate(*table);
    EXPECT_TRUE(valid) << valid.error().message();
    EXPECT_FALSE(table->commands.empty());
  }
}

TEST(Declarations, NameEachCommandOnceOverAllTables) {
  std::set<std::string_view> names{"language"};  // the help topic
  for (const CommandTable* table : command_tables()) {
    for (const auto& command : table->commands) {
      if (table->name == "scene" && command.name == "help") continue;  // the same one, at the console
      EXPECT_TRUE(names.insert(command.name).second) << command.name;
    }
  }
}

TEST(Declarations, KeepGroupsTogether) {
  for (const CommandTable* table : command_tables()) {
    std::set<std::string_view> closed;
    std::string_view open;
    for (const auto& command : table->commands) {
      if (command.group == open) continue;
      EXPECT_TRUE(closed.insert(open).second) << open;
      EXPECT_FALSE(closed.contains(command.group)) << command.group;
      open = command.group;
    }
  }
}

TEST(Declarations, HaveTheDefaultsOfTheCode) {
  const Invocation chain = parsed("solver chain", plan_commands());
  const ChainParameters c;
  EXPECT_EQ(chain.number("alpha"), c.alpha);
  EXPECT_EQ(chain.number("column_alpha"), c.column_alpha);
  EXPECT_EQ(chain.number("beta"), c.beta);
  EXPECT_EQ(chain.number("max_stretch"), c.max_stretch);
  EXPECT_EQ(chain.number("max_compression"), c.max_compression);
  EXPECT_EQ(chain.word("fixed_points") == "hold", c.fixed_points == FixedPoints::hold);
  EXPECT_EQ(chain.integer("semi_active_passes"), c.semi_active_passes);

  const Invocation network = parsed("solver network", plan_commands());
  const EquilibriumOptions e;
  EXPECT_EQ(network.number("residual"), e.relative_residual);
  EXPECT_EQ(network.integer("max_steps"), e.max_newton_steps);
  EXPECT_EQ(network.integer("load_steps"), e.load_steps);
  EXPECT_EQ(network.number("poisson"), TissueMaterial{}.poisson);

  const Invocation surfaces = parsed("surfaces", plan_commands());
  const HeadOptions h;
  EXPECT_EQ(surfaces.integer("skin"), h.skin_triangles);
  EXPECT_EQ(surfaces.integer("bone"), h.bone_triangles);
  EXPECT_EQ(surfaces.number("smoothing"), h.smoothing);

  const Invocation phantom = parsed("phantom -o d", program_commands());
  const PhantomParameters p;
  EXPECT_EQ(phantom.number("size"), p.size);
  EXPECT_EQ(phantom.number("jaw_protrusion"), p.jaw_protrusion_mm);
  EXPECT_EQ(phantom.number("thickness"), p.thickness);
  EXPECT_EQ(phantom.number("voxel"), p.voxel_mm);
  EXPECT_EQ(phantom.number("slice"), p.slice_mm);
  EXPECT_EQ(phantom.number("noise"), p.noise_hu);
  EXPECT_EQ(phantom.number("blur"), p.blur_mm);
  EXPECT_EQ(phantom.integer("seed"), static_cast<std::int64_t>(p.seed));
  EXPECT_EQ(!phantom.flag("no_holder"), p.head_holder);
  EXPECT_EQ(phantom.flag("condyles_touch"), p.condyles_touch);
}

TEST(Declarations, OfPredictRepeatTheSolversOfPlans) {
  const CommandDeclaration* predict = program_commands().find("predict");
  ASSERT_NE(predict, nullptr);
  for (const char* solver : {"solver chain", "solver network"}) {
    for (const Parameter& parameter : plan_commands().find(solver)->parameters) {
      const Parameter* twin = predict->find(parameter.name);
      ASSERT_NE(twin, nullptr) << parameter.name;
      EXPECT_EQ(twin->fallback, parameter.fallback);
      EXPECT_EQ(twin->help, parameter.help);
    }
  }
}

// ---- validate() itself ----

std::string fault(const CommandDeclaration& command) {
  const CommandDeclaration commands[] = {command};
  const auto valid = validate({.name = "t", .title = "t", .prefix = "", .commands = commands});
  return valid ? "" : valid.error().what;
}

TEST(Validate, FindsFaultyDeclarations) {
  constexpr Example example[] = {{"go", "goes"}};
  const CommandDeclaration plain{.name = "go", .group = "g", .summary = "Go", .examples = example};
  EXPECT_EQ(fault(plain), "");
  const auto with = [&](const Parameter& parameter) {
    CommandDeclaration command = plain;
    command.parameters = {&parameter, 1};
    return fault(command);
  };
  EXPECT_EQ(with({.name = "x", .help = "h"}), "");
  EXPECT_NE(with({.name = "X", .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .help = ""}), "");
  EXPECT_NE(with({.name = "x", .range = between(0, 1), .fallback = "2", .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .count = {3, 3}, .fallback = "1 2", .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .range = between(1, 0), .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .type = ValueType::choice, .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .type = ValueType::word, .unit = Unit::mm, .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .type = ValueType::flag, .fallback = "1", .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .fallback = "1", .required = true, .help = "h"}), "");
  EXPECT_NE(with({.name = "x", .required = true, .help = "h"}), "") << "its example lacks x";

  CommandDeclaration other = plain;
  other.name = "Go";
  EXPECT_NE(fault(other), "");
  other = plain;
  other.examples = {};
  EXPECT_NE(fault(other), "");
  constexpr std::string_view names[] = {"a", "b"};
  const Rule rules[] = {{Rule::at_least_one, names}};
  other = plain;
  other.rules = rules;
  EXPECT_NE(fault(other), "");
  const CommandDeclaration twice[] = {plain, plain};
  EXPECT_FALSE(validate({.name = "t", .title = "t", .prefix = "", .commands = twice}));
}

}  // namespace
}  // namespace turgor
