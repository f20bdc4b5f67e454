#include "abbe/core/number.h"

#include <fmt/core.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <random>
#include <string>

namespace abbe {
namespace {

constexpr int kDraws = 300'000;

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

double library_reads(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = std::numeric_limits<double>::quiet_NaN();
  std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  return value;
}

// What append_fixed promises, made with the library: its digits, the point kept, no negative zero.
std::string library_writes(double value, int decimals) {
  std::array<char, 512> buffer;
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals)
          .ptr;
  std::string text(buffer.data(), end);
  if (decimals == 0) text += '.';
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

void expect_as_library(double value, int decimals) {
  std::string text = "X";
  const double seen = append_fixed(text, value, decimals);
  ASSERT_EQ(text, "X" + library_writes(value, decimals)) << fmt::format("{:.17g} {}", value, decimals);
  const Decimal back = read_decimal(std::string_view(text).substr(1));
  ASSERT_TRUE(same_bits(seen, back.value)) << text;
  ASSERT_EQ(back.decimals, decimals);
  ASSERT_EQ(back.length, text.size() - 1);
  ASSERT_TRUE(same_bits(seen, rounded(value, decimals))) << text;
  FixedNumber number;
  if (!to_fixed(value, decimals, number)) return;
  std::array<char, kFixedRoom> spelled;
  ASSERT_EQ("X" + std::string(spelled.data(), write_fixed(spelled.data(), number)), text);
  ASSERT_TRUE(same_bits(number.value, seen)) << text;
}

std::string draw_decimal(std::mt19937_64& rng, int max_whole, int max_decimals) {
  std::string text;
  const auto sign = rng() % 4;
  if (sign == 0) text += '-';
  if (sign == 1) text += '+';
  const auto whole = static_cast<int>(rng() % static_cast<unsigned>(max_whole + 1));
  for (int i = 0; i < whole; ++i) text += static_cast<char>('0' + rng() % 10);
  if (rng() % 5 != 0 || whole == 0) {
    text += '.';
    auto decimals = static_cast<int>(rng() % static_cast<unsigned>(max_decimals + 1));
    if (whole == 0 && decimals == 0) decimals = 1;
    for (int i = 0; i < decimals; ++i) text += static_cast<char>('0' + rng() % 10);
  }
  return text;
}

TEST(ReadDecimal, IsBitEqualToFromChars) {
  std::mt19937_64 rng{1};
  for (int k = 0; k < kDraws; ++k) {
    const std::string text = k % 3 == 0 ? draw_decimal(rng, 25, 30) : draw_decimal(rng, 6, 6);
    // Followed by other text, and alone at the end of its memory.
    for (const std::string& tail : {std::string(), std::string("Y12.5 Z3"), std::string(" ")}) {
      const Decimal read = read_decimal(text + tail);
      ASSERT_TRUE(same_bits(read.value, library_reads(text))) << text;
      ASSERT_EQ(read.length, text.size()) << text + tail;
      ASSERT_EQ(read.has_sign, text[0] == '-' || text[0] == '+');
      const std::size_t point = text.find('.');
      ASSERT_EQ(read.has_point, point != std::string::npos) << text;
      ASSERT_EQ(read.decimals, point == std::string::npos ? 0 : static_cast<int>(text.size() - point - 1))
          << text;
    }
  }
}

TEST(ReadDecimal, PlainNumbersReadTheSame) {
  std::mt19937_64 rng{3};
  int plain = 0;
  for (int k = 0; k < kDraws; ++k) {
    const std::string text = (k % 3 == 0 ? draw_decimal(rng, 12, 12) : draw_decimal(rng, 5, 5)) + "Z1";
    double value = 0;
    int decimals = 0;
    const char* const end =
        read_plain_decimal(text.data(), text.data(), text.data() + text.size(), value, decimals);
    if (end == nullptr) continue;
    ++plain;
    const Decimal read = read_decimal(text);
    ASSERT_TRUE(same_bits(read.value, value)) << text;
    ASSERT_EQ(read.decimals, decimals) << text;
    ASSERT_EQ(read.length, static_cast<std::size_t>(end - text.data())) << text;
  }
  EXPECT_GT(plain, kDraws / 4);
  for (const std::string text : {"", "-", ".", "-.", "+1", "X1", "1234567890123456", "--1"}) {
    double value = 7;
    int decimals = 0;
    EXPECT_EQ(read_plain_decimal(text.data(), text.data(), text.data() + text.size(), value, decimals),
              nullptr)
        << text;
  }
}

// Near the start and the end of a line the eight bytes looked at are others.
TEST(ReadDecimal, PlainNumbersReadTheSameWhereverTheyStand) {
  std::mt19937_64 rng{7};
  for (int k = 0; k < 10 * kDraws; ++k) {
    const std::string number = draw_decimal(rng, 5, 6),
                      behind = std::string(" .-Z7\x80\n9").substr(rng() % 8);
    const std::string before(rng() % 10, '5');
    const std::string text = before + number + behind.substr(0, rng() % 4);
    const char* const at = text.data() + before.size();
    const char* const end = text.data() + text.size();
    double value = 0;
    int decimals = 0;
    const char* const found = read_plain_decimal(text.data(), at, end, value, decimals);
    const Decimal read = read_decimal(std::string_view(text).substr(before.size()));
    if (number.starts_with('+')) {
      ASSERT_EQ(found, nullptr) << text;
      continue;
    }
    ASSERT_EQ(read.length == 0, found == nullptr) << text;
    if (found == nullptr) continue;
    ASSERT_EQ(at + read.length, found) << text;
    ASSERT_TRUE(same_bits(read.value, value)) << text;
    ASSERT_EQ(read.decimals, decimals) << text;
  }
}

TEST(ReadDecimal, ReadsEveryLengthExactly) {
  for (int whole = 0; whole <= 40; ++whole) {
    for (int decimals = 0; decimals <= 40; ++decimals) {
      if (whole + decimals == 0) continue;
      for (const char digit : {'0', '1', '9'}) {
        const std::string text = std::string(static_cast<std::size_t>(whole), digit) + "." +
                                 std::string(static_cast<std::size_t>(decimals), digit);
        const Decimal read = read_decimal(text + "X");
        ASSERT_TRUE(same_bits(read.value, library_reads(text))) << text;
        ASSERT_EQ(read.length, text.size());
        ASSERT_EQ(read.decimals, decimals);
      }
    }
  }
}

TEST(ReadDecimal, NeverReadsAnExponent) {
  const Decimal read = read_decimal("1E2");
  EXPECT_EQ(read.value, 1.0);
  EXPECT_EQ(read.length, 1U);
  EXPECT_EQ(read_decimal("1.5e-7         ").length, 3U);
}

TEST(ReadDecimal, FindsNoNumber) {
  for (const char* text : {"",
                           "+",
                           "-",
                           ".",
                           "-.",
                           "+.X",
                           "X1",
                           " 1",
                           "--1",
                           "+-1",
                           "nan",
                           "inf",
                           "NAN     ",
                           "INFINITY",
                           ".        ",
                           "-.       ",
                           "        ",
                           "/1234567",
                           ":1234567",
                           "\xfa"
                           "1234567"}) {
    const Decimal read = read_decimal(text);
    EXPECT_EQ(read.length, 0U) << text;
    EXPECT_EQ(read.value, 0.0) << text;
  }
}

TEST(ReadDecimal, StopsAtAnyOtherByte) {
  for (int byte = 0; byte < 256; ++byte) {
    if (byte == '.' || (byte >= '0' && byte <= '9')) continue;
    for (std::size_t before = 1; before < 8; ++before) {
      const std::string digits(before, '7');
      const std::string text = digits + static_cast<char>(byte) + "77777777";
      EXPECT_EQ(read_decimal(text).length, before) << byte;
      EXPECT_EQ(read_decimal(text).value, std::stod(digits)) << byte;
      EXPECT_EQ(read_decimal("1." + text).length, before + 2) << byte;
    }
  }
}

TEST(ReadDecimal, KeepsTheSignOfZero) {
  EXPECT_TRUE(std::signbit(read_decimal("-0.000").value));
  EXPECT_TRUE(std::signbit(read_decimal("-0").value));
  EXPECT_FALSE(std::signbit(read_decimal("+0.").value));
}

TEST(ReadDecimal, RefusesWhatADoubleCannotHoldAndRoundsTheTiniestToZero) {
  EXPECT_EQ(read_decimal(std::string(400, '9')).length, 0U);
  EXPECT_EQ(read_decimal("00" + std::string(400, '9') + ".5").length, 0U);
  const std::string tiny = "-0." + std::string(400, '0') + "1";
  EXPECT_EQ(read_decimal(tiny).value, 0.0);
  EXPECT_EQ(read_decimal(tiny).length, tiny.size());
  EXPECT_EQ(read_decimal(std::string(400, '0') + "7").value, 7.0);
}

TEST(ReadNumber, ReadsGeneralNotationAndNothingElse) {
  EXPECT_EQ(read_number("1"), 1.0);
  EXPECT_EQ(read_number(" \t+1.5e-3 \r\n"), 1.5e-3);
  EXPECT_EQ(read_number("-2."), -2.0);
  EXPECT_EQ(read_number(".5"), 0.5);
  EXPECT_EQ(read_number("1e300"), 1e300);
  for (const char* text :
       {"",     " ",   "+",    "-",        "+-1",   "-+1",    "++1",  "1 2", "1,5", "1x",   "nan",
        "-nan", "inf", "+inf", "infinity", "1e400", "-1e400", "0x10", "1e",  ".",   "1_000"}) {
    EXPECT_FALSE(read_number(text).has_value()) << text;
  }
}

TEST(AppendFixed, IsByteIdenticalToToCharsForRandomNumbers) {
  std::mt19937_64 rng{2};
  std::uniform_real_distribution<double> exponent(-9, 9);
  std::uniform_real_distribution<double> mantissa(-10, 10);
  for (int k = 0; k < kDraws; ++k) {
    ASSERT_NO_FATAL_FAILURE(
        expect_as_library(mantissa(rng) * std::pow(10.0, exponent(rng)), static_cast<int>(rng() % 10)));
  }
}

TEST(AppendFixed, IsByteIdenticalToToCharsNextToTies) {
  std::mt19937_64 rng{3};
  for (int k = 0; k < kDraws; ++k) {
    const auto decimals = static_cast<int>(rng() % 8);
    const auto n = static_cast<double>(rng() % 10'000'000) + 0.5;
    double value = n / std::pow(10.0, decimals);
    for (auto steps = rng() % 3; steps > 0; --steps)
      value = std::nextafter(value, rng() % 2 == 0 ? 1e300 : -1e300);
    ASSERT_NO_FATAL_FAILURE(expect_as_library(rng() % 2 == 0 ? value : -value, decimals));
  }
}

TEST(AppendFixed, IsByteIdenticalToToCharsForDyadicNumbers) {
  std::mt19937_64 rng{4};
  for (int k = 0; k < kDraws; ++k) {
    const auto shift = static_cast<int>(rng() % 30);
    const double value = std::ldexp(static_cast<double>(rng() % (1U << 30U)), -shift);
    ASSERT_NO_FATAL_FAILURE(expect_as_library(rng() % 2 == 0 ? value : -value, static_cast<int>(rng() % 12)));
  }
}

TEST(AppendFixed, IsByteIdenticalToToCharsForLargeNumbersAndManyDigits) {
  std::mt19937_64 rng{5};
  std::uniform_real_distribution<double> wide(-1e12, 1e12);
  for (int k = 0; k < kDraws / 10; ++k) {
    ASSERT_NO_FATAL_FAILURE(expect_as_library(wide(rng), static_cast<int>(rng() % 30)));
  }
  for (const double value : {4503.599627370496, 4503.5996273704955, 0.1, 1e-300, 5e-324, 999999999999.9999}) {
    for (int decimals = 0; decimals < 30; ++decimals)
      ASSERT_NO_FATAL_FAILURE(expect_as_library(value, decimals));
  }
}

TEST(AppendFixed, KeepsThePointAndHasNoNegativeZero) {
  const auto text = [](double value, int decimals) {
    std::string out;
    append_fixed(out, value, decimals);
    return out;
  };
  EXPECT_EQ(text(5, 0), "5.");
  EXPECT_EQ(text(-0.0004, 3), "0.000");
  EXPECT_EQ(text(-0.4, 0), "0.");
  EXPECT_EQ(text(-0.0, 2), "0.00");
  EXPECT_EQ(text(-0.0005000001, 3), "-0.001");
  EXPECT_EQ(text(-1e-300, 25), "0.0000000000000000000000000");
  EXPECT_EQ(text(0.125, 2), "0.12");
  EXPECT_EQ(text(0.375, 2), "0.38");
  EXPECT_EQ(text(2.5, 0), "2.");
  EXPECT_EQ(text(3.5, 0), "4.");
  EXPECT_EQ(text(999.9996, 3), "1000.000");
  std::string out;
  EXPECT_FALSE(std::signbit(append_fixed(out, -0.0001, 3)));
}

TEST(ToShortest, ReadsBackToTheSameDouble) {
  std::mt19937_64 rng{6};
  for (int k = 0; k < kDraws; ++k) {
    const auto value = std::bit_cast<double>(rng());
    if (!std::isfinite(value)) continue;
    const auto back = read_number(to_shortest(value));
    ASSERT_TRUE(back.has_value() && same_bits(*back, value)) << to_shortest(value);
  }
  EXPECT_EQ(to_shortest(0.1), "0.1");
}

}  // namespace
}  // namespace abbe
