#include "dynamics/network_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "dynamics/bisect.hpp"
#include "math/lanes.hpp"
#include "tissue/incidence.hpp"
#include "tissue/spring_law.hpp"
#include "turgor/core/index.hpp"

namespace turgor {
namespace {

using Quad = NetworkBlocks::Quad;

// Own points of a block at most: positions, velocities and forces of it and its halo stay in a second level
// cache of 256 KiB, and less than a tenth of the springs of layered tissue are computed twice.
constexpr std::size_t kOwn = 2048;
constexpr std::size_t kWidth = kLanes;
constexpr std::size_t kAhead = 16;  // points that are fetched from memory before they are needed

template <class Real>
constexpr bool kIsScalar = std::is_same_v<Real, double>;

template <class Real>
Real load(const double* from) {
  if constexpr (kIsScalar<Real>)
    return *from;
  else
    return load_lanes(from);
}

double root(double x) {
  return std::sqrt(x);
}
Lanes root(Lanes x) {
  return sqrt(x);
}

bool all(bool condition) {
  return condition;
}
bool all(LaneBits mask) {
  return (mask[0] & mask[1] & mask[2] & mask[3]) != 0;
}

template <class Real>
struct Column {
  Real x, y, z;
};

/// From the points `a` to the points `b` of one spring, or of four.
template <class Real>
Column<Real> difference(const Quad* of, const int* a, const int* b) {
  if constexpr (kIsScalar<Real>) {
    const double *from = of[*a].v, *to = of[*b].v;
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  } else {
    const auto row = [&](std::size_t k) { return load_lanes(of[b[k]].v) - load_lanes(of[a[k]].v); };
    Lanes r0 = row(0), r1 = row(1), r2 = row(2), r3 = row(3);
    transpose(r0, r1, r2, r3);
    return {r0, r1, r2};
  }
}

/// Adds forces to the points `a`, the opposite ones to the points `b`, and the stiffness to both.
template <class Real>
void scatter(Quad* to, const int* a, const int* b, const Column<Real>& force, Real stiffness) {
  if constexpr (kIsScalar<Real>) {
    double *at_a = to[*a].v, *at_b = to[*b].v;
    at_a[0] += force.x, at_a[1] += force.y, at_a[2] += force.z, at_a[3] += stiffness;
    at_b[0] -= force.x, at_b[1] -= force.y, at_b[2] -= force.z, at_b[3] += stiffness;
  } else {
    constexpr Lanes sign = {-1, -1, -1, 1};
    Lanes rows[kWidth] = {force.x, force.y, force.z, stiffness};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (std::size_t k = 0; k < kWidth; ++k) {
      double *at_a = to[a[k]].v, *at_b = to[b[k]].v;
      store_lanes(at_a, load_lanes(at_a) + rows[k]);
      store_lanes(at_b, load_lanes(at_b) + rows[k] * sign);
    }
  }
}

/// The same to one point of each element.
template <class Real>
void scatter(Quad* to, const int* a, const Column<Real>& force, Real stiffness) {
  if constexpr (kIsScalar<Real>) {
    double* at_a = to[*a].v;
    at_a[0] += force.x, at_a[1] += force.y, at_a[2] += force.z, at_a[3] += stiffness;
  } else {
    Lanes rows[kWidth] = {force.x, force.y, force.z, stiffness};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (std::size_t k = 0; k < kWidth; ++k) {
      double* at_a = to[a[k]].v;
      store_lanes(at_a, load_lanes(at_a) + rows[k]);
    }
  }
}

template <class Real>
Column<Real> cross(const Column<Real>& a, const Column<Real>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

template <class Real>
Real dot(const Column<Real>& a, const Column<Real>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// from[index[0]], from[index[1]], …; zero for the index −1.
template <class Real>
Real pick(std::span<const double> from, const int* index) {
  const auto one = [&](std::size_t k) { return index[k] < 0 ? 0.0 : from[at(index[k])]; };
  if constexpr (kIsScalar<Real>)
    return one(0);
  else
    return Lanes{one(0), one(1), one(2), one(3)};
}

}  // namespace

NetworkBlocks::NetworkBlocks(const MotionModel& model, std::span<const double> share) {
  const auto& net = model.network;
  const int points = static_cast<int>(net.rest.size());
  mobile_ = model.mobile.empty() ? std::vector<char>(net.rest.size(), 1) : model.mobile;
  for (const SpringMotion& s : model.springs) {
    viscous_ = viscous_ || s.viscosity > 0;
    cut_ = cut_ || s.cutoff_mm > 0;
  }
  slots_of_spring_.assign(net.springs.size(), {-1, -1});
  const auto springs_at = make_incidence(points, 2 * static_cast<int>(net.springs.size()), [&](int e) {
    return e % 2 == 0 ? net.springs[at(e / 2)].a : net.springs[at(e / 2)].b;
  });
  const auto volumes_at = make_incidence(points, 4 * static_cast<int>(net.volumes.size()),
                                         [&](int e) { return net.volumes[at(e / 4)].p[e % 4]; });
  const auto areas_at = make_incidence(points, 3 * static_cast<int>(net.areas.size()),
                                       [&](int e) { return net.areas[at(e / 3)].p[e % 3]; });
  std::vector<int> relaxing_number(net.springs.size(), -1);
  int relaxing = 0;
  for (std::size_t i = 0; i < model.springs.size(); ++i)
    if (model.springs[i].relaxes) relaxing_number[i] = relaxing++;
  std::vector<int> mobile;
  for (int p = 0; p < points; ++p)
    if (mobile_[at(p)] != 0) mobile.push_back(p);
  std::vector<int> local(net.rest.size(), -1);
  const Layout layout{model, share, springs_at, areas_at, volumes_at, relaxing_number};
  detail::bisect(
      std::span(mobile), [&](int p) { return net.rest[at(p)]; },
      [](std::span<const int> own) { return own.size() <= kOwn; },
      [&](std::span<const int> own) { lay_out_block(layout, own, local); });
}

void NetworkBlocks::lay_out_block(const Layout& layout, std::span<const int> own, std::vector<int>& local) {
  Block block{members_.size(), own.size(), 0, {}, 0, 0, 0, 0};
  const auto enter = [&](int point) {
    if (local[at(point)] >= 0) return;
    local[at(point)] = static_cast<int>(members_.size() - block.first_member);
    members_.push_back(point);
  };
  for (const int p : own) enter(p);
  lay_out_springs(layout, block, own, local, enter);
  lay_out_areas(layout, block, own, local, enter);
  lay_out_volumes(layout, block, own, local, enter);
  block.members = members_.size() - block.first_member;
  for (std::size_t i = 0; i < block.members; ++i) local[at(members_[block.first_member + i])] = -1;
  blocks_.push_back(block);
}

template <class Enter>
void NetworkBlocks::lay_out_springs(const Layout& layout, Block& block, std::span<const int> own,
                                    std::span<const int> local, const Enter& enter) {
  const auto& springs = layout.model.network.springs;
  std::array<std::vector<Draft>, kGroups> drafts;
  for (const int p : own) {
    for (int k = layout.springs_at.offsets[at(p)]; k < layout.springs_at.offsets[at(p) + 1]; ++k) {
      const int entry = layout.springs_at.entries[at(k)], i = entry / 2;
      const Spring& s = springs[at(i)];
      const int other = entry % 2 == 0 ? s.b : s.a;
      enter(other);
      const bool second_visit = at(local[at(other)]) < own.size() && entry % 2 == 1;
      if (layout.share[at(i)] == 0 || second_visit) continue;
      const std::size_t relaxes = layout.relaxing_number[at(i)] >= 0 ? 1 : 0;
      drafts[2 * static_cast<std::size_t>(s.law) + relaxes].push_back({i, local[at(s.a)], local[at(s.b)]});
    }
  }
  for (std::size_t g = 0; g < kGroups; ++g) {
    block.group[g] = a_.size();
    lay_out_group(layout, drafts[g]);
  }
  block.group[kGroups] = a_.size();
}

// Springs of one point follow one another in the drafts. Lanes run through quarters of them, so that lanes
// side by side, and mostly springs after one another, add to points of their own.
void NetworkBlocks::lay_out_group(const Layout& layout, std::span<const Draft> drafts) {
  const std::size_t rows = (drafts.size() + kWidth - 1) / kWidth;
  for (std::size_t slot = 0; slot < rows * kWidth; ++slot) {
    const std::size_t from = (slot % kWidth) * rows + slot / kWidth;
    const bool real = from < drafts.size();
    const Draft draft = real ? drafts[from] : Draft{-1, 0, 0};
    const Spring s = real ? layout.model.network.springs[at(draft.spring)] : Spring{};
    const SpringMotion motion =
        real && !layout.model.springs.empty() ? layout.model.springs[at(draft.spring)] : SpringMotion{};
    const double share = real ? layout.share[at(draft.spring)] : 0.0;
    if (real) {
      auto& slots = slots_of_spring_[at(draft.spring)];
      slots[slots[0] < 0 ? 0 : 1] = static_cast<int>(a_.size());
    }
    a_.push_back(draft.a);
    b_.push_back(draft.b);
    spring_.push_back(draft.spring);
    rest_length_.push_back(s.rest_length_mm);
    stiffness_.push_back(share * s.stiffness_n);
    if (viscous_) viscosity_.push_back(share * motion.viscosity);
    constexpr double never = std::numeric_limits<double>::infinity();
    if (cut_) cutoff_.push_back(motion.cutoff_mm > 0 ? motion.cutoff_mm : never);
    relaxing_.push_back(real ? layout.relaxing_number[at(draft.spring)] : -1);
  }
}

// The elements of so many corners at own points, each at the first of these: own corners come before those
// of the halo.
template <class Element, class Enter>
std::vector<int> NetworkBlocks::elements_at(const std::vector<Element>& elements,
                                            const NetworkEnergy::Incidence& at_point,
                                            std::span<const int> own, std::span<const int> local,
                                            const Enter& enter) {
  constexpr int corners = static_cast<int>(std::extent_v<decltype(Element::p)>);
  std::vector<int> found;
  for (const int p : own) {
    for (int k = at_point.offsets[at(p)]; k < at_point.offsets[at(p) + 1]; ++k) {
      const int i = at_point.entries[at(k)] / corners;
      int first = p;
      for (const int q : elements[at(i)].p) {
        enter(q);
        if (local[at(q)] < local[at(first)]) first = q;
      }
      if (first == p) found.push_back(i);
    }
  }
  return found;
}

// Lanes as those of springs: visit(element, −1 where there is none) slot by slot.
template <class Visit>
void NetworkBlocks::visit_slots(std::span<const int> elements, const Visit& visit) {
  const std::size_t rows = (elements.size() + kWidth - 1) / kWidth;
  for (std::size_t slot = 0; slot < rows * kWidth; ++slot) {
    const std::size_t from = (slot % kWidth) * rows + slot / kWidth;
    visit(from < elements.size() ? elements[from] : -1);
  }
}

template <class Enter>
void NetworkBlocks::lay_out_areas(const Layout& layout, Block& block, std::span<const int> own,
                                  std::span<const int> local, const Enter& enter) {
  const auto& areas = layout.model.network.areas;
  block.first_area = area_stiffness_.size();
  visit_slots(elements_at(areas, layout.areas_at, own, local, enter), [&](int i) {
    const AreaElement a = i >= 0 ? areas[at(i)] : AreaElement{};
    for (std::size_t c = 0; c < 3; ++c) area_corner_[c].push_back(i >= 0 ? local[at(a.p[c])] : 0);
    const double doubled = 2 * a.rest_area_mm2;
    doubled_area_.push_back(doubled);
    area_stiffness_.push_back(a.stiffness_nmm / (doubled * doubled));
  });
  block.areas_end = area_stiffness_.size();
}

template <class Enter>
void NetworkBlocks::lay_out_volumes(const Layout& layout, Block& block, std::span<const int> own,
                                    std::span<const int> local, const Enter& enter) {
  const auto& volumes = layout.model.network.volumes;
  block.first_volume = sixth_inverse_.size();
  visit_slots(elements_at(volumes, layout.volumes_at, own, local, enter), [&](int i) {
    const VolumeElement v = i >= 0 ? volumes[at(i)] : VolumeElement{};
    for (std::size_t c = 0; c < 4; ++c) corner_[c].push_back(i >= 0 ? local[at(v.p[c])] : 0);
    sixth_inverse_.push_back(i >= 0 ? 1 / (6 * v.rest_volume_mm3) : 0);
    sixth_modulus_.push_back(v.modulus_mpa / 6);
    sixth_guard_.push_back(v.inversion_guard_mpa / 6);
  });
  block.volumes_end = sixth_inverse_.size();
}

void NetworkBlocks::set_rest_length(int spring, double rest_length_mm) {
  for (const int slot : slots_of_spring_[at(spring)])
    if (slot >= 0) rest_length_[at(slot)] = rest_length_mm;
}

// Where the first end is mobile its block counts the spring, otherwise the only one.
int NetworkBlocks::count_coincident(const Block& block, std::size_t slot, std::size_t slots,
                                    const Quad* position) const {
  int count = 0;
  for (std::size_t i = slot; i < slot + slots; ++i) {
    if (spring_[i] < 0) continue;
    const bool counts = at(a_[i]) < block.own || mobile_[at(members_[block.first_member + at(a_[i])])] == 0;
    const Column<double> d = difference<double>(position, &a_[i], &b_[i]);
    if (counts && !(d.x * d.x + d.y * d.y + d.z * d.z > 0)) ++count;
  }
  return count;
}

template <class Real, NetworkBlocks::Wants wants, SpringLaw law>
int NetworkBlocks::add_group(const Block& block, std::size_t group, std::span<const double> offset,
                             const Buffers& buffers) const {
  constexpr std::size_t width = kIsScalar<Real> ? 1 : kWidth;
  const bool relaxes = group % 2 == 1;
  int coincident = 0;
  for (std::size_t i = block.group[group]; i < block.group[group + 1]; i += width) {
    const auto d = difference<Real>(buffers.position, &a_[i], &b_[i]);
    const Real length = root(d.x * d.x + d.y * d.y + d.z * d.z), none = Real{};
    auto acts = length > 0.0;
    if (!all(acts)) coincident += count_coincident(block, i, width, buffers.position);
    if (cut_) acts = acts & (length <= load<Real>(&cutoff_[i]));
    const Real inverse = 1.0 / length;
    const auto t = law_tension<law>(length, load<Real>(&rest_length_[i]));
    const Real k = load<Real>(&stiffness_[i]);
    Real tension = k * t.tension;
    if (relaxes) tension = tension - pick<Real>(offset, &relaxing_[i]);
    Real stiffness = none;  // of both blocks in a row
    if constexpr (wants == Wants::stiffness) {
      const Real axial = k * t.slope, across = (tension < 0.0 ? -tension : tension) * inverse;
      stiffness = 2.0 * (axial > across ? axial : across);
    }
    if (viscous_) {
      const auto u = difference<Real>(buffers.velocity, &a_[i], &b_[i]);
      const Real rate = (u.x * d.x + u.y * d.y + u.z * d.z) * inverse;
      tension = tension + load<Real>(&viscosity_[i]) * rate;
    }
    const Real pull = acts ? tension * inverse : none;
    scatter<Real>(buffers.force, &a_[i], &b_[i], {d.x * pull, d.y * pull, d.z * pull},
                  acts ? stiffness : none);
  }
  return coincident;
}

// With n = 2 A and n₀ of A₀ the energy is ½ κ (n − n₀)², κ = k/n₀². Between corners c and d the blocks are
// κ |e_c||e_d| at most within the plane and the tension κ |n − n₀| e_c·e_d/n across it, e being the edges
// opposite, and the tension turned by a right angle within. A flat one has no direction.
template <class Real, NetworkBlocks::Wants wants>
void NetworkBlocks::add_areas(const Block& block, const Buffers& to) const {
  constexpr std::size_t width = kIsScalar<Real> ? 1 : kWidth;
  for (std::size_t i = block.first_area; i < block.areas_end; i += width) {
    const int* const p[3] = {&area_corner_[0][i], &area_corner_[1][i], &area_corner_[2][i]};
    const Column<Real> e[3] = {difference<Real>(to.position, p[1], p[2]),
                               difference<Real>(to.position, p[2], p[0]),
                               difference<Real>(to.position, p[0], p[1])};
    const auto n = cross(e[0], e[1]);
    const Real size = root(dot(n, n)), none = Real{}, k = load<Real>(&area_stiffness_[i]);
    const auto acts = size > 0.0;
    const Real tension = k * (size - load<Real>(&doubled_area_[i])), inverse = 1.0 / size;
    const Real pull = acts ? tension * inverse : none;
    Real length[3] = {none, none, none}, around = none, turning = none;
    if constexpr (wants == Wants::stiffness) {
      const Real across = pull < 0.0 ? -pull : pull;
      for (std::size_t c = 0; c < 3; ++c) length[c] = root(dot(e[c], e[c]));
      around = (k > across ? k : across) * ((length[0] + length[1]) + length[2]);
      turning = (across * size) * 2.0;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const auto f = cross(e[c], n);
      scatter<Real>(to.force, p[c], {f.x * pull, f.y * pull, f.z * pull}, around * length[c] + turning);
    }
  }
}

// With h = 6 ∂V/∂x the blocks of the stiffness between corners c and d are h hᵀ/36 · ∂²E/∂V², of the norm
// |h_c||h_d|/36 · ∂²E/∂V², and the mean stress times the opposite edge over 6, turned; a row has three of
// these, whose edges are no longer than 2 (|e₁| + |e₂| + |e₃|) ≤ 2 √(3 Σ e²) together.
template <class Real, NetworkBlocks::Wants wants>
void NetworkBlocks::add_volumes(const Block& block, const Buffers& to) const {
  constexpr std::size_t width = kIsScalar<Real> ? 1 : kWidth;
  constexpr double from = VolumeElement::kGuardFrom;
  for (std::size_t i = block.first_volume; i < block.volumes_end; i += width) {
    const int* const p[4] = {&corner_[0][i], &corner_[1][i], &corner_[2][i], &corner_[3][i]};
    const auto e1 = difference<Real>(to.position, p[0], p[1]), e2 = difference<Real>(to.position, p[0], p[2]),
               e3 = difference<Real>(to.position, p[0], p[3]);
    const auto h1 = cross(e2, e3), h2 = cross(e3, e1), h3 = cross(e1, e2);
    const Column<Real> h0 = {-(h1.x + h2.x + h3.x), -(h1.y + h2.y + h3.y), -(h1.z + h2.z + h3.z)};
    const Real none = Real{}, inverse = load<Real>(&sixth_inverse_[i]), ratio = dot(e1, h1) * inverse;
    const Real k = load<Real>(&sixth_modulus_[i]), g = load<Real>(&sixth_guard_[i]);
    const Real under = (from - ratio) * (1 / from), depth = under > 0.0 ? under : none;
    const Real pull = g * (depth * depth) - k * (ratio - 1.0);
    const Column<Real>* const h[4] = {&h0, &h1, &h2, &h3};
    Real norm[4] = {none, none, none, none}, slope = none, turning = none;
    if constexpr (wants == Wants::stiffness) {
      for (std::size_t c = 0; c < 4; ++c) norm[c] = root(dot(*h[c], *h[c]));
      slope = (k + g * depth * (2 / from)) * inverse * ((norm[0] + norm[1]) + (norm[2] + norm[3]));
      turning = (pull < 0.0 ? -pull : pull) * root((dot(e1, e1) + dot(e2, e2) + dot(e3, e3)) * 12.0);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      scatter<Real>(to.force, p[c], {h[c]->x * pull, h[c]->y * pull, h[c]->z * pull},
                    slope * norm[c] + turning);
    }
  }
}

template <class Real, NetworkBlocks::Wants wants>
NetworkBlocks::Sums NetworkBlocks::sum(std::size_t number, const MotionState& state,
                                       std::span<const double> offset, std::vector<Quad>& scratch) const {
  const Block& block = blocks_[number];
  const bool bare = block.group[0] == block.group[kGroups] && block.first_area == block.areas_end &&
                    block.first_volume == block.volumes_end;
  if (bare) return {std::span(members_).subspan(block.first_member, block.own)};
  if (scratch.size() < 3 * block.members) scratch.resize(3 * block.members);
  const Buffers to{scratch.data(), scratch.data() + block.members, scratch.data() + 2 * block.members};
  const std::span<const int> members = std::span(members_).subspan(block.first_member, block.members);
  for (std::size_t i = 0; i < block.members; ++i) {
    if (i + kAhead < block.members) {
      __builtin_prefetch(&state.position[at(members[i + kAhead])]);
      __builtin_prefetch(&state.velocity[at(members[i + kAhead])]);
    }
    const Vec3& x = state.position[at(members[i])];
    to.position[i] = {{x.x, x.y, x.z, 0}};
    to.force[i] = {};
  }
  for (std::size_t i = 0; i < (viscous_ ? block.members : block.own); ++i) {
    const Vec3& v = state.velocity[at(members[i])];
    to.velocity[i] = {{v.x, v.y, v.z, 0}};
  }
  Sums sums{members.first(block.own), to.position, to.velocity, to.force, 0, false};
  for (std::size_t g = 0; g < kGroups; ++g) {
    if (block.group[g] == block.group[g + 1]) continue;
    sums.coincident += with_law(kSpringLaws[g / 2], [&]<SpringLaw law>() {
      return add_group<Real, wants, law>(block, g, offset, to);
    });
  }
  add_areas<Real, wants>(block, to);
  add_volumes<Real, wants>(block, to);
  return sums;
}

template NetworkBlocks::Sums NetworkBlocks::sum<double, NetworkBlocks::Wants::forces>(
    std::size_t, const MotionState&, std::span<const double>, std::vector<Quad>&) const;
template NetworkBlocks::Sums NetworkBlocks::sum<double, NetworkBlocks::Wants::stiffness>(
    std::size_t, const MotionState&, std::span<const double>, std::vector<Quad>&) const;
template NetworkBlocks::Sums NetworkBlocks::sum<Lanes, NetworkBlocks::Wants::forces>(
    std::size_t, const MotionState&, std::span<const double>, std::vector<Quad>&) const;
template NetworkBlocks::Sums NetworkBlocks::sum<Lanes, NetworkBlocks::Wants::stiffness>(
    std::size_t, const MotionState&, std::span<const double>, std::vector<Quad>&) const;

}  // namespace turgor
