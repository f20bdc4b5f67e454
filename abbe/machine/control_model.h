#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// How a control turns a rotary axis to a programmed position (docs/machine-file.md, [control]).
enum class Turning {
  linear,    ///< as a linear axis: the number is the position, whatever the turns
  shortest,  ///< modulo 360 degrees, the shorter way
  sign,      ///< modulo 360 degrees, the sign of the word is the direction
};

/// A code that switches tool centre point control on or off.
struct TcpCode {
  char letter = 'G';  ///< G or M
  int code = 0;       ///< 10 times its number: G43.4 is 434
  bool on = false;
  bool vectors = false;  ///< while it is on, I J K of lines and rapids are the tool's direction (G43.5)
};

/// What a control makes of a tool's direction that a program states as a vector (docs/theory/five-axes.md):
/// which of the positions of the rotary axes that give it, and how they go there from block to block.
struct VectorRule {
  bool nearest =
      false;  ///< the nearest ones; the outer axis stays where it does not matter. false: not stated
  enum class Between { unstated, axes } between = Between::unstated;  ///< axes: each goes evenly
};

/// One axis as the control knows it.
struct ControlAxis {
  std::optional<Vec3> origin;         ///< point on the axis, bed frame at home, mm; none: as built
  std::optional<Vec3> direction;      ///< none: as built
  Turning turning = Turning::linear;  ///< rotary axes
  std::optional<double> resolution;   ///< least increment, mm or rad
};

/// Which of the two ways in which rotary axes can stand on a tilted plane a control takes: the one with this
/// axis on this side of zero.
struct TiltSolution {
  int axis = 0;  ///< 0 1 2 = A B C
  int sign = 1;
};

/// [control]: the control's own model of the machine. It turns programmed points into axis commands with
/// its numbers, which need not be those of the machine as built.
struct ControlModel {
  bool declared = false;       ///< false: rotary words are refused
  bool tcp = false;            ///< tool centre point control is on when a program starts
  std::vector<TcpCode> codes;  ///< that switch it
  VectorRule vectors;
  std::vector<std::string> corrects;  ///< errors the control corrects itself, as they are named in [errors]
  std::optional<TiltSolution> tilt;   ///< none: programs of tilted planes say where the rotary axes stand
  std::vector<ControlAxis> axes;      ///< one per moving axis
};

}  // namespace abbe
