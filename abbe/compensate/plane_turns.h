#pragma once

#include <optional>

#include "abbe/chain/control_kinematics.h"
#include "abbe/machine/control_model.h"

namespace abbe {

/// Where a control's rotary axes stand when its tool is square to a plane.
///
///   d(r) = K0^-1 axis(r)    direction of the tool in the axes of the program's points, r the rotary axes (1)
///   d(r) = n                n the plane's normal
///
/// axis(r)  of the believed chain, workpiece axes; K0 the tip's motion by X Y Z, rotary axes at zero
/// errors   nullopt: no such positions were found, or (with a side) not exactly one way to stand
/// cost     some ten evaluations of the chain; with a side some thousand
/// source   docs/theory/five-axes.md
class PlaneTurns {
 public:
  PlaneTurns(const ControlKinematics& control, const AddressedAxes& axes, const Tool& tool);

  [[nodiscard]] Vec3 tool_direction(const Turns& turns) const;
  /// The solution of (1) next to `from`, by Newton steps of least length.
  [[nodiscard]] std::optional<Turns> near(const Vec3& normal, const Turns& from) const;
  /// The one with its axis on the side of zero that the control takes. Where that axis is zero `from` must
  /// solve (1) already. Axes that count modulo a turn go the shorter way from `from`.
  [[nodiscard]] std::optional<Turns> on_side(const Vec3& normal, const Turns& from,
                                             const TiltSolution& side) const;

 private:
  [[nodiscard]] std::optional<Turns> counted(const Turns& turns, const Turns& from) const;

  const ControlKinematics& control_;
  AddressedAxes axes_;
  const Tool& tool_;
  Mat3 back_;  ///< K0^-1
};

}  // namespace abbe
