#include "turgor/world/prediction.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/index.hpp"
#include "turgor/geometry/embedding.hpp"
#include "world/bone_contact.hpp"
#include "world/face_solve.hpp"
#include "world/skin_check.hpp"
#include "world/tissue_motion.hpp"
#include "world/tissue_solve.hpp"

namespace turgor {
namespace {

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
                                        const std::vector<Vec3>& surface_points) const {
    std::vector<Vec3> shift(surface_points);
    for (std::size_t c = 0; c < shift.size(); ++c) shift[c] -= tissue.surface.points[c];
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
  const std::vector<Vec3> shift = carrier.carry(patient.tissue(), prediction.surface_points);
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
  const std::vector<Vec3> shift = carrier.carry(patient.tissue(), prediction.surface_points);
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

// The layered tissue, by the chain or the network.
Result<void> solve_layers(const PatientCase& patient, Solver solver, const SolverOptions& options,
                          Prediction& prediction, Context& context) {
  TURGOR_TRY(const TissueMotion motion, tissue_motion(patient));
  const BoneContact bone(patient);
  if (solver == Solver::chain) {
    TURGOR_CHECK(solve_chain(patient, options.chain, motion, bone, prediction));
  } else {
    TURGOR_CHECK(solve_network(patient, options, motion, bone, prediction, context));
  }
  const auto& points = prediction.tissue_points;
  prediction.points = static_cast<int>(points.size());
  prediction.surface_points.assign(points.begin(), points.begin() + patient.tissue().columns());
  prediction.inverted = count_inverted(patient.tissue(), points);
  return {};
}

}  // namespace

std::string_view name_of(Solver solver) {
  constexpr std::array<std::string_view, kSolvers.size()> names{"chain", "network", "solid", "fem"};
  return names[static_cast<std::size_t>(solver)];
}

Result<Prediction> predict(const PatientCase& patient, Solver solver, const SolverOptions& options,
                           Context& context) {
  const Stage stage(context, "predict " + std::string(name_of(solver)));
  Prediction prediction;
  prediction.solver = solver;
  if (solver == Solver::chain || solver == Solver::network) {
    TURGOR_CHECK(solve_layers(patient, solver, options, prediction, context));
  } else {
    TURGOR_CHECK(solve_cubes(patient, solver, options.cubes, options.equilibrium, prediction, context));
  }
  move_skin(patient, prediction);
  move_landmarks(patient, prediction);
  measure_ratios(prediction);
  TURGOR_CHECK(check_skin(patient, prediction, context));
  return prediction;
}

std::vector<std::pair<std::string, std::vector<bool>>> skin_parts(const PatientCase& patient) {
  return parts_of_face(patient, patient.skin().points);
}

std::vector<std::pair<std::string, std::vector<bool>>> parts_of_face(const PatientCase& patient,
                                                                     const std::vector<Vec3>& points) {
  const auto where = [&](auto&& inside) {
    std::vector<bool> out;
    out.reserve(points.size());
    for (const Vec3& p : points) out.push_back(patient.tissue().region.contains(p) && inside(p));
    return out;
  };
  std::vector<std::pair<std::string, std::vector<bool>>> parts;
  const auto nose = patient.landmarks().find("subnasale"), chin = patient.landmarks().find("soft_menton");
  if (nose != patient.landmarks().end()) {
    // To the neck, the length of which would flatter the means.
    constexpr double below_chin_mm = 5;
    const double top = nose->second.point.z;
    const double bottom = chin != patient.landmarks().end() ? chin->second.point.z - below_chin_mm : -1e30;
    parts.emplace_back(kLowerThird, where([&](const Vec3& p) { return p.z < top && p.z > bottom; }));
  }
  if (const auto& slit = patient.tissue().slit) {
    constexpr double lip_mm = 12;
    parts.emplace_back("lips", where([&](const Vec3& p) {
                         return slit->covers(p) && std::abs(slit->plane.signed_distance(p)) < lip_mm;
                       }));
  }
  return parts;
}

SkinDistance compare(const Prediction& a, const Prediction& b, const std::vector<bool>& within) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < a.skin.points.size(); ++i) {
    const bool still = a.displacement_mm[i] < 0.1f && b.displacement_mm[i] < 0.1f;
    if (still || (!within.empty() && !within[i])) continue;
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
