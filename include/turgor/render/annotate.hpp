// Words, scales and lines on a picture. All of these draw anti-aliased and cut off at the picture's edges.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "turgor/render/camera.hpp"
#include "turgor/render/colour_map.hpp"
#include "turgor/render/image.hpp"

namespace turgor {

/// Text with its top left corner at (x, y); 'size' pixels high. UTF-8; printable ASCII and ° ′ ″ ± µ × · –
/// are known, others show as a box. Nothing is drawn outside text_width(text, size) × size pixels.
void draw_text(Image& image, int x, int y, int size, const std::string& text,
               const Vec3f& colour = {0, 0, 0});
/// The same on a soft rim of the other colour, two pixels wide, that keeps it readable on any ground.
void draw_text_with_halo(Image& image, int x, int y, int size, const std::string& text, const Vec3f& colour,
                         const Vec3f& halo = {1, 1, 1});
/// Pixels, rounded up.
int text_width(std::string_view text, int size);

/// A straight line of `width` pixels between picture points.
void draw_segment(Image& image, double x0, double y0, double x1, double y1, double width, const Vec3f& colour,
                  double opacity = 1);
/// A filled disc.
void draw_disc(Image& image, double x, double y, double radius, const Vec3f& colour, double opacity = 1);
/// The projection of a line through `points` (mm), drawn over everything.
void draw_polyline(Image& image, const CameraView& camera, const std::vector<Vec3>& points, double width,
                   const Vec3f& colour, double opacity = 1);

/// A rectangle of pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
};
/// Draws a vertical colour bar with ticks and a title at the right edge; returns where the bar is.
PixelBox draw_legend(Image& image, double lowest, double highest, const std::string& title);
/// The same with any colour map; letters of `size` pixels, 0: as the picture's height asks for.
PixelBox draw_legend(Image& image, double lowest, double highest, const std::string& title, ColourMap map,
                     int size = 0);

/// A filled dot at the projection of `point`, with a label beside it.
void draw_marker(Image& image, const CameraView& camera, const Vec3& point, const std::string& label,
                 const Vec3f& colour);
struct Marker {
  Vec3 point;
  std::string label;
  Vec3f colour{0.8f, 0.05f, 0.05f};
};
/// Many at once: labels stand in columns at the left and right edge without touching one another, with leader
/// lines.
void draw_markers(Image& image, const CameraView& camera, const std::vector<Marker>& markers);

/// A bar of a round number of millimetres at the bottom left; for orthographic views (in perspective it holds
/// at the target only). Letters of `size` pixels, 0: as the picture's height asks for.
void draw_scale_bar(Image& image, const CameraView& camera, int size = 0);
/// R and L (or A and P, S and I) in the upper corners: the patient's sides as this camera sees them, the main
/// one first where a view lies between.
void draw_orientation(Image& image, const CameraView& camera);

/// Pictures side by side in `columns` columns, each under its caption (captions may be fewer), on
/// `background`.
Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions, int columns,
                   const Vec3f& background = {1, 1, 1});

}  // namespace turgor
