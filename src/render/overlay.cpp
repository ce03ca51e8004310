// Lines, dots and labels at places of the patient.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "render/canvas.hpp"
#include "turgor/render/annotate.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr Vec3f white{1, 1, 1};

PixelRect whole(const Image& image) {
  return {0, 0, image.width, image.height};
}

int label_size(const Image& image) {
  return std::clamp(image.height / 55, 12, 32);
}

double dot_radius(const Image& image) {
  return std::clamp(image.height / 240.0, 2.5, 8.0);
}

void draw_dot(Image& image, double x, double y, const Vec3f& colour) {
  const double r = dot_radius(image);
  draw_disc(image, x, y, r + 1.3, white, 0.95);
  draw_disc(image, x, y, r, colour);
}

/// Pushes labels apart along y, keeping their order and staying within [top, bottom] where they fit.
void spread(std::vector<double>& y, double spacing, double top, double bottom) {
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::max(y[i], i == 0 ? top : y[i - 1] + spacing);
  for (std::size_t i = y.size(); i-- > 0;)
    y[i] = std::min(y[i], i + 1 == y.size() ? bottom : y[i + 1] - spacing);
}

struct PlacedMarker {
  const Marker* marker;
  PicturePoint at;
};

void draw_column(Image& image, std::vector<PlacedMarker> column, bool left) {
  const int size = label_size(image), margin = size;
  std::stable_sort(column.begin(), column.end(),
                   [](const PlacedMarker& a, const PlacedMarker& b) { return a.at.y < b.at.y; });
  std::vector<double> y;
  y.reserve(column.size());
  for (const PlacedMarker& m : column) y.push_back(m.at.y);
  spread(y, 1.25 * size, 4.0 * size, image.height - 4.0 * size);
  const double base = 0.407 * size;  // of a label's middle below its top
  for (std::size_t i = 0; i < column.size(); ++i) {
    const Marker& m = *column[i].marker;
    const int wide = text_width(m.label, size);
    const double end = left ? margin + wide + 4 : image.width - margin - wide - 4;
    draw_segment(image, end, y[i], column[i].at.x, column[i].at.y, 3, white, 0.7);
    draw_segment(image, end, y[i], column[i].at.x, column[i].at.y, 1.1, m.colour, 0.9);
  }
  for (std::size_t i = 0; i < column.size(); ++i) {
    const Marker& m = *column[i].marker;
    draw_dot(image, column[i].at.x, column[i].at.y, m.colour);
    draw_text_with_halo(image, left ? margin : image.width - margin - text_width(m.label, size),
                        static_cast<int>(std::lround(y[i] - base)), size, m.label, {0, 0, 0});
  }
}

/// The letters of the patient's sides that `direction` points to, the main one first (as in DICOM
/// (0020,0020)).
std::string side_letters(const Vec3& direction) {
  static constexpr std::array<std::array<const char*, 2>, 3> letters{{{"R", "L"}, {"A", "P"}, {"I", "S"}}};
  std::array<int, 3> order{0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return std::abs(direction[a]) > std::abs(direction[b]); });
  std::string out;
  for (const int axis : order)
    if (std::abs(direction[axis]) > 0.35) out += letters[static_cast<std::size_t>(axis)][direction[axis] > 0];
  return out;
}

}  // namespace

void draw_segment(Image& image, double x0, double y0, double x1, double y1, double width, const Vec3f& colour,
                  double opacity) {
  draw_capsules(image, {{x0, y0, x1, y1}}, width / 2, 1, whole(image), colour, opacity);
}

void draw_disc(Image& image, double x, double y, double radius, const Vec3f& colour, double opacity) {
  draw_capsules(image, {{x, y, x, y}}, radius, 1, whole(image), colour, opacity);
}

void draw_polyline(Image& image, const CameraView& camera, const std::vector<Vec3>& points, double width,
                   const Vec3f& colour, double opacity) {
  std::vector<Capsule> line;
  std::optional<PicturePoint> last;
  for (const Vec3& p : points) {
    const auto next = project(camera, image.width, image.height, p);
    if (next && last) line.push_back({last->x, last->y, next->x, next->y});
    last = next;
  }
  draw_capsules(image, line, width / 2, 1, whole(image), colour, opacity);
}

void draw_marker(Image& image, const CameraView& camera, const Vec3& point, const std::string& label,
                 const Vec3f& colour) {
  const auto at = project(camera, image.width, image.height, point);
  if (!at) return;
  draw_dot(image, at->x, at->y, colour);
  if (label.empty()) return;
  const int size = label_size(image), wide = text_width(label, size);
  const double gap = dot_radius(image) + 4;
  const bool fits = at->x + gap + wide < image.width;
  const int x = static_cast<int>(std::lround(fits ? at->x + gap : at->x - gap - wide));
  draw_text_with_halo(image, x, static_cast<int>(std::lround(at->y - 0.407 * size)), size, label, {0, 0, 0});
}

void draw_markers(Image& image, const CameraView& camera, const std::vector<Marker>& markers) {
  std::vector<PlacedMarker> placed;
  for (const Marker& m : markers)
    if (const auto at = project(camera, image.width, image.height, m.point)) placed.push_back({&m, *at});
  if (placed.empty()) return;
  std::stable_sort(placed.begin(), placed.end(),
                   [](const PlacedMarker& a, const PlacedMarker& b) { return a.at.x < b.at.x; });
  const auto middle = placed.begin() + static_cast<std::ptrdiff_t>(placed.size() / 2);
  draw_column(image, {placed.begin(), middle}, true);
  draw_column(image, {middle, placed.end()}, false);
}

void draw_orientation(Image& image, const CameraView& camera) {
  const auto frame = camera_frame(camera);
  if (!frame) return;
  const int size = std::clamp(image.height / 36, 14, 48), margin = size / 2;
  const int y = margin;
  const std::string at_left = side_letters(-frame->right), at_right = side_letters(frame->right);
  draw_text_with_halo(image, margin, y, size, at_left, {0.25f, 0.25f, 0.25f});
  draw_text_with_halo(image, image.width - margin - text_width(at_right, size), y, size, at_right,
                      {0.25f, 0.25f, 0.25f});
}

Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions, int columns,
                   const Vec3f& background) {
  if (images.empty()) return filled_image(1, 1, background);
  columns = std::clamp(columns, 1, static_cast<int>(images.size()));
  int width = 1, height = 1;
  for (const Image& i : images) width = std::max(width, i.width), height = std::max(height, i.height);
  const int size = captions.empty() ? 0 : std::clamp(height / 36, 14, 40),
            cell = height + (captions.empty() ? 0 : 2 * size);
  const int rows = (static_cast<int>(images.size()) + columns - 1) / columns;
  Image out = filled_image(columns * width, rows * cell, background);
  for (std::size_t i = 0; i < images.size(); ++i) {
    const int x = static_cast<int>(i) % columns * width, y = static_cast<int>(i) / columns * cell;
    paste(out, images[i], x + (width - images[i].width) / 2, y + (height - images[i].height) / 2);
    if (i >= captions.size()) continue;
    const Vec3f ink = luminance(background) > 0.2f ? Vec3f{0, 0, 0} : white;
    draw_text(out, x + (width - text_width(captions[i], size)) / 2, y + height + size / 2, size, captions[i],
              ink);
  }
  return out;
}

}  // namespace turgor
