#include "turgor/anatomy/head.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "anatomy/airway.hpp"
#include "anatomy/bone_labels.hpp"
#include "anatomy/coarse_grid.hpp"
#include "anatomy/head_surface.hpp"
#include "anatomy/symmetry.hpp"
#include "anatomy/teeth.hpp"

namespace turgor {
namespace {

constexpr int kFewestVoxels = 16;
constexpr double kSmallestScanMm = 80;
constexpr int kTeethTriangles = 20'000;
constexpr int kAirwayTriangles = 30'000;
/// Part of the triangles of the bones that the mandible gets; rami alone get half of it.
constexpr double kMandibleShare = 0.2;

Result<void> check_size(const Grid& grid) {
  for (int a = 0; a < 3; ++a) {
    const int voxels = grid.size[static_cast<std::size_t>(a)];
    const double extent = voxels * grid.spacing[a];
    if (voxels >= kFewestVoxels && extent >= kSmallestScanMm) continue;
    return Error{.what = fmt::format(
                     "the scan is too small for a head: {} x {} x {} voxels, {:.0f} x {:.0f} x {:.0f} mm",
                     grid.size[0], grid.size[1], grid.size[2], grid.size[0] * grid.spacing.x,
                     grid.size[1] * grid.spacing.y, grid.size[2] * grid.spacing.z),
                 .remedy = fmt::format("Give a CT of at least {0} voxels and {1:.0f} mm in each direction",
                                       kFewestVoxels, kSmallestScanMm)};
  }
  return {};
}

std::size_t count_nonzero(const LabelVolume& mask) {
  return mask.voxels.size() -
         static_cast<std::size_t>(std::count(mask.voxels.begin(), mask.voxels.end(), std::uint8_t{0}));
}

/// The triangles between points that the cut alone has placed.
TriMesh cut_of(const LabelSurface& surface) {
  const TriMesh& mesh = surface.mesh;
  std::vector<bool> keep(mesh.triangles.size());
  for (std::size_t t = 0; t < keep.size(); ++t) {
    keep[t] = true;
    for (const int p : mesh.triangles[t])
      keep[t] = keep[t] && surface.placed_by_label[static_cast<std::size_t>(p)];
  }
  return submesh(mesh, keep);
}

Result<void> add_skin(Head& head, const ScannedBody& body, const TissueLevels& levels,
                      const HeadOptions& options, Context& context) {
  const Stage stage(context, "Skin surface");
  const SurfaceSettings settings{levels.skin_level, options.smoothing, true, &context};
  const LabelSurface skin = surface_of_label(body.hu, body.solid, 1, settings);
  TURGOR_CHECK(context.check());
  head.skin = reduced(skin.mesh, options.skin_triangles);
  return context.check();
}

Result<void> add_bones(Head& head, const ScannedBody& body, const TissueLevels& levels,
                       const BoneLabels& bones, const HeadOptions& options, Context& context) {
  const Stage stage(context, "Bone surfaces");
  const SurfaceSettings settings{levels.bone_level, options.smoothing, false, &context};
  const int share = static_cast<int>(kMandibleShare * options.bone_triangles);
  int left = options.bone_triangles;
  if (bones.mandible_state != MandibleState::absent) {
    const LabelSurface mandible = surface_of_label(body.hu, bones.labels, kMandible, settings);
    TURGOR_CHECK(context.check());
    head.mandible = reduced(mandible.mesh, share);
    if (bones.mandible_state == MandibleState::cut) head.mandible_cut = cut_of(mandible);
    left -= share;
  }
  TURGOR_CHECK(context.check());
  head.rami = reduced_pieces(surface_pieces_of_label(body.hu, bones.labels, kRamus, settings), share / 2);
  if (!head.rami.empty()) left -= share / 2;
  TURGOR_CHECK(context.check());
  const LabelSurface skull = surface_of_label(body.hu, bones.labels, kSkull, settings);
  TURGOR_CHECK(context.check());
  head.skull = reduced(skull.mesh, left);
  return context.check();
}

void add_notices(const Head& head, const BoneLabels& bones, const HeadOptions& options, Context& context) {
  if (head.removed_pieces > 0) {
    context.notice(fmt::format("{} object{} outside the head removed (head holder, table, cables)",
                               head.removed_pieces, head.removed_pieces == 1 ? "" : "s"));
  }
  if (!options.separate_mandible) {
    context.notice("The mandible was not separated from the skull, as asked");
  } else if (head.mandible_state == MandibleState::absent) {
    context.notice(head.rami.empty()
                       ? "The scan ends above the mandible: there is none to operate on"
                       : "The scan ends above the body of the mandible: its rami are kept as fixed bone, "
                         "there is no mandible to operate on");
  } else if (head.mandible_state == MandibleState::cut) {
    context.notice(
        "The mandible touched the skull in the scan and was cut free where the bridge was weakest; look at "
        "the cut");
  }
  constexpr double kWorthSayingMl = 1.0;
  if (bones.loose_ml > kWorthSayingMl) {
    context.notice(
        fmt::format("{:.0f} ml of loose bone (vertebrae, hyoid, crumbs) left out", bones.loose_ml));
  }
}

void warn_of_cut_sides(const ScannedBody& body, Context& context) {
  const Grid& g = body.solid.grid;
  const auto area = [&](int axis, bool far) {
    const auto a = static_cast<std::size_t>(axis), b = (a + 1) % 3, c = (a + 2) % 3;
    std::size_t count = 0;
    Index3 at{};
    at[a] = far ? g.size[a] - 1 : 0;
    for (at[b] = 0; at[b] < g.size[b]; ++at[b]) {
      for (at[c] = 0; at[c] < g.size[c]; ++at[c]) count += body.solid.at(at[0], at[1], at[2]);
    }
    return static_cast<double>(count) * g.spacing[static_cast<int>(b)] * g.spacing[static_cast<int>(c)];
  };
  constexpr double kLeastAreaMm2 = 100;
  const std::pair<std::pair<int, bool>, const char*> sides[] = {{{0, false}, "right"},
                                                                {{0, true}, "left"},
                                                                {{1, false}, "front"},
                                                                {{1, true}, "back"},
                                                                {{2, true}, "top"}};
  for (const auto& [side, name] : sides) {
    if (area(side.first, side.second) > kLeastAreaMm2) {
      context.warning(
          fmt::format("The field of view cuts the head at the {}: the surfaces are open there", name));
    }
  }
}

Box3 box_of_centres(const Grid& grid) {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    box.extend(grid.to_patient({corner & 1 ? grid.size[0] - 1.0 : 0.0, corner & 2 ? grid.size[1] - 1.0 : 0.0,
                                corner & 4 ? grid.size[2] - 1.0 : 0.0}));
  }
  return box;
}

}  // namespace

Result<Head> build_head(const Scan& scan, const HeadOptions& options, Context& context) {
  const Stage stage(context, "Building the head");
  TURGOR_CHECK(check_size(scan.hu.grid));
  TURGOR_TRY(TissueLevels levels, measure_air_and_soft_tissue(scan.hu));
  TURGOR_CHECK(context.check());
  TURGOR_TRY(const ScannedBody body, find_body(scan.hu, levels, context));
  TURGOR_CHECK(measure_bone(body.hu, body.solid, options, levels));
  TURGOR_TRY(const Cranium cranium, find_cranium(body, levels));
  context.progress(0.25);
  TURGOR_TRY(const BoneLabels bones, label_bones(body, levels, cranium, options, context));
  context.progress(0.4);

  Head head;
  head.skin_level_hu = levels.skin_level;
  head.bone_level_hu = levels.bone_level;
  head.scan_box = box_of_centres(scan.hu.grid);
  head.open_below = body.touches_lower_end;
  head.removed_pieces = body.removed_pieces;
  head.mandible_state = bones.mandible_state;
  head.occlusal_plane = bones.occlusal_plane;
  const double ml = voxel_ml(body.hu.grid);
  head.skin_volume_ml = static_cast<double>(count_nonzero(body.solid)) * ml;
  head.bone_volume_ml = static_cast<double>(count_nonzero(bones.labels)) * ml;
  TURGOR_CHECK(add_skin(head, body, levels, options, context));
  context.progress(0.6);
  TURGOR_CHECK(add_bones(head, body, levels, bones, options, context));
  context.progress(0.9);
  head.teeth = teeth_surface(body, bones.teeth, kTeethTriangles);
  head.airway = airway_surface(body, levels, cranium, kAirwayTriangles);
  TURGOR_CHECK(context.check());
  {
    const Stage symmetry(context, "Midsagittal plane");
    head.midsagittal = find_symmetry_plane(head.skull, Plane::through(cranium.centre, {1, 0, 0}));
  }
  warn_of_cut_sides(body, context);
  add_notices(head, bones, options, context);
  return head;
}

}  // namespace turgor
