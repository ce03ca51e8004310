// Edits of scanned surfaces with all their flaws.
#include <gtest/gtest.h>

#include <filesystem>

#include "shapes.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/geometry/mesh_file.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

class RealMesh : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const fs::path path =
        fs::path(TURGOR_SOURCE_DIR).parent_path() / "shared" / "data" / "meshes" / GetParam();
    if (!fs::exists(path)) GTEST_SKIP() << "no shared/data/meshes beside the project";
    auto mesh = read_mesh(path);
    ASSERT_TRUE(mesh) << mesh.error().message();
    mesh_ = *std::move(mesh);
    // To the size of a head.
    const Box3 box = bounds(mesh_);
    const double scale = 200 / std::max({box.size().x, box.size().y, box.size().z});
    for (Vec3& p : mesh_.points) p = (p - box.centre()) * scale;
  }
  TriMesh mesh_;
};

class FineRealMesh : public RealMesh {};

TEST_P(FineRealMesh, IsReducedToTheNumberAskedForWithoutNewFlaws) {
  const Topology before = topology(mesh_);
  const int target = static_cast<int>(mesh_.triangles.size() / 10);
  double error = 0;
  const TriMesh reduced = decimate(mesh_, target, &error);
  EXPECT_TRUE(validate(reduced));
  EXPECT_LE(reduced.triangles.size(), static_cast<std::size_t>(target));
  EXPECT_GE(reduced.triangles.size(), static_cast<std::size_t>(0.99 * target));
  const Topology after = topology(reduced);
  EXPECT_EQ(after.non_manifold_edges, 0);
  if (before.boundary_edges == 0) {
    EXPECT_EQ(after.boundary_edges, 0);
  }
  EXPECT_NEAR(surface_area(reduced) / surface_area(mesh_), 1, 0.05);
  // Every point of the original has the reduced surface near it.
  const SurfaceQuery query(reduced);
  double worst = 0;
  for (std::size_t i = 0; i < mesh_.triangles.size(); i += 17) {
    const Vec3& p = mesh_.points[static_cast<std::size_t>(mesh_.triangles[i][0])];
    worst = std::max(worst, query.nearest(p)->distance);
  }
  EXPECT_LT(worst, 5);
}

TEST_P(RealMesh, IsCutByPlanesInAnyPosition) {
  const Topology before = topology(mesh_);
  const RandomStream random(12);
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Plane plane{testing::random_direction(random, i), 60 * random.uniform(i) - 30};
    double total = 0;
    for (const double side : {1.0, -1.0}) {
      const TriMesh half = clip(mesh_, {plane.normal * side, plane.offset * side}, true);
      EXPECT_TRUE(validate(half));
      if (before.closed()) {
        EXPECT_TRUE(topology(half).closed()) << i;
      }
      if (before.boundary_edges == 0) {
        EXPECT_EQ(topology(half).boundary_edges, 0) << i;
      }
      total += enclosed_volume(half);
    }
    if (before.boundary_edges == 0) {
      EXPECT_NEAR(total, enclosed_volume(mesh_), 1e-3 + 1e-6 * enclosed_volume(mesh_));
    }
  }
}

TEST_P(FineRealMesh, IsSmoothedWithoutLosingItsVolume) {
  const TriMesh smoothed = smooth(mesh_, 10, 0.1);
  EXPECT_TRUE(validate(smoothed));
  EXPECT_NEAR(enclosed_volume(smoothed) / enclosed_volume(mesh_), 1, 0.01);
}

const auto short_name = [](const auto& info) {
  const std::string name = info.param;
  return name.substr(0, name.find_first_of("._"));
};
// The gear has long thin triangles and only sharp edges: nothing to smooth or reduce.
INSTANTIATE_TEST_SUITE_P(Scans, RealMesh,
                         ::testing::Values("bunny.ply", "gear.ply", "happy_15535.ply",
                                           "dragon_vrip_res2.ply"),
                         short_name);
INSTANTIATE_TEST_SUITE_P(Scans, FineRealMesh,
                         ::testing::Values("bunny.ply", "happy_15535.ply", "dragon_vrip_res2.ply"),
                         short_name);

}  // namespace
}  // namespace turgor
