// A head built from a scan: surfaces of skin and bones, airway, landmarks.
#pragma once

#include <optional>
#include <string>

#include "turgor/anatomy/landmarks.hpp"
#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor {

struct HeadOptions {
  /// Level of bone, HU. With `refine_bone_threshold` it is replaced by the level that the histogram gives: a
  /// quarter of the way from soft tissue to bone (near 250 on calibrated scans), clear of the noise; else
  /// taken as it is.
  int bone_threshold_hu = 250;
  bool refine_bone_threshold = true;
  int skin_triangles = 60'000;  ///< surfaces after reduction
  int bone_triangles = 90'000;
  double smoothing = 1.0;  ///< 0 none, 1 default, up to 3
  std::optional<Plane>
      occlusal_plane;  ///< correction of the cut between upper and lower teeth, normal upwards
  bool separate_mandible = true;
};

/// How the mandible was found.
enum class MandibleState {
  separate,  ///< its own piece in the voxels
  cut,       ///< touched the skull and was cut free at the joint spaces or between the teeth
  absent,    ///< the scan ends above it (or it was not found)
};

struct Head {
  TriMesh
      skin;  ///< outside of the head, nostrils, ears and mouth closed; open only where the scan cuts the head
  TriMesh skull;     ///< with upper teeth
  TriMesh mandible;  ///< with lower teeth; empty where absent
  TriMesh rami;  ///< of a mandible whose body the scan does not show (state absent): bone under tissue, never
                 ///< moved
  TriMesh teeth;   ///< both rows, enamel and dentine by density, for display
  TriMesh airway;  ///< nose, mouth, sinuses, pharynx; may be empty
  MandibleState mandible_state = MandibleState::absent;
  TriMesh mandible_cut;  ///< where the mandible was cut free, to be shown; empty unless state is `cut`
  std::optional<Plane> occlusal_plane;  ///< found or given; normal upwards

  double skin_level_hu = 0, bone_level_hu = 0;  ///< global levels, before local refinement
  Box3 scan_box;                                ///< of the voxel centres, mm
  bool open_below = false;                      ///< the scan cuts head or neck at its lower end
  double skin_volume_ml = 0, bone_volume_ml = 0;
  int removed_pieces = 0;           ///< head holder, table, cables
  Plane midsagittal{{1, 0, 0}, 0};  ///< normal to the patient's left
};

/// Scan to head. Errors, each with its remedy (the caller adds the file's name): too few voxels; no skin
/// (nothing but air, or no air); no bone; not a head (no cranial vault); upside down, back to front or turned
/// to one side; face missing or cut away. A mirrored patient cannot be told from the anatomy.
Result<Head> build_head(const Scan& scan, const HeadOptions& options, Context& context);

/// The landmarks that the surfaces show, in patient coordinates. Searched by geometry in the midsagittal
/// plane and in a frame levelled by orbitalia and zygia; one whose place the scan cuts off is absent.
Landmarks find_landmarks(const Head& head, Context& context);

}  // namespace turgor
