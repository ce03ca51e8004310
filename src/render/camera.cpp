#include "turgor/render/camera.hpp"

#include <algorithm>
#include <cmath>

namespace turgor {
namespace {

struct Axes {
  Vec3 forward, up;
};

Axes axes_of(StandardView view) {
  // Half a turn of the head would show the profile; three-quarter views stop at 40°, where the far eye still
  // shows.
  const double s = std::sin(radians(40)), c = std::cos(radians(40));
  switch (view) {
    case StandardView::front:
      return {{0, 1, 0}, {0, 0, 1}};
    case StandardView::back:
      return {{0, -1, 0}, {0, 0, 1}};
    case StandardView::profile_left:
      return {{-1, 0, 0}, {0, 0, 1}};
    case StandardView::profile_right:
      return {{1, 0, 0}, {0, 0, 1}};
    case StandardView::three_quarter_left:
      return {{-s, c, 0}, {0, 0, 1}};
    case StandardView::three_quarter_right:
      return {{s, c, 0}, {0, 0, 1}};
    case StandardView::top:
      return {{0, 0, -1}, {0, 1, 0}};
    case StandardView::below:
      return {{0, 0, 1}, {0, -1, 0}};
  }
  return {{0, 1, 0}, {0, 0, 1}};
}

/// Half the extent, along the unit vector `axis`, of the rounded body that fills the box (the superellipsoid
/// of exponent 4; its support function has the dual exponent 4/3). Along the box's own axes this is the box;
/// at a slant a head would look lost in the frame of the box's corners, which it does not reach.
double half_extent(const Vec3& size, const Vec3& axis) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += std::pow(0.5 * std::abs(axis[k]) * size[k], 4.0 / 3.0);
  return std::pow(sum, 0.75);
}

}  // namespace

CameraView standard_view(StandardView view, const Box3& box) {
  const Axes axes = axes_of(view);
  const Vec3 centre = box.empty() ? Vec3{} : box.centre();
  const Vec3 size = box.empty() ? Vec3{100, 100, 100} : box.size();
  constexpr double least_aspect = 0.9, margin = 1.06;
  const double tall = half_extent(size, axes.up);
  const double wide = half_extent(size, cross(axes.forward, axes.up)) / least_aspect;
  CameraView camera;
  camera.target = centre;
  camera.up = axes.up;
  camera.height_mm = std::max(2 * margin * std::max(tall, wide), 1e-3);
  camera.eye = centre - axes.forward * (length(size) + 1000);
  return camera;
}

CameraView in_perspective(CameraView camera, double fov_deg) {
  const double height = camera.fov_deg > 0
                            ? 2 * distance(camera.eye, camera.target) * std::tan(radians(camera.fov_deg) / 2)
                            : camera.height_mm;
  const Vec3 back = normalized(camera.eye - camera.target);
  camera.height_mm = height;
  camera.fov_deg = fov_deg;
  camera.eye = camera.target + back * (height / 2 / std::tan(radians(fov_deg) / 2));
  return camera;
}

double CameraFrame::pixel_mm(double depth, int image_height) const {
  const double span = fov_deg > 0 ? 2 * depth * std::tan(radians(fov_deg) / 2) : height_mm;
  return span / std::max(image_height, 1);
}

Result<CameraFrame> camera_frame(const CameraView& camera) {
  const auto bad = [](std::string what, std::string remedy) {
    return Error{ErrorKind::bad_input, std::move(what), "camera", std::move(remedy)};
  };
  if (!is_finite(camera.eye) || !is_finite(camera.target) || !is_finite(camera.up))
    return bad("eye, target or up is not a finite number", "Give three finite coordinates each");
  CameraFrame frame;
  frame.eye = camera.eye;
  frame.target_distance = distance(camera.eye, camera.target);
  if (!(frame.target_distance > 1e-9)) return bad("the eye lies on the target", "Move one of them");
  if (!(camera.fov_deg >= 0 && camera.fov_deg < 170))
    return bad("the opening angle is not in [0, 170) degrees", "Use 0 for an orthographic view");
  if (camera.fov_deg == 0 && !(camera.height_mm > 0 && std::isfinite(camera.height_mm)))
    return bad("the height of the view is not above 0 mm", "Give the height of the picture in mm");
  frame.fov_deg = camera.fov_deg;
  frame.height_mm = camera.fov_deg > 0 ? 2 * frame.target_distance * std::tan(radians(camera.fov_deg) / 2)
                                       : camera.height_mm;
  frame.forward = (camera.target - camera.eye) / frame.target_distance;
  Vec3 right = cross(frame.forward, normalized(camera.up));
  if (length(right) < 1e-6) right = any_orthogonal(frame.forward);
  frame.right = normalized(right);
  frame.up = cross(frame.right, frame.forward);
  return frame;
}

std::optional<PicturePoint> project(const CameraView& camera, int width, int height, const Vec3& point) {
  const auto frame = camera_frame(camera);
  if (!frame) return std::nullopt;
  const Vec3 d = point - frame->eye;
  const double depth = dot(d, frame->forward);
  if (frame->fov_deg > 0 && !(depth > 1e-9)) return std::nullopt;
  const double mm = frame->pixel_mm(depth, height);
  return PicturePoint{0.5 * width + dot(d, frame->right) / mm, 0.5 * height - dot(d, frame->up) / mm, depth};
}

}  // namespace turgor
