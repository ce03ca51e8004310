#include "turgor/world/solid_part.hpp"

#include <fmt/format.h>

#include <cmath>

#include "world/scene/bad_input.hpp"

namespace turgor {
namespace {

Result<void> check(const SolidMaterial& m) {
  const auto above_zero = [](double x) { return std::isfinite(x) && x > 0; };
  if (!above_zero(m.youngs_modulus_mpa) || !above_zero(m.density_g_mm3)) {
    return bad_input(
        fmt::format("Young's modulus is {} and the density {}", m.youngs_modulus_mpa, m.density_g_mm3),
        "Both must be finite numbers above 0");
  }
  if (!(m.poissons_ratio >= 0 && m.poissons_ratio < 0.5))
    return bad_input(fmt::format("Poisson's ratio is {}", m.poissons_ratio),
                     "Give at least 0 and less than 0.5");
  if (!(m.area_share >= 0 && m.area_share <= 1))
    return bad_input(fmt::format("the share of areas is {}", m.area_share), "Give 0 to 1");
  return {};
}

Result<void> bind_skin(SolidPart& part, std::span<const Vec3> positions, const TriMesh& skin) {
  if (part.options.binding == SkinBinding::frames) {
    SolidMesh now = part.mesh;
    now.points.assign(positions.begin(), positions.end());
    TURGOR_TRY(SolidSkin bound, SolidSkin::bind(now, skin, part.options.neighbours));
    part.frames = std::make_shared<const SolidSkin>(std::move(bound));
    return {};
  }
  TURGOR_TRY(TetraEmbedding bound, TetraEmbedding::bind(positions, part.mesh.tetrahedra, skin.points));
  part.barycentric = std::make_shared<const TetraEmbedding>(std::move(bound));
  return {};
}

}  // namespace

TriMesh SolidPart::shown(std::span<const Vec3> positions) const {
  TriMesh now{std::vector<Vec3>(skin.points.size()), skin.triangles};
  if (frames)
    frames->apply(positions, now.points, {});
  else
    barycentric->apply(positions, now.points);
  return now;
}

Result<void> refresh_elements(SolidPart& part) {
  if (!part.constants[2].empty())
    return set_constants(part.elements, part.mesh.points, part.constants, part.stiffness);
  const SolidStiffness whole = stiffness_of(part.options.material);
  std::vector<SolidStiffness> each;
  for (const double factor : part.stiffness)
    each.push_back({factor * whole.length, factor * whole.area, factor * whole.volume});
  return set_stiffness(part.elements, part.mesh.points, each);
}

Result<void> complete_solid_part(SolidPart& part, std::span<const Vec3> positions, const TriMesh& skin_now) {
  const auto points = part.mesh.points.size();
  TURGOR_TRY(part.elements, make_solid({part.mesh.tetrahedra.begin(), part.mesh.tetrahedra.end()},
                                       static_cast<int>(points), part.mesh.spacing));
  TURGOR_CHECK(refresh_elements(part));
  part.mass_g.assign(points, 0.0);
  add_mass(part.elements, part.mesh.points, part.options.material.density_g_mm3, part.mass_g);
  return bind_skin(part, positions, skin_now);
}

Result<SolidPart> make_solid_part(const TriMesh& surface, const SolidOptions& options,
                                  const Context& context) {
  TURGOR_CHECK(check(options.material));
  SolidPart part;
  part.options = options;
  TURGOR_TRY(const VoxelGrid voxels, voxelise(surface, options.voxels, context));
  TURGOR_TRY(part.mesh, solid_of(voxels));
  part.mobile.assign(part.mesh.points.size(), 1);
  part.stiffness.assign(part.mesh.tetrahedra.size(), 1.0);
  part.skin = surface;
  TURGOR_CHECK(complete_solid_part(part, part.mesh.points, surface));
  return part;
}

}  // namespace turgor
