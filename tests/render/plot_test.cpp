#include "turgor/render/plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support.hpp"

namespace turgor::render_tests {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Plot plot_of(std::vector<double> x, std::vector<double> y) {
  Plot plot;
  Curve curve;
  curve.x = std::move(x), curve.y = std::move(y), curve.colour = red;
  plot.curves = {curve};
  return plot;
}

Image drawn(const Plot& plot) {
  auto image = draw_plot(plot);
  EXPECT_TRUE(image) << image.error().message();
  return image ? *std::move(image) : filled_image(plot.width, plot.height, {1, 1, 1});
}

int red_pixels(const Image& image) {
  return blob(image, is_red).count;
}

TEST(Plot, DotsLieWhereTheAxesSay) {
  // Dots at the four corners of given axes span the plot's box; a fifth stands in its middle.
  Plot plot = plot_of({0, 10, 0, 10}, {-1, -1, 1, 1});
  plot.x.low = 0, plot.x.high = 10, plot.y.low = -1, plot.y.high = 1;
  plot.curves[0].dots = true;
  const Blob corners = blob(drawn(plot), is_red);
  plot.curves[0].x = {5}, plot.curves[0].y = {0};
  const Blob middle = blob(drawn(plot), is_red);
  EXPECT_GT(middle.count, 20);
  EXPECT_NEAR(middle.x, corners.x, 1);
  EXPECT_NEAR(middle.y, corners.y, 1);
  plot.curves[0].x = {7.5}, plot.curves[0].y = {0.5};
  const Blob quarter = blob(drawn(plot), is_red);
  EXPECT_GT(quarter.x, middle.x + 50);
  EXPECT_LT(quarter.y, middle.y - 50);
}

TEST(Plot, PointsThatAreNotFiniteBreakTheLine) {
  const Image whole = drawn(plot_of({0, 1, 2, 3, 4}, {1, 1, 1, 1, 1}));
  for (const double v : {nan, infinity, -infinity, 1e308}) {
    const Image broken = drawn(plot_of({0, 1, 2, 3, 4}, {1, 1, v, 1, 1}));
    EXPECT_NEAR(red_pixels(broken), red_pixels(whole) / 2.0, red_pixels(whole) / 10.0) << v;
  }
}

TEST(Plot, CurvesAreCutOffAtTheAxes) {
  Plot plot = plot_of({-1e9, 1e9}, {-1e9, 1e9});
  plot.x.low = 0, plot.x.high = 1, plot.y.low = 0, plot.y.high = 1;
  const Image far = drawn(plot);
  plot.curves[0].x = plot.curves[0].y = {0, 1};
  const Image near = drawn(plot);
  EXPECT_GT(red_pixels(near), 500);
  EXPECT_NEAR(red_pixels(far), red_pixels(near), 30);  // round ends stand over the axes
}

TEST(Plot, TheLegendKeepsOutOfTheCurve) {
  // A curve along the top and the left leaves the lower right corner.
  Plot plot = plot_of({0, 0.01, 1}, {0, 0.95, 0.95});
  plot.y.high = 1;
  const int bare = red_pixels(drawn(plot));
  plot.curves[0].name = "Saturation";
  const Image image = drawn(plot);
  EXPECT_GT(red_pixels(image), bare);  // nothing covered, and the sample line added
  const auto in_corner = [&](int x0, int x1) {
    int dark = 0;
    for (int y = image.height * 7 / 10; y < image.height * 9 / 10; ++y)
      for (int x = x0; x < x1; ++x) dark += is_red(bytes_at(image, x, y)) ? 1 : 0;
    return dark;
  };
  EXPECT_GT(in_corner(image.width / 2, image.width * 19 / 20), 20);
}

TEST(Plot, TitlesAndTicksAreThere) {
  Plot plot = plot_of({0, 1}, {0, 1});
  const auto dark = [](const auto& c) { return c[0] < 120 && c[1] < 120 && c[2] < 120; };
  const int bare = blob(drawn(plot), dark).count;
  plot.x.title = "Strain";
  const int with_x = blob(drawn(plot), dark).count;
  plot.y.title = "Tension, N/cm";
  const int with_y = blob(drawn(plot), dark).count;
  EXPECT_GT(bare, 500);
  EXPECT_GT(with_x, bare + 100);
  EXPECT_GT(with_y, with_x + 100);
}

TEST(Plot, AnyRangeIsDrawn) {
  for (const double low : {0.0, -1e300, 1e-300, -3.0, 1e9})
    for (const double high : {0.0, 1e300, 1e-299, 1e9 + 1e-3, 1e9 + 1}) {
      const Image image = drawn(plot_of({low, high}, {high, low}));
      EXPECT_GT(red_pixels(image), 1) << low << " to " << high;
    }
}

TEST(Plot, LogarithmicAxesPutEqualFactorsEquallyFar) {
  Plot plot = plot_of({0, 1, 2}, {0.01, 1, 100});
  plot.y.logarithmic = true;
  const Image straight = drawn(plot);
  Plot same = plot_of({0, 1, 2}, {-2, 0, 2});
  // A straight line in both: as many red pixels, up to the width of the labels beside it.
  EXPECT_NEAR(red_pixels(straight), red_pixels(drawn(same)), 0.1 * red_pixels(straight));
  plot.curves[0].y[1] = 0;  // no logarithm: the line is broken
  EXPECT_LT(red_pixels(drawn(plot)), red_pixels(straight) / 2);
  for (const double factor : {1e-300, 1e-9, 1.0, 1e9, 1e298}) {
    plot.curves[0].y = {factor, 1.0001 * factor, 3 * factor};
    EXPECT_GT(red_pixels(drawn(plot)), 1) << factor;
  }
  plot.curves[0].y = {-1, 0, -3};
  EXPECT_FALSE(draw_plot(plot));
  plot = plot_of({0, 1}, {1, 2});
  plot.y.logarithmic = true, plot.y.low = 0;
  EXPECT_FALSE(draw_plot(plot));
}

TEST(Plot, BadInputIsNamed) {
  const auto fails = [](const Plot& plot, const std::string& word) {
    const auto image = draw_plot(plot);
    ASSERT_FALSE(image) << word;
    EXPECT_EQ(image.error().kind, ErrorKind::bad_input);
    EXPECT_NE(image.error().message().find(word), std::string::npos) << image.error().message();
  };
  fails({}, "no curves");
  fails(plot_of({1, 2}, {1}), "do not match");
  fails(plot_of({}, {}), "finite");
  fails(plot_of({nan, 1}, {1, infinity}), "finite");
  Plot plot = plot_of({0, 1}, {0, 1});
  plot.y.low = 2, plot.y.high = 1;
  fails(plot, "y axis");
  plot.y.high = nan;
  fails(plot, "y axis");
  for (const auto& [width, height] : {std::pair{0, 100}, {-5, 600}, {100000, 600}, {900, 2'000'000'000}}) {
    plot = plot_of({0, 1}, {0, 1});
    plot.width = width, plot.height = height;
    fails(plot, "pixels");
  }
}

TEST(Plot, ShortAxesMakeRoomForThemselves) {
  Plot plot = plot_of({3, 3, 3}, {5, 5, 5});  // no extent at all
  EXPECT_GT(red_pixels(drawn(plot)), 1);
  plot.x.low = 10;  // beyond all data
  drawn(plot);
  plot.width = plot.height = 160;  // long labels in the smallest plot
  plot.curves[0].name = plot.title = plot.y.title = "A title that is far wider than the plot itself";
  plot.y.low = -123456.789, plot.y.high = 123456.789;
  drawn(plot);
}

}  // namespace
}  // namespace turgor::render_tests
