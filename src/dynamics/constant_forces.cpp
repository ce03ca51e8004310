#include "dynamics/constant_forces.hpp"

#include "tissue/area_element.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

ElementForce force_of(const Spring& spring, std::span<const Vec3> x) {
  const Vec3 d = x[at(spring.b)] - x[at(spring.a)];
  const Vec3 pull = normalized(d) * respond(spring, length(d)).tension;
  return {2, {spring.a, spring.b}, {pull, -pull}};
}

ElementForce force_of(const AreaElement& area, std::span<const Vec3> x) {
  const TriangleShape shape = shape_of(x[at(area.p[0])], x[at(area.p[1])], x[at(area.p[2])]);
  const double stress = respond(area, shape.area).stress;
  ElementForce out{3, {area.p[0], area.p[1], area.p[2]}, {}};
  for (std::size_t c = 0; c < 3; ++c) out.force_n[c] = area_gradient(shape.normal, shape.edge[c]) * -stress;
  return out;
}

ElementForce force_of(const VolumeElement& volume, std::span<const Vec3> x) {
  const Vec3& origin = x[at(volume.p[0])];
  const Vec3 e1 = x[at(volume.p[1])] - origin;
  const std::array<Vec3, 4> g = volume_gradient(e1, x[at(volume.p[2])] - origin, x[at(volume.p[3])] - origin);
  const double stress = respond(volume, dot(e1, g[1])).mean_stress;
  ElementForce out{4, std::to_array(volume.p), {}};
  for (std::size_t c = 0; c < 4; ++c) out.force_n[c] = g[c] * -stress;
  return out;
}

// As NetworkEnergy lowers them.
void add_solid(const Solid& solid, const std::vector<Vec3>& rest, std::span<const Vec3> x,
               std::vector<ElementForce>& out) {
  for (std::size_t e = 0; e < solid.edges.size(); ++e) {
    const auto [a, b] = solid.edges[e];
    const double length = distance(rest[at(a)], rest[at(b)]);
    out.push_back(force_of(Spring{a, b, length, solid.edge_nmm[e] / length, SpringLaw::hookean}, x));
  }
  for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
    const auto [a, b, c] = solid.triangles[t];
    const double area = shape_of(rest[at(a)], rest[at(b)], rest[at(c)]).area;
    out.push_back(force_of(AreaElement{{a, b, c}, area, solid.triangle_nmm[t]}, x));
  }
  for (std::size_t t = 0; t < solid.tetrahedra.size(); ++t) {
    const auto [a, b, c, d] = solid.tetrahedra[t];
    const double volume = signed_volume(rest[at(a)], rest[at(b)], rest[at(c)], rest[at(d)]);
    out.push_back(force_of(VolumeElement{{a, b, c, d}, volume, solid.tetrahedron_nmm[t] / volume}, x));
  }
}

}  // namespace

std::vector<ElementForce> forces_of_constants(const SpringNetwork& network, std::span<const Vec3> positions) {
  std::vector<ElementForce> out;
  for (const Spring& spring : network.springs) out.push_back(force_of(spring, positions));
  for (const VolumeElement& volume : network.volumes) out.push_back(force_of(volume, positions));
  for (const AreaElement& area : network.areas) out.push_back(force_of(area, positions));
  for (const Solid& solid : network.solids) add_solid(solid, network.rest, positions, out);
  return out;
}

}  // namespace turgor
