// Pictures of surfaces by ray tracing on the CPU: no display, no GPU.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 bytes a pixel (sRGB), rows from the top
};
Result<void> write_png(const std::filesystem::path& path, const Image& image);
std::vector<std::byte> encode_png(const Image& image);

enum class MaterialKind { skin, bone, teeth, mucosa, plain };
struct Material {
  MaterialKind kind = MaterialKind::plain;
  Vec3f colour{0.8f, 0.8f, 0.8f};  ///< linear RGB; used by `plain` and where point colours are absent
  double opacity = 1.0;
};

struct Body {
  const TriMesh* mesh = nullptr;
  Material material;
  std::vector<Vec3f> point_colours;  ///< empty, or linear RGB per point (overrides the material's colour)
};

/// Orthographic where fov_deg is 0.
struct CameraView {
  Vec3 eye, target;
  Vec3 up{0, 0, 1};
  double fov_deg = 0;
  double height_mm = 280;  ///< of the picture at the target, orthographic
};
enum class StandardView { front, three_quarter_left, three_quarter_right, profile_left, profile_right, back, top, below };
/// A view of the whole box from the patient's named side ("profile_right" shows the right cheek).
CameraView standard_view(StandardView view, const Box3& box);

struct RenderOptions {
  int width = 900, height = 1000;
  int samples = 16;          ///< rays a pixel
  Vec3f background{1, 1, 1};
  std::uint64_t seed = 1;
};
/// The same bits for any number of threads.
Result<Image> render(const std::vector<Body>& bodies, const CameraView& camera, const RenderOptions& options,
                     Context& context);

/// A perceptually uniform colour map (viridis), t in [0, 1], linear RGB.
Vec3f colour_map(double t);
/// Draws a vertical colour bar with ticks and a title at the right edge.
void draw_legend(Image& image, double lowest, double highest, const std::string& title);
/// Text with its top left corner at (x, y); 'size' pixels high.
void draw_text(Image& image, int x, int y, int size, const std::string& text, const Vec3f& colour = {0, 0, 0});
/// A filled dot at the projection of `point`, with a label beside it.
void draw_marker(Image& image, const CameraView& camera, const Vec3& point, const std::string& label,
                 const Vec3f& colour);

}  // namespace turgor
