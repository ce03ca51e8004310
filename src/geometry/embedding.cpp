#include "turgor/geometry/embedding.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "geometry/triangle_math.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

constexpr std::size_t lanes = 16;
using Lane = std::array<float, lanes>;

/// Sum over the lanes in a fixed order that compilers can vectorise.
float total(const Lane& v) {
  std::array<float, 8> eight{};
  for (std::size_t j = 0; j < 8; ++j) eight[j] = v[j] + v[j + 8];
  std::array<float, 4> four{};
  for (std::size_t j = 0; j < 4; ++j) four[j] = eight[j] + eight[j + 4];
  return (four[0] + four[2]) + (four[1] + four[3]);
}

float sum_of_products(const Lane& a, const Lane& b) {
  Lane product{};
  for (std::size_t j = 0; j < lanes; ++j) product[j] = a[j] * b[j];
  return total(product);
}

/// Two unit vectors at right angles to the unit vector n and to each other (Duff et al. 2017).
std::array<Vec3f, 2> tangents(const Vec3f& n) {
  const float sign = std::copysign(1.0F, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {Vec3f{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, Vec3f{b, sign + n.y * n.y * a, -n.y}};
}

std::span<const int> neighbours_of(const PointAdjacency& adjacency, int point) {
  const auto i = static_cast<std::size_t>(point);
  return {adjacency.neighbours.data() + adjacency.offsets[i],
          static_cast<std::size_t>(adjacency.offsets[i + 1] - adjacency.offsets[i])};
}

/// The corners of a triangle, then the points joined to any of them, nearest to `middle` first.
std::vector<int> points_around(const TriMesh& mesh, const PointAdjacency& adjacency, const Index3& corners,
                               const Vec3& middle) {
  std::vector<int> others;
  for (const int c : corners) {
    for (const int q : neighbours_of(adjacency, c)) {
      if (std::find(corners.begin(), corners.end(), q) == corners.end()) others.push_back(q);
    }
  }
  std::sort(others.begin(), others.end());
  others.erase(std::unique(others.begin(), others.end()), others.end());
  const auto from_middle = [&](int p) {
    return squared_length(mesh.points[static_cast<std::size_t>(p)] - middle);
  };
  std::stable_sort(others.begin(), others.end(),
                   [&](int a, int b) { return from_middle(a) < from_middle(b); });
  others.insert(others.begin(), corners.begin(), corners.end());
  return others;
}

}  // namespace

SurfaceEmbedding::SurfaceEmbedding(const TriMesh& coarse, const std::vector<Vec3>& fine_points,
                                   double reach_mm, double fade_mm)
    : coarse_(coarse), normals_(point_normals(coarse)) {
  build_rings();
  weigh_coarse_points();
  bind(fine_points, std::max(reach_mm, 0.0), std::max(fade_mm, 0.0));
}

void SurfaceEmbedding::build_rings() {
  const PointAdjacency adjacency = point_adjacency(coarse_);
  // On a regular triangulation the kernel reaches just short of the second ring, so the points that take part
  // change from triangle to triangle without a jump.
  std::vector<float> support(coarse_.points.size(), 0);
  for (std::size_t p = 0; p < support.size(); ++p) {
    double sum = 0;
    const auto around = neighbours_of(adjacency, static_cast<int>(p));
    for (const int q : around)
      sum += distance(coarse_.points[p], coarse_.points[static_cast<std::size_t>(q)]);
    if (!around.empty()) support[p] = static_cast<float>(1.7 * sum / static_cast<double>(around.size()));
  }
  rings_.resize(coarse_.triangles.size());
  parallel_for(rings_.size(), 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const Index3& corners = coarse_.triangles[t];
      Ring& ring = rings_[t];
      for (const int c : corners) ring.middle += coarse_.points[static_cast<std::size_t>(c)] / 3.0;
      const std::vector<int> points = points_around(coarse_, adjacency, corners, ring.middle);
      ring.count = static_cast<int>(std::min(points.size(), most_neighbours));
      ring.points.fill(corners[0]);
      for (std::size_t j = 0; j < static_cast<std::size_t>(ring.count); ++j) {
        const Vec3f d = to_float(coarse_.points[static_cast<std::size_t>(points[j])] - ring.middle);
        ring.points[j] = points[j];
        ring.x[j] = d.x, ring.y[j] = d.y, ring.z[j] = d.z;
        ring.used[j] = 1;
      }
      for (std::size_t k = 0; k < 3; ++k) ring.support[k] = support[static_cast<std::size_t>(corners[k])];
    }
  });
}

void SurfaceEmbedding::bind(const std::vector<Vec3>& fine_points, double reach_mm, double fade_mm) {
  bindings_.resize(fine_points.size());
  weights_.resize(fine_points.size());
  const SurfaceQuery query(coarse_);
  const double farthest = reach_mm + fade_mm;
  parallel_for(fine_points.size(), 2048, [&](std::size_t begin, std::size_t end) {
    int last = -1;
    for (std::size_t i = begin; i < end; ++i) {
      // The triangle of the point before is often near: its distance bounds the search, the answer stays the
      // same.
      double bound = farthest;
      if (last >= 0) {
        const Index3& t = coarse_.triangles[static_cast<std::size_t>(last)];
        const auto close = detail::closest_on_triangle(
            fine_points[i], coarse_.points[static_cast<std::size_t>(t[0])],
            coarse_.points[static_cast<std::size_t>(t[1])], coarse_.points[static_cast<std::size_t>(t[2])]);
        bound = std::min(bound, std::sqrt(close.squared_distance) * (1 + 1e-9) + 1e-9);
      }
      Binding& binding = bindings_[i];
      weights_[i].fill(0);
      const auto nearest = query.nearest(fine_points[i], bound);
      if (!nearest) continue;
      last = binding.triangle = nearest->triangle;
      binding.u = static_cast<float>(nearest->u), binding.v = static_cast<float>(nearest->v);
      binding.distance = static_cast<float>(nearest->distance);
      const double t = fade_mm > 0 ? std::clamp((farthest - nearest->distance) / fade_mm, 0.0, 1.0) : 1.0;
      binding.share = static_cast<float>(t * t * (3 - 2 * t));
      weigh(fine_points[i], binding, weights_[i]);
    }
  });
}

struct SurfaceEmbedding::Place {
  Vec3f point, foot;  ///< the point and the nearest one of the surface, about the ring's middle
  Vec3f normal;       ///< unit, interpolated between the triangle's corners
  float support;      ///< kernel radius, mm
};

SurfaceEmbedding::Place SurfaceEmbedding::place_of(const Vec3& point, const Binding& binding) const {
  const Ring& ring = rings_[static_cast<std::size_t>(binding.triangle)];
  const std::array<float, 3> bary{1 - binding.u - binding.v, binding.u, binding.v};
  Place place{to_float(point - ring.middle), {}, {}, 0};
  for (std::size_t k = 0; k < 3; ++k) {
    place.foot += Vec3f{ring.x[k], ring.y[k], ring.z[k]} * bary[k];
    place.normal += to_float(normals_[static_cast<std::size_t>(ring.points[k])]) * bary[k];
    place.support += ring.support[k] * bary[k];
  }
  place.normal = normalized(place.normal);
  return place;
}

SurfaceEmbedding::Weights SurfaceEmbedding::kernel_weights(const Place& place, const Binding& binding) const {
  const Ring& ring = rings_[static_cast<std::size_t>(binding.triangle)];
  const Vec3f& p = place.point;
  const float inverse = 1 / std::max(place.support * place.support, 1e-12F);
  const float off = binding.distance * binding.distance;
  Weights w{};
  for (std::size_t j = 0; j < lanes; ++j) {
    const float dx = ring.x[j] - p.x, dy = ring.y[j] - p.y, dz = ring.z[j] - p.z;
    const float s = 1 - std::max(dx * dx + dy * dy + dz * dz - off, 0.0F) * inverse;
    const float positive = std::max(s, 0.0F);
    w[j] = positive * positive * positive * ring.used[j];
  }
  // Where a sliver's corners are all out of reach, the barycentrics take over.
  w[0] += 1e-3F * (1 - binding.u - binding.v), w[1] += 1e-3F * binding.u, w[2] += 1e-3F * binding.v;
  const float scale = 1 / total(w);
  for (float& x : w) x *= scale;
  return w;
}

void SurfaceEmbedding::weigh(const Vec3& point, Binding& binding, Weights& weights) const {
  const Ring& ring = rings_[static_cast<std::size_t>(binding.triangle)];
  const Place place = place_of(point, binding);
  const Weights w = kernel_weights(place, binding);
  const Vec3f centre{sum_of_products(w, ring.x), sum_of_products(w, ring.y), sum_of_products(w, ring.z)};
  const auto [t1, t2] = tangents(place.normal);
  Lane a{}, b{}, wa{}, wb{};
  for (std::size_t j = 0; j < lanes; ++j) {
    const float dx = ring.x[j] - centre.x, dy = ring.y[j] - centre.y, dz = ring.z[j] - centre.z;
    a[j] = dx * t1.x + dy * t1.y + dz * t1.z;
    b[j] = dx * t2.x + dy * t2.y + dz * t2.z;
    wa[j] = w[j] * a[j];
    wb[j] = w[j] * b[j];
  }
  const float slack = 1e-6F * place.support * place.support + 1e-12F, ab = sum_of_products(wa, b);
  const float aa = sum_of_products(wa, a) + slack, bb = sum_of_products(wb, b) + slack;
  const float inverse_det = 1 / (aa * bb - ab * ab), limit = 0.3F * place.support;
  // First order: the weights meet where the point's normal goes through the tangent plane. That normal
  // depends on the weights, a little: twice is enough. How far this place may lie from the nearest one is
  // bounded, so that points beyond an open rim are not extrapolated.
  Vec3f m = place.normal;
  binding.height = dot(place.point - place.foot, m);
  for (int pass = 0; pass < 2; ++pass) {
    const Vec3f along = place.point - m * binding.height - place.foot;
    float ta = dot(along, t1), tb = dot(along, t2);
    const float bounded = limit / std::sqrt(limit * limit + ta * ta + tb * tb + 1e-12F);
    ta = ta * bounded + dot(place.foot - centre, t1), tb = tb * bounded + dot(place.foot - centre, t2);
    const float ca = (bb * ta - ab * tb) * inverse_det, cb = (aa * tb - ab * ta) * inverse_det;
    for (std::size_t j = 0; j < lanes; ++j) weights[j] = w[j] + ca * wa[j] + cb * wb[j];
    Vec3f base;
    m = {};
    for (std::size_t j = 0; j < static_cast<std::size_t>(ring.count); ++j) {
      base += Vec3f{ring.x[j], ring.y[j], ring.z[j]} * weights[j];
      m += to_float(normals_[static_cast<std::size_t>(ring.points[j])]) * weights[j];
    }
    const float m2 = squared_length(m);
    binding.height = m2 > 0.01F ? dot(place.point - base, m) / m2 : 0.0F;
  }
}

void SurfaceEmbedding::weigh_coarse_points() {
  own_weights_.resize(coarse_.points.size());
  own_bindings_.resize(coarse_.points.size());
  for (std::size_t t = 0; t < coarse_.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto p = static_cast<std::size_t>(coarse_.triangles[t][k]);
      Binding& binding = own_bindings_[p];
      if (binding.triangle >= 0) continue;
      binding = {static_cast<int>(t), k == 1 ? 1.0F : 0.0F, k == 2 ? 1.0F : 0.0F, 0, 1, 0};
      weigh(coarse_.points[p], binding, own_weights_[p]);
    }
  }
}

Vec3 SurfaceEmbedding::blended(const Ring& ring, const Weights& weights,
                               const std::vector<Vec3>& values) const {
  // Relative to one of them, so that a constant comes out exactly.
  const Vec3 first = values[static_cast<std::size_t>(ring.points[0])];
  Vec3 sum;
  for (std::size_t j = 1; j < static_cast<std::size_t>(ring.count); ++j) {
    sum += (values[static_cast<std::size_t>(ring.points[j])] - first) * static_cast<double>(weights[j]);
  }
  return first + sum;
}

std::vector<Vec3> SurfaceEmbedding::displacements(const std::vector<Vec3>& coarse_displacements) const {
  TriMesh moved = coarse_;
  for (std::size_t i = 0; i < moved.points.size(); ++i) moved.points[i] += coarse_displacements[i];
  const std::vector<Vec3> turned = point_normals(moved);
  std::vector<Vec3> turns(turned.size());
  for (std::size_t i = 0; i < turns.size(); ++i) turns[i] = turned[i] - normals_[i];
  // Smooth weights average a little: what they would take off each coarse point's displacement is put on
  // beforehand.
  std::vector<Vec3> sharpened = coarse_displacements;
  for (std::size_t i = 0; i < sharpened.size(); ++i) {
    const Binding& own = own_bindings_[i];
    if (own.triangle < 0) continue;
    const Ring& ring = rings_[static_cast<std::size_t>(own.triangle)];
    const Vec3 carried = blended(ring, own_weights_[i], coarse_displacements) +
                         blended(ring, own_weights_[i], turns) * static_cast<double>(own.height);
    sharpened[i] += coarse_displacements[i] - carried;
  }
  // Eight floats for each coarse point, displacement and change of normal: one wide load a neighbour.
  struct alignas(32) Motion {
    std::array<float, 8> v{};
  };
  std::vector<Motion> motion(moved.points.size());
  for (std::size_t i = 0; i < motion.size(); ++i) {
    const Vec3f d = to_float(sharpened[i]), n = to_float(turns[i]);
    motion[i].v = {d.x, d.y, d.z, 0, n.x, n.y, n.z, 0};
  }
  std::vector<Vec3> result(bindings_.size());
  parallel_for(result.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Binding& binding = bindings_[i];
      if (binding.triangle < 0) continue;
      const Ring& ring = rings_[static_cast<std::size_t>(binding.triangle)];
      const Weights& weights = weights_[i];
      // Relative to one of them, so that a constant displacement comes out exactly.
      const Motion& first = motion[static_cast<std::size_t>(ring.points[0])];
      Motion sum;
      for (std::size_t j = 1; j < static_cast<std::size_t>(ring.count); ++j) {
        const Motion& m = motion[static_cast<std::size_t>(ring.points[j])];
        for (std::size_t k = 0; k < 8; ++k) sum.v[k] += weights[j] * (m.v[k] - first.v[k]);
      }
      const Vec3f rest{sum.v[0], sum.v[1], sum.v[2]};
      const Vec3f normal{sum.v[4] + first.v[4], sum.v[5] + first.v[5], sum.v[6] + first.v[6]};
      const Vec3 d =
          sharpened[static_cast<std::size_t>(ring.points[0])] + to_double(rest + normal * binding.height);
      result[i] = d * static_cast<double>(binding.share);
    }
  });
  return result;
}

}  // namespace turgor
