// Energies of point samples in motion.
#include <array>

#include "tissue/area_element.hpp"
#include "tissue/spring_law.hpp"
#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"
#include "turgor/dynamics/time_stepper.hpp"

namespace turgor {
namespace {

constexpr std::size_t kGrain = 2048;

template <std::size_t n, class Size>
double energy_of(std::span<const std::array<int, n>> elements, std::span<const double> constants,
                 std::span<const Vec3> rest, std::span<const Vec3> x, Size&& size) {
  return parallel_sum(elements.size(), kGrain, [&](std::size_t i) {
    const double at_rest = size(rest, elements[i]), strain = (size(x, elements[i]) - at_rest) / at_rest;
    return 0.5 * constants[i] * strain * strain;
  });
}

double solid_energy(const Solid& s, std::span<const Vec3> rest, std::span<const Vec3> x) {
  using Points = std::span<const Vec3>;
  return energy_of(std::span(s.edges), s.edge_nmm, rest, x,
                   [](Points y, const auto& p) { return distance(y[at(p[0])], y[at(p[1])]); }) +
         energy_of(
             std::span(s.triangles), s.triangle_nmm, rest, x,
             [](Points y, const auto& p) { return shape_of(y[at(p[0])], y[at(p[1])], y[at(p[2])]).area; }) +
         energy_of(std::span(s.tetrahedra), s.tetrahedron_nmm, rest, x, [](Points y, const auto& p) {
           return signed_volume(y[at(p[0])], y[at(p[1])], y[at(p[2])], y[at(p[3])]);
         });
}

}  // namespace

double TimeStepper::spring_energy(std::size_t i, std::span<const Vec3> x) const {
  const Spring& s = model_.network.springs[i];
  const double share = acting_share(s), length = distance(x[at(s.a)], x[at(s.b)]);
  if (share == 0) return 0;
  if (!model_.springs.empty() && model_.springs[i].cutoff_mm > 0 && length > model_.springs[i].cutoff_mm)
    return 0;
  return share * s.stiffness_n *
         with_law(s.law, [&]<SpringLaw law>() { return law_energy<law>(length, s.rest_length_mm); });
}

double TimeStepper::potential(std::span<const Vec3> x) const {
  const auto& net = model_.network;
  const double springs =
      parallel_sum(net.springs.size(), kGrain, [&](std::size_t i) { return spring_energy(i, x); });
  const double volumes = parallel_sum(net.volumes.size(), kGrain, [&](std::size_t i) {
    const VolumeElement& v = net.volumes[i];
    return respond(v, signed_volume(x[at(v.p[0])], x[at(v.p[1])], x[at(v.p[2])], x[at(v.p[3])])).energy;
  });
  const double areas = parallel_sum(net.areas.size(), kGrain, [&](std::size_t i) {
    const AreaElement& a = net.areas[i];
    return respond(a, shape_of(x[at(a.p[0])], x[at(a.p[1])], x[at(a.p[2])]).area).energy;
  });
  double solids = 0;
  for (const Solid& solid : net.solids) solids += solid_energy(solid, net.rest, x);
  return springs + volumes + areas + solids + applied_energy(x) +
         parallel_sum(x.size(), kGrain, [&](std::size_t i) {
           if (!is_mobile(static_cast<int>(i))) return 0.0;
           double own = -net.mass_g[i] * dot(model_.gravity_mm_ms2, x[i]);
           barriers_of_.visit(static_cast<int>(i),
                              [&](int b) { own += respond(model_.barriers[at(b)], x[i]).energy; });
           return own;
         });
}

double TimeStepper::kinetic(std::span<const Vec3> v) const {
  return parallel_sum(v.size(), kGrain,
                      [&](std::size_t i) { return 0.5 * model_.network.mass_g[i] * squared_length(v[i]); });
}

}  // namespace turgor
