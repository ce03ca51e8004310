#include "world/tissue_solve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/index.hpp"
#include "world/solve_round.hpp"

namespace turgor {
namespace {

constexpr double kUsableResidual = 1e-2;

// Adds places of inner ends to a motion, whose points stay sorted.
void prescribe(const std::vector<std::pair<int, Vec3>>& ends, PrescribedMotion& motion) {
  std::vector<std::pair<int, Vec3>> all = ends;
  for (std::size_t i = 0; i < motion.moved.size(); ++i)
    all.emplace_back(motion.moved[i], motion.positions[i]);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  motion.moved.clear(), motion.positions.clear();
  for (const auto& [point, place] : all) motion.moved.push_back(point), motion.positions.push_back(place);
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

}  // namespace

// The chain knows no sliding: mucosa follows the bone that it lies on, as in the paper. Nor does it know
// contact: ends that it leaves in bone are prescribed to lie upon it, and the chain is solved again.
Result<void> solve_chain(const PatientCase& patient, const ChainParameters& parameters,
                         const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction) {
  const LayeredTissue& layers = patient.tissue();
  const auto start = Clock::now();
  TURGOR_TRY(const SpringNetwork network, make_chain_network(layers));
  const ChainSolver chain(network);
  PrescribedMotion motion = tissue.motion;
  prescribe(tissue.mucosa, motion);
  prediction.setup_seconds = seconds_since(start);
  auto begin = Clock::now();
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
    begin = Clock::now();
    TURGOR_TRY(prediction.tissue_points, chain.solve(motion, parameters));
    prediction.solve_seconds += seconds_since(begin);
  }
  prediction.springs = static_cast<int>(network.springs.size());
  return {};
}

// The first planes are those at the places on moved bone that inner ends lay on or that have entered their
// columns.
std::vector<Vec3> first_places(const PatientCase& patient, const TissueMotion& tissue,
                               const BoneContact& bone) {
  std::vector<Vec3> points = patient.tissue().points;
  for (const int c : tissue.free_columns) {
    Vec3& end = points[at(patient.tissue().inner_end(c))];
    const int segment = patient.segment_of_column(c);
    end = segment >= 0 ? patient.bones().segments()[at(segment)].motion.point(end)
                       : bone.pushed(c).value_or(end);
  }
  return points;
}

Result<EquilibriumResult> settle_network(const PatientCase& patient, const EquilibriumOptions& options,
                                         const TissueMotion& tissue, const BoneContact& bone,
                                         SpringNetwork& network, const std::vector<Vec3>* start,
                                         double* deepest_mm, Context& context) {
  constexpr int max_rounds = 6;
  constexpr double bearable_mm = 0.3, rough_residual = 1e-2;
  bool settled = false;
  const LayeredTissue& layers = patient.tissue();
  std::vector<Vec3> points = start != nullptr ? *start : first_places(patient, tissue, bone);
  EquilibriumResult result;
  for (int round = 0; round < max_rounds; ++round) {
    network.contacts = contacts_of(tissue, bone, layers, points);
    const int steps = result.newton_steps, iterations = result.linear_iterations;
    EquilibriumOptions now = options;
    if (round + 1 < max_rounds && !settled)
      now.relative_residual = std::max(options.relative_residual, rough_residual);
    const bool known = round > 0 || start != nullptr;
    TURGOR_TRY(result, solve_equilibrium(network, tissue.motion, now, context, known ? &points : nullptr));
    result.newton_steps += steps, result.linear_iterations += iterations;
    TURGOR_CHECK(check_usable(Solver::network, result, kUsableResidual));
    points = result.positions;
    const std::vector<double> depths = depths_in_bone(tissue, bone, layers, points);
    if (!depths.empty() && deepest_mm != nullptr) *deepest_mm = depths.back();
    if (settled) break;
    settled = depths.empty() || depths[depths.size() * 99 / 100] < bearable_mm;
  }
  return result;
}

Result<void> solve_network(const PatientCase& patient, const SolverOptions& options,
                           const TissueMotion& tissue, const BoneContact& bone, Prediction& prediction,
                           Context& context) {
  const auto start = Clock::now();
  const LayeredTissue& layers = patient.tissue();
  TURGOR_TRY(SpringNetwork network, make_network(layers, patient.options().material));
  TURGOR_CHECK(scale_layers(layers, options.factors, network));
  prediction.setup_seconds = seconds_since(start);
  const auto begin = Clock::now();
  TURGOR_TRY(prediction.equilibrium, settle_network(patient, options.equilibrium, tissue, bone, network,
                                                    nullptr, &prediction.deepest_contact_mm, context));
  prediction.solve_seconds = seconds_since(begin);
  prediction.tissue_points = std::exchange(prediction.equilibrium.positions, {});
  prediction.springs = static_cast<int>(network.springs.size());
  prediction.volumes = static_cast<int>(network.volumes.size());
  return {};
}

}  // namespace turgor
