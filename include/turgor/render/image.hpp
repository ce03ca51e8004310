// A picture as bytes, its file, and the plain operations on it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  ///< 3 bytes a pixel (sRGB), rows from the top
};

/// A picture of one colour (linear RGB). Sizes below 1 count as 1.
Image filled_image(int width, int height, const Vec3f& colour);

/// All or nothing (see write_file). Errors: an image whose bytes do not match its size, a path that cannot be
/// written.
Result<void> write_png(const std::filesystem::path& path, const Image& image);
/// The bytes of a PNG file; empty where the image's bytes do not match its size.
std::vector<std::byte> encode_png(const Image& image);

/// The picture `factor` times smaller in both directions: each pixel the mean of factor² in linear light;
/// what is left over at the right and bottom is dropped. `factor` below 2 returns the image.
Image downscale(const Image& image, int factor);
/// Writes `source` into `target` with its top left corner at (x, y); what lies outside is cut off.
void paste(Image& target, const Image& source, int x, int y);

/// sRGB transfer function (IEC 61966-2-1): linear [0, 1] to 0 … 255, rounded, and back.
std::uint8_t encode_srgb(float linear);
float decode_srgb(std::uint8_t value);
/// Relative luminance of linear RGB (IEC 61966-2-1).
inline float luminance(const Vec3f& c) {
  return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

}  // namespace turgor
