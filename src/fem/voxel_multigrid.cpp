#include "fem/voxel_multigrid.hpp"

#include <Eigen/SparseCholesky>
#include <algorithm>

#include "turgor/core/index.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor::detail {
namespace {

// Values of a level that is solved directly.
constexpr std::size_t kDirectUnknowns = 900;
// Stiffness added to the coarsest level's diagonal, relative to it: coarse functions of which little is left
// beside what is held need not be independent.
constexpr double kShift = 1e-12;
// Smoothing steps of each level below the first coarse one for each of the one above, and at most. Coarse
// cells that the boundary cuts are stiffer than what they stand for, and the more levels there are the more
// that adds up; coarse work costs little, an eighth from level to level.
constexpr int kFactor = 2, kMostSteps = 200;

std::size_t active_values(const VoxelLevel& level) {
  return level.scaling.size() -
         static_cast<std::size_t>(std::count(level.scaling.begin(), level.scaling.end(), 0.0F));
}

}  // namespace

struct VoxelMultigrid::Coarsest {
  std::vector<std::size_t> values;  // of each unknown
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors;
};

VoxelMultigrid::VoxelMultigrid() : coarsest_(std::make_unique<Coarsest>()) {}
VoxelMultigrid::VoxelMultigrid(VoxelMultigrid&&) noexcept = default;
VoxelMultigrid& VoxelMultigrid::operator=(VoxelMultigrid&&) noexcept = default;
VoxelMultigrid::~VoxelMultigrid() = default;

Result<VoxelMultigrid> VoxelMultigrid::build(std::unique_ptr<VoxelLevel> finest,
                                             const std::vector<std::uint8_t>& held, Smoothing smoothing,
                                             const Context& context) {
  VoxelMultigrid m;
  m.smoothing_ = smoothing;
  m.levels_.push_back(std::move(finest));
  for (;;) {
    TURGOR_CHECK(context.check());
    VoxelLevel& fine = *m.levels_.back();
    const Index3& n = fine.rows.cells;
    if (active_values(fine) <= kDirectUnknowns || std::max({n[0], n[1], n[2]}) <= 1) break;
    const bool finest_of_all = m.levels_.size() == 1;
    m.levels_.push_back(coarser(fine, finest_of_all ? held : std::vector<std::uint8_t>{}));
  }
  if (!m.factor_coarsest())
    return Error{ErrorKind::internal, "the coarsest lattice has no stiffness", "multigrid", ""};
  return m;
}

bool VoxelMultigrid::factor_coarsest() {
  const VoxelLevel& level = *levels_.back();
  std::vector<int> number(level.rows.values(), -1);
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (level.scaling[i] == 0) continue;
    number[i] = static_cast<int>(coarsest_->values.size());
    coarsest_->values.push_back(i);
  }
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](const std::array<NodePlace, 8>& corners, auto&& value) {
    const auto unknowns = unknowns_of(corners);
    for (std::size_t a = 0; a < kCubeUnknowns; ++a) {
      for (std::size_t b = 0; b < kCubeUnknowns; ++b) {
        const int row = number[unknowns[a]], column = number[unknowns[b]];
        if (row < column || column < 0) continue;
        entries.emplace_back(row, column, value(kCubeUnknowns * a + b) * (a == b ? 1 + kShift : 1));
      }
    }
  };
  const CubeMatrix shear = matrix_of(level.stiffness.shear), bulk = matrix_of(level.stiffness.bulk);
  for (int k = 0; k < level.rows.cells[2]; ++k) {
    for (int j = 0; j < level.rows.cells[1]; ++j) {
      const CellRow& row = level.rows.cell_row(j, k);
      for (int i = row.first; i < row.end; ++i) {
        const std::size_t cell = level.rows.cell(i, j, k);
        if (!level.regular(cell)) continue;
        const double mu = level.shear[cell], kappa = level.bulk[cell];
        add(level.rows.corners(i, j, k), [&](std::size_t e) { return mu * shear[e] + kappa * bulk[e]; });
      }
    }
  }
  for (const DenseCell& cell : level.dense.cells) {
    const double* matrix = level.dense.matrix(cell.matrix);
    add(cell.corners, [&](std::size_t e) { return matrix[e]; });
  }
  for (const NodePlane& p : level.planes) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        const int row = number[p.node.component(a)], column = number[p.node.component(b)];
        if (row >= column && column >= 0)
          entries.emplace_back(
              row, column, static_cast<double>(p.stiffness) * static_cast<double>(p.normal[a] * p.normal[b]));
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(coarsest_->values.size());
  if (n == 0) return true;
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  coarsest_->factors.compute(matrix);
  return coarsest_->factors.info() == Eigen::Success;
}

VoxelMultigrid::Work::Work(const VoxelMultigrid& multigrid) {
  for (const auto& level : multigrid.levels_) {
    const std::size_t n = level->rows.values();
    levels_.push_back(
        {std::vector<float>(n), std::vector<float>(n), std::vector<float>(n), std::vector<float>(n)});
  }
  planes_ = multigrid.levels_.front()->planes;
}

namespace {

// One step of the smoother over some values: the last step is taken off the residual, the next one added to
// the result.
void advance(float keep, float add, std::size_t count, const float* __restrict image,
             const float* __restrict scaling, float* __restrict residual, float* __restrict step,
             float* __restrict result) {
  for (std::size_t i = 0; i < count; ++i) {
    const float r = residual[i] - image[i], s = keep * step[i] + add * scaling[i] * r;
    residual[i] = r, step[i] = s, result[i] += s;
  }
}

}  // namespace

int VoxelMultigrid::steps_of(std::size_t number) const {
  int steps = smoothing_.steps;
  for (std::size_t n = 0; n < number && steps < kMostSteps; ++n)
    steps *= n == 0 ? smoothing_.first_factor : kFactor;
  return number == 0 ? steps : std::min(steps, kMostSteps);
}

// Chebyshev polynomials of the fourth kind (Lottes 2023, "Optimal polynomial smoothers for multigrid
// V-cycles", algorithm 3). From zero: result = p(K) residual, and the residual is that of it, zero where
// held. Otherwise `step` is what has just been added to the result; the residual is left as it was before the
// last step.
void VoxelMultigrid::smooth(std::size_t number, std::span<const NodePlane> on, Work::Vectors& v,
                            bool from_zero) const {
  const VoxelLevel& level = *levels_[number];
  float *residual = v.residual.data(), *result = v.result.data(), *step = v.step.data();
  float* image = v.image.data();
  const float* scaling = level.scaling.data();
  const double largest = level.largest_eigenvalue;
  const auto first = static_cast<float>(4 / (3 * largest));
  const auto advance_all = [&](float keep, float add) {
    level.apply(on, step, image, [=](std::size_t, std::size_t begin, std::size_t end) {
      advance(keep, add, end - begin, image + begin, scaling + begin, residual + begin, step + begin,
              result + begin);
    });
  };
  if (from_zero) {
    const std::vector<std::size_t>& planes = level.rows.planes;
    parallel_for(planes.size() - 1, at(level.rows.slab), [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = planes[begin]; i < planes[end]; ++i)
        result[i] = step[i] = first * scaling[i] * residual[i];
    });
  } else {
    advance_all(0, first);
  }
  const int steps = steps_of(number);
  for (int n = 1; n < steps; ++n) {
    advance_all(static_cast<float>((2.0 * n - 1) / (2.0 * n + 3)),
                static_cast<float>((8.0 * n + 4) / ((2.0 * n + 3) * largest)));
  }
  if (!from_zero) return;
  level.apply(on, step, image, [=](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) residual[i] = scaling[i] != 0 ? residual[i] - image[i] : 0.0F;
  });
}

void VoxelMultigrid::cycle(Work& work, std::size_t number) const {
  const VoxelLevel& level = *levels_[number];
  Work::Vectors& v = work.levels_[number];
  if (number + 1 == levels_.size()) {
    const auto n = static_cast<Eigen::Index>(coarsest_->values.size());
    Eigen::VectorXd b(n);
    for (Eigen::Index i = 0; i < n; ++i) b[i] = v.residual[coarsest_->values[static_cast<std::size_t>(i)]];
    if (n > 0) b = coarsest_->factors.solve(b);
    std::fill(v.result.begin(), v.result.end(), 0.0F);
    for (Eigen::Index i = 0; i < n; ++i)
      v.result[coarsest_->values[static_cast<std::size_t>(i)]] = static_cast<float>(b[i]);
    return;
  }
  const std::span<const NodePlane> on = number == 0 ? work.planes_ : std::span<const NodePlane>{};
  smooth(number, on, v, true);
  Work::Vectors& below = work.levels_[number + 1];
  restrict_values(level, v.residual.data(), *levels_[number + 1], below.residual.data());
  cycle(work, number + 1);
  prolong_values(*levels_[number + 1], below.result.data(), level, v.step.data());
  const std::vector<std::size_t>& planes = level.rows.planes;
  project(on, v.step.data());
  parallel_for(planes.size() - 1, static_cast<std::size_t>(level.rows.slab),
               [&](std::size_t begin, std::size_t end) {
                 for (std::size_t i = planes[begin]; i < planes[end]; ++i) v.result[i] += v.step[i];
               });
  smooth(number, on, v, false);
}

}  // namespace turgor::detail
