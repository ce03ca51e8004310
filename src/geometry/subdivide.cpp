#include "turgor/geometry/subdivide.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "turgor/core/index.hpp"

namespace turgor {

// One level. New points, in order: the old ones, one in each edge, one in each polygon, one in each line.
class SubdivisionStep {
 public:
  explicit SubdivisionStep(const Polyhedron& surface) : surface_(surface) {
    gather_edges();
    gather_points();
  }

  [[nodiscard]] Subdivision::Stencils stencils() const {
    Subdivision::Stencils s;
    for (int p = 0; p < static_cast<int>(surface_.points.size()); ++p) add_point(p, s);
    for (const Sides& e : edges_) {
      const double weight = e.count == 2 ? 0.25 : 0.5;
      s.add(e.edge[0], weight), s.add(e.edge[1], weight);
      for (int side = 0; e.count == 2 && side < 2; ++side) add_mean(e.polygon[at(side)], 0.25, s);
      s.close();
    }
    for (int i = 0; i < surface_.polygon_count(); ++i) add_mean(i, 1, s), s.close();
    for (const auto& [a, b] : surface_.lines) s.add(a, 0.5), s.add(b, 0.5), s.close();
    return s;
  }

  // The polygons of the new level; its points are for the caller to fill.
  [[nodiscard]] Polyhedron refined() const {
    const int points = static_cast<int>(surface_.points.size());
    const int first_centre = points + static_cast<int>(edges_.size());
    Polyhedron fine;
    fine.corners.reserve(4 * surface_.corners.size());
    fine.ends.reserve(surface_.corners.size());
    std::size_t corner = 0;
    for (int i = 0; i < surface_.polygon_count(); ++i) {
      const std::size_t begin = corner, end = at(surface_.ends[at(i)]);
      for (; corner < end; ++corner) {
        const std::size_t before = corner == begin ? end - 1 : corner - 1;
        fine.add_polygon(std::array{surface_.corners[corner], points + edge_of_corner_[corner],
                                    first_centre + i, points + edge_of_corner_[before]});
      }
    }
    int middle = first_centre + surface_.polygon_count();
    for (const auto& [a, b] : surface_.lines) {
      fine.lines.push_back({a, middle});
      fine.lines.push_back({middle++, b});
    }
    return fine;
  }

 private:
  // An edge and the first two of the polygons that have it.
  struct Sides {
    Edge edge{};
    std::array<int, 2> polygon{-1, -1};
    int count = 0;
  };

  void gather_edges() {
    struct HalfEdge {
      Edge edge;
      int corner, polygon;
    };
    std::vector<HalfEdge> half_edges;
    half_edges.reserve(surface_.corners.size());
    for (int i = 0, corner = 0; i < surface_.polygon_count(); ++i) {
      const auto p = surface_.polygon(i);
      for (std::size_t k = 0; k < p.size(); ++k, ++corner) {
        const auto [low, high] = std::minmax(p[k], p[k + 1 < p.size() ? k + 1 : 0]);
        half_edges.push_back({{low, high}, corner, i});
      }
    }
    std::sort(half_edges.begin(), half_edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
      return std::pair(a.edge, a.corner) < std::pair(b.edge, b.corner);
    });
    edge_of_corner_.resize(half_edges.size());
    for (const HalfEdge& h : half_edges) {
      if (edges_.empty() || edges_.back().edge != h.edge) edges_.push_back({h.edge, {-1, -1}, 0});
      Sides& e = edges_.back();
      if (e.count < 2) e.polygon[at(e.count)] = h.polygon;
      ++e.count;
      edge_of_corner_[at(h.corner)] = static_cast<int>(edges_.size()) - 1;
    }
  }

  // What meets at each point: polygons, edges, and the far ends of edges that are not between two polygons.
  void gather_points() {
    polygons_at_.resize(surface_.points.size());
    edges_at_.resize(surface_.points.size());
    for (int i = 0; i < surface_.polygon_count(); ++i) {
      for (const int p : surface_.polygon(i)) polygons_at_[at(p)].push_back(i);
    }
    for (int e = 0; e < static_cast<int>(edges_.size()); ++e) {
      for (const int p : edges_[at(e)].edge) edges_at_[at(p)].push_back(e);
    }
  }

  void add_mean(int polygon, double weight, Subdivision::Stencils& s) const {
    const auto corners = surface_.polygon(polygon);
    for (const int p : corners) s.add(p, weight / static_cast<double>(corners.size()));
  }

  void add_point(int point, Subdivision::Stencils& s) const {
    std::vector<int> crease;
    for (const int e : edges_at_[at(point)]) {
      if (edges_[at(e)].count != 2) crease.push_back(edges_[at(e)].edge[0] + edges_[at(e)].edge[1] - point);
    }
    const auto n = static_cast<double>(edges_at_[at(point)].size());
    const bool corner = polygons_at_[at(point)].size() == 1;
    if (crease.size() == 2 && !corner) {
      s.add(point, 0.75), s.add(crease[0], 0.125), s.add(crease[1], 0.125);
    } else if (!crease.empty() || n < 3) {
      s.add(point, 1);
    } else {
      // (mean of the polygons' centres + 2 · mean of the edges' middles + (n − 3) · point) / n
      const auto polygons = static_cast<double>(polygons_at_[at(point)].size());
      for (const int i : polygons_at_[at(point)]) add_mean(i, 1 / (n * polygons), s);
      s.add(point, (n - 2) / n);
      for (const int e : edges_at_[at(point)]) {
        s.add(edges_[at(e)].edge[0] + edges_[at(e)].edge[1] - point, 1 / (n * n));
      }
    }
    s.close();
  }

  const Polyhedron& surface_;
  std::vector<Sides> edges_;
  std::vector<int> edge_of_corner_;  // from that corner to the next of its polygon
  std::vector<std::vector<int>> polygons_at_, edges_at_;
};

Subdivision::Subdivision(const Polyhedron& surface, int levels) : surface_(surface) {
  // The next level has as many polygons as this one has corners.
  const auto size = [&] { return surface_.corners.size() + surface_.lines.size(); };
  for (int i = 0; i < levels && size() > 0 && size() <= kMostPolygons; ++i) {
    const SubdivisionStep step(surface_);
    levels_.push_back(step.stencils());
    Polyhedron fine = step.refined();
    fine.points = levels_.back().apply(surface_.points);
    surface_ = std::move(fine);
  }
}

Polyhedron subdivided(const Polyhedron& surface, int levels) {
  return Subdivision(surface, levels).surface();
}

}  // namespace turgor
