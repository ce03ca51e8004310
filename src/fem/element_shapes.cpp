#include "fem/element_shapes.hpp"

#include <cmath>

#include "turgor/core/index.hpp"

namespace turgor::detail {
namespace {

// Shape functions and their derivatives in the element's own coordinates, and the weight of the point.
struct Local {
  double weight = 1;
  std::array<double, 8> shape{};
  std::array<Vec3, 8> derivative{};
};

const double kGauss = 1 / std::sqrt(3.0);

Local hexahedron_at(const Vec3& xi) {
  constexpr int signs[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                               {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  Local local;
  for (std::size_t n = 0; n < 8; ++n) {
    const Vec3 s{static_cast<double>(signs[n][0]), static_cast<double>(signs[n][1]),
                 static_cast<double>(signs[n][2])};
    const Vec3 f{1 + s.x * xi.x, 1 + s.y * xi.y, 1 + s.z * xi.z};
    local.shape[n] = f.x * f.y * f.z / 8;
    local.derivative[n] = Vec3{s.x * f.y * f.z, f.x * s.y * f.z, f.x * f.y * s.z} / 8;
  }
  return local;
}

// x and y from 0 to 1 − x in the triangle, z from −1 to 1 across.
Local prism_at(const Vec3& xi) {
  const double area[3] = {1 - xi.x - xi.y, xi.x, xi.y};
  constexpr double along_x[3] = {-1, 1, 0}, along_y[3] = {-1, 0, 1};
  Local local;
  local.weight = 1.0 / 6;
  for (std::size_t n = 0; n < 6; ++n) {
    const double sign = n < 3 ? -1 : 1, f = 0.5 * (1 + sign * xi.z);
    local.shape[n] = area[n % 3] * f;
    local.derivative[n] = {along_x[n % 3] * f, along_y[n % 3] * f, area[n % 3] * 0.5 * sign};
  }
  return local;
}

Local tetrahedron_at_centre() {
  Local local;
  local.weight = 1.0 / 6;
  local.shape = {0.25, 0.25, 0.25, 0.25};
  local.derivative = {Vec3{-1, -1, -1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  return local;
}

// For the corners of one element: its Jacobian, and the gradients in space.
GaussPoint in_space(const Local& local, std::span<const Vec3> corners) {
  Mat3 jacobian{{Vec3{}, Vec3{}, Vec3{}}};  // column j: ∂x/∂ξ_j
  for (std::size_t n = 0; n < corners.size(); ++n)
    for (int j = 0; j < 3; ++j) jacobian.c[at(j)] += corners[n] * local.derivative[n][j];
  const double determinant = jacobian.determinant();
  GaussPoint point;
  point.volume = local.weight * determinant;
  point.shape = local.shape;
  const Vec3 across[3] = {cross(jacobian.c[1], jacobian.c[2]) / determinant,
                          cross(jacobian.c[2], jacobian.c[0]) / determinant,
                          cross(jacobian.c[0], jacobian.c[1]) / determinant};
  for (std::size_t n = 0; n < corners.size(); ++n)
    for (int j = 0; j < 3; ++j) point.gradient[n] += across[j] * local.derivative[n][j];
  return point;
}

}  // namespace

void add_gauss_points(std::span<const Vec3> corners, std::vector<GaussPoint>& points) {
  const auto add = [&](const Local& local) { points.push_back(in_space(local, corners)); };
  if (corners.size() == 4) {
    add(tetrahedron_at_centre());
  } else if (corners.size() == 6) {
    constexpr double near = 1.0 / 6, far = 2.0 / 3;
    for (const double z : {-kGauss, kGauss})
      for (const auto& [x, y] : {std::pair{near, near}, std::pair{far, near}, std::pair{near, far}})
        add(prism_at({x, y, z}));
  } else {
    for (const double z : {-kGauss, kGauss})
      for (const double y : {-kGauss, kGauss})
        for (const double x : {-kGauss, kGauss}) add(hexahedron_at({x, y, z}));
  }
}

}  // namespace turgor::detail
