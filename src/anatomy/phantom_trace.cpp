#include "anatomy/phantom_pose.hpp"

namespace turgor::phantom {

std::optional<double> trace(const PosedParts& parts, PhantomSurface surface, const Vec3& origin,
                            const Vec3& direction, double max_mm) {
  const auto value = [&](double t) {
    const Vec3 p = origin + direction * t;
    switch (surface) {
      case PhantomSurface::skin:
        return parts.value(Part::skin, p);
      case PhantomSurface::skull:
        return parts.value(Part::skull, p);
      case PhantomSurface::mandible:
        return parts.value(Part::mandible, p);
      case PhantomSurface::bone:
        break;
    }
    return std::min(parts.value(Part::skull, p), parts.value(Part::mandible, p));
  };
  double slope = parts.lipschitz(Part::skin);
  if (surface != PhantomSurface::skin)
    slope = std::max(parts.lipschitz(Part::skull), parts.lipschitz(Part::mandible));
  constexpr double least_step = 0.02;  // mm: what is thinner may be passed
  double t = 0, v = value(0);
  const bool starts_inside = v < 0;
  while (t < max_mm) {
    const double before = t;
    t = std::min(t + std::max(std::abs(v) / slope, least_step), max_mm);
    v = value(t);
    if ((v < 0) == starts_inside) continue;
    double low = before, high = t;
    while (high - low > 1e-8) {
      const double middle = 0.5 * (low + high);
      ((value(middle) < 0) == starts_inside ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
  return std::nullopt;
}

Box3 scan_extent(const PhantomParameters& parameters) {
  const double size = parameters.size;
  Box3 box{Vec3{-84, -125 - std::max(parameters.jaw_protrusion_mm, 0.0) * 0.3, -160} * size,
           Vec3{84, 108, 136} * size};
  for (int a = 0; a < 2; ++a) box.lower[a] -= 8, box.upper[a] += 8;
  box.upper.z += 6;
  if (parameters.head_holder) {
    box.extend({-106, box.lower.y, box.lower.z});
    box.extend({106, 132, box.lower.z});
  }
  return box;
}

}  // namespace turgor::phantom
