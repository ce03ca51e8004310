#include "fem/voxel_level.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

#include "turgor/core/parallel.hpp"
#include "turgor/core/random.hpp"

namespace turgor::detail {
namespace {

constexpr int kLanczosSteps = 12;
// Lanczos' estimate comes from below.
constexpr double kEigenvalueMargin = 1.05;

// The largest eigenvalue of scaling · stiffness, by the coefficients of conjugate gradients (Lanczos).
double largest_eigenvalue(const VoxelLevel& level) {
  const std::size_t n = level.rows.values(), planes = level.rows.planes.size() - 1;
  std::vector<float> r(n), p(n, 0.0F), y(n);
  std::vector<double> parts(planes);
  const RandomStream random(1);
  parallel_for(planes, 1, [&](std::size_t k, std::size_t) {
    for (std::size_t i = level.rows.planes[k]; i < level.rows.planes[k + 1]; ++i)
      r[i] = level.scaling[i] == 0 ? 0.0F : static_cast<float>(random.uniform(i) - 0.5);
    project(planes_in(level.planes, level.rows.planes[k], level.rows.planes[k + 1]), r.data());
  });
  const auto total = [&] {
    double sum = 0;
    for (const double part : parts) sum += part;
    return sum;
  };
  const auto square = [&] {
    parallel_for(planes, 1, [&](std::size_t k, std::size_t) {
      double sum = 0;
      for (std::size_t i = level.rows.planes[k]; i < level.rows.planes[k + 1]; ++i)
        sum += static_cast<double>(r[i] * level.scaling[i]) * static_cast<double>(r[i]);
      parts[k] = sum;
    });
    return total();
  };
  std::vector<double> diagonal, beside;
  double rho = square(), beta = 0, alpha_before = 1;
  for (int step = 0; step < kLanczosSteps && rho > 0; ++step) {
    const auto b = static_cast<float>(beta);
    parallel_for(planes, 1, [&](std::size_t k, std::size_t) {
      for (std::size_t i = level.rows.planes[k]; i < level.rows.planes[k + 1]; ++i)
        p[i] = r[i] * level.scaling[i] + b * p[i];
    });
    level.apply(level.planes, p.data(), y.data(), [&](std::size_t k, std::size_t begin, std::size_t end) {
      double sum = 0;
      for (std::size_t i = begin; i < end; ++i) sum += static_cast<double>(p[i]) * static_cast<double>(y[i]);
      parts[k] = sum;
    });
    const double curvature = total();
    if (!(curvature > 0)) break;
    const double alpha = rho / curvature;
    diagonal.push_back(1 / alpha + (step > 0 ? beta / alpha_before : 0));
    const auto a = static_cast<float>(alpha);
    parallel_for(planes, 1, [&](std::size_t k, std::size_t) {
      for (std::size_t i = level.rows.planes[k]; i < level.rows.planes[k + 1]; ++i)
        r[i] = level.scaling[i] == 0 ? 0.0F : r[i] - a * y[i];
    });
    const double next = square();
    beta = next / rho, alpha_before = alpha, rho = next;
    beside.push_back(std::sqrt(beta) / alpha);
  }
  if (diagonal.empty()) return 1;
  const auto m = static_cast<Eigen::Index>(diagonal.size());
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    t(i, i) = diagonal[static_cast<std::size_t>(i)];
    if (i + 1 < m) t(i, i + 1) = t(i + 1, i) = beside[static_cast<std::size_t>(i)];
  }
  return kEigenvalueMargin *
         Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(t, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
}

double diagonal_of(const CubeModes<double>& modes) {
  return matrix_of(modes)[0];
}

}  // namespace

std::array<std::size_t, kCubeUnknowns> unknowns_of(const std::array<NodePlace, 8>& corners) {
  std::array<std::size_t, kCubeUnknowns> out{};
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t corner = 0; corner < 8; ++corner) out[8 * c + corner] = corners[corner].component(c);
  return out;
}

void VoxelLevel::apply(std::span<const NodePlane> on, const float* in, float* out,
                       const PlaneDone& done) const {
  if (on.empty()) return stiffness_operator->apply(in, out, done);
  stiffness_operator->apply(in, out, [&](std::size_t plane, std::size_t begin, std::size_t end) {
    for (const NodePlane& p : planes_in(on, begin, end)) {
      const float resisted = p.holds ? -along_normal(p, out) : p.stiffness * along_normal(p, in);
      add_along_normal(p, resisted, out);
    }
    done(plane, begin, end);
  });
}

void VoxelLevel::finish(const std::vector<std::uint8_t>& held) {
  std::vector<float>& diagonal = scaling;
  diagonal.assign(rows.values(), 0.0F);
  const double of_shear = diagonal_of(stiffness.shear), of_bulk = diagonal_of(stiffness.bulk);
  for (int k = 0; k < rows.cells[2]; ++k) {
    for (int j = 0; j < rows.cells[1]; ++j) {
      const CellRow& row = rows.cell_row(j, k);
      for (int i = row.first; i < row.end; ++i) {
        const std::size_t cell = row.offset + static_cast<std::size_t>(i - row.first);
        if (!regular(cell)) continue;
        const auto d = static_cast<float>(of_shear * static_cast<double>(shear[cell]) +
                                          of_bulk * static_cast<double>(bulk[cell]));
        for (const std::size_t u : unknowns_of(rows.corners(i, j, k))) diagonal[u] += d;
      }
    }
  }
  for (const DenseCell& cell : dense.cells) {
    const double* matrix = dense.matrix(cell.matrix);
    const auto u = unknowns_of(cell.corners);
    for (std::size_t a = 0; a < kCubeUnknowns; ++a)
      diagonal[u[a]] += static_cast<float>(matrix[(kCubeUnknowns + 1) * a]);
  }
  plane_of.assign(planes.empty() ? 0 : rows.values(), -1);
  for (std::size_t p = 0; p < planes.size(); ++p) {
    plane_of[planes[p].node.value] = static_cast<int>(p);
    for (std::size_t c = 0; c < 3 && !planes[p].holds; ++c)
      diagonal[planes[p].node.component(c)] +=
          planes[p].stiffness * planes[p].normal[c] * planes[p].normal[c];
  }
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    const bool out = !(diagonal[i] > 0) || (!held.empty() && held[i] != 0);
    scaling[i] = out ? 0.0F : 1.0F / diagonal[i];
  }
  if (!dense.cells.empty()) dense_blocks = std::make_unique<DenseBlocks>(dense);
  stiffness_operator =
      std::make_unique<VoxelOperator<float>>(rows, stiffness, shear, bulk, dense_blocks.get());
  largest_eigenvalue = detail::largest_eigenvalue(*this);
}

namespace {

// line[x − first] += weight · row's component, for the nodes that both have.
void add_line(const NodeRow& row, const float* values, int component, float weight, int first,
              std::vector<float>& line) {
  const int begin = std::max(first, row.first);
  const int end = std::min(first + static_cast<int>(line.size()), row.first + row.count);
  const float* from =
      values + row.offset + static_cast<std::size_t>(component) * static_cast<std::size_t>(row.count);
  for (int x = begin; x < end; ++x) line[static_cast<std::size_t>(x - first)] += weight * from[x - row.first];
}

void clear_after_rows(const VoxelRows& rows, int plane, float* values) {
  const auto k = static_cast<std::size_t>(plane);
  std::fill(values + rows.extras[k], values + rows.planes[k + 1], 0.0F);
}

}  // namespace

void restrict_values(const VoxelLevel& fine, float* from, const VoxelLevel& coarse, float* to) {
  const Index3 &n = fine.rows.cells, &m = coarse.rows.cells;
  // Odd nodes are left out of the rows, and given back when they have gone where they belong.
  std::vector<float> aside(3 * fine.odd_nodes.size());
  for (std::size_t e = 0; e < aside.size(); ++e)
    aside[e] = std::exchange(from[fine.odd_nodes[e / 3].node.component(e % 3)], 0.0F);
  parallel_for(static_cast<std::size_t>(m[2]) + 1, 2, [&](std::size_t begin, std::size_t end) {
    std::vector<float> line;
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j <= m[1]; ++j) {
        const NodeRow& row = coarse.rows.node_row(j, k);
        for (int c = 0; c < 3 && row.count > 0; ++c) {
          line.assign(2 * static_cast<std::size_t>(row.count) + 1, 0.0F);
          for (int z = std::max(0, 2 * k - 1); z <= std::min(n[2], 2 * k + 1); ++z) {
            for (int y = std::max(0, 2 * j - 1); y <= std::min(n[1], 2 * j + 1); ++y) {
              const float weight = (z == 2 * k ? 1.0F : 0.5F) * (y == 2 * j ? 1.0F : 0.5F);
              add_line(fine.rows.node_row(y, z), from, c, weight, 2 * row.first - 1, line);
            }
          }
          float* out = to + row.offset + static_cast<std::size_t>(c) * static_cast<std::size_t>(row.count);
          for (std::size_t x = 0; x < static_cast<std::size_t>(row.count); ++x)
            out[x] = line[2 * x + 1] + 0.5F * (line[2 * x] + line[2 * x + 2]);
        }
      }
      clear_after_rows(coarse.rows, k, to);
    }
  });
  for (std::size_t o = 0; o < fine.odd_nodes.size(); ++o) {
    const OddNode& odd = fine.odd_nodes[o];
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = aside[3 * o + c];
      from[odd.node.component(c)] = value;
      for (int w = 0; w < odd.count; ++w) {
        const auto e = static_cast<std::size_t>(w);
        to[odd.coarse[e].component(c)] += odd.weight[e] * value;
      }
    }
  }
}

void prolong_values(const VoxelLevel& coarse, const float* from, const VoxelLevel& fine, float* to) {
  const Index3& n = fine.rows.cells;
  parallel_for(static_cast<std::size_t>(n[2]) + 1, 2, [&](std::size_t begin, std::size_t end) {
    std::vector<float> line;
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j <= n[1]; ++j) {
        const NodeRow& row = fine.rows.node_row(j, k);
        for (int c = 0; c < 3 && row.count > 0; ++c) {
          line.assign(static_cast<std::size_t>(row.count) / 2 + 1, 0.0F);
          for (int z = k / 2; z <= (k + 1) / 2; ++z) {
            for (int y = j / 2; y <= (j + 1) / 2; ++y) {
              const float weight = (k % 2 == 0 ? 1.0F : 0.5F) * (j % 2 == 0 ? 1.0F : 0.5F);
              add_line(coarse.rows.node_row(y, z), from, c, weight, row.first / 2, line);
            }
          }
          const std::size_t start =
              row.offset + static_cast<std::size_t>(c) * static_cast<std::size_t>(row.count);
          const float* scale = fine.scaling.data() + start;
          float* out = to + start;
          for (std::size_t x = 0; 2 * x < static_cast<std::size_t>(row.count); ++x) {
            out[2 * x] = scale[2 * x] != 0 ? line[x] : 0.0F;
            out[2 * x + 1] = scale[2 * x + 1] != 0 ? 0.5F * (line[x] + line[x + 1]) : 0.0F;
          }
        }
      }
      clear_after_rows(fine.rows, k, to);
    }
  });
  for (const OddNode& odd : fine.odd_nodes) {
    for (std::size_t c = 0; c < 3; ++c) {
      float value = 0;
      for (int w = 0; w < odd.count; ++w) {
        const auto e = static_cast<std::size_t>(w);
        value += odd.weight[e] * from[odd.coarse[e].component(c)];
      }
      const std::size_t i = odd.node.component(c);
      to[i] = fine.scaling[i] != 0 ? value : 0.0F;
    }
  }
}

}  // namespace turgor::detail
