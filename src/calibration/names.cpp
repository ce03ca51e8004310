#include "turgor/calibration/calibrate.hpp"

namespace turgor {

std::string_view name_of(ErrorMeasure measure) {
  switch (measure) {
    case ErrorMeasure::distance:
      return "distance";
    case ErrorMeasure::shape:
      return "shape";
    case ErrorMeasure::force:
      break;
  }
  return "force";
}

std::string_view name_of(FitMethod method) {
  switch (method) {
    case FitMethod::gauss_newton:
      return "gauss_newton";
    case FitMethod::gradient:
      return "gradient";
    case FitMethod::cma_es:
      return "cma_es";
    case FitMethod::annealing:
      break;
  }
  return "annealing";
}

}  // namespace turgor
