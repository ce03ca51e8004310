#include "turgor/dynamics/chain.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "math/lanes.hpp"

namespace turgor {
namespace {

// Marks of points that the wave has not come to, and of fixed points that it passes over.
constexpr int kUnreached = -1, kInert = -2;

Error out_of_range(const char* name, double value, const char* range) {
  return {ErrorKind::bad_input, fmt::format("{} is {}", name, value), "mass-spring chain",
          fmt::format("It must lie {}", range)};
}

Result<void> check(const ChainParameters& p) {
  if (!(p.alpha >= 0 && p.alpha <= 1)) return out_of_range("alpha", p.alpha, "from 0 to 1");
  if (!(p.column_alpha >= 0 && p.column_alpha <= 1)) {
    return out_of_range("the alpha across the layers", p.column_alpha, "from 0 to 1");
  }
  if (!(p.beta >= 0 && p.beta <= 1e6)) return out_of_range("beta", p.beta, "from 0 to 1,000,000");
  if (!(p.max_stretch >= 0 && p.max_stretch <= 1e6)) {
    return out_of_range("the largest stretch", p.max_stretch, "from 0 to 1,000,000");
  }
  if (!(p.max_compression >= 0 && p.max_compression < 1)) {
    return out_of_range("the largest compression", p.max_compression, "from 0 to below 1");
  }
  if (p.semi_active_passes < 0 || p.semi_active_passes > 100) {
    return out_of_range("the number of semi-active passes", p.semi_active_passes, "from 0 to 100");
  }
  return {};
}

struct SpringWriter {
  int *from, *to;
  double *rest_length, *elastic;
  int size = 0;

  explicit SpringWriter(ChainWorkspace::Springs& springs)
      : from(springs.from.data()),
        to(springs.to.data()),
        rest_length(springs.rest_length.data()),
        elastic(springs.elastic.data()) {}

  void put(int from_place, int to_place, double r0, double one_minus_alpha) {
    from[size] = from_place;
    to[size] = to_place;
    rest_length[size] = r0;
    elastic[size] = one_minus_alpha;
    ++size;
  }
};

Vec3 vec_at(const std::vector<double>& array, int place) {
  const double* v = &array[4 * static_cast<std::size_t>(place)];
  return {v[0], v[1], v[2]};
}

void add_at(std::vector<double>& array, int place, const Vec3& v) {
  double* to = &array[4 * static_cast<std::size_t>(place)];
  to[0] += v.x;
  to[1] += v.y;
  to[2] += v.z;
}

// What four neighbours are displaced by, b − B. With D = a − A, v = u − D and w = u − (1 − α) D, so
// b − B = D − u + q w = (q − 1) u + (1 − q (1 − α)) D, where q = length / |w|. `d` is D, then the answer;
// returns |w|.
Lanes displace(const Lanes u[3], Lanes d[3], Lanes r0, Lanes elastic, const ChainParameters& p) {
  const Lanes wx = u[0] - elastic * d[0], wy = u[1] - elastic * d[1], wz = u[2] - elastic * d[2];
  const Lanes w = sqrt(wx * wx + wy * wy + wz * wz);
  const Lanes excess = w - r0;
  const LaneBits longer = excess > 0.0;
  const Lanes limit = longer ? broadcast(p.max_stretch) : broadcast(-p.max_compression);
  const Lanes exponent = (longer ? -excess : excess) * p.beta / r0;
  const Lanes q = r0 * (1.0 + limit * (1.0 - exp_of_negative(exponent))) / w;
  const Lanes keep = q - 1.0, drag = 1.0 - q * elastic;
  for (int k = 0; k < 3; ++k) d[k] = keep * u[k] + drag * d[k];
  return w;
}

// Where α u + (1 − α) v vanishes the spring has no direction; it keeps its old one, compressed as far as it
// may be.
Vec3 displace_without_direction(const Vec3& u, const Vec3& d, double rest, const ChainParameters& p) {
  const double shortest = rest * (1 - p.max_compression * (1 - std::exp(-p.beta)));
  return d - u + normalized(u) * shortest;
}

void move_neighbours(int begin, int end, const ChainParameters& parameters, ChainWorkspace& w) {
  ChainWorkspace::Springs& springs = w.active;
  const int spare =
      static_cast<int>(w.order.size()) - 1;  // two places beyond all points, for lanes without a spring
  for (int i = springs.size; i % kLanes != 0; ++i) {
    springs.from[i] = spare;
    springs.to[i] = spare + 1;
    springs.rest_length[i] = 1;
    springs.elastic[i] = 0;
  }
  for (int i = 0; i < springs.size; i += kLanes) {
    const int* from = &springs.from[i];
    const int* to = &springs.to[i];
    Lanes u[4], d[4];
    for (int k = 0; k < kLanes; ++k) {
      u[k] = load_lanes(&w.rest[4 * to[k]]) - load_lanes(&w.rest[4 * from[k]]);
      d[k] = load_lanes(&w.displacement[4 * from[k]]);
    }
    transpose(u[0], u[1], u[2], u[3]);
    transpose(d[0], d[1], d[2], d[3]);
    const Lanes r0 = load_lanes(&springs.rest_length[i]);
    const Lanes length = displace(u, d, r0, load_lanes(&springs.elastic[i]), parameters);
    d[3] = broadcast(1);
    transpose(d[0], d[1], d[2], d[3]);
    const LaneBits lost = length <= 1e-9 * r0;
    for (int k = 0; k < kLanes; ++k) {
      if (any(lost) && lost[k] != 0) [[unlikely]] {
        const Vec3 v = displace_without_direction(vec_at(w.rest, to[k]) - vec_at(w.rest, from[k]),
                                                  vec_at(w.displacement, from[k]), springs.rest_length[i + k],
                                                  parameters);
        d[k] = Lanes{v.x, v.y, v.z, 1};
      }
      double* sum = &w.displacement[4 * to[k]];
      store_lanes(sum, load_lanes(sum) + d[k]);
    }
  }
  for (int i = 0; i < w.held.size; ++i) w.displacement[4 * w.held.to[i] + 3] += 1;
  for (int i = begin; i < end; ++i) {
    double* mean = &w.displacement[4 * i];
    store_lanes(mean, load_lanes(mean) / broadcast(mean[3]));
  }
}

// Springs between two points moved in the same step are shortened or lengthened to their limit, half at
// either end. All read the same state and a point takes the mean of what its springs ask, so the order of
// springs has no say.
void limit_semi_active(int begin, int end, const ChainParameters& parameters, ChainWorkspace& w) {
  const double shortest = 1 - parameters.max_compression, longest = 1 + parameters.max_stretch;
  for (int pass = 0; pass < parameters.semi_active_passes; ++pass) {
    bool corrected = false;
    std::fill(w.correction.begin() + 4 * begin, w.correction.begin() + 4 * end, 0.0);
    for (int s = 0; s < w.semi_active.size; ++s) {
      const int from = w.semi_active.from[s], to = w.semi_active.to[s];
      const double r0 = w.semi_active.rest_length[s], low = r0 * shortest, high = r0 * longest;
      const Vec3 d = (vec_at(w.rest, to) + vec_at(w.displacement, to)) -
                     (vec_at(w.rest, from) + vec_at(w.displacement, from));
      const double square = squared_length(d);
      if ((square >= low * low && square <= high * high) || !(square > 0)) continue;
      const double l = std::sqrt(square);
      const Vec3 half = d * (0.5 * (l - std::clamp(l, low, high)) / l);
      add_at(w.correction, from, half);
      add_at(w.correction, to, -half);
      w.correction[4 * from + 3] += 1;
      w.correction[4 * to + 3] += 1;
      corrected = true;
    }
    if (!corrected) return;
    for (int i = begin; i < end; ++i) {
      const double asked = w.correction[4 * i + 3];
      if (asked > 0) add_at(w.displacement, i, vec_at(w.correction, i) / asked);
    }
  }
}

}  // namespace

ChainSolver::ChainSolver(const SpringNetwork& network)
    : valid_(validate(network)), network_rest_(network.rest) {
  if (!valid_) return;
  number_.resize(network_rest_.size());
  std::iota(number_.begin(), number_.end(), 0);
  make_links(network);
  renumber(network);
}

void ChainSolver::make_links(const SpringNetwork& network) {
  offsets_.assign(number_.size() + 1, 0);
  for (const Spring& s : network.springs) ++offsets_[number_[s.a] + 1], ++offsets_[number_[s.b] + 1];
  for (std::size_t i = 0; i < number_.size(); ++i) offsets_[i + 1] += offsets_[i];
  links_.resize(2 * network.springs.size());
  std::vector<int> next(offsets_.begin(), offsets_.end() - 1);
  for (const Spring& s : network.springs) {
    const bool column = s.kind == SpringKind::vertical || s.kind == SpringKind::diagonal;
    const int a = number_[s.a], b = number_[s.b];
    links_[next[a]++] = {s.rest_length_mm, b, column};
    links_[next[b]++] = {s.rest_length_mm, a, column};
  }
}

// Breadth first over the springs (Cuthill and McKee 1969), whatever the order in which the points came.
void ChainSolver::renumber(const SpringNetwork& network) {
  point_.reserve(number_.size());
  std::vector<char> met(number_.size(), 0);
  const auto meet = [&](int p) {
    if (met[p]) return;
    met[p] = 1;
    point_.push_back(p);
  };
  std::size_t done = 0;
  for (int seed = 0; seed < static_cast<int>(number_.size()); ++seed) {
    meet(seed);
    for (; done < point_.size(); ++done) {
      for (int k = offsets_[point_[done]]; k < offsets_[point_[done] + 1]; ++k) meet(links_[k].neighbour);
    }
  }
  for (std::size_t i = 0; i < point_.size(); ++i) {
    number_[point_[i]] = static_cast<int>(i);
    rest_.push_back(network_rest_[point_[i]]);
  }
  make_links(network);
}

Result<std::vector<Vec3>> ChainSolver::solve(const PrescribedMotion& motion,
                                             const ChainParameters& parameters) const {
  ChainWorkspace workspace;
  std::vector<Vec3> positions;
  TURGOR_CHECK(solve(motion, parameters, workspace, positions));
  return positions;
}

Result<void> ChainSolver::solve(const PrescribedMotion& motion, const ChainParameters& parameters,
                                ChainWorkspace& w, std::vector<Vec3>& positions) const {
  TURGOR_CHECK(valid_);
  TURGOR_CHECK(check(parameters));
  TURGOR_CHECK(validate(motion, static_cast<int>(rest_.size())));
  start(motion, parameters, w);
  int begin = 0, end = w.prescribed;
  while (begin < end) {
    scan(begin, end, parameters, w);
    if (w.semi_active.size > 0) limit_semi_active(begin, end, parameters, w);
    begin = end;
    end = w.prescribed + w.reached;
    enter(begin, end, w);
    move_neighbours(begin, end, parameters, w);
    ++w.steps;
  }
  positions.assign(network_rest_.begin(), network_rest_.end());
  for (int i = w.prescribed; i < end; ++i) positions[point_[w.order[i]]] += vec_at(w.displacement, i);
  for (std::size_t i = 0; i < motion.moved.size(); ++i) positions[motion.moved[i]] = motion.positions[i];
  return {};
}

void ChainSolver::prepare(ChainWorkspace& w) const {
  const std::size_t n = rest_.size(), links = links_.size() + kLanes;
  w.visit.assign(n, kUnreached);
  w.order.resize(n + 1);
  for (auto* array : {&w.rest, &w.displacement, &w.correction}) array->resize(4 * (n + 2));
  store_lanes(&w.rest[4 * n], broadcast(0));
  store_lanes(&w.rest[4 * (n + 1)], Lanes{1, 0, 0, 0});
  store_lanes(&w.displacement[4 * n], broadcast(0));
  for (ChainWorkspace::Springs* springs : {&w.active, &w.semi_active, &w.held}) {
    springs->from.resize(links);
    springs->to.resize(links);
    springs->rest_length.resize(links);
    springs->elastic.resize(links);
  }
  w.steps = w.prescribed = w.reached = 0;
}

// Points that a step has come to get their place in the arrays.
void ChainSolver::enter(int begin, int end, ChainWorkspace& w) const {
  for (int place = begin; place < end; ++place) {
    const Vec3& r = rest_[w.order[place]];
    store_lanes(&w.rest[4 * place], Lanes{r.x, r.y, r.z, 0});
    store_lanes(&w.displacement[4 * place], broadcast(0));
  }
}

void ChainSolver::start(const PrescribedMotion& motion, const ChainParameters& parameters,
                        ChainWorkspace& w) const {
  prepare(w);
  const auto prescribe = [&](int point) {
    w.visit[number_[point]] = w.prescribed;
    w.order[w.prescribed++] = number_[point];
  };
  for (const int m : motion.moved) prescribe(m);
  for (const int f : motion.fixed) {
    if (parameters.fixed_points == FixedPoints::hold) {
      prescribe(f);
    } else {
      w.visit[number_[f]] = kInert;
    }
  }
  enter(0, w.prescribed, w);
  for (std::size_t i = 0; i < motion.moved.size(); ++i) {
    add_at(w.displacement, static_cast<int>(i), motion.positions[i] - network_rest_[motion.moved[i]]);
  }
}

// One look at the springs of the active points finds both kinds: those between two of them, which are
// semi-active, and those to points not yet moved.
void ChainSolver::scan(int begin, int end, const ChainParameters& parameters, ChainWorkspace& w) const {
  const double elastic[2] = {1 - parameters.alpha, 1 - parameters.column_alpha};
  const bool hold = parameters.fixed_points == FixedPoints::hold;
  // Springs between prescribed points are nobody's to correct.
  const bool correctable = begin > 0;
  const Link* links = links_.data();
  int *visit = w.visit.data(), *order = w.order.data();
  SpringWriter active(w.active), semi_active(w.semi_active), held(w.held);
  int next = w.prescribed + w.reached;
  for (int from = begin; from < end; ++from) {
    const int number = order[from], last = offsets_[number + 1];
    const bool still = vec_at(w.displacement, from) == Vec3{};
    for (int k = offsets_[number]; k < last; ++k) {
      const Link& link = links[k];
      int to = visit[link.neighbour];
      if (to >= 0 && to < end) {
        if (to > from && correctable) semi_active.put(from, to, link.rest_length, 0);
        continue;
      }
      // What is held holds the layers above it, not its neighbours in the layer.
      if (to == kInert || (still && hold && !link.column)) continue;
      if (to == kUnreached) {
        to = next++;
        visit[link.neighbour] = to;
        order[to] = link.neighbour;
      }
      // What has not moved drags nothing.
      if (still) {
        held.put(from, to, 0, 0);
      } else {
        active.put(from, to, link.rest_length, elastic[link.column]);
      }
    }
  }
  w.reached = next - w.prescribed;
  w.active.size = active.size;
  w.semi_active.size = semi_active.size;
  w.held.size = held.size;
}

}  // namespace turgor
