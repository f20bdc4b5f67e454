#pragma once

#include <cstdint>
#include <string>

namespace abbe::oracle {

/// A valid three-axis program of about 60 blocks that uses the language in random order: units, planes,
/// work offsets, G92 and G52, tool offsets, distance modes, lines, arcs in both forms, several spellings
/// of words, and canned cycles if asked for. The same seed gives the same bytes.
///
/// The generator knows no frames: what depends on the position (arcs, increments) follows an absolute
/// move of all three axes, and is written relative to its words.
[[nodiscard]] std::string random_program(std::uint64_t seed, bool with_cycles);

}  // namespace abbe::oracle
