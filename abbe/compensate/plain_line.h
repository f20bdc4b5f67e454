#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace abbe {

/// A line that is nothing but axis words and perhaps a feed, with or without N and G1 before them:
/// "N10 G1 X1.5 Y2. F800". No blanks but one between words, capitals, no word twice, numbers without
/// a plus sign.
struct PlainLine {
  static constexpr std::size_t kFeed = 6;  ///< place of F behind X Y Z A B C
  struct Number {
    double value = 0;
    std::uint16_t begin = 0, end = 0;  ///< bytes of the number
    std::uint16_t decimals = 0;
  };
  std::string_view text, eol;
  unsigned named = 0;                         ///< bits 0 to 5 = X Y Z A B C, 6 = F
  std::array<Number, kFeed + 1> numbers;      ///< where `named` says so
  std::array<std::uint8_t, kFeed + 1> order;  ///< places in `numbers`, as the words stand in the line
  std::size_t count = 0;
  bool spaced = true;      ///< a further word needs a blank before it
  bool says_line = false;  ///< G1

  [[nodiscard]] bool has(std::size_t place) const { return (named >> place & 1) != 0; }
};

/// Reads a line with its end-of-line bytes. Words and values are those of read_block.
/// errors   false: the line says something else, or needs a closer look; `line` is then incomplete
/// laws     PlainLine.SaysWhatTheBlockSays
/// cost     about 6 ns per word, no allocation
[[nodiscard]] bool read_plain_line(std::string_view bytes, PlainLine& line);

}  // namespace abbe
