#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "abbe/machine/control_model.h"
#include "abbe/machine/profile.h"
#include "abbe/verify/hole_words.h"

namespace abbe::verifying {

/// Longest block that any control reads, in bytes without the end of line.
inline constexpr std::size_t kMaxBlockLength = 254;
/// Numbers above this are refused, so that no later product overflows.
inline constexpr double kMaxNumber = 1e9;

/// Why a block was refused; becomes a Diagnostic when the reader adds file and line.
struct Fault {
  const char* code = "";
  std::size_t column = 0;  ///< bytes from 1
  std::size_t length = 1;
  std::string message, why, fix;
};

/// A set of word letters: bit 0 = A, bit 25 = Z.
using Letters = LetterSet;
constexpr Letters letter_bit(char letter) { return Letters{1} << (letter - 'A'); }
template <class... Char>
constexpr Letters letters(Char... letter) {
  return (letter_bit(letter) | ...);
}

/// What the lines before leave open in a conversational program: a block ends with the first line without
/// '~'.
struct Continued {
  bool open = false;
  bool preset = false;  ///< the block is CYCL DEF 247
  int hole = 0;         ///< lines of Q words belong to this drilling cycle, behind '~' or not
};

/// The words of one block, before any meaning. Arrays are valid only where a bit says so, so that
/// clearing a block costs four stores.
struct Block {
  /// LinuxCNC's modal groups of G codes; 11 holds frames, 16 and 17 the ends of a scale and a mirror,
  /// 18 and 19 how the tool turns between blocks, 20 a cycle with brackets.
  static constexpr int kGroups = 21;
  static constexpr int kRetracts = 1;           ///< M group: M140
  static constexpr int kWays = 2;               ///< M group: M126 M127, how rotary axes turn
  static constexpr int kCalls = 3;              ///< M group: M99 M89, calls of a drilling cycle
  static constexpr int kStops = 4;              ///< M group: M0 M1 M2 M30 M60
  static constexpr int kFurtherOffset = 10000;  ///< in the group of work offsets: P says which
  static constexpr int kMaxExtras = 12;
  static constexpr int kMGroups = 10;
  static constexpr int kMaxComments = 127;

  Letters words = 0;                           ///< value words present (neither G nor M)
  static constexpr std::size_t kLetters = 29;  ///< A to Z, and kVectorLetters
  std::array<double, kLetters> value;          ///< by letter
  std::array<std::uint8_t, kLetters> column;
  std::uint32_t g_groups = 0;           ///< bit = group
  std::array<std::int16_t, kGroups> g;  ///< 10 times the code: G59.1 is 591
  std::array<std::uint8_t, kGroups> g_column;
  std::array<Letters, kGroups> g_words;  ///< letters that belong to the code
  std::uint32_t m_groups = 0;
  std::array<std::int16_t, kMGroups> m;
  std::array<std::uint8_t, kMGroups> m_column;
  std::array<Letters, kMGroups> m_words;
  std::uint32_t m_after = 0;  ///< groups whose code acts when the motion is done
  /// Codes without a group: they stand beside each other.
  struct Extra {
    char kind;  ///< G or M
    bool after;
    std::int16_t code;  ///< G: 10 times, or the place of a word in Profile::g
    Letters words;
    std::string_view text;  ///< of a code that is a word, with its arguments
  };
  int extra_count = 0;
  std::array<Extra, kMaxExtras> extras;
  Letters pointless = 0;  ///< words whose number has no point, where that matters
  int tcp_code = -1;      ///< 10 times the number of a code that switches tool centre point control
  char tcp_letter = 'G';
  bool tcp = false;              ///< on or off
  bool tcp_vectors = false;      ///< and with it I J K of straight motions become the tool's direction
  bool deletable = false;        ///< starts with '/'
  std::string_view frame_text;   ///< of a code of group 11 that is a word, with its brackets
  std::string_view tool_name;    ///< T="..", without quotes; the T word is then 0
  std::uint32_t increments = 0;  ///< axes whose word is a distance by itself (IX), bits 0 1 2 = X Y Z
  std::uint32_t places = 0;      ///< words that are places whatever the mode (X=AC(5)); bits 3 4 5 = I J K
  enum class Pole : std::uint8_t { none, set, used };
  Pole pole = Pole::none;    ///< CC X Y: sets the centre of the arcs that follow; C: goes about it
  HoleWords hole;            ///< Q words of a drilling cycle that this line (hole.cycle != 0) defines
  bool hole_begins = false;  ///< the line is the first one of the definition
  bool tool_data = false;    ///< TOOL DEF: T, and L or R of the tool, which are no words to be executed
  /// LBL 5, CALL LBL 5, LBL 0 of conversational programs; `label` is "5".
  enum class Flow : std::uint8_t { none, label, call, end };
  Flow flow = Flow::none;
  std::string_view label;
  int comment_count = 0;
  std::array<std::string_view, kMaxComments> comments;  ///< with their delimiters

  [[nodiscard]] bool has(char letter) const { return (words & letter_bit(letter)) != 0; }
  [[nodiscard]] double operator[](char letter) const { return value[static_cast<std::size_t>(letter - 'A')]; }
  [[nodiscard]] std::size_t column_of(char letter) const {
    return column[static_cast<std::size_t>(letter - 'A')];
  }
  /// The code of a G group times 10, or -1.
  [[nodiscard]] int g_code(int group) const {
    return (g_groups >> group & 1) != 0 ? g[static_cast<std::size_t>(group)] : -1;
  }
  [[nodiscard]] int m_code(int group) const {
    return (m_groups >> group & 1) != 0 ? m[static_cast<std::size_t>(group)] : -1;
  }
};

/// Splits one line (without its end of line) into words, as the control of the profile does. Every byte is
/// part of a known word, a comment or blank, or the block is refused. errors   false with `fault` filled:
/// E-CHAR E-COMMENT E-LINELEN E-OWORD E-EXPR E-NUMBER E-WORD E-AXIS
///          E-GCODE E-MCODE E-CUTCOM E-BLOCK
/// cost     about 10 ns per word, no allocation unless refused
/// `tcp_codes`: codes of this control that switch tool centre point control.
[[nodiscard]] bool read_block(std::string_view line, const Profile& profile, Block& block, Fault& fault,
                              std::span<const TcpCode> tcp_codes = {}, Continued continued = {});

}  // namespace abbe::verifying
