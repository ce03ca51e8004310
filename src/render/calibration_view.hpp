// One camera for all pictures of a calibration, and pictures beside each other with their legend. Internal to
// render.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turgor/render/annotate.hpp"
#include "turgor/render/camera.hpp"
#include "turgor/render/colour_map.hpp"
#include "turgor/render/image.hpp"

namespace turgor::render_detail {

/// Orthographic, from the side `to_viewer`, all points within a picture of these sides.
CameraView camera_about(std::span<const Vec3> points, const Vec3& to_viewer, int width, int height);

/// Height of letters that stay readable where pictures stand two in a row.
int letters(const Image& panel);
/// The picture with a line of text below.
Image captioned(const Image& image, const std::string& caption);
/// The picture with a strip at its right that holds the legend, in letters of `size` pixels.
Image with_legend(const Image& image, double low, double high, const std::string& title, ColourMap map,
                  int size);

/// An arrow that ends at `tip`, drawn over everything; `length_mm` long.
void draw_arrow(Image& image, const CameraView& camera, const Vec3& tip, const Vec3& along, double length_mm,
                const Vec3f& colour);

/// The next of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten from `greatest` up: a legend that reads well.
double round_up(double greatest);

}  // namespace turgor::render_detail
