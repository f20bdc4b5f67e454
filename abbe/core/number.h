#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace abbe {

/// A decimal number as programs and tables write it.
struct Decimal {
  double value = 0;
  int decimals = 0;         ///< digits after the point
  bool has_point = false;
  bool has_sign = false;    ///< an explicit + or -
  std::size_t length = 0;   ///< characters read; 0 = no number here
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

}  // namespace number_detail

/// The usual number of a program: [-]digits[.digits], 1 to 15 digits in all. Returns its end, or null if it is
/// anything else: then ask read_decimal, which reads the same value where both read one.
[[nodiscard]] inline const char* read_plain_decimal(const char* p, const char* end, double& value,
                                                    int& decimals) {
  const auto digit_of = [](char c) { return static_cast<unsigned char>(c) - static_cast<unsigned>('0'); };
  const bool negative = p != end && *p == '-';
  p += negative ? 1 : 0;
  const char* const first = p;
  std::uint64_t mantissa = 0;
  unsigned digit = 0;
  for (; p != end && (digit = digit_of(*p)) < 10; ++p) mantissa = mantissa * 10 + digit;
  std::ptrdiff_t digits = p - first, behind = 0;
  if (p != end && *p == '.') {
    const char* const after_point = ++p;
    for (; p != end && (digit = digit_of(*p)) < 10; ++p) mantissa = mantissa * 10 + digit;
    behind = p - after_point;
    digits += behind;
  }
  if (static_cast<std::size_t>(digits - 1) >= 15) return nullptr;
  // Both are exact: below 10^15 < 2^53, and a power of ten up to 10^15.
  const double magnitude =
      static_cast<double>(static_cast<std::int64_t>(mantissa)) / number_detail::kPower10[static_cast<std::size_t>(behind)];
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
  if (digits == 0 || digits > kMaxMantissaDigits || mantissa >= kTwo53)
    return read_long_decimal(text);
  out.length = static_cast<std::size_t>(p - text.data());
  const double value = static_cast<double>(mantissa) / kPower10[static_cast<std::size_t>(out.decimals)];
  out.value = negative ? -value : value;
  return out;
}

}  // namespace abbe
