#include "fem/cube_element.hpp"

#include <bit>
#include <utility>

namespace turgor::detail {
namespace {

constexpr int kCorners = 8;

constexpr std::size_t entry(int row, int column) {
  return static_cast<std::size_t>(kCubeUnknowns * row + column);
}

// +1 or −1: the mode's value at the corner.
constexpr double sign(int mode, int corner) {
  return std::popcount(static_cast<unsigned>(mode & ~corner)) % 2 == 0 ? 1.0 : -1.0;
}

constexpr int mode_number(int component, int parity) {
  return kCorners * component + (parity ^ (1 << component));
}

// To the basis of modes (transpose false: u at corners = sum of modes) on both sides.
CubeMatrix transformed(const CubeMatrix& m, bool to_modes) {
  CubeMatrix out{};
  for (int a = 0; a < kCubeUnknowns; ++a) {
    for (int b = 0; b < kCubeUnknowns; ++b) {
      double sum = 0;
      for (int i = 0; i < kCorners; ++i) {
        const double left = to_modes ? sign(a % kCorners, i) : sign(i, a % kCorners) / kCorners;
        for (int j = 0; j < kCorners; ++j) {
          const double right = to_modes ? sign(b % kCorners, j) : sign(j, b % kCorners) / kCorners;
          sum += left * m[entry(a / kCorners * kCorners + i, b / kCorners * kCorners + j)] * right;
        }
      }
      out[entry(a, b)] = sum;
    }
  }
  return out;
}

}  // namespace

CubeStiffness cube_stiffness(double edge) {
  // ∂/∂x = (2/h) ∂/∂ξ, the mean of ξ² is 1/3: every coefficient is a number times 4 h.
  const double unit = 4 * edge;
  CubeStiffness s;
  s.shear = {2 * unit, -2.0 / 3 * unit, unit, -2.0 / 9 * unit, unit, 10.0 / 27 * unit, unit / 3, unit / 3};
  s.bulk = {0, unit, 0, 0, 0, 0, 0, 0};
  return s;
}

CubeMatrix matrix_of(const CubeModes<double>& m) {
  CubeMatrix modal{};
  for (int parity = 0; parity < kCorners; ++parity) {
    const int members = std::popcount(static_cast<unsigned>(parity));
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) {
        double value = 0;
        const bool a_in = ((parity >> a) & 1) != 0, b_in = ((parity >> b) & 1) != 0;
        if (members == 0) value = m.axial_pair + (a == b ? m.axial : 0);
        if (members == 1 && !a_in && !b_in) value = m.bending_pair + (a == b ? m.bending : 0);
        if (members == 2 && a_in && b_in) value = m.shear;
        if (members == 2 && !a_in && !b_in) value = m.hourglass;
        if (members == 3) value = m.twist_pair + (a == b ? m.twist : 0);
        modal[entry(mode_number(a, parity), mode_number(b, parity))] = value;
      }
    }
  }
  return transformed(modal, false);
}

CubeModes<double> modes_of(const CubeMatrix& matrix) {
  const CubeMatrix m = transformed(matrix, true);
  const auto at = [&](int parity, int a, int b) {
    return m[entry(mode_number(a, parity), mode_number(b, parity))];
  };
  CubeModes<double> out{};
  out.axial_pair = at(0, 0, 1), out.axial = at(0, 0, 0) - out.axial_pair;
  out.bending_pair = at(1, 1, 2), out.bending = at(1, 1, 1) - out.bending_pair;
  out.shear = at(3, 0, 1), out.hourglass = at(3, 2, 2);
  out.twist_pair = at(7, 0, 1), out.twist = at(7, 0, 0) - out.twist_pair;
  return out;
}

CubeStiffness coarsened(const CubeStiffness& stiffness) {
  const auto coarse = [](const CubeModes<double>& modes) {
    const CubeMatrix fine = matrix_of(modes);
    CubeMatrix sum{};
    for (int child = 0; child < kCorners; ++child) add_galerkin(fine, child, sum);
    return modes_of(sum);
  };
  return {coarse(stiffness.shear), coarse(stiffness.bulk)};
}

namespace {

// Weights of the corners of a coarse cube at those of its children.
struct Weights {
  double of[kCorners][kCorners][kCorners] = {};  // child, its corner, coarse corner

  constexpr Weights() {
    for (int child = 0; child < kCorners; ++child) {
      for (int corner = 0; corner < kCorners; ++corner) {
        for (int coarse = 0; coarse < kCorners; ++coarse) {
          double weight = 1;
          for (int a = 0; a < 3; ++a) {
            const int place = ((child >> a) & 1) + ((corner >> a) & 1);
            weight *= ((coarse >> a) & 1) != 0 ? 0.5 * place : 1 - 0.5 * place;
          }
          of[child][corner][coarse] = weight;
        }
      }
    }
  }
};
constexpr Weights kWeights;

// out += Pᵀ in, for the eight rows of each component.
void restrict_rows(const CubeMatrix& in, int child, CubeMatrix& out) {
  for (int corner = 0; corner < kCorners; ++corner) {
    for (int coarse = 0; coarse < kCorners; ++coarse) {
      const double weight = kWeights.of[child][corner][coarse];
      if (weight == 0) continue;
      for (int c = 0; c < 3; ++c) {
        const double* from = &in[entry(kCorners * c + corner, 0)];
        double* to = &out[entry(kCorners * c + coarse, 0)];
        for (int k = 0; k < kCubeUnknowns; ++k) to[k] += weight * from[k];
      }
    }
  }
}

}  // namespace

void add_galerkin(const CubeMatrix& fine, int child, CubeMatrix& coarse) {
  CubeMatrix half{}, turned;
  restrict_rows(fine, child, half);
  for (int i = 0; i < kCubeUnknowns; ++i)
    for (int j = 0; j < kCubeUnknowns; ++j) turned[entry(i, j)] = half[entry(j, i)];
  restrict_rows(turned, child, coarse);
}

}  // namespace turgor::detail
