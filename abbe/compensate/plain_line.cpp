#include "abbe/compensate/plain_line.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include <algorithm>
#include <bit>
#include <cstring>

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

/// Enters a word that begins at `p` and whose number ends at `behind`.
void enter(PlainLine& line, std::size_t place, const char* p, const char* behind, double value, int decimals) {
  const char* const begin = line.text.data();
  line.numbers[place] = {value, static_cast<std::uint16_t>(p + 1 - begin), static_cast<std::uint16_t>(behind - begin),
                         static_cast<std::uint16_t>(decimals)};
  line.named |= 1u << place;
  line.order[line.count++] = static_cast<std::uint8_t>(place);
}

/// Word after word, each from where the one before ends.
bool read_words(const char* words, PlainLine& line) {
  const char* const begin = line.text.data();
  const char* const end = begin + line.text.size();
  for (const char* p = words; p != end;) {
    const std::size_t place = kPlaces[static_cast<unsigned char>(*p)];
    if (place == kNoPlace || line.has(place)) return false;
    double value = 0;
    int decimals = 0;
    const char* const behind = read_plain_decimal(begin, p + 1, end, value, decimals);
    if (behind == nullptr) return false;
    enter(line, place, p, behind, value, decimals);
    p = behind;
    if (p == end) break;
    const bool blank = *p == ' ';
    if (line.count == 1 && words == begin) line.spaced = blank;
    if (blank && ++p == end) return false;  // a blank at the end
  }
  return true;
}

#if defined(__SSE2__)
constexpr std::size_t kLane = 16, kMostMasked = 64;

/// Bit i: what byte i of a text of 16 to 64 bytes is.
struct Kinds {
  std::uint64_t letters = 0, points = 0, minuses = 0, blanks = 0, digits = 0;
};
Kinds kinds_of(const char* text, std::size_t size) {
  Kinds kinds;
  for (std::size_t at = 0; at < size; at += kLane) {
    // The last bytes are read with those before them, never with what is behind the text.
    const std::size_t from = std::min(at, size - kLane);
    __m128i bytes;
    std::memcpy(&bytes, text + from, sizeof bytes);
    const auto equal = [&](char c) {
      return static_cast<std::uint64_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(bytes, _mm_set1_epi8(c)))) << from;
    };
    const auto between = [&](char lo, char hi) {  // of signed bytes
      const __m128i inside = _mm_and_si128(_mm_cmpgt_epi8(bytes, _mm_set1_epi8(static_cast<char>(lo - 1))),
                                           _mm_cmplt_epi8(bytes, _mm_set1_epi8(static_cast<char>(hi + 1))));
      return static_cast<std::uint64_t>(_mm_movemask_epi8(inside)) << from;
    };
    kinds.letters |= between('A', 'Z');
    kinds.digits |= between('0', '9');
    kinds.points |= equal('.');
    kinds.minuses |= equal('-');
    kinds.blanks |= equal(' ');
  }
  return kinds;
}

/// As read_words, for texts of 16 to 64 bytes: all letters are found first, so no number waits for the end of
/// another.
bool read_words_at_once(const char* words, PlainLine& line) {
  const char* const begin = line.text.data();
  const std::size_t size = line.text.size();
  const Kinds kinds = kinds_of(begin, size);
  const std::uint64_t whole = ~std::uint64_t{0} >> (kMostMasked - size);
  if ((kinds.letters | kinds.digits | kinds.points | kinds.minuses | kinds.blanks) != whole) return false;
  const auto first = static_cast<std::size_t>(words - begin);
  if (first == size || (kinds.letters >> first & 1) == 0) return false;
  for (std::uint64_t left = kinds.letters >> first << first; left != 0;) {
    const auto at = static_cast<std::size_t>(std::countr_zero(left));
    left &= left - 1;
    const std::size_t next = left != 0 ? static_cast<std::size_t>(std::countr_zero(left)) : size;
    const bool blank = (kinds.blanks >> (next - 1) & 1) != 0;
    const bool minus = next > at + 1 && (kinds.minuses >> (at + 1) & 1) != 0;
    const std::size_t from = at + 1 + (minus ? 1 : 0), end = next - (blank ? 1 : 0);
    const std::size_t place = kPlaces[static_cast<unsigned char>(begin[at])];
    if (place == kNoPlace || line.has(place) || end <= from || (blank && left == 0)) return false;
    const std::uint64_t number = (whole >> (size - end + from)) << from;
    const std::uint64_t point = kinds.points & number;
    const std::size_t length = end - from;
    double value = 0;
    int decimals = 0;
    if (length > 8 || end < 8 || point == 0) {
      if (read_plain_decimal(begin, begin + at + 1, begin + size, value, decimals) != begin + end) return false;
    } else {
      if (((kinds.minuses | kinds.blanks) & number) != 0 || (point & (point - 1)) != 0 || length < 2) return false;
      using namespace number_detail;
      // The digits before the point, and those behind it one byte down.
      std::uint64_t bytes;
      std::memcpy(&bytes, begin + end - 8, 8);
      bytes = (bytes ^ 0x3030303030303030U) >> (8 * (8 - length));
      const auto before = static_cast<std::size_t>(std::countr_zero(point)) - from;
      const std::uint64_t low = (std::uint64_t{1} << (8 * before)) - 1;
      const std::uint64_t joined = (bytes & low) | (bytes >> 8 & ~low);
      decimals = static_cast<int>(length - 1 - before);
      const auto mantissa = static_cast<std::int64_t>(number_of_digits(joined << (8 * (9 - length))));
      // As in read_plain_decimal: both are exact.
      value = static_cast<double>(mantissa) / kPower10[static_cast<std::size_t>(decimals)];
      if (minus) value = -value;
    }
    enter(line, place, begin + at, begin + end, value, decimals);
    if (line.count == 1 && words == begin && left != 0) line.spaced = blank;
  }
  return true;
}
#endif

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
  const char* const words = behind_prefix(begin, begin + text.size(), line);
  if (words == nullptr) return false;
#if defined(__SSE2__)
  const bool read = text.size() >= kLane && text.size() <= kMostMasked ? read_words_at_once(words, line)
                                                                       : read_words(words, line);
#else
  const bool read = read_words(words, line);
#endif
  return read && (line.named & ~(1u << PlainLine::kFeed)) != 0;
}

}  // namespace abbe
