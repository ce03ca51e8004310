// The laws of fem/elastic_material.hpp at one point. Of the gradient of the displacement h = F − 1, from
// which small strains keep their digits, LawPoint<law, T> has the energy density W of the part that changes
// shape, P = ∂W/∂F, θ and ∂θ/∂F, and applies the second derivatives. T is a number or lanes of numbers; of
// the corotational law double alone. Internal.
//
// An element of points g with weights w (mm³, sum V) and mean θ̄ = Σ w θ / V then has the energy
// Σ w W + ½ K V θ̄², the forces Σ w (P + p ∂θ/∂F) ∇N with p = K θ̄, and the stiffness
// Σ w ∇N tangent(·, p) ∇N + (K / V) b bᵀ with b = Σ w ∂θ/∂F ∇N.
#pragma once

#include <Eigen/Core>

#include "fem/tensor.hpp"
#include "turgor/fem/elastic_material.hpp"

namespace turgor::detail {

/// What a law needs besides K, each lane its own.
template <class T>
struct LawModuli {
  T shear;  ///< μ, MPa
  T c20;    ///< MPa, of mooney_rivlin
};
inline LawModuli<double> moduli_of(const ElasticMaterial& m) {
  return {m.shear_modulus(), m.c20_mpa};
}

/// The laws of J have no energy below this ratio of volumes: turned over.
inline constexpr double kLeastVolumeRatio = 1e-6;

template <ElasticLaw law, class T>
class LawPoint;

template <class T>
class LawPoint<ElasticLaw::linear, T> {
 public:
  LawPoint(const Tensor<T>& h, const LawModuli<T>& moduli)
      : two_mu_(moduli.shear + moduli.shear),
        strain_(h.symmetric().deviator()),
        stress_(strain_ * two_mu_),
        theta_(h.trace()) {}

  /// False where the law has no energy in some lane; the rest then says nothing.
  [[nodiscard]] static bool valid() { return true; }
  [[nodiscard]] T energy() const { return contract(stress_, strain_) * number<T>(0.5); }
  /// P, the first Piola–Kirchhoff stress of the shape.
  [[nodiscard]] const Tensor<T>& stress() const { return stress_; }
  [[nodiscard]] const T& theta() const { return theta_; }
  [[nodiscard]] Tensor<T> theta_gradient() const { return Tensor<T>::unit(); }
  /// (∂P/∂F + pressure ∂²θ/∂F²) : df.
  [[nodiscard]] Tensor<T> tangent(const Tensor<T>& df, const T& /*pressure*/) const {
    return df.symmetric().deviator() * two_mu_;
  }

 private:
  T two_mu_;
  Tensor<T> strain_, stress_;  // strain: its deviator
  T theta_;
};

template <class T>
class LawPoint<ElasticLaw::st_venant_kirchhoff, T> {
 public:
  LawPoint(const Tensor<T>& h, const LawModuli<T>& moduli)
      : two_mu_(moduli.shear + moduli.shear),
        f_(h + Tensor<T>::unit()),
        strain_(scaled_sum(h.transposed() * h, number<T>(0.5), h.symmetric())),
        second_(strain_.deviator() * two_mu_),
        stress_(f_ * second_),
        theta_(strain_.trace()) {}

  [[nodiscard]] static bool valid() { return true; }
  [[nodiscard]] T energy() const { return contract(second_, strain_) * number<T>(0.5); }
  [[nodiscard]] const Tensor<T>& stress() const { return stress_; }
  [[nodiscard]] const T& theta() const { return theta_; }
  [[nodiscard]] const Tensor<T>& theta_gradient() const { return f_; }
  [[nodiscard]] Tensor<T> tangent(const Tensor<T>& df, const T& pressure) const {
    const Tensor<T> turned = scaled_sum(df, pressure, df * second_);
    return turned + f_ * ((f_.transposed() * df).symmetric().deviator() * two_mu_);
  }

 private:
  T two_mu_;
  Tensor<T> f_, strain_, second_, stress_;  // F, Green's strain, second and first Piola–Kirchhoff stress
  T theta_;
};

/// Neo-Hookean and Mooney-Rivlin: W of Ī1, θ = J − 1.
template <ElasticLaw law, class T>
class FirstInvariantPoint {
 public:
  FirstInvariantPoint(const Tensor<T>& h, const LawModuli<T>& moduli) : f_(h + Tensor<T>::unit()) {
    const Tensor<T> unit = Tensor<T>::unit(), of_h = cofactor(h);
    const T one = number<T>(1), h_trace = h.trace(), h_squares = contract(h, h);
    const Tensor<T> cofactor_less_one = (unit * h_trace - h.transposed()) + of_h;
    cofactor_ = unit + cofactor_less_one;
    // J = 1 + tr h + tr cof h + det h
    const T beyond_trace =
        of_h.trace() + fused(h(0, 0), of_h(0, 0), fused(h(0, 1), of_h(0, 1), h(0, 2) * of_h(0, 2)));
    theta_ = h_trace + beyond_trace;
    per_j_ = one / (one + theta_);
    const T r = inverse_cube_root(one + theta_), series = one / fused(r, r, one + r);
    scale_ = r * r;
    third_ = (h_trace + h_trace + h_squares + number<T>(3)) * per_j_ * number<T>(1.0 / 3);
    // Ī1 − 3 without its parts of first order, which cancel: with r³ = 1/J, 1 − r = θ r³ / (1 + r + r²).
    const T of_theta = theta_ * series * scale_;
    const T excess =
        scale_ * (h_squares - (beyond_trace + beyond_trace)) + of_theta * of_theta * r * (number<T>(2) + r);
    slope_ = moduli.shear * number<T>(0.5), curve_ = number<T>(0), energy_ = slope_ * excess;
    if constexpr (law == ElasticLaw::mooney_rivlin) {
      curve_ = moduli.c20 + moduli.c20;
      slope_ = fused(curve_, excess, slope_);
      energy_ = fused(moduli.c20 * excess, excess, energy_);
    }
    const T one_less_third =
        (theta_ + (beyond_trace + beyond_trace) - h_squares) * per_j_ * number<T>(1.0 / 3);
    direction_ = (h + unit * one_less_third - cofactor_less_one * third_) * (scale_ + scale_);
    stress_ = direction_ * slope_;
  }

  [[nodiscard]] bool valid() const {
    return all_above(theta_, kLeastVolumeRatio - 1) && all_above(-theta_, -1e30);
  }
  [[nodiscard]] const T& energy() const { return energy_; }
  [[nodiscard]] const Tensor<T>& stress() const { return stress_; }
  [[nodiscard]] const T& theta() const { return theta_; }
  [[nodiscard]] const Tensor<T>& theta_gradient() const { return cofactor_; }
  [[nodiscard]] Tensor<T> tangent(const Tensor<T>& df, const T& pressure) const {
    const T log_change = contract(cofactor_, df) * per_j_;  // of J
    const T third_change = contract(f_, df) * per_j_ * number<T>(2.0 / 3) - third_ * log_change;
    const T factor = (scale_ + scale_) * slope_;
    T along = slope_ * log_change * number<T>(-2.0 / 3);
    if constexpr (law == ElasticLaw::mooney_rivlin) along = fused(curve_, contract(direction_, df), along);
    const Tensor<T> straight = scaled_sum(df, factor, direction_ * along);
    const Tensor<T> across = scaled_sum(cofactor_, -(third_change * factor), straight);
    return scaled_sum(cofactor_change(f_, df), pressure - third_ * factor, across);
  }

 private:
  Tensor<T> f_, cofactor_, direction_, stress_;  // F, ∂J/∂F, ∂Ī1/∂F
  T theta_, per_j_, scale_, third_;              // 1/J, J^(−2/3), tr FᵀF / (3 J)
  T energy_, slope_, curve_;                     // W of Ī1 and its derivatives
};
template <class T>
class LawPoint<ElasticLaw::neo_hookean, T> : public FirstInvariantPoint<ElasticLaw::neo_hookean, T> {
  using FirstInvariantPoint<ElasticLaw::neo_hookean, T>::FirstInvariantPoint;
};
template <class T>
class LawPoint<ElasticLaw::mooney_rivlin, T> : public FirstInvariantPoint<ElasticLaw::mooney_rivlin, T> {
  using FirstInvariantPoint<ElasticLaw::mooney_rivlin, T>::FirstInvariantPoint;
};

template <>
class LawPoint<ElasticLaw::corotational, double> {
 public:
  LawPoint(const Tensor<double>& h, const LawModuli<double>& moduli);

  /// False where two principal stretches sum to zero or less: turned over so far that R jumps.
  [[nodiscard]] bool valid() const { return valid_; }
  [[nodiscard]] double energy() const;
  [[nodiscard]] const Tensor<double>& stress() const { return stress_; }
  [[nodiscard]] double theta() const { return theta_; }
  [[nodiscard]] const Tensor<double>& theta_gradient() const { return rotation_; }
  [[nodiscard]] Tensor<double> tangent(const Tensor<double>& df, double pressure) const;
  /// S − 1 of F = R S.
  [[nodiscard]] const Tensor<double>& strain() const { return strain_; }

 private:
  bool valid_ = true;
  double two_mu_;
  Tensor<double> rotation_{}, strain_{}, stress_{};
  double theta_ = 0;
  Eigen::Matrix3d turning_;  // (tr S 1 − S)⁻¹: the turn of R from the skew part of Rᵀ dF
};

/// Calls f.operator()<law>() of a law known at run time.
template <class Function>
auto with_law(ElasticLaw law, Function&& f) {
  switch (law) {
    case ElasticLaw::corotational:
      return f.template operator()<ElasticLaw::corotational>();
    case ElasticLaw::st_venant_kirchhoff:
      return f.template operator()<ElasticLaw::st_venant_kirchhoff>();
    case ElasticLaw::neo_hookean:
      return f.template operator()<ElasticLaw::neo_hookean>();
    case ElasticLaw::mooney_rivlin:
      return f.template operator()<ElasticLaw::mooney_rivlin>();
    default:
      return f.template operator()<ElasticLaw::linear>();
  }
}

/// Of a law known at run time.
struct LawResponse {
  bool valid = false;  ///< false: no energy, or a number that is not finite; the rest then says nothing
  double energy = 0;
  Tensor<double> stress{};
  double theta = 0;
  Tensor<double> theta_gradient{};
};
LawResponse law_response(const ElasticMaterial& material, const Tensor<double>& h);
/// ∂P/∂F + pressure ∂²θ/∂F²: symmetric, components as in Tensor::m.
Eigen::Matrix<double, 9, 9> law_tangent(const ElasticMaterial& material, const Tensor<double>& h,
                                        double pressure);

}  // namespace turgor::detail
