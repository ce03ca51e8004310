// Symmetric matrices of eight cubes side by side, the upper halves by rows. Internal.
#pragma once

#include "fem/cube_modes.hpp"
#include "fem/tensor.hpp"

namespace turgor::detail {

/// y = M x.
template <std::size_t n>
void multiply_packed(const float* matrix, const Floats (&x)[n], Floats (&y)[n]) {
  constexpr std::size_t lanes = static_cast<std::size_t>(Pack<Floats>::lanes);
  for (Floats& v : y) v = Floats{};
  for (std::size_t p = 0; p < n; ++p) {
    const Floats own = x[p];
    Floats sum = multiply_add<Floats>(load<Floats>(matrix), own, y[p]);
    matrix += lanes;
    for (std::size_t q = p + 1; q < n; ++q, matrix += lanes) {
      const Floats m = load<Floats>(matrix);
      sum = multiply_add<Floats>(m, x[q], sum);
      y[q] = multiply_add<Floats>(m, own, y[q]);
    }
    y[p] = sum;
  }
}

}  // namespace turgor::detail
