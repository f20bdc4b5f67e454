#pragma once

#include "abbe/machine/control_model.h"

namespace abbe {

/// A word of a rotary axis and where it takes the axis. Angles in rad, counted through whole turns;
/// numbers as written, in degrees.
struct TurnWord {
  double number = 0;     ///< to write
  double position = 0;   ///< where the axis goes
  bool clamped = false;  ///< the position wanted would have changed the sense, or passed a full turn
};

/// Where a word of the original takes an axis that stands at `from`.
///
///   linear    r1 = w + offset
///   shortest  r1 = from + d,  d = w + offset - from  within (-180, 180] degrees
///   sign      r1 = from + d,  d the way from `from` to |w| in the direction of the sign, below one turn
struct TurnTarget {
  double position = 0;
  bool ambiguous = false;  ///< shortest: half a turn, to a hundredth of a degree
};
[[nodiscard]] TurnTarget turn_target(Turning turning, double written, double from, double offset);

/// A block of the original turns an axis by the word `written` to `target`; the output's axis stands at
/// `from` and shall stop at `wanted` (the corrected end, or a place on the way). Gives the word to write,
/// rounded to `decimals`, such that the control turns the same way round as in the original: where a
/// correction would change the sense or pass a full turn it is cut short.
/// laws   TheWordLeadsWhereItSays, NoCorrectionTurnsTheOtherWay, AnUncorrectedWordStays
[[nodiscard]] TurnWord turn_word(Turning turning, double written, double target, double from, double wanted,
                                 double offset, int decimals);

}  // namespace abbe
