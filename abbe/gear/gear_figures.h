#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "abbe/gear/wheel_deviations.h"

namespace abbe {

/// Over which part of a flank it is judged (ISO 1328-1:2013, 3.4 and 3.5), and with how many samples.
struct EvaluationSpec {
  double profile_part = 0.95;    ///< of the roll length from form to tip diameter, from the form diameter
  double helix_end_part = 0.05;  ///< of the face width left out at each end ..
  double helix_end_modules = 1;  ///< .. but not more than this many modules
  int profile_samples = 201, helix_samples = 101;
};

/// Deviations along a trace, mm, + = excess material.
///
///     mean line a + s x by least squares over the evaluation length L;   slope f_H = s L
///     total F = max f - min f,   form f_f = max (f - a - s x) - min (f - a - s x)
///
/// A profile's slope is positive with more material towards the tip, a helix's towards +z.
struct TraceFigures {
  double total = 0, form = 0, slope = 0;
};
/// x, f   as long as each other; fewer than two different x give a slope of 0
/// laws   FiguresOfAStraightLine
[[nodiscard]] TraceFigures trace_figures(std::span<const double> x, std::span<const double> f, double length);

/// What is measured on one flank of one tooth.
struct FlankFigures {
  TraceFigures profile;  ///< at the middle of the face
  TraceFigures helix;    ///< at the reference cylinder
  double position =
      0;  ///< arc at the reference cylinder by which the flank is ahead, counter-clockwise seen from +z
};

/// Pitch of all flanks of one side.
///     index F_pi = position of tooth i - that of tooth 1,   single f_pi = F_pi - F_p(i-1)
///     f_p = max |f_pi|,   F_p = max F_pi - min F_pi
struct PitchFigures {
  std::vector<double> index, single;  ///< per tooth; single[i] from tooth i - 1 to tooth i
  double f_p = 0, F_p = 0;
};

/// A whole gear. Tooth i lies between gap i and gap i + 1, gaps counted counter-clockwise seen from +z; its
/// right flank is the right flank of gap i, its left flank the left flank of gap i + 1.
struct GearFigures {
  std::vector<std::array<FlankFigures, 2>> teeth;  ///< right, left
  std::array<PitchFigures, 2> pitch;               ///< right, left
  std::vector<double> ball;                        ///< per gap: radial position of a ball in it, mm
  double F_r = 0;                                  ///< max - min of `ball`
};

/// Traces of one flank, for charts: roll length and profile deviation, height and helix deviation.
struct FlankTraces {
  std::vector<double> roll_length, profile, z, helix;
};

/// Measures what the wheel made.
///
///     position = -s f / cos alpha_t  (s = +1 right, -1 left),   ball = (f_right + f_left) / (2 sin phi)
///
/// errors   none; numbers that are not finite do not come in
/// laws     EccentricityGivesItsPitchCurve, IndexErrorIsPitchOnly, RunoutOfAPerfectGearIsZero
/// cost     about 600 flank points per tooth
/// source   ISO 1328-1:2013; docs/theory/gears.md, section 4
class GearInspection {
 public:
  /// The contacts of the traces are found once. nullopt: the wheel does not touch at some roll angle.
  [[nodiscard]] static std::optional<GearInspection> make(const Gear& gear, const WheelInGap& wheel,
                                                          const EvaluationSpec& spec);

  [[nodiscard]] GearFigures figures(const WheelDeviations& deviations) const;
  /// tooth   from 0
  [[nodiscard]] FlankTraces traces(const WheelDeviations& deviations, int tooth, Flank flank) const;
  [[nodiscard]] double profile_length() const { return profile_length_; }  ///< L_alpha, mm
  [[nodiscard]] double helix_length() const { return helix_length_; }      ///< L_beta, mm

 private:
  GearInspection(const Gear& gear, const WheelInGap& wheel) : gear_(gear), wheel_(wheel) {}
  [[nodiscard]] FlankFigures flank_figures(const WheelDeviations& deviations, std::size_t gap,
                                           Flank flank) const;

  Gear gear_;
  WheelInGap wheel_;
  double profile_length_ = 0, helix_length_ = 0;
  std::array<std::vector<WheelContact>, 2> profile_;  ///< over the evaluation length
  std::array<std::vector<WheelContact>, 2> whole_;    ///< from form to tip
  std::array<WheelContact, 2> reference_;
  std::vector<double> profile_x_, helix_z_;
};

/// The gap in which a flank of a tooth is: its own, or the next one. Both from 0.
[[nodiscard]] std::size_t gap_of(const Gear& gear, int tooth, Flank flank);

}  // namespace abbe
