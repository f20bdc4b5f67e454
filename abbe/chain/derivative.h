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
    a /= b.a;
    for (std::size_t i = 0; i < v.size(); ++i) v[i] = (v[i] - a * b.v[i]) / b.a;
    return *this;
  }

  friend Derivative operator+(Derivative a, const Derivative& b) { return a += b; }
  friend Derivative operator-(Derivative a, const Derivative& b) { return a -= b; }
  friend Derivative operator*(Derivative a, const Derivative& b) { return a *= b; }
  friend Derivative operator/(Derivative a, const Derivative& b) { return a /= b; }
  friend Derivative operator-(const Derivative& a) { return chain(-a.a, -1, a); }

  friend bool operator==(const Derivative& a, const Derivative& b) { return a.a == b.a; }
  friend bool operator!=(const Derivative& a, const Derivative& b) { return a.a != b.a; }
  friend bool operator<(const Derivative& a, const Derivative& b) { return a.a < b.a; }
  friend bool operator>(const Derivative& a, const Derivative& b) { return a.a > b.a; }
  friend bool operator<=(const Derivative& a, const Derivative& b) { return a.a <= b.a; }
  friend bool operator>=(const Derivative& a, const Derivative& b) { return a.a >= b.a; }

  friend Derivative sin(const Derivative& a) { return chain(std::sin(a.a), std::cos(a.a), a); }
  friend Derivative cos(const Derivative& a) { return chain(std::cos(a.a), -std::sin(a.a), a); }
  friend Derivative sqrt(const Derivative& a) {
    const double r = std::sqrt(a.a);
    return chain(r, r > 0 ? 0.5 / r : 0.0, a);
  }
  friend Derivative abs(const Derivative& a) { return a.a < 0 ? -a : a; }
  friend Derivative floor(const Derivative& a) { return Derivative(std::floor(a.a)); }
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
