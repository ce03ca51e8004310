// 3×3 tensors of numbers T: double, float, or lanes of them (math/float_lanes.hpp). Internal.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

#include "math/float_lanes.hpp"

namespace turgor::detail {

/// x, in every lane.
template <class T>
T number(double x) {
  if constexpr (std::is_floating_point_v<T>)
    return static_cast<T>(x);
  else
    return same<T>(static_cast<typename Pack<T>::Scalar>(x));
}

/// Whether x > limit in every lane; not a number is not.
template <class T>
bool all_above(const T& x, double limit) {
  if constexpr (std::is_floating_point_v<T>) {
    return x > limit;
  } else {
    typename Pack<T>::Scalar v[Pack<T>::lanes];
    std::memcpy(v, &x, sizeof v);
    for (const auto one : v)
      if (!(one > limit)) return false;
    return true;
  }
}

/// a b + c, rounded once where the instruction set has it; as multiply_add of lanes.
template <class T>
T fused(const T& a, const T& b, const T& c) {
  if constexpr (!std::is_floating_point_v<T>) {
    return multiply_add<T>(a, b, c);
  } else {
#ifdef __FMA__
    return std::fma(a, b, c);
#else
    return a * b + c;
#endif
  }
}

template <class T>
struct Tensor {
  T m[9];  ///< row · 3 + column

  const T& operator()(int row, int column) const { return m[3 * row + column]; }
  T& operator()(int row, int column) { return m[3 * row + column]; }

  template <class Operation>
  static Tensor each(Operation operation) {
    Tensor r;
    for (int i = 0; i < 9; ++i) r.m[i] = operation(i);
    return r;
  }
  static Tensor unit() {
    return each([](int i) { return number<T>(i % 4 == 0 ? 1 : 0); });
  }
  friend Tensor operator+(const Tensor& a, const Tensor& b) {
    return each([&](int i) { return a.m[i] + b.m[i]; });
  }
  friend Tensor operator-(const Tensor& a, const Tensor& b) {
    return each([&](int i) { return a.m[i] - b.m[i]; });
  }
  friend Tensor operator*(const Tensor& a, const T& s) {
    return each([&](int i) { return a.m[i] * s; });
  }
  friend Tensor operator*(const Tensor& a, const Tensor& b) {
    return each([&](int i) {
      const int row = i - i % 3, column = i % 3;
      return fused(a.m[row], b.m[column],
                   fused(a.m[row + 1], b.m[3 + column], a.m[row + 2] * b.m[6 + column]));
    });
  }
  [[nodiscard]] Tensor transposed() const {
    return each([&](int i) { return m[3 * (i % 3) + i / 3]; });
  }
  [[nodiscard]] T trace() const { return m[0] + m[4] + m[8]; }
  [[nodiscard]] Tensor symmetric() const {
    const T half = number<T>(0.5);
    return each([&](int i) { return (m[i] + m[3 * (i % 3) + i / 3]) * half; });
  }
  [[nodiscard]] Tensor deviator() const {
    const T mean = trace() * number<T>(1.0 / 3);
    return each([&](int i) { return i % 4 == 0 ? m[i] - mean : m[i]; });
  }
};

/// Sum of the products of all nine components.
template <class T>
T contract(const Tensor<T>& a, const Tensor<T>& b) {
  T sum = a.m[0] * b.m[0];
  for (int i = 1; i < 9; ++i) sum = fused(a.m[i], b.m[i], sum);
  return sum;
}

/// a s + b.
template <class T>
Tensor<T> scaled_sum(const Tensor<T>& a, const T& s, const Tensor<T>& b) {
  return Tensor<T>::each([&](int i) { return fused(a.m[i], s, b.m[i]); });
}

/// Derivative of the cofactors of a along b.
template <class T>
Tensor<T> cofactor_change(const Tensor<T>& a, const Tensor<T>& b) {
  return Tensor<T>::each([&](int i) {
    const int r = i / 3, c = i % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return fused(a(r1, c1), b(r2, c2), b(r1, c1) * a(r2, c2)) -
           fused(a(r1, c2), b(r2, c1), b(r1, c2) * a(r2, c1));
  });
}
template <class T>
Tensor<T> cofactor(const Tensor<T>& a) {
  return Tensor<T>::each([&](int i) {
    const int r = i / 3, c = i % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
    return fused(a(r1, c1), a(r2, c2), -(a(r1, c2) * a(r2, c1)));
  });
}

/// Three per cent about x^(−⅓), x > 0 among floats: the exponent divided by minus three.
inline float rough_inverse_cube_root(float x) {
  return std::bit_cast<float>(0x54a21d2a - std::bit_cast<std::int32_t>(x) / 3);
}
template <class T>
T rough_inverse_cube_root(const T& x) {
  if constexpr (std::is_same_v<T, double>) {
    return rough_inverse_cube_root(static_cast<float>(x));
  } else if constexpr (std::is_same_v<T, Floats>) {
    using Bits = std::int32_t __attribute__((vector_size(32)));
    return std::bit_cast<Floats>(0x54a21d2a - std::bit_cast<Bits>(x) / 3);
  } else if constexpr (std::is_same_v<T, Lanes>) {
    using Bits = std::int32_t __attribute__((vector_size(16)));
    const auto few = __builtin_convertvector(x, HalfFloats);
    return __builtin_convertvector(std::bit_cast<HalfFloats>(0x54a21d2a - std::bit_cast<Bits>(few) / 3),
                                   Lanes);
  } else {
    return T::each([&](int i) { return rough_inverse_cube_root(x.v[i]); });
  }
}

/// x^(−⅓) to round-off, x > 0 within what a float holds; anything elsewhere. The same bits in lanes as alone.
template <class T>
T inverse_cube_root(const T& x) {
  T y = rough_inverse_cube_root(x);
  for (int step = 0; step < 2; ++step) {  // (1 − h)^(−⅓) to its third power: fourth order
    const T h = number<T>(1) - x * (y * y * y);
    y = y + y * (h * (number<T>(1.0 / 3) + h * (number<T>(2.0 / 9) + h * number<T>(14.0 / 81))));
  }
  return y;
}

}  // namespace turgor::detail
