#include "dynamics/network_blocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "math/lanes.hpp"
#include "support/layered_slab.hpp"
#include "tissue/area_element.hpp"
#include "turgor/core/random.hpp"

namespace turgor {
namespace {

using Wants = NetworkBlocks::Wants;

/// All laws, some springs viscous, cut off or relaxing, areas, volumes, some guarded and inverted, some
/// points fixed; far more than one block.
struct Shaken {
  MotionModel model;
  MotionState state;
  std::vector<double> share, offset;
};

Shaken make_shaken(int side) {
  support::SlabOptions options;
  options.nx = options.ny = side;
  options.volumes = true;
  Shaken s;
  s.model.network = support::make_slab(options).network;
  auto& net = s.model.network;
  const RandomStream random(11);
  net.mass_g.assign(net.rest.size(), 0.05);
  s.model.mobile.assign(net.rest.size(), 1);
  for (std::size_t i = 0; i < net.rest.size(); i += 9) s.model.mobile[i] = 0;
  for (std::size_t i = 0; i < net.springs.size(); ++i) {
    Spring& spring = net.springs[i];
    spring.law = kSpringLaws[i % kSpringLaws.size()];
    s.model.springs.push_back({i % 3 == 0 ? 0.02 : 0.0, i % 5 == 0 ? 3.2 : 0.0, i % 4 == 0});
    const int mobile = s.model.mobile[static_cast<std::size_t>(spring.a)] +
                       s.model.mobile[static_cast<std::size_t>(spring.b)];
    s.share.push_back(mobile == 2 ? 0.5 : mobile);
    if (i % 4 == 0) s.offset.push_back(0.01 * random.uniform(i));
  }
  for (std::size_t i = 0; i < net.volumes.size(); i += 3) net.volumes[i].inversion_guard_mpa = 0.5;
  for (std::size_t i = 0; i < net.volumes.size(); i += 2) {
    const auto& p = net.volumes[i].p;
    net.areas.push_back({{p[0], p[1], p[2]}, 1 + random.uniform(i), 0.3});
  }
  for (std::size_t i = 0; i < net.rest.size(); ++i) {
    const auto vector = [&](std::uint64_t k) {
      return Vec3{random.normal(k), random.normal(k + 1), random.normal(k + 2)};
    };
    s.state.position.push_back(net.rest[i] + vector(6 * i) * 0.8);
    s.state.velocity.push_back(vector(6 * i + 3) * 0.1);
  }
  return s;
}

struct Total {
  std::vector<Vec3> force;
  std::vector<double> stiffness;
  std::vector<int> visits;
  int coincident = 0;
};

template <class Real, Wants wants = Wants::stiffness>
Total total(const NetworkBlocks& blocks, const Shaken& s) {
  const std::size_t n = s.state.position.size();
  Total t{std::vector<Vec3>(n), std::vector<double>(n), std::vector<int>(n)};
  std::vector<NetworkBlocks::Quad> scratch;
  for (std::size_t b = 0; b < blocks.count(); ++b) {
    const auto sums = blocks.sum<Real, wants>(b, s.state, s.offset, scratch);
    t.coincident += sums.coincident;
    for (std::size_t i = 0; i < sums.points.size(); ++i) {
      const auto p = static_cast<std::size_t>(sums.points[i]);
      const double* f = sums.force[i].v;
      t.force[p] = {f[0], f[1], f[2]};
      t.stiffness[p] = f[3];
      ++t.visits[p];
    }
  }
  return t;
}

std::array<Vec3, 4> gradient_of(const VolumeElement& v, const std::vector<Vec3>& x) {
  return volume_gradient(x[v.p[1]] - x[v.p[0]], x[v.p[2]] - x[v.p[0]], x[v.p[3]] - x[v.p[0]]);
}

double volume_of(const VolumeElement& v, const std::vector<Vec3>& x) {
  return signed_volume(x[v.p[0]], x[v.p[1]], x[v.p[2]], x[v.p[3]]);
}

/// Element by element, by respond().
std::vector<Vec3> reference(const Shaken& s) {
  std::vector<Vec3> force(s.state.position.size());
  std::size_t relaxing = 0;
  for (std::size_t i = 0; i < s.share.size(); ++i) {
    const Spring& spring = s.model.network.springs[i];
    const SpringMotion& motion = s.model.springs[i];
    const double lost = motion.relaxes ? s.offset[relaxing++] : 0.0;
    const auto a = static_cast<std::size_t>(spring.a), b = static_cast<std::size_t>(spring.b);
    const Vec3 d = s.state.position[b] - s.state.position[a];
    const double l = length(d);
    if (s.share[i] == 0 || l == 0 || (motion.cutoff_mm > 0 && l > motion.cutoff_mm)) continue;
    const double rate = dot(s.state.velocity[b] - s.state.velocity[a], d) / l;
    const Vec3 pull = d / l * (s.share[i] * (respond(spring, l).tension + motion.viscosity * rate) - lost);
    force[a] += pull;
    force[b] -= pull;
  }
  for (const AreaElement& a : s.model.network.areas) {
    const TriangleShape shape =
        shape_of(s.state.position[a.p[0]], s.state.position[a.p[1]], s.state.position[a.p[2]]);
    for (std::size_t c = 0; c < 3; ++c)
      force[a.p[c]] -= area_gradient(shape.normal, shape.edge[c]) * respond(a, shape.area).stress;
  }
  for (const VolumeElement& v : s.model.network.volumes) {
    const double stress = respond(v, volume_of(v, s.state.position)).mean_stress;
    const auto gradient = gradient_of(v, s.state.position);
    for (std::size_t c = 0; c < 4; ++c) force[static_cast<std::size_t>(v.p[c])] -= gradient[c] * stress;
  }
  return force;
}

TEST(NetworkBlocks, GiveEveryMobilePointOnceTheForceOfItsElements) {
  const Shaken s = make_shaken(70);
  const auto& volumes = s.model.network.volumes;
  const auto guards = [&](const VolumeElement& v) {
    return v.inversion_guard_mpa > 0 &&
           volume_of(v, s.state.position) < VolumeElement::kGuardFrom * v.rest_volume_mm3;
  };
  EXPECT_GT(std::count_if(volumes.begin(), volumes.end(), guards), 10);
  const NetworkBlocks blocks(s.model, s.share);
  EXPECT_GT(blocks.count(), 4U);
  const Total t = total<Lanes>(blocks, s);
  const std::vector<Vec3> force = reference(s);
  for (std::size_t p = 0; p < force.size(); ++p) {
    EXPECT_EQ(t.visits[p], s.model.mobile[p]);
    if (s.model.mobile[p] != 0)
      EXPECT_LT(distance(t.force[p], force[p]), 1e-13 * (1 + length(force[p]))) << p;
  }
}

TEST(NetworkBlocks, LanesDoAsTheirScalarTwin) {
  const Shaken s = make_shaken(25);
  const NetworkBlocks blocks(s.model, s.share);
  const Total four = total<Lanes>(blocks, s), one = total<double>(blocks, s);
  for (std::size_t p = 0; p < four.force.size(); ++p) {
    EXPECT_LT(distance(four.force[p], one.force[p]), 1e-14 * (1 + length(one.force[p]))) << p;
    EXPECT_NEAR(four.stiffness[p], one.stiffness[p], 1e-13 * (1 + one.stiffness[p])) << p;
  }
}

TEST(NetworkBlocks, AskingForStiffnessLeavesForcesTheirBits) {
  const Shaken s = make_shaken(25);
  const NetworkBlocks blocks(s.model, s.share);
  EXPECT_TRUE((total<Lanes, Wants::forces>(blocks, s).force == total<Lanes>(blocks, s).force));
  EXPECT_TRUE((total<double, Wants::forces>(blocks, s).force == total<double>(blocks, s).force));
}

TEST(NetworkBlocks, TheStiffnessOfAVolumeBoundsItsCurvature) {
  // uᵀ K u ≤ Σ S |u|² for any u: K by differences of the forces of one element, turned, pressed and inverted.
  const RandomStream random(5);
  std::uint64_t k = 0;
  const auto vector = [&] { return Vec3{random.normal(k++), random.normal(k++), random.normal(k++)}; };
  double sharpest = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Shaken s;
    for (int c = 0; c < 4; ++c) s.state.position.push_back(vector());
    s.model.network.rest = s.state.position;
    s.model.network.volumes = {{{0, 1, 2, 3}, 0.2 + random.uniform(k++), 0.3, 0.2}};
    s.model.mobile.assign(4, 1);
    s.state.velocity.resize(4);
    const NetworkBlocks blocks(s.model, s.share);
    const Total here = total<Lanes>(blocks, s);
    std::vector<Vec3> u;
    for (int c = 0; c < 4; ++c) u.push_back(vector());
    if (trial % 2 == 0) {  // along the gradient, where it is stiffest
      const auto gradient = gradient_of(s.model.network.volumes[0], s.state.position);
      u.assign(gradient.begin(), gradient.end());
    }
    const double h = 1e-5;
    const auto moved = [&](double by) {
      Shaken there = s;
      for (std::size_t c = 0; c < 4; ++c) there.state.position[c] += u[c] * by;
      return total<Lanes>(blocks, there).force;
    };
    const auto ahead = moved(h), behind = moved(-h);
    double curvature = 0, bound = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      curvature += dot(u[c], behind[c] - ahead[c]) / (2 * h);
      bound += here.stiffness[c] * squared_length(u[c]);
    }
    EXPECT_LT(std::abs(curvature), bound * (1 + 1e-6)) << trial;
    sharpest = std::max(sharpest, curvature / bound);
  }
  EXPECT_GT(sharpest, 0.5);
}

TEST(NetworkBlocks, TheStiffnessOfAnAreaBoundsItsCurvature) {
  const RandomStream random(6);
  std::uint64_t k = 0;
  const auto vector = [&] { return Vec3{random.normal(k++), random.normal(k++), random.normal(k++)}; };
  double sharpest = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Shaken s;
    std::vector<Vec3> u;
    for (int c = 0; c < 3; ++c) s.state.position.push_back(vector()), u.push_back(vector());
    s.model.network.rest = s.state.position;
    s.model.network.areas = {{{0, 1, 2}, 0.2 + random.uniform(k++), 0.3}};
    s.model.mobile.assign(3, 1);
    s.state.velocity.resize(3);
    const NetworkBlocks blocks(s.model, s.share);
    const Total here = total<Lanes>(blocks, s);
    if (trial % 2 == 0) u = here.force;
    const double h = 1e-5;
    const auto moved = [&](double by) {
      Shaken there = s;
      for (std::size_t c = 0; c < 3; ++c) there.state.position[c] += u[c] * by;
      return total<Lanes>(blocks, there).force;
    };
    const auto ahead = moved(h), behind = moved(-h);
    double curvature = 0, bound = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      curvature += dot(u[c], behind[c] - ahead[c]) / (2 * h);
      bound += here.stiffness[c] * squared_length(u[c]);
    }
    EXPECT_LT(std::abs(curvature), bound * (1 + 1e-6)) << trial;
    sharpest = std::max(sharpest, curvature / bound);
  }
  EXPECT_GT(sharpest, 0.4);
}

TEST(NetworkBlocks, CountACoincidentSpringOnce) {
  Shaken s = make_shaken(60);
  // Over the whole sheet, so that springs between blocks are among them; fixed ends too.
  std::vector<char> used(s.state.position.size(), 0);
  int expected = 0;
  for (std::size_t i = 0; i < s.share.size(); i += 7) {
    const Spring& spring = s.model.network.springs[i];
    const auto a = static_cast<std::size_t>(spring.a), b = static_cast<std::size_t>(spring.b);
    if (used[a] || used[b] || s.share[i] == 0) continue;
    used[a] = used[b] = 1;
    s.state.position[b] = s.state.position[a];
    ++expected;
  }
  EXPECT_GT(expected, 500);
  const NetworkBlocks blocks(s.model, s.share);
  EXPECT_EQ(total<Lanes>(blocks, s).coincident, expected);
  EXPECT_EQ(total<double>(blocks, s).coincident, expected);
}

TEST(NetworkBlocks, ANewRestLengthActsOnBothEndsOfASpringBetweenBlocks) {
  Shaken s = make_shaken(50);
  NetworkBlocks blocks(s.model, s.share);
  for (std::size_t i = 0; i < s.share.size(); ++i) {
    Spring& spring = s.model.network.springs[i];
    spring.rest_length_mm *= 0.9;
    blocks.set_rest_length(static_cast<int>(i), spring.rest_length_mm);
  }
  const Total t = total<Lanes>(blocks, s);
  const std::vector<Vec3> force = reference(s);
  for (std::size_t p = 0; p < force.size(); ++p)
    if (s.model.mobile[p] != 0)
      EXPECT_LT(distance(t.force[p], force[p]), 1e-13 * (1 + length(force[p]))) << p;
}

TEST(NetworkBlocks, AHubWithSpringsToAllPointsIsNoTrouble) {
  Shaken s;
  auto& net = s.model.network;
  const RandomStream random(2);
  for (std::size_t i = 0; i < 9000; ++i)
    net.rest.push_back(Vec3{random.normal(3 * i), random.normal(3 * i + 1), random.normal(3 * i + 2)} * 10.0);
  net.mass_g.assign(9000, 1);
  for (int i = 1; i < 9000; ++i)
    net.springs.push_back({0, i, 5.0, 0.3, SpringLaw::linear, SpringKind::fibre});
  s.model.springs.assign(net.springs.size(), {});
  s.share.assign(net.springs.size(), 0.5);
  s.state = {net.rest, std::vector<Vec3>(9000), 0, {}};
  s.model.mobile.assign(9000, 1);
  const NetworkBlocks blocks(s.model, s.share);
  const Total t = total<Lanes>(blocks, s);
  const std::vector<Vec3> force = reference(s);
  for (std::size_t p = 0; p < force.size(); ++p)
    EXPECT_LT(distance(t.force[p], force[p]), 1e-11 * (1 + length(force[p]))) << p;
}

}  // namespace
}  // namespace turgor
