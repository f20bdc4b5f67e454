#pragma once

#include <array>
#include <optional>

#include "abbe/chain/correct.h"

namespace abbe {

struct InverseOptions {
  bool ideal = false;  ///< of the nominal machine: errors ignored
  AxisSet locked = 0;  ///< held at their value in `start`
  double max_rotary_correction = 0.5 * deg;
};

struct InverseResult {
  std::array<double, kMaxAxes> q{};
  double residual_position = 0;   ///< mm
  double residual_direction = 0;  ///< rad
  Status status = Status::failed;
  int branch = 0;  ///< index among the nominal solutions found, nearest to `start` first = 0
};

/// Commands that bring the tool tip to `position` (workpiece axes, mm) with tool axis `direction`
/// (normalised here). The branch nearest to `start` within the travels is taken; rotary axes are
/// unwrapped to it. Numeric: nominal chain by damped Newton from several starts, then `correct`.
[[nodiscard]] InverseResult inverse(const Plan& plan, const Tool& tool, const Vec3& position,
                                    const Vec3& direction, const std::array<double, kMaxAxes>& start,
                                    AxisSet free, const InverseOptions& options);

}  // namespace abbe
