// Eight floats side by side, as lanes.hpp has four doubles; both with one interface, Pack<T>, and a scalar
// twin that does the same operations one lane after another. Every operation is the IEEE one: the same bits.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "math/lanes.hpp"

namespace turgor {

using Floats = float __attribute__((vector_size(32)));

/// The scalar twin of `n` lanes.
template <class T, int n>
struct Twin {
  T v[n];

  template <class Operation>
  static Twin each(Operation operation) {
    Twin r;
    for (int i = 0; i < n; ++i) r.v[i] = operation(i);
    return r;
  }
  friend Twin operator+(const Twin& a, const Twin& b) {
    return each([&](int i) { return a.v[i] + b.v[i]; });
  }
  friend Twin operator-(const Twin& a, const Twin& b) {
    return each([&](int i) { return a.v[i] - b.v[i]; });
  }
  friend Twin operator-(const Twin& a) {
    return each([&](int i) { return -a.v[i]; });
  }
  friend Twin operator*(const Twin& a, const Twin& b) {
    return each([&](int i) { return a.v[i] * b.v[i]; });
  }
  friend Twin operator/(const Twin& a, const Twin& b) {
    return each([&](int i) { return a.v[i] / b.v[i]; });
  }
};

/// What a kernel needs to know of its lanes: their number, the type of one, and a point of memory: x y z and
/// something, aligned.
template <class Real>
struct Pack;
template <>
struct Pack<Floats> {
  using Scalar = float;
  static constexpr int lanes = 8;
};
template <>
struct Pack<Lanes> {
  using Scalar = double;
  static constexpr int lanes = 4;
};
template <class T, int n>
struct Pack<Twin<T, n>> {
  using Scalar = T;
  static constexpr int lanes = n;
};

template <class Real>
Real same(typename Pack<Real>::Scalar x) {
  if constexpr (requires(Real r) { r.v[0]; })
    return Real::each([&](int) { return x; });
  else
    return x - Real{};
}

template <class Real>
Real load(const typename Pack<Real>::Scalar* from) {
  Real r;
  std::memcpy(&r, from, sizeof r);
  return r;
}

inline Floats root(Floats x) {
#ifdef __AVX__
  return _mm256_sqrt_ps(x);
#else
  Floats r;
  for (int i = 0; i < 8; ++i) r[i] = std::sqrt(x[i]);
  return r;
#endif
}
inline Lanes root(Lanes x) {
  return sqrt(x);
}
template <class T, int n>
Twin<T, n> root(const Twin<T, n>& x) {
  return Twin<T, n>::each([&](int i) { return std::sqrt(x.v[i]); });
}

/// The second where one of them is not a number.
template <class Real>
Real larger(Real a, Real b) {
  if constexpr (requires { a.v[0]; })
    return Real::each([&](int i) { return a.v[i] > b.v[i] ? a.v[i] : b.v[i]; });
  else
    return a > b ? a : b;
}

template <class Real>
typename Pack<Real>::Scalar largest_lane(const Real& a) {
  constexpr int lanes = Pack<Real>::lanes;
  typename Pack<Real>::Scalar v[lanes];
  std::memcpy(v, &a, sizeof v);
  auto most = v[0];
  for (int i = 1; i < lanes; ++i) most = v[i] > most ? v[i] : most;
  return most;
}

/// a b + c and a b − c, rounded once where the instruction set has it: named, so that the same sums are fused
/// by every compiler.
template <class Real>
Real multiply_add(const Real& a, const Real& b, const Real& c) {
#ifdef __FMA__
  if constexpr (std::is_same_v<Real, Floats>)
    return _mm256_fmadd_ps(a, b, c);
  else if constexpr (std::is_same_v<Real, Lanes>)
    return _mm256_fmadd_pd(a, b, c);
  else
    return Real::each([&](int i) { return std::fma(a.v[i], b.v[i], c.v[i]); });
#else
  return a * b + c;
#endif
}
template <class Real>
Real multiply_subtract(const Real& a, const Real& b, const Real& c) {
#ifdef __FMA__
  if constexpr (std::is_same_v<Real, Floats>)
    return _mm256_fmsub_ps(a, b, c);
  else if constexpr (std::is_same_v<Real, Lanes>)
    return _mm256_fmsub_pd(a, b, c);
  else
    return Real::each([&](int i) { return std::fma(a.v[i], b.v[i], -c.v[i]); });
#else
  return a * b - c;
#endif
}

template <class Real>
struct Triple {
  Real x, y, z;

  friend Triple operator+(const Triple& a, const Triple& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Triple operator-(const Triple& a, const Triple& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend Triple operator-(const Triple& a) { return {-a.x, -a.y, -a.z}; }
  friend Triple operator*(const Triple& a, const Real& s) { return {a.x * s, a.y * s, a.z * s}; }
};
template <class Real>
Real dot(const Triple<Real>& a, const Triple<Real>& b) {
  return multiply_add<Real>(a.z, b.z, multiply_add<Real>(a.y, b.y, a.x * b.x));
}
template <class Real>
Triple<Real> cross(const Triple<Real>& a, const Triple<Real>& b) {
  return {multiply_subtract<Real>(a.y, b.z, a.z * b.y), multiply_subtract<Real>(a.z, b.x, a.x * b.z),
          multiply_subtract<Real>(a.x, b.y, a.y * b.x)};
}
/// a s + b.
template <class Real>
Triple<Real> multiply_add(const Triple<Real>& a, const Real& s, const Triple<Real>& b) {
  return {multiply_add<Real>(a.x, s, b.x), multiply_add<Real>(a.y, s, b.y), multiply_add<Real>(a.z, s, b.z)};
}
/// a × b + c.
template <class Real>
Triple<Real> cross_add(const Triple<Real>& a, const Triple<Real>& b, const Triple<Real>& c) {
  const auto one = [](const Real& p, const Real& q, const Real& r, const Real& s, const Real& t) {
    return multiply_subtract<Real>(p, q, multiply_subtract<Real>(r, s, t));
  };
  return {one(a.y, b.z, a.z, b.y, c.x), one(a.z, b.x, a.x, b.z, c.y), one(a.x, b.y, a.y, b.x, c.z)};
}

/// Rows of x y z · of the points a to d and of e to h become eight x, eight y and eight z.
inline Triple<Floats> columns(Floats ae, Floats bf, Floats cg, Floats dh) {
  const Floats ab = __builtin_shufflevector(ae, bf, 0, 8, 1, 9, 4, 12, 5, 13),
               cd = __builtin_shufflevector(cg, dh, 0, 8, 1, 9, 4, 12, 5, 13);
  const Floats ab_z = __builtin_shufflevector(ae, bf, 2, 10, 3, 11, 6, 14, 7, 15),
               cd_z = __builtin_shufflevector(cg, dh, 2, 10, 3, 11, 6, 14, 7, 15);
  return {__builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15),
          __builtin_shufflevector(ab_z, cd_z, 0, 1, 8, 9, 4, 5, 12, 13)};
}

using HalfFloats = float __attribute__((vector_size(16)));

inline Lanes load_as_lanes(const float* from) {
  HalfFloats v;
  std::memcpy(&v, from, sizeof v);
  return __builtin_convertvector(v, Lanes);
}
inline Lanes load_as_lanes(const double* from) {
  return load_lanes(from);
}

inline void add_to(float* to, HalfFloats row) {
  HalfFloats sum;
  std::memcpy(&sum, to, sizeof sum);
  sum += row;
  std::memcpy(to, &sum, sizeof sum);
}

/// x, y and z of the points `index`, one for each lane; a point of memory is v[4], x y z and something.
template <class Real, class Quad>
Triple<Real> gather(const Quad* of, const std::uint16_t* index) {
  if constexpr (std::is_same_v<Real, Floats>) {
    const auto pair = [&](int i) {  // lanes i and i + 4 side by side
      HalfFloats low, high;
      std::memcpy(&low, of[index[i]].v, sizeof low), std::memcpy(&high, of[index[i + 4]].v, sizeof high);
      return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
    };
    return columns(pair(0), pair(1), pair(2), pair(3));
  } else if constexpr (std::is_same_v<Real, Lanes>) {
    Lanes a = load_lanes(of[index[0]].v), b = load_lanes(of[index[1]].v), c = load_lanes(of[index[2]].v),
          d = load_lanes(of[index[3]].v);
    transpose(a, b, c, d);
    return {a, b, c};
  } else {
    const auto column = [&](int k) { return Real::each([&](int i) { return of[index[i]].v[k]; }); };
    return {column(0), column(1), column(2)};
  }
}

/// Adds to each lane's point, one lane after another: points may repeat.
template <class Real, class Quad>
void scatter(Quad* to, const std::uint16_t* index, const Triple<Real>& f) {
  if constexpr (std::is_same_v<Real, Floats>) {
    const Floats none = {};
    const Floats xy0 = __builtin_shufflevector(f.x, f.y, 0, 8, 1, 9, 4, 12, 5, 13),
                 xy2 = __builtin_shufflevector(f.x, f.y, 2, 10, 3, 11, 6, 14, 7, 15),
                 z0 = __builtin_shufflevector(f.z, none, 0, 8, 1, 9, 4, 12, 5, 13),
                 z2 = __builtin_shufflevector(f.z, none, 2, 10, 3, 11, 6, 14, 7, 15);
    const Floats rows[4] = {__builtin_shufflevector(xy0, z0, 0, 1, 8, 9, 4, 5, 12, 13),
                            __builtin_shufflevector(xy0, z0, 2, 3, 10, 11, 6, 7, 14, 15),
                            __builtin_shufflevector(xy2, z2, 0, 1, 8, 9, 4, 5, 12, 13),
                            __builtin_shufflevector(xy2, z2, 2, 3, 10, 11, 6, 7, 14, 15)};
    for (int i = 0; i < 4; ++i) add_to(to[index[i]].v, __builtin_shufflevector(rows[i], none, 0, 1, 2, 3));
    for (int i = 0; i < 4; ++i)
      add_to(to[index[i + 4]].v, __builtin_shufflevector(rows[i], none, 4, 5, 6, 7));
  } else if constexpr (std::is_same_v<Real, Lanes>) {
    Lanes rows[4] = {f.x, f.y, f.z, Lanes{}};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (int i = 0; i < 4; ++i) {
      double* p = to[index[i]].v;
      store_lanes(p, load_lanes(p) + rows[i]);
    }
  } else {
    for (int i = 0; i < Pack<Real>::lanes; ++i) {
      auto* p = to[index[i]].v;
      p[0] += f.x.v[i], p[1] += f.y.v[i], p[2] += f.z.v[i];
    }
  }
}

}  // namespace turgor
