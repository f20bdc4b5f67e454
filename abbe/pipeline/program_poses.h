#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "abbe/chain/plan.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/machine/control_setup.h"
#include "abbe/part/tool_way.h"
#include "abbe/verify/verify.h"

namespace abbe {

/// A program, followed on the machine as it is.
struct PoseJob {
  std::string path, name;  ///< the file, and what findings call it
  ControlSetup setup;
  DatumRule datum = DatumRule::probed;
  double tolerance = 0.01 * um;  ///< mm: tips between two poses are nearer than this to the straight line
  double rapid_speed = 10000;    ///< mm/min, for the time only
  /// The plan after so many seconds, for errors that depend on time; empty: one plan throughout.
  std::function<std::optional<Plan>(double seconds)> plan_at;
  double time_step = 10;  ///< s: how often it is asked
};

struct PoseReport {
  enum class End { done, stopped, io, refused } end = End::refused;
  Diagnostics diagnostics;
  std::uint64_t motions = 0, poses = 0;
  double seconds = 0;          ///< by the feeds; dwells and tool changes count nothing
  double feed_length = 0;      ///< mm
  bool outside = false;        ///< an error was held beyond its ends
  bool beyond_travel = false;  ///< a motion ends where an axis of the machine does not reach
  Vec3 datum = Vec3::Zero();   ///< mm, workpiece axes: deviation at the work offset's origin, taken off
};

/// Follows a program with the reader of `verify` and calls `motion` for every motion with the actual poses of
/// the tool in part coordinates: those of the program at the work offset of its first feed motion.
///
///     tip_part = A^-1 (actual tip - datum - b),    nominal tip of program point p = A p + b, rotary axes at
///     zero
///
/// Rapids before the first feed, and motions from or to a place that is not known (G28), are left out, and
/// the next one is not connected. Canned cycles are followed hole by hole. Direction-dependent errors count
/// with their mean. A motion has the plan of its start; the datum stays that of the beginning: what drifts
/// later is on the part.
///
/// errors   what the reader refuses; E-PART-TOOL: a second tool cuts; E-PART-AXES: part axes are not at right
/// angles;
///          E-PART-TIME: plan_at with a feed per turn; E-SENSOR: no plan at some time
/// laws     APerfectMachineIsWhereTheProgramSays, SquarenessShears, ProbedDatumIsTakenOff, DriftGrowsWithTime
/// cost     about 2 us per pose; constant memory
[[nodiscard]] PoseReport program_poses(const Plan& plan, const PoseJob& job,
                                       const std::function<void(const MotionPoses&)>& motion,
                                       const Progress& progress = {});

}  // namespace abbe
