#include "turgor/render/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "render/canvas.hpp"
#include "render/scale.hpp"
#include "turgor/render/annotate.hpp"

namespace turgor {

using namespace render_detail;

namespace {

constexpr Vec3f ink{0.012f, 0.012f, 0.015f}, axis_ink{0.06f, 0.06f, 0.065f}, grid_ink{0.78f, 0.79f, 0.8f};
constexpr int least_side = 160, largest_side = 8192;
/// Larger magnitudes count as not finite: their differences would not be numbers.
constexpr double largest_value = 1e300;

Error bad(std::string what, std::string where, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), std::move(where), std::move(remedy)};
}

bool usable(double v) {
  return std::abs(v) <= largest_value;  // false for NaN
}

struct PlotTick {
  double at;  ///< on the axis: of a logarithmic one the logarithm
  std::string label;
};

/// One axis made ready: its ends, its ticks, and the power of ten that its labels leave out.
struct Scale {
  double low = 0, high = 1;  ///< of a logarithmic axis the logarithms
  int exponent = 0;
  bool logarithmic = false;
  std::vector<PlotTick> ticks;

  [[nodiscard]] double share_at(double place) const { return (place - low) / (high - low); }
  [[nodiscard]] double share(double v) const { return share_at(logarithmic ? std::log10(v) : v); }
  [[nodiscard]] bool shows(double v) const { return usable(v) && (!logarithmic || v > 0); }
};

/// "0.05", "200", "2e-7".
std::string short_number(double v) {
  const double power = std::floor(std::log10(v) + 1e-9);
  if (power < -4 || power > 5) {
    const double unit = std::pow(10.0, power);
    return number(v / unit, 0) + "e" + number(power, 0);
  }
  return number(v, power < 0 ? static_cast<int>(-power) : 0);
}

struct Range {
  double low = largest_value, high = -largest_value;

  void extend(double v) { low = std::min(low, v), high = std::max(high, v); }
  [[nodiscard]] bool empty() const { return low > high; }
};

Result<Range> data_range(const Plot& plot, std::vector<double> Curve::*axis) {
  Range range;
  const auto shows = [](const Axis2& a, double v) { return usable(v) && (!a.logarithmic || v > 0); };
  for (const Curve& c : plot.curves)
    for (std::size_t i = 0; i < c.x.size(); ++i)
      if (shows(plot.x, c.x[i]) && shows(plot.y, c.y[i])) range.extend((c.*axis)[i]);
  if (range.empty())
    return bad("no curve has a point that is finite", "plot", "Draw curves with numbers in them");
  return range;
}

/// 1, 2 and 5 times the powers of ten from one below `low` to one above `high`.
std::vector<double> round_numbers(double low, double high) {
  std::vector<double> out;
  const int last = static_cast<int>(std::ceil(std::log10(high)));
  for (int power = static_cast<int>(std::floor(std::log10(low))); power <= last; ++power)
    for (const double digit : {1.0, 2.0, 5.0}) out.push_back(digit * std::pow(10.0, power));
  return out;
}

Result<Scale> logarithmic_scale(const Axis2& axis, const Range& range, const std::string& where) {
  if (!(range.low > 0)) return bad("a logarithmic axis begins at 0 or below", where, "Begin it above 0");
  constexpr double close = 1e-9;
  const std::vector<double> round = round_numbers(range.low, range.high);
  double low = range.low, high = range.high;
  for (const double v : round)
    if (!axis.low && v <= range.low * (1 + close)) low = v;
  for (const double v : std::vector<double>(round.rbegin(), round.rend()))
    if (!axis.high && v >= range.high * (1 - close)) high = v;
  Scale scale;
  scale.logarithmic = true;
  scale.low = std::log10(low), scale.high = std::log10(high);
  const double decades = scale.high - scale.low;
  for (std::size_t k = 0; k < round.size(); ++k) {
    if (round[k] < low * (1 - close) || round[k] > high * (1 + close)) continue;
    if (decades > 4 && k % 3 != 0) continue;  // powers of ten alone
    scale.ticks.push_back({std::log10(round[k]), short_number(round[k])});
  }
  return scale;
}

Result<Scale> make_scale(const Axis2& axis, Range range, int ticks, const std::string& where) {
  for (const auto& end : {axis.low, axis.high})
    if (end && !usable(*end)) return bad("the end of an axis is not a finite number", where, "Give a number");
  range.low = axis.low.value_or(range.low), range.high = axis.high.value_or(range.high);
  const double magnitude = std::max(std::abs(range.low), std::abs(range.high));
  if (!(range.high - range.low > 1e-9 * magnitude)) {
    if (axis.low && axis.high)
      return bad("the axis ends before it begins", where, "Give the low end first, then the high one");
    // One value, or an end beyond all data: some room about it.
    const double room = magnitude > 0 ? 0.1 * magnitude : 1;
    if (axis.low)
      range.high = range.low + room;
    else if (axis.high)
      range.low = range.high - room;
    else
      range.low -= room, range.high += room;
  }
  if (axis.logarithmic) return logarithmic_scale(axis, range, where);
  Scale scale;
  const double step = round_step(range.high - range.low, ticks);
  scale.low = axis.low.value_or(std::floor(range.low / step + 1e-6) * step);
  scale.high = axis.high.value_or(std::ceil(range.high / step - 1e-6) * step);
  const double power = std::floor(std::log10(std::max(std::abs(scale.low), std::abs(scale.high))) + 1e-9);
  if (power >= 5 || power <= -4) scale.exponent = static_cast<int>(power);
  const double unit = std::pow(10.0, scale.exponent);
  for (double k = std::ceil(scale.low / step - 1e-6); k <= std::floor(scale.high / step + 1e-6); ++k)
    scale.ticks.push_back({k * step, k == 0 ? "0" : number(k * step / unit, decimals_of(step / unit))});
  return scale;
}

/// Where the curves stand in the picture, and the sizes that follow from the picture's.
struct Layout {
  PixelRect box;
  int size = 20;      ///< of letters
  double line = 2.2;  ///< width of curves
  Scale x, y;

  [[nodiscard]] double pixel_x(double share) const { return box.x0 + share * (box.x1 - box.x0); }
  [[nodiscard]] double pixel_y(double share) const { return box.y1 - share * (box.y1 - box.y0); }
};

int widest_label(const Scale& scale, int size) {
  int widest = 0;
  for (const PlotTick& tick : scale.ticks) widest = std::max(widest, text_width(tick.label, size));
  return widest;
}

/// The part of a segment within the box (Liang and Barsky 1984): far ends would cost accuracy and time.
bool clip(Capsule& c, double x0, double y0, double x1, double y1) {
  double from = 0, to = 1;
  const double dx = c.x1 - c.x0, dy = c.y1 - c.y0;
  const std::array<std::array<double, 2>, 4> sides{
      {{-dx, c.x0 - x0}, {dx, x1 - c.x0}, {-dy, c.y0 - y0}, {dy, y1 - c.y0}}};
  for (const auto& [speed, room] : sides) {
    if (speed == 0 && room < 0) return false;
    if (speed < 0) from = std::max(from, room / speed);
    if (speed > 0) to = std::min(to, room / speed);
  }
  if (from > to) return false;
  c = {c.x0 + from * dx, c.y0 + from * dy, c.x0 + to * dx, c.y0 + to * dy};
  return true;
}

/// The strokes of a curve: its points as dots, or its segments between finite points.
std::vector<Capsule> strokes(const Curve& curve, const Layout& layout) {
  const double rim = 20;
  const PixelRect& b = layout.box;
  std::vector<Capsule> out;
  const auto add = [&](double x0, double y0, double x1, double y1) {
    Capsule c{x0, y0, x1, y1};
    if (clip(c, b.x0 - rim, b.y0 - rim, b.x1 + rim, b.y1 + rim)) out.push_back(c);
  };
  bool drawing = false;
  double last_x = 0, last_y = 0;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!layout.x.shows(curve.x[i]) || !layout.y.shows(curve.y[i])) {
      drawing = false;
      continue;
    }
    const double x = layout.pixel_x(layout.x.share(curve.x[i])),
                 y = layout.pixel_y(layout.y.share(curve.y[i]));
    if (curve.dots || !drawing)
      add(x, y, x, y);
    else
      add(last_x, last_y, x, y);
    drawing = true, last_x = x, last_y = y;
  }
  return out;
}

double pen_radius(const Curve& curve, const Layout& layout) {
  return curve.dots ? 1.45 * layout.line : layout.line / 2;
}

void draw_curve(Image& image, const Curve& curve, const std::vector<Capsule>& line, const Layout& layout) {
  // Strokes may stand over the axes by half their width, so that a curve along an edge is seen whole.
  const double radius = pen_radius(curve, layout);
  const int rim = static_cast<int>(std::ceil(radius)) + 1;
  const PixelRect& b = layout.box;
  draw_capsules(image, line, radius, 1, {b.x0 - rim, b.y0 - rim, b.x1 + rim, b.y1 + rim}, curve.colour, 1);
}

void rule(Image& image, double x0, double y0, double x1, double y1, double width, const Vec3f& colour) {
  // Lines along the pixel grid stand in the middle of pixels: crisp, not smeared over two.
  const auto middle = [](double v) { return std::floor(v) + 0.5; };
  draw_segment(image, middle(x0), middle(y0), middle(x1), middle(y1), width, colour);
}

/// A title, with the power of ten that the axis' labels leave out. Returns its width.
int draw_title(Image* image, int x, int y, int size, std::string text, int exponent) {
  if (exponent != 0) text += text.empty() ? "×10" : " (×10";
  const int wide = text_width(text, size);
  if (image) draw_text(*image, x, y, size, text, ink);
  if (exponent == 0) return wide;
  const int small = static_cast<int>(std::lround(0.72 * size));
  const std::string power = number(exponent, 0);
  const bool bracket = text.size() > 5;
  const int power_wide = text_width(power, small);
  if (image) {
    draw_text(*image, x + wide, y - size / 6, small, power, ink);
    if (bracket) draw_text(*image, x + wide + power_wide, y, size, ")", ink);
  }
  return wide + power_wide + (bracket ? text_width(")", size) : 0);
}

void draw_grid(Image& image, const Layout& l) {
  for (const PlotTick& tick : l.x.ticks) {
    const double x = l.pixel_x(l.x.share_at(tick.at));
    rule(image, x, l.box.y0, x, l.box.y1, 1, grid_ink);
  }
  for (const PlotTick& tick : l.y.ticks) {
    const double y = l.pixel_y(l.y.share_at(tick.at));
    rule(image, l.box.x0, y, l.box.x1, y, 1, grid_ink);
  }
}

void draw_axes(Image& image, const Plot& plot, const Layout& l) {
  const int tick = l.size / 3, gap = tick + l.size / 4;
  rule(image, l.box.x0, l.box.y0, l.box.x0, l.box.y1, 1.4, axis_ink);
  rule(image, l.box.x0, l.box.y1, l.box.x1, l.box.y1, 1.4, axis_ink);
  for (const auto& [at, label] : l.x.ticks) {
    const double x = l.pixel_x(l.x.share_at(at));
    rule(image, x, l.box.y1, x, l.box.y1 + tick, 1.4, axis_ink);
    draw_text(image, static_cast<int>(std::lround(x)) - text_width(label, l.size) / 2, l.box.y1 + gap, l.size,
              label, ink);
  }
  for (const auto& [at, label] : l.y.ticks) {
    const double y = l.pixel_y(l.y.share_at(at));
    rule(image, l.box.x0 - tick, y, l.box.x0, y, 1.4, axis_ink);
    draw_text(image, l.box.x0 - gap - text_width(label, l.size),
              static_cast<int>(std::lround(y - 0.407 * l.size)), l.size, label, ink);
  }
  const int wide = draw_title(nullptr, 0, 0, l.size, plot.x.title, l.x.exponent);
  draw_title(&image, (l.box.x0 + l.box.x1 - wide) / 2, l.box.y1 + gap + 3 * l.size / 2, l.size, plot.x.title,
             l.x.exponent);
  draw_title(&image, std::max(l.size / 2, l.box.x0 - widest_label(l.y, l.size) - gap),
             l.box.y0 - 17 * l.size / 10, l.size, plot.y.title, l.y.exponent);
  const int title_size = 6 * l.size / 5;
  draw_text(image, (l.box.x0 + l.box.x1 - text_width(plot.title, title_size)) / 2, l.size / 2, title_size,
            plot.title, ink);
}

/// How many strokes run through the rectangle.
int crossings(const std::vector<std::vector<Capsule>>& lines, const PixelRect& r) {
  int count = 0;
  for (const auto& line : lines)
    for (Capsule c : line) count += clip(c, r.x0, r.y0, r.x1, r.y1) ? 1 : 0;
  return count;
}

/// The corner of the box where the fewest curves run, the upper right one where they tie.
PixelRect legend_place(const Layout& l, const std::vector<std::vector<Capsule>>& lines, int wide, int high) {
  const int rim = l.size / 2;
  const int left = l.box.x0 + rim, right = std::max(left, l.box.x1 - rim - wide);
  const int top = l.box.y0 + rim, bottom = std::max(top, l.box.y1 - rim - high);
  PixelRect best;
  int fewest = -1;
  for (const auto& [x, y] : {std::pair{right, top}, {left, top}, {right, bottom}, {left, bottom}}) {
    const PixelRect place{x, y, x + wide, y + high};
    const int count = crossings(lines, place);
    if (fewest < 0 || count < fewest) best = place, fewest = count;
  }
  return best;
}

void draw_legend_box(Image& image, const Plot& plot, const Layout& l,
                     const std::vector<std::vector<Capsule>>& lines) {
  const int row = 7 * l.size / 5, sample = 2 * l.size, gap = l.size / 2;
  int widest = 0, count = 0;
  const int room = (l.box.y1 - l.box.y0 - l.size) / row;
  std::vector<const Curve*> listed;
  for (const Curve& c : plot.curves)
    if (!c.name.empty() && count < room) {
      listed.push_back(&c), ++count;
      widest = std::max(widest, text_width(c.name, l.size));
    }
  if (listed.empty()) return;
  const PixelRect place = legend_place(l, lines, sample + widest + 3 * gap, row * count + gap);
  fill_rect(image, place, {1, 1, 1}, 0.85);
  for (int i = 0; i < count; ++i) {
    const Curve& c = *listed[static_cast<std::size_t>(i)];
    const double y = place.y0 + gap / 2.0 + (i + 0.5) * row, x = place.x0 + gap;
    const Capsule line =
        c.dots ? Capsule{x + sample / 2.0, y, x + sample / 2.0, y} : Capsule{x, y, x + sample, y};
    draw_capsules(image, {line}, pen_radius(c, l), 1, place, c.colour, 1);
    draw_text(image, static_cast<int>(x) + sample + gap, static_cast<int>(std::lround(y - 0.407 * l.size)),
              l.size, c.name, ink);
  }
}

Result<void> check(const Plot& plot) {
  if (plot.width < least_side || plot.height < least_side || plot.width > largest_side ||
      plot.height > largest_side)
    return bad("a plot of " + std::to_string(plot.width) + " by " + std::to_string(plot.height) +
                   " pixels cannot be drawn",
               "plot", "Use sides from 160 to 8192 pixels");
  if (plot.curves.empty()) return bad("the plot has no curves", "plot", "Give at least one");
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    const Curve& c = plot.curves[i];
    const std::string where = "curve " + std::to_string(i + 1) + (c.name.empty() ? "" : " '" + c.name + "'");
    if (c.x.size() != c.y.size())
      return bad(std::to_string(c.x.size()) + " values along x do not match " + std::to_string(c.y.size()) +
                     " along y",
                 where, "Give as many of both");
    if (!is_finite(c.colour)) return bad("the colour is not a finite number", where, "Give linear RGB");
  }
  return {};
}

Result<Layout> lay_out(const Plot& plot) {
  Layout l;
  l.size = std::clamp(std::min(plot.height / 32, plot.width / 40), 10, 48);
  l.line = std::max(1.4, 0.115 * l.size);
  TURGOR_TRY(const Range x, data_range(plot, &Curve::x));
  TURGOR_TRY(const Range y, data_range(plot, &Curve::y));
  TURGOR_TRY(l.x, make_scale(plot.x, x, std::max(2, plot.width / (7 * l.size)), "x axis of the plot"));
  TURGOR_TRY(l.y, make_scale(plot.y, y, std::max(2, plot.height / (5 * l.size)), "y axis of the plot"));
  const bool y_title = !plot.y.title.empty() || l.y.exponent != 0;
  l.box = {widest_label(l.y, l.size) + 8 * l.size / 5, l.size + (plot.title.empty() ? 0 : 8 * l.size / 5),
           plot.width - std::max(l.size, widest_label(l.x, l.size) / 2 + l.size / 3),
           plot.height - 17 * l.size / 4};
  if (y_title) l.box.y0 += 8 * l.size / 5;
  l.box.x0 = std::min(l.box.x0, plot.width / 2);
  l.box.x1 = std::max(l.box.x1, l.box.x0 + 10);
  l.box.y1 = std::max(l.box.y1, l.box.y0 + 10);
  return l;
}

}  // namespace

Result<Image> draw_plot(const Plot& plot) {
  TURGOR_CHECK(check(plot));
  TURGOR_TRY(const Layout layout, lay_out(plot));
  Image image = filled_image(plot.width, plot.height, {1, 1, 1});
  draw_grid(image, layout);
  draw_axes(image, plot, layout);
  std::vector<std::vector<Capsule>> lines;
  for (const Curve& c : plot.curves) {
    lines.push_back(strokes(c, layout));
    draw_curve(image, c, lines.back(), layout);
  }
  draw_legend_box(image, plot, layout, lines);
  return image;
}

}  // namespace turgor
