// From voxel labels to the surfaces of a head.
#pragma once

#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

struct SurfaceSettings {
  double level = 0;        ///< HU that separates inside from outside
  double smoothing = 1.0;  ///< 0 none, 1 default
  /// Where label and level disagree: false, the bones of a joint are drawn back to the seam between them;
  /// true, a taut membrane is spanned over closed openings.
  bool membranes = false;
  /// Asked between the steps, some of which take half a second. Where it says stop, the surface is
  /// unfinished.
  const Context* context = nullptr;

  [[nodiscard]] bool stopped() const { return context != nullptr && context->cancelled(); }
};

/// A surface, and which of its points the label alone has placed (on a cut, over a closed opening), where the
/// scan shows no edge.
struct LabelSurface {
  TriMesh mesh;
  std::vector<bool> placed_by_label;
};

/// The largest connected surface around the voxels with `label`, each point where the scan is locally midway
/// between the tissues on either side; smoothed, not reduced.
LabelSurface surface_of_label(const CtVolume& hu, const LabelVolume& labels, std::uint8_t label,
                              const SurfaceSettings& settings);

/// The same of every connected surface rather than of the largest, less those with hardly any volume.
TriMesh surface_pieces_of_label(const CtVolume& hu, const LabelVolume& labels, std::uint8_t label,
                                const SurfaceSettings& settings);

/// Reduced to the number of triangles, one component.
TriMesh reduced(const TriMesh& mesh, int triangles);
/// Reduced, all components.
TriMesh reduced_pieces(const TriMesh& mesh, int triangles);

/// The component of the largest area.
TriMesh largest_surface(const TriMesh& mesh, std::vector<int>* point_map = nullptr);

}  // namespace turgor
