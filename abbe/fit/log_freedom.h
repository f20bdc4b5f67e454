#pragma once

#include <Eigen/Core>
#include <vector>

#include "abbe/fit/drift_courses.h"

namespace abbe {

/// What every log has for itself, whatever the model says: the zero of its instruments, and what the machine
/// still remembered when the log began. A lagged temperature that follows from the log alone is taken to
/// begin in equilibrium; a machine that was warm had another one, and the difference dies away with the lag:
///
///   N = [1, exp(-(t - t_0) / tau_1), exp(-(t - t_0) / tau_2), ..]     one column per different lag
///
/// A settled log (DriftCourse::settled) has its zero alone. What is left of a column beside N is what tells a
/// slope; columns of N that say nearly the same (1e-6 of their length) count once.
///
/// shapes   columns hold the rows of all logs below each other
/// laws     StartsAreTakenOff, SettledLogsKeepTheirStart
/// cost     rows * (1 + lags)^2 to make, rows * (1 + lags) per column taken
class LogFreedom {
 public:
  /// `lags` in s; those not above 0 and repeated ones need no column.
  LogFreedom(const std::vector<const DriftCourse*>& courses, const std::vector<double>& lags);

  /// The part of a column that no zero and no start can explain.
  [[nodiscard]] Eigen::VectorXd taken_off(Eigen::VectorXd column) const;
  /// As taken_off, but nothing (exact zeros) if less than 1e-3 of what the zeros leave is left: then the
  /// slope cannot be told from the starts.
  [[nodiscard]] Eigen::VectorXd told(const Eigen::VectorXd& column) const;

  /// Different lags above 0, in the order given.
  [[nodiscard]] const std::vector<double>& lags() const { return lags_; }
  [[nodiscard]] std::size_t logs() const { return logs_.size(); }
  /// False if log c is settled: its states at the start are known.
  [[nodiscard]] bool is_free(std::size_t log) const { return logs_[log].shape.cols() > 1; }
  /// Unknowns of all logs together.
  [[nodiscard]] Eigen::Index rank() const;

  /// Coefficients of N for one log that meet a column best (least norm among those that do): its zero, then
  /// the starts; as many rows as columns of N, one column per column of `columns`.
  [[nodiscard]] Eigen::MatrixXd coefficients(std::size_t log, const Eigen::MatrixXd& columns) const;
  /// (N^T N)^-1 of one log: their covariance for readings of variance 1.
  [[nodiscard]] Eigen::MatrixXd covariance(std::size_t log) const;
  /// The columns of N of one log, exp(-(t - t_0) / tau) from column 1 on, and its first row.
  [[nodiscard]] const Eigen::MatrixXd& shape(std::size_t log) const { return logs_[log].shape; }
  [[nodiscard]] Eigen::Index first(std::size_t log) const { return logs_[log].first; }

 private:
  struct Log {
    Eigen::Index first = 0;
    Eigen::MatrixXd shape;  ///< N
    Eigen::MatrixXd basis;  ///< orthonormal, of the same span
  };
  std::vector<double> lags_;
  std::vector<Log> logs_;
};

}  // namespace abbe
