#include "turgor/world/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "turgor/geometry/embedding.hpp"
#include "turgor/geometry/surface_query.hpp"
#include "world/bone_contact.hpp"
#include "world/tissue_motion.hpp"

namespace turgor {
namespace {

constexpr std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Adds places of inner ends to a motion, whose points stay sorted.
void prescribe(const std::vector<std::pair<int, Vec3>>& ends, PrescribedMotion& motion) {
  std::vector<std::pair<int, Vec3>> all = ends;
  for (std::size_t i = 0; i < motion.moved.size(); ++i)
    all.emplace_back(motion.moved[i], motion.positions[i]);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  motion.moved.clear(), motion.positions.clear();
  for (const auto& [point, place] : all) motion.moved.push_back(point), motion.positions.push_back(place);
}

// The chain knows no sliding: mucosa follows the bone that it lies on, as in the paper. Nor does it know
// contact: ends that it leaves in bone are prescribed to lie upon it, and the chain is solved again.
Result<void> solve_chain(const PatientCase& patient, const ChainParameters& parameters,
                         const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction) {
  const LayeredTissue& layers = patient.tissue();
  const auto start = std::chrono::steady_clock::now();
  TURGOR_TRY(const SpringNetwork network, make_chain_network(layers));
  const ChainSolver chain(network);
  PrescribedMotion motion = tissue.motion;
  prescribe(tissue.mucosa, motion);
  prediction.setup_seconds = seconds_since(start);
  auto begin = std::chrono::steady_clock::now();
  TURGOR_TRY(prediction.tissue_points, chain.solve(motion, parameters));
  prediction.solve_seconds = seconds_since(begin);

  std::vector<std::pair<int, Vec3>> lifted;
  for (const int c : tissue.free_columns) {
    constexpr double bearable_mm = 0.2;
    const int p = layers.inner_end(c);
    const Vec3& end = prediction.tissue_points[at(p)];
    const bool prescribed = std::binary_search(motion.moved.begin(), motion.moved.end(), p);
    if (prescribed || bone.depth(c, end) < bearable_mm) continue;
    if (const auto plane = bone.plane(c, end)) {
      lifted.emplace_back(p, end + plane->normal * (plane->offset_mm - dot(plane->normal, end)));
    }
  }
  if (!lifted.empty()) {
    prescribe(lifted, motion);
    begin = std::chrono::steady_clock::now();
    TURGOR_TRY(prediction.tissue_points, chain.solve(motion, parameters));
    prediction.solve_seconds += seconds_since(begin);
  }
  prediction.springs = static_cast<int>(network.springs.size());
  return {};
}

std::vector<Contact> contacts_of(const TissueMotion& tissue, const BoneContact& bone,
                                 const LayeredTissue& layers, const std::vector<Vec3>& points) {
  std::vector<Contact> out;
  for (const int c : tissue.free_columns) {
    if (const auto plane = bone.plane(c, points[at(layers.inner_end(c))])) out.push_back(*plane);
  }
  return out;
}

// Free inner ends by how deep they lie in bone, mm, the deepest last.
std::vector<double> depths_in_bone(const TissueMotion& tissue, const BoneContact& bone,
                                   const LayeredTissue& layers, const std::vector<Vec3>& points) {
  std::vector<double> depths;
  for (const int c : tissue.free_columns) depths.push_back(bone.depth(c, points[at(layers.inner_end(c))]));
  std::sort(depths.begin(), depths.end());
  return depths;
}

// Short of the residual asked for the solver warns and the report states what was reached; beyond this it is
// no answer.
Result<void> check_usable(const EquilibriumResult& equilibrium) {
  constexpr double usable_residual = 1e-2;
  if (equilibrium.converged || equilibrium.relative_residual < usable_residual) return {};
  return Error{ErrorKind::bad_input,
               fmt::format("the tissue found no equilibrium (relative residual {:.1e} after {} steps)",
                           equilibrium.relative_residual, equilibrium.newton_steps),
               "network", "Move the bones less, or lower Poisson's ratio (solver network -poisson 0.3)"};
}

// The planes of the bone are those at the places where the last round left the tissue, until it no longer
// enters bone.
Result<void> solve_network(const PatientCase& patient, const EquilibriumOptions& options,
                           const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction,
                           Context& context) {
  constexpr int max_rounds = 6;
  constexpr double bearable_mm = 0.3, rough_residual = 1e-2;
  bool settled = false;
  const auto start = std::chrono::steady_clock::now();
  const LayeredTissue& layers = patient.tissue();
  TURGOR_TRY(SpringNetwork network, make_network(layers, patient.options().material));
  prediction.setup_seconds = seconds_since(start);
  const auto begin = std::chrono::steady_clock::now();
  // The first planes are those at the places on moved bone that inner ends lay on or that have entered their
  // columns.
  std::vector<Vec3> points = layers.points;
  for (const int c : tissue.free_columns) {
    Vec3& end = points[at(layers.inner_end(c))];
    const int segment = patient.segment_of_column(c);
    end = segment >= 0 ? patient.bones().segments()[at(segment)].motion.point(end)
                       : bone.pushed(c).value_or(end);
  }
  EquilibriumResult& result = prediction.equilibrium;
  for (int round = 0; round < max_rounds; ++round) {
    network.contacts = contacts_of(tissue, bone, layers, points);
    const int steps = result.newton_steps, iterations = result.linear_iterations;
    EquilibriumOptions now = options;
    if (round + 1 < max_rounds && !settled)
      now.relative_residual = std::max(options.relative_residual, rough_residual);
    TURGOR_TRY(result,
               solve_equilibrium(network, tissue.motion, now, context, round > 0 ? &points : nullptr));
    result.newton_steps += steps, result.linear_iterations += iterations;
    TURGOR_CHECK(check_usable(result));
    points = std::move(result.positions);
    const std::vector<double> depths = depths_in_bone(tissue, bone, layers, points);
    if (!depths.empty()) prediction.deepest_contact_mm = depths.back();
    if (settled) break;
    settled = depths.empty() || depths[depths.size() * 99 / 100] < bearable_mm;
  }
  prediction.solve_seconds = seconds_since(begin);
  prediction.tissue_points = std::move(points);
  prediction.springs = static_cast<int>(network.springs.size());
  prediction.volumes = static_cast<int>(network.volumes.size());
  return {};
}

// Carries the movement of the tissue's skin to the points of the full skin and to landmarks.
class SkinCarrier {
 public:
  SkinCarrier(const PatientCase& patient, const std::vector<Vec3>& points, const std::vector<int>& lip_side) {
    const LayeredTissue& tissue = patient.tissue();
    for (const Vec3& p : points) inside_.push_back(tissue.region.contains(p));
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
    std::vector<Vec3> carried = embedding_->displacements(shift);
    // What lies near the region but beyond its rim, such as the lobe of an ear, stays.
    for (std::size_t i = 0; i < carried.size(); ++i) {
      if (!inside_[i]) carried[i] = {};
    }
    return carried;
  }

 private:
  std::vector<bool> inside_;
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

Result<Prediction> predict(const PatientCase& patient, Solver solver, const SolverOptions& options,
                           Context& context) {
  const Stage stage(context, "predict " + std::string(name_of(solver)));
  TURGOR_TRY(const TissueMotion motion, tissue_motion(patient));
  const BoneContact bone(patient);
  Prediction prediction;
  prediction.solver = solver;
  if (solver == Solver::chain) {
    TURGOR_CHECK(solve_chain(patient, options.chain, motion, bone, prediction));
  } else {
    TURGOR_CHECK(solve_network(patient, options.equilibrium, motion, bone, prediction, context));
  }
  prediction.points = static_cast<int>(prediction.tissue_points.size());
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
