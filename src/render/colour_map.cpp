#include "turgor/render/colour_map.hpp"

#include <array>
#include <cmath>
#include <cstdint>

#include "turgor/render/image.hpp"

namespace turgor {
namespace {

constexpr Vec3f missing_value{0.35f, 0.35f, 0.35f};

float to_linear(double s) {
  return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

/// CIELAB (D65) to linear sRGB primaries, clamped to the gamut.
Vec3f lab_to_linear(double l, double a, double b) {
  const auto inverse = [](double t) {
    constexpr double d = 6.0 / 29.0;
    return t > d ? t * t * t : 3 * d * d * (t - 4.0 / 29.0);
  };
  const double fy = (l + 16) / 116;
  const double x = 0.95047 * inverse(fy + a / 500), y = inverse(fy), z = 1.08883 * inverse(fy - b / 200);
  const auto clamp = [](double v) { return static_cast<float>(std::clamp(v, 0.0, 1.0)); };
  return {clamp(3.2404542 * x - 1.5371385 * y - 0.4985314 * z),
          clamp(-0.9692660 * x + 1.8760108 * y + 0.0415560 * z),
          clamp(0.0556434 * x - 0.2040259 * y + 1.0572252 * z)};
}

/// Linear between the table's sRGB colours.
template <std::size_t n>
Vec3f from_table(const std::array<std::uint32_t, n>& table, double t) {
  if (std::isnan(t)) return missing_value;
  const double s = std::clamp(t, 0.0, 1.0) * (n - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(s), n - 2);
  const double f = s - static_cast<double>(i);
  const auto channel = [&](int shift) {
    const double a = (table[i] >> shift) & 0xFF, b = (table[i + 1] >> shift) & 0xFF;
    return to_linear((a + (b - a) * f) / 255.0);
  };
  return {channel(16), channel(8), channel(0)};
}

}  // namespace

Vec3f colour_map(double t) {
  static constexpr std::array<std::uint32_t, 20> table{
      0x440154, 0x481568, 0x482677, 0x453781, 0x3F4788, 0x39558C, 0x32648E, 0x2D718E, 0x287D8E, 0x238A8D,
      0x1F968B, 0x20A386, 0x29AF7F, 0x3CBC75, 0x56C667, 0x74D055, 0x94D840, 0xB8DE29, 0xDCE318, 0xFDE725};
  return from_table(table, t);
}

Vec3f light_colour_map(double t) {
  static constexpr std::array<std::uint32_t, 9> table{0xEDE9E4, 0xFCE0AC, 0xFED976, 0xFEB24C, 0xFD8D3C,
                                                      0xFC4E2A, 0xE31A1C, 0xBD0026, 0x800026};
  return from_table(table, t);
}

Vec3f diverging_colour_map(double t) {
  if (std::isnan(t)) return missing_value;
  // Msh coordinates of Moreland's table 2: both ends (80, 1.08, hue), the middle (88, 0, hue turned by
  // 0.561).
  const double s = std::clamp(t, 0.0, 1.0), away = std::abs(2 * s - 1);
  const double m = 88 + (80 - 88) * away, saturation = 1.08 * away;
  const double hue = s < 0.5 ? -1.661 + (1.661 - 1.1) * away : 1.061 + (0.5 - 1.061) * away;
  return lab_to_linear(m * std::cos(saturation), m * std::sin(saturation) * std::cos(hue),
                       m * std::sin(saturation) * std::sin(hue));
}

}  // namespace turgor
