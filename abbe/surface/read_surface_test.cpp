#include "abbe/surface/read_surface.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace abbe {
namespace {

const std::string kGood = R"(format = 1

[units]
length = "mm"

[surface]
name = "saddle"
degree = [2, 2]
outward = "u x v"
knots_u = [0, 0, 0, 1, 1, 1]
points = [
  [[0, 0, 0], [0, 20, 2], [0, 40, 0]],
  [[20, 0, -2], [20, 20, 0], [20, 40, -2]],
  [[40, 0, 0], [40, 20, 2], [40, 40, 0]],
]
weights = [[1, 1, 1], [1, 2, 1], [1, 1, 1]]
)";

std::string code_of(const std::string& text) {
  const Parsed<NurbsSurface> read = read_surface(text, "part.toml");
  return read.diagnostics.empty() ? "" : read.diagnostics.front().code;
}

std::string with(const std::string& from, const std::string& to) {
  std::string text = kGood;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ReadSurface, NetKnotsAndWeightsStandWhereTheyAreWritten) {
  const Parsed<NurbsSurface> read = read_surface(kGood, "part.toml");
  ASSERT_TRUE(read.value);
  const NurbsSurface& s = *read.value;
  EXPECT_TRUE(s.is_valid());
  EXPECT_EQ(s.name, "saddle");
  EXPECT_EQ(s.points[1], Vec3(0, 20, 2)) << "inner lists run along v";
  EXPECT_EQ(s.weights[4], 2);
  EXPECT_GT(evaluate(s, {0.5, 0.5}).normal.z(), 0.9);
  const auto turned = read_surface(with("u x v", "v x u"), "part.toml");
  EXPECT_LT(evaluate(*turned.value, {0.5, 0.5}).normal.z(), -0.9);
  const auto inch = read_surface(with("\"mm\"", "\"in\""), "part.toml");
  EXPECT_DOUBLE_EQ(inch.value->points[1].y(), 508);
}

TEST(ReadSurface, MistakesAreNamed) {
  EXPECT_EQ(code_of("format = 1\n"), "E-MISSING-KEY");
  EXPECT_EQ(code_of("[surface"), "E-TOML");
  EXPECT_EQ(code_of(with("degree", "degrees")), "E-UNKNOWN-KEY");
  EXPECT_EQ(code_of(with("degree = [2, 2]", "degree = [3, 2]")), "E-SURFACE-NET");
  EXPECT_EQ(code_of(with("degree = [2, 2]", "degree = [0, 2]")), "E-VALUE");
  EXPECT_EQ(code_of(with("[0, 40, 0]],", "],")), "E-SURFACE-NET") << "a row of two";
  EXPECT_EQ(code_of(with("[1, 2, 1]", "[1, -2, 1]")), "E-SURFACE-NET");
  EXPECT_EQ(code_of(with("[1, 2, 1], ", "")), "E-SURFACE-NET");
  EXPECT_EQ(code_of(with("0, 0, 0, 1, 1, 1", "0, 0, 1, 0, 1, 1")), "E-SURFACE-KNOTS");
  EXPECT_EQ(code_of(with("0, 0, 0, 1, 1, 1", "0, 0, 0, 1, 1")), "E-SURFACE-KNOTS");
  EXPECT_EQ(code_of(with("[20, 20, 0]", "[20, 2e9, 0]")), "E-SURFACE-NET");
  EXPECT_EQ(code_of(with("[20, 20, 0]", "[20, nan, 0]")), "E-NOT-FINITE");
  EXPECT_EQ(code_of(with("[[20, 0, -2], [20, 20, 0], [20, 40, -2]]",
                         "[[200, 0, -2], [200, 20, 0], [200, 40, -2]]")),
            "E-SURFACE-FOLD");
}

TEST(ReadSurface, AnyBytesGiveASurfaceOrAReason) {
  std::mt19937 random(2016);
  const std::string letters = "0123456789[],.-\"\n e=xunva";
  int read_well = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string text = kGood;
    for (unsigned edits = 1 + random() % 4; edits > 0; --edits) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = letters[random() % letters.size()];
          break;
        case 1:
          text.erase(at, 1 + random() % 9);
          break;
        default:
          text.insert(at, 1, static_cast<char>(random() % 256));
          break;
      }
    }
    const Parsed<NurbsSurface> read = read_surface(text, "part.toml");
    ASSERT_EQ(read.value.has_value(), !has_errors(read.diagnostics)) << text;
    if (!read.value) continue;
    ++read_well;
    ASSERT_TRUE(read.value->is_valid());
    ASSERT_TRUE(evaluate(*read.value, {0.3, 0.6}).p.allFinite());
  }
  EXPECT_GT(read_well, 30);
}

}  // namespace
}  // namespace abbe
