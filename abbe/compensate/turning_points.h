#pragma once

#include <vector>

#include "abbe/compensate/arc.h"

namespace abbe {

/// Where an axis of the arc's plane turns round: the s in (0, 1), increasing, at which the path's derivative
/// (3) along that axis changes its sign,
///
///   tan(a(s) + rotation - k pi / 2) = (r1 - r0) / (r(s) sweep)                              (5)
///
/// rotation  of the program's X to the machine's, rad; arcs in XY only
/// least     mm: an axis that moves less than this before it turns (at the start) or after it has turned
///           (at the end) is taken not to turn
[[nodiscard]] std::vector<double> turning_points(const Arc& arc, double rotation, double least);

}  // namespace abbe
