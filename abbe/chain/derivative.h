#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

namespace abbe {

/// A number that carries its derivatives with respect to N variables: forward differentiation. The
/// walk over the chain runs on it unchanged.
///
/// laws   DerivativeScalarEqualsDifference
template <int N>
struct Derivative {
  double a = 0;                                         ///< the value
  std::array<double, static_cast<std::size_t>(N)> v{};  ///< its derivatives

  Derivative() = default;
  Derivative(double x) : a(x) {}  // NOLINT: constants mix freely with variables
  [[nodiscard]] static Derivative variable(double at, int index) {
    Derivative x(at);
    x.v[static_cast<std::size_t>(index)] = 1;
    return x;
  }

  /// f(x) with f'(x) known: the chain rule.
  [[nodiscard]] static Derivative chain(double f, double df, const Derivative& x) {
    Derivative r(f);
    for (std::size_t i = 0; i < r.v.size(); ++i) r.v[i] = df * x.v[i];
    return r;
  }

  Derivative& operator+=(const Derivative& b) {
    a += b.a;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] += b.v[i];
    return *this;
  }
  Derivative& operator-=(const Derivative& b) {
    a -= b.a;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= b.v[i];
    return *this;
  }
  Derivative& operator*=(const Derivative& b) {
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = v[i] * b.a + a * b.v[i];
    a *= b.a;
    return *this;
  }
  Derivative& operator/=(const Derivative& b) {
    const double inverse = 1 / b.a;
    a *= inverse;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = (v[i] - a * b.v[i]) * inverse;
    return *this;
  }

  friend Derivative operator+(Derivative x, const Derivative& y) { return x += y; }
  friend Derivative operator-(Derivative x, const Derivative& y) { return x -= y; }
  friend Derivative operator*(Derivative x, const Derivative& y) { return x *= y; }
  friend Derivative operator/(Derivative x, const Derivative& y) { return x /= y; }
  friend Derivative operator-(const Derivative& x) { return chain(-x.a, -1, x); }

  friend bool operator==(const Derivative& x, const Derivative& y) { return x.a == y.a; }
  friend bool operator!=(const Derivative& x, const Derivative& y) { return x.a != y.a; }
  friend bool operator<(const Derivative& x, const Derivative& y) { return x.a < y.a; }
  friend bool operator>(const Derivative& x, const Derivative& y) { return x.a > y.a; }
  friend bool operator<=(const Derivative& x, const Derivative& y) { return x.a <= y.a; }
  friend bool operator>=(const Derivative& x, const Derivative& y) { return x.a >= y.a; }

  friend Derivative sin(const Derivative& x) { return chain(std::sin(x.a), std::cos(x.a), x); }
  friend Derivative cos(const Derivative& x) { return chain(std::cos(x.a), -std::sin(x.a), x); }
  friend Derivative sqrt(const Derivative& x) {
    const double r = std::sqrt(x.a);
    return chain(r, r > 0 ? 0.5 / r : 0.0, x);
  }
};

/// The plain number of a scalar: what decisions are taken on.
[[nodiscard]] inline double value_of(double x) { return x; }
template <int N>
[[nodiscard]] double value_of(const Derivative<N>& x) {
  return x.a;
}

}  // namespace abbe

template <int N>
struct Eigen::NumTraits<abbe::Derivative<N>> : Eigen::GenericNumTraits<double> {
  using Real = abbe::Derivative<N>;
  using NonInteger = abbe::Derivative<N>;
  using Nested = abbe::Derivative<N>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = N,
    AddCost = N,
    MulCost = 2 * N
  };
};
