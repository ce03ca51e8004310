// What every solid must hold.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <utility>
#include <vector>

#include "turgor/core/index.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor::test {

/// Every face inside belongs to exactly two tetrahedra that lie on opposite sides; the others are the
/// surface.
inline void expect_conforming(const SolidMesh& solid) {
  constexpr int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  struct Use {
    int count = 0, turn = 0, cell = 0;
  };
  std::map<Index3, Use> uses;
  const auto turn_of = [](Index3& f) {
    int turn = 1;
    for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 1}})
      if (f[at(a)] > f[at(b)]) std::swap(f[at(a)], f[at(b)]), turn = -turn;
    return turn;
  };
  for (std::size_t t = 0; t < solid.tetrahedra.size(); ++t) {
    for (const auto& f : faces) {
      Index3 key{};
      for (std::size_t n = 0; n < 3; ++n) key[n] = solid.tetrahedra[t][at(f[n])];
      const int turn = turn_of(key);
      Use& use = uses[key];
      ++use.count, use.turn += turn, use.cell = static_cast<int>(t);
    }
  }
  std::size_t bare = 0;
  for (const auto& [face, use] : uses) {
    ASSERT_LE(use.count, 2);
    if (use.count == 2) {
      ASSERT_EQ(use.turn, 0);
    }
    bare += use.count == 1 ? 1 : 0;
  }
  ASSERT_EQ(bare, solid.surface_triangles.size());
  std::vector<std::uint8_t> on_surface(solid.points.size());
  for (std::size_t t = 0; t < bare; ++t) {
    Index3 key = solid.surface_triangles[t];
    for (const int p : key) on_surface[at(p)] = 1;
    const int turn = turn_of(key);
    const auto use = uses.find(key);
    ASSERT_NE(use, uses.end());
    ASSERT_EQ(use->second.count, 1);
    ASSERT_EQ(use->second.turn, turn);
    ASSERT_EQ(use->second.cell, solid.surface_cells[t]);
  }
  EXPECT_TRUE(on_surface == solid.on_surface);
}

}  // namespace turgor::test
