#include "anatomy/head_surface.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"
#include "turgor/imaging/isosurface.hpp"

namespace turgor {
namespace {

/// Profiles reach this far to find the tissue on either side.
constexpr double kReachMm = 3.0;
/// Partial volume shifts an edge by no more than this part of the largest voxel edge.
constexpr double kMostShiftVoxels = 0.75;
constexpr int kSmoothingSteps = 10;
constexpr double kPassBand = 0.15;
constexpr int kMembraneSteps = 120;

/// Points on grid edges of which one end has a label other than its value says.
std::vector<bool> find_points_placed_by_label(const TriMesh& mesh, const CtVolume& hu,
                                              const LabelVolume& labels, std::uint8_t label, double level) {
  std::vector<std::uint8_t> placed(mesh.points.size(), 0);
  const Grid& g = hu.grid;
  const auto disagrees = [&](int i, int j, int k) {
    const std::size_t v = g.offset(std::clamp(i, 0, g.size[0] - 1), std::clamp(j, 0, g.size[1] - 1),
                                   std::clamp(k, 0, g.size[2] - 1));
    return (hu.voxels[v] >= level) != (labels.voxels[v] == label);
  };
  parallel_for(mesh.points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const Vec3 at = g.to_index(mesh.points[p]);
      int near[3], far[3];
      for (int a = 0; a < 3; ++a) {
        // Iso-surface points lie strictly inside one grid edge; along the other two axes they are on the
        // grid.
        const double rounded = std::round(at[a]);
        const bool on_grid = std::abs(at[a] - rounded) < 1e-4;
        near[a] = static_cast<int>(on_grid ? rounded : std::floor(at[a]));
        far[a] = on_grid ? near[a] : near[a] + 1;
      }
      placed[p] = disagrees(near[0], near[1], near[2]) || disagrees(far[0], far[1], far[2]);
    }
  });
  return {placed.begin(), placed.end()};
}

/// Lets the marked points settle into a membrane spanned by the others.
void relax(TriMesh& mesh, const std::vector<bool>& marked) {
  if (std::none_of(marked.begin(), marked.end(), [](bool m) { return m; })) return;
  const PointAdjacency adjacency = point_adjacency(mesh);
  std::vector<std::size_t> moving;
  for (std::size_t p = 0; p < marked.size(); ++p) {
    if (marked[p] && adjacency.offsets[p + 1] > adjacency.offsets[p]) moving.push_back(p);
  }
  std::vector<Vec3> next(moving.size());
  for (int step = 0; step < kMembraneSteps; ++step) {
    parallel_for(moving.size(), 2048, [&](std::size_t begin, std::size_t end) {
      for (std::size_t m = begin; m < end; ++m) {
        const int first = adjacency.offsets[moving[m]], last = adjacency.offsets[moving[m] + 1];
        Vec3 sum;
        for (int n = first; n < last; ++n) {
          sum += mesh.points[static_cast<std::size_t>(adjacency.neighbours[static_cast<std::size_t>(n)])];
        }
        next[m] = sum / static_cast<double>(last - first);
      }
    });
    for (std::size_t m = 0; m < moving.size(); ++m) mesh.points[moving[m]] = next[m];
  }
}

std::vector<bool> boundary_points(const TriMesh& mesh, const Grid& grid) {
  std::vector<bool> at_end(mesh.points.size(), false);
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    const Vec3 at = grid.to_index(mesh.points[p]);
    for (int a = 0; a < 3; ++a) {
      const double last = grid.size[static_cast<std::size_t>(a)] - 1;
      if (at[a] < 1e-4 || at[a] > last - 1e-4) at_end[p] = true;
    }
  }
  return at_end;
}

LabelSurface finished(TriMesh raw, const CtVolume& hu, const LabelVolume& labels, std::uint8_t label,
                      const SurfaceSettings& settings) {
  LabelSurface surface{std::move(raw), {}};
  TriMesh& mesh = surface.mesh;
  if (mesh.empty() || settings.stopped()) return surface;
  surface.placed_by_label = find_points_placed_by_label(mesh, hu, labels, label, settings.level);
  const std::vector<bool> at_end = boundary_points(mesh, hu.grid);
  const Vec3 s = hu.grid.spacing;
  const std::vector<Vec3> before = mesh.points;
  refine_to_local_level(mesh, hu, kReachMm, kMostShiftVoxels * std::max({s.x, s.y, s.z}));
  if (settings.stopped()) return surface;
  std::vector<bool> membrane(before.size(), false);
  for (std::size_t p = 0; p < before.size(); ++p) {
    membrane[p] = settings.membranes && surface.placed_by_label[p] && !at_end[p];
    if (membrane[p] || at_end[p]) mesh.points[p] = before[p];
  }
  relax(mesh, membrane);
  if (settings.stopped()) return surface;
  const int steps = static_cast<int>(std::lround(kSmoothingSteps * settings.smoothing));
  if (steps > 0) mesh = smooth(std::move(mesh), steps, kPassBand);
  if (settings.stopped()) return surface;
  unfold(mesh);  // local refinement turns over some slivers
  return surface;
}

}  // namespace

TriMesh largest_surface(const TriMesh& mesh, std::vector<int>* point_map) {
  const std::vector<int> component = triangle_components(mesh);
  std::vector<bool> keep(component.size());
  for (std::size_t t = 0; t < keep.size(); ++t) keep[t] = component[t] == 0;
  return submesh(mesh, keep, point_map);
}

LabelSurface surface_of_label(const CtVolume& hu, const LabelVolume& labels, std::uint8_t label,
                              const SurfaceSettings& settings) {
  const TriMesh all = isosurface_of_label(hu, settings.level, labels, label);
  if (settings.stopped()) return {};
  return finished(largest_surface(all), hu, labels, label, settings);
}

TriMesh surface_pieces_of_label(const CtVolume& hu, const LabelVolume& labels, std::uint8_t label,
                                const SurfaceSettings& settings) {
  const TriMesh all = isosurface_of_label(hu, settings.level, labels, label);
  if (all.empty()) return {};
  const std::vector<int> component = triangle_components(all);
  std::vector<double> area(
      static_cast<std::size_t>(*std::max_element(component.begin(), component.end())) + 1, 0.0);
  for (std::size_t t = 0; t < component.size(); ++t) {
    area[static_cast<std::size_t>(component[t])] += 0.5 * length(triangle_normal(all, all.triangles[t]));
  }
  constexpr double kLeastAreaMm2 = 300;
  std::vector<bool> keep(component.size());
  for (std::size_t t = 0; t < keep.size(); ++t)
    keep[t] = area[static_cast<std::size_t>(component[t])] > kLeastAreaMm2;
  return finished(submesh(all, keep), hu, labels, label, settings).mesh;
}

TriMesh reduced_pieces(const TriMesh& mesh, int triangles) {
  if (static_cast<int>(mesh.triangles.size()) <= triangles) return mesh;
  TriMesh out = decimate(mesh, triangles);
  unfold(out);
  return out;
}

TriMesh reduced(const TriMesh& mesh, int triangles) {
  if (static_cast<int>(mesh.triangles.size()) <= triangles) return mesh;
  return largest_surface(reduced_pieces(mesh, triangles));
}

}  // namespace turgor
