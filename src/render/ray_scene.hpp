// Sixteen rays at a time against triangles: Embree behind the curtain.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "turgor/core/error.hpp"
#include "turgor/math/vec.hpp"

namespace turgor::render_detail {

inline constexpr int lanes = 16;
inline constexpr std::uint32_t no_hit = 0xFFFFFFFFu;

/// Rays as columns. `active` lanes are traced, the others left alone.
struct RayPacket {
  alignas(64) std::array<float, lanes> origin_x{}, origin_y{}, origin_z{}, direction_x{}, direction_y{},
      direction_z{};
  alignas(64) std::array<float, lanes> near{}, far{};
  alignas(64) std::array<int, lanes> active{};  ///< -1 or 0

  void set(int lane, const Vec3f& origin, const Vec3f& direction, float from, float to) {
    const auto i = static_cast<std::size_t>(lane);
    origin_x[i] = origin.x, origin_y[i] = origin.y, origin_z[i] = origin.z;
    direction_x[i] = direction.x, direction_y[i] = direction.y, direction_z[i] = direction.z;
    near[i] = from, far[i] = to, active[i] = -1;
  }
};

struct HitPacket {
  alignas(64) std::array<std::uint32_t, lanes> surface{},
      triangle{};  ///< surface is no_hit where nothing was met
  alignas(64) std::array<float, lanes> distance{}, u{}, v{};
};

/// Triangles of one surface, which must outlive the scene's construction only.
struct SceneSurface {
  const std::vector<Vec3f>* points;
  const std::vector<std::array<std::uint32_t, 3>>* triangles;
};

class RayScene {
 public:
  static Result<RayScene> build(const std::vector<SceneSurface>& surfaces);
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;
  ~RayScene();

  /// Nearest hits. `coherent`: the rays run side by side.
  void intersect(const RayPacket& rays, HitPacket& hits, bool coherent) const;
  /// Bit i is set where ray i meets anything.
  [[nodiscard]] std::uint32_t occluded(const RayPacket& rays, bool coherent) const;

 private:
  struct Handles;
  explicit RayScene(std::unique_ptr<Handles> handles);
  std::unique_ptr<Handles> handles_;
};

}  // namespace turgor::render_detail
