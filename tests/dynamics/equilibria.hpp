// Networks at rest by the solver, and by a dense solver of its own.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <vector>

#include "support/largest_distance.hpp"
#include "turgor/dynamics/equilibrium.hpp"
#include "turgor/tissue/network_energy.hpp"

namespace turgor {

using support::largest_distance;

inline SpringNetwork points_without_springs(std::vector<Vec3> points) {
  SpringNetwork net;
  net.rest = std::move(points);
  net.mass_g.assign(net.rest.size(), 1);
  return net;
}

inline void join(SpringNetwork& net, int a, int b, double k, SpringLaw law = SpringLaw::linear) {
  net.springs.push_back({a, b, distance(net.rest[a], net.rest[b]), k, law, SpringKind::membrane});
}

inline EquilibriumResult solved(const SpringNetwork& net, const PrescribedMotion& motion,
                                EquilibriumOptions options = {}, const std::vector<Vec3>* start = nullptr) {
  Context context;
  const auto result = solve_equilibrium(net, motion, options, context, start);
  EXPECT_TRUE(static_cast<bool>(result)) << (result ? "" : result.error().message());
  return result ? *result : EquilibriumResult{};
}

inline EquilibriumOptions sharp() {
  EquilibriumOptions options;
  options.relative_residual = 1e-11;
  return options;
}

// Newton's method on the dense Hessian by Eigen's LDLT, from the same start, with nothing of the solver in it
// but the elements' own blocks.
inline std::vector<Vec3> dense_newton(const SpringNetwork& net, const PrescribedMotion& motion) {
  const NetworkEnergy energy = *NetworkEnergy::prepare(net);
  std::vector<int> column(net.rest.size(), 0);
  std::vector<Vec3> x = net.rest;
  for (std::size_t i = 0; i < motion.moved.size(); ++i) {
    column[motion.moved[i]] = -1;
    x[motion.moved[i]] = motion.positions[i];
  }
  for (const int f : motion.fixed) column[f] = -1;
  int unknowns = 0;
  for (int& c : column) c = c < 0 ? -1 : 3 * unknowns++;
  NetworkEnergy::Workspace workspace;
  std::vector<Vec3> f(x.size());
  for (int step = 0; step < 300; ++step) {
    const double before = energy.forces(x, f, workspace);
    Eigen::VectorXd force(3 * unknowns);
    Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(3 * unknowns, 3 * unknowns);
    for (std::size_t i = 0; i < x.size(); ++i) {
      for (int k = 0; k < 3 && column[i] >= 0; ++k) force[column[i] + k] = f[i][k];
    }
    if (force.norm() < 1e-12) break;
    ElementStiffness k;
    energy.linearise(x, 0.0, k);
    const auto add = [&](int a, int b, const Mat3& block, double sign) {
      if (column[a] < 0 || column[b] < 0) return;
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c)
          hessian(column[a] + r, column[b] + c) += sign * block.c[static_cast<std::size_t>(c)][r];
      }
    };
    for (std::size_t s = 0; s < k.springs.size(); ++s) {
      const auto& [a, b] = energy.spring_ends()[s];
      Mat3 block;
      for (int c = 0; c < 3; ++c) {
        for (int r = 0; r < 3; ++r) {
          const Vec3& n = k.springs[s].direction;
          block.c[static_cast<std::size_t>(c)][r] =
              (k.springs[s].axial - k.springs[s].transverse) * n[r] * n[c] +
              (r == c ? k.springs[s].transverse : 0);
        }
      }
      add(a, a, block, 1), add(b, b, block, 1), add(a, b, block, -1), add(b, a, block, -1);
    }
    for (std::size_t v = 0; v < k.volumes.size(); ++v) {
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          add(energy.volume_corners()[v].p[a], energy.volume_corners()[v].p[b],
              volume_block(k.volumes[v], a, b, 0.0), 1);
        }
      }
    }
    for (std::size_t t = 0; t < k.areas.size(); ++t) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          add(energy.area_corners()[t].p[a], energy.area_corners()[t].p[b], area_block(k.areas[t], a, b, 0.0),
              1);
        }
      }
    }
    Eigen::VectorXd d;
    for (double shift = 0;; shift = std::max(10 * shift, 1e-3)) {  // until the factor is positive definite
      const Eigen::LDLT<Eigen::MatrixXd> factor(
          hessian + shift * Eigen::MatrixXd::Identity(3 * unknowns, 3 * unknowns));
      d = factor.solve(force);
      if (factor.isPositive() && d.dot(force) > 0) break;
    }
    std::vector<Vec3> y;
    double t = 1;
    for (; t > 1e-8; t *= 0.5) {
      y = x;
      for (std::size_t i = 0; i < y.size(); ++i) {
        for (int c = 0; c < 3 && column[i] >= 0; ++c) y[i][c] += t * d[column[i] + c];
      }
      if (energy.value(y) <= before * (1 + 1e-14)) break;
    }
    x = y;
  }
  return x;
}

}  // namespace turgor
