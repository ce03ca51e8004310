// Small bodies and pixel readers for the tests of pictures.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "turgor/render/ray_tracer.hpp"

namespace turgor::render_tests {

/// A box with two triangles a face, normals outwards.
inline TriMesh box_mesh(const Vec3& lower, const Vec3& upper) {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.points.push_back({i & 1 ? upper.x : lower.x, i & 2 ? upper.y : lower.y, i & 4 ? upper.z : lower.z});
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

/// A square in the plane y = `y`, facing the front (-y).
inline TriMesh plate_mesh(double half, double y) {
  return {{{-half, y, -half}, {half, y, -half}, {half, y, half}, {-half, y, half}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// An octahedron split `levels` times, on the sphere.
inline TriMesh sphere_mesh(const Vec3& centre, double radius, int levels) {
  TriMesh mesh{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
               {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, fresh] =
          middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(mesh.points.size()));
      if (fresh)
        mesh.points.push_back(
            normalized(mesh.points[static_cast<std::size_t>(a)] + mesh.points[static_cast<std::size_t>(b)]));
      return at->second;
    };
    std::vector<Index3> finer;
    for (const Index3& t : mesh.triangles) {
      const int a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
      finer.insert(finer.end(), {{t[0], a, c}, {t[1], b, a}, {t[2], c, b}, {a, b, c}});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3& p : mesh.points) p = centre + p * radius;
  return mesh;
}

inline Box3 cube_box(double half) {
  return {{-half, -half, -half}, {half, half, half}};
}

inline std::array<int, 3> bytes_at(const Image& image, int x, int y) {
  const auto at =
      3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
  return {image.rgb[at], image.rgb[at + 1], image.rgb[at + 2]};
}

inline Vec3f linear_at(const Image& image, int x, int y) {
  const auto b = bytes_at(image, x, y);
  return {decode_srgb(static_cast<std::uint8_t>(b[0])), decode_srgb(static_cast<std::uint8_t>(b[1])),
          decode_srgb(static_cast<std::uint8_t>(b[2]))};
}

/// Where the pixels that `chosen` accepts lie on average, and how many they are.
struct Blob {
  double x = 0, y = 0;
  int count = 0;
};
template <class Chosen>
Blob blob(const Image& image, Chosen&& chosen) {
  Blob out;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (chosen(bytes_at(image, x, y))) out.x += x + 0.5, out.y += y + 0.5, ++out.count;
  if (out.count > 0) out.x /= out.count, out.y /= out.count;
  return out;
}
inline bool is_white(const std::array<int, 3>& c) {
  return c[0] == 255 && c[1] == 255 && c[2] == 255;
}
inline bool is_red(const std::array<int, 3>& c) {
  return c[0] > c[1] + 60 && c[0] > c[2] + 60;
}
inline bool is_blue(const std::array<int, 3>& c) {
  return c[2] > c[0] + 60 && c[2] > c[1] + 60;
}

inline constexpr Vec3f red{0.8f, 0.02f, 0.02f}, blue{0.02f, 0.02f, 0.8f};

inline Body plain_body(const TriMesh& mesh, const Vec3f& colour, double opacity = 1) {
  return {&mesh, {MaterialKind::plain, colour, opacity}, {}};
}

}  // namespace turgor::render_tests
