#pragma once

#include <array>

#include "abbe/machine/machine.h"

namespace abbe {

/// A matrix of up to 5 rows and kMaxAxes columns, stored by columns.
struct SmallMatrix {
  static constexpr int kRows = 5;
  using Column = std::array<double, kRows>;
  std::array<Column, kMaxAxes> columns;  ///< the first `count`, each set to its end
  int rows = 0, count = 0;
};

/// The Moore-Penrose inverse of `a`, transposed: its columns are the rows of the inverse, so that
/// x_i = columns[i] . b is the least-squares solution of a x = b with the smallest norm. Directions whose
/// singular value is below `least` times the largest are left out of `rank`. No allocation.
[[nodiscard]] SmallMatrix pseudo_inverse(const SmallMatrix& a, int& rank, double least = 1e-7);

/// Three linear axes whose unit directions span less volume than this move the tip in two directions only: to
/// make up for 10 um in the third they would travel a millimetre and more. The same number for the least
/// singular value.
inline constexpr double kDependentAxes = 1e-2;

}  // namespace abbe
