#include "turgor/tissue/network.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "support/lattice_solid.hpp"
#include "support/layered_slab.hpp"

namespace turgor {
namespace {

TEST(SpringNetwork, OfASlabIsValid) {
  support::SlabOptions options;
  options.volumes = true;
  const auto checked = validate(support::make_slab(options).network);
  EXPECT_TRUE(static_cast<bool>(checked)) << (checked ? "" : checked.error().message());
}

TEST(SpringNetwork, OfTheFaceOfDuysakAndZhangHasTheirCounts) {
  for (const auto& options : {support::duysak_zhang_size(), support::duysak_zhang_size_braced()}) {
    const auto slab = support::make_slab(options);
    EXPECT_EQ(slab.network.rest.size(), 7884U);
    EXPECT_EQ(slab.network.springs.size(), 19724U);
  }
}

TEST(SpringNetwork, ThatBreaksItsInvariantIsNamedWithTheFirstFault) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    std::function<void(SpringNetwork&)> damage;
    const char* says;
  };
  const Case cases[] = {
      {[](SpringNetwork& n) { n.mass_g.pop_back(); }, "masses"},
      {[&](SpringNetwork& n) { n.rest[3].y = nan; }, "point 3 is not a finite number"},
      {[](SpringNetwork& n) { n.mass_g[2] = -1; }, "mass of point 2"},
      {[](SpringNetwork& n) { n.springs[5].a = -1; }, "spring 5 joins points -1"},
      {[](SpringNetwork& n) { n.springs[5].b = 1'000'000; }, "spring 5"},
      {[](SpringNetwork& n) { n.springs[4].b = n.springs[4].a; }, "spring 4 joins point"},
      {[](SpringNetwork& n) { n.springs[6].rest_length_mm = 0; }, "rest length of spring 6"},
      {[&](SpringNetwork& n) { n.springs[6].stiffness_n = nan; }, "stiffness of spring 6"},
      {[](SpringNetwork& n) { n.springs[6].law = static_cast<SpringLaw>(9); }, "unknown law 9"},
      {[](SpringNetwork& n) { n.volumes[1].p[2] = 1'000'000; }, "volume 1 has the corner 1000000"},
      {[](SpringNetwork& n) { n.volumes[1].p[2] = n.volumes[1].p[0]; }, "twice"},
      {[](SpringNetwork& n) { n.volumes[1].rest_volume_mm3 = -2; }, "rest volume of volume 1"},
      {[](SpringNetwork& n) { n.volumes[1].modulus_mpa = -2; }, "modulus -2"},
      {[](SpringNetwork& n) {
         n.contacts = {{2, {0, 0, 1}, 0, 1}, {1, {0, 0, 1}, 0, 1}};
       },
       "contact 1"},
      {[](SpringNetwork& n) {
         n.contacts = {{2, {0, 0, 2}, 0, 1}};
       },
       "no unit normal"},
      {[](SpringNetwork& n) {
         n.contacts = {{2, {0, 0, 1}, 0, -1}};
       },
       "stiffness of contact 0"},
  };
  support::SlabOptions options;
  options.volumes = true;
  for (const Case& c : cases) {
    SpringNetwork network = support::make_slab(options).network;
    c.damage(network);
    const auto checked = validate(network);
    ASSERT_FALSE(static_cast<bool>(checked)) << c.says;
    EXPECT_EQ(checked.error().kind, ErrorKind::bad_input);
    EXPECT_NE(checked.error().message().find(c.says), std::string::npos) << checked.error().message();
  }
}

TEST(SpringNetwork, WithAreasAndSolidsIsNamedWithTheFirstFault) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    std::function<void(SpringNetwork&)> damage;
    const char* says;
  };
  const Case cases[] = {
      {[](SpringNetwork& n) { n.areas[0].p[1] = -3; }, "area 0 has the corner -3"},
      {[](SpringNetwork& n) { n.areas[0].p[1] = n.areas[0].p[2]; }, "area 0 has the corner 2 twice"},
      {[](SpringNetwork& n) { n.areas[0].rest_area_mm2 = 0; }, "rest area of area 0"},
      {[&](SpringNetwork& n) { n.areas[0].stiffness_nmm = nan; }, "stiffness of area 0"},
      {[](SpringNetwork& n) { n.solids[0].edge_nmm.pop_back(); }, "constants"},
      {[](SpringNetwork& n) { n.solids[0].edge_nmm[4] = -1; }, "constant of edge 4 of solid 0"},
      {[&](SpringNetwork& n) { n.solids[0].triangle_nmm[2] = nan; }, "constant of triangle 2 of solid 0"},
      {[](SpringNetwork& n) { n.solids[0].tetrahedra[3][2] = 99; },
       "tetrahedron 3 of solid 0 has the corner 99"},
      {[](SpringNetwork& n) {
         n.solids[0].edges[1] = {1, 1};
       },
       "edge 1 of solid 0 has the corner 1 twice"},
      {[](SpringNetwork& n) { std::swap(n.solids[0].tetrahedra[2][0], n.solids[0].tetrahedra[2][1]); },
       "tetrahedron 2 of solid 0"},
      {[](SpringNetwork& n) { n.rest[5] = n.rest[4]; }, "tetrahedron"},
  };
  SpringNetwork sound = support::lattice_network({2, 1, 1, 3, {}});
  sound.areas.push_back({{0, 1, 2}, 2.0, 1.0});
  ASSERT_TRUE(static_cast<bool>(validate(sound)));
  for (const Case& c : cases) {
    SpringNetwork network = sound;
    c.damage(network);
    const auto checked = validate(network);
    ASSERT_FALSE(static_cast<bool>(checked)) << c.says;
    EXPECT_NE(checked.error().message().find(c.says), std::string::npos) << checked.error().message();
  }
}

}  // namespace
}  // namespace turgor
