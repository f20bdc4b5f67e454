#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace abbe {

/// One word of a block: a letter and a number, and where both stand in the line.
struct Word {
  char letter = 0;             ///< upper case
  bool tidy = true;            ///< no blanks inside the number
  std::uint16_t begin = 0;     ///< of the letter
  std::uint16_t number = 0;    ///< first byte of the number
  std::uint16_t end = 0;       ///< past the number
  std::uint16_t decimals = 0;  ///< digits after the point
  double value = 0;
};

/// How a program spells numbers: "10.5", "+10.5", "+10,5".
struct NumberStyle {
  bool sign = false;   ///< also of positive numbers
  bool comma = false;  ///< in place of the point
};

/// What a line of a program says, as byte ranges of the line: nothing is copied or changed.
struct Block {
  static constexpr int kMaxWords = 48;
  std::string_view text;  ///< without end-of-line bytes
  std::string_view eol;   ///< "\n", "\r\n", "" at the end of a file without one
  bool slash = false;     ///< block delete
  bool percent = false;   ///< a line with '%' and nothing else
  bool has_comment = false;
  bool has_semicolon = false;                    ///< a comment begins with ';'
  std::uint16_t slash_begin = 0, slash_end = 0;  ///< of "/" or "/2"
  std::uint16_t words_end = 0;                   ///< past the last word (or the slash): where words are added
  int count = 0;
  std::array<Word, kMaxWords> words;

  // Of conversational blocks (read_klartext_block); elsewhere as they stand here.
  /// What a block has to do with the pole CC: it sets it with I and J, or goes about it (C).
  enum class Pole : std::uint8_t { none, set, used };
  Pole pole = Pole::none;
  std::uint8_t increments = 0;  ///< axes whose word is a distance (IX), bits 0 1 2 = X Y Z
  std::uint8_t places = 0;      ///< words that are places whatever the mode (X=AC(5)), bits 0 to 5 = X Y Z I J K
  bool continues = false;       ///< the line belongs to the block of the line before
  std::int16_t cycle = 0;       ///< the line is part of the definition of this drilling cycle
  bool defines = false;         ///< and its first one
  std::string_view brackets;    ///< the cycle with its numbers: "CYCLE81(50, 0, 2, -20)"
  bool modal_call = false;      ///< MCALL stands before it, or alone
  bool tool_data = false;       ///< TOOL DEF with the length L and radius R of tool T
  /// Subprograms: LBL 1, CALL LBL 1, LBL 0; `label` is what stands behind LBL.
  enum class Flow : std::uint8_t { none, label, call, end };
  Flow flow = Flow::none;
  std::string_view label;
  std::array<std::uint16_t, kMaxWords> parameters;  ///< of its words: 203 of Q203
  NumberStyle style;                                ///< of numbers that are written into the block

  /// "/", "/2" or nothing.
  [[nodiscard]] std::string_view slash_text() const {
    return text.substr(slash_begin, static_cast<std::size_t>(slash_end - slash_begin));
  }
};

/// Why a line is not a block; `column` counts from 0.
struct BlockError {
  const char* code = "";
  std::size_t column = 0;
  std::size_t length = 1;
  std::string message, why, fix;
};

/// LinuxCNC refuses longer lines (its LINELEN is 255).
inline constexpr std::size_t kMaxBlockBytes = 254;

/// Reads one line (with its end-of-line bytes) of RS274/NGC text: blanks are allowed anywhere outside
/// comments, letters in either case, numbers without exponent. A block delete may have a digit ("/2") where
/// `numbered_skip` says so.
/// errors   the first reason why the line is not understood; `block` is then incomplete
/// cost     about 30 ns for a line of three words, no allocation
[[nodiscard]] std::optional<BlockError> read_block(std::string_view line, Block& block,
                                                   bool numbered_skip = false);

/// Gives the block the line and no words. errors   E-LINELEN: the line is longer than kMaxBlockBytes
[[nodiscard]] std::optional<BlockError> begin_block(std::string_view line, Block& block);

/// Splits end-of-line bytes off a line.
[[nodiscard]] std::string_view without_eol(std::string_view line);

}  // namespace abbe
