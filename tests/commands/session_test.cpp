#include "turgor/commands/session.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "turgor/core/file.hpp"
#include "turgor/world/flesh_objects.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A session that hears itself, with a folder of its own.
class SessionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::temp_directory_path() /
              (std::string("turgor_session_") + test->name() + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder() const { return folder_; }
  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  SessionOptions options(bool interactive = false) {
    SessionOptions options;
    options.output = folder_;
    options.interactive = interactive;
    options.say = [this](std::string_view text) { said_ += std::string(text) + '\n'; };
    return options;
  }
  Session script() { return {options(false), context_}; }
  Session console() { return {options(true), context_}; }

  // Its message, empty where all went well.
  static std::string run(Session& session, const std::string& text) {
    if (const auto entered = session.enter_text(text, "script"); !entered) return entered.error().message();
    const auto done = session.run();
    return done ? "" : done.error().message();
  }
  static void expect_runs(Session& session, const std::string& text) { EXPECT_EQ(run(session, text), ""); }
  static void expect_fails(Session& session, const std::string& text, const std::string& expected) {
    const std::string message = run(session, text);
    EXPECT_NE(message.find(expected), std::string::npos) << text << "\n" << message;
    EXPECT_TRUE(session.idle());
  }
  // At a console: until nothing is to do but to answer.
  static std::string work(Session& session) {
    while (!session.idle() && !session.waits_for_answer()) {
      if (const auto done = session.frame(); !done) return done.error().message();
    }
    return "";
  }
  static void say_to(Session& session, const std::string& line) {
    ASSERT_TRUE(static_cast<bool>(session.enter_text(line, "console")));
    EXPECT_EQ(work(session), "");
  }
  bool heard(const std::string& text) const { return said_.find(text) != std::string::npos; }
  int notices(const std::string& text) const {
    int count = 0;
    for (const Notice& n : context_.notices()) count += n.text.find(text) != std::string::npos ? 1 : 0;
    return count;
  }

  Context context_;
  std::string said_;

 private:
  fs::path folder_;
};

const std::string kSheet =
    "instance_object grid.4.4 sheet\nflesh_out sheet -dfth 0.1 -sfth 0.1 -me 1\ngravity -g 0.1\ndamping 0.2\n"
    "add_muscle pull 4 7 -c 5\n";

bool same_bits(const Session& a, const Session& b) {
  return a.scene().specimen.state().position == b.scene().specimen.state().position &&
         a.scene().specimen.state().velocity == b.scene().specimen.state().velocity &&
         a.scene().time == b.scene().time;
}

// ---- the table ----

TEST_F(SessionTest, EveryCommandOfASceneIsCarriedOut) {
  for (const CommandDeclaration& command : scene_commands().commands) {
    for (const Example& example : command.examples) {
      Session session = script();
      const auto entered = session.enter_text(example.line, "example");
      ASSERT_TRUE(static_cast<bool>(entered)) << example.line;
      const fs::path before = fs::current_path();
      fs::current_path(folder());
      const auto done = session.run();
      fs::current_path(before);
      // What it needs may be missing in an empty scene, but something carries it out.
      if (!done) EXPECT_NE(done.error().kind, ErrorKind::internal) << done.error().message();
    }
  }
}

// ---- one buffer ----

TEST_F(SessionTest, LinesOfAllSourcesAreDoneInTheOrderOfTheirEntry) {
  Session session = script();
  write("part.turgor", "edit_xform ball -t 2 0 0\nedit_xform ball -t 3 0 0 -relative\n");
  ASSERT_TRUE(
      static_cast<bool>(session.enter_text("instance_object sphere ball\nedit_xform ball -t 1 0 0", "a")));
  ASSERT_TRUE(static_cast<bool>(session.enter_script(folder() / "part.turgor")));
  EXPECT_TRUE(session.scene().find("ball") == nullptr);  // entered, not done
  EXPECT_FALSE(session.idle());
  ASSERT_TRUE(static_cast<bool>(session.run()));
  EXPECT_EQ(session.scene().find("ball")->transform.translation, (Vec3{5, 0, 0}));
  EXPECT_TRUE(session.idle());
}

TEST_F(SessionTest, AScriptThatCannotBeReadEntersNothing) {
  Session session = script();
  write("broken.turgor", "instance_object cube box\n#include nowhere.turgor\n");
  const auto entered = session.enter_script(folder() / "broken.turgor");
  ASSERT_FALSE(static_cast<bool>(entered));
  EXPECT_NE(entered.error().message().find("broken.turgor:2:10"), std::string::npos)
      << entered.error().message();
  EXPECT_TRUE(session.idle());
  EXPECT_FALSE(static_cast<bool>(session.enter_text("post 'open", "t")));
  EXPECT_TRUE(session.idle());
}

TEST_F(SessionTest, AnErrorNamesItsPlaceOnceAndDropsTheRest) {
  Session session = script();
  expect_fails(session, "instance_object cube box\nedit_xform bax -t 1 0 0\ninstance_object cube other\n",
               "script:2:1: there is no object 'bax'. Did you mean box?");
  EXPECT_NE(session.scene().find("box"), nullptr);
  EXPECT_EQ(session.scene().find("other"), nullptr);
  expect_fails(session, "nonsense 1 2", "script:1:1: ");
  expect_fails(session, "damping many", "script:1:9: ");
  expect_fails(session, "viewport main -at 1 0 0 1", "script:1:19: the viewport has no extent");
  const std::string message = run(session, "viewport main -at 1 0 0 1");
  EXPECT_EQ(message.find("script:"), message.rfind("script:")) << message;
  expect_runs(session, "instance_object cube other");  // it goes on with what comes after
}

// ---- asking ----

TEST_F(SessionTest, AtTheConsoleACommandAsksForWhatIsMissingAndTheNextLineAnswers) {
  Session session = console();
  say_to(session, "instance_object sphere ball");
  say_to(session, "visible");
  ASSERT_TRUE(session.asks().has_value());
  EXPECT_NE(session.asks()->find("visible: OBJECT"), std::string::npos) << *session.asks();
  EXPECT_TRUE(heard(*session.asks()));
  EXPECT_TRUE(session.waits_for_answer());
  EXPECT_FALSE(session.idle());
  say_to(session, "ball");
  EXPECT_FALSE(session.asks().has_value());
  EXPECT_FALSE(session.scene().find("ball")->visible);
  // One thing after another, flags by their name too.
  say_to(session, "volume");
  say_to(session, "tissue");
  ASSERT_TRUE(session.asks().has_value());
  EXPECT_NE(session.asks()->find("-modulus"), std::string::npos) << *session.asks();
  session.interrupt();
  EXPECT_TRUE(session.idle());
  EXPECT_EQ(session.recording().find("volume"), std::string::npos);
}

TEST_F(SessionTest, InAScriptAMissingArgumentIsAnErrorAtItsPlace) {
  Session session = script();
  expect_fails(session, "instance_object sphere ball\n  visible\nball\n", "script:2:3: ");
  Session asked = console();
  expect_fails(asked, "visible", "the input ends before visible: OBJECT");
}

TEST_F(SessionTest, ReadingsOfADeviceAreNoAnswers) {
  write("hand.txt", "0 1 2 3\n");
  Session session = console();
  say_to(session, "instance_object sphere ball");
  say_to(session, "visible");
  ASSERT_TRUE(static_cast<bool>(session.enter_now("ball", "console")));
  EXPECT_EQ(work(session), "");
  say_to(session, "device hand -file " + (folder() / "hand.txt").string());
  say_to(session, "follow_device ball hand");
  say_to(session, "visible");
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(static_cast<bool>(session.frame()));
  EXPECT_TRUE(session.asks().has_value());
  EXPECT_LT(distance(world_sphere(*session.scene().find("ball")).centre, {1, 2, 3}), 1e-12);
}

// ---- simulating ----

TEST_F(SessionTest, SimulateStaysWhileLinesOfScriptsWaitAndOthersDoNot) {
  Session session = script();
  ASSERT_TRUE(static_cast<bool>(session.enter_text(
      kSheet + "instance_object cube box\nsimulate 10 -dt 0.1 -skip 2\nedit_xform box -t 1 0 0\n",
      "script")));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(static_cast<bool>(session.frame()));
  EXPECT_NEAR(session.scene().time, 0.4, 1e-12);  // the first frame shows the start
  EXPECT_EQ(session.scene().find("box")->transform.translation, Vec3{});
  ASSERT_TRUE(static_cast<bool>(session.enter_now("colors box -opacity 0.5", "console")));
  ASSERT_TRUE(static_cast<bool>(session.frame()));
  EXPECT_EQ(session.scene().find("box")->optics.opacity, 0.5);
  EXPECT_EQ(session.scene().find("box")->transform.translation, Vec3{});
  ASSERT_TRUE(static_cast<bool>(session.enter_now("simulate 1 -dt 0.1", "console")));
  const auto second = session.frame();
  ASSERT_FALSE(static_cast<bool>(second));
  EXPECT_NE(second.error().message().find("console:1:1: a simulation runs already"), std::string::npos);
  EXPECT_TRUE(session.idle());  // an error ends what runs and drops what waits
}

TEST_F(SessionTest, SimulateEndsByCountOrByTimeWhicheverComesFirst) {
  Session session = script();
  expect_runs(session, kSheet + "simulate 3 -dt 0.1");
  EXPECT_NEAR(session.scene().time, 0.3, 1e-12);
  expect_runs(session, "simulate -dt 0.1 -until 1");
  EXPECT_NEAR(session.scene().time, 1, 1e-12);
  expect_runs(session, "simulate -dt 0.1 -until 1");
  expect_runs(session, "simulate 0 -dt 0.1");
  expect_runs(session, "simulate -dt 0.1 -until -5");
  EXPECT_NEAR(session.scene().time, 1, 1e-12);
  expect_runs(session, "simulate 100 -dt 0.1 -until 1.2");
  EXPECT_NEAR(session.scene().time, 1.2, 1e-12);
  expect_runs(session, "simulate -1 -dt 0.1 -until 1.5 -skip 1000");
  EXPECT_NEAR(session.scene().time, 1.5, 1e-12);
  expect_runs(session, "simulate 4 -dt 0.1 -adaptive 1e-4");
  EXPECT_NEAR(session.scene().time, 1.9, 1e-12);
}

TEST_F(SessionTest, AScriptCannotSimulateForEver) {
  Session session = script();
  expect_runs(session, kSheet);
  expect_fails(session, "simulate -dt 0.1", "would never end");
  expect_fails(session, "simulate -1 -dt 0.1", "would never end");
  expect_fails(session, "simulate -dt 1e-300 -until 1", "script:1:");
  expect_fails(session, "simulate -dt 0 -until 1", "script:1:");
  EXPECT_EQ(session.scene().time, 0);
}

TEST_F(SessionTest, AtTheConsoleASimulationRunsUntilItIsInterrupted) {
  Session session = console();
  ASSERT_TRUE(
      static_cast<bool>(session.enter_text(kSheet + "simulate -1 -dt 0.1 -skip 3\nlist\n", "script")));
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(static_cast<bool>(session.frame()));
  EXPECT_FALSE(session.idle());
  session.interrupt();
  EXPECT_TRUE(session.idle());
  EXPECT_NEAR(session.scene().time, 5.7, 1e-9);
  EXPECT_NE(session.recording().find("simulate 57 -dt 0.1 -skip 3"), std::string::npos)
      << session.recording();
}

TEST_F(SessionTest, StepsTakenInPartsAreToldOnce) {
  Session session = script();
  expect_runs(session, kSheet + "simulate 20 -dt 5");
  EXPECT_EQ(notices("were taken in parts"), 1);
  EXPECT_EQ(notices("script:6:1: "), 1);
}

TEST_F(SessionTest, CancellingEndsTheSimulationAndKeepsWhatIsDone) {
  int checks = 200;
  Context context({}, {}, [&] { return --checks < 0; });
  Session session(options(), context);
  ASSERT_TRUE(static_cast<bool>(session.enter_text(kSheet + "simulate -dt 0.05 -until 1e6\n", "script")));
  const auto done = session.run();
  ASSERT_FALSE(static_cast<bool>(done));
  EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
  EXPECT_TRUE(session.idle());
  EXPECT_GT(session.scene().time, 0);
  EXPECT_NE(session.recording().find("simulate "), std::string::npos);
}

TEST_F(SessionTest, FramesAreWatchedAndTheirErrorsEndTheRun) {
  std::vector<double> times;
  SessionOptions watched = options();
  watched.frame = [&](const Scene& scene) -> Result<void> {
    times.push_back(scene.time);
    if (times.size() < 5) return {};
    return Error{ErrorKind::system, "enough", "here", "Stop"};
  };
  Session session(std::move(watched), context_);
  expect_fails(session, kSheet + "simulate 100 -dt 0.5 -skip 2", "here: enough");
  EXPECT_EQ(times, (std::vector<double>{0, 1, 2, 3, 4}));
}

// ---- pairs of samples and objects ----

TEST_F(SessionTest, ASampleAndAnObjectThatFollowEachOtherComeToRest) {
  Session session = script();
  expect_runs(session,
              kSheet + "instance_object sphere ball\nbobblot ball sheet:2:5\nblotbob sheet:2:5 ball\n");
  const auto apart = [&] {
    const Specimen& specimen = session.scene().specimen;
    return distance(world_sphere(*session.scene().find("ball")).centre, specimen.position({1, 2 * 16 + 5}));
  };
  EXPECT_LT(apart(), 1e-12);
  expect_runs(session, "edit_xform ball -t 0 0 0.25");
  EXPECT_LT(apart(), 1e-12);
  EXPECT_NEAR(session.scene().specimen.position({1, 37}).z, 0.25, 1e-9);  // the object led
  expect_runs(session, "simulate 50 -dt 0.05");
  EXPECT_LT(apart(), 1e-12);
  EXPECT_LT(session.scene().specimen.position({1, 37}).z, 0.24);  // the sample led
  EXPECT_LE(session.scene().constraints.report().loops.size(), 1U);
  expect_runs(session, "list constraints\nremove_constraint blotbob\nedit_xform ball -t 0 0 5");
  EXPECT_TRUE(heard("bobblot") && heard("ball follows sheet:2:5"));
  expect_fails(session, "remove_constraint blotbob", "there is no constraint 'blotbob'");
  expect_runs(session, "delete_object ball");
  EXPECT_TRUE(session.scene().constraints.constraints().empty());
}

TEST_F(SessionTest, AScriptDoesInOneFrameWhatTheConsoleDoesInMany) {
  const std::vector<std::string> lines{"instance_object cube rod",
                                       "instance_object sphere a",
                                       "instance_object sphere b",
                                       "edit_xform b -t 3 0 0",
                                       "link rod a b",
                                       "edit_xform b -t 0 5 0",
                                       "edit_xform a -t 0 1 0",
                                       "instance_object grid.4.4 sheet",
                                       "flesh_out sheet",
                                       "add_muscle m 5 10",
                                       "colors muscles.m -no_wire",
                                       "blotbob sheet:2:5 a",
                                       "edit_xform a -t -0.2 -0.2 0.3"};
  std::string text;
  Session many = console();
  for (const std::string& line : lines) {
    say_to(many, line);
    text += line + '\n';
  }
  Session one = script();
  expect_runs(one, text);
  EXPECT_TRUE(one.scene().find("rod")->transform == many.scene().find("rod")->transform);
  const Box3 rod = world_box(*one.scene().find("rod"));
  EXPECT_NEAR(rod.upper.y, 5, 0.6);
  EXPECT_TRUE(same_bits(one, many));
  EXPECT_NEAR(one.scene().specimen.position({1, 37}).z, 0.3, 1e-12);
}

TEST_F(SessionTest, DrawingsOfTissueAreHiddenNotDeleted) {
  Session session = script();
  expect_runs(session, kSheet);
  for (const char* name : {"muscles.pull", "skin.face.sheet", "smas.face.sheet", "bone.face.sheet"}) {
    expect_fails(session, std::string("delete_object ") + name, "is drawn as long as");
    expect_runs(session, std::string("visible ") + name + " -off");
  }
  expect_runs(session, "delete_object sheet\nsimulate 2 -dt 0.1");  // the source is no drawing
  EXPECT_FALSE(session.scene().find("muscles.pull")->visible);
}

TEST_F(SessionTest, SamplesAreFoundByNameOrByTheirNumbers) {
  Session session = script();
  expect_runs(session,
              kSheet + "blot a 0 0 3\nblot b 0 1 3 -mass 2 -fixed\nshock a b -c 2\nshock a sheet:2:0\n");
  for (const char* wrong :
       {"c", "sheet:3:0", "sheet:0:16", "sheet:-1:0", "sheet::", ":::", "other:0:0", "sheet:0:99999999999"}) {
    expect_fails(session, std::string("shock a ") + wrong, "there is no point sample");
  }
  expect_fails(session, "shock a a", "script:1:1: ");
}

// ---- devices ----

TEST_F(SessionTest, ADeviceIsPlayedFromItsFileAsTimeGoesBy) {
  const fs::path file = write("hand.txt", "; time x y z\n0 0 0 1\n0.35 0 0 2\n0.75 0 0 3\n");
  Session session = script();
  expect_runs(session, kSheet + "instance_object sphere ball\ndevice hand -file " + file.string() +
                           "\nfollow_device ball hand\n");
  const auto height = [&] { return world_sphere(*session.scene().find("ball")).centre.z; };
  expect_runs(session, "simulate 2 -dt 0.1");
  EXPECT_NEAR(height(), 1, 1e-12);
  expect_runs(session, "simulate 4 -dt 0.1");
  EXPECT_NEAR(height(), 2, 1e-12);
  expect_runs(session, "simulate 4 -dt 0.1");
  EXPECT_NEAR(height(), 3, 1e-12);
  expect_runs(session, "device hand 0 0 7");
  EXPECT_NEAR(height(), 7, 1e-12);
  Session again = script();
  expect_runs(again, session.recording());
  EXPECT_TRUE(same_bits(session, again));
  EXPECT_EQ(again.recording(), session.recording());
}

TEST_F(SessionTest, AStateHoldsWhatHasRelaxed) {
  const std::string skin = "make_skin sheet -collagen 5 -rest_strain 0.2 -relaxation 0.3 0.5\n";
  Session session = script();
  expect_runs(session, kSheet + skin + "simulate 20 -dt 0.1\nstate half\nsimulate 20 -dt 0.1\n");
  const std::string restore = "restore " + (folder() / "half.state").string() + "\nsimulate 20 -dt 0.1\n";
  Session other = script(), same = script();
  expect_runs(other, kSheet + skin + restore);
  EXPECT_TRUE(same_bits(session, other)) << "in a scene that has not moved";
  expect_runs(same, kSheet + skin + "simulate 7 -dt 0.1\n" + restore);
  EXPECT_TRUE(same_bits(session, same)) << "in one that has";
}

TEST_F(SessionTest, FramesThatPassCanBeStopped) {
  int frames = 0;
  Context impatient({}, {}, [&] { return ++frames > 50; });
  Session session(options(), impatient);
  ASSERT_TRUE(static_cast<bool>(session.enter_text("frame 1000000000", "script")));
  const auto done = session.run();
  ASSERT_FALSE(static_cast<bool>(done));
  EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
  EXPECT_TRUE(session.idle());
}

TEST_F(SessionTest, ARecordingKeepsEveryCommandInItsFrame) {
  Session session = console();
  say_to(session, "instance_object wiregrid.3.2 path");
  say_to(session, "instance_object sphere ball");
  for (const std::string& line : {std::string("mv_obj_path ball path -frames 40"), std::string("damping 0.1"),
                                  std::string("vp_track_obj main -look_at ball"), std::string("frame 7")}) {
    say_to(session, line);
  }
  expect_runs(session, kSheet);
  say_to(session, "simulate 20 -dt 0.1 -skip 3");
  ASSERT_TRUE(static_cast<bool>(session.enter_text("simulate 30 -dt 0.1 -skip 4", "console")));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(static_cast<bool>(session.frame()));
  ASSERT_TRUE(static_cast<bool>(session.enter_now("damping 0.5", "device")));
  work(session);
  say_to(session, "frame 2");
  Session again = script();
  expect_runs(again, session.recording());
  EXPECT_TRUE(same_bits(session, again));
  EXPECT_EQ(again.recording(), session.recording());
  EXPECT_EQ(again.scene().frame, session.scene().frame);
  for (const char* name : {"ball", "camera"}) {
    EXPECT_TRUE(session.scene().find(name)->transform == again.scene().find(name)->transform) << name;
  }
}

TEST_F(SessionTest, FilesThatAreNoReadingsAreRefusedByLine) {
  Session session = script();
  expect_runs(session, "instance_object sphere ball");
  for (const char* text :
       {"0 1 2\n", "0 0 0 1\n-1 0 0 1\n", "0 nan 0 0\n", "0 1e300 0 0\n", "0 0 0 x\n", "#include a\n"}) {
    const fs::path file = write("bad.txt", text);
    expect_fails(session, "device hand -file " + file.string(), "bad.txt:");
  }
  expect_fails(session, "device hand -file " + (folder() / "none").string(), "none");
  expect_fails(session, "device hand", "a device needs a reading");
  expect_fails(session, "follow_device ball hand", "there is no device 'hand'");
}

// ---- views ----

TEST_F(SessionTest, WorldsViewportsAndCamerasAreMadeAndChanged) {
  Session session = script();
  expect_runs(session,
              "instance_object cube box\nworld closeup\ninstance_object sphere ball\npost box\nunpost box "
              "-world main\n"
              "camera above -eye 0 0 5 -up 0 1 0 -height 2\ncamera camera -fov 50\nlight sun -from 1 0 1 "
              "-strength 2\n"
              "viewport top -at 0.5 0.5 1 1 -camera above -style wire -title -border -stereo -eyes 0.1\n"
              "viewport main -world closeup\nscreen -size 320 200 -background 0 0.5 1\n");
  const Scene& scene = session.scene();
  ASSERT_EQ(scene.worlds.size(), 2U);
  EXPECT_EQ(scene.worlds[0].objects, (std::vector<std::string>{"camera"}));
  EXPECT_EQ(scene.worlds[1].objects, (std::vector<std::string>{"ball", "box", "above", "sun"}));
  ASSERT_EQ(scene.screen.viewports.size(), 2U);
  EXPECT_EQ(scene.screen.viewports[0].world, "closeup");
  const Viewport& top = scene.screen.viewports[1];
  EXPECT_EQ(top.camera, "above");
  EXPECT_TRUE(top.stereo && top.title && top.border && top.style == DrawStyle::wire &&
              top.eye_separation == 0.1);
  EXPECT_EQ(scene.screen.width, 320);
  EXPECT_EQ(std::get<CameraLens>(scene.find("above")->description).fov_deg, 0);
  EXPECT_EQ(std::get<CameraLens>(scene.find("camera")->description).fov_deg, 50);
  expect_runs(session, "list worlds\nlist viewports\nviewport top -mono -plain -off\nviewport main -remove");
  EXPECT_TRUE(heard("closeup (current): ball box above sun"));
  EXPECT_TRUE(heard("camera above, world closeup, wire, stereo"));
  ASSERT_EQ(scene.screen.viewports.size(), 1U);
  EXPECT_FALSE(scene.screen.viewports[0].visible);
}

TEST_F(SessionTest, ViewsOfWhatIsNotThereAreErrors) {
  Session session = script();
  expect_runs(session, "instance_object cube box");
  expect_fails(session, "viewport main -camera box", "there is no camera 'box'");
  expect_fails(session, "viewport main -world nowhere", "there is no world 'nowhere'");
  expect_fails(session, "viewport none -remove", "there is no viewport 'none'");
  expect_fails(session, "post box -world nowhere", "there is no world 'nowhere'");
  expect_fails(session, "camera box -eye 0 0 1", "'box' is a polyhedron");
  expect_fails(session, "camera camera -eye 0 0 0 -look_at 0 0 0", "script:1:1: ");
  expect_fails(session, "light camera", "'camera' is a camera");
}

TEST_F(SessionTest, ALayerThatTheTissueHasNotIsAnError) {
  Session session = script();
  expect_fails(session, "instance_object sphere ball\ndrape -s ball -layer 1", "there is no tissue yet");
  expect_runs(session, kSheet + "drape -s ball -layer 1");
  expect_fails(session, "drape -s ball -layer 3", "'sheet' has no layer 3");
}

// ---- output ----

TEST_F(SessionTest, PicturesNeedSomethingThatDraws) {
  Session session = script();
  expect_fails(session, "picture a", "draws no pictures");
  std::vector<fs::path> drawn;
  SessionOptions drawing = options();
  drawing.picture = [&](const Scene&, const fs::path& path) -> Result<void> {
    drawn.push_back(path);
    return {};
  };
  Session second(std::move(drawing), context_);
  expect_runs(second, "picture a");
  EXPECT_EQ(drawn, (std::vector<fs::path>{folder() / "a.png"}));
  for (const char* name : {"../a", "/tmp/a", ".a", "a/b"})
    expect_fails(second, std::string("picture ") + name, "not the name of a file");
}

TEST_F(SessionTest, AStateIsRestoredToTheBit) {
  Session session = script();
  expect_runs(
      session,
      kSheet + "muscle_set pull -scale 0.5\nsimulate 20 -dt 0.05\nstate kept\nsimulate 20 -dt 0.05\n");
  EXPECT_TRUE(fs::exists(folder() / "kept.state") && fs::exists(folder() / "kept.vtu"));
  Session again = script();
  expect_runs(again, kSheet + "muscle_set pull -scale 0.5\nrestore " + (folder() / "kept.state").string() +
                         "\nstate again\n");
  EXPECT_EQ(*read_text_file(folder() / "kept.state"), *read_text_file(folder() / "again.state"));
  expect_runs(again, "simulate 20 -dt 0.05");
  EXPECT_TRUE(same_bits(session, again));
}

TEST_F(SessionTest, DamagedStatesAreRefused) {
  Session session = script();
  expect_runs(session, kSheet + "state good");
  const std::string good = *read_text_file(folder() / "good.state");
  const auto refused = [&](const std::string& text, const std::string& expected) {
    write("bad.state", text);
    expect_fails(session, "restore " + (folder() / "bad.state").string(), expected);
  };
  refused("", "script:1:1: ");
  refused("[]", "this is no state");
  refused("{\"format\":1}", "this is no state");
  refused(good.substr(0, good.size() / 2), "this is no state");
  refused("{\"format\":\"turgor state 1\"}", "the time is missing");
  refused("{\"format\":\"turgor state 1\",\"time\":\"0\"}", "the time is missing");
  refused("{\"format\":\"turgor state 1\",\"time\":0}", "a list of numbers is missing");
  refused("{\"format\":\"turgor state 1\",\"time\":0,\"position\":[[0,0]],\"velocity\":[]}",
          "not of three numbers");
  refused("{\"format\":\"turgor state 1\",\"time\":0,\"position\":[],\"velocity\":[]}", "the tissue has 48");
  std::string wild = good;
  wild.replace(wild.find("[["), 2, "[[1e300,0,0],[");
  refused(wild, "script:1:1: ");
  expect_fails(session, "restore " + (folder() / "none.state").string(), "none.state");
  expect_runs(session, "restore " + (folder() / "good.state").string());
}

// ---- talk ----

TEST_F(SessionTest, ListsHelpAndMenuAreSaid) {
  Session session = console();
  say_to(session, "help");
  EXPECT_TRUE(heard("flesh_out"));
  say_to(session, "help simulate");
  EXPECT_TRUE(heard("-runge_kutta"));
  say_to(session, "menu");
  EXPECT_TRUE(heard("instance_object"));
  for (const std::string& line : {std::string("instance_object cube box"), kSheet}) say_to(session, line);
  said_.clear();
  say_to(session, "list");
  say_to(session, "list tissue");
  say_to(session, "list muscles");
  EXPECT_TRUE(heard("box") && heard("sheet: 48 samples") && heard("pull"));
  ASSERT_TRUE(static_cast<bool>(session.enter_text("menu 1000", "console")));
  EXPECT_NE(work(session).find("the menu has no entry 1000"), std::string::npos);
}

TEST_F(SessionTest, AnEntryOfTheMenuAsksForWhatItNeeds) {
  Session session = console();
  const auto all = scene_commands().commands;
  const auto damping =
      std::find_if(all.begin(), all.end(), [](const auto& c) { return c.name == "damping"; });
  say_to(session, "menu " + std::to_string(damping - all.begin() + 1));
  ASSERT_TRUE(session.asks().has_value());
  EXPECT_EQ(session.asks()->find("damping: "), 0U);
  say_to(session, "0.7");
  EXPECT_EQ(session.scene().specimen.damping(), 0.7);
  EXPECT_NE(session.recording().find("damping 0.7"), std::string::npos);
  EXPECT_EQ(session.recording().find("menu"), std::string::npos);
}

TEST_F(SessionTest, QuitLeavesTheRestOut) {
  Session session = script();
  expect_runs(session, "instance_object cube a\nquit\ninstance_object cube b\n");
  EXPECT_TRUE(session.finished());
  EXPECT_EQ(session.scene().find("b"), nullptr);
  Session running = console();
  ASSERT_TRUE(static_cast<bool>(running.enter_text(kSheet + "simulate -1 -dt 0.1\n", "script")));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(static_cast<bool>(running.frame()));
  ASSERT_TRUE(static_cast<bool>(running.enter_now("quit", "console")));
  ASSERT_TRUE(static_cast<bool>(running.frame()));
  EXPECT_TRUE(running.finished() && running.idle());
}

TEST_F(SessionTest, ARecordingLeadsToTheSameBits) {
  Session session = console();
  ASSERT_TRUE(static_cast<bool>(
      session.enter_text(kSheet + "instance_object sphere ball\nedit_xform ball -t 0 0 -0.6\n"
                                  "drape -c 100 -s ball\nsetup twitch pull 0 1 1 0.5\n"
                                  "simulate -1 -dt 0.03 -skip 3 -runge_kutta\n",
                         "script")));
  const auto frames = [&](int count) {
    for (int i = 0; i < count; ++i) ASSERT_TRUE(static_cast<bool>(session.frame()));
  };
  frames(5);
  ASSERT_TRUE(static_cast<bool>(session.enter_now("damping 0.05", "console")));
  frames(3);
  ASSERT_TRUE(static_cast<bool>(session.enter_now("edit_xform ball -t 0.1 0 -0.5", "console")));
  ASSERT_TRUE(static_cast<bool>(session.enter_now("list tissue", "console")));
  frames(4);
  ASSERT_TRUE(static_cast<bool>(session.enter_now("remove sheet -sphere -0.5 -0.5 0.2 0.3", "console")));
  frames(4);
  session.interrupt();
  say_to(session, "refine sheet -above 0.02 -below 0.01");
  say_to(session, "simulate 10 -dt 0.02 -adaptive 1e-5");
  say_to(session, "record " + (folder() / "all.turgor").string());
  EXPECT_EQ(*read_text_file(folder() / "all.turgor"), session.recording());
  Session again = script();
  ASSERT_TRUE(static_cast<bool>(again.enter_script(folder() / "all.turgor")));
  const auto done = again.run();
  ASSERT_TRUE(static_cast<bool>(done)) << done.error().message();
  EXPECT_TRUE(same_bits(session, again));
  EXPECT_EQ(again.recording(), session.recording());
}

// ---- the library ----

TEST_F(SessionTest, ViewScriptsAndObjectsOfTheLibraryAreUsedWithANotice) {
  Session session = script();
  expect_runs(
      session,
      "#include lookat_wound\n#include /u/pieper/lookat.balldrape\ninstance_object data/grid.3.3 g\n");
  EXPECT_EQ(notices("lookat_wound"), 1);
  EXPECT_GE(notices("lookat.balldrape"), 1);
  EXPECT_EQ(notices("data/grid.3.3"), 1);
  EXPECT_FALSE(static_cast<bool>(session.enter_text("#include lookat.nothing", "t")));
}

TEST_F(SessionTest, AnAbsolutePathIsFoundByItsLastPartOnTheSearchPath) {
  write("bone.object", "name bone\nshape cube\n");
  SessionOptions searching = options();
  searching.search_paths = {folder()};
  Session session(std::move(searching), context_);
  expect_runs(session, "instance_object /u/pieper/data/bone.object\nsave_object bone " +
                           (folder() / "copy.object").string() + "\ninstance_object copy.object copy\n");
  EXPECT_EQ(notices("/u/pieper/data/bone.object"), 1);
  EXPECT_NE(session.scene().find("copy"), nullptr);
  expect_fails(session, "instance_object /u/pieper/data/nothing", "script:1:1: ");
}

// ---- wild ----

TEST_F(SessionTest, ANameThatNoDrawingCanBearIsRefused) {
  Session session = script();
  expect_runs(session, kSheet);
  expect_fails(session, "add_muscle 'a;b' 0 1", "script:1:1: ");
  expect_runs(session, "simulate 1 -dt 0.1");
}

TEST_F(SessionTest, EnormousNumbersOfStepsCanBeStopped) {
  int checks = 50;
  Context context({}, {}, [&] { return --checks < 0; });
  Session session(options(), context);
  ASSERT_TRUE(static_cast<bool>(
      session.enter_text(kSheet + "simulate 1000000000000 -dt 1e-300 -skip 1000000\n", "s")));
  const auto done = session.run();
  ASSERT_FALSE(static_cast<bool>(done));
  EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace turgor
