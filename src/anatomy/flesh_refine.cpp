// Local refinement of flesh where it deforms, and back.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "turgor/anatomy/flesh.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

constexpr int kMostLevels = 16;  // two bits each, beside the number of the base triangle

Error broken(std::string what, std::string remedy) {
  return {ErrorKind::bad_input, std::move(what), "refinement of flesh", std::move(remedy)};
}

Result<void> check(const Flesh& flesh, const std::vector<double>& measure, const RefinementOptions& options) {
  if (measure.size() != flesh.surface.ends.size()) {
    return broken(
        fmt::format("there are {} measures for {} polygons", measure.size(), flesh.surface.ends.size()),
        "Give one for each polygon of the present flesh");
  }
  for (std::size_t i = 0; i < measure.size(); ++i) {
    if (std::isnan(measure[i]))
      return broken(fmt::format("the measure of polygon {} is not a number", i), "");
  }
  if (!(options.merge_below <= options.refine_above)) {
    return broken(
        fmt::format("it would merge below {} and split above {}", options.merge_below, options.refine_above),
        "merge_below must not exceed refine_above");
  }
  if (options.most_levels < 0 || options.most_levels > kMostLevels) {
    return broken(fmt::format("{} levels cannot be kept", options.most_levels),
                  fmt::format("Give 0 to {}", kMostLevels));
  }
  return {};
}

// A sample halfway between two others; its mass is given by hand_on_masses().
FleshSample between(const FleshSample& a, const FleshSample& b) {
  FleshSample m;
  m.rest = (a.rest + b.rest) * 0.5;
  m.mobile = a.mobile || b.mobile;
  m.growth = (a.growth + b.growth) / 2;
  m.stiffness = (a.stiffness + b.stiffness) / 2;
  m.spacing = (a.spacing + b.spacing) / 2;
  return m;
}

// A corner of a polygon, and where it lies in its base triangle: the weights of the triangle's three points.
struct Corner {
  int column;
  Vec3 weight;
};
using Part = std::array<Corner, 3>;

// Area of a part over that of its base triangle; exactly 1 for the whole.
double share_of_area(const Part& p) {
  return std::abs(dot(p[0].weight, cross(p[1].weight, p[2].weight)));
}

// The samples of base triangle `t` hand their masses on to the corners of its parts, each as its linear shape
// function says: Σ over the parts of a third of their area × 3 λ / area of the triangle = 1.
void hand_on_masses(const Flesh& base, const std::vector<Part>& parts, const std::vector<int>& base_triangle,
                    Flesh& fine) {
  std::vector<int> triangles(base.surface.points.size(), 0), split(triangles.size(), 0);
  for (const int p : base.surface.corners) ++triangles[at(p)];
  int last = -1;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (share_of_area(parts[i]) == 1 || base_triangle[i] == last) continue;
    last = base_triangle[i];
    for (const int p : base.surface.polygon(last)) ++split[at(p)];
  }
  for (int layer = 0; layer < base.layers; ++layer) {
    for (int c = 0; c < base.columns(); ++c) {
      if (split[at(c)] == 0) continue;
      fine.samples[at(fine.sample(layer, c))].mass_g *=
          static_cast<double>(triangles[at(c)] - split[at(c)]) / triangles[at(c)];
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const double area = share_of_area(parts[i]);
      if (area == 1) continue;
      const auto owners = base.surface.polygon(base_triangle[i]);
      for (const Corner& corner : parts[i]) {
        double& mass = fine.samples[at(fine.sample(layer, corner.column))].mass_g;
        for (int k = 0; k < 3; ++k) {
          const int owner = owners[at(k)];
          mass += base.samples[at(base.sample(layer, owner))].mass_g / triangles[at(owner)] * area *
                  corner.weight[k];
        }
      }
    }
  }
}

// Each sample's spacing falls with the mean size of the polygons about it.
void scale_spacing(const std::vector<Part>& parts, Flesh& fine) {
  std::vector<double> sum(fine.surface.points.size(), 0), count(sum.size(), 0);
  for (const Part& part : parts) {
    const double size = std::sqrt(share_of_area(part));
    for (const Corner& corner : part) sum[at(corner.column)] += size, ++count[at(corner.column)];
  }
  for (int layer = 0; layer < fine.layers; ++layer) {
    for (int c = 0; c < fine.columns(); ++c) {
      if (count[at(c)] > 0) fine.samples[at(fine.sample(layer, c))].spacing *= sum[at(c)] / count[at(c)];
    }
  }
}

// A triangle with new points in some of its edges, in conforming parts. `corners` are its three, then the
// points in the edges that start at them, of column -1 where there is none.
std::vector<Part> conforming_parts(std::array<Corner, 6> corners, const std::vector<Vec3>& points) {
  const auto turn = [&] {
    std::rotate(corners.begin(), corners.begin() + 1, corners.begin() + 3);
    std::rotate(corners.begin() + 3, corners.begin() + 4, corners.end());
  };
  const auto& [a, b, c, ab, bc, ca] = corners;
  const auto halved =
      std::count_if(corners.begin() + 3, corners.end(), [](const Corner& m) { return m.column >= 0; });
  if (halved == 0) return {{a, b, c}};
  if (halved == 3) return {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
  while (ab.column < 0 || (halved == 2 && bc.column < 0)) turn();
  if (halved == 1) return {{a, ab, c}, {ab, b, c}};
  const auto apart = [&](const Corner& p, const Corner& q) {
    return distance(points[at(p.column)], points[at(q.column)]);
  };
  if (apart(ab, c) < apart(a, bc)) return {{ab, b, bc}, {a, ab, c}, {ab, bc, c}};
  return {{ab, b, bc}, {a, ab, bc}, {a, bc, c}};
}

}  // namespace

int AdaptiveFlesh::Middles::find(int a, int b) const {
  const auto [low, high] = std::minmax(a, b);
  const auto found = vertex_in.find(static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high));
  return found == vertex_in.end() ? -1 : found->second;
}

int AdaptiveFlesh::Middles::in(int a, int b) {
  const auto [low, high] = std::minmax(a, b);
  const int next = first + static_cast<int>(edges.size());
  const auto [place, added] =
      vertex_in.try_emplace(static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint64_t>(high), next);
  if (added) edges.push_back({low, high});
  return place->second;
}

// The triangles that a set of splits leaves, and the vertices in use: those of the base, then middles in the
// order in which they are met.
class RefinedSurface {
 public:
  using Triangle = AdaptiveFlesh::Triangle;
  using Splits = AdaptiveFlesh::Splits;
  using Middles = AdaptiveFlesh::Middles;

  struct Leaf {
    Triangle triangle;
    Index3 vertices;
    std::array<Vec3, 3> weights;
  };

  RefinedSurface(const Polyhedron& base, const Splits& splits, Middles& middles)
      : splits_(splits), middles_(middles), next_(splits.size(), 0) {
    for (int v = 0; v < middles.first; ++v) use(v);
    for (int i = 0; i < base.polygon_count(); ++i) {
      const auto p = base.polygon(i);
      walk({{0, static_cast<std::uint64_t>(i)},
            {p[0], p[1], p[2]},
            {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}});
    }
  }

  // Splits further triangles until no edge is halved twice on one side.
  static RefinedSurface balanced(const Polyhedron& base, Splits& splits, Middles& middles) {
    for (;;) {
      RefinedSurface surface(base, splits, middles);
      bool changed = false;
      for (const Leaf& leaf : surface.leaves_) {
        if (!surface.is_too_coarse(leaf)) continue;
        splits[at(leaf.triangle.level)].push_back(leaf.triangle.key);
        changed = true;
      }
      if (!changed) return surface;
      for (auto& level : splits) std::sort(level.begin(), level.end());
    }
  }

  // The flesh over this surface.
  [[nodiscard]] Flesh fleshed(const Flesh& base) const {
    Flesh fine = base;
    fine.surface = {};
    fine.samples.resize(vertices_.size() * at(base.layers));
    const int columns = static_cast<int>(vertices_.size());
    for (int layer = 0; layer < base.layers; ++layer) {
      for (int c = 0; c < columns; ++c) {
        FleshSample* const samples = fine.samples.data() + at(layer) * vertices_.size();
        if (c < base.columns()) {
          samples[c] = base.samples[at(base.sample(layer, c))];
        } else {
          const auto [a, b] = middles_.edges[at(vertices_[at(c)] - middles_.first)];
          samples[c] = between(samples[column_[at(a)]], samples[column_[at(b)]]);
          samples[c].mass_g = 0;
        }
      }
    }
    for (int c = 0; c < columns; ++c) fine.surface.points.push_back(fine.samples[at(c)].rest);
    std::vector<Part> parts;
    std::vector<int> base_triangle;
    for (const Leaf& leaf : leaves_) {
      for (const Part& part : parts_of(leaf, fine.surface.points)) {
        parts.push_back(part);
        base_triangle.push_back(static_cast<int>(leaf.triangle.key >> (2 * leaf.triangle.level)));
        fine.surface.add_polygon(std::array{part[0].column, part[1].column, part[2].column});
      }
    }
    hand_on_masses(base, parts, base_triangle, fine);
    scale_spacing(parts, fine);
    return fine;
  }

  // Of each polygon of fleshed().
  [[nodiscard]] std::vector<Triangle> triangles(const std::vector<Vec3>& points) const {
    std::vector<Triangle> result;
    for (const Leaf& leaf : leaves_)
      result.insert(result.end(), parts_of(leaf, points).size(), leaf.triangle);
    return result;
  }

  [[nodiscard]] const std::vector<int>& vertices() const { return vertices_; }

 private:
  void use(int vertex) {
    if (at(vertex) >= column_.size()) column_.resize(at(vertex) + 1, -1);
    if (column_[at(vertex)] >= 0) return;
    column_[at(vertex)] = static_cast<int>(vertices_.size());
    vertices_.push_back(vertex);
  }

  // Keys of a level are met in ascending order, as they are listed.
  void walk(const Leaf& leaf) {
    const auto [level, key] = leaf.triangle;
    if (at(level) >= splits_.size() || next_[at(level)] >= splits_[at(level)].size() ||
        splits_[at(level)][next_[at(level)]] != key) {
      leaves_.push_back(leaf);
      return;
    }
    ++next_[at(level)];
    const auto& v = leaf.vertices;
    const auto& w = leaf.weights;
    const Index3 m{middles_.in(v[0], v[1]), middles_.in(v[1], v[2]), middles_.in(v[2], v[0])};
    const std::array<Vec3, 3> u{(w[0] + w[1]) * 0.5, (w[1] + w[2]) * 0.5, (w[2] + w[0]) * 0.5};
    for (const int vertex : m) use(vertex);
    walk({{level + 1, 4 * key}, {v[0], m[0], m[2]}, {w[0], u[0], u[2]}});
    walk({{level + 1, 4 * key + 1}, {m[0], v[1], m[1]}, {u[0], w[1], u[1]}});
    walk({{level + 1, 4 * key + 2}, {m[2], m[1], v[2]}, {u[2], u[1], w[2]}});
    walk({{level + 1, 4 * key + 3}, {m[0], m[1], m[2]}, u});
  }

  // The vertex in use in the middle of an edge, -1 where there is none.
  [[nodiscard]] int middle(int a, int b) const {
    const int m = middles_.find(a, b);
    return m >= 0 && at(m) < column_.size() && column_[at(m)] >= 0 ? m : -1;
  }

  [[nodiscard]] bool is_too_coarse(const Leaf& leaf) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = leaf.vertices[k], b = leaf.vertices[(k + 1) % 3], m = middle(a, b);
      if (m >= 0 && (middle(a, m) >= 0 || middle(m, b) >= 0)) return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<Part> parts_of(const Leaf& leaf, const std::vector<Vec3>& points) const {
    std::array<Corner, 6> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const int m = middle(leaf.vertices[k], leaf.vertices[next]);
      corners[k] = {column_[at(leaf.vertices[k])], leaf.weights[k]};
      corners[k + 3] = {m < 0 ? -1 : column_[at(m)], (leaf.weights[k] + leaf.weights[next]) * 0.5};
    }
    return conforming_parts(corners, points);
  }

  const Splits& splits_;
  Middles& middles_;
  std::vector<std::size_t> next_;  // place in each level of splits_
  std::vector<Leaf> leaves_;
  std::vector<int> vertices_, column_;  // vertex of each column, and back
};

AdaptiveFlesh::AdaptiveFlesh(Flesh base) : base_(std::move(base)) {
  if (validate(base_)) base_.surface = to_polyhedron(triangulated(base_.surface));
  flesh_ = base_;
  middles_.first = base_.columns();
  vertices_.resize(base_.surface.points.size());
  std::iota(vertices_.begin(), vertices_.end(), 0);
  for (std::size_t i = 0; i < base_.surface.ends.size(); ++i) triangles_.push_back({0, i});
}

AdaptiveFlesh::Splits AdaptiveFlesh::wanted_splits(const std::vector<double>& measure,
                                                   const RefinementOptions& options) const {
  Splits splits = splits_, merged(at(options.most_levels));
  splits.resize(at(options.most_levels));
  Triangle previous{-1, 0};
  int calm = 0;  // parts of the present parent, up to here, that may merge
  for (std::size_t i = 0; i < measure.size();) {
    const auto [level, key] = triangles_[i];
    double most = measure[i];
    for (; i < measure.size() && triangles_[i] == Triangle{level, key}; ++i)
      most = std::max(most, measure[i]);
    if (level < options.most_levels && most >= options.refine_above) splits[at(level)].push_back(key);
    // Four parts that are all whole follow one another.
    const bool follows = previous == Triangle{level, key - 1} && key % 4 != 0;
    calm = most < options.merge_below ? (follows ? calm : 0) + 1 : 0;
    if (calm == 4 && key % 4 == 3 && level > 0 && level <= options.most_levels) {
      merged[at(level) - 1].push_back(key / 4);
    }
    if (key % 4 == 3) calm = 0;
    previous = {level, key};
  }
  for (std::size_t level = 0; level < splits.size(); ++level) {
    std::vector<std::uint64_t> kept;
    std::sort(splits[level].begin(), splits[level].end());
    std::set_difference(splits[level].begin(), splits[level].end(), merged[level].begin(),
                        merged[level].end(), std::back_inserter(kept));
    splits[level] = std::move(kept);
  }
  return splits;
}

FleshMap AdaptiveFlesh::map_to(const std::vector<int>& new_vertices) const {
  const auto columns_of = [&](const std::vector<int>& vertices) {
    std::vector<int> columns(at(middles_.first) + middles_.edges.size(), -1);
    for (std::size_t c = 0; c < vertices.size(); ++c) columns[at(vertices[c])] = static_cast<int>(c);
    return columns;
  };
  const std::vector<int> old_column = columns_of(vertices_), new_column = columns_of(new_vertices);
  const auto nearest_old = [&](int vertex) {
    while (old_column[at(vertex)] < 0) vertex = middles_.edges[at(vertex - middles_.first)][0];
    return old_column[at(vertex)];
  };
  const int old_columns = static_cast<int>(vertices_.size()),
            new_columns = static_cast<int>(new_vertices.size());
  FleshMap map;
  for (int layer = 0; layer < base_.layers; ++layer) {
    for (const int v : vertices_) {
      const int c = new_column[at(v)];
      map.new_of_old.push_back(c < 0 ? -1 : layer * new_columns + c);
    }
    for (const int v : new_vertices) {
      const bool is_old = old_column[at(v)] >= 0;
      const auto [a, b] = is_old ? Edge{v, v} : middles_.edges[at(v - middles_.first)];
      map.origin.push_back({layer * old_columns + nearest_old(a), layer * old_columns + nearest_old(b)});
    }
  }
  return map;
}

Result<void> AdaptiveFlesh::set_base(Flesh base) {
  TURGOR_CHECK(validate(base));
  base.surface = to_polyhedron(triangulated(base.surface));
  if (base.layers != base_.layers || base.columns() != base_.columns() ||
      base.surface.corners != base_.surface.corners) {
    return broken("the flesh given has other polygons or layers", "Begin a new refinement of it");
  }
  const RefinedSurface surface(base.surface, splits_, middles_);
  Flesh fine = surface.fleshed(base);
  TURGOR_CHECK(validate(fine));
  triangles_ = surface.triangles(fine.surface.points);
  flesh_ = std::move(fine);
  base_ = std::move(base);
  return {};
}

Result<FleshMap> AdaptiveFlesh::adapt(const std::vector<double>& measure, const RefinementOptions& options) {
  TURGOR_CHECK(validate(base_));
  TURGOR_CHECK(check(flesh_, measure, options));
  Splits splits = wanted_splits(measure, options);
  const RefinedSurface surface = RefinedSurface::balanced(base_.surface, splits, middles_);
  Flesh fine = surface.fleshed(base_);
  TURGOR_CHECK(validate(fine));
  FleshMap map = map_to(surface.vertices());
  triangles_ = surface.triangles(fine.surface.points);
  vertices_ = surface.vertices();
  flesh_ = std::move(fine);
  splits_ = std::move(splits);
  return map;
}

}  // namespace turgor
