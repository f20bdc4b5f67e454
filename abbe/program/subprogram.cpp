#include "abbe/program/subprogram.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <variant>

#include "abbe/core/file.h"
#include "abbe/core/number.h"
#include "abbe/program/block.h"
#include "abbe/program/klartext_block.h"

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

/// What stands behind LBL in "12 LBL 5 ; TEXT"; nothing: the line is no label.
std::string_view label_of(std::string_view line) {
  line = without_eol(line);
  if (const auto number = read_block_number(line)) line.remove_prefix(number->end);
  line = line.substr(0, line.find(';'));
  constexpr std::string_view kLabel = "LBL ", kBlanks = " \t\r";
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks)));
  if (line.substr(0, kLabel.size()) != kLabel) return {};
  line.remove_prefix(std::min(line.size(), line.find_first_not_of(kBlanks, kLabel.size())));
  return line.substr(0, line.find_last_not_of(kBlanks) + 1);
}

}  // namespace

std::optional<Subprogram> find_label(const std::string& path, std::string_view label) {
  auto opened = LineReader::open(path, false);
  if (!std::holds_alternative<LineReader>(opened)) return std::nullopt;
  auto& reader = std::get<LineReader>(opened);
  std::optional<Subprogram> found;
  bool inside = false;
  while (const auto line = reader.next()) {
    const std::string_view here = label_of(*line);
    if (here == label) {
      if (found) return std::nullopt;  // which of the two is run is not sure
      found = Subprogram{reader.line_number(), {}};
      inside = true;
    }
    if (!inside) continue;
    if (reader.too_long() || found->lines.size() == kMostSubprogramLines) return std::nullopt;
    found->lines.emplace_back(*line);
    inside = here.empty() || here.find_first_not_of('0') != std::string_view::npos;
  }
  if (reader.error()) return std::nullopt;
  return found;
}

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
