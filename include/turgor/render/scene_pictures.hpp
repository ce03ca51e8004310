// A scene's screen as a picture: every visible viewport, shaded or in wires, in stereo, one over another.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/render/image.hpp"
#include "turgor/world/scene.hpp"

namespace turgor {

struct ScenePictureOptions {
  int samples = 8;        ///< rays a pixel at edges
  int curved_levels = 2;  ///< of subdivision for curved objects
  /// Thickness of lines (tissue springs, wires) in pixels at the target and beyond.
  double line_pixels = 1.5;
};
/// Solid objects are ray traced with their optics; lines of polyhedra and wires stand in space as thin round
/// rods in their own colour, without light or shadow, so that surfaces hide them. Edges are drawn in the
/// wire's colour, in wire style else in the diffuse one; those of a curved object's own polygons over its
/// smooth surface. Without a lamp in the world, two of a studio turn with the camera. Objects that a world
/// names and that do not exist are left out. Errors: a viewport whose camera or world does not exist or whose
/// sides are not finite, a picture too large, an object whose numbers cannot be drawn.
Result<Image> draw_screen(const Scene& scene, const ScenePictureOptions& options, Context& context);

/// Frames written one by one and, where the program ffmpeg is present, joined to an MP4.
class Movie {
 public:
  /// Frames go to `folder`/frame_0000.png and on.
  static Result<Movie> create(std::filesystem::path folder);
  /// Errors: a frame of another size than the first one; it cannot be written.
  Result<void> add(const Image& frame);
  [[nodiscard]] int frames() const { return frames_; }
  /// Joins the frames to `file` (H.264, yuv420p) at `frames_per_second`: the whole file or none. False where
  /// ffmpeg is not present. Errors: ffmpeg fails (its last line); no frames; a rate outside 1 to 1000.
  Result<bool> encode(const std::filesystem::path& file, int frames_per_second, Context& context) const;

 private:
  std::filesystem::path folder_;
  int frames_ = 0, width_ = 0, height_ = 0;
};

}  // namespace turgor
