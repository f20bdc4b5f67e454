#pragma once

#include <array>
#include <optional>
#include <vector>

#include "abbe/gear/pose_map.h"

namespace abbe {

/// One measured point of a flank: deviation from the design along the transverse base tangent, + = excess
/// material.
struct MeasuredFlankPoint {
  int tooth = 1;  ///< from 1
  Flank flank = Flank::right;
  double roll = 0;       ///< roll angle, rad
  double z = 0;          ///< from the middle of the face, mm
  double deviation = 0;  ///< mm
  int trace = -1;        ///< points of one trace share an unknown offset; -1: the deviation is absolute
};

/// Pose deviations of gear and wheel that explain measured flanks.
struct PoseEstimate {
  enum class Status {
    ok,
    no_points,   ///< none, or none on the flank
    few_points,  ///< too few to tell their uncertainty, which is not stated either
    failed,      ///< the numbers overflow
  } status = Status::ok;
  PoseValues value{};        ///< mm and rad, of least norm among those that explain the flanks alike
  PoseValues uncertainty{};  ///< standard, of the determined part
  PoseValues determined{};   ///< 1: the flanks tell this one by itself; 0: they say nothing
  int rank = 0;              ///< of 24
  std::size_t points = 0;
  double rms_before = 0, rms_after = 0,
         largest_after = 0;  ///< mm; with offsets: about the mean of each trace
};

/// Least squares of the 24 deviations by (8) of theory/gears.md. What the process itself leaves (crowning) is
/// taken off first. Combinations that no flank shows, such as the wheel along a spur gap, are left at zero,
/// and so are those whose standard uncertainty is above 5 um (rotations at the reference radius): the noise
/// of one tooth must not displace the wheel on all others.
///
/// sigma    standard uncertainty of a point, mm; 0: from the residuals
/// errors   Status; points off the flank (roll angle without a contact) or with a tooth that is not there are
/// left out
/// laws     HiddenDeviationsAreFound, OffsetsOfTracesDoNotMatter, TheRankIsStated, NoiseDoesNotMoveTheWheel
/// cost     one row of 24 per point
/// source   docs/theory/gears.md, section 7
[[nodiscard]] PoseEstimate estimate_pose(const GearJob& job, const WheelInGap& wheel,
                                         const std::vector<MeasuredFlankPoint>& points, double sigma);

/// The pose to ask for so that with these deviations the nominal one appears (corrected_pose of
/// relative_deviation.h).
[[nodiscard]] TipAndAxis pose_corrected_for(const GearJob& job, const WheelInGap& wheel,
                                            const PoseValues& values, std::size_t gap, double height,
                                            const TipAndAxis& nominal);

}  // namespace abbe
