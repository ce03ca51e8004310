// How well the parameters of a fit are known.
#pragma once

#include "calibration/fit_point.hpp"

namespace turgor {

/// Standard deviation of each parameter's logarithm (or parameter, where not logarithmic) with the residual
/// as independent noise of equal size: σ² (JᵀJ)⁻¹, σ² = residual's squares / (measured − parameters).
/// Infinite: the loads tell nothing of it. Empty: no derivatives, or no more measured than parameters. Of the
/// fitted loads among those of `point`. Errors: cancelled.
Result<std::vector<double>> deviation_at(const Search& search, const FitPoint& point);

}  // namespace turgor
