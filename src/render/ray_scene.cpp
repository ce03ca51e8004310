#include "render/ray_scene.hpp"

#include <embree3/rtcore.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace turgor::render_detail {

struct RayScene::Handles {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  Handles() = default;
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;
  ~Handles() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
};

namespace {

Error out_of_memory() {
  return Error{ErrorKind::system, "the surfaces do not fit in memory for ray tracing", "picture",
               "Close other programs or reduce the meshes"};
}

bool attach(RTCDevice device, RTCScene scene, const SceneSurface& surface, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  if (!geometry) return false;
  void* points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                         sizeof(Vec3f), surface.points->size());
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), surface.triangles->size());
  if (points && triangles) {
    std::memcpy(points, surface.points->data(), surface.points->size() * sizeof(Vec3f));
    std::memcpy(triangles, surface.triangles->data(), surface.triangles->size() * 3 * sizeof(std::uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
  }
  rtcReleaseGeometry(geometry);
  return points && triangles;
}

template <class Ray>
void copy_rays(const RayPacket& from, Ray& to) {
  std::memcpy(to.org_x, from.origin_x.data(), sizeof to.org_x);
  std::memcpy(to.org_y, from.origin_y.data(), sizeof to.org_y);
  std::memcpy(to.org_z, from.origin_z.data(), sizeof to.org_z);
  std::memcpy(to.dir_x, from.direction_x.data(), sizeof to.dir_x);
  std::memcpy(to.dir_y, from.direction_y.data(), sizeof to.dir_y);
  std::memcpy(to.dir_z, from.direction_z.data(), sizeof to.dir_z);
  std::memcpy(to.tnear, from.near.data(), sizeof to.tnear);
  std::memcpy(to.tfar, from.far.data(), sizeof to.tfar);
  for (int i = 0; i < lanes; ++i) to.time[i] = 0, to.mask[i] = no_hit, to.id[i] = 0, to.flags[i] = 0;
}

RTCIntersectContext query_context(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

}  // namespace

RayScene::RayScene(std::unique_ptr<Handles> handles) : handles_(std::move(handles)) {}
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;
RayScene::~RayScene() = default;

Result<RayScene> RayScene::build(const std::vector<SceneSurface>& surfaces) {
  auto handles = std::make_unique<Handles>();
  // Embree splits its work by the number of threads, and the order of triangles in its leaves (hence which of
  // two that share an edge is hit) follows that split. A fixed number gives the same bits on every machine.
  handles->device = rtcNewDevice("threads=2,user_threads=0,set_affinity=0");
  if (!handles->device) return out_of_memory();
  handles->scene = rtcNewScene(handles->device);
  rtcSetSceneFlags(handles->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(handles->scene, RTC_BUILD_QUALITY_MEDIUM);
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (!attach(handles->device, handles->scene, surfaces[i], static_cast<unsigned>(i)))
      return out_of_memory();
  rtcCommitScene(handles->scene);
  if (rtcGetDeviceError(handles->device) != RTC_ERROR_NONE) return out_of_memory();
  return RayScene(std::move(handles));
}

void RayScene::intersect(const RayPacket& rays, HitPacket& hits, bool coherent) const {
  RTCRayHit16 query;
  copy_rays(rays, query.ray);
  for (int i = 0; i < lanes; ++i)
    query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID, query.hit.instID[0][i] = no_hit;
  RTCIntersectContext context = query_context(coherent);
  rtcIntersect16(rays.active.data(), handles_->scene, &context, &query);
  std::memcpy(hits.surface.data(), query.hit.geomID, sizeof query.hit.geomID);
  std::memcpy(hits.triangle.data(), query.hit.primID, sizeof query.hit.primID);
  std::memcpy(hits.distance.data(), query.ray.tfar, sizeof query.ray.tfar);
  std::memcpy(hits.u.data(), query.hit.u, sizeof query.hit.u);
  std::memcpy(hits.v.data(), query.hit.v, sizeof query.hit.v);
}

std::uint32_t RayScene::occluded(const RayPacket& rays, bool coherent) const {
  RTCRay16 query;
  copy_rays(rays, query);
  RTCIntersectContext context = query_context(coherent);
  rtcOccluded16(rays.active.data(), handles_->scene, &context, &query);
  std::uint32_t mask = 0;
  for (int i = 0; i < lanes; ++i)
    if (rays.active[static_cast<std::size_t>(i)] && query.tfar[i] < 0) mask |= 1u << i;
  return mask;
}

}  // namespace turgor::render_detail
