#include "world/tissue_motion.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/index.hpp"
#include "world/bone_contact.hpp"

namespace turgor {
namespace {

/// What holds a column.
struct Hold {
  enum class By : std::uint8_t { nothing, rim, bone } by = By::nothing;
  int segment = -1;  // of bone
  Vec3 inner;        // inner end, after the plan where bone holds it
};

std::vector<Hold> holds_of(const PatientCase& patient) {
  const LayeredTissue& tissue = patient.tissue();
  std::vector<Hold> holds(at(tissue.columns()));
  for (int c = 0; c < tissue.columns(); ++c) {
    Hold& hold = holds[at(c)];
    hold.inner = tissue.points[at(tissue.point(tissue.sheets - 1, c))];
    const int segment = tissue.attached[at(c)] ? patient.segment_of_column(c) : -1;
    if (tissue.fixed[at(c)]) {
      hold.by = Hold::By::rim;
    } else if (segment >= 0) {
      hold.by = Hold::By::bone;
      hold.segment = segment;
      hold.inner = patient.bones().segments()[at(segment)].motion.point(hold.inner);
    }
  }
  return holds;
}

// Columns on bone that parts from the bone beside it, in the operation or at a joint: near the gap their
// inner ends are not on periosteum that still holds. `reach` mm about the gap counts as near.
std::vector<bool> undermined(const PatientCase& patient, const std::vector<Hold>& holds, double reach) {
  constexpr double parted_mm = 0.5;
  const auto& segments = patient.bones().segments();
  const LayeredTissue& tissue = patient.tissue();
  std::vector<bool> out(holds.size(), false);
  for (std::size_t a = 0; a < holds.size(); ++a) {
    if (holds[a].by != Hold::By::bone) continue;
    const Vec3& here = tissue.points[at(tissue.point(tissue.sheets - 1, static_cast<int>(a)))];
    for (std::size_t b = a + 1; b < holds.size(); ++b) {
      if (holds[b].by != Hold::By::bone || holds[b].segment == holds[a].segment) continue;
      const Vec3& there = tissue.points[at(tissue.point(tissue.sheets - 1, static_cast<int>(b)))];
      if (squared_length(there - here) > reach * reach) continue;
      const Vec3 with_other = segments[at(holds[b].segment)].motion.point(here);
      if (distance(with_other, holds[a].inner) < parted_mm) continue;
      out[a] = out[b] = true;
    }
  }
  return out;
}

Error nothing_moves() {
  return {ErrorKind::bad_command, "no bone under the tissue moves, so the face stays as it is", "plan",
          "Add an operation that moves bone, such as: setback -amount 6"};
}

}  // namespace

Result<TissueMotion> tissue_motion(const PatientCase& patient) {
  const LayeredTissue& tissue = patient.tissue();
  const auto& segments = patient.bones().segments();
  std::vector<bool> moving(segments.size());
  std::transform(segments.begin(), segments.end(), moving.begin(), moves);
  const std::vector<Hold> holds = holds_of(patient);
  const std::vector<bool> loose = undermined(patient, holds, patient.options().contact.undermining_mm);
  // Next to tissue that is held, tissue slides over moving bone rather than tear away from its surroundings.
  constexpr double slides_within_mm = 20.0;
  TissueMotion out;
  const auto lay_free = [&](int c) {
    out.free_columns.push_back(c);
    const int p = tissue.inner_end(c), segment = tissue.vestibule[at(c)] ? patient.segment_of_column(c) : -1;
    if (holds[at(c)].by != Hold::By::nothing || segment < 0 || !moving[at(segment)]) return;
    out.mucosa.emplace_back(p, segments[at(segment)].motion.point(tissue.points[at(p)]));
  };
  for (int p = 0; p < static_cast<int>(tissue.points.size()); ++p) {
    const int c = p % tissue.columns();
    const Hold& hold = holds[at(c)];
    const bool at_rim = hold.by == Hold::By::rim;
    if (!at_rim && p != tissue.inner_end(c)) continue;
    const bool on_moved = hold.by == Hold::By::bone && moving[at(hold.segment)];
    const bool slides = on_moved && tissue.rim_distance_mm[at(c)] < slides_within_mm;
    if (hold.by == Hold::By::nothing || loose[at(c)] || slides) {
      lay_free(c);
    } else if (on_moved) {
      out.motion.moved.push_back(p);
      out.motion.positions.push_back(hold.inner);
    } else {
      out.motion.fixed.push_back(p);
    }
  }
  if (out.motion.moved.empty()) return nothing_moves();
  return out;
}

}  // namespace turgor
