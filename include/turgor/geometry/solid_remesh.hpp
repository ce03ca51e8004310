// A new solid about a body that has deformed, while its simulation runs on: the background remeshing that
// Morris (2006) names in sections 2 and 5.1.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/core/error.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tetra_embedding.hpp"
#include "turgor/geometry/voxel_solid.hpp"

namespace turgor {

/// A body at one moment. mm.
struct RemeshSnapshot {
  std::vector<Vec3> rest;                      ///< of the old solid's points
  std::vector<Vec3> positions;                 ///< of the same points now
  std::vector<std::array<int, 4>> tetrahedra;  ///< of the old solid
  TriMesh skin;                                ///< the body's surface as it stands now, closed
};

struct RemeshOptions {
  VoxelOptions voxels;     ///< of the skin as it stands; `border` so that the solid holds all of it
  int repair_sweeps = 60;  ///< at most, over points of tetrahedra that are too flat at rest

  /// Six volumes of a tetrahedron at rest, by the cube of its longest edge; 0.71 for the regular one.
  static constexpr double least_shape = 0.02;
};

/// The new solid and how it hangs on the old.
struct RemeshedSolid {
  SolidMesh solid;              ///< its points at rest; `spacing` is 0
  std::vector<Vec3> positions;  ///< where they stood at the moment of the snapshot: corners of cubes
  /// Each new point in the old tetrahedra: carries positions and velocities of the old points, as they are at
  /// the swap, over to the new ones.
  TetraEmbedding from_old;
  int repaired = 0;                ///< points whose rest position had to be smoothed
  double greatest_outside_mm = 0;  ///< how far a new point lay outside the old solid
};

/// Cubes about the skin as it stands, and for each of their corners the rest position that the deformation of
/// the old tetrahedron about it gives (of the nearest one outside): x ↦ Σ wᵢ Xᵢ with the barycentric weights
/// of x in the positions. Rest positions of tetrahedra that come out turned over or flatter than least_shape
/// are smoothed: each becomes the mean of what its neighbours' deformations say of it.
/// The same bits for any number of threads. Errors: numbers of points that differ, indices out of range,
/// coordinates not finite, all old tetrahedra flat; those of voxelise; tetrahedra that smoothing cannot
/// repair (`where` names a place, mm at rest); cancelled.
Result<RemeshedSolid> remesh_solid(const RemeshSnapshot& snapshot, const RemeshOptions& options,
                                   const Context& context = Context{});

/// remesh_solid on a thread of its own. One at a time; the destructor cancels and waits.
class BackgroundRemesh {
 public:
  BackgroundRemesh();
  ~BackgroundRemesh();
  BackgroundRemesh(BackgroundRemesh&&) noexcept;
  BackgroundRemesh& operator=(BackgroundRemesh&&) noexcept;

  /// Cancels what is under way and begins anew. Errors (system): no thread to be had.
  Result<void> start(RemeshSnapshot snapshot, const RemeshOptions& options);
  /// Started, and neither taken nor cancelled.
  [[nodiscard]] bool started() const;
  /// take() would not wait.
  [[nodiscard]] bool ready() const;
  /// The result, for which it waits. Error (internal) where nothing was started.
  Result<RemeshedSolid> take();
  /// Waits until the work has noticed, which is at its next stage.
  void cancel();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace turgor
