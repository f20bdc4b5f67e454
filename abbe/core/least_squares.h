#pragma once

#include <Eigen/Core>
#include <span>

namespace abbe {

/// The rows of a linear least-squares problem A x ~ b, folded as they come into the triangular factor of
/// [A b] (a sequential TSQR): memory does not grow with the rows, and nothing is squared.
///
///     [A b] = Q [R c; 0 rho],   R upper triangular m x m,   |A x - b|^2 = |R x - c|^2 + rho^2
///
/// shapes   m unknowns; weighted rows: divide row and value by the standard uncertainty of the value
/// errors   a row that is not finite is not added and is_finite() turns false
/// laws     FactorOfBlocksEqualsFactorOfTheWhole, FactorKeepsTheGramMatrix
/// cost     2 (m + 1)^2 operations per row in vectors of the processor (docs/performance.md); one block of
/// kBlock
///          rows of memory
/// source   Demmel, Grigori, Hoemmen, Langou: Communication-optimal QR (2012), section 2
class TriangularFactor {
 public:
  static constexpr Eigen::Index kBlock = 256;

  explicit TriangularFactor(Eigen::Index unknowns);

  void add(std::span<const double> row, double value);
  /// k rows at once, k x m and k.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& rows, const Eigen::Ref<const Eigen::VectorXd>& values);
  /// The rows of another factor of as many unknowns: two files, two threads.
  void add(const TriangularFactor& other);

  [[nodiscard]] Eigen::Index unknowns() const { return m_; }
  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  [[nodiscard]] bool is_finite() const { return finite_; }
  /// [R c; 0 rho], (m + 1) x (m + 1).
  [[nodiscard]] Eigen::MatrixXd factor() const;

 private:
  void fold();

  Eigen::Index m_;
  Eigen::Index rows_ = 0;
  Eigen::Index used_ = 0;  ///< rows of block_ that wait to be folded; the others are 0
  bool finite_ = true;
  Eigen::MatrixXd factor_;  ///< (m + 1) x (m + 1), upper triangular
  Eigen::MatrixXd block_;   ///< kBlock x (m + 1)
};

struct LeastSquaresOptions {
  /// Singular values below tolerance times the largest one count as zero.
  double tolerance = 1e-9;
  /// True: columns are brought to length 1 first, so that units do not decide what is small. The least
  /// norm is then that of the scaled unknowns.
  bool scale_columns = true;
};

/// The solution of least norm, and what the rows can tell at all.
///
///     A D = U S V^T,  x = D V_1 S_1^-1 U_1^T b,  D = diag(1 / column length) or I
///     null space: the columns of D V_2;   cofactor = D V_1 S_1^-2 V_1^T D
///
/// The covariance of x is cofactor times the variance of a row (1 if the rows were weighted with true
/// uncertainties). For an unknown with determined < 1 cofactor is that of its determined part.
struct LeastSquaresSolution {
  enum class Status {
    ok,
    no_rows,     ///< nothing was added
    not_finite,  ///< some row was not, or the numbers overflow
  } status = Status::ok;
  Eigen::VectorXd x;      ///< m
  Eigen::Index rank = 0;  ///< of A by the tolerance
  Eigen::Index rows = 0;
  Eigen::VectorXd singular_values;  ///< m, decreasing, of A D
  Eigen::VectorXd column_length;    ///< m; 1 / D
  Eigen::MatrixXd null_space;       ///< m x (m - rank): A n = 0 for every column n
  Eigen::MatrixXd root;             ///< m x rank: cofactor = root root^T, and A root has orthonormal columns
  Eigen::MatrixXd cofactor;         ///< m x m
  Eigen::VectorXd determined;       ///< m: 1 the rows determine this unknown, 0 they say nothing about it
  double sum_of_squares = 0;        ///< |A x - b|^2

  [[nodiscard]] bool ok() const { return status == Status::ok; }
  [[nodiscard]] Eigen::Index freedom() const { return rows - rank; }  ///< rows beyond what was fitted
  /// Of a row of weight 1, from the residuals; 0 without rows to spare.
  [[nodiscard]] double variance() const {
    return freedom() > 0 ? sum_of_squares / static_cast<double>(freedom()) : 0.0;
  }
};

/// errors   see Status; m = 0 gives an empty x
/// laws     EqualsPseudoInverse, NistCertifiedDigits, NullSpaceIsInvisible
/// cost     singular values of an m x m matrix
/// source   Golub, Van Loan: Matrix Computations, 5.5
[[nodiscard]] LeastSquaresSolution solve(const TriangularFactor& factor, const LeastSquaresOptions& options);

}  // namespace abbe
