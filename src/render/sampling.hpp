// Deterministic sample points for pixels, lights and hemispheres.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "turgor/math/vec.hpp"

namespace turgor::render_detail {

struct Sample2 {
  float u = 0, v = 0;
};

/// Point `index` of the (0,2)-sequence of van der Corput and Sobol', scrambled by exclusive-or (Kollig and
/// Keller 2002): every aligned block of 2^k indices is stratified over all elementary intervals.
inline Sample2 net_point(std::uint32_t index, std::uint32_t scramble_u, std::uint32_t scramble_v) {
  std::uint32_t u = index;
  u = (u << 16) | (u >> 16);
  u = ((u & 0x00FF00FFu) << 8) | ((u & 0xFF00FF00u) >> 8);
  u = ((u & 0x0F0F0F0Fu) << 4) | ((u & 0xF0F0F0F0u) >> 4);
  u = ((u & 0x33333333u) << 2) | ((u & 0xCCCCCCCCu) >> 2);
  u = ((u & 0x55555555u) << 1) | ((u & 0xAAAAAAAAu) >> 1);
  std::uint32_t v = 0;
  for (std::uint32_t bit = 1u << 31, i = index; i; i >>= 1, bit ^= bit >> 1)
    if (i & 1) v ^= bit;
  const auto unit = [](std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1.0p-24f; };
  return {unit(u ^ scramble_u), unit(v ^ scramble_v)};
}

/// Which block of a shared point set a pixel draws from. Any 4 × 4 pixels hold each of the 16 blocks once
/// (interleaved sampling, Keller and Heidrich 2001), so that a filter of that width sees the whole set.
inline constexpr std::array<std::uint32_t, 16> interleave{0, 8,  2, 10, 12, 4, 14, 6,
                                                          3, 11, 1, 9,  15, 7, 13, 5};

/// Area-preserving square to unit disc (Shirley and Chiu 1997).
inline Sample2 to_disc(const Sample2& s) {
  const float a = 2 * s.u - 1, b = 2 * s.v - 1;
  if (a == 0 && b == 0) return {0, 0};
  constexpr float quarter = std::numbers::pi_v<float> / 4;
  if (std::abs(a) > std::abs(b)) return {a * std::cos(quarter * (b / a)), a * std::sin(quarter * (b / a))};
  return {b * std::cos(2 * quarter - quarter * (a / b)), b * std::sin(2 * quarter - quarter * (a / b))};
}

/// Two unit vectors that complete `n`, smooth in n except at n = -pole, where `pole`, `pole_u`, `pole_v` are
/// orthonormal (Frisvad 2012, turned). With the pole towards the viewer, neighbouring pixels get neighbouring
/// frames.
struct Frame {
  Vec3f u, v;
};
inline Frame frame_about(const Vec3f& n, const Vec3f& pole, const Vec3f& pole_u, const Vec3f& pole_v) {
  const float x = dot(n, pole_u), y = dot(n, pole_v), z = dot(n, pole);
  if (z < -0.9999f) return {pole_v * -1.0f, pole_u * -1.0f};
  const float a = 1 / (1 + z), b = -x * y * a;
  return {pole_u * (1 - x * x * a) + pole_v * b - pole * x, pole_u * b + pole_v * (1 - y * y * a) - pole * y};
}

}  // namespace turgor::render_detail
