#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "abbe/verify/word_taker.h"

namespace abbe::verifying {

inline constexpr std::string_view kBlanks = " \t\r";
inline constexpr std::string_view kDigits = "0123456789";

inline std::string_view stripped(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

inline bool goes_on(std::string_view line) {
  const std::string_view said = stripped(line);
  return !said.empty() && said.back() == '~';
}

inline bool begins(std::string_view text, std::string_view with) {
  return text.substr(0, with.size()) == with;
}

inline bool is_hole(std::string_view cycle) {
  return cycle.size() == 3 && begins(cycle, "20") && kDigits.find(cycle[2]) != std::string_view::npos;
}

inline bool begins_q_word(std::string_view text) {
  return text.size() > 1 && text[0] == 'Q' && kDigits.find(text[1]) != std::string_view::npos;
}

/// A line of a conversational program cut into items at its blanks, and what every kind of block needs of
/// them: numbers, coordinates, comments, refusals with their column. Only for the scanner of
/// read_klartext_words.
class KlartextItems : public WordTaker {
 public:
  using WordTaker::WordTaker;

 protected:
  static constexpr std::size_t kMostItems = 40;

  bool keep_text(std::string_view text);
  /// The column of an item, from 1; at_ is put behind it.
  std::size_t column(std::string_view item);
  /// Always false: refuses the line for this item.
  bool bad(std::string_view item, const char* code, std::string message, const char* why, const char* fix);
  bool cut(std::string_view rest);
  [[nodiscard]] std::string_view item(std::size_t i) const {
    return i < count_ ? items_[i] : std::string_view();
  }
  [[nodiscard]] static std::string_view from_to(std::string_view first, std::string_view last) {
    return {first.data(), static_cast<std::size_t>(last.data() - first.data()) + last.size()};
  }
  /// Always false: an item that has no place in the block.
  bool unknown(std::string_view said);
  /// A literal number that is the whole of `digits`, with a point or a comma. `of`: the item it belongs to.
  bool number(std::string_view digits, std::string_view of, double& value);
  /// Coordinates from item i on, which becomes the first that is none.
  bool coordinates(std::size_t& i, std::string_view letters);

  std::string_view whole_;
  std::array<std::string_view, kMostItems> items_;
  std::size_t count_ = 0;
};

}  // namespace abbe::verifying
