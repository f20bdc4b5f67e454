#pragma once

#include <Eigen/Core>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/fit/fit_job.h"

namespace abbe {

/// One log as courses in time of the errors that drift.
struct DriftCourse {
  bool validation = false;
  bool settled = false;       ///< began in equilibrium; else what the machine remembered then is unknown
  std::vector<double> times;  ///< s
  std::vector<std::vector<double>> temperatures;  ///< degC, per sensor
  Eigen::MatrixXd errors;  ///< um or urad, times x errors of FitThermal; their zero is the instruments'
};

/// What the readings of every log say of the errors, time by time:
///
///   reading_r(t) = sum_k S_rk e_k(t),   S_rk = n_r . (displacement or rotation by one unit of error k)
///
/// solved by least squares, displacements in um beside rotations in urad. S is the chain's own first-order
/// effect at the pose and the measuring point (UnitEffects).
///
/// errors   E-THERMAL-RANK: readings that do not tell the errors apart, with the names
/// laws     TwoSensorsTellTilt
/// cost     readings * errors per time
[[nodiscard]] Parsed<std::vector<DriftCourse>> drift_courses(const FitJob& job);

}  // namespace abbe
