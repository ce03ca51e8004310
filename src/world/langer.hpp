// How what skin is along Langer's lines passes into what it is across them. Internal to the module.
#pragma once

namespace turgor {

/// By the square of the cosine of the angle to the lines.
inline double at_angle(double along, double across, double squared_cosine) {
  return across + (along - across) * squared_cosine;
}

}  // namespace turgor
