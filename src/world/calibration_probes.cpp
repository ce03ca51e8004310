// Loads made up to probe what other loads leave still.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/index.hpp"
#include "world/calibration_parts.hpp"

namespace turgor {
namespace {

/// Points of the surface within a cube's diagonal.
std::vector<int> patch_about(const SolidMesh& mesh, int point) {
  std::vector<int> patch;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    if (mesh.on_surface[p] != 0 && distance(mesh.points[p], mesh.points[at(point)]) < 1.5 * mesh.spacing)
      patch.push_back(static_cast<int>(p));
  }
  return patch;
}

std::vector<Vec3> normals_of(const SolidMesh& mesh) {
  return point_normals({{mesh.points.begin(), mesh.points.end()},
                        {mesh.surface_triangles.begin(), mesh.surface_triangles.end()}});
}

/// Points of the free surface, each the farthest from those before it and from what is held.
std::vector<int> far_points(const SolidMesh& mesh, std::span<const int> held, int count) {
  std::vector<double> far(mesh.points.size(), std::numeric_limits<double>::infinity());
  const auto keep_off = [&](int from) {
    for (std::size_t p = 0; p < far.size(); ++p)
      far[p] = std::min(far[p], distance(mesh.points[p], mesh.points[at(from)]));
  };
  for (std::size_t p = 0; p < far.size(); ++p)
    if (mesh.on_surface[p] == 0) far[p] = 0;
  for (const int h : held) keep_off(h);
  std::vector<int> out;
  while (std::ssize(out) < count) {
    const auto next = std::max_element(far.begin(), far.end());
    if (!(*next > 1.5 * mesh.spacing)) break;
    out.push_back(static_cast<int>(next - far.begin()));
    keep_off(out.back());
  }
  return out;
}

/// Lengths over the largest of them.
std::vector<double> shares(std::span<const Vec3> displacement) {
  std::vector<double> out;
  double greatest = 0;
  for (const Vec3& u : displacement) {
    out.push_back(length(u));
    greatest = std::max(greatest, out.back());
  }
  for (double& share : out) share /= std::max(greatest, std::numeric_limits<double>::min());
  return out;
}

struct Candidate {
  PreparedLoad load;
  std::vector<double> moves;  ///< shares of the largest displacement, one a point
};

/// Sum of what the candidate moves more than it is moved already.
double gain(const Candidate& candidate, std::span<const double> moved) {
  double sum = 0;
  for (std::size_t p = 0; p < moved.size(); ++p) sum += std::max(0.0, candidate.moves[p] - moved[p]);
  return sum;
}

void take_greatest(std::span<const double> moves, std::vector<double>& moved) {
  for (std::size_t p = 0; p < moved.size(); ++p) moved[p] = std::max(moved[p], moves[p]);
}

double longest_side(const SolidMesh& mesh) {
  Box3 box;
  for (const Vec3& p : mesh.points) box.extend(p);
  const Vec3 size = box.size();
  return std::max({size.x, size.y, size.z});
}

/// A force of as many newtons as move the body by the depth asked for.
Result<Candidate> candidate_at(int point, const SolidMesh& mesh, const Vec3& inward,
                               const VoxelElasticity& hooke, double depth_mm, Context& context) {
  Candidate out;
  out.load.probe = true;
  out.load.force_n.resize(mesh.points.size());
  const std::vector<int> patch = patch_about(mesh, point);
  for (const int p : patch) out.load.force_n[at(p)] = inward / static_cast<double>(patch.size());
  TURGOR_TRY(const ElasticSolution solution, hooke.solve(elastic_load(out.load), context));
  out.moves = shares(solution.displacement_mm);
  double greatest = 0;
  for (const Vec3& u : solution.displacement_mm) greatest = std::max(greatest, length(u));
  if (greatest > 0)
    for (Vec3& f : out.load.force_n) f *= depth_mm / greatest;
  return out;
}

}  // namespace

Result<std::vector<PreparedLoad>> probing_loads(const ProbeOptions& options, const SolidMesh& mesh,
                                                std::span<const int> held, const VoxelElasticity& hooke,
                                                std::span<const PreparedLoad> loads, Context& context) {
  std::vector<double> moved(mesh.points.size());
  for (const PreparedLoad& load : loads) {
    if (load.held_out) continue;
    std::vector<Vec3> displacement(mesh.points.size());
    for (std::size_t p = 0; p < displacement.size(); ++p)
      displacement[p] = load.reference[p] - mesh.points[p];
    take_greatest(shares(displacement), moved);
  }
  const std::vector<int> points = far_points(mesh, held, options.candidates);
  const std::vector<Vec3> normals = normals_of(mesh);
  const double depth_mm = options.depth * longest_side(mesh);
  std::vector<Candidate> candidates;
  for (const int p : points) {
    context.progress(static_cast<double>(candidates.size()) / static_cast<double>(points.size()));
    TURGOR_CHECK(context.check());
    TURGOR_TRY(Candidate c, candidate_at(p, mesh, -normals[at(p)], hooke, depth_mm, context));
    candidates.push_back(std::move(c));
  }
  std::vector<PreparedLoad> out;
  while (std::ssize(out) < options.loads && !candidates.empty()) {
    const auto best =
        std::ranges::max_element(candidates, {}, [&](const Candidate& c) { return gain(c, moved); });
    take_greatest(best->moves, moved);
    best->load.name = fmt::format("probe {}", out.size() + 1);
    best->load.held_out = options.held_out;
    out.push_back(std::move(best->load));
    candidates.erase(best);
  }
  return out;
}

}  // namespace turgor
