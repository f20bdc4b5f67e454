#include "abbe/cl/emit_gcode.h"

#include <algorithm>

#include "abbe/cl/test_cl_files.h"

namespace abbe::cl {
namespace {

struct Block {
  int code = 0;
  Commands q{};
  double feed = 0;
  bool inverse_time = false;
};

/// The blocks of a program with words X Y Z A C: this test's own reader.
std::vector<Block> blocks_of(const std::string& text, const Machine& machine) {
  std::vector<Block> blocks;
  Block now;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '(') continue;
    std::istringstream words(line);
    bool moves = false;
    for (std::string word; words >> word;) {
      const double value = std::stod(word.substr(1));
      if (word == "G93" || word == "G94")
        now.inverse_time = word == "G93";
      else if (word == "G0" || word == "G1")
        now.code = static_cast<int>(value);
      else if (word[0] == 'F')
        now.feed = value;
      else if (const int axis = machine.find_axis(word.substr(0, 1)); axis >= 0) {
        now.q[static_cast<std::size_t>(axis)] = value * machine.axis_unit(axis);
        moves = true;
      }
    }
    if (moves) blocks.push_back(now);
  }
  return blocks;
}

std::string emit(const Plan& plan, const std::string& text, bool ideal, GcodeReport& report) {
  const TestFile file(text);
  GcodeJob job;
  job.path = file.path();
  job.name = "part.cls";
  job.ideal = ideal;
  job.probed_datum = false;
  job.start[1] = 30 * deg;
  auto spool = SpoolFile::create("-");
  report = emit_gcode(plan, job, std::get<SpoolFile>(spool));
  return report.complete ? slurp(std::get<SpoolFile>(spool).temporary_path()) : std::string();
}

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double s = std::clamp((b - a).dot(p - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - (a + s * (b - a))).norm();
}

const char* const kMotion =
    "UNITS/MM\nMULTAX/ON\nSPINDL/RPM,2000,CLW\nRAPID\nGOTO/10,20,30,0.1,0.5,0.8602325\nFEDRAT/200,MMPM\nGOTO/"
    "110,40,20,0.3,0.5,0.8124038\nFINI\n";

// All axes move evenly within a block: the real tip stays on the line of the CL data.
TEST(EmitGcode, TheTipFollowsTheOriginal) {
  for (const bool ideal : {false, true}) {
    const Plan plan = plan_of(five_axes_with_errors());
    GcodeReport report;
    const auto blocks = blocks_of(emit(plan, kMotion, ideal, report), plan.machine());
    ASSERT_GT(blocks.size(), 3U);
    const Vec3 a(10, 20, 30), b(110, 40, 20);
    double most = 0;
    for (std::size_t i = 1; i < blocks.size(); ++i) {
      for (int k = 0; k <= 10; ++k) {
        Query query;
        query.tool = tool_of(plan.machine());
        for (std::size_t axis = 0; axis < query.q.size(); ++axis)
          query.q[axis] = blocks[i - 1].q[axis] + 0.1 * k * (blocks[i].q[axis] - blocks[i - 1].q[axis]);
        const Vec3 tip = ideal ? nominal_tip(plan, query) : actual_tip(plan, query);
        most = std::max(most, distance_to_segment(tip, a, b));
      }
    }
    EXPECT_LT(most, 0.75 * um) << ideal;  // half of 1 um, and the digits
    EXPECT_GT(ideal ? 1.0 : report.max_correction / um, 0.9);
  }
}

TEST(EmitGcode, TheTipKeepsItsFeed) {
  const Plan plan = plan_of(five_axes_with_errors());
  GcodeReport report;
  double minutes = 0;
  for (const Block& block : blocks_of(emit(plan, kMotion, false, report), plan.machine())) {
    if (block.code != 1) continue;
    EXPECT_TRUE(block.inverse_time);
    minutes += 1 / block.feed;
  }
  EXPECT_NEAR(minutes, Vec3(100, 20, -10).norm() / 200, 1e-6);
}

TEST(EmitGcode, StraightMotionsHaveTheFeedOfTheFile) {
  GcodeReport report;
  const std::string text = emit(plan_of(kThreeAxes),
                                "UNITS/INCHES\nLOADTL/2\nRAPID\nGOTO/0,0,1\nFEDRAT/10,IPM\nGOTO/"
                                "1,0,1\nCOOLNT/MIST\nDELAY/1.5\nSTOP\nFINI\n",
                                true, report);
  EXPECT_EQ(text.substr(text.find("T2")),
            "T2 M6\nG0 X0.0000 Y0.0000 Z25.4000\nG1 X25.4000 F254.0000\nM7\nG4 P1.5\nM0\nM2\n")
      << text;
}

TEST(EmitGcode, DrillingBecomesMotions) {
  GcodeReport report;
  const std::string text = emit(plan_of(kThreeAxes),
                                "UNITS/MM\nFEDRAT/100,MMPM\nRAPID\nGOTO/0,0,50\nCYCLE/"
                                "DRILL,FEDTO,8,RAPTO,2\nGOTO/5,0,0\nCYCLE/OFF\nFINI\n",
                                true, report);
  EXPECT_NE(text.find("G0 X5.0000 Z2.0000\nG1 Z-8.0000 F100.0000\nG0 Z2.0000\n"), std::string::npos) << text;
}

TEST(EmitGcode, ACycleDrillsWithItsOwnFeed) {
  const auto drilled = [](const std::string& unit, const std::string& cycle) {
    GcodeReport report;
    const std::string text = emit(plan_of(kThreeAxes),
                                  "UNITS/" + unit + "\nFEDRAT/1000,MMPM\nRAPID\nGOTO/0,0,2\nCYCLE/" + cycle +
                                      "\nGOTO/1,0,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,2\nGOTO/1,0,2\nFINI\n",
                                  true, report);
    return report.complete ? text : report.diagnostics.front().code;
  };
  const std::string nx = drilled("MM", "DRILL,RAPTO,2,FEDTO,-8,MMPM,80"),
                    catia = drilled("MM", "DRILL,8,MMPM,80,2");
  EXPECT_NE(nx.find("G1 Z-8.0000 F80.0000\nG0 Z2.0000\nG0 X0.0000\nG1 X1.0000 F1000.0000\n"),
            std::string::npos)
      << nx;
  EXPECT_EQ(nx, catia);
  const std::string inches = drilled("INCHES", "DRILL,FEDTO,1,IPM,3");
  EXPECT_NE(inches.find("G1 Z-25.4000 F76.2000\n"), std::string::npos) << inches;
  EXPECT_EQ(drilled("INCHES", "DRILL,FEDTO,1,PERMIN,3"), inches);
  // it retracts higher, or waits: no motion is left out
  EXPECT_EQ(drilled("MM", "DRILL,RAPTO,2,FEDTO,8,RTRCTO,30"), "E-CYCLE");
  EXPECT_EQ(drilled("MM", "DRILL,RAPTO,2,FEDTO,8,DWELL,1"), "E-CYCLE");
}

TEST(EmitGcode, WordsHaveNoExponent) {
  GcodeReport report;
  const std::string text =
      emit(plan_of(kThreeAxes), "UNITS/MM\nSPINDL/RPM,100000,CLW\nDELAY/0.0002\nRAPID\nGOTO/0,0,50\nFINI\n",
           true, report);
  EXPECT_NE(text.find("S100000 M3\nG4 P0.0002\n"), std::string::npos) << text;
}

// F0 of G93 would be no feed at all.
TEST(EmitGcode, ALongTimeKeepsItsDigits) {
  GcodeReport report;
  const std::string text =
      emit(plan_of(kThreeAxes), "UNITS/MM\nRAPID\nGOTO/0,0,50\nFEDRAT/0.0012345,INVERS\nGOTO/1,0,50\nFINI\n",
           true, report);
  EXPECT_NE(text.find("G93 F0.001234500\n"), std::string::npos) << text;
}

TEST(EmitGcode, AFeedPerMinuteCountsInTheUnitsOfTheFile) {
  GcodeReport report;
  const std::string text =
      emit(plan_of(kThreeAxes), "UNITS/INCHES\nRAPID\nGOTO/0,0,1\nFEDRAT/10,PERMIN\nGOTO/1,0,1\nFINI\n", true,
           report);
  EXPECT_NE(text.find("F254.0000"), std::string::npos) << text;
}

// The control moved the axes to change the tool: words left out would leave them there.
TEST(EmitGcode, EveryAxisIsNamedAfterAToolChange) {
  const std::string hole = "RAPID\nGOTO/10,20,50\nGOTO/10,20,-5\nRAPID\nGOTO/10,20,50\n";
  for (const char* change : {"LOADTL/2", "LOAD/TOOL,2", "TURRET/2"}) {
    GcodeReport report;
    const std::string text =
        emit(plan_of(kThreeAxes), "UNITS/MM\nFEDRAT/100,MMPM\n" + hole + change + "\n" + hole + "FINI\n",
             true, report);
    EXPECT_NE(text.find("T2 M6\nG0 X10.0000 Y20.0000 Z50.0000\nG1 Z-5.0000"), std::string::npos) << text;
  }
}

TEST(EmitGcode, EveryAxisIsNamedAfterFrom) {
  GcodeReport report;
  const std::string text =
      emit(plan_of(kThreeAxes),
           "UNITS/MM\nFEDRAT/100,MMPM\nRAPID\nGOTO/5,0,50\nFROM/0,0,50\nGOTO/5,0,50\nFINI\n", true, report);
  EXPECT_NE(text.find("G1 X5.0000 Y0.0000 Z50.0000 F100.0000\n"), std::string::npos) << text;
}

TEST(EmitGcode, WhatHasNoWordIsRefused) {
  const Plan plan = plan_of(kThreeAxes);
  const auto refusal = [&](const std::string& records) {
    GcodeReport report;
    EXPECT_EQ(emit(plan, "UNITS/MM\nRAPID\nGOTO/0,0,50\n" + records + "FINI\n", false, report), "");
    return report.diagnostics.empty() ? std::string() : report.diagnostics.front().code;
  };
  EXPECT_EQ(refusal("CUTCOM/LEFT\n"), "E-CUTCOM");
  EXPECT_EQ(refusal("CYCLE/TAP,5\nGOTO/1,1,1\n"), "E-CYCLE");
  EXPECT_EQ(refusal("SPINDL/ON\n"), "E-RECORD");
  EXPECT_EQ(refusal("AUXFUN/77\n"), "E-RECORD");
  EXPECT_EQ(refusal("PPFUN/1\n"), "E-RECORD");
  EXPECT_EQ(refusal("GOTO/1,1,1\n"), "E-FEED");
  EXPECT_EQ(refusal("FEDRAT/1E-9,MMPM\nGOTO/1,1,1\n"), "E-FEED") << "would be F0.0000";
  EXPECT_EQ(refusal("FEDRAT/1E9,MMPM\nGOTO/1,1,1\n"), "E-FEED");
  EXPECT_EQ(refusal("SPINDL/RPM,1E20,CLW\n"), "E-RECORD");
  EXPECT_EQ(refusal("DELAY/1E9\n"), "E-RECORD");
  EXPECT_EQ(refusal("GOTO/999,1,1\n"), "E-TRAVEL");
}

}  // namespace
}  // namespace abbe::cl
