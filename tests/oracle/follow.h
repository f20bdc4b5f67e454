#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/oracle/interpreter.h"

namespace abbe::oracle {

/// Position of the tool tip in the workpiece (mm) for axis commands (mm) with a tool in the spindle (-1:
/// none).
using Tip = std::function<Vec3(const Vec3& commands, int tool)>;

struct Following {
  double worst_feed = 0;   ///< mm: distance of the rewritten program's actual tip from the original's path
  double worst_rapid = 0;  ///< mm: the same at the ends of rapids
  std::size_t before = 0;  ///< motions at the start, until the first one ends on the path
  std::string fault;       ///< where the two part; empty if they do not
};

/// Does the rewritten program, on the real machine, follow the original's path on the ideal one? Motions are
/// LinuxCNC's for both programs. A rapid answers a rapid; one or more feed motions answer a feed motion, in
/// its direction, each point of theirs within `allowed` mm of its path.
///
/// A machine stands somewhere when a program starts: until a motion has ended on the path, rapids may miss
/// it. A feed that starts off the path (there, or after a change of the tool) may come back to it over its
/// length.
[[nodiscard]] Following follow(const std::vector<Motion>& original, const std::vector<Motion>& rewritten,
                               const Tip& nominal, const Tip& actual, double allowed);

}  // namespace abbe::oracle
