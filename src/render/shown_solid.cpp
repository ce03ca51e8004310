#include "render/shown_solid.hpp"

#include <cmath>
#include <utility>

#include "turgor/core/index.hpp"

namespace turgor::render_detail {
namespace {

/// Cosine of the angle between triangles from which an edge is sharp: 40 degrees.
constexpr double kSmooth = 0.766;

/// Shown points that copy one point, each with the normals of its triangles.
struct Copy {
  int number = 0;
  Vec3 normal;
};

}  // namespace

Result<ShownSolid> ShownSolid::create(const SolidMesh& solid, const TriMesh* skin) {
  ShownSolid out;
  TriMesh surface{{solid.points.begin(), solid.points.end()},
                  {solid.surface_triangles.begin(), solid.surface_triangles.end()}};
  if (skin != nullptr) {
    TURGOR_TRY(out.skin_, TetraEmbedding::bind(solid.points, solid.tetrahedra, skin->points));
    surface = *skin;
  }
  std::vector<std::vector<Copy>> copies(surface.points.size());
  for (const Index3& t : surface.triangles) {
    const Vec3 area = triangle_normal(surface, t);
    const double size = length(area);
    const Vec3 normal = size > 0 ? area / size : Vec3{0, 0, 1};
    Index3 corners{};
    for (std::size_t c = 0; c < 3; ++c) {
      auto& here = copies[at(t[c])];
      const Copy* same = nullptr;
      for (const Copy& copy : here)
        if (same == nullptr && dot(copy.normal, normal) > kSmooth) same = &copy;
      if (same == nullptr) {
        here.push_back({static_cast<int>(out.source_.size()), normal});
        out.source_.push_back(t[c]);
        same = &here.back();
      }
      corners[c] = same->number;
    }
    out.triangles_.push_back(corners);
  }
  return out;
}

std::vector<Vec3> ShownSolid::carried(std::span<const Vec3> values) const {
  std::vector<Vec3> skin, out;
  if (skin_) {
    skin.resize(skin_->places().size());
    skin_->apply(values, skin);
    values = skin;
  }
  for (const int s : source_) out.push_back(values[at(s)]);
  return out;
}

std::vector<double> ShownSolid::carried(std::span<const double> values) const {
  std::vector<Vec3> wide;
  for (const double v : values) wide.push_back({v, 0, 0});
  std::vector<double> out;
  for (const Vec3& v : carried(wide)) out.push_back(v.x);
  return out;
}

}  // namespace turgor::render_detail
