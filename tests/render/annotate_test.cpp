#include "turgor/render/annotate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support.hpp"

namespace turgor::render_tests {
namespace {

Image blank(int width = 300, int height = 200) {
  return filled_image(width, height, {1, 1, 1});
}
bool inked(const Image& image, int x, int y) {
  return !is_white(bytes_at(image, x, y));
}

TEST(Text, StaysInItsBoxAndFillsIt) {
  for (const int size : {12, 20, 40}) {
    Image image = blank();
    const std::string words = "Agjpq|@20° µ±";
    draw_text(image, 17, 23, size, words);
    const int width = text_width(words, size);
    int inside = 0, rightmost = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (!inked(image, x, y)) continue;
        const bool in_box = x >= 17 && x < 17 + width && y >= 23 && y < 23 + size;
        EXPECT_TRUE(in_box) << x << "," << y;
        inside += in_box;
        rightmost = std::max(rightmost, x);
      }
    EXPECT_GT(inside, 12 * size);
    if (17 + width < image.width) EXPECT_GT(rightmost, 17 + width - size);
  }
}

TEST(Text, EveryPrintableLetterHasItsOwnShape) {
  std::vector<std::vector<std::uint8_t>> shapes;
  for (char c = '!'; c <= '~'; ++c) {
    Image image = blank(60, 50);
    draw_text(image, 5, 5, 36, std::string(1, c));
    EXPECT_NE(image.rgb, blank(60, 50).rgb) << c;
    for (const auto& other : shapes) EXPECT_NE(image.rgb, other) << c;
    shapes.push_back(image.rgb);
  }
}

TEST(Text, TakesAnyBytesAndAnyPlace) {
  Image image = blank(20, 20);
  draw_text(image, -30, -5, 16, "\xff\xc3(\xe2\x82 cut off");
  draw_text(image, 15, 18, 16, "beyond");
  draw_text(image, 0, 0, 0, "nothing");
  draw_text(image, 0, 0, -4, "nothing");
  Image none;
  draw_text(none, 0, 0, 12, "no picture");
  EXPECT_TRUE(none.rgb.empty());
  EXPECT_EQ(text_width("", 20), 0);
}

TEST(ColourMap, RunsThroughThePublishedColours) {
  const auto hex = [](const Vec3f& c) {
    return encode_srgb(c.x) << 16 | encode_srgb(c.y) << 8 | encode_srgb(c.z);
  };
  EXPECT_EQ(hex(colour_map(0)), 0x440154);
  EXPECT_EQ(hex(colour_map(1)), 0xFDE725);
  EXPECT_EQ(hex(colour_map(-3)), 0x440154);
  EXPECT_EQ(hex(colour_map(7)), 0xFDE725);
  // The middle of the published table of 256 is #21918C (entry 127).
  const int middle = hex(colour_map(127.0 / 255));
  EXPECT_NEAR(middle >> 16, 0x21, 3);
  EXPECT_NEAR(middle >> 8 & 255, 0x91, 3);
  EXPECT_NEAR(middle & 255, 0x8C, 3);
  // Moreland's published ends (59, 76, 192) and (180, 4, 38), middle grey (221, 221, 221).
  const auto near = [&](const Vec3f& c, int r, int g, int b) {
    EXPECT_NEAR(encode_srgb(c.x), r, 2);
    EXPECT_NEAR(encode_srgb(c.y), g, 3);
    EXPECT_NEAR(encode_srgb(c.z), b, 2);
  };
  near(diverging_colour_map(0), 59, 76, 192);
  near(diverging_colour_map(0.5), 221, 221, 221);
  near(diverging_colour_map(1), 180, 4, 38);
  EXPECT_TRUE(is_finite(colour_map(std::nan(""))));
}

TEST(ColourMap, LightnessRisesOrFallsThroughout) {
  const auto luminance = [](const Vec3f& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; };
  for (int i = 0; i < 100; ++i) {
    EXPECT_LT(luminance(colour_map(i / 100.0)), luminance(colour_map((i + 1) / 100.0)));
    EXPECT_GT(luminance(light_colour_map(i / 100.0)), luminance(light_colour_map((i + 1) / 100.0)));
  }
}

TEST(Legend, EndsHoldTheEndColours) {
  for (const ColourMap map : {colour_map, diverging_colour_map}) {
    Image image = blank(400, 500);
    const PixelBox bar = draw_legend(image, -2, 8, "displacement (mm)", map);
    ASSERT_GT(bar.height, 100);
    const int x = bar.x + bar.width / 2;
    const Image top = filled_image(1, 1, map(1)), bottom = filled_image(1, 1, map(0));
    EXPECT_EQ(bytes_at(image, x, bar.y), bytes_at(top, 0, 0));
    EXPECT_EQ(bytes_at(image, x, bar.y + bar.height - 1), bytes_at(bottom, 0, 0));
    EXPECT_LT(bar.x + bar.width, image.width);
    // Title above and numbers beside the bar.
    int above = 0, beside = 0;
    for (int y = 0; y < image.height; ++y)
      for (int u = 0; u < image.width; ++u) {
        above += y < bar.y - 2 && inked(image, u, y);
        beside += u > bar.x + bar.width + 6 && y >= bar.y && y < bar.y + bar.height && inked(image, u, y);
      }
    EXPECT_GT(above, 100);
    EXPECT_GT(beside, 50);
  }
}

TEST(Legend, TakesAnyRange) {
  for (const auto& [low, high] : {std::pair{0.0, 0.0},
                                  {5.0, 5.0},
                                  {3.0, -1.0},
                                  {0.0, 1e-9},
                                  {0.0, 1e12},
                                  {std::nan(""), 1.0},
                                  {0.0, std::numeric_limits<double>::infinity()}}) {
    Image image = blank();
    const PixelBox bar = draw_legend(image, low, high, "mm");
    EXPECT_GT(bar.height, 0);
  }
  Image tiny = blank(1, 1);
  draw_legend(tiny, 0, 1, "mm");
  draw_scale_bar(tiny, standard_view(StandardView::front, cube_box(50)));
}

TEST(Marker, StandsWhereItsPointIsSeen) {
  const CameraView camera = standard_view(StandardView::front, cube_box(50));
  Image image = blank(300, 300);
  const Vec3 point{20, -40, 15};
  draw_marker(image, camera, point, "", red);
  const Blob dot = blob(image, is_red);
  const auto at = project(camera, 300, 300, point);
  ASSERT_TRUE(at);
  EXPECT_GT(dot.count, 5);
  EXPECT_NEAR(dot.x, at->x, 0.7);
  EXPECT_NEAR(dot.y, at->y, 0.7);
}

TEST(Markers, LabelsDoNotCoverOneAnother) {
  const CameraView camera = standard_view(StandardView::front, cube_box(50));
  std::vector<Marker> markers;
  for (int i = 0; i < 16; ++i) markers.push_back({{i - 8.0, -40, 0.3 * i}, "Hg", {0.8f, 0, 0}});
  Image image = blank(400, 400);
  draw_markers(image, camera, markers);
  // Count the separate bands of black ink in the left column: one a label.
  int bands = 0;
  bool last = false;
  for (int y = 0; y < image.height; ++y) {
    bool ink = false;
    for (int x = 0; x < 30; ++x) {
      const auto c = bytes_at(image, x, y);
      ink = ink || (c[0] < 100 && c[1] < 100 && c[2] < 100);
    }
    bands += ink && !last;
    last = ink;
  }
  EXPECT_EQ(bands, 8);
}

TEST(ScaleBar, IsAsLongAsItSays) {
  CameraView camera = standard_view(StandardView::front, cube_box(50));
  camera.height_mm = 200;
  Image image =
      blank(400, 400);  // 0.5 mm a pixel; a fifth of the width is 40 mm, the round number next to it 50
  draw_scale_bar(image, camera);
  int longest = 0;
  for (int y = 0; y < image.height; ++y) {
    int run = 0;
    for (int x = 0; x < image.width; ++x) {
      run = bytes_at(image, x, y)[0] < 90 ? run + 1 : 0;
      longest = std::max(longest, run);
    }
  }
  EXPECT_NEAR(longest, 100, 3);
}

TEST(Orientation, NamesThePatientsSides) {
  const auto corner = [](StandardView view, bool right) {
    Image image = blank(200, 200);
    draw_orientation(image, standard_view(view, cube_box(50)));
    Image half = blank(100, 40);
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 100; ++x)
        for (int k = 0; k < 3; ++k)
          half.rgb[static_cast<std::size_t>(3 * (100 * y + x) + k)] =
              image.rgb[static_cast<std::size_t>(3 * (200 * y + x + (right ? 100 : 0)) + k)];
    return half;
  };
  const auto expected = [](const std::string& letters, bool right) {
    Image half = blank(100, 40);
    const int size = 14, x = right ? 100 - size / 2 - text_width(letters, size) : size / 2;
    draw_text_with_halo(half, x, size / 2, size, letters, {0.25f, 0.25f, 0.25f});
    return half;
  };
  EXPECT_EQ(corner(StandardView::front, true).rgb, expected("L", true).rgb);
  EXPECT_EQ(corner(StandardView::front, false).rgb, expected("R", false).rgb);
  EXPECT_EQ(corner(StandardView::profile_right, true).rgb, expected("A", true).rgb);
  EXPECT_EQ(corner(StandardView::back, true).rgb, expected("R", true).rgb);
}

TEST(Polyline, FollowsItsPointsAndSkipsWhatIsBehindTheEye) {
  CameraView camera = in_perspective(standard_view(StandardView::front, cube_box(50)), 30);
  Image image = blank(200, 200);
  draw_polyline(image, camera, {{-20, 0, 0}, {20, 0, 0}}, 2, red);
  EXPECT_TRUE(is_red(bytes_at(image, 100, 100)));
  const Image before = image;
  draw_polyline(image, camera, {camera.eye - Vec3{0, 50, 0}, camera.eye - Vec3{0, 60, 1}}, 2, blue);
  EXPECT_EQ(image.rgb, before.rgb);
}

TEST(SideBySide, LaysOutRowsAndCaptions) {
  const Image black = filled_image(50, 40, {0, 0, 0});
  const Image plain = side_by_side({black, black, black}, {}, 2);
  EXPECT_EQ(plain.width, 100);
  EXPECT_EQ(plain.height, 80);
  EXPECT_TRUE(is_white(bytes_at(plain, 75, 60)));
  EXPECT_FALSE(is_white(bytes_at(plain, 25, 60)));
  const Image captioned = side_by_side({black, black}, {"a", "b"}, 2);
  EXPECT_GT(captioned.height, 40);
  int ink = 0;
  for (int y = 41; y < captioned.height; ++y)
    for (int x = 0; x < captioned.width; ++x) ink += inked(captioned, x, y);
  EXPECT_GT(ink, 10);
}

}  // namespace
}  // namespace turgor::render_tests
