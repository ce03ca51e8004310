// What reports of a calibration share, whatever the body: parameters and search. Internal to render.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "render/json.hpp"
#include "turgor/calibration/calibrate.hpp"
#include "turgor/render/case_pictures.hpp"
#include "turgor/world/calibration_case.hpp"

namespace turgor::render_detail {

/// JSON has no infinity: null, for what did not come to rest.
Json finite(double v);
Json search_json(const FitOptions& options, const Fit& fit);
Json parameters_json(const std::vector<FitParameter>& parameters, const Fit& fit);
Json samples_json(const Fit& fit);
/// Notices and times.
Json notes_json(const Context& context);

/// k_d, k_a and k_v of the uncalibrated guess, the same for all elements.
std::array<double, 3> guess_mpa(const CalibrationCase& problem);
/// In per cent; empty where it cannot be told.
std::string part_text(double v, double of);
/// Those whose name begins with `prefix`, in a row.
std::string pictures_of(const std::vector<Picture>& pictures, std::string_view prefix);
std::string parameter_table(const std::vector<FitParameter>& parameters, const Fit& fit);
std::string search_section(const FitOptions& options, const Fit& fit, const std::vector<Picture>& pictures);

/// The search: error of each sample, and the best so far (Morris 2006, figure 8).
Result<Picture> trajectory(const Fit& fit, const FitOptions& options);

}  // namespace turgor::render_detail
