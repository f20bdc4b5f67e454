#include "abbe/program/swivel.h"

#include <cmath>
#include <cstddef>

#include "abbe/core/number.h"

namespace abbe {
namespace {

constexpr std::size_t kFewest = 14, kMost = 16;
constexpr double kLargestNumber = 1e6;
enum Place : std::size_t {
  kRetract,
  kData,
  kState,
  kMode,
  kBefore,
  kAngles = 7,
  kBehind = 10,
  kDirection = 13
};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

/// The literal number of an argument, 0 if it is left out.
std::optional<double> number_of(std::string_view text) {
  if (text.empty()) return 0.0;
  const Decimal number = read_decimal(text);
  if (number.length != text.size() || !(std::abs(number.value) <= kLargestNumber)) return std::nullopt;
  return number.value;
}

/// Axis by axis: three different axes in the six lowest bits, and no others.
bool read_mode(double mode, std::array<int, 3>& axes) {
  if (mode != std::floor(mode) || mode < 0 || mode > 63) return false;
  const int bits = static_cast<int>(mode);
  unsigned seen = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    axes[i] = (bits >> 2 * static_cast<int>(i) & 3) - 1;
    if (axes[i] < 0) return false;
    seen |= 1U << axes[i];
  }
  return seen == 7;
}

}  // namespace

std::optional<Swivel> read_swivel(std::string_view code) {
  Swivel swivel;
  const std::size_t open = code.find('('), close = code.rfind(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return std::nullopt;
  std::string_view rest = trimmed(code.substr(open + 1, close - open - 1));
  if (rest.empty()) {
    swivel.ends = true;
    return swivel;
  }
  std::array<double, kMost> numbers{};
  std::size_t count = 0;
  for (bool more = true; more; ++count) {
    const bool quoted = count == kData && !rest.empty() && rest[0] == '"';
    const std::size_t from = quoted ? rest.find('"', 1) : 0;
    if (count == kMost || from == std::string_view::npos) return std::nullopt;
    const std::size_t comma = rest.find(',', from);
    const std::string_view argument = trimmed(rest.substr(0, comma));
    more = comma != std::string_view::npos;
    rest = more ? trimmed(rest.substr(comma + 1)) : std::string_view();
    if (count == kData) {
      if (!quoted || argument == "\"0\"" || argument.back() != '"') return std::nullopt;
      continue;
    }
    const auto number = number_of(argument);
    if (!number) return std::nullopt;
    numbers[count] = *number;
  }
  const double retract = numbers[kRetract], direction = numbers[kDirection];
  const bool known = count >= kFewest && numbers[kState] == 0 && read_mode(numbers[kMode], swivel.axes) &&
                     retract == std::floor(retract) && retract >= 0 && retract <= 8 &&
                     direction == std::floor(direction) && std::abs(direction) <= 1;
  if (!known) return std::nullopt;
  for (std::size_t i = 0; i < 3; ++i) {
    swivel.before[static_cast<Eigen::Index>(i)] = numbers[kBefore + i];
    swivel.angles[i] = numbers[kAngles + i];
    swivel.behind[static_cast<Eigen::Index>(i)] = numbers[kBehind + i];
  }
  swivel.direction = static_cast<int>(direction);
  return swivel;
}

}  // namespace abbe
