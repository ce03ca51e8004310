#include "turgor/world/object_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <filesystem>
#include <sstream>

#include "turgor/core/file.hpp"
#include "turgor/core/random.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/world/object_constraints.hpp"

namespace turgor {
namespace {
namespace fs = std::filesystem;

/// A folder for as long as a test runs.
class Folder {
 public:
  Folder()
      : path_(fs::temp_directory_path() / ("turgor_objects_" + std::to_string(::getpid()) + "_" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  fs::path write(const std::string& name, std::string_view text) const {
    fs::create_directories((path_ / name).parent_path());
    EXPECT_TRUE(static_cast<bool>(write_file(path_ / name, text)));
    return path_ / name;
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

constexpr std::string_view kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

Object loaded(const std::string& name, const ObjectSource& source, Context& context) {
  auto object = load_object(name, source, context);
  EXPECT_TRUE(static_cast<bool>(object)) << name << ": " << (object ? "" : object.error().message());
  return object ? *std::move(object) : Object{};
}
Object parsed(std::string_view text) {
  auto object = parse_object(text, "test.object");
  EXPECT_TRUE(static_cast<bool>(object)) << text << (object ? "" : object.error().message());
  return object ? *std::move(object) : Object{};
}
std::size_t point_count(const Object& object) {
  return std::get<Polyhedron>(object.description).points.size();
}

TEST(ObjectFile, WhatTheThesisNamesIsFoundInOurLibrary) {
  Context context;
  const Object grid = loaded("data/grid.10.10", {}, context);
  EXPECT_EQ(grid.name, "grid.10.10");
  EXPECT_EQ(point_count(grid), 100U);
  EXPECT_EQ(point_count(loaded("data/wiregrid.5.5", {}, context)), 25U);
  const Object sheet = loaded("/u/pieper/data/fusiform", {}, context);
  EXPECT_EQ(sheet.name, "fusiform");
  EXPECT_EQ(point_count(sheet), 174U);
  const Object ball = loaded("data/sphere.obj", {}, context);
  EXPECT_EQ(ball.name, "sphere");
  EXPECT_TRUE(ball.file.empty());
  const BoundingSphere sphere = world_sphere(ball);
  EXPECT_LT(distance(sphere.centre, {0, 0, -0.2}), 1e-12);
  EXPECT_NEAR(sphere.radius, 0.2, 1e-12);
  ASSERT_EQ(context.notices().size(), 4U);
  EXPECT_NE(context.notices()[0].text.find("data/grid.10.10"), std::string::npos);

  Context silent;
  EXPECT_EQ(loaded("fusiform", {}, silent).name, "fusiform");
  EXPECT_EQ(loaded("fusiform.obj", {}, silent).name, "fusiform");
  EXPECT_EQ(loaded("grid.4.5", {}, silent).name, "grid.4.5");
  EXPECT_EQ(loaded("grid.4.5.obj", {}, silent).name, "grid.4.5");
  EXPECT_TRUE(silent.notices().empty());
}

TEST(ObjectFile, FilesComeBeforeSearchPathsAndTheseBeforeTheLibrary) {
  const Folder folder;
  folder.write("near/sphere.obj", kTriangle);
  folder.write("far/data/sphere.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n");
  const ObjectSource source{{folder.path() / "near", folder.path() / "far"}};
  Context context;
  EXPECT_EQ(point_count(loaded("sphere.obj", source, context)), 3U);
  EXPECT_EQ(point_count(loaded("data/sphere.obj", source, context)), 4U);
  const std::string file = (folder.path() / "far/data/sphere.obj").string();
  const Object direct = loaded(file, source, context);
  EXPECT_EQ(point_count(direct), 4U);
  EXPECT_EQ(direct.file, file);
  EXPECT_EQ(direct.name, "sphere");
  EXPECT_TRUE(context.notices().empty());
  EXPECT_EQ(point_count(loaded("/u/pieper/sphere.obj", source, context)), 3U);
  ASSERT_EQ(context.notices().size(), 1U);
  EXPECT_NE(context.notices()[0].text.find("/u/pieper/sphere.obj"), std::string::npos);
  // A folder of a primitive's name is no file.
  fs::create_directories(folder.path() / "near/cube");
  EXPECT_EQ(point_count(loaded("cube", source, context)), 8U);
}

TEST(ObjectFile, MeshesAndObjectFilesAreNamedAfterTheirFile) {
  const Folder folder;
  folder.write("shapes/wedge.OBJ", kTriangle);
  const auto file =
      folder.write("my.tent.object", "name other\nmesh shapes/wedge.OBJ ; beside this file\nscale 2 2 2\n");
  Context context;
  const Object tent = loaded(file.string(), {}, context);
  EXPECT_EQ(tent.name, "my.tent");
  EXPECT_EQ(tent.file, file.string());
  EXPECT_EQ(world_box(tent).upper, (Vec3{2, 2, 0}));
  const auto missing = folder.write("b.object", "\n\nmesh nothing.ply\n");
  const auto broken = load_object(missing.string(), {}, context);
  ASSERT_FALSE(static_cast<bool>(broken));
  EXPECT_EQ(broken.error().where, missing.string() + ":3");
  EXPECT_NE(broken.error().what.find("nothing.ply"), std::string::npos);
}

TEST(ObjectFile, WhatDoesNotExistNamesTheNearest) {
  Context context;
  const auto refusal = [&](const std::string& name) {
    const auto object = load_object(name, {}, context);
    EXPECT_FALSE(static_cast<bool>(object)) << name;
    return object ? std::string() : object.error().message();
  };
  EXPECT_NE(refusal("data/fusifrom").find("fusiform"), std::string::npos);
  EXPECT_NE(refusal("/x/spere.obj").find("sphere"), std::string::npos);
  EXPECT_NE(refusal("data/grid.3000.3000").find("4 million"), std::string::npos);
  EXPECT_NE(refusal("data/grid.10").find("grid"), std::string::npos);
  for (const std::string& name :
       {std::string(), std::string("/"), std::string("data/"), std::string(".."), std::string(100'000, 'x'),
        std::string("a\0b", 3), std::string("\x01\xff")}) {
    EXPECT_FALSE(refusal(name).empty());
  }
}

TEST(ObjectFile, TransformsActInTheOrderOfTheirLines) {
  const Object object = parsed("shape cube\nscale 2 1 1\nrotate 0 0 90\ntranslate 0 0 1\ntranslate 0 0 2\n");
  EXPECT_LT(distance(object.transform.point({1, 0, 0}), {0, 2, 3}), 1e-12);
  const Object other = parsed("shape cube\nrotate 0 0 90\nscale 2 1 1\norigin 1 1 1");
  EXPECT_LT(distance(other.transform.point({2, 1, 1}), {1, 2, 1}), 1e-12);
  const Object matrix = parsed("shape cube\nrotate 1 2 3\nmatrix 1 2 3 4  5 6 7 8  9 10 11 12");
  EXPECT_EQ(matrix.transform.point({1, 0, 0}), (Vec3{5, 13, 21}));
}

Object random_object(std::uint64_t seed) {
  const RandomStream random(seed);
  std::uint64_t drawn = 0;
  // Of every magnitude, either zero, and the smallest numbers there are.
  const auto number = [&]() -> double {
    for (;;) {
      const double x = std::bit_cast<double>(random.bits(drawn++));
      if (drawn % 17 == 0) return -0.0;
      if (std::isfinite(x)) return drawn % 5 == 0 ? x * 0x1p-1000 : std::remainder(x, 1e3);
    }
  };
  const auto below = [&](int n) { return static_cast<int>(random.uniform(drawn++) * n); };
  const auto vec = [&] { return Vec3{number(), number(), number()}; };
  const auto colour = [&] {
    const auto part = [&] { return static_cast<float>(random.uniform(drawn++)); };
    return Vec3f{part(), part(), part()};
  };
  Object o;
  o.name = "object." + std::to_string(seed);
  o.file = "test.object";
  o.transform = {Mat3{{vec(), vec(), vec()}}, vec(), vec()};
  o.visible = below(2) == 0, o.triangulated = below(2) == 0;
  o.optics = {below(2) == 0 ? Shading::faceted : Shading::smooth,
              colour(),
              colour(),
              std::abs(number()),
              std::nullopt,
              0.5 + random.uniform(drawn++),
              below(2) == 0,
              random.uniform(drawn++)};
  if (below(2) == 0) o.optics.wire = colour();
  const int kind = below(4);
  if (kind == 0) {
    Polyhedron p;
    for (int i = 0; i < 8; ++i) p.points.push_back(vec());
    for (int i = below(4); i > 0; --i) p.add_polygon(std::vector<int>{i, i + 1, i + 2, 7});
    for (int i = below(4); i > 0; --i) p.lines.push_back({i, 0});
    o.description = p;
  } else if (kind == 1) {
    o.description = CameraLens{random.uniform(drawn++) * 169, std::abs(number()) + 1, std::abs(number()) + 1};
  } else if (kind == 2) {
    o.description = Light{colour(), std::abs(number())};
  } else {
    DepthMap map{2 + below(3), 2 + below(3), {}};
    for (int i = map.columns * map.rows; i > 0; --i) map.heights.push_back(number());
    o.description = map;
  }
  return o;
}

TEST(ObjectFile, TextReadsBackAsTheSameBits) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const Object object = random_object(seed);
    ASSERT_TRUE(static_cast<bool>(validate(object)));
    const std::string text = object_text(object);
    const Object again = parsed(text);
    EXPECT_EQ(again.name, object.name);
    EXPECT_EQ(again.file, object.file);
    EXPECT_TRUE(same_description(again.description, object.description)) << text;
    EXPECT_EQ(again.transform, object.transform) << text;
    // Signs of zeros, and all that is not compared above.
    EXPECT_EQ(object_text(again), text);
  }
  for (const char* name : {"sphere", "cube", "line", "fusiform", "wiregrid.3.4"}) {
    const Object object = *make_primitive(name);
    EXPECT_TRUE(same_description(parsed(object_text(object)).description, object.description)) << name;
  }
}

TEST(ObjectFile, DamagedFilesAreRefusedByLine) {
  struct Case {
    std::string text;
    int line;
    std::string says;
  };
  const std::vector<Case> cases{
      {"shape cube\nshpae cube\n", 2, "shape"},
      {"shape\n", 1, "shape PRIMITIVE"},
      {"shape cube\n; comment\n\nshape cube\n", 4, "second time"},
      {"shape kube\n", 1, "cube"},
      {"shape grid.4000.4000\n", 1, "4 million"},
      {"shape cube\ntranslate 1 2\n", 2, "translate X Y Z"},
      {"shape cube\ntranslate 1 2 3 4\n", 2, "translate X Y Z"},
      {"shape cube\ntranslate 1 2 nan\n", 2, "translate X Y Z"},
      {"shape cube\ntranslate 1 2 1e999\n", 2, "translate X Y Z"},
      {"shape cube\ntranslate 1 2 0x3\n", 2, "translate X Y Z"},
      {"shape cube\nscale 1e308 1e308 1e308\nscale 1e308 1 1\n", 3, "finite"},
      {"shape cube\nopacity 2\nvisible yes\n", 2, "opacity"},
      {"shape cube\nspecular -1\n", 2, "specular"},
      {"shape cube\ndiffuse 1 -1 0\n", 2, "diffuse"},
      {"shape cube\nvisible maybe\n", 2, "yes|no"},
      {"shape cube\nshading shiny\n", 2, "faceted|smooth"},
      {"name \"a\"\nshape cube\n", 1, "quote"},
      {"camera\nfov 180\n", 2, "angle"},
      {"camera\nheight 0\n", 2, "height"},
      {"shape cube\nfov 30\n", 2, "camera"},
      {"fov 30\ncamera\n", 1, "camera"},
      {"light\nstrength nan\n", 2, "strength"},
      {"points -1\n", 1, "points COUNT"},
      {"points 99999999999\n", 1, "points COUNT"},
      {"points 2000000000\n0 0 0\n", 2, "ends after 1"},
      {"points 2\n0 0 0\n0 0\n", 3, "three numbers"},
      {"points 2\n0 0 0\n0 0 inf\n", 3, "finite"},
      {"polygons 1\n0 1 2\n", 1, "after the points"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\npolygons 1\n0 1 3\n", 6, "not the number of a point"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\npolygons 1\n0 1 -1\n", 6, "not the number of a point"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\npolygons 1\n0 1 1\n", 6, "twice"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\npolygons 1\n0 1\n", 6, "three corners"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\nlines 1\n0 0\n", 6, "twice"},
      {"points 3\n0 0 0\n1 0 0\n0 1 0\nlines 1\n0 1 2\n", 6, "two ends"},
      {"depth_map 1 5\n", 1, "two columns"},
      {"depth_map 2000000000 2000000000\n1 2\n", 2, "2000000000"},
      {"depth_map 2 2\n1 2\n1 x\n", 3, "finite"},
      {"depth_map 2 2\n1 2\n", 2, "ends after 1"},
  };
  for (const Case& c : cases) {
    const auto object = parse_object(c.text, "bad.object");
    ASSERT_FALSE(static_cast<bool>(object)) << c.text;
    EXPECT_EQ(object.error().kind, ErrorKind::bad_input);
    EXPECT_EQ(object.error().where, "bad.object:" + std::to_string(c.line)) << c.text;
    EXPECT_NE(object.error().message().find(c.says), std::string::npos) << object.error().message();
  }
  for (const char* text : {"", "; nothing\n", "visible yes\n"}) {
    EXPECT_FALSE(static_cast<bool>(parse_object(text, "bad.object"))) << text;
  }
}

// Cut anywhere, or with any one byte changed, a file is read or refused.
TEST(ObjectFile, MangledFilesNeverCrash) {
  const RandomStream random(7);
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const std::string text = object_text(random_object(seed));
    for (std::size_t cut = 0; cut < text.size(); cut += 3) {
      (void)parse_object(std::string_view(text).substr(0, cut), "cut.object");
    }
    for (std::uint64_t k = 0; k < 300; ++k) {
      std::string changed = text;
      const auto place =
          static_cast<std::size_t>(random.uniform(2 * (seed * 300 + k)) * static_cast<double>(text.size()));
      changed[place] = static_cast<char>(random.bits(2 * (seed * 300 + k) + 1));
      if (const auto object = parse_object(changed, "changed.object")) {
        EXPECT_TRUE(static_cast<bool>(validate(*object)));
      }
    }
  }
}

TEST(ObjectFile, ExamplesOfTheDocumentationAreRead) {
  const auto page = read_text_file(fs::path(TURGOR_SOURCE_DIR) / "docs/object-files.md");
  ASSERT_TRUE(static_cast<bool>(page));
  int examples = 0;
  std::istringstream lines(*page);
  std::string line, example;
  bool inside = false;
  while (std::getline(lines, line)) {
    if (line == "```object") {
      inside = true, example.clear();
    } else if (inside && line == "```") {
      inside = false, ++examples;
      parsed(example);
    } else if (inside) {
      example += line + '\n';
    }
  }
  EXPECT_GE(examples, 5);
}

// The views of the thesis's scripts hold what they are to show, in a picture of 4 by 3.
TEST(ObjectFile, ViewsOfTheLibraryShowTheirScenes) {
  struct View {
    const char* name;
    std::vector<Box3> shown;
  };
  const std::vector<View> views{
      {"lookat_wound", {{{-0.5, -0.5, 0}, {0.5, 0.5, 0.14}}}},
      {"lookat.balldrape", {{{-0.5, -0.5, -0.25}, {0.5, 0.5, 0.2}}, {{-0.2, -0.2, -0.25}, {0.2, 0.2, 0}}}},
      {"lockat-twitch", {{{-0.5, -0.5, -0.45}, {0.5, 0.5, 0.29}}}},
  };
  for (const View& view : views) {
    const std::string* const text = library_script(view.name);
    ASSERT_NE(text, nullptr) << view.name;
    EXPECT_EQ(library_script(std::string("some/where/") + view.name), text);
    Vec3 eye, target;
    double fov = 0;
    const std::size_t at = text->find("\ncamera camera -eye ");
    ASSERT_NE(at, std::string::npos);
    ASSERT_EQ(std::sscanf(text->c_str() + at, " camera camera -eye %lf %lf %lf -look_at %lf %lf %lf -fov %lf",
                          &eye.x, &eye.y, &eye.z, &target.x, &target.y, &target.z, &fov),
              7);
    const auto camera = look_at(eye, target, {0, 0, 1});
    ASSERT_TRUE(static_cast<bool>(camera));
    EXPECT_GT(eye.z, target.z) << "from above";
    EXPECT_LT(eye.y, target.y) << "from the front";
    const double half_height = std::tan(radians(fov / 2)), half_width = half_height * 4 / 3;
    double reach = 0;
    for (const Box3& box : view.shown) {
      for (const Vec3& corner : box_polyhedron(box).points) {
        const Vec3 seen = camera->linear.transposed() * (corner - eye);
        reach = std::max(
            {reach, std::abs(seen.x / -seen.z) / half_width, std::abs(seen.y / -seen.z) / half_height});
      }
    }
    EXPECT_LT(reach, 0.98) << view.name;
    EXPECT_GT(reach, 0.6) << view.name;
  }
  EXPECT_EQ(library_script("lookat"), nullptr);
}

}  // namespace
}  // namespace turgor
