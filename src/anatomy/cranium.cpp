#include "anatomy/cranium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "anatomy/coarse_grid.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

constexpr double kCellMm = 4.0;
/// Of the 26 directions to neighbouring cells, those in which bone must be met.
constexpr int kLeastDirections = 20;
/// Orbits and nose join the cavity through openings narrower than twice this.
constexpr double kNeckMm = 8;
constexpr double kSmallestCavityMl = 250;
/// Several times an adult's. No head comes near it: the spacing in the file is wrong.
constexpr double kLargestCavityMl = 10'000;
/// Bone this far from the cavity is not vault.
constexpr double kVaultMm = 14;

/// Adds one to every cell from which a ray along `d` meets bone.
void count_direction(const LabelVolume& bone, const Index3& d, Volume<std::uint8_t>& counts) {
  const Grid& g = bone.grid;
  Volume<std::uint8_t> seen(g);
  const auto range = [](int n, int step) {
    return step > 0 ? std::array<int, 3>{n - 1, -1, -1} : std::array<int, 3>{0, n, 1};
  };
  const auto [i0, i1, is] = range(g.size[0], d[0]);
  const auto [j0, j1, js] = range(g.size[1], d[1]);
  const auto [k0, k1, ks] = range(g.size[2], d[2]);
  for (int k = k0; k != k1; k += ks) {
    for (int j = j0; j != j1; j += js) {
      for (int i = i0; i != i1; i += is) {
        if (!g.contains(i + d[0], j + d[1], k + d[2])) continue;
        const std::size_t next = g.offset(i + d[0], j + d[1], k + d[2]);
        if (bone.voxels[next] == 0 && seen.voxels[next] == 0) continue;
        seen.at(i, j, k) = 1;
        ++counts.at(i, j, k);
      }
    }
  }
}

LabelVolume cells_inside_bone(const LabelVolume& bone, const LabelVolume& solid) {
  Volume<std::uint8_t> counts(bone.grid);
  for (int c = 0; c < 27; ++c) {
    const Index3 d{c % 3 - 1, c / 3 % 3 - 1, c / 9 - 1};
    if (d != Index3{0, 0, 0}) count_direction(bone, d, counts);
  }
  LabelVolume inside(bone.grid);
  for (std::size_t c = 0; c < inside.voxels.size(); ++c) {
    inside.voxels[c] = counts.voxels[c] >= kLeastDirections && bone.voxels[c] == 0 && solid.voxels[c] != 0;
  }
  return inside;
}

/// Cells with their mass, for centroids.
struct Mass {
  double cells = 0;
  Vec3 sum;
  [[nodiscard]] Vec3 centre() const { return cells > 0 ? sum / cells : Vec3{}; }
};

template <class Weight>
Mass mass_of(const Grid& grid, Weight&& weight) {
  Mass mass;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double w = weight(grid.offset(i, j, k), i, j, k);
        if (w <= 0) continue;
        mass.cells += w;
        mass.sum += grid.to_patient({double(i), double(j), double(k)}) * w;
      }
    }
  }
  return mass;
}

struct Cells {
  LabelVolume bone, solid, cavity;
  Volume<std::uint16_t> air;  ///< voxels of closed air
  double ml = 0;              ///< of one cell
  double voxels = 1;          ///< in one cell
};

Cells coarse_cells(const ScannedBody& body, const TissueLevels& levels) {
  const CoarseGrid coarse = coarse_grid(body.hu.grid, kCellMm);
  Cells cells{LabelVolume(coarse.grid), LabelVolume(coarse.grid), {}, {}, 0, 1};
  const auto bone_counts =
      count_in_cells(body.hu, coarse, [level = levels.bone_level](std::int16_t v) { return v >= level; });
  const auto solid_counts = count_in_cells(body.solid, coarse, [](std::uint8_t m) { return m != 0; });
  cells.air = count_in_cells(body.cavity, coarse, [](std::uint8_t m) { return m != 0; });
  const int full = coarse.voxels_per_cell();
  const int some = std::max(1, full / 12);
  for (std::size_t c = 0; c < cells.bone.voxels.size(); ++c) {
    cells.solid.voxels[c] = 2 * solid_counts.voxels[c] >= full;
    cells.bone.voxels[c] = bone_counts.voxels[c] >= some && solid_counts.voxels[c] > 0;
  }
  cells.ml = voxel_ml(coarse.grid);
  cells.voxels = full;
  cells.cavity = cells_inside_bone(cells.bone, cells.solid);
  const LabelVolume core = largest_component(erode(cells.cavity, kNeckMm));
  const LabelVolume grown = dilate(core, kNeckMm);
  for (std::size_t c = 0; c < grown.voxels.size(); ++c) {
    cells.cavity.voxels[c] = cells.cavity.voxels[c] && grown.voxels[c];
  }
  return cells;
}

Error wrong_way(const std::string& how, const std::string& remedy) {
  return {.what = "the head is " + how, .remedy = remedy};
}

/// Where the face lies, from the air of nose, sinuses and pharynx and from the bone that is not vault.
Vec3 direction_to_face(const Cells& cells, const Vec3& centre, const Volume<float>& from_cavity) {
  const Mass air =
      mass_of(cells.air.grid, [&](std::size_t c, int, int, int) { return double(cells.air.voxels[c]); });
  const Mass bone = mass_of(cells.bone.grid, [&](std::size_t c, int, int, int) {
    return cells.bone.voxels[c] && from_cavity.voxels[c] > kVaultMm ? 1.0 : 0.0;
  });
  Vec3 direction;
  constexpr double kLeastAirMl = 3;
  if (air.cells / cells.voxels * cells.ml > kLeastAirMl) direction += normalized(air.centre() - centre);
  if (bone.cells * cells.ml > kLeastAirMl) direction += normalized(bone.centre() - centre);
  return normalized(direction);
}

Result<void> check_direction(const Vec3& to_face) {
  const std::string reorient =
      "Check the orientation stored in the file, or reorient the scan, and try again";
  if (to_face.z > 0.25) {
    return wrong_way("upside down: the face lies above the brain", reorient);
  }
  if (std::abs(to_face.x) > 0.6) {
    return wrong_way(to_face.x > 0 ? "turned: the face points to the patient's left"
                                   : "turned: the face points to the patient's right",
                     reorient);
  }
  if (to_face.y > 0.35) return wrong_way("back to front: the face points to the patient's back", reorient);
  return {};
}

/// The bone of the face: in front of the middle of the cavity and below the brow, and not vault.
Result<void> check_face(const Cells& cells, const Cranium& cranium, const Volume<float>& from_cavity,
                        bool touches_front) {
  // Below the brow: at the height of the orbits' lower half and under it.
  constexpr double kBrowMm = 30, kAdultCavityMl = 1350;
  const double brow = cranium.centre.z - kBrowMm * std::cbrt(cranium.cavity_ml / kAdultCavityMl);
  double foremost = 1e9, lowest = 1e9;
  const Mass face = mass_of(cells.bone.grid, [&](std::size_t c, int i, int j, int k) {
    if (cells.bone.voxels[c] == 0 || from_cavity.voxels[c] <= kVaultMm) return 0.0;
    const Vec3 p = cells.bone.grid.to_patient({double(i), double(j), double(k)});
    if (p.y > cranium.centre.y || p.z > brow) return 0.0;
    foremost = std::min(foremost, p.y);
    lowest = std::min(lowest, p.z);
    return 1.0;
  });
  const double expected_ml = 0.02 * cranium.cavity_ml;
  constexpr double kFaceBehindCavityMm = 12, kLeastFaceMm = 30;
  const bool missing = face.cells * cells.ml < expected_ml || lowest > brow - kLeastFaceMm;
  const bool cut = touches_front || foremost > cranium.cavity.lower.y + kFaceBehindCavityMm;
  if (!missing && !cut) return {};
  return Error{
      .what =
          missing
              ? "the face is not in the scan: it shows no facial bone below the brow, or ends close under it"
              : "the face is cut away: neither nose nor upper jaw is in the scan",
      .remedy = "Choose a scan that shows the head at least down to the upper lip, nose included"};
}

}  // namespace

Result<Cranium> find_cranium(const ScannedBody& body, const TissueLevels& levels) {
  const Cells cells = coarse_cells(body, levels);
  Cranium cranium;
  const Mass cavity = mass_of(cells.cavity.grid, [&](std::size_t c, int i, int j, int k) {
    if (cells.cavity.voxels[c] == 0) return 0.0;
    cranium.cavity.extend(cells.cavity.grid.to_patient({double(i), double(j), double(k)}));
    return 1.0;
  });
  cranium.cavity_ml = cavity.cells * cells.ml;
  cranium.centre = cavity.centre();
  if (cranium.cavity_ml < kSmallestCavityMl) {
    return Error{
        .what = fmt::format("the scan does not show a head: no cranial vault (the largest space within bone "
                            "holds {:.0f} ml)",
                            cranium.cavity_ml),
        .remedy = "Choose a CT of the head that shows the face and at least half of the cranium"};
  }
  if (cranium.cavity_ml > kLargestCavityMl) {
    return Error{.what = fmt::format("the head is too large: its cranial cavity holds {:.0f} litres",
                                     cranium.cavity_ml / 1000),
                 .remedy = "Check the voxel spacing stored in the file: it must be in millimetres"};
  }
  const Volume<float> from_cavity = distance_to(cells.cavity, 200);
  cranium.to_face = direction_to_face(cells, cranium.centre, from_cavity);
  TURGOR_CHECK(check_direction(cranium.to_face));
  TURGOR_CHECK(check_face(cells, cranium, from_cavity, body.touches_front));
  return cranium;
}

}  // namespace turgor
