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

char first_of(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  return begin == std::string_view::npos ? ' ' : line[begin];
}

}  // namespace

std::optional<Subprogram> find_subprogram(const std::string& path, int number) {
  auto opened = LineReader::open(path, false);
  if (!std::holds_alternative<LineReader>(opened)) return std::nullopt;
  auto& reader = std::get<LineReader>(opened);
  std::optional<Subprogram> found;
  bool inside = false, begun = false;
  while (const auto line = reader.next()) {
    const char first = first_of(*line);
    if (first == '%' && begun) break;  // the control reads no further
    begun = begun || first == '/' || (first >= 'A' && first <= 'Z') || (first >= 'a' && first <= 'z');
    const int name = program_number(*line);
    const bool begins = name == number;
    if (begins && found) return std::nullopt;  // which of the two is run is not sure
    inside = begins || (inside && name < 0);
    if (begins) found = Subprogram{reader.line_number(), {}};
    if (!inside) continue;
    if (reader.too_long() || found->lines.size() == kMostSubprogramLines) return std::nullopt;
    found->lines.emplace_back(*line);
  }
  if (reader.error()) return std::nullopt;
  return found;
}

}  // namespace abbe
