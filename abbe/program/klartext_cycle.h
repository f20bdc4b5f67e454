#pragma once

#include <optional>

#include "abbe/program/klartext_scan.h"

namespace abbe {

/// Definitions of cycles in conversational programs, CYCL DEF and what stands behind it: one block with Q
/// words (200 to 209, 247), or a title and a line for each value (7.0, 7.1 X+5).
class KlartextCycle : public KlartextScan {
 public:
  using KlartextScan::KlartextScan;

 protected:
  /// The rest of a block CYCL DEF that began at `begin`.
  /// errors   E-CYCLE E-FRAME E-WCS E-EXPR and what the profile says of a cycle that it refuses
  std::optional<BlockError> read_definition(std::size_t begin);
  /// Q words of a drilling cycle.
  std::optional<BlockError> read_cycle_words();
  /// "Q339=+1": the preset that cycle 247 puts in force.
  std::optional<BlockError> read_parameters();

 private:
  std::optional<BlockError> begin_hole(const Profile::Keyword& keyword, std::size_t begin);
  std::optional<BlockError> read_hole_part(const Profile::Keyword& keyword, int part, std::size_t begin);
  std::optional<BlockError> read_shift(const Profile::Keyword& keyword, std::size_t begin);
  std::optional<BlockError> read_frame(const Profile::Keyword& keyword, std::size_t begin);
  std::optional<BlockError> read_frame_word(Meaning meaning, bool& known);
};

}  // namespace abbe
