#include "abbe/compensate/plain_line.h"

#include "abbe/core/number.h"
#include "abbe/program/block.h"

namespace abbe {
namespace {

constexpr std::size_t kNoPlace = 31;

/// Where the number of a word of this letter goes; kNoPlace: the line is not plain.
constexpr std::array<std::uint8_t, 256> make_places() {
  std::array<std::uint8_t, 256> places{};
  for (auto& place : places) place = kNoPlace;
  constexpr std::string_view kLetters = "XYZABCF";
  for (std::size_t i = 0; i < kLetters.size(); ++i)
    places[static_cast<unsigned char>(kLetters[i])] = static_cast<std::uint8_t>(i);
  return places;
}
constexpr std::array<std::uint8_t, 256> kPlaces = make_places();

/// Behind "N120" and "G1" or "G01", one blank behind each included; null if the line begins otherwise.
const char* behind_prefix(const char* p, const char* end, PlainLine& line) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto gap = [&](const char* at, bool first) {
    const bool blank = at != end && *at == ' ';
    if (first) line.spaced = blank;
    return at + (blank ? 1 : 0);
  };
  const char* const begin = p;
  if (*p == 'N') {
    constexpr std::ptrdiff_t kMostDigits = 9;
    const char* const digits = ++p;
    while (p != end && is_digit(*p)) ++p;
    if (p == digits || p - digits > kMostDigits) return nullptr;
    p = gap(p, true);
  }
  if (p == end || *p != 'G') return p;
  const bool first = p == begin;
  ++p;
  if (p != end && *p == '0') ++p;
  if (p == end || *p != '1') return nullptr;
  line.says_line = true;
  return gap(p + 1, first);
}

}  // namespace

bool read_plain_line(std::string_view bytes, PlainLine& line) {
  const std::string_view text = without_eol(bytes);
  line.text = text;
  line.eol = bytes.substr(text.size());
  line.named = 0;
  line.count = 0;
  line.spaced = true;
  line.says_line = false;
  if (text.empty() || text.size() > kMaxBlockBytes) return false;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const char* const words = behind_prefix(begin, end, line);
  if (words == nullptr) return false;
  for (const char* p = words; p != end;) {
    const std::size_t place = kPlaces[static_cast<unsigned char>(*p)];
    if (place == kNoPlace || line.has(place)) return false;
    PlainLine::Number& number = line.numbers[place];
    int decimals = 0;
    const char* const behind = read_plain_decimal(begin, p + 1, end, number.value, decimals);
    if (behind == nullptr) return false;
    number.begin = static_cast<std::uint16_t>(p + 1 - begin);
    number.end = static_cast<std::uint16_t>(behind - begin);
    number.decimals = static_cast<std::uint16_t>(decimals);
    line.named |= 1u << place;
    line.order[line.count++] = static_cast<std::uint8_t>(place);
    p = behind;
    if (p == end) break;
    const bool blank = *p == ' ';
    if (line.count == 1 && words == begin) line.spaced = blank;
    if (blank && ++p == end) return false;  // a blank at the end
  }
  return (line.named & ~(1u << PlainLine::kFeed)) != 0;
}

}  // namespace abbe
