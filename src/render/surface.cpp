#include "render/surface.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "render/shading.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::render_detail {
namespace {

/// Two faces at a point share a normal there when they turn by less than this: noise of scans is smoothed
/// over, the rim where a surface was clipped is not.
constexpr double crease_cosine = 0.5;

constexpr std::size_t grain = 4096;

Result<void> check(const Body& body, std::size_t number) {
  const auto bad = [&](std::string what, std::string remedy) {
    return Error{ErrorKind::bad_input, std::move(what), "body " + std::to_string(number) + " of the picture",
                 std::move(remedy)};
  };
  if (!body.mesh || body.mesh->empty()) return bad("the mesh has no triangles", "Leave empty bodies out");
  const TriMesh& mesh = *body.mesh;
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!is_finite(mesh.points[i]) || !is_finite(to_float(mesh.points[i])))
      return bad("point " + std::to_string(i) + " of the mesh is not a finite number", "Repair the mesh");
  const int count = static_cast<int>(mesh.points.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const int p : mesh.triangles[i])
      if (p < 0 || p >= count)
        return bad("triangle " + std::to_string(i) + " names a point that does not exist", "Repair the mesh");
  if (!body.point_colours.empty() && body.point_colours.size() != mesh.points.size())
    return bad(std::to_string(body.point_colours.size()) + " colours do not match " +
                   std::to_string(mesh.points.size()) + " points",
               "Give one colour per point or none");
  for (const Vec3f& c : body.point_colours)
    if (!is_finite(c)) return bad("a point's colour is not a finite number", "Replace missing values first");
  if (!is_finite(body.material.colour))
    return bad("the colour is not a finite number", "Give linear RGB from 0 to 1");
  if (!(body.material.opacity >= 0 && body.material.opacity <= 1))
    return bad("the opacity is not in [0, 1]", "Use 1 for a solid body");
  if (!is_finite(body.material.highlight) ||
      !(body.material.exponent >= 0 && std::isfinite(body.material.exponent)))
    return bad("the highlight's colour or exponent is not usable",
               "Give linear RGB, and an exponent of 0 or more");
  return {};
}

/// The corners (3 × triangle + 0, 1, 2) at each point.
struct Corners {
  std::vector<std::uint32_t> offsets, items;
};

Corners corners_by_point(const Surface& surface) {
  Corners corners;
  corners.offsets.assign(surface.points.size() + 1, 0);
  for (const auto& t : surface.triangles)
    for (const std::uint32_t p : t) ++corners.offsets[p + 1];
  for (std::size_t i = 1; i < corners.offsets.size(); ++i) corners.offsets[i] += corners.offsets[i - 1];
  corners.items.resize(3 * surface.triangles.size());
  std::vector<std::uint32_t> next(corners.offsets.begin(), corners.offsets.end() - 1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      corners.items[next[surface.triangles[t][k]]++] = static_cast<std::uint32_t>(3 * t + k);
  return corners;
}

struct WeightedNormals {
  std::vector<Vec3f> face;    ///< unit, or zero for a triangle without area
  std::vector<float> angles;  ///< per corner, radians
};

WeightedNormals face_normals(const TriMesh& mesh) {
  WeightedNormals out;
  out.face.resize(mesh.triangles.size());
  out.angles.resize(3 * mesh.triangles.size());
  parallel_for(mesh.triangles.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      out.face[t] = to_float(normalized(triangle_normal(mesh, mesh.triangles[t])));
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = mesh.points[static_cast<std::size_t>(mesh.triangles[t][k])];
        const Vec3 a = mesh.points[static_cast<std::size_t>(mesh.triangles[t][(k + 1) % 3])] - p;
        const Vec3 b = mesh.points[static_cast<std::size_t>(mesh.triangles[t][(k + 2) % 3])] - p;
        out.angles[3 * t + k] = static_cast<float>(std::atan2(length(cross(a, b)), dot(a, b)));
      }
    }
  });
  return out;
}

/// Angle-weighted (Thürmer and Wüthrich 1998) over the faces at the point that lie within the crease angle of
/// the corner's own face. Also returns, through `mean`, the normal of the whole point.
void normals_at_point(const std::uint32_t* begin, const std::uint32_t* end, const WeightedNormals& weighted,
                      std::vector<Vec3f>& corner_normals, Vec3f& mean) {
  Vec3f sum{};
  for (const auto* c = begin; c != end; ++c) sum += weighted.face[*c / 3] * weighted.angles[*c];
  mean = normalized(sum);
  // A facet against all its neighbours is one that reduction folded over, not a crease: it takes their
  // normal. (The two sides of a thin edge both stand at right angles to the mean.)
  const auto folded = [&](std::uint32_t c) { return dot(weighted.face[c / 3], mean) < -0.5f; };
  const float narrow = static_cast<float>(std::sqrt((1 + crease_cosine) / 2));  // half the crease angle
  const bool smooth = std::all_of(
      begin, end, [&](std::uint32_t c) { return folded(c) || dot(weighted.face[c / 3], mean) > narrow; });
  for (const auto* c = begin; c != end; ++c) {
    Vec3f normal = mean;
    if (!smooth && !folded(*c)) {
      normal = {};
      for (const auto* d = begin; d != end; ++d)
        if (dot(weighted.face[*c / 3], weighted.face[*d / 3]) >= static_cast<float>(crease_cosine))
          normal += weighted.face[*d / 3] * weighted.angles[*d];
      normal = normalized(normal);
    }
    corner_normals[*c] = squared_length(normal) > 0 ? normal : mean;
  }
}

/// Mean over the edges at each point of the normal curvature along the edge, (n_j − n_i)·(p_j − p_i) / |p_j −
/// p_i|².
std::vector<float> mean_curvature(const Surface& surface, const Corners& corners,
                                  const std::vector<Vec3f>& normals) {
  std::vector<float> curvature(surface.points.size());
  parallel_for(surface.points.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float sum = 0, count = 0;
      for (std::uint32_t c = corners.offsets[i]; c < corners.offsets[i + 1]; ++c) {
        const std::uint32_t corner = corners.items[c];
        const std::uint32_t j = surface.triangles[corner / 3][(corner % 3 + 1) % 3];
        const Vec3f edge = surface.points[j] - surface.points[i];
        const float square = squared_length(edge);
        if (square < 1e-8f) continue;
        sum += std::clamp(dot(normals[j] - normals[i], edge) / square, -2.0f, 2.0f);
        ++count;
      }
      curvature[i] = count > 0 ? sum / count : 0.0f;
    }
  });
  return curvature;
}

/// One step of averaging with the neighbours: the noise of a scan's surface is far above that of its shape.
std::vector<float> smoothed(const std::vector<float>& values, const Surface& surface,
                            const Corners& corners) {
  std::vector<float> out(values.size());
  parallel_for(values.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      float sum = values[i], count = 1;
      for (std::uint32_t c = corners.offsets[i]; c < corners.offsets[i + 1]; ++c) {
        const std::uint32_t corner = corners.items[c];
        sum += values[surface.triangles[corner / 3][(corner % 3 + 1) % 3]];
        ++count;
      }
      out[i] = sum / count;
    }
  });
  return out;
}

}  // namespace

Result<Surface> prepare_surface(const Body& body, std::size_t number, const Vec3& origin) {
  TURGOR_CHECK(check(body, number));
  const TriMesh& mesh = *body.mesh;
  Surface surface;
  surface.material = body.material;
  surface.colours = body.point_colours;
  surface.points.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points) surface.points.push_back(to_float(p - origin));
  surface.triangles.reserve(mesh.triangles.size());
  for (const Index3& t : mesh.triangles)
    surface.triangles.push_back({static_cast<std::uint32_t>(t[0]), static_cast<std::uint32_t>(t[1]),
                                 static_cast<std::uint32_t>(t[2])});

  const WeightedNormals weighted = face_normals(mesh);
  const Corners corners = corners_by_point(surface);
  surface.corner_normals.resize(corners.items.size());
  std::vector<Vec3f> means(surface.points.size());
  parallel_for(surface.points.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      normals_at_point(corners.items.data() + corners.offsets[i],
                       corners.items.data() + corners.offsets[i + 1], weighted, surface.corner_normals,
                       means[i]);
  });
  surface.curvature.assign(surface.points.size(), 0.0f);
  if (!shows_curvature(body.material.kind)) return surface;
  surface.curvature = mean_curvature(surface, corners, means);
  for (int step = 0; step < 3; ++step) surface.curvature = smoothed(surface.curvature, surface, corners);
  return surface;
}

}  // namespace turgor::render_detail
