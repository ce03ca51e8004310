// A head modelled with smooth implicit shapes: known truth for every step from scan to prediction.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/imaging/volume.hpp"

namespace turgor {

struct PhantomParameters {
  double size = 1.0;  ///< scale of the whole head, 0.7 to 1.3
  double jaw_protrusion_mm =
      0;                   ///< chin and lower teeth forward (+, prognathic) or back (-, retruded), -12 to 12
  double thickness = 1.0;  ///< scale of the soft-tissue thickness, 0.6 to 1.6
  double voxel_mm = 1.0;   ///< in-plane spacing, 0.4 to 3
  double slice_mm = 1.0;   ///< slice spacing, 0.4 to 5
  double noise_hu = 12;    ///< standard deviation, 0 to 100
  double blur_mm = 0.5;    ///< standard deviation of the scanner's point spread, 0 to 2
  std::uint64_t seed = 1;
  bool head_holder = true;
  bool condyles_touch = false;  ///< the joint space is narrower than a voxel, as in many scans
};

/// Labels of the phantom's voxels, by the tissue at the voxel's centre.
enum class PhantomLabel : std::uint8_t {
  air = 0,
  skin = 1,
  fat = 2,
  muscle = 3,
  skull = 4,
  mandible = 5,
  upper_teeth = 6,
  lower_teeth = 7,
  airway = 8,
  brain = 9,
  eye = 10,
  holder = 11,
  cartilage = 12,
};

/// A surface of the phantom; `bone` is whichever of skull and mandible comes first.
enum class PhantomSurface : std::uint8_t { skin, skull, mandible, bone };

/// The exact shapes. Signed distances (mm, negative inside, exact to first order near the surface), LPS mm,
/// the head upright, midsagittal plane x = 0, nose towards -y. Thread-safe.
class Phantom {
 public:
  static Result<Phantom> create(const PhantomParameters& parameters);
  ~Phantom();
  Phantom(Phantom&&) noexcept;

  [[nodiscard]] const PhantomParameters& parameters() const;
  /// Outer skin with nostrils, ear canals and mouth closed.
  [[nodiscard]] double skin(const Vec3& p) const;
  [[nodiscard]] double skull(const Vec3& p) const;     ///< with upper teeth
  [[nodiscard]] double mandible(const Vec3& p) const;  ///< with lower teeth
  [[nodiscard]] PhantomLabel label(const Vec3& p) const;
  /// Hounsfield number at a point, without blur or noise.
  [[nodiscard]] double hounsfield(const Vec3& p) const;
  /// True landmark positions by name (the names of anatomy/landmarks.hpp), on the surfaces above.
  [[nodiscard]] const std::map<std::string, Vec3>& landmarks() const;
  /// What the scan covers (voxels' outer faces), cutting the neck at its lower end.
  [[nodiscard]] Box3 extent() const;

  /// Distance along the ray (unit `direction`) to where it first crosses the surface, either way, good to
  /// 1e-6 mm; nothing where it does not within `max_mm`.
  [[nodiscard]] std::optional<double> trace(PhantomSurface surface, const Vec3& origin, const Vec3& direction,
                                            double max_mm) const;
  /// Exact thickness of the soft tissue: from each point straight towards its target (one for all, or one a
  /// point) to the first bone, mm; NaN where none lies before the target.
  [[nodiscard]] Result<std::vector<double>> thickness_map(std::span<const Vec3> points,
                                                          std::span<const Vec3> targets,
                                                          Context& context) const;

  /// The surface as triangles from a grid of that spacing (0.25 to 20 mm), closed where the scan cuts the
  /// neck. Errors: a spacing out of range; cancelled.
  [[nodiscard]] Result<TriMesh> surface(PhantomSurface which, double spacing_mm, Context& context) const;

  /// The CT: partial volume by supersampling, blur, noise. The same bits for any number of threads.
  [[nodiscard]] Result<CtVolume> scan(Context& context) const;
  [[nodiscard]] Result<LabelVolume> labels(const Grid& grid, Context& context) const;

 private:
  struct Shapes;
  explicit Phantom(std::unique_ptr<const Shapes> shapes);
  std::unique_ptr<const Shapes> shapes_;
};

}  // namespace turgor
