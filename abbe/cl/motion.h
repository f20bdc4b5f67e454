#pragma once

#include <cstdint>

#include "abbe/core/linear_algebra.h"

namespace abbe::cl {

/// Tip (mm) and tool axis (unit vector from the tip to the spindle).
struct ToolPose {
  Vec3 tip = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
};

/// What a motion record asks of the post-processor.
enum class MotionKind : std::uint8_t {
  from,   ///< FROM: where the tool stands; nothing moves
  rapid,  ///< the GOTO behind RAPID
  line,   ///< feed
  arc,    ///< CIRCLE or MOVARC with its GOTO
  hole,   ///< a GOTO while CYCLE is on
};

/// An arc or helix about a line; the right hand gives its sense.
///
///   point(s) = centre + r(s) (cos(sweep s) u + sin(sweep s) n x u) + n rise s,   u = from the centre to the
///   start
///
/// r(s) runs evenly from the start's radius to the end's. sweep > 0 holds all turns.
struct Arc {
  Vec3 centre = Vec3::Zero();  ///< at the height of the start, mm
  Vec3 normal = Vec3::UnitZ();
  double sweep = 0;                                   ///< rad
  double start_radius = 0, end_radius = 0, rise = 0;  ///< mm
};

/// One motion in the frame of the program, the frame in which the part is placed on the machine.
struct Motion {
  MotionKind kind = MotionKind::line;
  bool start_known = false;
  bool incremental = false;  ///< GODLTA
  bool axis_given = false;   ///< the record states a tool axis
  bool axis_free = false;    ///< and the tool axis may be corrected
  bool may_split = true;
  bool cutter_compensated = false;  ///< CUTCOM is on
  ToolPose start, end;
  Arc arc;
  double above = 0, below = 0;  ///< hole: reach along the tool axis from the point, mm
};

/// Pose at s in [0, 1]: the tip on its line or arc, the tool axis on the great circle between its ends.
/// law   EndsOfAMotionAreItsEnds
[[nodiscard]] ToolPose pose_at(const Motion& motion, double s);

/// Length of the tip's path, mm.
[[nodiscard]] double length_of(const Motion& motion);

/// Angle between the tool axes at both ends, rad.
[[nodiscard]] double turn_of(const Motion& motion);

/// Unit vector on the great circle from a to b (unit vectors, not opposite) at s.
[[nodiscard]] Vec3 between(const Vec3& a, const Vec3& b, double s);

/// The arc about `centre` and `normal` (unit) from start to end. `turns` whole turns are added; a start on
/// the end is a full turn.
[[nodiscard]] Arc make_arc(const Vec3& centre, const Vec3& normal, const Vec3& start, const Vec3& end,
                           int turns);

}  // namespace abbe::cl
