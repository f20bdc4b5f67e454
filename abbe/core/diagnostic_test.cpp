#include "abbe/core/diagnostic.h"

#include <gtest/gtest.h>

#include <random>

namespace abbe {
namespace {

Diagnostic frame_error() {
  Diagnostic d;
  d.code = "E-FRAME";
  d.place = {"part.nc", 1187, 7, 5, "N2050 G68.2 X0. Y0.\r\n"};
  d.message = "tilted plane";
  d.why = "the correction depends on where A and C really stand";
  d.fix = "post with explicit A and C";
  return d;
}

TEST(ToText, HasTheCompilerForm) {
  EXPECT_EQ(to_text(frame_error()),
            "part.nc:1187:7: error[E-FRAME]: tilted plane\n"
            " 1187 | N2050 G68.2 X0. Y0.\n"
            "      |       ^~~~~\n"
            "      = why: the correction depends on where A and C really stand\n"
            "      = fix: post with explicit A and C\n");
}

TEST(ToText, LeavesOutWhatIsNotKnown) {
  Diagnostic d;
  d.severity = Severity::warning;
  d.message = "m";
  EXPECT_EQ(to_text(d), "warning: m\n");
  d.place.file = "a.toml";
  EXPECT_EQ(to_text(d), "a.toml: warning: m\n");
  d.place.line = 3;
  d.severity = Severity::note;
  d.code = "N";
  EXPECT_EQ(to_text(d), "a.toml:3: note[N]: m\n");
}

TEST(ToText, CountsCharactersNotBytesAndHidesControlBytes) {
  Diagnostic d = frame_error();
  d.why = d.fix = "";
  d.place = {"f", 2, 7, 1,
             "\t\xc2\xb5\xce\xb1 X\x1b[31m\xff"};  // tab, micro sign, alpha, blank, X, escape, ..
  EXPECT_EQ(to_text(d),
            "f:2:7: error[E-FRAME]: tilted plane\n"
            " 2 |  \xc2\xb5\xce\xb1 X?[31m?\n"
            "   |     ^\n");
}

TEST(ToText, ShowsAPartOfALongLine) {
  Diagnostic d;
  d.message = "m";
  d.place = {"f", 1, 5001, 3, std::string(5000, 'a') + "BCD" + std::string(5000, 'e')};
  const std::string text = to_text(d);
  EXPECT_LT(text.size(), 500U);
  const std::size_t excerpt = text.find("| "), caret = text.find("| ", text.find('\n', excerpt));
  EXPECT_EQ(text.find("BCD") - excerpt, text.find("^~~") - caret);
}

TEST(ToText, IsTotal) {
  std::mt19937_64 rng{1};
  for (int k = 0; k < 20000; ++k) {
    Diagnostic d;
    for (auto n = rng() % 300; n > 0; --n) d.place.source_line += static_cast<char>(rng());
    d.place.file = d.message = d.place.source_line.substr(0, 9);
    d.place.line = rng() % 3;
    d.place.column = rng() % 5 == 0 ? ~std::size_t{0} : rng() % 320;
    d.place.length = rng() % 5 == 0 ? ~std::size_t{0} : rng() % 320;
    const std::string text = to_text(d);
    for (const char c : text) ASSERT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
    ASSERT_EQ(text.back(), '\n');
  }
}

TEST(HasErrors, LooksForErrorsOnly) {
  Diagnostic warning = frame_error();
  warning.severity = Severity::warning;
  EXPECT_FALSE(has_errors({}));
  EXPECT_FALSE(has_errors({warning}));
  EXPECT_TRUE(has_errors({warning, frame_error()}));
}

TEST(Closest, FindsLikelyMisspellings) {
  const std::vector<std::string> keys = {"direction", "range", "origin", "location", "order",
                                         "EXX",       "EYX",   "X",      "Z1"};
  EXPECT_EQ(closest("diretcion", keys), "direction");  // a swap is one edit
  EXPECT_EQ(closest("orgin", keys), "origin");
  EXPECT_EQ(closest("rnage", keys), "range");
  EXPECT_EQ(closest("EXx", keys), "EXX");
  EXPECT_EQ(closest("LOCATION", {"location", "vocation"}), std::nullopt);  // 8 halves are 4 edits
  EXPECT_EQ(closest("Origin", keys), "origin");
  EXPECT_EQ(closest("z1", keys), "Z1");
  EXPECT_EQ(closest("x", keys), "X");
  EXPECT_EQ(closest("Q", keys), std::nullopt);
  EXPECT_EQ(closest("speed", keys), std::nullopt);
  EXPECT_EQ(closest("EAX", {"EXX", "EAY"}), "EXX");  // the first of equals
  EXPECT_EQ(closest("EAXY", {"EX"}), std::nullopt);
  EXPECT_EQ(closest("", keys), std::nullopt);
  EXPECT_EQ(closest("word", {}), std::nullopt);
}

}  // namespace
}  // namespace abbe
