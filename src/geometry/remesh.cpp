#include "turgor/geometry/remesh.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

// A triangle soup with the triangles around each point, edited in place. Dead triangles and points are
// dropped by compact().
class EditableMesh {
 public:
  explicit EditableMesh(const TriMesh& mesh) : points_(mesh.points), triangles_(mesh.triangles) {
    alive_.assign(triangles_.size(), true);
    around_.resize(points_.size());
    for (int t = 0; t < static_cast<int>(triangles_.size()); ++t) {
      for (const int p : triangles_[index(t)]) around_[index(p)].push_back(t);
    }
    boundary_.resize(points_.size());
    for (int p = 0; p < point_count(); ++p) boundary_[index(p)] = compute_boundary(p);
  }

  [[nodiscard]] int point_count() const { return static_cast<int>(points_.size()); }
  [[nodiscard]] int triangle_count() const { return static_cast<int>(triangles_.size()); }
  [[nodiscard]] bool alive(int t) const { return alive_[index(t)]; }
  [[nodiscard]] const Index3& triangle(int t) const { return triangles_[index(t)]; }
  [[nodiscard]] Vec3& point(int p) { return points_[index(p)]; }
  [[nodiscard]] const Vec3& point(int p) const { return points_[index(p)]; }
  [[nodiscard]] bool on_boundary(int p) const { return boundary_[index(p)]; }
  [[nodiscard]] const std::vector<int>& around(int p) const { return around_[index(p)]; }

  // Neighbours of p, ascending.
  [[nodiscard]] std::vector<int> neighbours(int p) const {
    std::vector<int> out;
    for (const int t : around(p)) {
      for (const int q : triangle(t)) {
        if (q != p) out.push_back(q);
      }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  // Triangles on the edge (a, b): one on the boundary, two inside.
  [[nodiscard]] std::vector<int> edge_triangles(int a, int b) const {
    std::vector<int> out;
    for (const int t : around(a)) {
      const Index3& v = triangle(t);
      if (v[0] == b || v[1] == b || v[2] == b) out.push_back(t);
    }
    return out;
  }

  [[nodiscard]] static int opposite(const Index3& t, int a, int b) {
    for (const int p : t) {
      if (p != a && p != b) return p;
    }
    return -1;
  }

  void split(int a, int b) {
    const int m = point_count();
    const std::vector<int> edge = edge_triangles(a, b);
    points_.push_back((point(a) + point(b)) * 0.5);
    around_.emplace_back();
    boundary_.push_back(edge.size() == 1);
    for (const int t : edge) {
      Index3 first = triangle(t), second = first;
      std::replace(first.begin(), first.end(), b, m);
      std::replace(second.begin(), second.end(), a, m);
      replace_triangle(t, first);
      add_triangle(second);
    }
  }

  // Moves a onto b where that keeps the surface manifold and no triangle turns over or grows too long.
  bool collapse(int a, int b, double longest) {
    const std::vector<int> edge = edge_triangles(a, b);
    if (edge.empty() || edge.size() > 2) return false;
    if (on_boundary(a) && (edge.size() != 1 || !on_boundary(b))) return false;
    std::vector<int> common;
    const std::vector<int> na = neighbours(a), nb = neighbours(b);
    std::set_intersection(na.begin(), na.end(), nb.begin(), nb.end(), std::back_inserter(common));
    if (common.size() != edge.size()) return false;
    for (const int t : around(a)) {
      Index3 moved = triangle(t);
      if (std::find(moved.begin(), moved.end(), b) != moved.end()) continue;
      const Vec3 before = normal(moved);
      std::replace(moved.begin(), moved.end(), a, b);
      const Vec3 after = normal(moved);
      if (dot(before, after) < 0.3 * length(before) * length(after) || length(after) <= 1e-12) return false;
      for (const int q : moved) {
        if (q != b && distance(point(q), point(b)) > longest) return false;
      }
    }
    for (const int t : edge) kill(t);
    for (const int t : std::vector<int>(around(a))) {
      Index3 moved = triangle(t);
      std::replace(moved.begin(), moved.end(), a, b);
      replace_triangle(t, moved);
    }
    return true;
  }

  // Turns the inner edge (a, b) into (c, d) where that raises the smallest angle and keeps the surface's
  // course.
  bool flip(int a, int b) {
    const std::vector<int> edge = edge_triangles(a, b);
    if (edge.size() != 2) return false;
    int t0 = edge[0], t1 = edge[1];
    if (!runs(triangle(t0), a, b)) std::swap(t0, t1);
    if (!runs(triangle(t0), a, b) || !runs(triangle(t1), b, a)) return false;
    const int c = opposite(triangle(t0), a, b), d = opposite(triangle(t1), a, b);
    if (c == d || !edge_triangles(c, d).empty()) return false;
    const Index3 n0{a, d, c}, n1{d, b, c};
    const Vec3 before = normalized(normal(triangle(t0))) + normalized(normal(triangle(t1)));
    const Vec3 u0 = normalized(normal(n0)), u1 = normalized(normal(n1));
    if (dot(u0, before) <= 0 || dot(u1, before) <= 0 || dot(u0, u1) < 0.8) return false;
    const double now = std::min(quality(triangle(t0)), quality(triangle(t1)));
    if (std::min(quality(n0), quality(n1)) <= now + 1e-9) return false;
    replace_triangle(t0, n0);
    replace_triangle(t1, n1);
    return true;
  }

  [[nodiscard]] Vec3 normal(const Index3& t) const {
    return cross(point(t[1]) - point(t[0]), point(t[2]) - point(t[0]));
  }

  [[nodiscard]] TriMesh compact() const {
    TriMesh out;
    std::vector<int> number(points_.size(), -1);
    for (int t = 0; t < triangle_count(); ++t) {
      if (!alive(t)) continue;
      Index3 v = triangle(t);
      for (int& p : v) {
        int& n = number[index(p)];
        if (n < 0) {
          n = static_cast<int>(out.points.size());
          out.points.push_back(point(p));
        }
        p = n;
      }
      out.triangles.push_back(v);
    }
    return out;
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] static bool runs(const Index3& t, int a, int b) {
    return (t[0] == a && t[1] == b) || (t[1] == a && t[2] == b) || (t[2] == a && t[0] == b);
  }
  // 4√3 area over the sum of squared edges: 1 for an equilateral triangle.
  [[nodiscard]] double quality(const Index3& t) const {
    const double sum = squared_length(point(t[0]) - point(t[1])) + squared_length(point(t[1]) - point(t[2])) +
                       squared_length(point(t[2]) - point(t[0]));
    return sum > 0 ? 3.4641016151377544 * length(normal(t)) / sum : 0;
  }
  [[nodiscard]] bool compute_boundary(int p) const {
    for (const int q : neighbours(p)) {
      if (edge_triangles(p, q).size() != 2) return true;
    }
    return false;
  }
  void kill(int t) {
    for (const int p : triangle(t)) std::erase(around_[index(p)], t);
    alive_[index(t)] = false;
  }
  void add_triangle(const Index3& v) {
    const int t = triangle_count();
    triangles_.push_back(v);
    alive_.push_back(true);
    for (const int p : v) around_[index(p)].push_back(t);
  }
  void replace_triangle(int t, const Index3& v) {
    for (const int p : triangle(t)) std::erase(around_[index(p)], t);
    triangles_[index(t)] = v;
    for (const int p : v) around_[index(p)].push_back(t);
  }

  std::vector<Vec3> points_;
  std::vector<Index3> triangles_;
  std::vector<bool> alive_;
  std::vector<std::vector<int>> around_;
  std::vector<bool> boundary_;
};

struct Edge {
  int a, b;
};

std::vector<Edge> edges(const EditableMesh& mesh) {
  std::vector<Edge> out;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (!mesh.alive(t)) continue;
    const Index3& v = mesh.triangle(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = v[i], b = v[(i + 1) % 3];
      if (a < b || mesh.edge_triangles(a, b).size() == 1) out.push_back({a, b});
    }
  }
  return out;
}

bool exists(const EditableMesh& mesh, const Edge& e) {
  return !mesh.edge_triangles(e.a, e.b).empty();
}

void relax(EditableMesh& mesh, const SurfaceQuery& surface) {
  const auto count = static_cast<std::size_t>(mesh.point_count());
  std::vector<Vec3> target(count);
  parallel_for(count, 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const int p = static_cast<int>(i);
      target[i] = mesh.point(p);
      if (mesh.around(p).empty() || mesh.on_boundary(p)) continue;
      Vec3 normal{}, mean{};
      double weight = 0;
      for (const int t : mesh.around(p)) {
        const Index3& v = mesh.triangle(t);
        const Vec3 n = mesh.normal(v);
        const double area = length(n);
        normal += n;
        mean += (mesh.point(v[0]) + mesh.point(v[1]) + mesh.point(v[2])) * (area / 3);
        weight += area;
      }
      if (weight <= 0) continue;
      normal = normalized(normal);
      const Vec3 step = mean / weight - mesh.point(p);
      const Vec3 moved = mesh.point(p) + (step - normal * dot(step, normal)) * 0.8;
      const auto nearest = surface.nearest(moved);
      if (nearest) target[i] = nearest->point;
    }
  });
  for (std::size_t i = 0; i < count; ++i) mesh.point(static_cast<int>(i)) = target[i];
}

}  // namespace

Result<TriMesh> remesh_isotropic(const TriMesh& mesh, const SizingField& size_mm, int rounds,
                                 Context& context) {
  const SurfaceQuery surface(mesh);
  EditableMesh work(mesh);
  const auto middle = [&](const Edge& e) { return (work.point(e.a) + work.point(e.b)) * 0.5; };
  for (int round = 0; round < rounds; ++round) {
    TURGOR_CHECK(context.check());
    context.progress(static_cast<double>(round) / rounds);
    for (const Edge& e : edges(work)) {
      if (exists(work, e) && distance(work.point(e.a), work.point(e.b)) > 4.0 / 3.0 * size_mm(middle(e))) {
        work.split(e.a, e.b);
      }
    }
    for (const Edge& e : edges(work)) {
      if (!exists(work, e)) continue;
      const double size = size_mm(middle(e));
      if (distance(work.point(e.a), work.point(e.b)) >= 0.8 * size) continue;
      if (!work.collapse(e.a, e.b, 4.0 / 3.0 * size)) work.collapse(e.b, e.a, 4.0 / 3.0 * size);
    }
    for (const Edge& e : edges(work)) {
      if (exists(work, e)) work.flip(e.a, e.b);
    }
    relax(work, surface);
  }
  return work.compact();
}

}  // namespace turgor
