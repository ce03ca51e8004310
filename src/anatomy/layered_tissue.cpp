#include "turgor/anatomy/layered_tissue.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "tissue_region.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

// Area-weighted mean of the triangles that `accept` takes; nothing where there are none.
template <class Accept>
std::optional<Vec3> centroid(const TriMesh& mesh, Accept&& accept) {
  Vec3 sum{};
  double area = 0;
  for (const Index3& t : mesh.triangles) {
    const Vec3 c = (mesh.points[at(t[0])] + mesh.points[at(t[1])] + mesh.points[at(t[2])]) / 3.0;
    if (!accept(c)) continue;
    const double a = length(triangle_normal(mesh, t));
    sum += c * a;
    area += a;
  }
  if (area <= 0) return std::nullopt;
  return sum / area;
}

// The centre above the jaw: amid the bones of the midface, in the midsagittal plane.
Vec3 find_upper_centre(const Head& head, double lip_level) {
  const Box3 box = bounds(head.skull);
  const double top = std::min(lip_level + 75, box.upper.z), middle_y = box.centre().y;
  auto c =
      centroid(head.skull, [&](const Vec3& p) { return p.z > lip_level && p.z < top && p.y < middle_y; });
  const Vec3 centre = c.value_or(box.centre());
  return centre - head.midsagittal.normal * head.midsagittal.signed_distance(centre);
}

// The centre in the lower jaw: amid its body, or below the upper one where the scan shows no mandible.
Vec3 find_lower_centre(const Head& head, double lip_level, const Vec3& upper) {
  const auto c = centroid(head.mandible, [&](const Vec3& p) { return p.z < lip_level; });
  const Vec3 centre = c.value_or(Vec3{upper.x, upper.y, lip_level - 20});
  return centre - head.midsagittal.normal * head.midsagittal.signed_distance(centre);
}

// Directions and depths of the columns while they are being found.
struct Columns {
  std::vector<Vec3> direction;  // unit, inwards
  std::vector<double> depth;    // mm
};

// Where a column from `p` aims. Skin of the neck would aim almost along itself at the centre above: its rays
// rise by 45° at most, towards the axis below the centre.
Vec3 target_of(const Vec3& p, const Vec3& centre) {
  const double across = std::hypot(p.x - centre.x, p.y - centre.y);
  return {centre.x, centre.y, std::min(centre.z, p.z + across)};
}

Columns aim(const TissueRegion& region, const LayeredTissue& tissue) {
  Columns columns;
  const std::size_t n = region.surface.points.size();
  columns.direction.resize(n);
  columns.depth.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = region.surface.points[i];
    const bool upper = region.lip_side[i] != 0 ? region.lip_side[i] > 0 : p.z >= tissue.lip_level_mm;
    const Vec3 target = upper ? tissue.upper_centre : target_of(p, tissue.lower_centre);
    columns.direction[i] = normalized(target - p);
  }
  return columns;
}

// First pass: hits on bone, and their mean depth.
Result<void> first_pass(const SurfaceQuery& bone, const TissueOptions& options, LayeredTissue& tissue,
                        Columns& columns) {
  const std::size_t n = columns.depth.size();
  tissue.ends.assign(n, ColumnEnd::none);
  parallel_for(n, 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto found = bone.first_hit(tissue.surface.points[i], columns.direction[i],
                                        options.least_thickness_mm * 0.5, options.greatest_thickness_mm);
      if (!found) continue;
      columns.depth[i] = std::max(found->distance, options.least_thickness_mm);
      tissue.ends[i] = found->surface == 1 ? ColumnEnd::mandible : ColumnEnd::skull;
    }
  });
  const auto misses = std::count(tissue.ends.begin(), tissue.ends.end(), ColumnEnd::none);
  const auto hits = static_cast<std::ptrdiff_t>(n) - misses;
  if (hits == 0) {
    return Error{ErrorKind::bad_input, "no ray from the skin meets bone", "scan",
                 "Check the bone threshold and the two centres (commands bone_threshold and centre)"};
  }
  tissue.rays_missed = static_cast<int>(misses);
  tissue.mean_hit_thickness_mm =
      std::accumulate(columns.depth.begin(), columns.depth.end(), 0.0) / static_cast<double>(hits);
  return {};
}

// Second pass: rays that missed get the mean depth; their depths and directions are then evened out between
// their neighbours so that columns do not cross.
void second_pass(const LayeredTissue& tissue, const PointAdjacency& adjacency, Columns& columns) {
  const std::size_t n = columns.depth.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (tissue.ends[i] == ColumnEnd::none) columns.depth[i] = tissue.mean_hit_thickness_mm;
  }
  constexpr int rounds = 60;
  std::vector<double> next(n);
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < n; ++i) {
      next[i] = columns.depth[i];
      const int begin = adjacency.offsets[i], end = adjacency.offsets[i + 1];
      if (tissue.ends[i] != ColumnEnd::none || begin == end) continue;
      double sum = 0;
      for (int k = begin; k < end; ++k) sum += columns.depth[at(adjacency.neighbours[at(k)])];
      next[i] = 0.5 * columns.depth[i] + 0.5 * sum / (end - begin);
    }
    columns.depth.swap(next);
  }
}

// Repair turns and shortens columns: one that no longer ends near bone ends in soft tissue.
void forget_bone_left(const SurfaceQuery& bone, LayeredTissue& tissue, const Columns& columns) {
  constexpr double near_mm = 3.0;
  for (std::size_t i = 0; i < columns.depth.size(); ++i) {
    const Vec3 inner = tissue.surface.points[i] + columns.direction[i] * columns.depth[i];
    if (tissue.ends[i] != ColumnEnd::none && !bone.nearest(inner, near_mm)) tissue.ends[i] = ColumnEnd::none;
  }
}

// Columns are attached to the bone they met, except where lips and cheeks slide over the teeth (mucosa of the
// vestibule).
void attach(const Head& head, const TissueOptions& options, const Columns& columns, LayeredTissue& tissue) {
  std::optional<SurfaceQuery> teeth;
  if (!head.teeth.empty() && options.release_near_teeth_mm > 0) teeth.emplace(head.teeth);
  tissue.attached.assign(columns.depth.size(), false);
  tissue.vestibule.assign(columns.depth.size(), false);
  for (std::size_t i = 0; i < columns.depth.size(); ++i) {
    if (tissue.ends[i] == ColumnEnd::none) continue;
    const Vec3 inner = tissue.surface.points[i] + columns.direction[i] * columns.depth[i];
    tissue.vestibule[i] = teeth && teeth->nearest(inner, options.release_near_teeth_mm);
    tissue.attached[i] = !tissue.vestibule[i];
  }
}

// Depths of the sheets below the skin in a column of the given depth.
std::vector<double> sheet_depths(const TissueOptions& options, double depth) {
  const bool by_share = options.thickness_mm.empty();
  const std::vector<double>& layers = by_share ? options.fractions : options.thickness_mm;
  const double total = std::accumulate(layers.begin(), layers.end(), 0.0);
  // Where the tissue is thinner than its layers they thin in proportion; where it is thicker the innermost
  // takes the rest.
  const double scale = by_share ? depth / total : std::min(1.0, depth / total);
  std::vector<double> out(1, 0.0);
  for (const double layer : layers) out.push_back(out.back() + layer * scale);
  out.back() = depth;
  return out;
}

// Whether the prisms of triangle t are all well away from inversion.
bool sound(const TissueOptions& options, const LayeredTissue& tissue, const Columns& columns,
           const Index3& t) {
  const auto& p = tissue.surface.points;
  std::vector<double> depths[3];
  for (std::size_t i = 0; i < 3; ++i) depths[i] = sheet_depths(options, columns.depth[at(t[i])]);
  const auto place = [&](std::size_t i, std::size_t sheet) {
    return p[at(t[i])] + columns.direction[at(t[i])] * depths[i][sheet];
  };
  const double twice_area = length(triangle_normal(tissue.surface, t));
  for (std::size_t s = 0; s + 1 < depths[0].size(); ++s) {
    const double height = std::min(
        {depths[0][s + 1] - depths[0][s], depths[1][s + 1] - depths[1][s], depths[2][s + 1] - depths[2][s]});
    const double volume = smallest_prism_volume(place(0, s), place(1, s), place(2, s), place(0, s + 1),
                                                place(1, s + 1), place(2, s + 1));
    if (volume <= 0.02 * twice_area * height) return false;
  }
  return true;
}

// Triangles over prisms that are crossed.
std::vector<int> crossed_triangles(const TissueOptions& options, const LayeredTissue& tissue,
                                   const Columns& columns) {
  std::vector<int> out;
  for (int t = 0; t < static_cast<int>(tissue.surface.triangles.size()); ++t) {
    if (!sound(options, tissue, columns, tissue.surface.triangles[at(t)])) out.push_back(t);
  }
  return out;
}

// Depth of a column that met bone, along its present direction; as it was where that direction misses.
void cast_again(const SurfaceQuery& bone, const TissueOptions& options, const LayeredTissue& tissue, int c,
                Columns& columns) {
  if (tissue.ends[at(c)] == ColumnEnd::none) return;
  const auto hit = bone.first_hit(tissue.surface.points[at(c)], columns.direction[at(c)],
                                  options.least_thickness_mm * 0.5, options.greatest_thickness_mm);
  if (hit) columns.depth[at(c)] = std::max(hit->distance, options.least_thickness_mm);
}

// Gentle: evens out direction and depth between the columns of crossed prisms and their neighbours.
void even_out(const SurfaceQuery& bone, const TissueOptions& options, const LayeredTissue& tissue,
              const PointAdjacency& adjacency, const std::vector<int>& crossed, Columns& columns) {
  const auto neighbours = [&](int c) {
    return std::span(adjacency.neighbours)
        .subspan(at(adjacency.offsets[at(c)]), at(adjacency.offsets[at(c) + 1] - adjacency.offsets[at(c)]));
  };
  std::vector<bool> troubled(columns.depth.size(), false);
  for (const int t : crossed) {
    for (const int c : tissue.surface.triangles[at(t)]) {
      troubled[at(c)] = true;
      for (const int n : neighbours(c)) troubled[at(n)] = true;
    }
  }
  const Columns before = columns;
  for (int c = 0; c < tissue.columns(); ++c) {
    if (!troubled[at(c)]) continue;
    Vec3 direction{};
    double depth = 0;
    for (const int n : neighbours(c)) {
      direction += before.direction[at(n)];
      depth += before.depth[at(n)] / static_cast<double>(neighbours(c).size());
    }
    columns.direction[at(c)] = normalized(before.direction[at(c)] * 0.5 + normalized(direction) * 0.5);
    columns.depth[at(c)] = 0.7 * before.depth[at(c)] + 0.3 * depth;
    cast_again(bone, options, tissue, c, columns);
  }
}

// Firm: turns the columns of crossed prisms inwards, triangle by triangle, and shortens them. Short columns
// that run inwards from all their triangles are never crossed.
void turn_inwards(const LayeredTissue& tissue, const std::vector<int>& crossed, Columns& columns) {
  std::vector<bool> shortened(columns.depth.size(), false);
  for (const int t : crossed) {
    const Vec3 normal = normalized(triangle_normal(tissue.surface, tissue.surface.triangles[at(t)]));
    for (const int c : tissue.surface.triangles[at(t)]) {
      Vec3& direction = columns.direction[at(c)];
      if (dot(direction, normal) > -0.25) direction = normalized(direction - normal * 0.2);
      if (!shortened[at(c)]) columns.depth[at(c)] = std::max(0.95 * columns.depth[at(c)], 0.5);
      shortened[at(c)] = true;
    }
  }
}

// Returns the number of prisms that had to be repaired.
int repair(const SurfaceQuery& bone, const TissueOptions& options, const PointAdjacency& adjacency,
           const LayeredTissue& tissue, Columns& columns) {
  std::vector<bool> ever(tissue.surface.triangles.size(), false);
  constexpr int gentle_rounds = 20, rounds = 200;
  for (int round = 0; round < rounds; ++round) {
    const std::vector<int> crossed = crossed_triangles(options, tissue, columns);
    if (crossed.empty()) break;
    for (const int t : crossed) ever[at(t)] = true;
    if (round < gentle_rounds) {
      even_out(bone, options, tissue, adjacency, crossed, columns);
    } else {
      turn_inwards(tissue, crossed, columns);
    }
  }
  return (tissue.sheets - 1) * static_cast<int>(std::count(ever.begin(), ever.end(), true));
}

std::vector<double> distances_to_rim(const LayeredTissue& tissue) {
  const auto& points = tissue.surface.points;
  std::vector<Vec3> rim;
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (tissue.fixed[c]) rim.push_back(points[c]);
  }
  std::vector<double> out(points.size(), std::numeric_limits<double>::infinity());
  for (std::size_t c = 0; c < points.size(); ++c) {
    for (const Vec3& r : rim) out[c] = std::min(out[c], distance(points[c], r));
  }
  return out;
}

void lay_sheets(const TissueOptions& options, const Columns& columns, LayeredTissue& tissue) {
  const int n = tissue.columns();
  tissue.points.resize(at(n * tissue.sheets));
  tissue.thickness_mm = columns.depth;
  tissue.layer_fractions.assign(at(tissue.sheets - 1), 0.0);
  for (int c = 0; c < n; ++c) {
    const std::vector<double> depths = sheet_depths(options, columns.depth[at(c)]);
    for (int s = 0; s < tissue.sheets; ++s) {
      tissue.points[at(tissue.point(s, c))] =
          tissue.surface.points[at(c)] + columns.direction[at(c)] * depths[at(s)];
    }
    for (std::size_t s = 0; s + 1 < depths.size(); ++s) {
      tissue.layer_fractions[s] += (depths[s + 1] - depths[s]) / depths.back() / n;
    }
  }
}

Result<void> check_options(const TissueOptions& options) {
  const auto& layers = options.thickness_mm.empty() ? options.fractions : options.thickness_mm;
  const bool positive =
      std::all_of(layers.begin(), layers.end(), [](double v) { return std::isfinite(v) && v > 0; });
  if (layers.empty() || !positive) {
    return Error{ErrorKind::bad_command, "layer thicknesses and fractions must be positive", "layers",
                 "Give one positive number per layer, outermost first"};
  }
  return {};
}

}  // namespace

double smallest_prism_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, const Vec3& e,
                             const Vec3& f) {
  const auto six_volume = [](const Vec3& o, const Vec3& p, const Vec3& q, const Vec3& r) {
    return dot(p - o, cross(q - o, r - o));
  };
  return std::min({// one at each corner
                   six_volume(a, d, c, b), six_volume(b, e, a, c), six_volume(c, f, b, a),
                   six_volume(d, a, e, f), six_volume(e, b, f, d), six_volume(f, c, d, e),
                   // the middle tetrahedron of each of the six splits
                   six_volume(a, b, e, f), six_volume(a, c, e, f), six_volume(b, c, f, d),
                   six_volume(b, a, f, d), six_volume(c, a, d, e), six_volume(c, b, d, e)});
}

int count_inverted(const LayeredTissue& tissue, const std::vector<Vec3>& points) {
  int inverted = 0;
  for (const Index3& t : tissue.surface.triangles) {
    for (int s = 0; s + 1 < tissue.sheets; ++s) {
      const auto p = [&](int sheet, int i) -> const Vec3& {
        return points[at(tissue.point(sheet, t[at(i)]))];
      };
      if (smallest_prism_volume(p(s, 0), p(s, 1), p(s, 2), p(s + 1, 0), p(s + 1, 1), p(s + 1, 2)) <= 0)
        ++inverted;
    }
  }
  return inverted;
}

Result<LayeredTissue> build_tissue(const Head& head, const Landmarks& landmarks, const TissueOptions& options,
                                   Context& context) {
  const Stage stage(context, "tissue");
  TURGOR_CHECK(check_options(options));
  TURGOR_TRY(const TissueRegion region, find_tissue_region(head, landmarks, options, context));

  LayeredTissue tissue;
  tissue.region = region.limits;
  tissue.surface = region.surface;
  tissue.slit = region.slit;
  tissue.lip_side = region.lip_side;
  tissue.lip_level_mm = region.lip_level_mm;
  tissue.skin_points_above_bone = region.skin_points_above_bone;
  tissue.fixed = region.rim;
  tissue.upper_centre = options.upper_centre.value_or(find_upper_centre(head, tissue.lip_level_mm));
  tissue.lower_centre =
      options.lower_centre.value_or(find_lower_centre(head, tissue.lip_level_mm, tissue.upper_centre));

  tissue.sheets = static_cast<int>(sheet_depths(options, 1).size());
  const PointAdjacency adjacency = point_adjacency(tissue.surface);
  const SurfaceQuery bone({&head.skull, &head.mandible, &head.rami});
  Columns columns = aim(region, tissue);
  TURGOR_CHECK(first_pass(bone, options, tissue, columns));
  second_pass(tissue, adjacency, columns);
  tissue.prisms_repaired = repair(bone, options, adjacency, tissue, columns);
  forget_bone_left(bone, tissue, columns);
  attach(head, options, columns, tissue);
  lay_sheets(options, columns, tissue);
  tissue.rim_distance_mm = distances_to_rim(tissue);
  if (const int inverted = count_inverted(tissue, tissue.points); inverted > 0) {
    return Error{
        ErrorKind::internal, std::to_string(inverted) + " prisms of tissue stay inverted after repair",
        "tissue",
        "Correct the two centres with the command centre, or ask for fewer columns with tissue_points"};
  }
  return tissue;
}

}  // namespace turgor
