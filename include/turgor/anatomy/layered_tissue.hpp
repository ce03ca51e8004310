// Layered tissue between skin and bone by rays to two centres (Duysak and Zhang 2005, section 2).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "turgor/anatomy/head.hpp"
#include "turgor/anatomy/lips.hpp"
#include "turgor/core/context.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

struct TissueOptions {
  int columns = 2628;  ///< points wanted on the skin of the face; the number found lies near it
  /// Share of the thickness of each layer, outermost first: skin, SMAS with superficial fat, deep tissue.
  std::vector<double> fractions{0.15, 0.30, 0.55};
  /// Thickness of each layer in mm instead, outermost first: thinned in proportion where the tissue is
  /// thinner than their sum; the innermost takes the rest where it is thicker. Empty: fractions.
  std::vector<double> thickness_mm;
  std::optional<Vec3> upper_centre, lower_centre;  ///< corrections, mm LPS
  std::optional<double> lip_level_mm;              ///< correction: z of the lip line in the midline, LPS
  std::optional<double> bone_level_mm;  ///< no skin above this z; the top of the bone where not given
  double least_thickness_mm = 1.0;
  double greatest_thickness_mm =
      32.0;               ///< a hit farther away lies behind a gap in the bone and counts as missed
  double neck_mm = 60.0;  ///< how far below the chin the tissue goes
  bool lip_slit = true;   ///< part upper and lower lip where the mouth lies
  double release_near_teeth_mm = 4.0;  ///< bone points this near to teeth are not attached: the vestibule
};

/// The part of the head that gets tissue, mm LPS: in front of the ears, and below them round the angles of
/// the jaw.
struct FaceRegion {
  double back_y = 0;  ///< in front of this coronal plane …
  double ear_z = 0;   ///< … which goes back below this height, at a slope, by `farthest_back_mm` at most
  double top_z = 0, bottom_z = 0;

  static constexpr double farthest_back_mm = 45, slope = 1.5;
  /// How far behind `back_y` the region reaches at height z.
  [[nodiscard]] double reach_back(double z) const;
  [[nodiscard]] bool contains(const Vec3& p) const {
    return p.z <= top_z && p.z >= bottom_z && p.y <= back_y + reach_back(p.z);
  }
};

/// What the ray of a column met.
enum class ColumnEnd : std::uint8_t {
  skull,
  mandible,
  none,  ///< missed bone in the first pass, and was given a depth in the second; or left it in the repair
};

/// Points lie in sheets, outermost first: point of column c in sheet s is points[s * columns + c]; sheet 0 is
/// the skin, the last one lies on the bone. Prism (t, s) joins surface triangle t between sheets s and s + 1.
/// Invariant: no prism is inverted (smallest_prism_volume > 0).
struct LayeredTissue {
  FaceRegion region;
  TriMesh surface;  ///< skin triangulation; its points are sheet 0
  int sheets = 4;
  std::vector<Vec3> points;     ///< sheets * columns, mm LPS
  std::vector<ColumnEnd> ends;  ///< per column
  std::vector<bool>
      vestibule;  ///< lips and cheeks before the teeth: wet mucosa that slides on the bone it met
  std::vector<bool> attached;  ///< the inner end moves with the bone it met; others are free: those that met
                               ///< none, and the vestibule
  std::vector<bool> fixed;     ///< the whole column is held: rim of the region towards tissue that stays
  std::vector<double> rim_distance_mm;  ///< per column, to the nearest column that is held
  std::vector<double> thickness_mm;     ///< per column, skin to bone
  std::vector<double> layer_fractions;  ///< mean share of each layer, outermost first
  Vec3 upper_centre, lower_centre;
  double lip_level_mm = 0;
  std::optional<LipSlit> slit;  ///< where the lips were parted
  std::vector<int> lip_side;    ///< per column: +1 upper, -1 lower rim of the slit, else 0

  // Counts for the report.
  int skin_points_above_bone = 0;  ///< left out: above the highest bone
  int rays_missed = 0;             ///< filled in the second pass
  int prisms_repaired = 0;
  double mean_hit_thickness_mm = 0;  ///< of the first pass, the depth given in the second

  [[nodiscard]] int columns() const { return static_cast<int>(surface.points.size()); }
  [[nodiscard]] int prisms() const { return static_cast<int>(surface.triangles.size()) * (sheets - 1); }
  [[nodiscard]] int point(int sheet, int column) const { return sheet * columns() + column; }
  [[nodiscard]] int inner_end(int column) const { return point(sheets - 1, column); }
};

/// Six times the smallest volume (mm³) among the tetrahedra at the corners of a prism and those of its
/// splits; positive where the prism is not inverted anywhere. Triangle (a, b, c) outer, (d, e, f) inner,
/// anticlockwise from outside.
double smallest_prism_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e,
                             const Vec3& f);
/// Number of prisms with such a volume ≤ 0 at the given positions (sheets * columns points).
int count_inverted(const LayeredTissue& tissue, const std::vector<Vec3>& points);

/// Both passes, layers, repair. Errors: no skin below the bone level, no ray meets bone.
Result<LayeredTissue> build_tissue(const Head& head, const Landmarks& landmarks, const TissueOptions& options,
                                   Context& context);

}  // namespace turgor
