// A body made ready for tracing and shading.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/render/ray_tracer.hpp"

namespace turgor::render_detail {

struct Surface {
  Material material;
  std::vector<Vec3f> points;  ///< relative to the renderer's origin, so that floats hold 1e-5 mm
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Vec3f> corner_normals;  ///< three a triangle; split along creases
  std::vector<float> curvature;       ///< mean curvature per point, 1/mm, positive where convex
  std::vector<Vec3f> colours;         ///< per point, or empty
};

/// `number` names the body in errors (from 1).
Result<Surface> prepare_surface(const Body& body, std::size_t number, const Vec3& origin);

}  // namespace turgor::render_detail
