#include "abbe/fit/independent_columns.h"

#include <Eigen/QR>
#include <cmath>

namespace abbe {
namespace {

constexpr double kWorthNaming = 1e-6;  // share of a column of length 1

/// The column as a combination of the kept ones, by least squares; small shares left out.
DependentColumn combination(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& kept,
                            Eigen::Index column) {
  DependentColumn out{column, {}};
  Eigen::MatrixXd others(matrix.rows(), static_cast<Eigen::Index>(kept.size()));
  Eigen::VectorXd length(others.cols());
  for (Eigen::Index k = 0; k < others.cols(); ++k) {
    others.col(k) = matrix.col(kept[static_cast<std::size_t>(k)]);
    length[k] = others.col(k).norm();
    others.col(k) /= length[k];
  }
  const double own = matrix.col(column).norm();
  const Eigen::VectorXd share = others.householderQr().solve(matrix.col(column) / own);
  for (Eigen::Index k = 0; k < share.size(); ++k)
    if (std::abs(share[k]) > kWorthNaming)
      out.like.emplace_back(kept[static_cast<std::size_t>(k)], share[k] * own / length[k]);
  return out;
}

}  // namespace

IndependentColumns independent_columns(const Eigen::MatrixXd& matrix, double tolerance) {
  IndependentColumns out;
  Eigen::MatrixXd basis(matrix.rows(), matrix.cols());
  Eigen::Index rank = 0;
  const double largest = matrix.cols() > 0 ? matrix.colwise().norm().maxCoeff() : 0;
  for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
    const double length = matrix.col(j).norm();
    if (!(length > 1e-14 * largest)) {
      out.dependent.push_back({j, {}});
      continue;
    }
    Eigen::VectorXd rest = matrix.col(j) / length;
    // Twice: once leaves rounding of the first subtraction.
    for (int pass = 0; pass < 2; ++pass)
      rest -= basis.leftCols(rank) * (basis.leftCols(rank).transpose() * rest);
    if (rest.norm() > tolerance && rank < matrix.rows()) {
      basis.col(rank++) = rest.normalized();
      out.kept.push_back(j);
    } else {
      out.dependent.push_back(combination(matrix, out.kept, j));
    }
  }
  return out;
}

}  // namespace abbe
