#include "turgor/render/image.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <cstring>

#include "turgor/core/file.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

Image noise_image(int width, int height) {
  Image image = filled_image(width, height, {});
  const RandomStream random(3);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<std::uint8_t>(random.bits(i));
  return image;
}

/// Reads with libpng's own simple interface.
Image decode(const std::vector<std::byte>& bytes) {
  png_image png;
  std::memset(&png, 0, sizeof png);
  png.version = PNG_IMAGE_VERSION;
  Image image;
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) return image;
  EXPECT_EQ(png.flags & PNG_IMAGE_FLAG_COLORSPACE_NOT_sRGB, 0u);
  png.format = PNG_FORMAT_RGB;
  image.width = static_cast<int>(png.width);
  image.height = static_cast<int>(png.height);
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr);
  return image;
}

TEST(Png, RoundTripsThroughLibpng) {
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {64, 50}}) {
    const Image image = noise_image(width, height);
    const Image back = decode(encode_png(image));
    EXPECT_EQ(back.width, width);
    EXPECT_EQ(back.height, height);
    EXPECT_EQ(back.rgb, image.rgb);
  }
}

TEST(Png, IsWrittenWholeOrNotAtAll) {
  const auto folder = std::filesystem::temp_directory_path() / "turgor_png_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const Image image = noise_image(20, 10);
  ASSERT_TRUE(write_png(folder / "a.png", image));
  const auto bytes = read_file(folder / "a.png");
  ASSERT_TRUE(bytes);
  EXPECT_EQ(decode(*bytes).rgb, image.rgb);
  EXPECT_FALSE(write_png(folder / "missing" / "a.png", image));
  Image broken = image;
  broken.rgb.pop_back();
  EXPECT_FALSE(write_png(folder / "b.png", broken));
  EXPECT_TRUE(encode_png(broken).empty());
  EXPECT_FALSE(std::filesystem::exists(folder / "b.png"));
  std::filesystem::remove_all(folder);
}

TEST(Srgb, EncodingIsTheInverseOfDecoding) {
  for (int i = 0; i < 256; ++i) EXPECT_EQ(encode_srgb(decode_srgb(static_cast<std::uint8_t>(i))), i);
  EXPECT_EQ(encode_srgb(0.2140f), 127);  // half way up in sRGB is about a fifth in light
  EXPECT_EQ(encode_srgb(-1), 0);
  EXPECT_EQ(encode_srgb(2), 255);
}

TEST(Downscale, AveragesLightNotBytes) {
  Image image = filled_image(5, 4, {0, 0, 0});
  for (int y = 0; y < 4; ++y)
    for (int x = y % 2; x < 5; x += 2)
      for (int k = 0; k < 3; ++k) image.rgb[static_cast<std::size_t>(3 * (5 * y + x) + k)] = 255;
  const Image small = downscale(image, 2);
  ASSERT_EQ(small.width, 2);
  ASSERT_EQ(small.height, 2);
  for (const auto byte : small.rgb) EXPECT_EQ(byte, encode_srgb(0.5f));
  EXPECT_EQ(downscale(image, 1).rgb, image.rgb);
}

TEST(Paste, CutsOffWhatLiesOutside) {
  Image target = filled_image(4, 4, {0, 0, 0});
  const Image white = filled_image(3, 3, {1, 1, 1});
  paste(target, white, -2, 3);
  paste(target, white, 40, 0);
  for (int i = 0; i < 16; ++i) EXPECT_EQ(target.rgb[static_cast<std::size_t>(3 * i)], i == 12 ? 255 : 0) << i;
}

}  // namespace
}  // namespace turgor
