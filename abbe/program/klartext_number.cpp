#include "abbe/program/klartext_number.h"

#include <array>

#include "abbe/core/number.h"

namespace abbe {
namespace {

constexpr std::size_t kLongestNumber = 24;
constexpr std::string_view kBytes = "0123456789.,+-";

}  // namespace

KlartextNumber read_klartext_number(std::string_view text) {
  std::array<char, kLongestNumber> digits{};
  std::size_t n = 0;
  KlartextNumber number;
  while (n < text.size() && n < digits.size() && kBytes.find(text[n]) != std::string_view::npos) {
    number.comma = number.comma || text[n] == ',';
    digits[n] = text[n] == ',' ? '.' : text[n];
    ++n;
  }
  const Decimal read = read_decimal({digits.data(), n});
  const bool ends = n == text.size() || text[n] == ' ' || text[n] == '\t' || text[n] == '\r';
  if (read.length == 0 || read.length != n || !ends) return {};
  number.value = read.value;
  number.decimals = static_cast<int>(read.decimals);
  number.length = n;
  return number;
}

}  // namespace abbe
