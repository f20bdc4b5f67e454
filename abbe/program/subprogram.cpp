#include "abbe/program/subprogram.h"

#include <string_view>
#include <utility>
#include <variant>

#include "abbe/core/file.h"
#include "abbe/core/number.h"

namespace abbe {
namespace {

/// The number of "O2000 (NAME)"; -1: the line begins otherwise.
int program_number(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos || (line[begin] != 'O' && line[begin] != 'o')) return -1;
  const Decimal number = read_decimal(line.substr(begin + 1));
  return number.length == 0 || number.has_point || number.has_sign || number.value > 99999999
             ? -1
             : static_cast<int>(number.value);
}

bool begins_another(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  return begin != std::string_view::npos && (line[begin] == '%' || program_number(line) >= 0);
}

}  // namespace

std::optional<Subprogram> find_subprogram(const std::string& path, int number) {
  auto opened = LineReader::open(path, false);
  if (!std::holds_alternative<LineReader>(opened)) return std::nullopt;
  auto& reader = std::get<LineReader>(opened);
  std::optional<Subprogram> found;
  bool inside = false;
  while (const auto line = reader.next()) {
    const bool begins = program_number(*line) == number;
    if (begins && found) return std::nullopt;  // which of the two is run is not sure
    inside = begins || (inside && !begins_another(*line));
    if (begins) found = Subprogram{reader.line_number(), {}};
    if (!inside) continue;
    if (reader.too_long() || found->lines.size() == kMostSubprogramLines) return std::nullopt;
    found->lines.emplace_back(*line);
  }
  if (reader.error()) return std::nullopt;
  return found;
}

}  // namespace abbe
