#include "anatomy/bone_labels.hpp"

#include <algorithm>

#include "anatomy/bone_flood.hpp"
#include "anatomy/mandible.hpp"
#include "anatomy/teeth.hpp"
#include "turgor/imaging/segmentation.hpp"

namespace turgor {
namespace {

LabelVolume bone_mask(const ScannedBody& body, double level) {
  LabelVolume mask(body.hu.grid);
  parallel_for(mask.voxels.size(), 1 << 18, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      mask.voxels[v] = body.solid.voxels[v] != 0 && body.hu.voxels[v] >= level;
    }
  });
  return mask;
}

std::size_t count(const LabelVolume& labels, std::uint8_t label) {
  return static_cast<std::size_t>(std::count(labels.voxels.begin(), labels.voxels.end(), label));
}

/// Keeps the largest connected part of each label; rami keep one part on either side.
void keep_largest_parts(LabelVolume& labels) {
  for (const std::uint8_t label : {kSkull, kMandible, kRamus}) {
    LabelVolume mask(labels.grid);
    bool any = false;
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      mask.voxels[v] = labels.voxels[v] == label;
      any = any || mask.voxels[v] != 0;
    }
    if (!any) continue;
    const LabelVolume kept =
        label == kRamus ? remove_small_components(mask, static_cast<std::size_t>(1.0 / voxel_ml(mask.grid)))
                        : largest_component(mask);
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      if (mask.voxels[v] != 0 && kept.voxels[v] == 0) labels.voxels[v] = kNoBone;
    }
  }
}

/// The mandible where it is a piece of its own. `pieces` of the bone mask, the skull first.
bool find_separate_mandible(const Components& pieces, const Cranium& cranium, LabelVolume& labels) {
  for (int label = 2; label <= static_cast<int>(pieces.sizes.size()); ++label) {
    if (!has_volume_of_mandible(pieces.sizes[static_cast<std::size_t>(label - 1)], labels.grid)) break;
    const LabelVolume piece = component_mask(pieces, label);
    if (!looks_like_mandible(piece, cranium)) continue;
    for (std::size_t v = 0; v < piece.voxels.size(); ++v) {
      if (piece.voxels[v] != 0) labels.voxels[v] = kMandible;
    }
    return true;
  }
  return false;
}

/// Parts skull and mandible where they touch; otherwise what the scan shows of the rami. `touching` is the
/// piece of bone that holds the skull.
void part_by_density(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium,
                     const LabelVolume& bone, const LabelVolume& touching, BoneLabels& bones) {
  std::optional<LabelVolume> markers;
  if (bones.occlusal_plane) {
    markers = markers_by_occlusal_plane(body.hu, touching, bones.teeth, *bones.occlusal_plane, cranium);
  }
  if (!markers) markers = markers_by_rising_threshold(body.hu, touching, levels, cranium);
  if (markers) {
    const LabelVolume flooded = flood_by_density(body.hu, touching, *markers);
    LabelVolume mandible(flooded.grid);
    for (std::size_t v = 0; v < flooded.voxels.size(); ++v)
      mandible.voxels[v] = flooded.voxels[v] == kMandible;
    if (looks_like_mandible(largest_component(mandible), cranium)) {
      bones.labels = flooded;
      bones.mandible_state = MandibleState::cut;
      return;
    }
  }
  bones.occlusal_plane.reset();
  markers = markers_of_rami(bone, bones.teeth, cranium);
  if (markers) bones.labels = flood_by_density(body.hu, bone, *markers);
}

}  // namespace

Result<BoneLabels> label_bones(const ScannedBody& body, const TissueLevels& levels, const Cranium& cranium,
                               const HeadOptions& options, Context& context) {
  const Stage stage(context, "Separating the bones");
  const LabelVolume bone = bone_mask(body, levels.bone_level);
  const Components pieces = connected_components(bone);
  TURGOR_CHECK(context.check());
  BoneLabels bones;
  const LabelVolume largest = component_mask(pieces, 1);
  bones.labels = largest;
  bones.teeth = find_teeth(body, levels, cranium);
  bones.occlusal_plane =
      options.occlusal_plane ? options.occlusal_plane : find_occlusal_plane(bones.teeth, body.hu);
  TURGOR_CHECK(context.check());
  if (options.separate_mandible) {
    if (find_separate_mandible(pieces, cranium, bones.labels)) {
      bones.mandible_state = MandibleState::separate;
    } else {
      part_by_density(body, levels, cranium, bone, largest, bones);
    }
  }
  keep_largest_parts(bones.labels);
  const std::size_t loose = count(bone, 1) - (bone.voxels.size() - count(bones.labels, kNoBone));
  bones.loose_ml = static_cast<double>(loose) * voxel_ml(bone.grid);
  if (static_cast<double>(count(bones.labels, kSkull)) * voxel_ml(bone.grid) < 20) {
    return Error{.what = "no piece of bone in the scan is large enough for a skull",
                 .remedy = "Lower the bone threshold, or choose a scan with less noise"};
  }
  return bones;
}

}  // namespace turgor
