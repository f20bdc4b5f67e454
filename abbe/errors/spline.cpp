#include "abbe/errors/spline.h"

#include <cstddef>

namespace abbe {
namespace {

// A symmetric, diagonally dominant tridiagonal system: such systems need no pivoting.
struct Tridiagonal {
  std::vector<double> diagonal;
  std::vector<double> off;  // off[i] couples i and i + 1

  // Solves for `right` in place.
  void solve(std::vector<double>& right) const {
    const std::size_t n = diagonal.size();
    std::vector<double> pivot = diagonal;
    for (std::size_t i = 1; i < n; ++i) {
      const double factor = off[i - 1] / pivot[i - 1];
      pivot[i] -= factor * off[i - 1];
      right[i] -= factor * right[i - 1];
    }
    for (std::size_t i = n; i-- > 0;) {
      if (i + 1 < n) right[i] -= off[i] * right[i + 1];
      right[i] /= pivot[i];
    }
  }
};

double step(std::span<const double> x, std::size_t i) { return x[i + 1] - x[i]; }
double slope(std::span<const double> x, std::span<const double> e, std::size_t i) {
  return (e[i + 1] - e[i]) / step(x, i);
}

}  // namespace

std::vector<double> natural_spline(std::span<const double> positions, std::span<const double> values) {
  const std::size_t n = positions.size();
  std::vector<double> second(n, 0.0);
  if (n < 3) return second;
  Tridiagonal system;
  std::vector<double> right;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    system.diagonal.push_back(2 * (step(positions, i - 1) + step(positions, i)));
    system.off.push_back(step(positions, i));
    right.push_back(6 * (slope(positions, values, i) - slope(positions, values, i - 1)));
  }
  system.solve(right);
  for (std::size_t i = 1; i + 1 < n; ++i) second[i] = right[i - 1];
  return second;
}

std::vector<double> periodic_spline(std::span<const double> positions, std::span<const double> values) {
  const std::size_t n = positions.size() - 1;  // unknowns M_0 .. M_{n-1}; M_n = M_0
  std::vector<double> second(n + 1, 0.0);
  if (n < 2) return second;
  Tridiagonal system;
  std::vector<double> right;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t before = i > 0 ? i - 1 : n - 1;
    system.diagonal.push_back(2 * (step(positions, before) + step(positions, i)));
    system.off.push_back(step(positions, i));
    right.push_back(6 * (slope(positions, values, i) - slope(positions, values, before)));
  }
  const double corner = step(positions, n - 1);  // couples M_0 and M_{n-1}
  if (n == 2) {
    // Both neighbours of a sample are the other one: (2 s, s; s, 2 s) with s the period.
    const double s = step(positions, 0) + corner;
    second[0] = (2 * right[0] - right[1]) / (3 * s);
    second[1] = (2 * right[1] - right[0]) / (3 * s);
    second[2] = second[0];
    return second;
  }
  // Sherman and Morrison: A = A' + u u^T * corner with u = (1, 0 .. 0, 1), A' tridiagonal.
  system.diagonal.front() -= corner;
  system.diagonal.back() -= corner;
  std::vector<double> seam(n, 0.0);
  seam.front() = seam.back() = corner;
  system.solve(right);
  system.solve(seam);
  // M = y - z (u^T y) / (1 + u^T z) with A' y = r, A' z = corner u
  const double share = (right.front() + right.back()) / (1 + seam.front() + seam.back());
  for (std::size_t i = 0; i < n; ++i) second[i] = right[i] - share * seam[i];
  second[n] = second[0];
  return second;
}

}  // namespace abbe
