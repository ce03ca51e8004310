// The phantom's surfaces as triangles, from its exact distances.
#include <algorithm>
#include <cmath>

#include "turgor/anatomy/phantom.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/imaging/isosurface.hpp"

namespace turgor {
namespace {

// A distance as a number of a CT: a hundredth of a millimetre each, far enough for the iso-surface.
constexpr double kPerMm = 100, kFarthestMm = 300;

std::int16_t encoded(double distance_mm) {
  return static_cast<std::int16_t>(std::lround(-kPerMm * std::clamp(distance_mm, -kFarthestMm, kFarthestMm)));
}

Grid grid_over(const Box3& box, double spacing_mm) {
  Grid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    const double extent = box.size()[static_cast<int>(a)];
    grid.size[a] = std::max(2, static_cast<int>(std::ceil(extent / spacing_mm)) + 1);
  }
  grid.spacing = {spacing_mm, spacing_mm, spacing_mm};
  grid.origin = box.lower;
  return grid;
}

}  // namespace

Result<TriMesh> Phantom::surface(PhantomSurface which, double spacing_mm, Context& context) const {
  if (!(spacing_mm >= 0.25 && spacing_mm <= 20)) {
    return Error{ErrorKind::bad_input, "the spacing of the phantom's surface is out of range", "",
                 "Give 0.25 to 20 mm"};
  }
  const auto distance = [&](const Vec3& p) {
    switch (which) {
      case PhantomSurface::skin:
        return skin(p);
      case PhantomSurface::skull:
        return skull(p);
      case PhantomSurface::mandible:
        return mandible(p);
      case PhantomSurface::bone:
        break;
    }
    return std::min(skull(p), mandible(p));
  };
  CtVolume field;
  field.grid = grid_over(extent(), spacing_mm);
  field.voxels.resize(field.grid.voxel_count());
  const Index3 size = field.grid.size;
  parallel_for(static_cast<std::size_t>(size[2]), 1, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < size[1]; ++j) {
        for (int i = 0; i < size[0]; ++i) {
          const Vec3 p =
              field.grid.to_patient({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
          field.at(i, j, k) = encoded(distance(p));
        }
      }
    }
  });
  TURGOR_CHECK(context.check());
  return isosurface(field, 0, true);
}

}  // namespace turgor
