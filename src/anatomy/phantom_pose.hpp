// The phantom's fields in the patient: the reference parts carried by size, jaw protrusion and soft-tissue
// thickness.
#pragma once

#include <array>

#include "anatomy/implicit.hpp"
#include "anatomy/phantom_shapes.hpp"
#include "turgor/anatomy/phantom.hpp"

namespace turgor::phantom {

/// The fields from which every tissue follows.
enum class Part : std::uint8_t {
  skin,
  skull,
  mandible,
  upper_teeth,
  lower_teeth,
  air,
  muscle,
  brain,
  cartilage,
  holder
};
inline constexpr std::size_t part_count = 10;

/// One tissue: where `outline` is negative and no earlier layer lies.
struct Layer {
  PhantomLabel label;
  double hounsfield;
};

/// A polynomial of the second degree.
struct Quadric {
  Vec3 centre;
  double value = 0;
  Vec3 slope, bend, twist;  ///< of x, y, z; of x², y², z²; of yz, zx, xy
  [[nodiscard]] double at(const Vec3& p) const {
    const Vec3 d = p - centre;
    return value + d.x * (slope.x + bend.x * d.x + twist.z * d.y) +
           d.y * (slope.y + bend.y * d.y + twist.x * d.z) + d.z * (slope.z + bend.z * d.z + twist.y * d.x);
  }
};

/// Fields of some parts that hold in one box only, and there faster.
struct LocalFields {
  std::array<implicit::Field, part_count> fields;
  std::array<Quadric, part_count> quadrics;
  std::array<double, part_count> misfit{};  ///< mm: what the quadric that was tried was off by
  std::uint32_t held = 0;                   ///< bit of each part whose field is there
  std::uint32_t fitted = 0;                 ///< bit of each part whose quadric stands for it
};

class PosedParts {
 public:
  explicit PosedParts(const PhantomParameters& parameters);

  /// Zero on the surface, negative inside; gradient near but not exactly 1.
  [[nodiscard]] double value(Part part, const Vec3& p) const;
  /// The same by `local`, where p lies in its ball.
  [[nodiscard]] double value(Part part, const Vec3& p, const LocalFields& local) const;
  /// Adds the part's field for a box along the axes; `wider` (may be null) holds in one around it. Where a
  /// quadric comes within `tolerance` mm of it (0: never), that instead.
  void add_local(LocalFields& local, Part part, const Vec3& centre, const Vec3& half, double tolerance,
                 const LocalFields* wider) const;
  /// Bound of the change of value() per mm: everywhere, and within `radius` around p.
  [[nodiscard]] double lipschitz(Part part) const;
  [[nodiscard]] double lipschitz(Part part, const Vec3& p, double radius) const;
  /// The value divided by the length of its gradient.
  [[nodiscard]] double distance(Part part, const Vec3& p) const;
  [[nodiscard]] Vec3 gradient(Part part, const Vec3& p) const;
  [[nodiscard]] double eye(const Vec3& p) const;

  /// Where the jaw's protrusion takes a point of the reference mandible (or of the soft tissue) and the size
  /// then puts it. Good to a fraction of a millimetre, for places to search from.
  [[nodiscard]] Vec3 place_bone(const Vec3& reference) const;
  [[nodiscard]] Vec3 place_soft(const Vec3& reference) const;

  [[nodiscard]] const PhantomParameters& parameters() const { return parameters_; }

 private:
  [[nodiscard]] double bone_share(const Vec3& q) const;
  [[nodiscard]] double soft_share(const Vec3& q) const;
  [[nodiscard]] double thickening(const Vec3& q) const;
  [[nodiscard]] Vec3 without_protrusion(const Vec3& q, double share) const;
  /// The point of the reference that `part` has at p.
  [[nodiscard]] Vec3 reference(Part part, const Vec3& p) const;
  /// The part's value at p, given its field's value at p's place q in the reference.
  [[nodiscard]] double posed(Part part, const Vec3& q, double value) const;
  [[nodiscard]] double reference_radius(Part part, double radius) const;
  void fit(LocalFields& local, Part part, const Vec3& centre, const Vec3& half, double tolerance) const;

  PhantomParameters parameters_;
  std::array<implicit::IndexedField, part_count> fields_;
  std::array<double, part_count> stretch_{}, thickening_slope_{};
};

/// The tissues in order of precedence, and the outline of each at one point. Fields are evaluated when first
/// asked for.
class TissueProbe {
 public:
  static constexpr int layer_count = 13;
  static const std::array<Layer, layer_count> layers;

  TissueProbe(const PosedParts& parts, const Vec3& p, const LocalFields* local = nullptr)
      : parts_(parts), p_(p), local_(local) {}
  /// Negative where the layer is, were there no earlier one.
  [[nodiscard]] double outline(int layer);
  /// Bound of the change of outline() per mm within `radius`.
  [[nodiscard]] double lipschitz(int layer, double radius);
  /// The parts that outline() of these layers (bits) asks for.
  static std::uint32_t parts_of(std::uint32_t layer_bits);
  /// The label there, the layer found.
  [[nodiscard]] PhantomLabel label(int layer);
  /// The layer has one label everywhere within `radius`.
  [[nodiscard]] bool same_label(int layer, double radius);

 private:
  double field(Part part);
  const PosedParts& parts_;
  Vec3 p_;
  const LocalFields* local_;
  double slope(Part part, double radius);
  std::array<double, part_count> values_{}, slopes_{};
  std::uint32_t known_ = 0, known_slopes_ = 0;
};

/// As Phantom::trace.
std::optional<double> trace(const PosedParts& parts, PhantomSurface surface, const Vec3& origin,
                            const Vec3& direction, double max_mm);

/// Every landmark, on the zero set of its surface.
std::map<std::string, Vec3> true_landmarks(const PosedParts& parts);

/// Corners of the scanned region, mm.
Box3 scan_extent(const PhantomParameters& parameters);

Result<CtVolume> scan(const PosedParts& parts, Context& context);
Result<LabelVolume> labels(const PosedParts& parts, const Grid& grid, Context& context);

}  // namespace turgor::phantom
