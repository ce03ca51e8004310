// Reduction of surfaces by quadric edge collapse (meshoptimizer), and the repair of what it leaves.
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

#include "geometry/connectivity.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

/// Positions about the middle of the box, where single precision is finest.
std::vector<Vec3f> centred_positions(const TriMesh& mesh) {
  const Vec3 centre = bounds(mesh).centre();
  std::vector<Vec3f> positions(mesh.points.size());
  for (std::size_t i = 0; i < positions.size(); ++i) positions[i] = to_float(mesh.points[i] - centre);
  return positions;
}

/// meshoptimizer does not look out for thin parts whose two sides fall together, nor for rings that close up.
bool is_manifold(const TriMesh& mesh) {
  const detail::Lists edges = detail::half_edges_by_edge(mesh.points.size(), mesh.triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto around = edges[e];
    if (around.size() > 2) return false;
    if (around.size() == 2 &&
        detail::corner_point(mesh.triangles, around[0]) == detail::corner_point(mesh.triangles, around[1])) {
      return false;
    }
  }
  return true;
}

/// One run of the simplifier to at most `target` triangles; `error` in mm.
TriMesh simplified(const TriMesh& mesh, std::size_t target, double& error) {
  const std::vector<Vec3f> positions = centred_positions(mesh);
  std::vector<unsigned> indices(mesh.triangles.size() * 3);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) indices[3 * i + k] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  // The error wanted is whatever the number of triangles costs, so no limit that could stop it early.
  constexpr float unlimited = 1e6F;
  float relative_error = 0;
  std::vector<unsigned> reduced(indices.size());
  const std::size_t count =
      meshopt_simplify(reduced.data(), indices.data(), indices.size(), &positions[0].x, positions.size(),
                       sizeof(Vec3f), target * 3, unlimited, 0, &relative_error);
  error = static_cast<double>(relative_error) *
          static_cast<double>(meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(Vec3f)));
  TriMesh result;
  result.points = mesh.points;
  result.triangles.resize(count / 3);
  for (std::size_t i = 0; i < result.triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) result.triangles[i][k] = static_cast<int>(reduced[3 * i + k]);
  }
  return result;
}

}  // namespace

TriMesh decimate(const TriMesh& mesh, int target_triangles, double* error) {
  if (error) *error = 0;
  const auto target = static_cast<std::size_t>(std::max(target_triangles, 0));
  TriMesh result = detail::without_unused_points(mesh);
  // The first round stops a little early: repair takes away the folds it left (a per cent or two of the
  // triangles), and a short second round, which leaves hardly any, then comes out at the number asked for.
  // Where parting sheets has added triangles instead, the next round aims as much lower.
  constexpr int rounds = 5;
  std::size_t excess = 0;
  for (int round = 0; round < rounds && result.triangles.size() > target; ++round) {
    const std::size_t before = result.triangles.size(), early = target + target / 16;
    const std::size_t aim = round == 0 && before > early ? early : target - std::min(target, excess);
    double deviation = 0;
    result = simplified(result, aim, deviation);
    if (error) *error = std::max(*error, deviation);
    if (!is_manifold(result)) result = detail::separated_sheets(std::move(result));
    result = detail::without_unused_points(std::move(result));
    if (aim <= target && result.triangles.size() > aim) excess += result.triangles.size() - aim;
    if (result.triangles.size() >= before) break;
  }
  return result;
}

}  // namespace turgor
