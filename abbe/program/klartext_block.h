#pragma once

#include <optional>
#include <string_view>

#include "abbe/machine/profile.h"
#include "abbe/program/block.h"

namespace abbe {

/// A block may go on over several lines: all but the last end with '~'.
struct KlartextContext {
  bool open = false;                             ///< the next line belongs to the same block
  const Profile::Keyword* definition = nullptr;  ///< the cycle that it defines
  int cycle = 0;                                 ///< a drilling cycle to which lines of Q words still belong
  bool wanting = false;                          ///< cycle 247 has not said its preset yet
  bool comma = false;                            ///< numbers of the program have commas
};

/// Reads one line of a conversational program (Profile::Text::conversational): "12 L X+10 IZ-5,5 R0 FMAX M3",
/// "CC X+0 Y+0", "C X+5 DR-", "CR X+5 R+9 DR+", "TOOL CALL 1 Z S900", "CYCL DEF 7.1 X+5", "BEGIN PGM A MM".
/// What a block does becomes words as RS274 has them, each at the bytes that say it: L is G1 (with FMAX G0),
/// C and CR are G2 and G3, M91 is G28, R0 is G40, TOOL CALL is T M6 G43, BEGIN PGM is G21 or G20. CC has its
/// coordinates in I and J. PLANE SPATIAL has its angles in I, J and K, P1 where the control turns the rotary
/// axes (TURN, MOVE) and Q1 or Q-1 for SEQ+ and SEQ-. A cycle is the code that the profile calls CYCL and its
/// number; CYCL CALL is M99. The lines of a drilling cycle (Block::cycle) hold its Q words (read_hole_words);
/// they may go on in lines of Q words without '~'. The block number and comments are no words; `words_end` is
/// where coordinates are added. `context` goes from line to line.
/// errors   the first reason why the line is not understood; `block` is then incomplete
/// cost     about 100 ns for a line of three words, no allocation
[[nodiscard]] std::optional<BlockError> read_klartext_block(std::string_view line, const Profile& profile,
                                                            KlartextContext& context, Block& block);

/// The number at the start of a line.
struct BlockNumber {
  std::size_t begin = 0, end = 0;  ///< of the digits
  unsigned long value = 0;
};
/// errors   nullopt: there is none, or one of more than nine digits
[[nodiscard]] std::optional<BlockNumber> read_block_number(std::string_view line);

}  // namespace abbe
