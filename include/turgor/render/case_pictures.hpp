// The pictures of a case: before, after, superimposed, displacement, bones, landmarks, thickness.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "turgor/core/context.hpp"
#include "turgor/world/prediction.hpp"

namespace turgor {

struct Picture {
  std::string name;            ///< of the file, without extension: "before_front"
  std::string caption;         ///< one sentence
  std::vector<std::byte> png;  ///< the bytes of the file
};

struct PictureOptions {
  int width = 720, height = 800;
  int samples = 16;
};

/// Of one prediction: from front, both three-quarter views and profile the skin before and after, both
/// superimposed (Duysak and Zhang 2005, figure 9) and the displacement with its legend; bones before and
/// after.
Result<std::vector<Picture>> prediction_pictures(const PatientCase& patient, const Prediction& prediction,
                                                 const PictureOptions& options, Context& context);
/// Of the model: landmarks on skin and bone, thickness of the soft tissue, the mandible's cut where one was
/// made.
Result<std::vector<Picture>> model_pictures(const PatientCase& patient, const PictureOptions& options,
                                            Context& context);

}  // namespace turgor
