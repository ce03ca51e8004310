// Four doubles side by side. Vector types of GCC and Clang, so that lowering falls to the compiler; only the
// square root, which they lack, is spelt out. Every operation is the IEEE one, lane by lane: the bits are
// those of scalar code.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#ifdef __AVX__
#include <immintrin.h>
#endif

namespace turgor {

using Lanes = double __attribute__((vector_size(32)));
using LaneBits = std::int64_t __attribute__((vector_size(32)));
inline constexpr int kLanes = 4;

inline Lanes broadcast(double x) {
  return Lanes{x, x, x, x};
}

inline Lanes load_lanes(const double* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

inline void store_lanes(double* to, Lanes v) {
  std::memcpy(to, &v, sizeof v);
}

inline Lanes sqrt(Lanes x) {
#ifdef __AVX__
  return _mm256_sqrt_pd(x);
#else
  return Lanes{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
#endif
}

/// Rows become columns: x y z · of four points become four x, four y, four z.
inline void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
              ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
              cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

/// Whether any lane of a comparison holds.
inline bool any(LaneBits mask) {
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
}

/// e^x for x ≤ 0 to round-off: x = n ln 2 + r, Taylor's polynomial of r, n into the exponent. Zero below
/// −700.
inline Lanes exp_of_negative(Lanes x) {
  constexpr double shift = 0x1.8p52, log2e = 1.4426950408889634;
  constexpr double ln2_high = 0x1.62e42fee00000p-1, ln2_low = 0x1.a39ef35793c76p-33;
  const LaneBits in_range = x > -700.0;
  const Lanes biased = x * log2e + shift, n = biased - shift;
  const Lanes r = (x - n * ln2_high) - n * ln2_low;
  // Estrin's scheme: pairs, then pairs of pairs, so that the products do not wait for one another.
  const Lanes r2 = r * r, r4 = r2 * r2;
  const Lanes p0 = (1.0 + r) + r2 * (0.5 + r * (1.0 / 6));
  const Lanes p4 = (1.0 / 24 + r * (1.0 / 120)) + r2 * (1.0 / 720 + r * (1.0 / 5040));
  const Lanes p8 = (1.0 / 40320 + r * (1.0 / 362880)) + r2 * (1.0 / 3628800 + r * (1.0 / 39916800));
  const Lanes p12 = 1.0 / 479001600 + r * (1.0 / 6227020800.0);
  Lanes p = (p0 + r4 * p4) + (r4 * r4) * (p8 + r4 * p12);
  LaneBits bits, exponent;
  std::memcpy(&bits, &p, sizeof bits);
  std::memcpy(&exponent, &biased, sizeof exponent);
  bits = (bits + (exponent << 52)) & in_range;
  std::memcpy(&p, &bits, sizeof p);
  return p;
}

}  // namespace turgor
