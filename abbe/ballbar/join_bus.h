#pragma once

#include <string>
#include <variant>
#include <vector>

#include "abbe/ballbar/trace.h"

namespace abbe {

/// What drives reported while a circular test ran: positions of the two axes of its plane.
struct BusRecord {
  std::vector<double> time;                     ///< s, increasing
  std::vector<double> commanded[2], actual[2];  ///< 607A and 6064 of the plane's first and second axis, mm
};

/// Why a record does not belong to a test.
struct JoinTrouble {
  std::string message, why, fix;
};

/// Gives every sample of a ball-bar trace the positions that the control commanded and reached there:
/// the moment is the one at which the commanded point passed the angle of the sample. The trace's own time,
/// if it has one, is that of another clock and stays as it is.
///
/// The runs are looked for in their order, each in a stretch of the record that goes round the centre on the
/// circle in its direction, without a halt, and covers its angles. What the two clocks of instrument and
/// control disagree on within a run is left to the identification (IdentifyOptions::time_offset).
/// A bus that reports more often than the control commands repeats commands: the first of each counts.
///
/// units    mm, s; angles in the plane's sense
/// errors   a record that is too short or not finite, whose time does not increase, that never goes round
///          this circle (another centre, radius, plane or sense), or that lacks a run
/// laws     JoinedPositionsAreThoseOfTheAngle, RunsKeepTheirDirection, RepeatedCommandsCountOnce
/// cost     a few passes over the record
/// source   docs/theory/ball-bar.md
[[nodiscard]] std::variant<BallbarTest, JoinTrouble> join_bus(const BallbarTest& test,
                                                              const BusRecord& whole);

}  // namespace abbe
