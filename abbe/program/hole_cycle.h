#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/program/block.h"

namespace abbe {

/// A drilling cycle of a conversational program as CYCL DEF defines it: its number (200 to 209), the text
/// behind it, and its Q words; or of the older ones 1, 2 and 17, whose values stand in lines of their own:
/// CYCL DEF 1.2 DEPTH -20 is parameter 2.
struct HoleDefinition {
  struct Word {
    int parameter = 0;    ///< 203 of Q203
    double value = 0;     ///< program units
    int decimals = 0;     ///< digits after the point
    std::string spelled;  ///< as the program has it: "+0,5", "FAUTO"
  };
  int cycle = 0;      ///< 0: none is defined
  std::string title;  ///< "CYCL DEF 200 DRILLING"
  std::vector<Word> words;

  [[nodiscard]] const Word* find(int parameter) const;
};

/// Q203: the only word of a drilling cycle that says a place; the others count from it.
inline constexpr int kSurface = 203;

/// Where the control moves the tool within a hole: heights along Z and how far to the side of the hole's
/// axis, program units. top = Q203 + Q200, bottom = Q203 + Q201, clear = Q203 + max(Q200, Q204).
///
/// The older cycles know no place of the surface: they begin where the tool stands, z, end there, and
///   top = z - set-up (the surface), bottom = top + depth
struct HoleSpan {
  bool from_start = false;  ///< heights count from z
  double top = 0;           ///< to here at rapid
  double bottom = 0;        ///< the lowest place
  double clear = 0;         ///< where the cycle leaves the tool
  double aside = 0;         ///< of a bore that is milled (208) or cut from behind (204)
};

/// The span of a cycle, or why it is not sure: a word is missing, or says what depends on the control.
/// source   TNC 640 user's manual for cycle programming, fixed cycles: drilling, tapping; TNC 426 user's
/// manual,
///          cycles 1 PECKING, 2 TAPPING, 17 RIGID TAPPING
struct HoleAnswer {
  std::optional<HoleSpan> span;
  std::string message;  ///< where there is none
};
[[nodiscard]] HoleAnswer span_of(const HoleDefinition& definition);

/// "CYCL200" and so on: the number of a drilling cycle that is known here, or 0.
[[nodiscard]] int hole_cycle_number(std::string_view keyword);
/// Its values stand in lines of their own (CYCL DEF 1.1 ..).
[[nodiscard]] constexpr bool has_parts(int cycle) { return cycle > 0 && cycle < 200; }

/// Reads Q words "Q200=+2 Q201=-10,5" from byte `at` to `end` of a line into words with the letter Q, each
/// with its parameter. `comma` becomes true where a number has one.
/// errors   E-EXPR: a value that is not literal; E-CYCLE: not a word of this cycle, or there twice
[[nodiscard]] std::optional<BlockError> read_hole_words(int cycle, std::size_t at, std::size_t end,
                                                        bool& comma, Block& block);

/// Reads the value of CYCL DEF cycle.part, "SET UP 2" or "F229", from byte `at` to `end` of a line into a
/// word with the letter Q and the parameter `part`. The control spells its name in its own language: it says
/// nothing.
/// errors   E-EXPR: a value that is not literal; E-CYCLE: the cycle has no such part
[[nodiscard]] std::optional<BlockError> read_hole_value(int cycle, int part, std::size_t at, std::size_t end,
                                                        bool& comma, Block& block);

}  // namespace abbe
