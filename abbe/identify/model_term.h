#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "abbe/identify/nodal_spline.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// Where and how the axes are at one sample: positions (mm, rad), rates per second, sense of motion.
struct AxisState {
  std::array<double, kMaxAxes> q{}, v{}, a{};
  std::array<signed char, kMaxAxes> approach{};  ///< -1, 0, +1
};

/// One unknown of an identification: a coefficient of one error of the machine.
///
///   constant      c                 of location errors (squareness)
///   power         c (q^n - line)    static, of the axis' own position; of a straightness a line is taken
///   off: the
///                                   trend over the tested travel, which the squareness contains, through
///                                   the middle of the travel, where the error is zero
///   spline        c f(q)            static: f is a natural spline without trend (NodalSpline); the sum of
///   all of
///                                   an error is any natural spline with these nodes, but for its line
///   lost_motion   -c/2 for increasing, +c/2 for decreasing approach of the axis: c > 0 falls behind
///   velocity      c v               dynamic
///   acceleration  c a               dynamic
struct ModelTerm {
  enum class Form { constant, power, spline, lost_motion, velocity, acceleration } form = Form::power;
  ErrorName name;
  int axis = 0;                  ///< moving axis whose position, rate or approach is the variable
  int power = 1;                 ///< of a spline: its node, from 0
  std::array<double, 2> line{};  ///< offset and slope taken off
  std::shared_ptr<const NodalSpline> spline;

  [[nodiscard]] bool is_dynamic() const { return form == Form::velocity || form == Form::acceleration; }
  friend bool operator==(const ModelTerm&, const ModelTerm&) = default;
};

/// The factor of the coefficient in the value of the error (mm or rad).
[[nodiscard]] double basis(const ModelTerm& term, const AxisState& state);

/// "EXX X^2", "EC0Y", "EXX lost motion", "DXX a.X".
[[nodiscard]] std::string to_string(const ModelTerm& term, const Machine& machine);

/// Which terms are looked for.
struct TermChoice {
  int positioning = 3;   ///< E_aa: powers 1..n; 0 none
  int straightness = 3;  ///< E_ba: powers 2..n; the linear part is the squareness
  int rotation = 1;      ///< rotations E_Aa..: powers 1..n
  bool squareness = true;
  bool lost_motion = true;    ///< of E_aa
  bool lateral_play = false;  ///< lost motion of E_ba
  bool velocity = true;       ///< D_aa of v.a
  bool acceleration = true;   ///< D_aa of a.a
  bool cross = false;         ///< D_ba of v.a and a.a as well
  /// Nodes over the tested travel, 0 or 4..: E_aa (its first power stays) and E_ba are splines in place of
  /// powers, where those are not 0.
  int splines = 0;
};

/// Terms of the linear axes `moving` (indices of moving axes), in the order: squareness, then per axis
/// positioning, straightness, rotations, lost motion, dynamics. `travel` is what the tests cover of every
/// moving axis. Squareness of two axes is the location error of the one farther along the chain from the
/// workpiece; errors that cannot act on this chain are left out.
using Travel = std::array<double, 2>;
[[nodiscard]] std::vector<ModelTerm> choose_terms(const Machine& machine, const std::vector<int>& moving,
                                                  const std::vector<Travel>& travel,
                                                  const TermChoice& choice);

/// Offset and slope of the line with the trend of q^power (least squares, every q of the travel counts alike)
/// that meets it in the middle of the travel.
[[nodiscard]] std::array<double, 2> trend_line(int power, const Travel& travel);

}  // namespace abbe
