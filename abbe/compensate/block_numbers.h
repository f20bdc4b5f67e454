#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace abbe {

/// Numbers of the blocks of a conversational program. Blocks that were added get the number behind the one
/// before them, and all numbers that follow grow by as many. Lines without a number keep none; neither does a
/// line behind '~', which belongs to the block of the line before.
class BlockNumbers {
 public:
  /// Numbers the lines of `out` from `begin` on, which have come of the block `text`.
  /// errors   false: the numbers of the program do not grow from block to block
  /// cost     nothing is moved as long as no block has been added
  [[nodiscard]] bool renumber(std::string_view text, std::size_t begin, std::string& out);

 private:
  bool append(std::string_view line, bool added, std::string& to);

  unsigned long added_ = 0;
  std::optional<unsigned long> last_;  ///< of the original
};

}  // namespace abbe
