#pragma once

#include <array>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "abbe/chain/inverse.h"
#include "abbe/gear/gear_file.h"

namespace abbe {

/// The axes of a gap at a height of the wheel, as columns in workpiece axes: turned about z by the gap and
/// the helix.
///     angle = first_gap + 2 pi gap / z + kappa t
[[nodiscard]] Mat3 gap_axes(const GearJob& job, std::size_t gap, double height);

/// Centre and axis of the wheel in workpiece axes, crowning infeed included.
/// height      above the middle of the face, mm
/// axis_sign   -1 or +1: which end of the wheel axis the spindle is at
[[nodiscard]] TipAndAxis wheel_pose(const GearJob& job, const WheelInGap& wheel, std::size_t gap,
                                    double height, double axis_sign);

/// The wheel's stroke: what the face and the reach of the contacts need, and the overrun.
struct Stroke {
  double low = 0, high = 0;
};
[[nodiscard]] Stroke stroke_of(const GearJob& job, const WheelInGap& wheel);

/// The wheel's ways with the feed before its stroke, mm: from `clearance` outside the tip cylinder down to
/// its depth, beyond the end of the face, then along the gap. After the stroke it goes on as far along the
/// gap.
struct Approach {
  double down = 0, along = 0;
};
///     down = clearance + h,   along = sqrt(R^2 - (R - h)^2),   h = depth of the gap, R = radius of the
///     wheel: there the wheel does not reach the tip cylinder any more
[[nodiscard]] Approach approach_of(const GearJob& job);

/// The wheel `clearance` outside the tip cylinder: on the way to a gap from the upper end of the one before
/// (to the first gap: where that begins), about the gear so closely that straight lines between keep three
/// quarters of the clearance; and above the upper end of a gap.
[[nodiscard]] std::vector<TipAndAxis> poses_before_gap(const GearJob& job, const WheelInGap& wheel,
                                                       std::size_t gap, double axis_sign);
[[nodiscard]] TipAndAxis pose_after_gap(const GearJob& job, const WheelInGap& wheel, std::size_t gap,
                                        double axis_sign);

using AxisCommands = std::array<double, kMaxAxes>;

/// Axis commands for every gap, as the machine without errors needs them.
struct CuttingMotion {
  Stroke stroke;
  Approach approach;
  std::size_t nodes = 0;
  double axis_sign = 1;
  std::vector<AxisCommands> commands;  ///< gap by gap, `nodes` of each from the lower end upwards

  [[nodiscard]] std::size_t gaps() const { return nodes > 0 ? commands.size() / nodes : 0; }
  [[nodiscard]] double height(std::size_t node) const {
    return stroke.low +
           (stroke.high - stroke.low) * static_cast<double>(node) / static_cast<double>(nodes - 1);
  }
  /// When the wheel is there, s, from the beginning of the way into gap 1: all ways in a gap with the feed,
  /// between two gaps the time of indexing.
  [[nodiscard]] double time(const CuttingSpec& cutting, std::size_t gap, std::size_t node) const;
};

/// Changes a pose of the wheel: gap, height above the middle of the face, the nominal pose.
using PoseChange = std::function<TipAndAxis(std::size_t gap, double height, const TipAndAxis& nominal)>;

/// Why a machine cannot cut a gear.
struct CuttingProblem {
  enum class Trouble {
    axes,    ///< it has no axes that hold the wheel like that
    travel,  ///< it has, but not within its travels
  } trouble = Trouble::axes;
  std::string message;
};

/// Follows the wheel through all gaps with the ideal inverse of the chain: all moving axes help (also those
/// that are not correctable); of two ends of the wheel axis the one that needs less turning is taken.
///
/// start    where the machine stands: decides the branch
/// change   null: nominal poses
/// The ways between the gaps, into them and out of them (poses_before_gap, approach_of) are followed too, so
/// that travels hold for all that a program of the cut would command.
///
/// errors   CuttingProblem
/// laws     CommandsBringTheWheelToItsPose, TravelsHoldBetweenTheGaps
/// cost     one inverse per gap and node, and some five per gap
[[nodiscard]] std::variant<CuttingMotion, CuttingProblem> plan_cutting(
    const Machine& machine, const GearJob& job, const WheelInGap& wheel, std::size_t nodes,
    const AxisCommands& start, const PoseChange& change = {});

}  // namespace abbe
