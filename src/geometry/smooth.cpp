// Taubin smoothing.
#include <algorithm>
#include <cmath>

#include "turgor/core/parallel.hpp"
#include "turgor/geometry/mesh_edit.hpp"

namespace turgor {
namespace {

constexpr std::size_t grain = 4096;

/// out = in + factor * (mean of neighbours - in), except at fixed points.
template <class T>
void umbrella_step(const PointAdjacency& adjacency, const std::vector<bool>& fixed, double factor,
                   const std::vector<T>& in, std::vector<T>& out) {
  parallel_for(in.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      const int first = adjacency.offsets[p], last = adjacency.offsets[p + 1];
      if (fixed[p] || first == last) {
        out[p] = in[p];
        continue;
      }
      T sum{};
      for (int i = first; i < last; ++i) {
        sum += in[static_cast<std::size_t>(adjacency.neighbours[static_cast<std::size_t>(i)])];
      }
      out[p] = in[p] + (sum / static_cast<double>(last - first) - in[p]) * factor;
    }
  });
}

}  // namespace

TriMesh smooth(TriMesh mesh, int iterations, double pass_band) {
  if (iterations <= 0 || mesh.triangles.empty()) return mesh;
  pass_band = std::clamp(pass_band, 1e-4, 1.9);
  // Taubin (1995), section 4: 1/lambda + 1/mu = pass band, lambda > 0 > mu. Frequencies k in [0, 2] are
  // multiplied by ((1 - lambda k)(1 - mu k))^iterations; lambda <= 1/2 keeps that from falling below 0, and a
  // smaller lambda keeps its hump within the pass band, (1 + pass_band^2 / (4 a (a - pass_band)))^iterations
  // with a = 1/lambda, below some ten per cent.
  const double a = std::max(2.0, pass_band * (0.5 + std::sqrt(0.25 + 2.5 * iterations)));
  const double lambda = 1 / a, mu = 1 / (pass_band - a);
  const PointAdjacency adjacency = point_adjacency(mesh);
  const std::vector<bool> fixed = boundary_points(mesh);
  std::vector<Vec3> other(mesh.points.size());
  for (int i = 0; i < iterations; ++i) {
    umbrella_step(adjacency, fixed, lambda, mesh.points, other);
    umbrella_step(adjacency, fixed, mu, other, mesh.points);
  }
  return mesh;
}

std::vector<double> smooth_field(const TriMesh& mesh, std::vector<double> values,
                                 const std::vector<bool>& fixed, int iterations, double factor) {
  if (iterations <= 0 || values.size() != mesh.points.size()) return values;
  const PointAdjacency adjacency = point_adjacency(mesh);
  const std::vector<bool> none(values.size(), false);
  std::vector<double> other(values.size());
  for (int i = 0; i < iterations; ++i) {
    umbrella_step(adjacency, fixed.size() == values.size() ? fixed : none, factor, values, other);
    values.swap(other);
  }
  return values;
}

}  // namespace turgor
