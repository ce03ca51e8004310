#include "turgor/tissue/network_energy.hpp"

#include <algorithm>
#include <array>
#include <functional>

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

}  // namespace

Result<NetworkEnergy> NetworkEnergy::prepare(const SpringNetwork& network) {
  TURGOR_CHECK(validate(network));
  NetworkEnergy energy;
  energy.split(network);
  for (const VolumeElement& v : network.volumes) {
    energy.corners_.push_back({{v.p[0], v.p[1], v.p[2], v.p[3]}});
  }
  energy.materials_ = network.volumes;
  const int volumes = static_cast<int>(network.volumes.size());
  for (int begin = 0; begin < volumes; begin += kRange) {
    energy.ranges_.push_back({true, SpringLaw::linear, begin, std::min(begin + kRange, volumes)});
  }
  const int points = static_cast<int>(network.rest.size());
  energy.spring_incidence_ = make_incidence(points, 2 * static_cast<int>(energy.ends_.size()), [&](int e) {
    return e % 2 == 0 ? energy.ends_[e / 2].a : energy.ends_[e / 2].b;
  });
  energy.volume_incidence_ =
      make_incidence(points, 4 * volumes, [&](int e) { return energy.corners_[e / 4].p[e % 4]; });
  energy.prepare_contacts(network);
  return energy;
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

void NetworkEnergy::split(const SpringNetwork& network) {
  for (const SpringLaw law : kSpringLaws) {
    const int first = static_cast<int>(ends_.size());
    for (const Spring& s : network.springs) {
      if (s.law != law) continue;
      ends_.push_back({s.a, s.b});
      rest_length_.push_back(s.rest_length_mm);
      stiffness_.push_back(s.stiffness_n);
    }
    const int last = static_cast<int>(ends_.size());
    for (int begin = first; begin < last; begin += kRange) {
      ranges_.push_back({false, law, begin, std::min(begin + kRange, last)});
    }
  }
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

double NetworkEnergy::value(std::span<const Vec3> positions) const {
  const double elastic = parallel_reduce<double>(
      ranges_.size(), 1, 0.0,
      [&](std::size_t begin, std::size_t) {
        const Range& range = ranges_[begin];
        return range.volumes ? volume_forces(range, positions, nullptr)
                             : spring_forces(range, positions, nullptr);
      },
      std::plus<>());
  return elastic + add_contacts(positions, {});
}

double NetworkEnergy::forces(std::span<const Vec3> positions, std::span<Vec3> forces,
                             Workspace& workspace) const {
  workspace.spring_force.resize(ends_.size());
  workspace.volume_force.resize(4 * corners_.size());
  const double energy = parallel_reduce<double>(
      ranges_.size(), 1, 0.0,
      [&](std::size_t begin, std::size_t) {
        const Range& range = ranges_[begin];
        return range.volumes ? volume_forces(range, positions, workspace.volume_force.data())
                             : spring_forces(range, positions, workspace.spring_force.data());
      },
      std::plus<>());
  gather(workspace, forces);
  return energy + add_contacts(positions, forces);
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
  stiffness.volumes.resize(corners_.size());
  stiffness.contacts.resize(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    stiffness.contacts[i] = stiffness_at(contacts_[i], distance_from_plane(contacts_[i], positions));
  }
  parallel_for(ranges_.size(), 1, [&](std::size_t r, std::size_t) {
    const Range& range = ranges_[r];
    if (range.volumes) {
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
      return;
    }
    with_law(range.law, [&]<SpringLaw law>() {
      for (int i = range.begin; i < range.end; ++i) {
        const Line line = line_of_force(positions[ends_[i].a], positions[ends_[i].b]);
        stiffness.springs[i] = spring_stiffness<law>(line, rest_length_[i], stiffness_[i], projection);
      }
    });
  });
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

void NetworkEnergy::multiply(const ElementStiffness& stiffness, std::span<const Vec3> v, std::span<Vec3> out,
                             Workspace& workspace) const {
  workspace.spring_force.resize(ends_.size());
  workspace.volume_force.resize(4 * corners_.size());
  parallel_for(ranges_.size(), 1, [&](std::size_t r, std::size_t) {
    const Range& range = ranges_[r];
    for (int i = range.begin; i < range.end; ++i) {
      if (range.volumes) {
        for (int a = 0; a < 4; ++a) {
          Vec3 sum;
          for (int b = 0; b < 4; ++b) {
            sum += volume_block(stiffness.volumes[i], a, b, stiffness.projection) * v[corners_[i].p[b]];
          }
          workspace.volume_force[4 * i + a] = sum;
        }
      } else {
        const SpringStiffness& s = stiffness.springs[i];
        const Vec3 d = v[ends_[i].a] - v[ends_[i].b];
        workspace.spring_force[i] =
            d * s.transverse + s.direction * ((s.axial - s.transverse) * dot(s.direction, d));
      }
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
