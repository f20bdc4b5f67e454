#include "abbe/machine/control_setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "abbe/machine/test_machines.h"

namespace abbe {
namespace {

using test::all_of;

TEST(ControlSetup, WorkOffsetsHaveNames) {
  EXPECT_EQ(work_offset_index("G54"), 0);
  EXPECT_EQ(work_offset_index("G59"), 5);
  EXPECT_EQ(work_offset_index("G59.3"), 8);
  for (const char* name : {"G53", "g54", "G59.4", "G54.1", "", "54"})
    EXPECT_FALSE(work_offset_index(name)) << name;
}

TEST(ControlSetup, ReadsAToolTable) {
  const auto parsed = read_tool_table(
      "tool.tbl",
      "; metric\n\nT1 P1 Z100.5 D10 ; mill gauge=112.4\r\n"
      "t2 p12 x+1.5 y-2 z-30 a0 q3 I1 J2 ;drill\nT99999 P3 gauge=55.5\nT4 Z1 ; not_a_gauge=3\n"
      "T5 ; Gauge = 7.25, new");
  ASSERT_TRUE(parsed.value) << all_of(parsed.diagnostics);
  const auto& tools = *parsed.value;
  ASSERT_EQ(tools.size(), 5u);
  EXPECT_EQ(tools.at(1).pocket, 1);
  EXPECT_DOUBLE_EQ(tools.at(1).offset[2], 100.5);
  EXPECT_DOUBLE_EQ(tools.at(1).diameter, 10);
  EXPECT_DOUBLE_EQ(*tools.at(1).gauge, 112.4);
  EXPECT_EQ(tools.at(1).comment, "mill gauge=112.4");
  EXPECT_DOUBLE_EQ(tools.at(2).offset[0], 1.5);
  EXPECT_DOUBLE_EQ(tools.at(2).offset[1], -2);
  EXPECT_DOUBLE_EQ(tools.at(2).offset[2], -30);
  EXPECT_FALSE(tools.at(2).gauge);
  EXPECT_DOUBLE_EQ(*tools.at(99999).gauge, 55.5);
  EXPECT_FALSE(tools.at(4).gauge);
  EXPECT_DOUBLE_EQ(*tools.at(5).gauge, 7.25);
}

TEST(ControlSetup, ToolTableMistakesHaveTheirPlace) {
  struct Case {
    std::string code, text;
    std::size_t line, column;
  };
  for (const Case& c : std::vector<Case>{{"E-TOOL-WORD", "T1 P1 Z1x\n", 1, 7},
                                         {"E-TOOL-WORD", "T1 P1 Znan\n", 1, 7},
                                         {"E-TOOL-WORD", "T1 K3\n", 1, 4},
                                         {"E-TOOL-WORD", "T1 Z1 Z2\n", 1, 7},
                                         {"E-TOOL-NUMBER", "P1 Z1\n", 1, 1},
                                         {"E-TOOL-NUMBER", "T1 Z1\nT1 Z2\n", 2, 1},
                                         {"E-TOOL-NUMBER", "T1.5\n", 1, 1},
                                         {"E-TOOL-NUMBER", "T-1\n", 1, 1},
                                         {"E-TOOL-NUMBER", "T1e10\n", 1, 1},
                                         {"E-TOOL-OFFSET", "T1 W0.5\n", 1, 4},
                                         {"E-TOOL-GAUGE", "T1 ; gauge=long\n", 1, 12},
                                         {"E-TOOL-GAUGE", "T1 gauge=-3\n", 1, 10},
                                         {"E-TOOL-GAUGE", "T1 gauge=3 ; gauge=4\n", 1, 10}}) {
    const auto parsed = read_tool_table("tool.tbl", c.text);
    EXPECT_FALSE(parsed.value) << c.text;
    ASSERT_EQ(parsed.diagnostics.size(), 1u) << c.text << all_of(parsed.diagnostics);
    EXPECT_EQ(parsed.diagnostics[0].code, c.code) << c.text;
    EXPECT_EQ(parsed.diagnostics[0].place.line, c.line) << c.text;
    EXPECT_EQ(parsed.diagnostics[0].place.column, c.column) << c.text;
  }
}

TEST(ControlSetup, ReadsAParameterFile) {
  const auto parsed =
      read_parameter_file("linuxcnc.var",
                          "5161\t0.000000\n5210\t0\n5211\t7.0\n5220\t1.0\n5221\t10.5\n5222\t-20\n5223\t30\n"
                          "5224\t0.0\n5230\t90.0\n5381\t1\n5390\t0\n5391 4\n");
  ASSERT_TRUE(parsed.value) << all_of(parsed.diagnostics);
  EXPECT_TRUE(parsed.diagnostics.empty());
  const auto& offsets = parsed.value->work_offsets;
  ASSERT_TRUE(offsets[0] && offsets[8]);
  EXPECT_FALSE(offsets[1]);
  EXPECT_EQ(offsets[0]->origin, (std::array<double, 3>{10.5, -20, 30}));
  EXPECT_DOUBLE_EQ(offsets[0]->rotation, std::acos(0.0));
  EXPECT_EQ(offsets[8]->origin, (std::array<double, 3>{1, 0, 0}));
}

TEST(ControlSetup, ParameterFileMistakes) {
  struct Case {
    std::string code, text;
    std::size_t line;
  };
  for (const Case& c : std::vector<Case>{{"E-PARAM-LINE", "5221 1 2\n", 1},
                                         {"E-PARAM-LINE", "5221\n", 1},
                                         {"E-PARAM-LINE", "5221 x\n", 1},
                                         {"E-PARAM-LINE", "0 1\n", 1},
                                         {"E-PARAM-LINE", "5222 1\n5221 1\n", 2},
                                         {"E-PARAM-LINE", "5221 1\n5221 1\n", 2},
                                         {"E-PARAM-G92", "5210 1\n5211 0\n5213 4\n", 3},
                                         {"E-PARAM-OFFSET", "5226 4\n", 1}}) {
    const auto parsed = read_parameter_file("linuxcnc.var", c.text);
    EXPECT_FALSE(parsed.value) << c.text;
    ASSERT_EQ(parsed.diagnostics.size(), 1u) << c.text;
    EXPECT_EQ(parsed.diagnostics[0].code, c.code) << c.text;
    EXPECT_EQ(parsed.diagnostics[0].place.line, c.line) << c.text;
  }
  const auto active = read_parameter_file("linuxcnc.var", "5220 2\n");
  EXPECT_TRUE(active.value);
  EXPECT_EQ(active.diagnostics.at(0).code, "W-PARAM-SYSTEM");
}

TEST(ControlSetup, GaugeLengthIsTheLeverArmOfTheToolInTheSpindle) {
  const auto parsed = test::read(test::five_axis("[tool]\nlength = 200\n"));
  ASSERT_TRUE(parsed.value);
  const Machine& machine = *parsed.value;
  ControlSetup setup;
  setup.tools = *read_tool_table("tool.tbl", "T1 Z100 ; gauge=112\nT2 Z90\nT3 Z-40\nT4 Z80 gauge=81\n").value;
  setup.gauges[4] = 82;
  const auto check = [&](std::optional<int> tool, double length, GaugeLength::Source source, bool touch_off) {
    const GaugeLength gauge = gauge_length(setup, machine, tool);
    EXPECT_DOUBLE_EQ(gauge.length, length);
    EXPECT_EQ(gauge.source, source);
    EXPECT_EQ(gauge.touch_off, touch_off);
  };
  check(std::nullopt, 200, GaugeLength::Source::machine_file, false);
  check(7, 200, GaugeLength::Source::machine_file, false);
  check(1, 112, GaugeLength::Source::table_comment, false);
  check(2, 90, GaugeLength::Source::table_offset, false);
  check(3, 200, GaugeLength::Source::table_offset, true);  // a negative offset is no length
  check(4, 82, GaugeLength::Source::option, false);
}

}  // namespace
}  // namespace abbe
