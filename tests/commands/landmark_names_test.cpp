#include <gtest/gtest.h>

#include <set>

#include "turgor/anatomy/landmarks.hpp"
#include "turgor/commands/declaration.hpp"

namespace turgor {
namespace {

TEST(LandmarkNames, OfTheCommandAreThoseOfAnatomy) {
  const Parameter* name = plan_commands().find("landmark")->find("name");
  ASSERT_NE(name, nullptr);
  std::set<std::string_view> known;
  for (const LandmarkKind& kind : landmark_kinds()) known.insert(kind.name);
  EXPECT_EQ(std::set<std::string_view>(name->choices.begin(), name->choices.end()), known);
  EXPECT_EQ(name->choices.size(), known.size());
}

}  // namespace
}  // namespace turgor
