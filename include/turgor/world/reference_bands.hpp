// Published ratios of soft-tissue to bone movement, and how a prediction stands against them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/world/prediction.hpp"

namespace turgor {

/// Plausible share of the bone's movement that a soft-tissue landmark makes, for one operation.
struct ReferenceBand {
  std::string_view operation;  ///< "mandibular setback"
  std::string_view segment;    ///< the bone segment whose movement counts
  std::string_view soft;       ///< landmark
  std::string_view hard;       ///< landmark of the segment whose movement is the measure
  double low, high;
  std::string_view source;
};
const std::vector<ReferenceBand>& reference_bands();

struct BandResult {
  const ReferenceBand* band;
  double ratio;
  [[nodiscard]] bool inside() const { return ratio >= band->low && ratio <= band->high; }
};
/// The operation whose segment moves by more than half a millimetre, in one of the directions the bands are
/// known for; nothing for plans of several or other movements.
std::vector<BandResult> judge(const PatientCase& patient, const Prediction& prediction);

}  // namespace turgor
