// The body in a scan: without head holder, table and cables, its cavities closed.
#pragma once

#include "anatomy/tissue_levels.hpp"
#include "turgor/core/context.hpp"
#include "turgor/imaging/scan.hpp"

namespace turgor {

struct ScannedBody {
  CtVolume hu;         ///< the scan, cropped to the body with a margin of air where the scan has one
  LabelVolume solid;   ///< 1 inside the skin: tissue, bone and closed cavities
  LabelVolume cavity;  ///< 1 in the air of closed cavities: nose, mouth, sinuses, pharynx, ear canals
  int removed_pieces = 0;
  bool touches_lower_end = false;  ///< the lowest slice of the scan cuts the body
  bool touches_front = false;      ///< so does the front of the field of view, over a large area
};

/// Errors: no air, nothing but air.
Result<ScannedBody> find_body(const CtVolume& scan, const TissueLevels& levels, Context& context);

/// The largest body of `mask` without plates, tubes and cables that touch it: parts that vanish when the body
/// is eroded by a few millimetres and that reach far. Ears and nose vanish too but are short. Exposed for
/// tests.
LabelVolume without_attached_objects(const LabelVolume& mask, int& removed_pieces);

}  // namespace turgor
