// The three scripts of Pieper (1989, section 6.1) run exactly as they are printed, and what they show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "turgor/commands/session.hpp"
#include "turgor/core/file.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/world/flesh_objects.hpp"

namespace turgor {
namespace {

std::filesystem::path scripts() {
  return std::filesystem::path(TURGOR_SOURCE_DIR).parent_path() / "shared/data/scripts";
}

std::string text_of(const std::string& script) {
  const auto text = read_text_file(scripts() / script);
  EXPECT_TRUE(static_cast<bool>(text)) << script;
  return text ? *text : std::string();
}

// The printed script, but for the time at which it ends.
std::string cut_short(const std::string& script, double until) {
  std::string text = text_of(script);
  const std::size_t at = text.rfind("-until ");
  EXPECT_NE(at, std::string::npos);
  return text.substr(0, at) + "-until " + std::to_string(until) + "\n";
}

using Watch = std::function<void(const Scene&)>;

/// A session that has run a script, watched at every frame.
struct Played {
  Played(const std::string& text, const std::string& name, Watch watch = {})
      : session(options(std::move(watch)), context) {
    const auto entered = session.enter_text(text, name);
    EXPECT_TRUE(static_cast<bool>(entered)) << entered.error().message();
    const auto run = session.run();
    EXPECT_TRUE(static_cast<bool>(run)) << run.error().message();
  }
  const Specimen& specimen() const { return session.scene().specimen; }
  FleshMeasures measured() const { return measure(specimen()).at(0); }

  int worst_inversion = 0;
  Context context;
  Session session;

 private:
  SessionOptions options(Watch watch) {
    SessionOptions options;
    options.frame = [this, watch = std::move(watch)](const Scene& scene) -> Result<void> {
      for (const FleshMeasures& m : measure(scene.specimen))
        worst_inversion = std::max(worst_inversion, m.inverted);
      if (watch) watch(scene);
      return {};
    };
    return options;
  }
};

const TissueBody& only_flesh(const Scene& scene) {
  return scene.specimen.bodies().at(1);
}

/// Highest point of the skin within `reach` of a place in the plane, over the skin's height at rest.
double rise_near(const Scene& scene, const Vec3& place, double reach) {
  const TissueBody& body = only_flesh(scene);
  double highest = -1;
  for (int c = 0; c < body.flesh.columns(); ++c) {
    const int sample = body.flesh.sample(body.flesh.layers - 1, c);
    const Vec3& rest = body.flesh.samples[static_cast<std::size_t>(sample)].rest;
    if (std::hypot(rest.x - place.x, rest.y - place.y) > reach) continue;
    highest = std::max(highest, scene.specimen.position({1, sample}).z - rest.z);
  }
  return highest;
}

class ThesisScriptsRun : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(scripts())) GTEST_SKIP() << "no shared/data/scripts beside the project";
  }
};

// ---- 6.1.1 ----

struct Closed {
  bool reached = false;
  double opening = 1;  // area over that at rest
  double gap = 1;  // between the edges where they are farthest apart, over the width at rest of the opening
  double dog_ear_front = 0, dog_ear_back = 0, rise_between = 0;
};

// The ends of the spindle, at rest: the points of the opening that lie farthest along y.
constexpr Vec3 kFrontTip{0, -0.26, 0}, kBackTip{0, 0.26, 0};

Closed look_at_closed(const Scene& scene) {
  const FleshMeasures m = measure(scene.specimen).at(0);
  Closed seen{true,
              m.opening / m.rest_opening,
              0,
              rise_near(scene, kFrontTip, 0.1),
              rise_near(scene, kBackTip, 0.1),
              rise_near(scene, {0.45, 0, 0}, 0.1)};
  double widest = 0, widest_at_rest = 0;
  for (const Muscle& muscle : scene.specimen.muscles()) {
    for (const Fibre& fibre : muscle.fibres) {
      widest = std::max(widest, scene.specimen.length(fibre));
      widest_at_rest = std::max(widest_at_rest, fibre.original_length);
    }
  }
  seen.gap = widest / widest_at_rest;
  return seen;
}

TEST_F(ThesisScriptsRun, TheWoundClosesAndDogEarsRiseAtBothOfItsEnds) {
  Closed closed;
  const Played wound(text_of("wound_closure.bolio"), "wound_closure.bolio", [&](const Scene& scene) {
    // The sutures hold up to the time 40.5; then the script lets them go.
    if (!closed.reached && scene.time > 40 - 1e-6) closed = look_at_closed(scene);
  });
  ASSERT_EQ(wound.measured().samples, 522);
  EXPECT_NEAR(wound.session.scene().time, 100, 1e-6);
  EXPECT_EQ(wound.worst_inversion, 0);
  ASSERT_TRUE(closed.reached);
  EXPECT_LT(closed.opening, 0.05);
  EXPECT_LT(closed.gap, 0.05);
  // Against a sheet 0.14 thick the bulges are plain, and the same at both ends.
  EXPECT_GT(closed.dog_ear_front, 0.02);
  EXPECT_GT(closed.dog_ear_back, 0.02);
  EXPECT_NEAR(closed.dog_ear_front, closed.dog_ear_back, 0.2 * closed.dog_ear_back);
  EXPECT_LT(closed.rise_between, 0.5 * std::min(closed.dog_ear_front, closed.dog_ear_back));
  // The sutures end at half their length.
  EXPECT_GT(wound.measured().opening, 0.5 * wound.measured().rest_opening);
  RecordProperty("opening_over_rest", std::to_string(closed.opening) + " " + std::to_string(closed.gap));
  RecordProperty("dog_ears",
                 std::to_string(closed.dog_ear_front) + " " + std::to_string(closed.dog_ear_back));
}

// ---- 6.1.2 ----

constexpr double kBallRadius = 0.2;  // about (0, 0, -0.2)

TEST_F(ThesisScriptsRun, TheSheetLiesOnBallAndFloor) {
  double in_ball = 0, in_floor = 0;  // at any time, over the ball's radius
  const Played cloth(text_of("balldrape.bolio"), "balldrape.bolio", [&](const Scene& scene) {
    for (const Penetration& p : penetrations(scene.specimen)) {
      double& deepest = p.radius > 0 ? in_ball : in_floor;
      deepest = std::max(deepest, p.depth / kBallRadius);
    }
  });
  ASSERT_EQ(cloth.measured().samples, 300);
  EXPECT_EQ(cloth.worst_inversion, 0);
  EXPECT_NEAR(cloth.session.scene().time, 50, 1e-6);
  EXPECT_LT(in_ball, 0.02);
  EXPECT_LT(in_floor, 0.05);  // where it strikes; it comes to lie at less:
  for (const Penetration& p : penetrations(cloth.specimen())) EXPECT_LT(p.depth, 0.02 * kBallRadius);
  // It came to lie: on top of the ball and on the floor (z = -0.25).
  const FleshMeasures m = cloth.measured();
  EXPECT_LT(m.greatest_speed, 0.05);
  double lowest = 1, on_ball = 1;
  for (const Vec3& x : cloth.specimen().positions_of(only_flesh(cloth.session.scene()))) {
    lowest = std::min(lowest, x.z);
    on_ball = std::min(on_ball, distance(x, {0, 0, -0.2}) - kBallRadius);
  }
  EXPECT_NEAR(lowest, -0.25, 0.005);
  EXPECT_NEAR(on_ball, 0, 0.005);
  EXPECT_GT(m.skin_box.upper.z, 0.05);
  RecordProperty("greatest_depth_over_radius", std::to_string(in_ball) + " " + std::to_string(in_floor));
}

// ---- 6.1.3 ----

/// Thickness of the tissue and its length along the fibres, over the columns that the muscle runs through.
struct Belly {
  double thickness = 0, length = 0, tension = 0;
};
Belly belly(const Scene& scene) {
  const Flesh& flesh = only_flesh(scene).flesh;
  const auto at = [&](int layer, int column) {
    return scene.specimen.position({1, flesh.sample(layer, column)});
  };
  Belly b;
  int columns = 0;
  for (int row = 3; row <= 6; ++row) {
    for (int i = 3; i <= 5; ++i, ++columns) b.thickness += distance(at(0, 10 * row + i), at(2, 10 * row + i));
  }
  b.thickness /= columns;
  for (int i = 3; i <= 5; ++i) b.length += distance(at(1, 30 + i), at(1, 60 + i)) / 3;
  for (const Fibre& f : scene.specimen.muscles().at(0).fibres) b.tension += scene.specimen.tension(f);
  return b;
}

TEST_F(ThesisScriptsRun, TheMuscleShortensTheSheetWhichThickensAndRelaxesWithIt) {
  std::map<int, Belly> at;  // by time
  const Played sheet(text_of("twitch.bolio"), "twitch.bolio", [&](const Scene& scene) {
    if (scene.specimen.muscles().empty()) return;
    const int whole = static_cast<int>(std::lround(scene.time));
    if (std::abs(scene.time - whole) < 1e-6) at[whole] = belly(scene);
  });
  ASSERT_EQ(sheet.measured().samples, 300);
  EXPECT_EQ(sheet.worst_inversion, 0);
  for (const Penetration& p : penetrations(sheet.specimen())) EXPECT_LT(p.depth, 0.004);
  ASSERT_EQ(sheet.specimen().muscles().at(0).fibres.size(), 6U);
  ASSERT_TRUE(at.contains(0) && at.contains(30) && at.contains(50));
  const Belly rest = at[0], contracted = at[30], relaxed = at[50];
  EXPECT_LT(contracted.length, 0.7 * rest.length);
  EXPECT_GT(contracted.thickness, 1.1 * rest.thickness);
  EXPECT_GT(contracted.tension, 0);
  // Back to its length, and flat again under its weight.
  EXPECT_NEAR(relaxed.length, rest.length, 0.05 * rest.length);
  EXPECT_NEAR(relaxed.thickness, rest.thickness, 0.1 * rest.thickness);
  EXPECT_LT(std::abs(relaxed.tension), 0.1 * contracted.tension);
  RecordProperty("length_over_rest", std::to_string(contracted.length / rest.length));
  RecordProperty("thickness_over_rest", std::to_string(contracted.thickness / rest.thickness));
}

// ---- the same bits ----

bool same_bits(const Specimen& a, const Specimen& b) {
  return a.state().position == b.state().position && a.state().velocity == b.state().velocity;
}

const std::map<std::string, double> kShortRuns{
    {"wound_closure.bolio", 4}, {"balldrape.bolio", 6}, {"twitch.bolio", 5}};

TEST_F(ThesisScriptsRun, AnyNumberOfThreadsGivesTheSameBits) {
  for (const auto& [script, until] : kShortRuns) {
    const std::string text = cut_short(script, until);
    set_thread_count(1);
    const Played one(text, script);
    set_thread_count(2);
    const Played two(text, script);
    set_thread_count(0);
    EXPECT_TRUE(same_bits(one.specimen(), two.specimen())) << script;
  }
}

TEST_F(ThesisScriptsRun, AReplayedRecordingGivesTheSameBits) {
  for (const auto& [script, until] : kShortRuns) {
    const Played first(cut_short(script, until), script);
    const std::string recording = first.session.recording();
    const Played again(recording, "recording");
    EXPECT_TRUE(same_bits(first.specimen(), again.specimen())) << script;
    EXPECT_EQ(again.session.scene().time, first.session.scene().time) << script;
    EXPECT_EQ(again.session.recording(), recording) << script;
  }
}

}  // namespace
}  // namespace turgor
