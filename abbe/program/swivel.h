#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// CYCLE800(FR, "TC", ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, DIR, FR_I, DMODE): a plane in space. The
/// coordinates are shifted to X0 Y0 Z0, turned about three of their axes one after the other, and shifted by
/// X1 Y1 Z1 on the plane:
///
///   p becomes before + R(A) R(B) R(C) (p + behind)
///
/// axes       about which A, B and C turn: pairs of bits of MODE, the lowest first, 1 2 3 = X Y Z (57: X Y Z)
/// direction  DIR: -1 and +1 the control turns the rotary axes to the lower or the higher of two ways, 0 not
struct Swivel {
  bool ends = false;                                  ///< CYCLE800(): no plane
  Vec3 before = Vec3::Zero(), behind = Vec3::Zero();  ///< units of the program
  std::array<int, 3> axes{0, 1, 2};
  std::array<double, 3> angles{};  ///< deg
  int direction = 0;
};

/// Reads the code with its brackets.
/// errors   nullopt: numbers that are no literals, MODE of another kind than axis by axis, ST other than 0,
///          the swivel data "0", DIR or FR out of range, too many or too few arguments
[[nodiscard]] std::optional<Swivel> read_swivel(std::string_view code);

}  // namespace abbe
