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

}  // namespace

bool read_plain_line(std::string_view bytes, PlainLine& line) {
  const std::string_view text = without_eol(bytes);
  line.text = text;
  line.eol = bytes.substr(text.size());
  line.named = 0;
  line.count = 0;
  line.spaced = true;
  if (text.empty() || text.size() > kMaxBlockBytes) return false;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  for (const char* p = begin; p != end;) {
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
    if (line.count == 1) line.spaced = blank;
    if (blank && ++p == end) return false;  // a blank at the end
  }
  return (line.named & ~(1u << PlainLine::kFeed)) != 0;
}

}  // namespace abbe
