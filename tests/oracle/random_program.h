#pragma once

#include <cstdint>
#include <string>

namespace abbe::oracle {

struct Ingredients {
  bool cycles = false;        ///< canned cycles
  bool machine_moves = true;  ///< G53
  bool tool_numbers = true;   ///< M61, after which the oracle does not say which tool is in the spindle
  bool rotations = true;      ///< work offsets rotated about Z
  bool all_planes = true;     ///< arcs in G18 and G19, too
};

/// A valid three-axis program of about 60 blocks that uses the language in random order: units, planes,
/// work offsets, G92 and G52, tool offsets, distance modes, lines, arcs in both forms, several spellings
/// of words. The same seed gives the same bytes.
///
/// The generator knows no frames: what depends on the position (arcs, increments) follows an absolute
/// move of all three axes, and is written relative to its words.
[[nodiscard]] std::string random_program(std::uint64_t seed, const Ingredients& ingredients);

/// A contour under cutter radius compensation with a tool of tool.tbl, every third in a turned work offset.
/// `worn_only`: the path of the centre, with a wear of zero.
[[nodiscard]] std::string random_contour(std::uint64_t seed, bool worn_only);

}  // namespace abbe::oracle
