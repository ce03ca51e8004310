#include "anatomy/mandible.hpp"

#include <algorithm>
#include <cmath>

#include "anatomy/ramus_track.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

/// Beyond this distance from the occlusal plane a voxel of the dental arch surely belongs to one row. Upper
/// incisors overlap lower ones by less.
constexpr double kBandMm = 4.0;
/// What lies this near to a tooth, seen along the occlusal plane's normal, belongs to the arch.
constexpr double kArchMm = 3.0;

/// Calls visit(offset, patient point) for the voxels of the box where the mask is set.
template <class Visit>
void for_each_voxel(const LabelVolume& mask, const VoxelBox& box, Visit&& visit) {
  const Grid& g = mask.grid;
  for (int k = box.lower[2]; k <= box.upper[2]; ++k) {
    for (int j = box.lower[1]; j <= box.upper[1]; ++j) {
      for (int i = box.lower[0]; i <= box.upper[0]; ++i) {
        const std::size_t v = g.offset(i, j, k);
        if (mask.voxels[v] != 0) visit(v, g.to_patient({double(i), double(j), double(k)}));
      }
    }
  }
}
template <class Visit>
void for_each_voxel(const LabelVolume& mask, Visit&& visit) {
  for_each_voxel(mask, bounding_box(mask), visit);
}

/// Points laid flat on a plane, as cells of 1 mm: which cells lie within a distance of one of the points.
class Footprint {
 public:
  Footprint(const LabelVolume& mask, const Plane& plane, double reach_mm)
      : reach_(static_cast<int>(reach_mm)) {
    across_ = normalized(cross(Vec3{0, 1, 0}, plane.normal));
    back_ = cross(plane.normal, across_);
    cells_.assign(static_cast<std::size_t>(kSide) * kSide, 0);
    for_each_voxel(mask, [&](std::size_t, const Vec3& p) {
      if (!placed_) origin_ = p, placed_ = true;
      const auto [a, b] = cell(p);
      for (int da = -reach_; da <= reach_; ++da) {
        for (int db = -reach_; db <= reach_; ++db) {
          if (da * da + db * db <= reach_ * reach_ && inside(a + da, b + db)) {
            cells_[static_cast<std::size_t>(b + db) * kSide + static_cast<std::size_t>(a + da)] = 1;
          }
        }
      }
    });
  }
  [[nodiscard]] bool contains(const Vec3& p) const {
    const auto [a, b] = cell(p);
    return inside(a, b) && cells_[static_cast<std::size_t>(b) * kSide + static_cast<std::size_t>(a)] != 0;
  }

 private:
  static constexpr int kSide = 400;
  static bool inside(int a, int b) { return a >= 0 && b >= 0 && a < kSide && b < kSide; }
  [[nodiscard]] std::array<int, 2> cell(const Vec3& p) const {
    return {static_cast<int>(std::lround(dot(p - origin_, across_))) + kSide / 2,
            static_cast<int>(std::lround(dot(p - origin_, back_))) + kSide / 2};
  }
  Vec3 across_, back_, origin_;
  bool placed_ = false;
  int reach_;
  std::vector<std::uint8_t> cells_;
};

/// Extent of the points of a mask and how they are spread.
struct Spread {
  Box3 box;
  double ml = 0;
};
Spread spread_of(const LabelVolume& mask) {
  Spread spread;
  std::size_t count = 0;
  for_each_voxel(mask, [&](std::size_t, const Vec3& p) {
    spread.box.extend(p);
    ++count;
  });
  spread.ml = static_cast<double>(count) * voxel_ml(mask.grid);
  return spread;
}

void mark(LabelVolume& markers, const LabelVolume& mask, std::uint8_t label) {
  for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
    if (mask.voxels[v] != 0) markers.voxels[v] = label;
  }
}

/// The vault and what lies well behind the ears is skull.
bool surely_skull(const Vec3& p, const Cranium& cranium) {
  return p.z > cranium.centre.z || p.y > cranium.centre.y + 45;
}

}  // namespace

bool looks_like_mandible(const LabelVolume& piece, const Cranium& cranium) {
  const Spread spread = spread_of(piece);
  const Vec3 size = spread.box.size();
  if (size.x < 55 || size.x > 160 || size.y < 35 || size.z < 25) return false;
  if (spread.box.centre().z > cranium.centre.z - 30 || spread.box.lower.y > cranium.centre.y - 20)
    return false;
  const double middle = spread.box.centre().x;
  double chin = 0, front = 0, back_middle = 0, back = 0;
  for_each_voxel(piece, [&](std::size_t, const Vec3& p) {
    const double depth = (p.y - spread.box.lower.y) / size.y;
    const bool central = std::abs(p.x - middle) < 0.1 * size.x;
    if (depth < 0.3) front += 1, chin += central ? 1 : 0;
    if (depth > 0.6) back += 1, back_middle += central ? 1 : 0;
  });
  return chin > 0.04 * front && front > 0 && back > 0 && back_middle < 0.02 * back;
}

std::optional<LabelVolume> markers_by_occlusal_plane(const CtVolume& hu, const LabelVolume& bone,
                                                     const LabelVolume& teeth, const Plane& plane,
                                                     const Cranium& cranium) {
  const Footprint arch(teeth, plane, kArchMm);
  LabelVolume markers(bone.grid), below(bone.grid), rows(bone.grid);
  for_each_voxel(bone, [&](std::size_t v, const Vec3& p) {
    if (surely_skull(p, cranium)) markers.voxels[v] = kSkull;
    const double height = plane.signed_distance(p);
    if (height > 2 * kBandMm || !arch.contains(p)) return;
    (height < -kBandMm ? below : rows).voxels[v] = 1;
  });
  below = largest_component(below);
  const Spread spread = spread_of(below);
  if (spread.ml < 3 || spread.box.size().x < 30) return std::nullopt;
  // A chin: bone in the middle of the front that goes down well below the teeth.
  const Vec3 size = spread.box.size();
  double lowest = 0;
  for_each_voxel(below, [&](std::size_t, const Vec3& p) {
    const bool front = p.y < spread.box.lower.y + 0.4 * size.y;
    if (front && std::abs(p.x - spread.box.centre().x) < 10)
      lowest = std::min(lowest, plane.signed_distance(p));
  });
  constexpr double kLeastChinMm = 18;
  if (lowest > -kLeastChinMm) return std::nullopt;
  mark_rami(hu, bone, below, rows, plane, kBandMm, markers);
  mark(markers, below, kMandible);
  return markers;
}

bool has_volume_of_mandible(std::size_t voxels, const Grid& grid) {
  const double ml = static_cast<double>(voxels) * voxel_ml(grid);
  return ml > 6 && ml < 200;
}

std::optional<LabelVolume> markers_by_rising_threshold(const CtVolume& hu, const LabelVolume& bone,
                                                       const TissueLevels& levels, const Cranium& cranium) {
  // Only what lies below the middle of the cavity can be mandible; the rest need not be looked at each time.
  const Index3 n = hu.grid.size;
  const VoxelBox lower{{0, 0, 0}, {n[0] - 1, n[1] - 1, static_cast<int>(hu.grid.to_index(cranium.centre).z)}};
  const CtVolume values = crop(hu, lower);
  const LabelVolume all = crop(bone, lower);
  LabelVolume dense(all.grid);
  for (double part = 0.15; part < 1.3; part += 0.15) {
    const double level = levels.bone_level + part * (levels.bone - levels.bone_level);
    parallel_for(dense.voxels.size(), 1 << 18, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v)
        dense.voxels[v] = all.voxels[v] != 0 && values.voxels[v] >= level;
    });
    const Components pieces = connected_components(dense);
    for (int label = 2; label <= static_cast<int>(pieces.sizes.size()); ++label) {
      if (!has_volume_of_mandible(pieces.sizes[static_cast<std::size_t>(label - 1)], dense.grid)) break;
      const LabelVolume piece = component_mask(pieces, label);
      if (!looks_like_mandible(piece, cranium)) continue;
      LabelVolume markers(bone.grid);
      for_each_voxel(bone, [&](std::size_t v, const Vec3& p) {
        const bool skull = v < piece.voxels.size() && pieces.labels.voxels[v] == 1;
        if (skull || surely_skull(p, cranium)) markers.voxels[v] = kSkull;
      });
      mark(markers, piece, kMandible);
      return markers;
    }
  }
  return std::nullopt;
}

std::optional<LabelVolume> markers_of_rami(const LabelVolume& bone, const LabelVolume& teeth,
                                           const Cranium& cranium) {
  const Grid& g = bone.grid;
  constexpr double kSlabMm = 6;
  VoxelBox slab{{0, 0, 0}, {g.size[0] - 1, g.size[1] - 1, static_cast<int>(kSlabMm / g.spacing.z)}};
  slab = clipped(slab, g);
  const Components sections = connected_components(crop(bone, slab));
  const Spread rows = spread_of(teeth);
  LabelVolume markers(g);
  for_each_voxel(bone, [&](std::size_t v, const Vec3& p) {
    if (surely_skull(p, cranium)) markers.voxels[v] = kSkull;
  });
  bool found = false;
  for (int label = 1; label <= static_cast<int>(sections.sizes.size()); ++label) {
    const LabelVolume section = component_mask(sections, label);
    const Spread spread = spread_of(section);
    if (spread.ml < 0.2) break;
    const Vec3 centre = spread.box.centre(), size = spread.box.size();
    const bool lateral = std::abs(centre.x - cranium.centre.x) > 30 && size.x < 35;
    const bool between = centre.y < cranium.centre.y + 15 && (rows.ml == 0 || centre.y > rows.box.upper.y);
    const bool ramus =
        lateral && between && size.y > 15 && size.y < 60 && size.z > 0.7 * (kSlabMm - g.spacing.z);
    found = found || ramus;
    // Sections in the slab have the same offsets as in the volume: both start at voxel (0, 0, 0).
    for (std::size_t v = 0; v < section.voxels.size(); ++v) {
      if (section.voxels[v] != 0) markers.voxels[v] = ramus ? kRamus : kSkull;
    }
  }
  if (!found) return std::nullopt;
  return markers;
}

}  // namespace turgor
