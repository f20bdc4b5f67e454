#pragma once

#include <optional>
#include <span>

#include "abbe/chain/control_kinematics.h"
#include "abbe/machine/machine.h"
#include "abbe/verify/tool_direction.h"

namespace abbe::verifying {

/// What a program's rotary words mean on a machine, and what tool centre point control makes of its points.
class Rotary {
 public:
  explicit Rotary(const Machine& machine)
      : control_(machine.control),
        axes_(addressed_axes(machine)),
        kinematics_(machine, axes_),
        direction_(machine, axes_, kinematics_),
        any_(has(0) || has(1) || has(2)) {
    for (int k = 0; k < 3; ++k) as_written_ |= (has(k) && turning(k) == Turning::linear ? 1u : 0u) << k;
  }

  [[nodiscard]] bool declared() const { return control_.declared; }
  [[nodiscard]] bool starts_with_tcp() const { return control_.tcp; }
  [[nodiscard]] bool has(int letter) const { return axes_.rotary[static_cast<std::size_t>(letter)] >= 0; }
  [[nodiscard]] bool any() const { return any_; }
  [[nodiscard]] std::span<const TcpCode> codes() const { return control_.codes; }
  /// It is stated that each rotary axis goes evenly between blocks that state directions of the tool.
  [[nodiscard]] bool between_evenly() const { return control_.vectors.between == VectorRule::Between::axes; }
  /// How the control chooses where its axes stand on a tilted plane, if it is stated.
  [[nodiscard]] const std::optional<TiltSolution>& tilt() const { return control_.tilt; }
  [[nodiscard]] const AddressedAxes& axes() const { return axes_; }
  [[nodiscard]] const ControlKinematics& kinematics() const { return kinematics_; }
  [[nodiscard]] const ToolDirection& direction() const { return direction_; }
  [[nodiscard]] Turning turning(int letter) const;
  /// A rotary axis goes where its word says, whole turns and all.
  [[nodiscard]] bool goes_as_written(int letter) const { return (as_written_ >> letter & 1) != 0; }
  /// Least increment of the control, rad; 0: not stated.
  [[nodiscard]] double resolution(int letter) const;

  /// Where a word (degrees) takes the axis that stands at `from`, rad, counted through whole turns.
  [[nodiscard]] double target(int letter, double word, double from, double offset) const;

 private:
  ControlModel control_;
  AddressedAxes axes_;
  ControlKinematics kinematics_;
  ToolDirection direction_;
  bool any_;
  unsigned as_written_ = 0;  ///< bits 0 1 2 = A B C
};

}  // namespace abbe::verifying
