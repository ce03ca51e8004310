#include "dynamics/block_cg.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "dynamics/lanes.hpp"
#include "turgor/core/parallel.hpp"

namespace turgor {
namespace {

constexpr int kRowsPerDomain = 700, kMaxDomains = 16;
// A pivot may be smaller than its diagonal block by about this; the trace of D over P.
constexpr double kLargestPivotRatio = 30;
constexpr int kCancelInterval = 32;

int domain_count(int rows) { return std::clamp(rows / kRowsPerDomain, 1, kMaxDomains); }

// Lane 3 of a column is the next column's first entry; the rows mask it away.
inline Lanes block_times(const double* block, const double* v) {
  return load_lanes(block) * v[0] + load_lanes(block + 3) * v[1] + load_lanes(block + 6) * v[2];
}

inline Lanes three_lanes(Lanes v) {
  const LaneBits mask = {-1, -1, -1, 0};
  LaneBits bits;
  std::memcpy(&bits, &v, sizeof bits);
  bits &= mask;
  std::memcpy(&v, &bits, sizeof v);
  return v;
}

inline double sum(Lanes v) { return (v[0] + v[1]) + (v[2] + v[3]); }

}  // namespace

BlockCg::BlockCg(const StiffnessMatrix& matrix) : rows_(matrix.rows()) {
  const int domains = domain_count(rows_);
  std::vector<int> domain_of(static_cast<std::size_t>(rows_));
  for (int d = 0; d <= domains; ++d) {
    bounds_.push_back(static_cast<int>(static_cast<std::int64_t>(rows_) * d / domains));
  }
  for (int d = 0; d < domains; ++d) {
    std::fill(domain_of.begin() + bounds_[d], domain_of.begin() + bounds_[d + 1], d);
  }
  for (Part* part : {&lower_, &upper_, &outer_}) part->offsets.assign(1, 0);
  for (int i = 0; i < rows_; ++i) {
    for (int k = matrix.offsets()[i]; k < matrix.offsets()[i + 1]; ++k) {
      const int j = matrix.columns()[k];
      if (j == i) continue;
      Part& part = domain_of[i] != domain_of[j] ? outer_ : j < i ? lower_ : upper_;
      part.columns.push_back(j);
      part.source.push_back(k);
    }
    for (Part* part : {&lower_, &upper_, &outer_}) part->offsets.push_back(static_cast<int>(part->columns.size()));
  }
  // One more, for the load of the last column's fourth lane.
  for (Part* part : {&lower_, &upper_, &outer_}) part->blocks.resize(9 * part->columns.size() + 1);
  factors_.resize(static_cast<std::size_t>(rows_));
  diagonal_.resize(9 * factors_.size() + 1);
  for (auto* v : {&residual_, &direction_, &solved_, &image_, &solution_}) v->resize(4 * factors_.size());
}

bool BlockCg::factor(const StiffnessMatrix& matrix, double damping) {
  double mean = 0;
  for (int i = 0; i < rows_; ++i) mean += Symmetric3(matrix.blocks()[matrix.diagonal()[i]]).trace() / (3.0 * rows_);
  std::vector<char> definite(bounds_.size() - 1);
  parallel_for(definite.size(), 1,
               [&](std::size_t d, std::size_t) { definite[d] = make_pivots(matrix, d, damping * mean); });
  if (std::count(definite.begin(), definite.end(), 0) > 0) return false;
  for (Part* part : {&lower_, &upper_, &outer_}) scale(matrix, *part);
  return true;
}

// P_i = D_i − Σ L_ij P_j⁻¹ L_ijᵀ, row by row. The sum may exceed D_i where A is no M-matrix; as much of it is taken as
// leaves a pivot that is safely positive definite.
bool BlockCg::make_pivots(const StiffnessMatrix& matrix, std::size_t domain, double shift) {
  for (int i = bounds_[domain]; i < bounds_[domain + 1]; ++i) {
    Symmetric3 d(matrix.blocks()[matrix.diagonal()[i]]);
    // A point on a single spring has a singular block; no force acts in its free directions, so a trifle of stiffness
    // there changes nothing. A point without any spring moves nowhere.
    const double size = std::abs(d.trace());
    d.add_to_diagonal(size == 0.0 ? 1.0 : 1e-9 * size + shift);
    InverseFactor& factor = factors_[i];
    if (!factor.factor(d)) return false;
    Mat3 scaled = factor.both_sides_of(d);
    for (const double share : {1.0, 0.5, 0.25}) {
      Symmetric3 pivot = d;
      for (int k = lower_.offsets[i]; k < lower_.offsets[i + 1]; ++k) {
        const Mat3 b = factors_[lower_.columns[k]].right_of(matrix.blocks()[lower_.source[k]]);
        for (const Vec3& column : b.c) pivot.add_outer(column, -share);  // L P⁻¹ Lᵀ = (L Wᵀ)(L Wᵀ)ᵀ
      }
      InverseFactor candidate;
      if (!candidate.factor(pivot)) continue;
      const Mat3 relative = candidate.both_sides_of(d);
      if (Symmetric3(relative).trace() > kLargestPivotRatio) continue;
      factor = candidate;
      scaled = relative;
      break;
    }
    scaled.c[0].x -= 2, scaled.c[1].y -= 2, scaled.c[2].z -= 2;
    double* out = &diagonal_[9 * static_cast<std::size_t>(i)];
    for (std::size_t c = 0; c < 3; ++c) out[3 * c] = scaled.c[c].x, out[3 * c + 1] = scaled.c[c].y, out[3 * c + 2] = scaled.c[c].z;
  }
  return true;
}

// Blocks become W_i A W_jᵀ.
void BlockCg::scale(const StiffnessMatrix& matrix, Part& part) {
  parallel_for(static_cast<std::size_t>(rows_), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const InverseFactor& fi = factors_[i];
      const Lanes w0{fi.w00, fi.w10, fi.w20, 0}, w1{0, fi.w11, fi.w21, 0}, w2{0, 0, fi.w22, 0};
      for (int k = part.offsets[i]; k < part.offsets[i + 1]; ++k) {
        const Mat3& a = matrix.blocks()[part.source[k]];
        const InverseFactor& fj = factors_[part.columns[k]];
        const Lanes c0 = w0 * a.c[0].x + w1 * a.c[0].y + w2 * a.c[0].z;
        const Lanes c1 = w0 * a.c[1].x + w1 * a.c[1].y + w2 * a.c[1].z;
        const Lanes c2 = w0 * a.c[2].x + w1 * a.c[2].y + w2 * a.c[2].z;
        // The fourth lane of a store is overwritten by the next; that of the last would be the next block's.
        double* out = &part.blocks[9 * static_cast<std::size_t>(k)];
        store_lanes(out, c0 * fj.w00);
        store_lanes(out + 3, c0 * fj.w10 + c1 * fj.w11);
        const Lanes last = c0 * fj.w20 + c1 * fj.w21 + c2 * fj.w22;
        std::memcpy(out + 6, &last, 3 * sizeof(double));
      }
    }
  });
}

// (1 + L) out = right_hand_side in one domain.
void BlockCg::forward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const {
  for (int i = bounds_[domain]; i < bounds_[domain + 1]; ++i) {
    Lanes v = load_lanes(&right_hand_side[4 * i]);
    for (int k = lower_.offsets[i]; k < lower_.offsets[i + 1]; ++k) {
      v -= block_times(&lower_.blocks[9 * k], &out[4 * lower_.columns[k]]);
    }
    store_lanes(&out[4 * i], three_lanes(v));
  }
}

// (1 + L)ᵀ out = right_hand_side in one domain.
void BlockCg::backward(std::size_t domain, std::span<const double> right_hand_side, std::span<double> out) const {
  for (int i = bounds_[domain + 1] - 1; i >= bounds_[domain]; --i) {
    Lanes v = load_lanes(&right_hand_side[4 * i]);
    for (int k = upper_.offsets[i]; k < upper_.offsets[i + 1]; ++k) {
      v -= block_times(&upper_.blocks[9 * k], &out[4 * upper_.columns[k]]);
    }
    store_lanes(&out[4 * i], three_lanes(v));
  }
}

// image = (1 + L)⁻¹ (p + (D − 2) t + R t) in one domain, all of t being known; returns its part of p · (t + image).
double BlockCg::apply(std::size_t domain) {
  Lanes product = broadcast(0);
  for (int i = bounds_[domain]; i < bounds_[domain + 1]; ++i) {
    const Lanes p = load_lanes(&direction_[4 * i]), t = load_lanes(&solved_[4 * i]);
    Lanes v = p + block_times(&diagonal_[9 * i], &solved_[4 * i]);
    for (int k = outer_.offsets[i]; k < outer_.offsets[i + 1]; ++k) {
      v += block_times(&outer_.blocks[9 * k], &solved_[4 * outer_.columns[k]]);
    }
    for (int k = lower_.offsets[i]; k < lower_.offsets[i + 1]; ++k) {
      v -= block_times(&lower_.blocks[9 * k], &image_[4 * lower_.columns[k]]);
    }
    v = three_lanes(v);
    store_lanes(&image_[4 * i], v);
    product += p * (t + v);
  }
  return sum(product);
}

CgResult BlockCg::solve(std::span<const Vec3> b, double tolerance, int max_iterations, const Context& context,
                        std::span<Vec3> x) {
  const std::size_t domains = bounds_.size() - 1;
  const auto over_domains = [&](auto&& body) {
    return parallel_reduce<double>(
        domains, 1, 0.0, [&](std::size_t d, std::size_t) { return body(d); }, std::plus<>());
  };
  double rho = over_domains([&](std::size_t d) {
    for (int i = bounds_[d]; i < bounds_[d + 1]; ++i) {
      const Vec3 v = factors_[i].times(b[i]);
      store_lanes(&image_[4 * i], Lanes{v.x, v.y, v.z, 0});
      store_lanes(&solution_[4 * i], broadcast(0));
      store_lanes(&direction_[4 * i], broadcast(0));
    }
    forward(d, image_, residual_);
    Lanes square = broadcast(0);
    for (int i = bounds_[d]; i < bounds_[d + 1]; ++i) {
      const Lanes r = load_lanes(&residual_[4 * i]);
      square += r * r;
    }
    return sum(square);
  });
  const double target = tolerance * tolerance * rho;
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
      for (int i = 4 * bounds_[d]; i < 4 * bounds_[d + 1]; i += kLanes) {
        store_lanes(&direction_[i], load_lanes(&residual_[i]) + load_lanes(&direction_[i]) * beta);
      }
      backward(d, direction_, solved_);
      return 0.0;
    });
    const double curvature = over_domains([&](std::size_t d) { return apply(d); });
    if (!(curvature > 0)) {
      result.outcome = CgOutcome::indefinite;
      break;
    }
    ++result.iterations;
    const double alpha = rho / curvature;
    const double next = over_domains([&](std::size_t d) {
      Lanes square = broadcast(0);
      for (int i = 4 * bounds_[d]; i < 4 * bounds_[d + 1]; i += kLanes) {
        const Lanes t = load_lanes(&solved_[i]);
        const Lanes r = load_lanes(&residual_[i]) - (load_lanes(&image_[i]) + t) * alpha;
        store_lanes(&residual_[i], r);
        store_lanes(&solution_[i], load_lanes(&solution_[i]) + t * alpha);
        square += r * r;
      }
      return sum(square);
    });
    beta = next / rho;
    rho = next;
  }
  for (int i = 0; i < rows_; ++i) {  // x = Wᵀ solution
    const double* s = &solution_[4 * i];
    x[i] = factors_[i].transposed_times({s[0], s[1], s[2]});
  }
  return result;
}

}  // namespace turgor
