#include "render/scene/rods.hpp"

#include <numbers>

namespace turgor::render_detail {
namespace {

constexpr int sides = 6;

/// An open prism: rods show their colour without light, and so the inside of an end looks like its lid.
void add_rod(TriMesh& mesh, const Vec3& a, const Vec3& b, double radius_a, double radius_b) {
  const Vec3 along = normalized(b - a);
  if (!(length(along) > 0.5)) return;
  const Vec3 u = any_orthogonal(along), v = cross(along, u);
  const int first = static_cast<int>(mesh.points.size());
  static const auto corners = [] {
    std::array<std::array<double, 2>, sides> c{};
    for (std::size_t k = 0; k < c.size(); ++k) {
      const double angle = 2 * std::numbers::pi * static_cast<double>(k) / sides;
      c[k] = {std::cos(angle), std::sin(angle)};
    }
    return c;
  }();
  for (const auto& [c, s] : corners) mesh.points.push_back(a + (u * c + v * s) * radius_a);
  for (const auto& [c, s] : corners) mesh.points.push_back(b + (u * c + v * s) * radius_b);
  for (int k = 0; k < sides; ++k) {
    const int here = first + k, next = first + (k + 1) % sides;
    mesh.triangles.push_back({here, next, next + sides});
    mesh.triangles.push_back({here, next + sides, here + sides});
  }
}

}  // namespace

void RodSet::add(std::span<const Vec3> points, std::span<const Edge> segments, const Vec3f& colour,
                 double width) {
  if (segments.empty()) return;
  TriMesh& mesh = meshes_[{colour.x, colour.y, colour.z}];
  for (const Edge& e : segments) {
    const Vec3 &a = points[static_cast<std::size_t>(e[0])], &b = points[static_cast<std::size_t>(e[1])];
    add_rod(mesh, a, b, width * radius_at(a), width * radius_at(b));
  }
}

}  // namespace turgor::render_detail
