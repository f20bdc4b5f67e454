#include "abbe/verify/klartext_items.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/core/number.h"

namespace abbe::verifying {

bool KlartextItems::keep_text(std::string_view text) {
  if (text.empty()) return true;
  block_.comments[static_cast<std::size_t>(block_.comment_count++)] = text;
  return true;
}

std::size_t KlartextItems::column(std::string_view item) {
  const auto begin = static_cast<std::size_t>(item.data() - line_.data());
  at_ = begin + item.size();
  return begin + 1;
}

bool KlartextItems::bad(std::string_view item, const char* code, std::string message, const char* why,
                        const char* fix) {
  const std::size_t place = column(item);
  return refuse(fault_, place, std::max<std::size_t>(1, item.size()), code, std::move(message), why, fix);
}

bool KlartextItems::cut(std::string_view rest) {
  for (std::size_t at = 0; at < rest.size();) {
    at = rest.find_first_not_of(kBlanks, at);
    if (at == std::string_view::npos) break;
    const std::size_t end = std::min(rest.size(), rest.find_first_of(kBlanks, at));
    if (count_ == kMostItems)
      return bad(rest.substr(at, 1), "E-BLOCK", "too many words in a block",
                 "no control accepts such a block", "use two blocks");
    items_[count_++] = rest.substr(at, end - at);
    at = end;
  }
  return true;
}

bool KlartextItems::unknown(std::string_view said) {
  std::size_t length = 0;
  while (length < said.size() && said[length] >= 'A' && said[length] <= 'Z') ++length;
  const std::string_view name = said.substr(0, length);
  column(said);
  if (const Profile::Keyword* word = find_keyword(profile_, name);
      word != nullptr && profile_.g[word->index].refusal != 0)
    return keyword(*word, name, column(said));
  if (name == "Q")
    return bad(said, "E-EXPR", "variables are not read", "their value is known only to the control",
               "post the program with literal numbers");
  return bad(said, "E-GCODE", fmt::format("{} is not understood for {}", said, profile_.title),
             "an unknown word may move the machine or change its state", "post the program without it");
}

bool KlartextItems::number(std::string_view digits, std::string_view of, double& value) {
  std::string text(digits.substr(0, 40));
  std::replace(text.begin(), text.end(), ',', '.');
  const Decimal read = read_decimal(text);
  if (read.length == 0 || read.length != digits.size())
    return bad(of, "E-EXPR", fmt::format("{} has no literal number", of),
               "its value is known only to the control", "post the program with literal numbers");
  value = read.value;
  if (std::abs(value) <= kMaxNumber) return true;
  return bad(of, "E-NUMBER", "the number is too large", "no machine goes there", "correct the number");
}

bool KlartextItems::coordinates(std::size_t& i, std::string_view letters) {
  for (; i < count_; ++i) {
    std::string_view said = items_[i];
    const bool distance = said[0] == 'I';
    if (distance) said.remove_prefix(1);
    const bool named = !said.empty() && letters.find(said[0]) != std::string_view::npos &&
                       (said.size() == 1 || said[1] < 'A' || said[1] > 'Z');
    if (!named) return true;
    const char letter = said[0];
    std::string_view digits = said.substr(1);
    if (digits.empty()) digits = item(++i);
    double value = 0;
    if (!number(digits, said, value)) return false;
    if (distance) {
      if (letter < 'X')
        return bad(said, "E-ROTARY", "an increment of a rotary axis", "its whole turns are not sure",
                   "post the angle itself");
      block_.increments |= std::uint32_t{1} << (letter - 'X');
    }
    if (!value_word(letter, value, column(said), false)) return false;
  }
  return true;
}

}  // namespace abbe::verifying
