// The triangles of the 256 ways in which a cell's corners can lie inside or outside a level.
#pragma once

#include <array>
#include <cstdint>

namespace turgor::detail {

/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2 & 1). Edge e runs along axis e / 4; its place on the
/// other two axes, lower axis first, is (e & 1, e >> 1 & 1).
struct MarchingCase {
  std::uint8_t triangles = 0;
  /// Edges on which the corners of the triangles lie, three a triangle, anticlockwise seen from the outside
  /// corners.
  std::array<std::uint8_t, 15> edges{};
};
using MarchingTable = std::array<MarchingCase, 256>;

/// Case number: bit c is set where corner c is inside. Marching cubes (Lorensen and Cline 1987) with one rule
/// on every face in place of a hand-made table: crossings are joined such that on a face with two inside
/// corners at opposite ends these are kept apart. Both cells at a face see the same four corners, so their
/// segments agree. The loops of segments are cut into triangles without a diagonal that lies on a face.
const MarchingTable& marching_table();

}  // namespace turgor::detail
