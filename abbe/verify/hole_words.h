#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace abbe::verifying {

/// A drilling cycle of a conversational program as its Q words say it (CYCL DEF 200 to 209), or its lines (1,
/// 2, 17; line 1.3 has the name 3), or one with brackets (CYCLE81 to 89, 840) put into such words: what the
/// control remembers until it is called. Written apart from the rewriter's.
struct HoleWords {
  static constexpr int kMost = 28;
  static constexpr double kFeedOfProgram = -1, kRapid = -2;  ///< feeds that are words: FAUTO, FMAX
  int cycle = 0;                                             ///< 0: none
  int count = 0;
  std::array<std::int16_t, kMost> name;  ///< 203 of Q203
  std::array<double, kMost> value;       ///< program units

  [[nodiscard]] std::optional<double> find(int q) const;
  /// False: there is no room, or it is there.
  [[nodiscard]] bool take(int q, double number);
};

/// The place of the surface: what may differ between an original and its output.
inline constexpr int kSurfaceQ = 203;

/// A cycle whose values stand in lines of their own. It begins and ends where the tool stands.
[[nodiscard]] constexpr bool of_lines(int cycle) { return cycle == 1 || cycle == 2 || cycle == 17; }

/// The words that a cycle may have; empty: the cycle is not known.
[[nodiscard]] std::span<const std::int16_t> known_words(int cycle);

/// Heights and reach of a hole, program units. `from_tool`: heights count from where the tool stands.
struct HolePlace {
  double retract = 0, bottom = 0, clear = 0, reach = 0;
  bool from_tool = false;
};
/// errors   nothing, `fault` says why: a word is missing, or its value leaves the motion to the control
[[nodiscard]] std::optional<HolePlace> place_of(const HoleWords& words, std::string& fault);

/// All words are equal but the place of the surface; heights that count from it to rounding.
[[nodiscard]] bool same_hole(const HoleWords& a, const HoleWords& b);

}  // namespace abbe::verifying
