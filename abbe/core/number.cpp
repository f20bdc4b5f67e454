#include "abbe/core/number.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace abbe {
namespace {

using number_detail::kExactPowers;
using number_detail::kMaxMantissaDigits;
using number_detail::kPower10;
using number_detail::kTwo53;

constexpr std::uint64_t kTwo52 = std::uint64_t{1} << 52;
constexpr int kMaxScaledDecimals = 15;  // 2^52 has 16 digits, one of them is in front of the point

constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// Any length, correctly rounded: for numbers with more digits than a double can hold exactly.
Decimal read_long(const char* first, const char* last, Decimal shape, bool negative) {
  double value = 0;
  const auto [end, error] = std::from_chars(first, last, value, std::chars_format::fixed);
  if (error == std::errc::result_out_of_range) {
    // Too large is no number that we can stand for; too small is 0.
    for (const char* p = first; p != last && *p != '.'; ++p) {
      if (*p != '0') return {};
    }
    value = 0;
  }
  if (!std::isfinite(value)) return {};
  shape.value = negative ? -value : value;
  return shape;
}

struct Scaled {
  bool exact = false;  // digits is right; otherwise the number is too large for this path
  std::uint64_t digits = 0;
};

// |value| * 10^decimals rounded to the nearest integer, ties to even, without error:
// p = fl(|v| 10^d) has a spacing u <= 1/2 below 2^52 and |p - |v| 10^d| <= u/2. So if the fraction of p
// is not 1/2 it is at least u away from it, on the same side as the true one. If it is 1/2, the
// residual r = |v| 10^d - p, which is exact in a fused multiply-add, says on which side we are.
Scaled scale(double magnitude, int decimals) {
  if (decimals < 0 || decimals > kExactPowers) return {};
  const double power = kPower10[static_cast<std::size_t>(decimals)];
  const double p = magnitude * power;
  if (!(p < static_cast<double>(kTwo52))) return {};
  auto n = static_cast<std::uint64_t>(static_cast<std::int64_t>(p));
  const double fraction = p - static_cast<double>(n);
  n += static_cast<std::uint64_t>(fraction > 0.5);  // not a branch: it could not be predicted
  if (fraction == 0.5) {
    const double r = std::fma(magnitude, power, -p);
    if (r > 0 || (r == 0 && n % 2 == 1)) ++n;
  }
  return {true, n};
}

// The eight decimal digits of n < 10^8 as bytes 0..9, the first one lowest.
std::uint64_t digit_bytes(std::uint64_t n) {
  const std::uint64_t fours = n / 10000 | (n % 10000) << 32;                   // 2 numbers below 10^4
  const std::uint64_t hundreds = (fours * 10486 >> 20) & 0x0000007F0000007FU;  // fours / 100
  const std::uint64_t twos = hundreds | (fours - 100 * hundreds) << 16;        // 4 numbers below 100
  const std::uint64_t tens = (twos * 103 >> 10) & 0x000F000F000F000FU;         // twos / 10
  return tens | (twos - 10 * tens) << 8;
}

// Decimal digits of n < 10^8, at least 1. Of n alone: the place of the next number does not wait for the
// spelling.
std::size_t count_of_digits(std::uint64_t n) {
  static constexpr std::array<std::uint64_t, 9> kPowers = {0,      10,      100,      1000,     10000,
                                                           100000, 1000000, 10000000, 100000000};
  const auto about = static_cast<std::size_t>(std::bit_width(n | 1) * 1233 >> 12);  // log10 2
  return about + static_cast<std::size_t>(n >= kPowers[about]);
}

// n with `decimals` <= 15 of its digits behind a point, n <= 2^52. Returns the end of the text, 17 bytes at
// most; bytes behind it are written, too.
[[gnu::noinline]] char* write_many(char* to, std::uint64_t n, std::size_t behind) {
  std::array<char, 16> digits;
  for (std::size_t i = digits.size(); i-- > 0; n /= 10) digits[i] = static_cast<char>('0' + n % 10);
  std::size_t skip = 0;
  while (digits[skip] == '0' && skip < 15 - behind) ++skip;
  const std::size_t whole = 16 - skip - behind;
  std::memcpy(to, digits.data() + skip, whole);
  to[whole] = '.';
  std::memcpy(to + whole + 1, digits.data() + skip + whole, behind);
  return to + whole + 1 + behind;
}
inline char* write_scaled(char* to, std::uint64_t n, int decimals) {
  constexpr std::uint64_t kAscii = 0x3030303030303030U;
  const auto behind = static_cast<std::size_t>(decimals);
  if (std::endian::native != std::endian::little || n >= 100'000'000 || behind - 1 >= 7)
    return write_many(to, n, behind);
  // The usual case stays in registers: leading zeros are shifted out, then the halves are stored.
  const std::size_t shown = std::max(count_of_digits(n), behind + 1), whole = shown - behind;
  const std::uint64_t text = (digit_bytes(n) | kAscii) >> (8 * (8 - shown));
  const std::uint64_t tail = text >> (8 * whole);
  std::memcpy(to, &text, 8);
  to[whole] = '.';
  std::memcpy(to + whole + 1, &tail, 8);
  return to + shown + 1;
}

// Beyond 2^52 units of the last digit, or more than 15 of them: what the library writes.
double append_fixed_slow(std::string& out, double value, int decimals) {
  const std::size_t start = out.size();
  out.resize(start + 320 + static_cast<std::size_t>(decimals));
  const char* const first = out.data() + start;
  const auto [end, error] =
      std::to_chars(out.data() + start, out.data() + out.size(), value, std::chars_format::fixed, decimals);
  assert(error == std::errc());
  out.resize(start + static_cast<std::size_t>(end - first));
  if (decimals == 0) out += '.';
  if (out[start] == '-' && out.find_first_not_of("0.", start + 1) == std::string::npos) out.erase(start, 1);
  double seen = 0;
  std::from_chars(out.data() + start, out.data() + out.size(), seen, std::chars_format::fixed);
  return seen;
}

}  // namespace

namespace number_detail {

Decimal read_long_decimal(std::string_view text) {
  Decimal out;
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const char* p = begin;
  bool negative = false;
  if (p != end && (*p == '+' || *p == '-')) {
    out.has_sign = true;
    negative = *p++ == '-';
  }
  const char* const first = p;
  std::uint64_t mantissa = 0;
  int significant = 0;
  const auto take = [&](char c) {
    if (significant > 0 || c != '0') ++significant;
    if (significant <= kMaxMantissaDigits) mantissa = mantissa * 10 + static_cast<std::uint64_t>(c - '0');
  };
  for (; p != end && is_digit(*p); ++p) take(*p);
  std::ptrdiff_t digits = p - first;
  if (p != end && *p == '.') {
    out.has_point = true;
    const char* const after_point = ++p;
    for (; p != end && is_digit(*p); ++p) take(*p);
    out.decimals = static_cast<int>(p - after_point);
    digits += out.decimals;
  }
  if (digits == 0) return {};
  out.length = static_cast<std::size_t>(p - begin);
  if (significant > kMaxMantissaDigits || mantissa >= kTwo53 || out.decimals > kExactPowers) {
    return read_long(first, p, out, negative);
  }
  const double value = static_cast<double>(mantissa) / kPower10[static_cast<std::size_t>(out.decimals)];
  out.value = negative ? -value : value;
  return out;
}

}  // namespace number_detail

std::optional<double> read_number(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  if (!text.empty() && text.front() == '+') {
    text.remove_prefix(1);
    if (!text.empty() && text.front() == '-') return std::nullopt;
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

bool to_fixed(double value, int decimals, FixedNumber& number) {
  const auto [exact, n] = scale(std::abs(value), decimals);
  if (!exact || decimals > kMaxScaledDecimals) return false;
  number.digits = n;
  number.decimals = decimals;
  number.negative = value < 0 && n != 0;
  // n <= 2^52 and 10^decimals are exact: this is the double nearest to what will be written.
  const double seen =
      static_cast<double>(static_cast<std::int64_t>(n)) / kPower10[static_cast<std::size_t>(decimals)];
  number.value = number.negative ? -seen : seen;
  return true;
}

char* write_fixed(char* to, const FixedNumber& number) {
  *to = '-';
  to += number.negative ? 1 : 0;
  return write_scaled(to, number.digits, number.decimals);
}

double append_fixed(std::string& out, double value, int decimals) {
  assert(std::isfinite(value) && std::abs(value) < 1e12 && decimals >= 0);
  if (!std::isfinite(value) || decimals < 0) return 0;
  FixedNumber number;
  if (!to_fixed(value, decimals, number)) return append_fixed_slow(out, value, decimals);
  // Written in place: copied from a buffer, the bytes just stored would have to be waited for.
  const std::size_t begin = out.size();
  out.resize(begin + kFixedRoom);
  out.resize(static_cast<std::size_t>(write_fixed(out.data() + begin, number) - out.data()));
  return number.value;
}

double rounded(double value, int decimals) {
  assert(std::isfinite(value) && decimals >= 0);
  const auto [exact, n] = scale(std::abs(value), decimals);
  if (!exact) {
    std::string text;
    return append_fixed(text, value, decimals);
  }
  const double seen = static_cast<double>(n) / kPower10[static_cast<std::size_t>(decimals)];
  return value < 0 && n != 0 ? -seen : seen;
}

std::string to_shortest(double value) {
  std::array<char, 32> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  assert(error == std::errc());
  return {buffer.data(), static_cast<std::size_t>(end - buffer.data())};
}

}  // namespace abbe
