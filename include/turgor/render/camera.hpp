// Where a picture is taken from, and where a point of the patient falls in it.
#pragma once

#include <optional>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

/// Orthographic where fov_deg is 0.
struct CameraView {
  Vec3 eye, target;
  Vec3 up{0, 0, 1};
  double fov_deg = 0;      ///< vertical opening angle, degrees, below 170
  double height_mm = 280;  ///< of the picture at the target, orthographic
};

enum class StandardView {
  front,
  three_quarter_left,
  three_quarter_right,
  profile_left,
  profile_right,
  back,
  top,
  below
};

/// A view of the whole box from the patient's named side ("profile_right" shows the right cheek),
/// orthographic, for a picture whose width is at least 0.9 of its height; three-quarter views fit a rounded
/// body in the box and may cut its corners. Front, top and below show the patient's left (+x) on the
/// picture's right; top has the nose at the bottom of the picture, below ("worm's eye") at its top.
CameraView standard_view(StandardView view, const Box3& box);

/// The same view through a lens of the given vertical opening angle (degrees, above 0 and below 170): the eye
/// moves along its line of sight so that the picture's height at the target stays.
CameraView in_perspective(CameraView camera, double fov_deg);

/// The axes of a camera, unit vectors: to the picture's right, up, and away from the viewer.
struct CameraFrame {
  Vec3 eye, right, up, forward;
  double target_distance = 1;  ///< mm
  double fov_deg = 0;
  double height_mm = 280;  ///< of the picture at the target, also in perspective

  /// mm that one pixel spans at `depth` mm from the eye in a picture `image_height` pixels high.
  [[nodiscard]] double pixel_mm(double depth, int image_height) const;
};
/// Errors: not finite, eye on the target, fov outside [0, 170), height not above 0. An `up` along the line of
/// sight is replaced by another one.
Result<CameraFrame> camera_frame(const CameraView& camera);

struct PicturePoint {
  double x = 0,
         y = 0;  ///< pixels from the top left corner of the picture; pixel (i, j) covers [i, i+1) × [j, j+1)
  double depth = 0;  ///< mm in front of the eye
};
/// Nothing for a camera without a frame, or a point not in front of a perspective camera.
std::optional<PicturePoint> project(const CameraView& camera, int width, int height, const Vec3& point);

}  // namespace turgor
