#include "abbe/chain/pseudo_inverse.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr int kN = SmallMatrix::kRows;
using Square = std::array<std::array<double, kN>, kN>;

/// Cyclic Jacobi: m becomes diagonal, the columns of v its eigenvectors.
void diagonalise(Square& m, Square& v, int n) {
  v = {};
  for (std::size_t i = 0; i < kN; ++i) v[i][i] = 1;
  const auto size = static_cast<std::size_t>(n);
  for (int sweep = 0; sweep < 30; ++sweep) {
    double off = 0, diagonal = 0;
    for (std::size_t p = 0; p < size; ++p) {
      diagonal += m[p][p] * m[p][p];
      for (std::size_t q = p + 1; q < size; ++q) off += m[p][q] * m[p][q];
    }
    if (!(off > 1e-36 * diagonal)) return;
    for (std::size_t p = 0; p < size; ++p) {
      for (std::size_t q = p + 1; q < size; ++q) {
        if (m[p][q] == 0) continue;
        // t = tan of the angle that makes m_pq zero
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (std::size_t k = 0; k < size; ++k) {
          const double kp = m[k][p], kq = m[k][q];
          m[k][p] = c * kp - s * kq;
          m[k][q] = s * kp + c * kq;
        }
        for (std::size_t k = 0; k < size; ++k) {
          const double pk = m[p][k], qk = m[q][k];
          m[p][k] = c * pk - s * qk;
          m[q][k] = s * pk + c * qk;
        }
        for (std::size_t k = 0; k < size; ++k) {
          const double kp = v[k][p], kq = v[k][q];
          v[k][p] = c * kp - s * kq;
          v[k][q] = s * kp + c * kq;
        }
      }
    }
  }
}

}  // namespace

SmallMatrix pseudo_inverse(const SmallMatrix& a, int& rank, double least) {
  const auto rows = static_cast<std::size_t>(a.rows), count = static_cast<std::size_t>(a.count);
  // a^+ = a^T (a a^T)^+ ; a a^T is small and symmetric
  Square gram{}, vectors{};
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < rows; ++j) {
      for (std::size_t k = 0; k < count; ++k) gram[i][j] += a.columns[k][i] * a.columns[k][j];
    }
  }
  diagonalise(gram, vectors, a.rows);
  double largest = 0;
  for (std::size_t i = 0; i < rows; ++i) largest = std::max(largest, gram[i][i]);

  SmallMatrix inverse;
  inverse.rows = a.rows;
  inverse.count = a.count;
  for (std::size_t k = 0; k < count; ++k) inverse.columns[k] = {};
  rank = 0;
  for (std::size_t e = 0; e < rows; ++e) {
    if (!(gram[e][e] > least * least * largest)) continue;  // eigenvalues are squares of singular values
    ++rank;
    for (std::size_t k = 0; k < count; ++k) {
      double dot = 0;
      for (std::size_t i = 0; i < rows; ++i) dot += a.columns[k][i] * vectors[i][e];
      for (std::size_t i = 0; i < rows; ++i) inverse.columns[k][i] += dot * vectors[i][e] / gram[e][e];
    }
  }
  return inverse;
}

}  // namespace abbe
