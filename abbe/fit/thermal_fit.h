#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "abbe/fit/drift_courses.h"

namespace abbe {

/// One sensor's part of an error.
struct ThermalTerm {
  std::string sensor;
  double lag = 0;           ///< s; 0: the temperature itself
  double slope = 0, u = 0;  ///< um or urad per K
  double lo = 0, hi = 0;    ///< degC, of the (lagged) temperature in the logs fitted: the range of validity
};

/// What an error held at the start of a log from before it, dying away with a lag.
struct ThermalStart {
  std::size_t log = 0;      ///< number among the logs fitted, from 0
  double lag = 0;           ///< s
  double value = 0, u = 0;  ///< um or urad at the first row, beside a start in equilibrium
};

/// An error as a function of temperatures, zero at the reference:
///
///   e = sum_s slope_s (T_s,lagged - reference)
struct ThermalModel {
  std::string name;
  bool rotation = false;
  std::vector<ThermalTerm> terms;
  std::vector<ThermalStart> starts;       ///< of every log fitted whose start is not known, for every lag
  std::vector<std::string> undetermined;  ///< sensors asked for whose part cannot be told from the starts
  double before = 0;   ///< rms of the drift in the logs fitted, each about its mean; um or urad
  double noise = 0;    ///< of the readings, from second differences
  double left = 0;     ///< rms of what the model leaves of the same logs
  double crossed = 0;  ///< the same when each block of a log is predicted by a model fitted without it
  std::optional<double> validated_before, validated;  ///< of the logs that only judge
  /// Standard uncertainty of the error within the range of validity: that of the slopes and lags, and what
  /// the model leaves of unseen logs (else blocks) beyond the noise.
  double u = 0;
  /// The part of u that is not of the slopes: what the uncertainty of the lags adds to theirs at worst, and
  /// what the model leaves of unseen logs beyond the noise.
  double beyond_slopes = 0;
  bool misfit = false;  ///< leaves more than noise: a heat source, a lag or a sensor is missing
};

struct ThermalFit {
  std::vector<std::vector<std::string>> groups;  ///< of sensors that say nearly the same
  std::vector<std::string> still;                ///< sensors that did not change
  std::vector<std::string> outside;  ///< sensors whose validation logs leave the range of those fitted
  std::vector<ThermalModel> models;  ///< in the order of FitThermal::errors
  /// Of the slopes of all terms of all models in their order, um or urad per K; errors that are found from
  /// the same readings are uncertain together.
  Eigen::MatrixXd covariance;
  bool finite = true;  ///< false: numbers too large; no models
};

/// Models of every error that drifts.
///
/// - groups: sensors whose correlation is above `correlated`; of each group the one that follows the error
/// best
/// - stepwise: the sensor that lowers the cross-validated square most, as long as it takes a tenth of it away
/// - ridge: one sensor of each group, slopes shrunk; the penalty by cross-validation (fit_ridge)
/// - all: every sensor of the job that changes
/// - lag: each input through a first-order lag of its own, found by a search over time constants on a
///   logarithmic grid, one after the other until none moves, then refined; taken (model automatic) if that
///   lowers the cross-validated square by a tenth
///
/// Slopes of two errors k, l are uncertain together by what both leave, r, and how they come from the
/// readings:
///
///   C_kl = s_kl G_k G_l^T,   slope_k = G_k y_k,   s_kl = r_k . r_l / sqrt(freedom_k freedom_l)
///
/// A log that is not settled may begin with a machine that remembers what was before: each lag has one
/// unknown start per log (LogFreedom), found with the slopes, in their covariance, and no part of the model.
///
/// Cross-validation leaves out blocks of time, not single rows: rows beside each other know each other.
/// laws     FindsSlopesAndLags, MisspecifiedModelIsFlagged, IntervalsCoverTheTruth,
///          NeverUsesValidationLogs, WarmStartsGiveTheSlopesOfColdOnes,
///          SlopesOfSharedReadingsAreUncertainTogether
/// cost     time constants * inputs * rows for each model tried
/// source   docs/theory/measurement.md, section 7
[[nodiscard]] ThermalFit fit_thermal(const FitThermal& thermal, const std::vector<DriftCourse>& courses);

/// The variable of an errors file that holds a lagged temperature: spindle_lag1830.
[[nodiscard]] std::string variable_of(const ThermalTerm& term);

}  // namespace abbe
