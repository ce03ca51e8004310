#include "anatomy/body_mask.hpp"

#include <algorithm>
#include <cmath>

#include "anatomy/coarse_grid.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

/// A ball of this radius cannot enter nostrils, ear canals and a mouth that is not wide open.
constexpr double kClosingRadiusMm = 5.0;
/// What the ball leaves out is a cavity where somewhere it goes as deep as this; creases of the skin stay
/// open.
constexpr double kCavityDepthMm = 7;
/// A cavity is closed from this depth on, and over its mouth.
constexpr double kCreaseDepthMm = 2.5;
constexpr double kMarginMm = 12;
/// Smaller loose pieces are noise and not worth counting.
constexpr double kSmallestPieceMl = 0.5;
/// Holder, table and cables have no part thicker than this.
constexpr double kObjectThicknessMm = 9;
/// … and reach further than any part of a head that is as thin (an ear: 70 mm).
constexpr double kObjectReachMm = 95;
/// Contacts of objects with the head extend this far beyond the objects' free parts.
constexpr double kContactMm = 30;
constexpr double kRoundnessMm = 18;

template <class Combine>
LabelVolume combined(const LabelVolume& a, const LabelVolume& b, Combine&& combine) {
  LabelVolume out(a.grid);
  parallel_for(out.voxels.size(), 1 << 18, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      out.voxels[v] = combine(a.voxels[v] != 0, b.voxels[v] != 0) ? 1 : 0;
    }
  });
  return out;
}
LabelVolume difference(const LabelVolume& a, const LabelVolume& b) {
  return combined(a, b, [](bool x, bool y) { return x && !y; });
}
LabelVolume both(const LabelVolume& a, const LabelVolume& b) {
  return combined(a, b, [](bool x, bool y) { return x && y; });
}
LabelVolume inverted(const LabelVolume& a) {
  return combined(a, a, [](bool x, bool) { return !x; });
}

/// The mask with slices and rows of air added on every side but below, where the body goes on.
LabelVolume padded_with_air(const LabelVolume& mask, double margin_mm, Index3& shift) {
  Grid g = mask.grid;
  for (std::size_t a = 0; a < 3; ++a) {
    shift[a] = static_cast<int>(std::ceil(margin_mm / g.spacing[static_cast<int>(a)]));
    g.size[a] += a == 2 ? shift[a] : 2 * shift[a];
  }
  shift[2] = 0;
  g.origin = mask.grid.to_patient({-double(shift[0]), -double(shift[1]), 0});
  LabelVolume padded(g);
  paste(padded, mask, shift);
  return padded;
}

/// fill_holes, but with a floor laid below the lowest slice: a pharynx that the scan cuts is a hole as well.
LabelVolume fill_holes_on_floor(const LabelVolume& mask) {
  Grid floored = mask.grid;
  ++floored.size[2];
  LabelVolume padded(floored, 1);
  paste(padded, mask, {0, 0, 1});
  const Index3 n = floored.size;
  LabelVolume filled = crop(fill_holes(padded), {{0, 0, 1}, {n[0] - 1, n[1] - 1, n[2] - 1}});
  filled.grid = mask.grid;
  return filled;
}

/// All that a ball rolled over the body from outside does not touch: the body, its cavities, and its creases.
LabelVolume unreachable_by_ball(const LabelVolume& body, double radius_mm) {
  Index3 shift;
  const LabelVolume in_air = padded_with_air(body, 2.5 * radius_mm, shift);
  const LabelVolume out_of_reach_of_centres = fill_holes_on_floor(dilate(in_air, radius_mm));
  const LabelVolume unreached = inverted(dilate(inverted(out_of_reach_of_centres), radius_mm));
  VoxelBox inner{shift, {}};
  for (std::size_t a = 0; a < 3; ++a) inner.upper[a] = shift[a] + body.grid.size[a] - 1;
  LabelVolume out = crop(unreached, inner);
  out.grid = body.grid;
  return out;
}

/// Air that no ball reaches, less the creases of the skin.
LabelVolume find_cavities(const LabelVolume& body) {
  const LabelVolume enclosed = unreachable_by_ball(body, kClosingRadiusMm);
  const LabelVolume filled = difference(enclosed, body);
  const Components parts = connected_components(both(filled, erode(enclosed, kCreaseDepthMm)));
  const LabelVolume deepest = erode(enclosed, kCavityDepthMm);
  std::vector<bool> cavity(parts.sizes.size() + 1, false);
  for (std::size_t v = 0; v < deepest.voxels.size(); ++v) {
    if (deepest.voxels[v] != 0) cavity[static_cast<std::size_t>(parts.labels.voxels[v])] = true;
  }
  LabelVolume deep(body.grid);
  for (std::size_t v = 0; v < deep.voxels.size(); ++v) {
    const std::int32_t part = parts.labels.voxels[v];
    deep.voxels[v] = part != 0 && cavity[static_cast<std::size_t>(part)];
  }
  const double step = std::max({body.grid.spacing.x, body.grid.spacing.y, body.grid.spacing.z});
  return both(filled, dilate(deep, kCreaseDepthMm + step));
}

/// Components of thin parts that reach far, in cells of a coarse grid.
struct Objects {
  LabelVolume cells;
  int count = 0;
};
Objects find_attached_objects(const LabelVolume& body) {
  const double radius = 0.5 * kObjectThicknessMm;
  const LabelVolume solid = fill_holes_on_floor(body);
  const LabelVolume core = largest_component(erode(solid, radius));
  const double cell = std::max({body.grid.spacing.x, body.grid.spacing.y, body.grid.spacing.z});
  const LabelVolume thin = difference(body, dilate(core, radius + 1.5 * cell));
  const Components parts = connected_components(thin);
  Objects objects{LabelVolume(body.grid), 0};
  for (int label = 1; label <= static_cast<int>(parts.sizes.size()); ++label) {
    if (static_cast<double>(parts.sizes[static_cast<std::size_t>(label - 1)]) * voxel_ml(body.grid) < 0.3)
      break;
    const LabelVolume object = component_mask(parts, label);
    const Index3 extent = bounding_box(object).size();
    Vec3 size;
    for (int a = 0; a < 3; ++a) size[a] = extent[static_cast<std::size_t>(a)] * body.grid.spacing[a];
    if (length(size) < kObjectReachMm) continue;
    ++objects.count;
    objects.cells = combined(objects.cells, object, [](bool x, bool y) { return x || y; });
  }
  if (objects.count == 0) return objects;
  // Where an object lies flat against the head it is thick together with it: near objects the head keeps only
  // what a large ball inside it reaches, for which a vault is round enough.
  const LabelVolume round = open_gaps(difference(solid, objects.cells), kRoundnessMm);
  const LabelVolume rim = both(difference(body, round), dilate(objects.cells, kContactMm));
  objects.cells = combined(objects.cells, rim, [](bool x, bool y) { return x || y; });
  return objects;
}

LabelVolume largest_body(const CtVolume& scan, const TissueLevels& levels, int& removed_pieces) {
  const Components parts =
      connected_components(threshold(scan, static_cast<int>(std::lround(levels.skin_level)), 32767));
  for (std::size_t i = 1; i < parts.sizes.size(); ++i) {
    if (static_cast<double>(parts.sizes[i]) * voxel_ml(scan.grid) > kSmallestPieceMl) ++removed_pieces;
  }
  return component_mask(parts, 1);
}

int count_front(const LabelVolume& body) {
  int count = 0;
  for (int k = 0; k < body.grid.size[2]; ++k) {
    for (int i = 0; i < body.grid.size[0]; ++i) count += body.at(i, 0, k);
  }
  return count;
}

}  // namespace

LabelVolume without_attached_objects(const LabelVolume& mask, int& removed_pieces) {
  // Looked for on cells of 2 mm: quick, and the usual scan has none.
  const CoarseGrid coarse = coarse_grid(mask.grid, 2.0);
  const Volume<std::uint16_t> counts = count_in_cells(mask, coarse, [](std::uint8_t m) { return m != 0; });
  LabelVolume cells(coarse.grid);
  const int half = (coarse.voxels_per_cell() + 1) / 2;
  for (std::size_t c = 0; c < cells.voxels.size(); ++c) cells.voxels[c] = counts.voxels[c] >= half ? 1 : 0;
  if (find_attached_objects(cells).count == 0) return mask;

  const Objects objects = find_attached_objects(mask);
  removed_pieces += objects.count;
  return largest_component(difference(mask, objects.cells));
}

Result<ScannedBody> find_body(const CtVolume& scan, const TissueLevels& levels, Context& context) {
  const Stage stage(context, "Finding the body");
  ScannedBody body;
  LabelVolume tissue = largest_body(scan, levels, body.removed_pieces);
  TURGOR_CHECK(context.check());
  const VoxelBox box = widened(bounding_box(tissue), kMarginMm, scan.grid);
  tissue = crop(tissue, box);
  tissue = without_attached_objects(tissue, body.removed_pieces);
  TURGOR_CHECK(context.check());

  const VoxelBox inner = widened(bounding_box(tissue), kMarginMm, tissue.grid);
  tissue = crop(tissue, inner);
  body.hu = crop(crop(scan, box), inner);
  const Grid& g = tissue.grid;
  body.cavity = find_cavities(tissue);
  body.solid = combined(tissue, body.cavity, [](bool x, bool y) { return x || y; });
  const std::size_t slice = static_cast<std::size_t>(g.size[0]) * static_cast<std::size_t>(g.size[1]);
  body.touches_lower_end =
      std::any_of(body.solid.voxels.begin(), body.solid.voxels.begin() + static_cast<std::ptrdiff_t>(slice),
                  [](std::uint8_t m) { return m != 0; });
  constexpr double kLargeAreaMm2 = 2000;
  body.touches_front = count_front(body.solid) * g.spacing.x * g.spacing.z > kLargeAreaMm2;
  TURGOR_CHECK(context.check());
  return body;
}

}  // namespace turgor
