#include "abbe/compensate/block_numbers.h"

#include <fmt/format.h>

#include "abbe/program/klartext_block.h"

namespace abbe {

bool BlockNumbers::append(std::string_view line, bool added, std::string& to) {
  const auto number = read_block_number(line);
  if (!number) {
    if (added) to += fmt::format("{} ", last_.value_or(0) + ++added_);
    to += line;
    return true;
  }
  const bool grows = !last_ || number->value > *last_;
  last_ = number->value;
  to += line.substr(0, number->begin);
  if (added_ == 0)
    to += line.substr(number->begin, number->end - number->begin);
  else
    to += fmt::format("{}", number->value + added_);
  to += line.substr(number->end);
  return grows;
}

bool BlockNumbers::renumber(std::string_view text, std::size_t begin, std::string& out) {
  const bool numbered = read_block_number(text).has_value();
  const std::string written = out.substr(begin);
  out.resize(begin);
  bool grow = true, goes_on = false;
  for (std::size_t at = 0; at < written.size();) {
    const std::size_t end = std::min(written.find('\n', at), written.size() - 1) + 1;
    const std::string_view line = std::string_view(written).substr(at, end - at);
    grow = append(line, numbered && !goes_on, out) && grow;
    const std::size_t last = line.find_last_not_of(" \t\r\n");
    goes_on = last != std::string_view::npos && line[last] == '~';
    at = end;
  }
  return grow;
}

}  // namespace abbe
