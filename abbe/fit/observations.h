#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/linear_algebra.h"
#include "abbe/fit/fit_job.h"

namespace abbe {

/// Something about a measurement that is not the machine's: the zero of an instrument, how a straightedge
/// lay.
struct Nuisance {
  std::string name;
  double value = 0;         ///< expected, with u
  std::optional<double> u;  ///< none: nothing is known of it
};

/// One number that was measured, as a linear equation:
///
///   value = direction . (displacement or rotation of the tool at the pose) + sum coefficient * nuisance
///
/// in mm or rad, workpiece axes, tool relative to workpiece.
struct Observation {
  struct Term {
    std::size_t nuisance = 0;
    double coefficient = 0;
  };
  std::size_t pose = 0;
  Vec3 direction = Vec3::UnitX();
  bool rotation = false;
  double value = 0, sigma = 1;
  std::vector<Term> terms;
};

/// The observations of one file: [begin, end) of all.
struct ObservationSet {
  std::string name;
  bool angle = false;
  bool noise_assumed = false;  ///< nothing is known of its scatter: 1 um or 1 urad were taken
  std::size_t begin = 0, end = 0;
};

struct Observations {
  std::vector<Query> poses;
  std::vector<Observation> rows;
  std::vector<Nuisance> nuisances;
  std::vector<ObservationSet> sets;
};

/// Every measurement of a job as equations.
///
///   run           one row per target and direction: the mean of its runs; an offset; straightness also a
///   slope, or
///                 the rotation of its square; scale of the instrument with its uncertainty
///   diagonal      the same along a line
///   points        three rows per pose; position and orientation of the measuring frame unless fixed
///   ball          three rows per pose: the tip is in the ball, whose place is unknown
///
/// errors   E-JOB-RANGE (a target beyond the diagonal), E-JOB-SQUARE (runs on one square that do not span one
///          plane), E-JOB-POINTS (points that do not fit the poses: other axes, other units), E-JOB-BALL
///          (poses that cannot hold the tip in one ball), E-JOB-AXIS (a point on the work while rotary axes
///          are turned)
[[nodiscard]] Parsed<Observations> observations_of(const FitJob& job);

/// Direction in which the tool moves relative to the workpiece for an increasing command of a linear axis, or
/// about which it turns for a rotary one; workpiece axes at home.
[[nodiscard]] Vec3 relative_direction(const Body& axis);

}  // namespace abbe
