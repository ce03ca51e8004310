#include "turgor/world/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "turgor/geometry/embedding.hpp"
#include "turgor/geometry/surface_query.hpp"

namespace turgor {
namespace {

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool moves(const BoneSegment& segment) {
  const Box3 box = bounds(segment.surface);
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p{(corner & 1) ? box.upper.x : box.lower.x, (corner & 2) ? box.upper.y : box.lower.y,
                 (corner & 4) ? box.upper.z : box.lower.z};
    if (distance(segment.motion.point(p), p) > 1e-9) return true;
  }
  return false;
}

// Bone that comes forward pushes the free tissue before it (lips before teeth, the neck before the angle of
// the jaw): the inner end of a free column that the moved bone has entered is set upon the bone, along the
// column.
class BoneContact {
 public:
  explicit BoneContact(const PatientCase& patient) : tissue_(patient.tissue()) {
    std::vector<const TriMesh*> surfaces;
    for (const BoneSegment& s : patient.bones().segments()) {
      if (moves(s)) moved_.push_back(transformed(s.surface, s.motion));
    }
    for (const TriMesh& mesh : moved_) surfaces.push_back(&mesh);
    bone_.emplace(surfaces);
  }
  /// Where the inner end of a free column goes; nothing where no moved bone reaches it.
  [[nodiscard]] std::optional<Vec3> pushed(int column) const {
    constexpr double outside_mm = 25.0, slack_mm = 0.2;
    const Vec3& skin = tissue_.points[at(column)];
    const Vec3& end = tissue_.points[at(tissue_.point(tissue_.sheets - 1, column))];
    const double thickness = distance(skin, end);
    const Vec3 inwards = (end - skin) / thickness;
    // The line enters and leaves bone in turn. Bone that has passed the skin altogether is not in this
    // column.
    const auto hits = bone_->all_hits(skin - inwards * outside_mm, inwards, 0, outside_mm + thickness + 60.0);
    for (std::size_t i = 0; i + 1 < hits.size(); i += 2) {
      const double enters = hits[i].distance - outside_mm, leaves = hits[i + 1].distance - outside_mm;
      if (leaves <= 0) continue;
      if (enters >= thickness - slack_mm) return std::nullopt;
      return skin + inwards * enters;
    }
    return std::nullopt;
  }

 private:
  const LayeredTissue& tissue_;
  std::vector<TriMesh> moved_;
  std::optional<SurfaceQuery> bone_;
};

Error nothing_moves() {
  return {ErrorKind::bad_command, "no bone under the tissue moves, so the face stays as it is", "plan",
          "Add an operation that moves bone, such as: setback -amount 6"};
}

// The network that a solver works on, and its answer.
Result<void> solve(const PatientCase& patient, const SolverOptions& options, const PrescribedMotion& motion,
                   Prediction& prediction, Context& context) {
  auto start = std::chrono::steady_clock::now();
  if (prediction.solver == Solver::chain) {
    TURGOR_TRY(const SpringNetwork network, make_chain_network(patient.tissue()));
    const ChainSolver chain(network);
    prediction.setup_seconds = seconds_since(start);
    start = std::chrono::steady_clock::now();
    TURGOR_TRY(prediction.tissue_points, chain.solve(motion, options.chain));
    prediction.springs = static_cast<int>(network.springs.size());
  } else {
    TURGOR_TRY(const SpringNetwork network, make_network(patient.tissue(), patient.options().material));
    prediction.setup_seconds = seconds_since(start);
    start = std::chrono::steady_clock::now();
    TURGOR_TRY(prediction.equilibrium, solve_equilibrium(network, motion, options.equilibrium, context));
    // Short of the residual asked for the solver warns and the report states what was reached; beyond this it
    // is no answer.
    constexpr double usable_residual = 1e-2;
    if (!prediction.equilibrium.converged && !(prediction.equilibrium.relative_residual < usable_residual)) {
      return Error{ErrorKind::bad_input,
                   fmt::format("the tissue found no equilibrium (relative residual {:.1e} after {} steps)",
                               prediction.equilibrium.relative_residual, prediction.equilibrium.newton_steps),
                   "network", "Move the bones less, or lower Poisson's ratio (solver network -poisson 0.3)"};
    }
    prediction.tissue_points = std::move(prediction.equilibrium.positions);
    prediction.springs = static_cast<int>(network.springs.size());
    prediction.volumes = static_cast<int>(network.volumes.size());
  }
  prediction.solve_seconds = seconds_since(start);
  prediction.points = static_cast<int>(prediction.tissue_points.size());
  return {};
}

// Carries the movement of the tissue's skin to the points of the full skin and to landmarks.
class SkinCarrier {
 public:
  SkinCarrier(const PatientCase& patient, const std::vector<Vec3>& points, const std::vector<int>& lip_side) {
    const LayeredTissue& tissue = patient.tissue();
    TriMesh coarse = tissue.surface;
    std::vector<Vec3> fine = points;
    if (tissue.slit) {
      constexpr double gap_mm = 2.0;
      coarse.points = spread_lips(coarse.points, tissue.lip_side, *tissue.slit, gap_mm);
      fine = spread_lips(fine, lip_side, *tissue.slit, gap_mm);
    }
    constexpr double reach_mm = 5.0, fade_mm = 12.0;
    embedding_.emplace(coarse, fine, reach_mm, fade_mm);
  }
  [[nodiscard]] std::vector<Vec3> carry(const LayeredTissue& tissue,
                                        const std::vector<Vec3>& tissue_points) const {
    std::vector<Vec3> shift(at(tissue.columns()));
    for (std::size_t c = 0; c < shift.size(); ++c) shift[c] = tissue_points[c] - tissue.points[c];
    return embedding_->displacements(shift);
  }

 private:
  std::optional<SurfaceEmbedding> embedding_;
};

void move_skin(const PatientCase& patient, Prediction& prediction) {
  const SkinCarrier carrier(patient, patient.skin().points, patient.skin_lip_side());
  const std::vector<Vec3> shift = carrier.carry(patient.tissue(), prediction.tissue_points);
  prediction.skin = patient.skin();
  prediction.displacement_mm.resize(shift.size());
  for (std::size_t i = 0; i < shift.size(); ++i) {
    prediction.skin.points[i] += shift[i];
    prediction.displacement_mm[i] = static_cast<float>(length(shift[i]));
  }
}

void move_landmarks(const PatientCase& patient, Prediction& prediction) {
  std::vector<std::string> soft;
  std::vector<Vec3> places;
  for (const auto& [name, landmark] : patient.landmarks()) {
    const LandmarkKind* kind = find_landmark_kind(name);
    if (kind != nullptr && kind->on_bone) {
      const bool lower = name.starts_with("gonion") || name.starts_with("condylion") || name == "pogonion" ||
                         name == "menton" || name == "b_point" || name == "lower_incisor";
      const int s = patient.bones().segment_at(lower ? Bone::mandible : Bone::skull, landmark.point);
      const Vec3 after =
          s < 0 ? landmark.point : patient.bones().segments()[at(s)].motion.point(landmark.point);
      prediction.landmarks.push_back({name, landmark.point, after});
    } else {
      soft.push_back(name);
      places.push_back(landmark.point);
    }
  }
  const SkinCarrier carrier(patient, places, std::vector<int>(places.size(), 0));
  const std::vector<Vec3> shift = carrier.carry(patient.tissue(), prediction.tissue_points);
  for (std::size_t i = 0; i < soft.size(); ++i) {
    prediction.landmarks.push_back({soft[i], places[i], places[i] + shift[i]});
  }
  std::sort(prediction.landmarks.begin(), prediction.landmarks.end(),
            [](const LandmarkShift& a, const LandmarkShift& b) { return a.name < b.name; });
}

void measure_ratios(Prediction& prediction) {
  const auto find = [&](std::string_view name) -> const LandmarkShift* {
    for (const LandmarkShift& l : prediction.landmarks) {
      if (l.name == name) return &l;
    }
    return nullptr;
  };
  for (const LandmarkShift& hard : prediction.landmarks) {
    const LandmarkKind* kind = find_landmark_kind(hard.name);
    if (kind == nullptr || !kind->on_bone || kind->twin.empty()) continue;
    const LandmarkShift* soft = find(kind->twin);
    const Vec3 step = hard.after - hard.before;
    if (soft == nullptr || length(step) < 0.5) continue;
    prediction.ratios.push_back(
        {soft->name, hard.name, dot(soft->after - soft->before, normalized(step)), length(step)});
  }
}

double stretch(const LayeredTissue& tissue, const std::vector<Vec3>& points, Vec3* where) {
  double greatest = 1;
  for (const Index3& t : tissue.surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t a = at(t[i]), b = at(t[(i + 1) % 3]);
      const double ratio = distance(points[a], points[b]) / distance(tissue.points[a], tissue.points[b]);
      if (ratio <= greatest) continue;
      greatest = ratio;
      *where = points[a];
    }
  }
  return greatest;
}

// Bone outside the predicted skin, or skin torn: the move is not one that a face survives.
Result<void> check_skin(const PatientCase& patient, Prediction& prediction, Context& context) {
  // Skin that nothing pushes (the neck before an opening jaw) may be passed by a little: that is told, not
  // refused.
  constexpr double bearable_stretch = 3.0, bearable_mm = 8.0, tolerance_mm = 0.5, reach_mm = 30.0;
  const std::string remedy = "Move the bones less, or check the direction of the move";
  Vec3 torn{};
  prediction.largest_stretch = stretch(patient.tissue(), prediction.tissue_points, &torn);
  const SurfaceQuery skin(prediction.skin);
  const std::vector<Vec3> normals = point_normals(prediction.skin);
  const double scan_end = patient.head().scan_box.lower.z + 4;
  for (const BoneSegment& segment : patient.bones().segments()) {
    if (!moves(segment)) continue;
    double farthest = 0;
    Vec3 place{};
    for (const Vec3& rest : segment.surface.points) {
      const Vec3 p = segment.motion.point(rest);
      const auto near = skin.nearest(p, reach_mm);
      if (!near || near->point.z < scan_end) continue;
      const Index3& t = prediction.skin.triangles[at(near->triangle)];
      const Vec3 n = normalized(normals[at(t[0])] * (1 - near->u - near->v) + normals[at(t[1])] * near->u +
                                normals[at(t[2])] * near->v);
      // Beyond an edge of the skin (mouth, end of the scan) or beside a fold of it the side alone says
      // nothing.
      const double out = dot(p - near->point, n);
      if (out < 0.7 * near->distance || out <= std::max(farthest, tolerance_mm) || skin.inside(p)) continue;
      farthest = out;
      place = p;
    }
    if (farthest > tolerance_mm && farthest <= bearable_mm) {
      context.warning(fmt::format(
          "'{}' comes {:.1f} mm through the predicted skin at ({:.0f}, {:.0f}, {:.0f}): the tissue "
          "there is not attached to it, and the prediction not to be trusted",
          segment.name, farthest, place.x, place.y, place.z));
    }
    if (farthest > bearable_mm || prediction.largest_stretch > bearable_stretch) {
      const Vec3 where = farthest > bearable_mm ? place : torn;
      const std::string what =
          farthest > bearable_mm
              ? fmt::format("the move of '{}' drives bone {:.1f} mm through the skin", segment.name, farthest)
              : fmt::format("the move of '{}' stretches the skin to {:.1f} times its length", segment.name,
                            prediction.largest_stretch);
      return Error{ErrorKind::bad_command,
                   fmt::format("{} at ({:.0f}, {:.0f}, {:.0f})", what, where.x, where.y, where.z), "plan",
                   remedy};
    }
  }
  return {};
}

}  // namespace

std::string_view name_of(Solver solver) {
  return solver == Solver::chain ? "chain" : "network";
}

Result<PrescribedMotion> prescribed_motion(const PatientCase& patient) {
  const LayeredTissue& tissue = patient.tissue();
  const auto& segments = patient.bones().segments();
  if (std::none_of(segments.begin(), segments.end(), moves)) return nothing_moves();
  const BoneContact contact(patient);
  std::vector<bool> fixed(tissue.points.size(), false);
  std::vector<std::optional<Vec3>> ends(at(tissue.columns()));
  const int innermost = tissue.sheets - 1;
  constexpr double slides_within_mm = 20.0;
  bool any = false;
  for (int c = 0; c < tissue.columns(); ++c) {
    const int segment = tissue.attached[at(c)] ? patient.segment_of_column(c) : -1;
    const Vec3& end = tissue.points[at(tissue.point(innermost, c))];
    if (tissue.fixed[at(c)]) {
      for (int s = 0; s < tissue.sheets; ++s) fixed[at(tissue.point(s, c))] = true;
    } else if (segment < 0) {
      ends[at(c)] = contact.pushed(c);
    } else if (moves(segments[at(segment)])) {
      // Next to tissue that is held, tissue slides over moving bone rather than tear away from its
      // surroundings.
      if (tissue.rim_distance_mm[at(c)] < slides_within_mm) continue;
      ends[at(c)] = segments[at(segment)].motion.point(end);
      any = true;
    } else {
      fixed[at(tissue.point(innermost, c))] = true;
    }
  }
  if (!any) return nothing_moves();
  PrescribedMotion motion;
  for (int p = 0; p < static_cast<int>(fixed.size()); ++p) {
    const int column = p - innermost * tissue.columns();
    if (fixed[at(p)]) motion.fixed.push_back(p);
    if (column < 0 || !ends[at(column)]) continue;
    motion.moved.push_back(p);
    motion.positions.push_back(*ends[at(column)]);
  }
  return motion;
}

Result<Prediction> predict(const PatientCase& patient, Solver solver, const SolverOptions& options,
                           Context& context) {
  const Stage stage(context, "predict " + std::string(name_of(solver)));
  TURGOR_TRY(const PrescribedMotion motion, prescribed_motion(patient));
  Prediction prediction;
  prediction.solver = solver;
  TURGOR_CHECK(solve(patient, options, motion, prediction, context));
  prediction.inverted_prisms = count_inverted(patient.tissue(), prediction.tissue_points);
  move_skin(patient, prediction);
  move_landmarks(patient, prediction);
  measure_ratios(prediction);
  TURGOR_CHECK(check_skin(patient, prediction, context));
  return prediction;
}

SkinDistance compare(const Prediction& a, const Prediction& b, double below_z) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < a.skin.points.size(); ++i) {
    const bool still = a.displacement_mm[i] < 0.1f && b.displacement_mm[i] < 0.1f;
    if (still || a.skin.points[i].z > below_z) continue;
    distances.push_back(distance(a.skin.points[i], b.skin.points[i]));
  }
  SkinDistance out;
  if (distances.empty()) return out;
  std::sort(distances.begin(), distances.end());
  for (const double d : distances) out.mean += d / static_cast<double>(distances.size());
  out.percentile_95 = distances[static_cast<std::size_t>(0.95 * static_cast<double>(distances.size() - 1))];
  out.greatest = distances.back();
  out.points = static_cast<int>(distances.size());
  return out;
}

}  // namespace turgor
