#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/core/units.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

using ::testing::HasSubstr;

const std::string kAxes = R"(format = 1
[machine]
chain = "w C b X Y Z B t"
[axis.C]
direction = [0, 0, 1]
errors_seen = "body"
)";
const std::string kErrors = "[errors]\nEXX = 5\nEC0Y = 30\nEAC = 7\n";

Parsed<Machine> read(const std::string& control) {
  return read_machine({"m.toml", kAxes + control + kErrors}, std::nullopt, {});
}

TEST(ControlSection, IsRead) {
  const auto parsed = read(R"([control]
mode = "tcp"
codes = { M428 = "tcp", "G43.4" = "tcp", G49 = "axis" }
corrects = ["EXX", "C0Y"]
tilt_solution = "C-"
[control.axis.C]
origin = [1, 2, 3]
turning = "sign"
resolution = 0.001
)");
  ASSERT_TRUE(parsed.value) << to_text(parsed.diagnostics.front());
  const ControlModel& control = parsed.value->control;
  EXPECT_TRUE(control.declared && control.tcp);
  ASSERT_EQ(control.codes.size(), 3u);
  ASSERT_TRUE(control.tilt);
  EXPECT_EQ(control.tilt->axis, 2);
  EXPECT_EQ(control.tilt->sign, -1);
  const auto c = static_cast<std::size_t>(parsed.value->find_axis("C"));
  EXPECT_EQ(*control.axes[c].origin, Vec3(1, 2, 3));
  EXPECT_EQ(control.axes[c].turning, Turning::sign);
  EXPECT_DOUBLE_EQ(*control.axes[c].resolution, 0.001 * deg);
  EXPECT_FALSE(control.axes[static_cast<std::size_t>(parsed.value->find_axis("X"))].origin);
}

TEST(ControlSection, CodesAreTenTimesTheirNumber) {
  const auto parsed = read("[control]\nmode = \"axis\"\ncodes = { \"G43.4\" = \"tcp\" }\n");
  ASSERT_TRUE(parsed.value);
  EXPECT_EQ(parsed.value->control.codes[0].letter, 'G');
  EXPECT_EQ(parsed.value->control.codes[0].code, 434);
  EXPECT_TRUE(parsed.value->control.codes[0].on);
}

TEST(ControlSection, SaysWhatAToolDirectionBecomes) {
  const auto parsed = read(
      "[control]\nmode = \"axis\"\ncodes = { \"G43.5\" = \"tcp-vectors\", \"G43.4\" = \"tcp\" }\n"
      "vectors = { turns = \"nearest\", between = \"axes\" }\n");
  ASSERT_TRUE(parsed.value);
  for (const TcpCode& code : parsed.value->control.codes)
    EXPECT_EQ(code.vectors, code.code == 435) << code.code;
  EXPECT_TRUE(parsed.value->control.vectors.nearest);
  EXPECT_EQ(parsed.value->control.vectors.between, VectorRule::Between::axes);
  const auto silent = read("[control]\nmode = \"tcp\"\n");
  EXPECT_FALSE(silent.value->control.vectors.nearest);
  EXPECT_EQ(silent.value->control.vectors.between, VectorRule::Between::unstated);
  EXPECT_FALSE(read("[control]\nmode = \"tcp\"\nvectors = { turns = \"farthest\" }\n").value);
  EXPECT_FALSE(read("[control]\nmode = \"tcp\"\nvectors = \"nearest\"\n").value);
  EXPECT_FALSE(read("[control]\nmode = \"tcp\"\nvectors = { turn = \"nearest\" }\n").value);
}

TEST(ControlSection, WhatTheControlCorrectsIsLeftOut) {
  const auto parsed = read("[control]\nmode = \"axis\"\ncorrects = [\"EXX\", \"C0Y\"]\n");
  ASSERT_TRUE(parsed.value);
  const Machine left = as_controlled(*parsed.value);
  ASSERT_EQ(left.errors.size(), 1u);
  EXPECT_EQ(to_string(left.errors[0].name), "EAC");
  EXPECT_EQ(parsed.value->errors.size(), 3u);
}

TEST(ControlSection, TheBelievedMachineHasTheControlsCentresAndNoErrors) {
  const auto parsed = read("[control.axis.C]\norigin = [1, 2, 3]\n");
  ASSERT_TRUE(parsed.value);
  const Machine believed = as_believed(*parsed.value);
  EXPECT_TRUE(believed.errors.empty());
  EXPECT_EQ(believed.axis(believed.find_axis("C")).origin, Vec3(1, 2, 3));
  EXPECT_EQ(parsed.value->axis(parsed.value->find_axis("C")).origin, Vec3::Zero());
  EXPECT_FALSE(parsed.value->control.declared);
}

struct Mistake {
  const char* name;
  const char* text;
  const char* code;
  const char* place;  ///< line:column
};

class ControlMistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(ControlMistakes, AreNamedWithTheirPlace) {
  const auto parsed = read(GetParam().text);
  ASSERT_FALSE(parsed.diagnostics.empty());
  EXPECT_THAT(to_text(parsed.diagnostics.front()), HasSubstr(std::string("m.toml:") + GetParam().place));
  EXPECT_THAT(to_text(parsed.diagnostics.front()), HasSubstr(GetParam().code));
}

INSTANTIATE_TEST_SUITE_P(
    Control, ControlMistakes,
    ::testing::Values(Mistake{"Mode", "[control]\nmode = \"TCP\"\n", "E-VALUE", "8:8"},
                      Mistake{"Code", "[control]\ncodes = { Q1 = \"tcp\" }\n", "E-CONTROL", "8:11"},
                      Mistake{"CodeWithTwoDecimals", "[control]\ncodes = { \"G43.45\" = \"tcp\" }\n",
                              "E-CONTROL", "8:11"},
                      Mistake{"Axis", "[control.axis.A]\nturning = \"sign\"\n", "E-CONTROL", "7:15"},
                      Mistake{"LinearTurns", "[control.axis.X]\nturning = \"sign\"\n", "E-CONTROL", "8:1"},
                      Mistake{"Resolution", "[control.axis.X]\nresolution = 0\n", "E-CONTROL", "8:14"},
                      Mistake{"TiltSolution", "[control]\ntilt_solution = \"C\"\n", "E-VALUE", "8:17"},
                      Mistake{"TiltSolutionOfAnAxisThatIsNotThere", "[control]\ntilt_solution = \"A+\"\n",
                              "E-CONTROL", "8:17"},
                      Mistake{"Key", "[control]\nmodus = \"tcp\"\n", "E-UNKNOWN-KEY", "8:1"},
                      Mistake{"CorrectsNothing", "[control]\ncorrects = [\"EYY\"]\n", "W-CONTROL", "8:13"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace abbe
