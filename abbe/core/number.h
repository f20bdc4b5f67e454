#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

namespace abbe {

/// A decimal number as programs and tables write it.
struct Decimal {
  double value = 0;
  int decimals = 0;  ///< digits after the point
  bool has_point = false;
  bool has_sign = false;   ///< an explicit + or -
  std::size_t length = 0;  ///< characters read; 0 = no number here
};

/// Reads [+-]digits[.digits] at the start of `text`, never an exponent: `X1E2` is 1 followed by
/// a word E (chars_format::fixed). The value is correctly rounded: bit-equal to from_chars.
/// A number too large for a double is no number (length 0).
/// cost    about 5 ns for up to 18 digits, no allocation
[[nodiscard]] Decimal read_decimal(std::string_view text);

/// The whole of `text` as a finite number in general notation (exponent allowed, blanks around
/// it allowed). nullopt for anything else: empty, trailing bytes, nan, inf, out of range.
[[nodiscard]] std::optional<double> read_number(std::string_view text);

/// Appends value with exactly `decimals` digits after the point (0 keeps the point: "5."),
/// correctly rounded (ties to even of the decimal digit), "-0.000" never occurs.
/// `value` must be finite and |value| < 1e12. Returns the value that a reader will see.
double append_fixed(std::string& out, double value, int decimals);

/// A number on its way into a text: rounded, not yet spelled. It has less than 2^52 units of its last digit
/// and 15 decimals at most; others are a matter of append_fixed.
struct FixedNumber {
  std::uint64_t digits = 0;  ///< without the point
  int decimals = 0;
  bool negative = false;
  double value = 0;  ///< what a reader will see
};
/// Bytes that write_fixed may touch: a sign, 16 digits, the point and what is stored behind them.
inline constexpr std::size_t kFixedRoom = 25;

/// append_fixed in two steps: the rounding (false: it does not fit), and the spelling. Returns the end of the
/// text.
[[nodiscard]] bool to_fixed(double value, int decimals, FixedNumber& number);
[[nodiscard]] char* write_fixed(char* to, const FixedNumber& number);

/// The integer nearest to x, ties to even; |x| < 2^51.
[[nodiscard]] inline double nearest_integer(double x) {
  constexpr double kNoFraction = 6755399441055744.0;  // 1.5 * 2^52
  return (x + kNoFraction) - kNoFraction;
}
/// n units of the last of `decimals` digits (15 at most), n an integer below 2^52.
[[nodiscard]] FixedNumber fixed_number(double n, int decimals);

/// value rounded to `decimals` digits as append_fixed would write it.
[[nodiscard]] double rounded(double value, int decimals);

/// Shortest text that reads back to the same double (17 significant digits at most).
[[nodiscard]] std::string to_shortest(double value);

namespace number_detail {

inline constexpr std::uint64_t kTwo53 = std::uint64_t{1} << 53;
inline constexpr int kMaxMantissaDigits = 18;  // fit an int64
inline constexpr int kExactPowers = 22;        // 10^22 is the largest power of ten that is a double
inline constexpr std::array<double, kExactPowers + 1> kPower10 = {
    1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

/// Any count of digits, and everything that is no number.
[[nodiscard]] Decimal read_long_decimal(std::string_view text);

/// The first 8 bytes of [p, end), the first one lowest, zeros behind the end. Bytes of [begin, end) are read.
[[nodiscard]] inline std::uint64_t eight_bytes(const char* begin, const char* p, const char* end) {
  std::uint64_t bytes = 0;
  const auto left = static_cast<std::size_t>(end - p);
  if (left >= 8) {
    std::memcpy(&bytes, p, 8);
  } else if (left > 0 && end - begin >= 8) {
    std::memcpy(&bytes, end - 8, 8);
    bytes >>= 8 * (8 - left);
  } else {
    for (std::size_t i = 0; i < left; ++i)
      bytes |= static_cast<std::uint64_t>(static_cast<unsigned char>(p[i])) << (8 * i);
  }
  return bytes;
}

/// The number whose eight decimal digits are these bytes 0..9, the first digit lowest: pairs, fours, all
/// eight.
[[nodiscard]] inline std::uint64_t number_of_digits(std::uint64_t digits) {
  constexpr std::uint64_t kPairs = 10 * 256 + 1, kFours = 100 * 65536 + 1, kEights = 10000 * 4294967296 + 1;
  digits = (digits * kPairs >> 8) & 0x00FF00FF00FF00FFU;
  digits = (digits * kFours >> 16) & 0x0000FFFF0000FFFFU;
  return digits * kEights >> 32;
}

/// Appends the digits at p to the mantissa, counts them, and returns their end.
[[nodiscard]] inline const char* more_digits(const char* p, const char* end, std::uint64_t& mantissa,
                                             std::ptrdiff_t& count) {
  const auto digit_of = [](char c) { return static_cast<unsigned char>(c) - static_cast<unsigned>('0'); };
  const char* const first = p;
  for (unsigned digit = 0; p != end && (digit = digit_of(*p)) < 10; ++p) mantissa = mantissa * 10 + digit;
  count += p - first;
  return p;
}

}  // namespace number_detail

inline FixedNumber fixed_number(double n, int decimals) {
  const double value = n / number_detail::kPower10[static_cast<std::size_t>(decimals)];
  return {static_cast<std::uint64_t>(static_cast<std::int64_t>(n < 0 ? -n : n)), decimals, n < 0, value};
}

/// The usual number of a program: [-]digits[.digits], 1 to 15 digits in all, at p in the text [begin, end).
/// Returns its end, or null if it is anything else: then ask read_decimal, which reads the same value where
/// both read one. cost    about 3 ns where it fits 8 bytes, the sign not counted
[[nodiscard]] inline const char* read_plain_decimal(const char* begin, const char* p, const char* end,
                                                    double& value, int& decimals) {
  using namespace number_detail;
  const bool negative = p != end && *p == '-';
  p += negative ? 1 : 0;
  std::uint64_t mantissa = 0;
  std::ptrdiff_t digits = 0, behind = 0;
  const std::uint64_t bytes = eight_bytes(begin, p, end) ^ 0x3030303030303030U;  // digits are 0..9 now
  // The top bit of each byte that is no digit; right up to the first byte beyond ASCII.
  const std::uint64_t others = ((bytes + 0x7676767676767676U) | bytes) & 0x8080808080808080U;
  const std::uint64_t later = others & (others - 1);
  const int first = std::countr_zero(others);  // 7 + 8 i for byte i
  constexpr std::uint64_t kPoint = '.' ^ '0';
  if (std::endian::native == std::endian::little && others != 0 && (bytes >> (first - 7) & 0xFF) == kPoint) {
    // Digits around a point: those behind it move down by one byte, then all of them up to the last byte.
    const int whole = first >> 3, all = later != 0 ? (std::countr_zero(later) >> 3) - 1 : 7;
    const std::uint64_t before = (std::uint64_t{1} << (first - 7)) - 1;
    const std::uint64_t joined = (bytes & before) | (bytes >> 8 & ~before);
    if (all == 0) return nullptr;
    mantissa = number_of_digits(joined << (8 * (8 - all)));
    p += all + 1;
    behind = all - whole;
    if (later == 0) p = more_digits(p, end, mantissa, behind);
    digits = whole + behind;
  } else {
    p = more_digits(p, end, mantissa, digits);
    if (p != end && *p == '.') p = more_digits(p + 1, end, mantissa, behind);
    digits += behind;
  }
  if (static_cast<std::size_t>(digits - 1) >= 15) return nullptr;
  // Both are exact: below 10^15 < 2^53, and a power of ten up to 10^15.
  const double magnitude =
      static_cast<double>(static_cast<std::int64_t>(mantissa)) / kPower10[static_cast<std::size_t>(behind)];
  value = negative ? -magnitude : magnitude;
  decimals = static_cast<int>(behind);
  return p;
}

// Numbers of programs have few digits: the plain loop, inlined, is then the fastest.
inline Decimal read_decimal(std::string_view text) {
  using namespace number_detail;
  Decimal out;
  const char* p = text.data();
  const char* const end = p + text.size();
  bool negative = false;
  if (p != end && (*p == '+' || *p == '-')) {
    out.has_sign = true;
    negative = *p++ == '-';
  }
  const auto digit_of = [](char c) { return static_cast<unsigned char>(c) - static_cast<unsigned>('0'); };
  const char* const first = p;
  std::uint64_t mantissa = 0;
  for (unsigned digit = 0; p != end && (digit = digit_of(*p)) < 10; ++p) mantissa = mantissa * 10 + digit;
  auto digits = p - first;
  if (p != end && *p == '.') {
    out.has_point = true;
    const char* const after_point = ++p;
    for (unsigned digit = 0; p != end && (digit = digit_of(*p)) < 10; ++p) mantissa = mantissa * 10 + digit;
    out.decimals = static_cast<int>(p - after_point);
    digits += out.decimals;
  }
  // 18 digits cannot have overflowed; mantissa and 10^decimals are exact, so their quotient is correctly
  // rounded.
  if (digits == 0 || digits > kMaxMantissaDigits || mantissa >= kTwo53) return read_long_decimal(text);
  out.length = static_cast<std::size_t>(p - text.data());
  const double value = static_cast<double>(mantissa) / kPower10[static_cast<std::size_t>(out.decimals)];
  out.value = negative ? -value : value;
  return out;
}

}  // namespace abbe
