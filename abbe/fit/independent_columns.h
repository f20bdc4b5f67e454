#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace abbe {

/// A column that is a combination of columns before it: nothing that was measured tells them apart.
struct DependentColumn {
  Eigen::Index column = 0;
  /// One unit of the column does what these amounts of the others do; empty: the column is zero.
  std::vector<std::pair<Eigen::Index, double>> like;
};

/// Columns kept, in order, and those left out.
struct IndependentColumns {
  std::vector<Eigen::Index> kept;
  std::vector<DependentColumn> dependent;
};

/// Goes through the columns of a matrix (or of its triangular factor) from left to right and leaves out each
/// one whose part perpendicular to those kept is below `tolerance` of its length. Unlike a least-norm
/// solution it says which unknown was set to zero, and the order of the columns decides which, not their
/// units. laws     NamesTheCombination, OrderDecides cost     columns^2 * rows
[[nodiscard]] IndependentColumns independent_columns(const Eigen::MatrixXd& matrix, double tolerance);

}  // namespace abbe
