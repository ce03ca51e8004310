#include "dynamics/block_cg.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "math/lanes.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr int kSize = BlockCg::kClusterSize, kBlock = kSize * kSize;
constexpr int kClustersPerDomain = 700, kMaxDomains = 8;
constexpr std::size_t kClusterGrain = 64;
constexpr int kCancelInterval = 16;
// Stiffness relative to a cluster's own that is added everywhere. A point on a single spring has a singular
// block; no force acts in its free directions, so a trifle of stiffness there changes nothing. It also covers
// the rounding of the blocks to single precision.
constexpr double kTrifle = 1e-6;

// Twelve numbers, those of a cluster.
struct Twelve {
  Lanes a, b, c;

  static Twelve load(const double* from) {
    return {load_lanes(from), load_lanes(from + 4), load_lanes(from + 8)};
  }
  void store(double* to) const { store_lanes(to, a), store_lanes(to + 4, b), store_lanes(to + 8, c); }
  friend Twelve operator+(Twelve x, const Twelve& y) { return {x.a + y.a, x.b + y.b, x.c + y.c}; }
  friend Twelve operator-(Twelve x, const Twelve& y) { return {x.a - y.a, x.b - y.b, x.c - y.c}; }
  friend Twelve operator*(Twelve x, double s) { return {x.a * s, x.b * s, x.c * s}; }
};

Lanes widen(const float* from) {
  using Floats = float __attribute__((vector_size(16)));
  Floats f;
  std::memcpy(&f, from, sizeof f);
  return __builtin_convertvector(f, Lanes);
}

// block · v.
Twelve block_times(const float* block, const double* v) {
  Twelve even{}, odd{};
  for (int k = 0; k < kSize; k += 2) {
    const float *p = block + kSize * k, *q = p + kSize;
    even = even + Twelve{widen(p), widen(p + 4), widen(p + 8)} * v[k];
    odd = odd + Twelve{widen(q), widen(q + 4), widen(q + 8)} * v[k + 1];
  }
  return even + odd;
}

double inner(const Twelve& x, const Twelve& y) {
  const Lanes p = (x.a * y.a + x.b * y.b) + x.c * y.c;
  return (p[0] + p[1]) + (p[2] + p[3]);
}

// C of block = C Cᵀ in the lower triangle; false where the block is not positive definite.
bool cholesky(std::array<double, kBlock>& block) {
  for (int j = 0; j < kSize; ++j) {
    double* column = &block[static_cast<std::size_t>(kSize * j)];
    for (int k = 0; k < j; ++k) {
      const double* done = &block[static_cast<std::size_t>(kSize * k)];
      for (int i = j; i < kSize; ++i) column[i] -= done[i] * done[j];
    }
    if (!(column[j] > 0)) return false;
    const double inverse = 1 / std::sqrt(column[j]);
    for (int i = j; i < kSize; ++i) column[i] *= inverse;
  }
  return true;
}

// The inverse of the lower triangle C, zero above its diagonal.
std::array<double, kBlock> inverse_of_lower(const std::array<double, kBlock>& c) {
  const auto at = [](int row, int column) { return static_cast<std::size_t>(kSize * column + row); };
  std::array<double, kBlock> w{};
  for (int j = 0; j < kSize; ++j) {
    w[at(j, j)] = 1 / c[at(j, j)];
    for (int i = j + 1; i < kSize; ++i) {
      double sum = 0;
      for (int k = j; k < i; ++k) sum -= c[at(i, k)] * w[at(k, j)];
      w[at(i, j)] = sum / c[at(i, i)];
    }
  }
  return w;
}

}  // namespace

BlockCg::BlockCg(const StiffnessMatrix& matrix, std::vector<int> cluster_offsets)
    : cluster_offsets_(std::move(cluster_offsets)), cluster_of_row_(static_cast<std::size_t>(matrix.rows())) {
  for (int c = 0; c < clusters(); ++c) {
    std::fill(cluster_of_row_.begin() + cluster_offsets_[c],
              cluster_of_row_.begin() + cluster_offsets_[c + 1], c);
  }
  make_domains();
  const auto same_domain = [this](int c, int d) { return domain_of_cluster_[c] == domain_of_cluster_[d]; };
  upper_.descending = true;
  make_part(matrix, lower_, [&](int c, int other) { return other < c && same_domain(c, other); });
  make_part(matrix, upper_, [&](int c, int other) { return other > c && same_domain(c, other); });
  make_part(matrix, outer_, [&](int c, int other) { return !same_domain(c, other); });
  const auto n = static_cast<std::size_t>(clusters());
  inverse_factors_.resize(n);
  for (auto* v : {&residual_, &direction_, &solved_, &image_, &solution_}) v->resize(kSize * n);
}

void BlockCg::make_domains() {
  const int domains = std::clamp(clusters() / kClustersPerDomain, 1, kMaxDomains);
  for (int d = 0; d <= domains; ++d) {
    bounds_.push_back(static_cast<int>(static_cast<std::int64_t>(clusters()) * d / domains));
  }
  domain_of_cluster_.resize(static_cast<std::size_t>(clusters()));
  for (int d = 0; d < domains; ++d) {
    std::fill(domain_of_cluster_.begin() + bounds_[d], domain_of_cluster_.begin() + bounds_[d + 1], d);
  }
}

// The pairs (cluster, other) that belong to a part, ascending by the other, with the matrix blocks that each
// gathers.
template <class Belongs>
void BlockCg::make_part(const StiffnessMatrix& matrix, Part& part, Belongs&& belongs) {
  part.clusters = clusters();
  part.offsets.assign(1, 0);
  std::vector<std::pair<int, Entry>> row;
  for (int r = 0; r < clusters(); ++r) {
    const int c = part.row(r);
    row.clear();
    for (int i = cluster_offsets_[c]; i < cluster_offsets_[c + 1]; ++i) {
      for (int k = matrix.offsets()[i]; k < matrix.offsets()[i + 1]; ++k) {
        const int j = matrix.columns()[k], other = cluster_of_row_[j];
        if (other == c || !belongs(c, other)) continue;
        row.push_back({other,
                       {k, static_cast<std::int16_t>(i - cluster_offsets_[c]),
                        static_cast<std::int16_t>(j - cluster_offsets_[other])}});
      }
    }
    std::stable_sort(row.begin(), row.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    for (std::size_t e = 0; e < row.size(); ++e) {
      if (e == 0 || row[e - 1].first != row[e].first) {
        part.columns.push_back(row[e].first);
        part.entry_offsets.push_back(static_cast<int>(entries_.size()));
      }
      entries_.push_back(row[e].second);
    }
    part.offsets.push_back(static_cast<int>(part.columns.size()));
  }
  part.entry_offsets.push_back(static_cast<int>(entries_.size()));
  part.blocks.resize(kBlock * part.columns.size());
}

bool BlockCg::factor(const StiffnessMatrix& matrix, double damping,
                     std::span<const CoupledStiffness> coupled) {
  const auto n = static_cast<std::size_t>(clusters());
  double mean = 0;
  for (int i = 0; i < matrix.rows(); ++i) {
    const Mat3& d = matrix.blocks()[matrix.diagonal()[i]];
    mean += (d.c[0].x + d.c[1].y + d.c[2].z) / (3.0 * matrix.rows());
  }
  const int indefinite = parallel_reduce<int>(
      n, kClusterGrain, 0,
      [&](std::size_t begin, std::size_t end) {
        int count = 0;
        for (std::size_t c = begin; c < end; ++c)
          count += !factor_cluster(matrix, static_cast<int>(c), damping * mean);
        return count;
      },
      std::plus<>());
  if (indefinite > 0) return false;
  parallel_for(n, kClusterGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c < end; ++c) {
      for (Part* part : {&lower_, &upper_, &outer_}) scale_row(matrix, *part, static_cast<int>(c));
    }
  });
  couple(coupled);
  return true;
}

void BlockCg::couple(std::span<const CoupledStiffness> coupled) {
  couplings_.clear();
  coupled_stiffness_.clear();
  coupled_force_.resize(coupled.size());
  for (std::size_t term = 0; term < coupled.size(); ++term) {
    coupled_stiffness_.push_back(coupled[term].stiffness);
    for (std::size_t i = 0; i < coupled[term].rows.size(); ++i) {
      const int row = coupled[term].rows[i], cluster = cluster_of_row_[row];
      const int first = 3 * (row - cluster_offsets_[cluster]);
      couplings_.push_back({cluster, static_cast<int>(term), {}});
      for (int k = 0; k < 3 * kSize; ++k) {
        couplings_.back().columns[static_cast<std::size_t>(k)] =
            coupled[term].weights[i] *
            inverse_factors_[static_cast<std::size_t>(cluster)][static_cast<std::size_t>(kSize * first + k)];
      }
    }
  }
  std::stable_sort(couplings_.begin(), couplings_.end(),
                   [](const Coupling& a, const Coupling& b) { return a.cluster < b.cluster; });
}

// Forces of the coupled terms against t.
void BlockCg::pull_coupled() {
  std::fill(coupled_force_.begin(), coupled_force_.end(), Vec3{});
  for (const Coupling& c : couplings_) {
    const Twelve t = Twelve::load(&solved_[kSize * c.cluster]);
    for (int k = 0; k < 3; ++k)
      coupled_force_[c.term][k] += inner(Twelve::load(&c.columns[static_cast<std::size_t>(kSize * k)]), t);
  }
  for (std::size_t i = 0; i < coupled_force_.size(); ++i)
    coupled_force_[i] = coupled_stiffness_[i] * coupled_force_[i];
}

bool BlockCg::factor_cluster(const StiffnessMatrix& matrix, int cluster, double shift) {
  const int first = cluster_offsets_[cluster], last = cluster_offsets_[cluster + 1];
  Dense block{};
  for (int i = first; i < last; ++i) {
    for (int k = matrix.offsets()[i]; k < matrix.offsets()[i + 1]; ++k) {
      const int j = matrix.columns()[k];
      if (j < first || j >= last) continue;
      for (std::size_t c = 0; c < 3; ++c) {
        double* out = &block[kSize * (3 * static_cast<std::size_t>(j - first) + c) +
                             3 * static_cast<std::size_t>(i - first)];
        const Vec3& column = matrix.blocks()[k].c[c];
        out[0] = column.x, out[1] = column.y, out[2] = column.z;
      }
    }
  }
  for (int k = 0; k < kSize; ++k) {
    double& diagonal = block[static_cast<std::size_t>((kSize + 1) * k)];
    if (k >= 3 * (last - first)) {
      diagonal = 1;
      continue;
    }
    const Mat3& own = matrix.blocks()[matrix.diagonal()[first + k / 3]];
    const double trace = own.c[0].x + own.c[1].y + own.c[2].z;
    diagonal +=
        trace == 0.0 ? 1.0 : kTrifle * std::abs(trace) + shift;  // a point without any spring moves nowhere
  }
  if (!cholesky(block)) return false;
  inverse_factors_[static_cast<std::size_t>(cluster)] = inverse_of_lower(block);
  return true;
}

// W_c A W_dᵀ for all pairs (c, d) of one cluster in one part.
void BlockCg::scale_row(const StiffnessMatrix& matrix, Part& part, int cluster) const {
  const Dense& left = inverse_factors_[static_cast<std::size_t>(cluster)];
  for (int pair = part.begin(cluster); pair < part.end(cluster); ++pair) {
    const int other = part.columns[pair];
    const Dense& right = inverse_factors_[static_cast<std::size_t>(other)];
    Twelve half[kSize] = {};  // W_c A, by columns
    for (int e = part.entry_offsets[pair]; e < part.entry_offsets[pair + 1]; ++e) {
      const Entry& entry = entries_[e];
      for (int c = 0; c < 3; ++c) {
        const Vec3& column = matrix.blocks()[entry.block].c[static_cast<std::size_t>(c)];
        for (int r = 0; r < 3; ++r) {
          Twelve& to = half[3 * entry.column + c];
          to = to + Twelve::load(&left[static_cast<std::size_t>(kSize * (3 * entry.row + r))]) * column[r];
        }
      }
    }
    for (int j = 0; j < kSize; ++j) {
      Twelve sum{};
      for (int k = 0; k <= j; ++k) sum = sum + half[k] * right[static_cast<std::size_t>(kSize * k + j)];
      double column[kSize];
      sum.store(column);
      float* out = &part.blocks[static_cast<std::size_t>(kBlock) * pair + kSize * j];
      for (int i = 0; i < kSize; ++i) out[i] = static_cast<float>(column[i]);
    }
  }
}

// (1 + L) out = right_hand_side in one domain.
void BlockCg::forward(std::size_t domain, std::span<const double> right_hand_side,
                      std::span<double> out) const {
  for (int c = bounds_[domain]; c < bounds_[domain + 1]; ++c) {
    Twelve v = Twelve::load(&right_hand_side[kSize * c]);
    for (int k = lower_.begin(c); k < lower_.end(c); ++k) {
      v = v - block_times(&lower_.blocks[kBlock * k], &out[kSize * lower_.columns[k]]);
    }
    v.store(&out[kSize * c]);
  }
}

// (1 + L)ᵀ out = right_hand_side in one domain.
void BlockCg::backward(std::size_t domain, std::span<const double> right_hand_side,
                       std::span<double> out) const {
  for (int c = bounds_[domain + 1] - 1; c >= bounds_[domain]; --c) {
    Twelve v = Twelve::load(&right_hand_side[kSize * c]);
    for (int k = upper_.begin(c); k < upper_.end(c); ++k) {
      v = v - block_times(&upper_.blocks[kBlock * k], &out[kSize * upper_.columns[k]]);
    }
    v.store(&out[kSize * c]);
  }
}

// image = (1 + L)⁻¹ (p − t + (R + U) t) in one domain, U t the coupled forces, all of t being known; returns
// its part of p · (t + image).
double BlockCg::apply(std::size_t domain) {
  double product = 0;
  auto coupling = std::lower_bound(couplings_.begin(), couplings_.end(), bounds_[domain],
                                   [](const Coupling& x, int cluster) { return x.cluster < cluster; });
  for (int c = bounds_[domain]; c < bounds_[domain + 1]; ++c) {
    const Twelve p = Twelve::load(&direction_[kSize * c]), t = Twelve::load(&solved_[kSize * c]);
    Twelve v = p - t;
    for (int k = outer_.begin(c); k < outer_.end(c); ++k) {
      v = v + block_times(&outer_.blocks[kBlock * k], &solved_[kSize * outer_.columns[k]]);
    }
    for (; coupling != couplings_.end() && coupling->cluster == c; ++coupling) {
      for (int k = 0; k < 3; ++k) {
        v = v + Twelve::load(&coupling->columns[static_cast<std::size_t>(kSize * k)]) *
                    coupled_force_[coupling->term][k];
      }
    }
    for (int k = lower_.begin(c); k < lower_.end(c); ++k) {
      v = v - block_times(&lower_.blocks[kBlock * k], &image_[kSize * lower_.columns[k]]);
    }
    v.store(&image_[kSize * c]);
    product += inner(p, t + v);
  }
  return product;
}

CgResult BlockCg::solve(std::span<const Vec3> b, double tolerance, int max_iterations, const Context& context,
                        std::span<Vec3> x) {
  const std::size_t domains = bounds_.size() - 1;
  const auto over_domains = [&](auto&& body) {
    return parallel_reduce<double>(
        domains, 1, 0.0, [&](std::size_t d, std::size_t) { return body(d); }, std::plus<>());
  };
  double rho = over_domains([&](std::size_t d) { return start(d, b); });
  const double first = rho, target = tolerance * tolerance * rho;
  CgResult result;
  double beta = 0;
  while (rho > target) {
    if (result.iterations == max_iterations) {
      result.outcome = CgOutcome::iteration_limit;
      break;
    }
    if (result.iterations % kCancelInterval == kCancelInterval - 1 && context.cancelled()) {
      result.outcome = CgOutcome::cancelled;
      break;
    }
    over_domains([&](std::size_t d) {
      for (int c = bounds_[d]; c < bounds_[d + 1]; ++c) {
        double* p = &direction_[kSize * c];
        (Twelve::load(&residual_[kSize * c]) + Twelve::load(p) * beta).store(p);
      }
      backward(d, direction_, solved_);
      return 0.0;
    });
    pull_coupled();
    const double curvature = over_domains([&](std::size_t d) { return apply(d); });
    if (!(curvature > 0)) {
      result.outcome = CgOutcome::indefinite;
      break;
    }
    ++result.iterations;
    const double next = over_domains([&](std::size_t d) { return step(d, rho / curvature); });
    beta = next / rho;
    rho = next;
  }
  if (first > 0) result.reduction = std::sqrt(rho / first);
  finish(x);
  return result;
}

// The scaled right-hand side through (1 + L)⁻¹ is the first residual; returns its square.
double BlockCg::start(std::size_t domain, std::span<const Vec3> b) {
  double square = 0;
  for (int c = bounds_[domain]; c < bounds_[domain + 1]; ++c) {
    const Dense& w = inverse_factors_[static_cast<std::size_t>(c)];
    Twelve scaled{};
    for (int i = cluster_offsets_[c]; i < cluster_offsets_[c + 1]; ++i) {
      for (int k = 0; k < 3; ++k) {
        scaled =
            scaled +
            Twelve::load(&w[static_cast<std::size_t>(kSize * (3 * (i - cluster_offsets_[c]) + k))]) * b[i][k];
      }
    }
    scaled.store(&image_[kSize * c]);
    Twelve{}.store(&solution_[kSize * c]);
    Twelve{}.store(&direction_[kSize * c]);
  }
  forward(domain, image_, residual_);
  for (int c = bounds_[domain]; c < bounds_[domain + 1]; ++c) {
    const Twelve r = Twelve::load(&residual_[kSize * c]);
    square += inner(r, r);
  }
  return square;
}

// One step along the direction; returns the square of the residual.
double BlockCg::step(std::size_t domain, double alpha) {
  double square = 0;
  for (int c = bounds_[domain]; c < bounds_[domain + 1]; ++c) {
    const Twelve t = Twelve::load(&solved_[kSize * c]);
    const Twelve r = Twelve::load(&residual_[kSize * c]) - (Twelve::load(&image_[kSize * c]) + t) * alpha;
    r.store(&residual_[kSize * c]);
    (Twelve::load(&solution_[kSize * c]) + t * alpha).store(&solution_[kSize * c]);
    square += inner(r, r);
  }
  return square;
}

// x = Wᵀ solution.
void BlockCg::finish(std::span<Vec3> x) const {
  for (int c = 0; c < clusters(); ++c) {
    const Dense& w = inverse_factors_[static_cast<std::size_t>(c)];
    const Twelve s = Twelve::load(&solution_[kSize * c]);
    for (int i = cluster_offsets_[c]; i < cluster_offsets_[c + 1]; ++i) {
      for (int k = 0; k < 3; ++k) {
        x[i][k] =
            inner(Twelve::load(&w[static_cast<std::size_t>(kSize * (3 * (i - cluster_offsets_[c]) + k))]), s);
      }
    }
  }
}

}  // namespace turgor
