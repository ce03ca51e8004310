// Tissue in layers built outward from a surface: `flesh_out` (Pieper 1989, sections 3.2.2 and 5.6), and the
// edits of it that section 6.2 asks for.
//
//   layer 2, skin  o───o───o    membrane: an edge of the source           ┐ in every layer
//                  │╲ ╱│╲ ╱│    plate: between the far ends of two        ┘
//   layer 1, SMAS  o───o───o      membranes that share a point
//                  │╲ ╱│╲ ╱│    vertical: at every point                  ┐ between two layers
//   layer 0, bone  o───o───o    diagonal: two for each spring in a layer  ┘
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "turgor/geometry/polyhedron.hpp"
#include "turgor/tissue/network.hpp"

namespace turgor {

/// What every point sample of a flesh carries. Springs, volumes and masses of the network follow from these,
/// so that any edit of them, or of the surface, leaves one consistent whole.
struct FleshSample {
  Vec3 rest;          ///< position at rest, mm
  double mass_g = 1;  ///< > 0
  bool mobile = true;
  double growth = 1;     ///< scale of the rest lengths of its springs (mean of both ends), > 0
  double stiffness = 1;  ///< scale of the stiffness of its springs (mean of both ends), ≥ 0
  double spacing = 1;    ///< of its neighbours over that of the source: 1, ½ where refined once, …
};

/// The recipe of a layered tissue. Point sample number = layer · columns() + column.
/// Invariant (see validate): a valid surface without loose lines, samples.size() = layers · columns, layers ≥
/// 1, at most 20 million samples, values in the ranges above.
struct Flesh {
  Polyhedron surface;  ///< polygons over columns; its points are the rest positions of layer 0
  int layers = 3;
  std::vector<FleshSample> samples;
  double stiffness_n = 1;  ///< material constant of every spring, force at strain 1
  SpringLaw law = SpringLaw::linear;
  double volume_modulus_mpa = 0;   ///< of the prisms between layers; 0: none
  double inversion_guard_mpa = 0;  ///< of the same; 0: none

  [[nodiscard]] int columns() const { return static_cast<int>(surface.points.size()); }
  [[nodiscard]] int sample(int layer, int column) const { return layer * columns() + column; }
};
Result<void> validate(const Flesh& flesh);

struct FleshOptions {
  /// Thickness of the tissue above each layer but the last, inwards to outwards (deep fascia, superficial
  /// fascia, …): one value for the whole, or one for each point of the source. > 0.
  std::vector<std::vector<double>> thickness = {{1}, {1}};
  double mass_g = 1;  ///< of each sample
  double stiffness_n = 1;
  SpringLaw law = SpringLaw::linear;
  double volume_modulus_mpa = 0, inversion_guard_mpa = 0;
  bool fix_bone = false;  ///< layer 0 does not move
};
/// Volume modulus as stiff against a change of volume as springs of this stiffness are against one of length:
/// twice it over the mean edge squared. 0 without edges of any length.
double default_volume_modulus(const Polyhedron& source, double stiffness_n);
/// Inversion guard over that modulus: no prism of the thesis's scripts turns over at half of it.
inline constexpr double kGuardShare = 10;

/// Layers along the vertex normals of `source`, which becomes layer 0; its loose lines are left out. Errors:
/// an invalid source or one without polygons, points that no polygon uses or without a normal, thicknesses of
/// the wrong number or sign, more than 20 million samples.
Result<Flesh> flesh_out(const Polyhedron& source, const FleshOptions& options);

/// One spring of the network, and where in the tissue it lies.
struct FleshNetwork {
  SpringNetwork network;  ///< rest positions, masses, springs, volumes
  /// Of each spring: its layer, or the lower one of the two that it joins.
  std::vector<int> layer_of_spring;
};
/// The network of a flesh. Each pair of samples has at most one spring (a membrane spring where it has two
/// reasons). Rest length: distance of the rest positions × mean growth; stiffness: stiffness_n × mean
/// stiffness × mean spacing (of vertical springs its square), so that a refined sheet is as stiff as the
/// coarse one in its plane and under pressure; diagonals stand steeper in it, and give less in the plane and
/// more across, the more the thicker the layers are. Volumes: a tetrahedron at every
/// corner of each prism between two layers, over the triangles and convex quadrilaterals of the surface
/// (other polygons in triangles), where modulus or guard is above 0; rest volume × the cube of the mean
/// growth. Errors: an invalid flesh, coincident samples, prisms with volume that are turned over, more than
/// 200 million springs.
Result<FleshNetwork> make_network(const Flesh& flesh);
/// Prisms between layers, and those of which a corner is flat or turned over at `positions` (of all samples).
int prism_count(const Flesh& flesh);
int inverted_prisms(const Flesh& flesh, const std::vector<Vec3>& positions);

/// How an edit renumbers samples: new number of each old sample, -1 where it is gone; and for each new sample
/// the old ones it lies between (one old sample twice where it is the same one), with which running states
/// (positions, velocities) carry over as means.
struct FleshMap {
  std::vector<int> new_of_old;
  std::vector<Edge> origin;
};

/// Removes columns and every polygon that uses one; columns that no polygon uses any more go too. Errors:
/// nothing would be left.
Result<FleshMap> remove_columns(Flesh& flesh, const std::vector<bool>& remove);
/// Cuts polygons out and leaves the columns of their rim; columns that no polygon uses any more go.
Result<FleshMap> remove_polygons(Flesh& flesh, const std::vector<bool>& remove);

/// When AdaptiveFlesh splits and merges. Errors of adapt(): merge_below above refine_above, levels out of
/// range.
struct RefinementOptions {
  double refine_above = 0.5;  ///< measure of a polygon from which on its triangle is split
  double merge_below = 0.25;  ///< measure under which the four parts of a triangle are joined again
  int most_levels = 1;        ///< 0 to 16
};
/// Largest strain of an edge of each polygon of `flesh`'s top layer at `positions` of all samples.
std::vector<double> polygon_strain(const Flesh& flesh, const std::vector<Vec3>& positions);

/// A flesh whose resolution follows the deformation (Pieper 1989, section 6.2.1): the triangles of a base,
/// each split in four where it is asked for, the parts in four again up to most_levels; triangles beside
/// finer ones in two or three (Bank, Sherman and Weiser, "Some refinement algorithms and data structures for
/// regular local mesh refinement", 1983), so that no edge hangs. New samples lie halfway between two others
/// and carry their mean (mobile where one of them is); masses are handed on, so that their sum stays; spacing
/// falls with the size of the polygons. What is in flesh() depends on base and splits alone, not on the way
/// to them: with all merged again it is the base, bit for bit. Samples of the base keep their columns.
class AdaptiveFlesh {
 public:
  /// Polygons of the base become triangles. An invalid base is reported by adapt().
  explicit AdaptiveFlesh(Flesh base);
  [[nodiscard]] const Flesh& flesh() const { return flesh_; }
  [[nodiscard]] const Flesh& base() const { return base_; }
  /// Takes what samples and material are from `base` (grown, stiffened, held …); splits and columns stay.
  /// Errors: an invalid flesh, other polygons or layers than those of base().
  Result<void> set_base(Flesh base);
  /// `measure`: one value for each polygon of flesh(), not NaN; the largest among the polygons of a triangle
  /// counts. Every triangle goes up or down by one level at most, and up also where neighbours would else
  /// differ by two. Returns the map from the flesh before to the one after; new_of_old is the identity where
  /// nothing changes. Errors leave all as it was.
  Result<FleshMap> adapt(const std::vector<double>& measure, const RefinementOptions& options);

 private:
  friend class RefinedSurface;
  // Triangle number of the base, followed by two bits a level: which of the four parts.
  struct Triangle {
    int level;
    std::uint64_t key;
    bool operator==(const Triangle&) const = default;
  };
  using Splits =
      std::vector<std::vector<std::uint64_t>>;  // of each level: the keys that are split, ascending
  // Vertices: the columns of the base, then a point in the middle of each edge that was ever split.
  struct Middles {
    int first = 0;
    std::vector<Edge> edges;
    std::unordered_map<std::uint64_t, int> vertex_in;
    int in(int a, int b);                        // made where there is none
    [[nodiscard]] int find(int a, int b) const;  // -1 where there is none
  };

  [[nodiscard]] Splits wanted_splits(const std::vector<double>& measure,
                                     const RefinementOptions& options) const;
  [[nodiscard]] FleshMap map_to(const std::vector<int>& new_vertices) const;

  Flesh base_, flesh_;
  Splits splits_;
  Middles middles_;
  std::vector<int> vertices_;        // of each column of flesh_
  std::vector<Triangle> triangles_;  // of each polygon of flesh_
};

}  // namespace turgor
