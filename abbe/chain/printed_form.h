#pragma once

#include <array>
#include <optional>
#include <string>

#include "abbe/chain/correct.h"

namespace abbe {

/// The first-order closed form of the X Y Z A C gear grinder of seed 003 as it is printed there, with the
/// A' that the print leaves out:
///
///     A' = s acos(k - b i + a j) - (aA + aT + aY + aZY + aZ - aX - aCY),   s = sign of A
///
/// All errors have the values they take at the command. Second-order rest: for errors up to 0.01 mm and
/// 10 urad, lever 200 mm, at most 8e-7 mm and 1e-9 rad at tilts of 15 to 75 deg, a hundred times that for
/// errors ten times as large; the direction grows with 1 / sin A. docs/theory/correction.md, section 4.
struct PrintedForm {
  std::array<double, kMaxAxes> q{};
  bool singular = false;  ///< no solution: C and A are those of the command, X Y Z fit them
};

/// What the machine must be: chain w C X b Y Z A t, axes along and about x, y, z, all origins at zero but
/// that of A, which is a length L above the tip; C, Y, Z with location `frame`, A with
/// [location motion static -location] (`line` is the same to first order); constant or position-dependent
/// errors among the 53 of the seed; all five axes free.
[[nodiscard]] std::optional<std::string> printed_form_obstacle(const Machine& machine, const Tool& tool,
                                                               AxisSet free);

/// target, axis  tip and tool axis wanted, workpiece axes; nothing is checked here
/// keep          rotary axes to leave at their command
[[nodiscard]] PrintedForm printed_form(const Plan& plan, const Query& query, const Vec3& target,
                                       const Vec3& axis, AxisSet keep, bool* outside);

}  // namespace abbe
