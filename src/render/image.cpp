#include "turgor/render/image.hpp"

#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csetjmp>
#include <cstring>

#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

float srgb_to_linear(float s) {
  return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

/// The linear values at which the rounded sRGB byte goes up, so that encoding is a search and exactly the
/// inverse of decoding.
const std::array<float, 255>& byte_thresholds() {
  static const std::array<float, 255> table = [] {
    std::array<float, 255> t{};
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = srgb_to_linear((static_cast<float>(i) + 0.5f) / 255.0f);
    return t;
  }();
  return table;
}

bool has_its_bytes(const Image& image) {
  return image.width > 0 && image.height > 0 &&
         image.rgb.size() ==
             3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

void append_bytes(png_structp png, png_bytep data, png_size_t size) {
  auto& out = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  const auto* bytes = reinterpret_cast<const std::byte*>(data);
  out.insert(out.end(), bytes, bytes + size);
}

/// libpng reports failure by longjmp: nothing with a destructor may live in this frame.
bool write_rows(png_structp png, png_infop info, const Image& image, std::vector<std::byte>* out) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_write_fn(png, out, append_bytes, nullptr);
  // The fastest level that still halves a picture: encoding must not outlast rendering.
  png_set_compression_level(png, 3);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB | PNG_FILTER_UP);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 8,
               PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  const std::size_t stride = 3 * static_cast<std::size_t>(image.width);
  for (int y = 0; y < image.height; ++y)
    png_write_row(png, image.rgb.data() + stride * static_cast<std::size_t>(y));
  png_write_end(png, info);
  return true;
}

}  // namespace

std::uint8_t encode_srgb(float linear) {
  static constexpr int cells = 4096;  // fine enough that at most one threshold lies in a cell
  static const std::array<std::uint8_t, cells> floor_of_cell = [] {
    std::array<std::uint8_t, cells> t{};
    const auto& up = byte_thresholds();
    for (std::size_t i = 0; i < t.size(); ++i) {
      const float low = static_cast<float>(i) / cells;
      t[i] = static_cast<std::uint8_t>(std::upper_bound(up.begin(), up.end(), low) - up.begin());
    }
    return t;
  }();
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  const std::uint8_t floor = floor_of_cell[static_cast<std::size_t>(linear * cells)];
  return floor < 255 && byte_thresholds()[floor] <= linear ? static_cast<std::uint8_t>(floor + 1) : floor;
}

float decode_srgb(std::uint8_t value) {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = srgb_to_linear(static_cast<float>(i) / 255.0f);
    return t;
  }();
  return table[value];
}

Image filled_image(int width, int height, const Vec3f& colour) {
  Image image;
  image.width = std::max(width, 1);
  image.height = std::max(height, 1);
  const std::size_t pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  image.rgb.resize(3 * pixels);
  const std::array<std::uint8_t, 3> bytes{encode_srgb(colour.x), encode_srgb(colour.y),
                                          encode_srgb(colour.z)};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = bytes[i % 3];
  return image;
}

std::vector<std::byte> encode_png(const Image& image) {
  std::vector<std::byte> out;
  if (!has_its_bytes(image)) return out;
  out.reserve(image.rgb.size() / 3);
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool done = info && write_rows(png, info, image, &out);
  png_destroy_write_struct(&png, &info);
  if (!done) out.clear();
  return out;
}

Result<void> write_png(const std::filesystem::path& path, const Image& image) {
  if (!has_its_bytes(image))
    return Error{ErrorKind::internal, "the picture's bytes do not match its size", path.string(), ""};
  const std::vector<std::byte> bytes = encode_png(image);
  if (bytes.empty())
    return Error{ErrorKind::system, "the picture could not be encoded as PNG", path.string(),
                 "Free some memory"};
  return write_file(path, bytes);
}

Image downscale(const Image& image, int factor) {
  if (factor < 2 || !has_its_bytes(image) || image.width < factor || image.height < factor) return image;
  Image small = filled_image(image.width / factor, image.height / factor, {});
  const float share = 1.0f / static_cast<float>(factor * factor);
  const auto width = static_cast<std::size_t>(image.width),
             small_width = static_cast<std::size_t>(small.width);
  const auto f = static_cast<std::size_t>(factor);
  parallel_for(static_cast<std::size_t>(small.height), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y)
      for (std::size_t i = 0; i < 3 * small_width; ++i) {
        float sum = 0;
        for (std::size_t v = 0; v < f; ++v)
          for (std::size_t u = 0; u < f; ++u)
            sum += decode_srgb(image.rgb[3 * ((y * f + v) * width + (i / 3) * f + u) + i % 3]);
        small.rgb[3 * small_width * y + i] = encode_srgb(sum * share);
      }
  });
  return small;
}

void paste(Image& target, const Image& source, int x, int y) {
  if (!has_its_bytes(target) || !has_its_bytes(source)) return;
  const int x0 = std::max(x, 0), x1 = std::min(x + source.width, target.width);
  if (x0 >= x1) return;
  for (int row = std::max(y, 0); row < std::min(y + source.height, target.height); ++row) {
    const auto from = 3 * (static_cast<std::size_t>(row - y) * static_cast<std::size_t>(source.width) +
                           static_cast<std::size_t>(x0 - x));
    const auto to = 3 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(target.width) +
                         static_cast<std::size_t>(x0));
    std::memcpy(target.rgb.data() + to, source.rgb.data() + from, 3 * static_cast<std::size_t>(x1 - x0));
  }
}

}  // namespace turgor
