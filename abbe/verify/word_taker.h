#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "abbe/verify/block.h"

namespace abbe::verifying {

constexpr Letters kValueLetters =
    letters('N', 'T', 'S', 'F', 'D', 'H', 'L', 'P', 'Q', 'R', 'X', 'Y', 'Z', 'I', 'J', 'K', 'A', 'B', 'C') |
    letter_set(kVectorLetters);

/// Fills the fault; always false. `column` counts from 1.
bool refuse(Fault& fault, std::size_t column, std::size_t length, const char* code, std::string message,
            std::string why, std::string fix);

/// Puts words that a scanner has found into a block: codes into their groups, values under their letters.
/// Columns count from 1; at_ is behind the word. errors   false with the fault filled: E-GCODE E-MCODE E-WORD
/// E-AXIS E-BLOCK, and what the profile says
class WordTaker {
 public:
  /// `at` bytes have been read.
  WordTaker(std::string_view line, std::size_t at, const Profile& profile, Block& block, Fault& fault,
            std::span<const TcpCode> tcp_codes)
      : line_(line), profile_(profile), block_(block), fault_(fault), at_(at), tcp_codes_(tcp_codes) {}

 protected:
  [[nodiscard]] bool g_word(double value, std::size_t column);
  [[nodiscard]] bool m_word(double value, std::size_t column);
  [[nodiscard]] bool value_word(char letter, double value, std::size_t column, bool first);
  /// A code that is a word; `text` is the word with all that belongs to it.
  [[nodiscard]] bool keyword(const Profile::Keyword& word, std::string_view text, std::size_t column);

  std::string_view line_;
  const Profile& profile_;
  Block& block_;
  Fault& fault_;
  std::size_t at_;
  std::span<const TcpCode> tcp_codes_;

 private:
  bool refuse_code(const std::string& name, const char* usual, const CodeUse& use, std::size_t column);
  bool extra(char kind, const CodeUse& use, int code, std::string_view text, std::size_t column);
  bool take_code(std::string_view word, double value, int number, const CodeUse& use, std::string_view text,
                 std::size_t column);
  bool tcp_switch(char letter, int code);
};

}  // namespace abbe::verifying
