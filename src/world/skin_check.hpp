// Whether a predicted face is one that tissue survives.
#pragma once

#include "turgor/core/context.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

/// Sets largest_stretch; warns where bone comes a little through the skin. Errors: bone far outside the skin,
/// skin torn (names the segment and the place).
Result<void> check_skin(const PatientCase& patient, Prediction& prediction, Context& context);

}  // namespace turgor
