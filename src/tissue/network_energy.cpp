#include "turgor/tissue/network_energy.hpp"

#include <algorithm>
#include <array>
#include <functional>

#include "tissue/area_element.hpp"
#include "tissue/incidence.hpp"
#include "tissue/spring_law.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr int kRange = 1024;
constexpr std::size_t kPointGrain = 1024;

struct Line {
  Vec3 direction;
  double length;
};

Line line_of_force(const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double l = length(d);
  return {l > 0 ? d * (1.0 / l) : Vec3{}, l};
}

template <SpringLaw law>
SpringStiffness spring_stiffness(const Line& line, double rest, double k, double projection) {
  const auto t = law_tension<law>(line.length, rest);
  const double transverse = line.length > 0 ? k * t.tension / line.length : 0.0;
  return {line.direction, k * t.slope, transverse < 0 ? transverse * (1 - projection) : transverse};
}

// ∂²V/∂x_a∂x_b = ⅙ [w]×, w along the edge opposite to a and b.
Vec3 opposite_edge(const Vec3 edge[3], int a, int b) {
  if (a > b) return -opposite_edge(edge, b, a);
  if (a == 0) return b == 1 ? edge[1] - edge[2] : b == 2 ? edge[2] - edge[0] : edge[0] - edge[1];
  if (a == 1) return b == 2 ? -edge[2] : edge[1];
  return -edge[0];
}

/// Of the point from its plane, mm; negative beyond it.
double distance_from_plane(const Contact& c, std::span<const Vec3> positions) {
  return dot(c.normal, positions[static_cast<std::size_t>(c.point)]) - c.offset_mm;
}
double stiffness_at(const Contact& c, double distance) {
  return distance < 0 ? c.stiffness_n_mm : c.adhesion_n_mm;
}

Mat3 outer(const Vec3& a, const Vec3& b) {
  return Mat3{{a * b.x, a * b.y, a * b.z}};
}

void add(Mat3& m, const Mat3& n) {
  for (std::size_t j = 0; j < 3; ++j) m.c[j] += n.c[j];
}

template <int corners, class Block>
void multiply_element(const int* p, std::span<const Vec3> v, Vec3* out, Block&& block) {
  for (int a = 0; a < corners; ++a) {
    Vec3 sum;
    for (int b = 0; b < corners; ++b) sum += block(a, b) * v[p[b]];
    out[a] = sum;
  }
}

}  // namespace

Result<NetworkEnergy> NetworkEnergy::prepare(const SpringNetwork& network) {
  TURGOR_CHECK(validate(network));
  NetworkEnergy energy;
  energy.add_springs(network);
  energy.add_areas(network);
  energy.add_volumes(network);
  energy.prepare_incidence(static_cast<int>(network.rest.size()));
  energy.prepare_contacts(network);
  return energy;
}

void NetworkEnergy::prepare_incidence(int points) {
  spring_incidence_ = make_incidence(points, 2 * static_cast<int>(ends_.size()),
                                     [&](int e) { return e % 2 == 0 ? ends_[e / 2].a : ends_[e / 2].b; });
  area_incidence_ = make_incidence(points, 3 * static_cast<int>(triangles_.size()),
                                   [&](int e) { return triangles_[e / 3].p[e % 3]; });
  volume_incidence_ = make_incidence(points, 4 * static_cast<int>(corners_.size()),
                                     [&](int e) { return corners_[e / 4].p[e % 4]; });
}

void NetworkEnergy::prepare_contacts(const SpringNetwork& network) {
  contacts_ = network.contacts;
  if (contacts_.empty()) return;
  contact_of_point_.assign(network.rest.size(), -1);
  for (std::size_t i = 0; i < contacts_.size(); ++i)
    contact_of_point_[contacts_[i].point] = static_cast<int>(i);
}

// Contacts are few: their energy, and their forces unless `forces` is empty.
double NetworkEnergy::add_contacts(std::span<const Vec3> positions, std::span<Vec3> forces) const {
  double energy = 0;
  for (const Contact& c : contacts_) {
    const double d = distance_from_plane(c, positions), k = stiffness_at(c, d);
    energy += 0.5 * k * d * d;
    if (!forces.empty()) forces[c.point] -= c.normal * (k * d);
  }
  return energy;
}

void NetworkEnergy::add_ranges(Kind kind, SpringLaw law, int first, int last) {
  for (int begin = first; begin < last; begin += kRange) {
    ranges_.push_back({kind, law, begin, std::min(begin + kRange, last)});
  }
}

void NetworkEnergy::add_spring(int a, int b, double rest_length_mm, double stiffness_n) {
  ends_.push_back({a, b});
  rest_length_.push_back(rest_length_mm);
  stiffness_.push_back(stiffness_n);
}

void NetworkEnergy::add_springs(const SpringNetwork& network) {
  place_of_spring_.resize(network.springs.size());
  for (const SpringLaw law : kSpringLaws) {
    const int first = static_cast<int>(ends_.size());
    for (std::size_t i = 0; i < network.springs.size(); ++i) {
      const Spring& s = network.springs[i];
      if (s.law != law) continue;
      place_of_spring_[i] = static_cast<int>(ends_.size());
      add_spring(s.a, s.b, s.rest_length_mm, s.stiffness_n);
    }
    for (std::size_t s = 0; law == SpringLaw::hookean && s < network.solids.size(); ++s) {
      const Solid& solid = network.solids[s];
      for (std::size_t e = 0; e < solid.edges.size(); ++e) {
        const auto [a, b] = solid.edges[e];
        const double rest = distance(network.rest[a], network.rest[b]);
        if (solid.edge_nmm[e] > 0) add_spring(a, b, rest, solid.edge_nmm[e] / rest);
      }
    }
    add_ranges(Kind::springs, law, first, static_cast<int>(ends_.size()));
  }
}

void NetworkEnergy::add_areas(const SpringNetwork& network) {
  area_materials_ = network.areas;
  for (const Solid& solid : network.solids) {
    for (std::size_t t = 0; t < solid.triangles.size(); ++t) {
      const auto [a, b, c] = solid.triangles[t];
      if (!(solid.triangle_nmm[t] > 0)) continue;
      const double area = shape_of(network.rest[a], network.rest[b], network.rest[c]).area;
      area_materials_.push_back({{a, b, c}, area, solid.triangle_nmm[t]});
    }
  }
  for (const AreaElement& m : area_materials_) triangles_.push_back({{m.p[0], m.p[1], m.p[2]}});
  add_ranges(Kind::areas, SpringLaw::linear, 0, static_cast<int>(triangles_.size()));
}

void NetworkEnergy::add_volume(const VolumeElement& v) {
  corners_.push_back({{v.p[0], v.p[1], v.p[2], v.p[3]}});
  materials_.push_back(v);
}

void NetworkEnergy::add_volumes(const SpringNetwork& network) {
  for (const VolumeElement& v : network.volumes) add_volume(v);
  for (const Solid& solid : network.solids) {
    for (std::size_t t = 0; t < solid.tetrahedra.size(); ++t) {
      const auto [a, b, c, d] = solid.tetrahedra[t];
      if (!(solid.tetrahedron_nmm[t] > 0)) continue;
      const double volume = signed_volume(network.rest[a], network.rest[b], network.rest[c], network.rest[d]);
      add_volume({{a, b, c, d}, volume, solid.tetrahedron_nmm[t] / volume});
    }
  }
  add_ranges(Kind::volumes, SpringLaw::linear, 0, static_cast<int>(corners_.size()));
}

void NetworkEnergy::set_rest_length(int spring, double rest_length_mm) {
  rest_length_[place_of_spring_[spring]] = rest_length_mm;
}

double NetworkEnergy::unit_force() const {
  double sum = 0;
  const auto add_square = [&](double k) { sum += k * k; };
  for (const double k : stiffness_) add_square(k);
  for (const AreaElement& a : area_materials_) add_square(a.stiffness_nmm / std::sqrt(a.rest_area_mm2));
  for (const VolumeElement& v : materials_)
    add_square(v.modulus_mpa * std::cbrt(v.rest_volume_mm3 * v.rest_volume_mm3));
  return std::sqrt(sum);
}

double NetworkEnergy::spring_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const {
  return with_law(range.law, [&]<SpringLaw law>() {
    double energy = 0;
    for (int i = range.begin; i < range.end; ++i) {
      const Line line = line_of_force(positions[ends_[i].a], positions[ends_[i].b]);
      if (out != nullptr) {
        out[i] = line.direction * (stiffness_[i] * law_tension<law>(line.length, rest_length_[i]).tension);
      }
      energy += stiffness_[i] * law_energy<law>(line.length, rest_length_[i]);
    }
    return energy;
  });
}

double NetworkEnergy::volume_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const {
  double energy = 0;
  for (int i = range.begin; i < range.end; ++i) {
    const Corners& c = corners_[i];
    const Vec3& origin = positions[c.p[0]];
    const Vec3 e1 = positions[c.p[1]] - origin, e2 = positions[c.p[2]] - origin,
               e3 = positions[c.p[3]] - origin;
    const std::array<Vec3, 4> g = volume_gradient(e1, e2, e3);
    const VolumeResponse r = respond(materials_[i], dot(e1, g[1]));
    energy += r.energy;
    if (out == nullptr) continue;
    for (int corner = 0; corner < 4; ++corner) out[4 * i + corner] = g[corner] * -r.mean_stress;
  }
  return energy;
}

double NetworkEnergy::area_forces(const Range& range, std::span<const Vec3> positions, Vec3* out) const {
  double energy = 0;
  for (int i = range.begin; i < range.end; ++i) {
    const Triangle& t = triangles_[i];
    const TriangleShape shape = shape_of(positions[t.p[0]], positions[t.p[1]], positions[t.p[2]]);
    const AreaResponse r = respond(area_materials_[i], shape.area);
    energy += r.energy;
    if (out == nullptr) continue;
    for (int corner = 0; corner < 3; ++corner)
      out[3 * i + corner] = area_gradient(shape.normal, shape.edge[corner]) * -r.stress;
  }
  return energy;
}

// Energy of all elements; their forces where there is a workspace for them.
double NetworkEnergy::element_forces(std::span<const Vec3> positions, Workspace* w) const {
  return parallel_reduce<double>(
      ranges_.size(), 1, 0.0,
      [&](std::size_t begin, std::size_t) {
        const Range& range = ranges_[begin];
        switch (range.kind) {
          case Kind::areas:
            return area_forces(range, positions, w != nullptr ? w->area_force.data() : nullptr);
          case Kind::volumes:
            return volume_forces(range, positions, w != nullptr ? w->volume_force.data() : nullptr);
          case Kind::springs:
            break;
        }
        return spring_forces(range, positions, w != nullptr ? w->spring_force.data() : nullptr);
      },
      std::plus<>());
}

double NetworkEnergy::value(std::span<const Vec3> positions) const {
  return element_forces(positions, nullptr) + add_contacts(positions, {});
}

double NetworkEnergy::forces(std::span<const Vec3> positions, std::span<Vec3> forces,
                             Workspace& workspace) const {
  fit(workspace);
  const double energy = element_forces(positions, &workspace);
  gather(workspace, forces);
  return energy + add_contacts(positions, forces);
}

void NetworkEnergy::fit(Workspace& workspace) const {
  workspace.spring_force.resize(ends_.size());
  workspace.area_force.resize(3 * triangles_.size());
  workspace.volume_force.resize(4 * corners_.size());
}

void NetworkEnergy::gather(const Workspace& workspace, std::span<Vec3> forces) const {
  parallel_for(forces.size(), kPointGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum;
      for (int k = spring_incidence_.offsets[i]; k < spring_incidence_.offsets[i + 1]; ++k) {
        const int entry = spring_incidence_.entries[k];
        const Vec3& f = workspace.spring_force[entry / 2];
        sum += entry % 2 == 0 ? f : -f;
      }
      for (int k = area_incidence_.offsets[i]; k < area_incidence_.offsets[i + 1]; ++k) {
        sum += workspace.area_force[area_incidence_.entries[k]];
      }
      for (int k = volume_incidence_.offsets[i]; k < volume_incidence_.offsets[i + 1]; ++k) {
        sum += workspace.volume_force[volume_incidence_.entries[k]];
      }
      forces[i] = sum;
    }
  });
}

void NetworkEnergy::linearise(std::span<const Vec3> positions, double projection,
                              ElementStiffness& stiffness) const {
  stiffness.projection = projection;
  stiffness.springs.resize(ends_.size());
  stiffness.areas.resize(triangles_.size());
  stiffness.volumes.resize(corners_.size());
  stiffness.contacts.resize(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    stiffness.contacts[i] = stiffness_at(contacts_[i], distance_from_plane(contacts_[i], positions));
  }
  parallel_for(ranges_.size(), 1, [&](std::size_t r, std::size_t) {
    const Range& range = ranges_[r];
    if (range.kind == Kind::springs) linearise_springs(range, positions, stiffness);
    if (range.kind == Kind::areas) linearise_areas(range, positions, stiffness);
    if (range.kind == Kind::volumes) linearise_volumes(range, positions, stiffness);
  });
}

void NetworkEnergy::linearise_springs(const Range& range, std::span<const Vec3> positions,
                                      ElementStiffness& stiffness) const {
  with_law(range.law, [&]<SpringLaw law>() {
    for (int i = range.begin; i < range.end; ++i) {
      const Line line = line_of_force(positions[ends_[i].a], positions[ends_[i].b]);
      stiffness.springs[i] =
          spring_stiffness<law>(line, rest_length_[i], stiffness_[i], stiffness.projection);
    }
  });
}

void NetworkEnergy::linearise_areas(const Range& range, std::span<const Vec3> positions,
                                    ElementStiffness& stiffness) const {
  for (int i = range.begin; i < range.end; ++i) {
    const Triangle& t = triangles_[i];
    const TriangleShape shape = shape_of(positions[t.p[0]], positions[t.p[1]], positions[t.p[2]]);
    const AreaResponse r = respond(area_materials_[i], shape.area);
    AreaStiffness& a = stiffness.areas[i];
    a.normal = shape.normal;
    std::copy(shape.edge.begin(), shape.edge.end(), a.edge);
    a.stretch = r.slope;
    a.stress = r.stress;
    a.bend = shape.area > 0 ? 0.25 * r.stress / shape.area : 0.0;
  }
}

void NetworkEnergy::linearise_volumes(const Range& range, std::span<const Vec3> positions,
                                      ElementStiffness& stiffness) const {
  for (int i = range.begin; i < range.end; ++i) {
    const Corners& c = corners_[i];
    VolumeStiffness& v = stiffness.volumes[i];
    for (int k = 0; k < 3; ++k) v.edge[k] = positions[c.p[k + 1]] - positions[c.p[0]];
    const std::array<Vec3, 4> g = volume_gradient(v.edge[0], v.edge[1], v.edge[2]);
    std::copy(g.begin(), g.end(), v.gradient);
    const VolumeResponse response = respond(materials_[i], dot(v.edge[0], g[1]));
    v.bulk = response.slope;
    v.stress = response.mean_stress;
  }
}

Mat3 volume_block(const VolumeStiffness& v, int a, int b, double projection) {
  Mat3 block = outer(v.gradient[a] * v.bulk, v.gradient[b]);
  if (v.stress == 0.0) return block;
  if (a != b) {
    const Vec3 w = opposite_edge(v.edge, a, b) * ((1 - 0.5 * projection) * v.stress / 6.0);
    add(block, Mat3{{Vec3{0, w.z, -w.y}, Vec3{-w.z, 0, w.x}, Vec3{w.y, -w.x, 0}}});  // [w]×
    return block;
  }
  if (projection == 0.0) return block;
  // The nearest semi-definite matrix to (0 B; Bᵀ 0) is ½ (√(BBᵀ) B; Bᵀ √(BᵀB)), and √([w]× [w]×ᵀ) = |w| − w
  // wᵀ/|w|.
  for (int other = 0; other < 4; ++other) {
    if (other == a) continue;
    const Vec3 w = opposite_edge(v.edge, a, other);
    const double l = length(w), half = 0.5 * projection * std::abs(v.stress) / 6.0;
    if (!(l > 0)) continue;
    add(block, outer(w * (-half / l), w));
    for (int k = 0; k < 3; ++k) block.c[static_cast<std::size_t>(k)][k] += half * l;
  }
  return block;
}

Mat3 area_block(const AreaStiffness& area, int a, int b, double projection) {
  Mat3 block{{Vec3{}, Vec3{}, Vec3{}}};
  add_area_block(area, parts_of(area, projection), a, b, area_gradient(area.normal, area.edge[a]),
                 area_gradient(area.normal, area.edge[b]), block);
  return block;
}

void NetworkEnergy::multiply_springs(const Range& range, const ElementStiffness& stiffness,
                                     std::span<const Vec3> v, Vec3* out) const {
  for (int i = range.begin; i < range.end; ++i) {
    const SpringStiffness& s = stiffness.springs[i];
    const Vec3 d = v[ends_[i].a] - v[ends_[i].b];
    out[i] = d * s.transverse + s.direction * ((s.axial - s.transverse) * dot(s.direction, d));
  }
}

void NetworkEnergy::multiply(const ElementStiffness& stiffness, std::span<const Vec3> v, std::span<Vec3> out,
                             Workspace& workspace) const {
  fit(workspace);
  const double projection = stiffness.projection;
  parallel_for(ranges_.size(), 1, [&](std::size_t r, std::size_t) {
    const Range& range = ranges_[r];
    if (range.kind == Kind::springs) multiply_springs(range, stiffness, v, workspace.spring_force.data());
    for (int i = range.begin; range.kind == Kind::areas && i < range.end; ++i) {
      multiply_element<3>(triangles_[i].p, v, &workspace.area_force[3 * i],
                          [&](int a, int b) { return area_block(stiffness.areas[i], a, b, projection); });
    }
    for (int i = range.begin; range.kind == Kind::volumes && i < range.end; ++i) {
      multiply_element<4>(corners_[i].p, v, &workspace.volume_force[4 * i],
                          [&](int a, int b) { return volume_block(stiffness.volumes[i], a, b, projection); });
    }
  });
  gather(workspace, out);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Contact& c = contacts_[i];
    out[c.point] += c.normal * (stiffness.contacts[i] * dot(c.normal, v[c.point]));
  }
}

int NetworkEnergy::coincident_springs(std::span<const Vec3> positions) const {
  return static_cast<int>(std::count_if(
      ends_.begin(), ends_.end(), [&](const SpringEnds& e) { return positions[e.a] == positions[e.b]; }));
}

int NetworkEnergy::inverted_volumes(std::span<const Vec3> positions) const {
  return static_cast<int>(std::count_if(corners_.begin(), corners_.end(), [&](const Corners& c) {
    return !(signed_volume(positions[c.p[0]], positions[c.p[1]], positions[c.p[2]], positions[c.p[3]]) > 0);
  }));
}

}  // namespace turgor
