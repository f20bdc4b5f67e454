#pragma once

#include <algorithm>
#include <array>

#include "abbe/chain/control_kinematics.h"
#include "abbe/compensate/plain_line.h"
#include "abbe/core/linear_algebra.h"
#include "abbe/core/number.h"

// What the rewriter keeps of runs of plain lines (rewriter_lane.cpp). mm, rad.
namespace abbe {

/// A plain line of a packet, what it asks for, and what it becomes.
struct LaneLine {
  PlainLine line;
  Vec3 m = Vec3::Zero();  ///< where the original goes
  Turns turns{};
  Turns stand{};  ///< where the output's rotary axes go
  Vec3 m_out = Vec3::Zero(), p_out = Vec3::Zero();
  Vec3 correction = Vec3::Zero();            ///< of the linear axes
  double way_square = 0, change_square = 0;  ///< of the linear axes, mm^2
  std::array<FixedNumber, PlainLine::kFeed> spelled;
  std::array<bool, 2> turn_stays{};
  bool sure = false;     ///< these may be spelled
  unsigned written = 0;  ///< words with new numbers, as PlainLine::named
};

/// The end of a line: of the original, of the output.
struct LaneReach {
  Vec3 m_in, m_out, p_out;
};

/// Decimals that the control resolves.
struct LaneDigits {
  int linear = 0;
  std::array<int, 3> turn{};
  std::array<bool, 3> fixed{};  ///< whatever the program writes
  [[nodiscard]] int of_turn(std::size_t k, int written) const {
    return fixed[k] ? turn[k] : std::max(turn[k], written);
  }
};

}  // namespace abbe
