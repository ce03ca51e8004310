#include "turgor/geometry/surface_query.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/triangle_math.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

/// Embree's scenes hold single-precision copies about `centre`; every answer is worked out again in double
/// from the surfaces themselves, so it depends on neither the tree nor the order in which its leaves are
/// visited.
struct Body {
  std::vector<Vec3> points;  ///< relative to the centre
  std::vector<Index3> triangles;
  struct Ball {
    Vec3f centre;
    float radius;
  };
  std::vector<Ball> balls;  ///< around each triangle: most are too far away to look at more closely

  [[nodiscard]] std::array<Vec3, 3> corners(unsigned triangle) const {
    const Index3& t = triangles[triangle];
    return {points[static_cast<std::size_t>(t[0])], points[static_cast<std::size_t>(t[1])],
            points[static_cast<std::size_t>(t[2])]};
  }
};

constexpr double huge = 1e30;  ///< as good as infinity, and still a float

float round_down(double x) {
  return std::nextafter(static_cast<float>(std::clamp(x, -huge, huge)),
                        -std::numeric_limits<float>::infinity());
}
float round_up(double x) {
  return std::nextafter(static_cast<float>(std::clamp(x, -huge, huge)),
                        std::numeric_limits<float>::infinity());
}

}  // namespace

namespace {

/// A ray cast gathers its hits here, worked out in double.
struct Gathering {
  RTCIntersectContext context;  ///< first, so that the filter can find the rest
  const std::vector<Body>* bodies;
  Vec3 origin, direction;
  double near, far;
  bool keep_all;
  std::vector<RayHit> hits;
};

/// A hit of the ray with a triangle that Embree found in single precision. Barycentrics that rounding has put
/// outside are brought back to the triangle, so neighbours leave no gap.
RayHit refined(const Gathering& g, unsigned surface, unsigned triangle) {
  const auto [a, b, c] = (*g.bodies)[surface].corners(triangle);
  const auto [u, v] = detail::ray_barycentrics(g.origin, g.direction, a, b, c);
  const Vec3 point = a + (b - a) * u + (c - a) * v;
  return {dot(point - g.origin, g.direction), static_cast<int>(surface), static_cast<int>(triangle), u, v};
}

void filter(const RTCFilterFunctionNArguments* args) {
  auto& g = *reinterpret_cast<Gathering*>(args->context);
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const RayHit hit =
        refined(g, RTCHitN_geomID(args->hit, args->N, i), RTCHitN_primID(args->hit, args->N, i));
    const bool in_range = hit.distance > g.near && hit.distance < g.far;
    if (in_range && g.keep_all) g.hits.push_back(hit);
    if (!in_range || g.keep_all) args->valid[i] = 0;
  }
}

/// Casts the ray; with keep_all every hit in (near, far) is gathered. Returns Embree's own distance to the
/// first hit accepted, or infinity.
double cast(RTCScene scene, Gathering& g, double shift, double from, double to) {
  rtcInitIntersectContext(&g.context);
  g.context.filter = filter;
  const Vec3 start = g.origin + g.direction * shift;
  RTCRayHit ray{};
  ray.ray = {static_cast<float>(start.x),
             static_cast<float>(start.y),
             static_cast<float>(start.z),
             std::max(0.0F, round_down(from - shift)),
             static_cast<float>(g.direction.x),
             static_cast<float>(g.direction.y),
             static_cast<float>(g.direction.z),
             0.0F,
             round_up(to - shift),
             0xffffffffU,
             0,
             0};
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &g.context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::numeric_limits<double>::infinity();
  return static_cast<double>(ray.ray.tfar) + shift;
}

bool before(const RayHit& a, const RayHit& b) {
  if (a.distance != b.distance) return a.distance < b.distance;
  return a.surface != b.surface ? a.surface < b.surface : a.triangle < b.triangle;
}

double least_barycentric(const RayHit& h) {
  return std::min({h.u, h.v, 1 - h.u - h.v});
}

/// Where a ray passes through an edge or a point it meets several triangles of one sheet at one place: one
/// hit is kept, the one most inside its triangle. Sheets facing opposite ways are different crossings.
std::vector<RayHit> merged(Gathering& g, double tolerance) {
  std::sort(g.hits.begin(), g.hits.end(), before);
  const auto exits = [&](const RayHit& h) {
    const auto [a, b, c] =
        (*g.bodies)[static_cast<std::size_t>(h.surface)].corners(static_cast<unsigned>(h.triangle));
    return dot(cross(b - a, c - a), g.direction) > 0;
  };
  const auto adjoin = [&](const RayHit& h, const RayHit& k) {
    const Body& body = (*g.bodies)[static_cast<std::size_t>(h.surface)];
    for (const int p : body.triangles[static_cast<std::size_t>(h.triangle)]) {
      for (const int q : body.triangles[static_cast<std::size_t>(k.triangle)]) {
        if (p == q || body.points[static_cast<std::size_t>(p)] == body.points[static_cast<std::size_t>(q)])
          return true;
      }
    }
    return false;
  };
  std::vector<RayHit> kept;
  for (const RayHit& hit : g.hits) {
    bool joined = false;
    for (std::size_t i = kept.size(); i-- > 0 && hit.distance - kept[i].distance <= tolerance && !joined;) {
      if (kept[i].surface != hit.surface || exits(kept[i]) != exits(hit) || !adjoin(kept[i], hit)) continue;
      joined = true;
      if (least_barycentric(hit) > least_barycentric(kept[i])) kept[i] = hit;
    }
    if (!joined) kept.push_back(hit);
  }
  std::sort(kept.begin(), kept.end(), before);
  return kept;
}

/// Search for the nearest point; ties go to the lowest surface and triangle.
struct Search {
  const std::vector<Body>* bodies;
  Vec3 point;
  double margin;  ///< what single precision may be off by
  double squared_distance;
  Vec3f point_single;
  float reach;  ///< the distance, in single precision and no less
  NearestPoint best = {};
  bool found = false;
};

bool visit(RTCPointQueryFunctionArguments* args) {
  auto& search = *static_cast<Search*>(args->userPtr);
  const Body& body = (*search.bodies)[args->geomID];
  const Body::Ball& ball = body.balls[args->primID];
  const float limit = search.reach + ball.radius;
  if (squared_length(ball.centre - search.point_single) > limit * limit) return false;
  const auto [a, b, c] = body.corners(args->primID);
  const auto closest = detail::closest_on_triangle(search.point, a, b, c);
  const auto surface = static_cast<int>(args->geomID), triangle = static_cast<int>(args->primID);
  if (closest.squared_distance > search.squared_distance) return false;
  if (search.found && closest.squared_distance == search.squared_distance &&
      std::pair(surface, triangle) > std::pair(search.best.surface, search.best.triangle)) {
    return false;
  }
  search.found = true;
  search.squared_distance = closest.squared_distance;
  search.best = {closest.point, 0, surface, triangle, closest.u, closest.v};
  search.reach = round_up(std::sqrt(closest.squared_distance) + search.margin);
  if (!(search.reach < args->query->radius)) return false;
  args->query->radius = search.reach;
  return true;
}

/// Balls about the middles of the triangles, with room for what single precision rounds away.
void add_balls(Body& body) {
  body.balls.resize(body.triangles.size());
  parallel_for(body.triangles.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto [a, b, c] = body.corners(static_cast<unsigned>(i));
      const Vec3 middle = (a + b + c) / 3.0;
      const double radius = std::max({distance(a, middle), distance(b, middle), distance(c, middle)});
      body.balls[i] = {to_float(middle), round_up(radius * (1 + 1e-5))};
    }
  });
}

void attach(RTCDevice device, RTCScene scene, const Body& body) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), body.points.size()));
  auto* triangles = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), body.triangles.size()));
  if (points && triangles) {
    for (const Vec3& p : body.points) {
      for (int i = 0; i < 3; ++i) *points++ = static_cast<float>(p[i]);
    }
    for (const Index3& t : body.triangles) {
      for (const int p : t) *triangles++ = static_cast<unsigned>(p);
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

}  // namespace

struct SurfaceQuery::Implementation {
  explicit Implementation(const std::vector<const TriMesh*>& surfaces);
  ~Implementation() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  /// Hits with distance in (near, far): all, or with `first` those at the place of the first.
  [[nodiscard]] std::vector<RayHit> hits(const Vec3& origin, const Vec3& direction, double near, double far,
                                         bool first) const;
  /// Whether a ray leaves an odd number of times, for each surface by itself.
  [[nodiscard]] std::vector<bool> parity(const Vec3& origin, const Vec3& direction) const;

  std::vector<Body> bodies;
  Vec3 centre;
  double radius = 0;     ///< of a ball about the centre that holds everything
  double tolerance = 0;  ///< within which single precision cannot tell distances apart
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
};

SurfaceQuery::Implementation::Implementation(const std::vector<const TriMesh*>& surfaces) {
  Box3 box;
  for (const TriMesh* surface : surfaces) {
    for (const Vec3& p : surface->points) box.extend(p);
  }
  centre = box.empty() ? Vec3{} : box.centre();
  radius = box.empty() ? 0 : 0.5 * length(box.size());
  tolerance = 1e-6 * radius;
  device = rtcNewDevice(nullptr);
  scene = rtcNewScene(device);
  rtcSetSceneFlags(
      scene, static_cast<RTCSceneFlags>(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION));
  for (const TriMesh* surface : surfaces) {
    Body& body = bodies.emplace_back(Body{surface->points, surface->triangles, {}});
    for (Vec3& p : body.points) p -= centre;
    add_balls(body);
    attach(device, scene, body);
  }
  rtcCommitScene(scene);
}

std::vector<RayHit> SurfaceQuery::Implementation::hits(const Vec3& origin, const Vec3& direction, double near,
                                                       double far, bool first) const {
  if (!is_finite(origin) || !is_finite(direction) || !(near < far)) return {};
  Gathering g{{}, &bodies, origin - centre, direction, near, far, !first, {}};
  // Single precision counts from where the ray comes near the surfaces, however far away it starts.
  const double shift = std::max(0.0, -dot(g.origin, direction) - 1.001 * radius);
  double from = std::max(near - tolerance, 0.0), to = far;
  if (first) {
    const double at = cast(scene, g, shift, from, to);
    if (!(at < std::numeric_limits<double>::infinity())) return {};
    // Neighbours and coincident sheets at the same place: which of them Embree met first is chance.
    const double window = tolerance + 1e-6 * std::abs(at - shift);
    from = std::max(at - window, 0.0), to = at + window;
    g.keep_all = true;
  }
  cast(scene, g, shift, from, to);
  return merged(g, tolerance);
}

std::vector<bool> SurfaceQuery::Implementation::parity(const Vec3& origin, const Vec3& direction) const {
  std::vector<bool> odd(bodies.size(), false);
  for (const RayHit& hit : hits(origin, direction, 0, std::numeric_limits<double>::infinity(), false)) {
    odd[static_cast<std::size_t>(hit.surface)] = !odd[static_cast<std::size_t>(hit.surface)];
  }
  return odd;
}

SurfaceQuery::SurfaceQuery(const TriMesh& surface) : SurfaceQuery(std::vector<const TriMesh*>{&surface}) {}
SurfaceQuery::SurfaceQuery(const std::vector<const TriMesh*>& surfaces)
    : impl_(std::make_unique<Implementation>(surfaces)) {}
SurfaceQuery::~SurfaceQuery() = default;
SurfaceQuery::SurfaceQuery(SurfaceQuery&&) noexcept = default;
SurfaceQuery& SurfaceQuery::operator=(SurfaceQuery&&) noexcept = default;

std::optional<RayHit> SurfaceQuery::first_hit(const Vec3& origin, const Vec3& direction, double near,
                                              double far) const {
  const std::vector<RayHit> hits = impl_->hits(origin, direction, near, far, true);
  if (hits.empty()) return std::nullopt;
  return hits.front();
}

std::vector<RayHit> SurfaceQuery::all_hits(const Vec3& origin, const Vec3& direction, double near,
                                           double far) const {
  return impl_->hits(origin, direction, near, far, false);
}

std::optional<NearestPoint> SurfaceQuery::nearest(const Vec3& point, double max_distance) const {
  if (!is_finite(point) || !(max_distance >= 0)) return std::nullopt;
  const Vec3 p = point - impl_->centre;
  const double limit = std::min(max_distance, huge);
  const double margin = 4e-7 * (impl_->radius + length(p));
  Search search{&impl_->bodies, p, margin, limit * limit, to_float(p), round_up(limit + margin)};
  RTCPointQuery query{search.point_single.x, search.point_single.y, search.point_single.z, 0.0F,
                      search.reach};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(impl_->scene, &query, &context, visit, &search);
  if (!search.found) return std::nullopt;
  search.best.distance = std::sqrt(search.squared_distance);
  search.best.point += impl_->centre;
  return search.best;
}

bool SurfaceQuery::inside(const Vec3& point) const {
  // Directions in no plane or line that a modelled surface is likely to contain.
  static const std::array<Vec3, 3> directions{normalized(Vec3{0.5377, 0.8339, 0.2588}),
                                              normalized(Vec3{-0.8622, 0.3188, 0.4336}),
                                              normalized(Vec3{0.3426, -0.5784, -0.7694})};
  std::vector<int> votes(impl_->bodies.size(), 0);
  for (const Vec3& direction : directions) {
    const std::vector<bool> odd = impl_->parity(point, direction);
    for (std::size_t i = 0; i < votes.size(); ++i) votes[i] += odd[i] ? 1 : 0;
    if (&direction == &directions[1] &&
        std::none_of(votes.begin(), votes.end(), [](int n) { return n == 1; }))
      break;
  }
  return std::any_of(votes.begin(), votes.end(), [](int n) { return n >= 2; });
}

}  // namespace turgor
