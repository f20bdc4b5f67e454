#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "abbe/fit/drift_courses.h"
#include "abbe/fit/log_freedom.h"

namespace abbe {

/// A sensor as a model uses it.
struct ThermalInput {
  std::size_t sensor = 0;
  double lag = 0;  ///< s; 0: as it was read
  friend bool operator==(const ThermalInput&, const ThermalInput&) = default;
};

/// Several logs below each other: columns of temperatures, each log with a zero of its own.
class ThermalColumns {
 public:
  /// `courses` that are all of one kind (fit, or validation).
  explicit ThermalColumns(std::vector<const DriftCourse*> courses);

  [[nodiscard]] Eigen::Index rows() const { return rows_; }
  [[nodiscard]] std::size_t logs() const { return courses_.size(); }
  /// Shortest sensible lag (two steps of time) and the longest that a log can show (its duration).
  [[nodiscard]] std::pair<double, double> lag_range() const;

  /// degC.
  [[nodiscard]] Eigen::VectorXd temperature(const ThermalInput& input) const;
  /// The course of error k, um or urad.
  [[nodiscard]] Eigen::VectorXd error(Eigen::Index k) const;
  /// Every log's mean taken off.
  [[nodiscard]] Eigen::VectorXd centred(Eigen::VectorXd column) const;
  [[nodiscard]] Eigen::MatrixXd centred(const std::vector<ThermalInput>& inputs) const;

  /// What the logs have for themselves beside inputs of these lags.
  [[nodiscard]] LogFreedom freedom(const std::vector<ThermalInput>& inputs) const;
  /// degC, one column per input.
  [[nodiscard]] Eigen::MatrixXd temperatures(const std::vector<ThermalInput>& inputs) const;

  /// Seconds from the start of a log, at its rows.
  [[nodiscard]] Eigen::VectorXd since_start(std::size_t log) const;
  /// 1 in the rows of a log, 0 in the others.
  [[nodiscard]] Eigen::VectorXd indicator(std::size_t log) const;

  /// Noise of an error's course: from its second differences, which slow courses leave alone.
  ///   u^2 = mean((y_(i-1) - 2 y_i + y_(i+1))^2) / 6
  [[nodiscard]] double noise(Eigen::Index k) const;

  /// Blocks of rows that follow each other in one log: those that cross-validation leaves out.
  [[nodiscard]] std::vector<std::pair<Eigen::Index, Eigen::Index>> blocks() const;

 private:
  template <class PerLog>
  [[nodiscard]] Eigen::VectorXd stacked(const PerLog& per_log) const;

  std::vector<const DriftCourse*> courses_;
  std::vector<Eigen::Index> first_;  ///< row of each log, and the end
  Eigen::Index rows_ = 0;
};

}  // namespace abbe
