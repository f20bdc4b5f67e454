#pragma once

#include <limits>
#include <vector>

#include "abbe/chain/plan_impl.h"

namespace abbe {

/// A rotary axis without travels is looked at as far as this either side, rad.
inline constexpr double kOpenTurn = 50;

/// What bounds the functions of a table (largest values, derivatives by the axis position and slope jumps),
/// components added up: one number for displacements d, one for rotations e. mm, rad.
struct TableBounds {
  double d0 = 0, d1 = 0, d2 = 0, e0 = 0, e1 = 0, e2 = 0;
  double d_jump = 0, e_jump = 0;
  double knot_distance = std::numeric_limits<double>::infinity();  ///< of knots with a jump
  std::vector<double> jumps_at;  ///< these knots, increasing
};

/// Within the travels of the axis (5 m or kOpenTurn either side where none is given).
/// lever    mm: what a rotation counts where jumps are told from rounding
/// errors   d_jump is infinite where the functions make a step
[[nodiscard]] TableBounds table_bounds(const Plan::Impl& plan, const AxisTable& table, double lever);

/// No point of the chain, and no place where an error was measured, is farther from the tip, mm.
[[nodiscard]] double chain_length(const Plan::Impl& plan, const Tool& tool);

}  // namespace abbe
