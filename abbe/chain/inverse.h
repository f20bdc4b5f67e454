#pragma once

#include <array>
#include <optional>

#include "abbe/chain/correct.h"

namespace abbe {

/// On which side of its singularity a machine with two rotary axes stands. The determinant
///
///     a . (c1 x c2),   c_i = d a / d q_i,   a = tool axis
///
/// is zero where both axes turn the tool about one line; a path changes its branch only there.
struct Side {
  int sign = 0;         ///< +1, -1; 0: not two free rotary axes, or on the singularity
  double distance = 0;  ///< |determinant|: sine of the angle to the singularity, 1 at most
};
[[nodiscard]] Side side_of(const Plan& plan, const Query& query, AxisSet free);

struct InverseOptions {
  bool ideal = false;  ///< of the nominal machine: errors ignored
  AxisSet locked = 0;  ///< held at their value in `start`
  double max_rotary_correction = 0.5 * deg;
  Method method = Method::newton;  ///< of the correction
  int side = 0;                    ///< +1, -1: solutions on this side of the singularity come first
};

struct InverseResult {
  std::array<double, kMaxAxes> q{};
  double residual_position = 0;   ///< mm
  double residual_direction = 0;  ///< rad
  Status status = Status::failed;
  int branch = 0;  ///< index among the nominal solutions found, nearest to `start` first = 0
  int iterations = 0;
  bool outside = false;  ///< an error was held beyond its measured ends
  Side side;             ///< of the nominal solution
};

/// Commands that bring the tool tip to `position` (workpiece axes, mm) with tool axis `direction`
/// (normalised here). The branch nearest to `start` within the travels is taken; rotary axes are
/// unwrapped to it. Nominal chain: closed form for three linear and up to two rotary axes, for all others
/// damped Newton from several starts; then `correct`.
[[nodiscard]] InverseResult inverse(const Plan& plan, const Tool& tool, const Vec3& position,
                                    const Vec3& direction, const std::array<double, kMaxAxes>& start,
                                    AxisSet free, const InverseOptions& options);

}  // namespace abbe
