#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/profile.h"

namespace abbe {

/// One number that differs between an original and its compensated program.
struct WordChange {
  std::uint64_t line_in = 0, line_out = 0;
  char letter = 0;
  bool added = false;  ///< the word stands in the output only
  double before = 0, after = 0;
  std::string text_before, text_after;
};

struct DiffReport {
  bool readable = false;      ///< false: see diagnostics
  bool same_program = false;  ///< apart from what is counted here every byte is the same
  std::uint64_t lines_in = 0, lines_out = 0, changed_words = 0, added_words = 0, added_blocks = 0,
                header_lines = 0;
  std::uint64_t taken_up =
      0;  ///< arcs whose block became the straight move that takes up lost motion before them
  std::array<double, 3> max_change{};  ///< of X Y Z words in absolute blocks, program units
  std::array<std::uint64_t, 3> max_line{};
  Diagnostics diagnostics;
};

/// Compares two texts word by word: what changed, and that nothing else did. It says nothing about the
/// path: that is verify_program.
/// each     called for every changed or added word, in order; may be empty
/// profile  of the control, whose words may have names; null: RS274 letters
[[nodiscard]] DiffReport diff_programs(const std::string& original, const std::string& output,
                                       const std::function<void(const WordChange&)>& each,
                                       const Profile* profile = nullptr);

}  // namespace abbe
