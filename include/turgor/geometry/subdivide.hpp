// A smooth surface through refinement, for drawing.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/geometry/polyhedron.hpp"

namespace turgor {

/// The refinement of one surface, prepared once: each level makes every polygon of n corners n
/// quadrilaterals, and every line two (Catmull and Clark, "Recursively generated B-spline surfaces on
/// arbitrary topological meshes", Computer-Aided Design 10(6), 1978). Edges that do not have two polygons,
/// rims above all, become cubic B-spline curves; points where one or more than two of them end stay where
/// they are, and so do those on a rim that belong to one polygon alone: a sheet keeps its corners and its
/// size (corner rule of DeRose, Kass and Truong, "Subdivision surfaces in character animation", SIGGRAPH
/// 1998). A surface whose cells are symmetric stays so, which its triangles do not (Pieper 1989,
/// section 6.2.5).
class Subdivision {
 public:
  /// Of a valid surface. Levels below 0 count as 0; those that would make more than kMostPolygons are left
  /// out.
  Subdivision(const Polyhedron& surface, int levels);

  static constexpr std::size_t kMostPolygons = 20'000'000;

  /// The refined surface; its points are values(surface.points).
  [[nodiscard]] const Polyhedron& surface() const { return surface_; }
  /// Values of the refined points from those of the points of the source (positions in motion, displacements,
  /// colours): one for each point.
  template <class T>
  [[nodiscard]] std::vector<T> values(std::vector<T> of_source) const {
    for (const Stencils& level : levels_) of_source = level.apply(of_source);
    return of_source;
  }

 private:
  friend class SubdivisionStep;

  // Each new point as a weighted sum of old ones.
  struct Stencils {
    std::vector<std::size_t> ends;
    std::vector<int> points;
    std::vector<double> weights;

    void add(int point, double weight) { points.push_back(point), weights.push_back(weight); }
    void close() { ends.push_back(points.size()); }
    template <class T>
    [[nodiscard]] std::vector<T> apply(const std::vector<T>& values) const {
      std::vector<T> result(ends.size());
      std::size_t i = 0;
      for (std::size_t p = 0; p < ends.size(); ++p) {
        T sum{};
        for (; i < ends[p]; ++i) sum += values[static_cast<std::size_t>(points[i])] * weights[i];
        result[p] = sum;
      }
      return result;
    }
  };

  Polyhedron surface_;
  std::vector<Stencils> levels_;
};

/// Subdivision(surface, levels).surface().
Polyhedron subdivided(const Polyhedron& surface, int levels);

}  // namespace turgor
