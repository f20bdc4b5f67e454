#pragma once

#include <array>
#include <cstddef>

#include "abbe/chain/control_kinematics.h"

namespace abbe::verifying {

/// Which rotary positions a control takes for a tool direction, where it is known to take the nearest.
///
/// Nothing is taken from the description of the axes: the forward model is asked for the tool axis at a few
/// positions. Turning the slow axis (next to the workpiece) moves the tool axis on a cone about a line p that
/// nothing else moves; turning the other changes its height along p as a sine:
///
///   p . axis(slow, fast) = h0 + h1 cos(fast) + h2 sin(fast)
///
/// cost     three divisions, a few sines per direction; twelve poses once
/// source   docs/theory/five-axes.md
class ToolDirection {
 public:
  ToolDirection(const Machine& machine, const AddressedAxes& axes, const ControlKinematics& kinematics);

  struct Found {
    Turns turns{};
    const char* problem = nullptr;  ///< why nothing was found
  };
  /// From where the rotary axes stand, rad. The direction (workpiece axes) may have any length.
  [[nodiscard]] Found turns_for(const Vec3& direction, const Turns& from) const;

 private:
  [[nodiscard]] bool learn(std::size_t slow, std::size_t fast, const ControlKinematics& kinematics);
  [[nodiscard]] bool within(std::size_t letter, double turn) const;

  bool known_ = false;
  bool nearest_ = false;  ///< the machine file says so
  std::size_t slow_ = 0, fast_ = 0;
  Vec3 pivot_ = Vec3::Zero();   ///< p; a positive turn of the slow axis turns right-handed about it
  Vec3 steady_ = Vec3::Zero();  ///< axis(0, fast) = steady + swing cos fast + sweep sin fast
  Vec3 swing_ = Vec3::Zero(), sweep_ = Vec3::Zero();
  std::array<std::array<double, 2>, 3> travel_{};
};

}  // namespace abbe::verifying
