// Programs whose words have names, as the verifying reader sees them: whatever changes is found.
#include "abbe/verify/named_words.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

const char* const kProgram =
    "N5 G17 G710 G90 G94 ; start\n"
    "T=\"MILL 10\"\n"
    "M6\n"
    "G54 D1\n"
    "ROUGH:\n"
    "G0 X=10 Y20 S1=1000 M1=3\n"
    "Z=50\n"
    "MSG(\"one (1);\") CTOL=0.01\n"
    "G1 Z10 F500\n"
    "G2 X30 CR=12\n"
    "G4 F2\n"
    "G4 S30\n"
    "TRANS X10 Y=5\n"
    "G1 X40\n"
    "AROT RPL=30\n"
    "G0 X5 Y5\n"
    "G1 X20 Y0 F300\n"
    "ROT\n"
    "SUPA G0 Z0 D0\n"
    "G505\n"
    "M30\n";

VerifyJob siemens_job() {
  VerifyJob job = ideal_job();
  job.setup.profile = embedded_profile("siemens");
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, "name=\"MILL 10\""};
  job.setup.tools[2] = ToolEntry{2, 2, {0, 0, 100}, 100.0, 10, "name=\"MILL 11\""};
  job.setup.further_offsets[5] = WorkOffset{};
  return job;
}

VerifyReport compared(const std::string& output, const std::string& original = kProgram) {
  return verify(plan_of("format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n"), original, output,
                siemens_job());
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = kProgram;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(NamedWords, TheSameProgramAgrees) {
  const VerifyReport report = compared(kProgram);
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_GT(report.events, 15U);
}

// D with Z in G90: the axis goes to its new place at once, whatever mode was in force before.
TEST(NamedWords, AnOffsetTakesTheModeOfItsBlock) {
  const std::string program = changed("G4 F2", "G91\nG90 G1 D0 Z10\nG1 X31\nD1 Z10");
  const VerifyReport report = compared(program, program);
  EXPECT_TRUE(report.agrees) << texts(report);
}

TEST(NamedWords, OtherSpellingsOfANumberAgree) {
  EXPECT_TRUE(compared(changed("X=10", "X10.0")).agrees);
  EXPECT_TRUE(compared(changed("CR=12", "CR = +12.00")).agrees);
}

TEST(NamedWords, WhateverChangesIsFound) {
  const std::vector<std::pair<std::string, std::string>> changes = {{"; start", "; Start"},
                                                                    {"\"MILL 10\"", "\"MILL 11\""},
                                                                    {"D1", "D0"},
                                                                    {"ROUGH:", "FINISH:"},
                                                                    {"S1=1000", "S1=100"},
                                                                    {"M1=3", "M1=4"},
                                                                    {"one (1)", "two (1)"},
                                                                    {"CTOL=0.01", "CTOL=0.1"},
                                                                    {"CR=12", "CR=-12"},
                                                                    {"G2", "G3"},
                                                                    {"G4 F2", "G4 F3"},
                                                                    {"G4 S30", "G4 S31"},
                                                                    {"Y=5", "Y=6"},
                                                                    {"TRANS", "ATRANS"},
                                                                    {"RPL=30", "RPL=31"},
                                                                    {"AROT", "ROT"},
                                                                    {"ROT\nSUPA", "TRANS\nSUPA"},
                                                                    {"SUPA ", ""},
                                                                    {"Z0 D0", "Z1 D0"},
                                                                    {"G505", "G54"},
                                                                    {"F300", "F30"},
                                                                    {"X20 Y0", "X20.01 Y0"},
                                                                    {"MSG(\"one (1);\") ", ""},
                                                                    {"M30\n", ""}};
  for (const auto& [from, to] : changes)
    EXPECT_FALSE(compared(changed(from, to)).agrees) << from << " -> " << to;
}

/// X=IC(5) counts from where the axis stands, X=AC(5) from zero.
TEST(NamedWords, StatedDistancesAndPlacesAreFollowed) {
  const std::string places = changed("G4 F2\n", "G1 X35 Y22\nX50 Y25\nG4 F2\n");
  for (const char* same : {"G1 X=IC(5) Y=AC(22)\nX=AC( 50 ) Y = IC(3)\n", "G1 X35 Y=IC(2)\nX=IC(15)Y25\n"})
    EXPECT_TRUE(compared(changed("G4 F2\n", std::string(same) + "G4 F2\n"), places).agrees) << same;
  for (const char* other : {"G1 X=AC(5) Y=AC(22)\nX50 Y25\n", "G1 X=IC(5) Y=IC(22)\nX50 Y25\n",
                            "G1 X=IC(5.01) Y=AC(22)\nX50 Y25\n"})
    EXPECT_FALSE(compared(changed("G4 F2\n", std::string(other) + "G4 F2\n"), places).agrees) << other;
}

/// I=AC(25) is the place of the centre, whatever stands before.
TEST(NamedWords, CentresMayBePlaces) {
  const auto arc = [](const std::string& words) {
    return changed("G4 F2\n", "G0 X20 Y10\nG2 X30 Y10 " + words + " F300\nG4 F2\n");
  };
  const std::string original = arc("I5 J0");
  EXPECT_TRUE(compared(arc("I=AC(25) J=AC(10)"), original).agrees);
  EXPECT_TRUE(compared(arc("I=AC(25) J0"), original).agrees);
  EXPECT_FALSE(compared(arc("I=AC(5) J=AC(0)"), original).agrees);
  EXPECT_FALSE(compared(arc("I=AC(25) J=AC(10.5)"), original).agrees);
}

TEST(NamedWords, WhatIsNotUnderstoodIsRefused) {
  const std::vector<std::pair<std::string, std::string>> refused = {{"X=R1", "E-EXPR"},
                                                                    {"R1=5", "E-EXPR"},
                                                                    {"I=IC(5)", "E-EXPR"},
                                                                    {"G2 X20 I=AC(5)", "E-ARC"},
                                                                    {"X=IC(R1)", "E-EXPR"},
                                                                    {"AROT R90", "E-EXPR"},
                                                                    {"G91 G1 X=AC(5)", "E-BLOCK"},
                                                                    {"TRANS X=IC(5)", "E-BLOCK"},
                                                                    {"SUPA X=IC(5) D0", "E-BLOCK"},
                                                                    {"IF R1", "E-EXPR"},
                                                                    {"MCALL CYCLE81(1)", "E-CYCLE"},
                                                                    {"G41\nG41 X1", "E-CUTCOM"},
                                                                    {"UNHEARD", "E-GCODE"},
                                                                    {"CYCLE800(1)", "E-PLANE"},
                                                                    {"(c)", "E-CHAR"},
                                                                    {"D2", "E-TOOL"},
                                                                    {"T=\"NONE\"", "E-TOOL"},
                                                                    {"M6\nG0 X1", "E-TOOL"},
                                                                    {"TRAORI", "E-TCP"},
                                                                    {"SUPA X0", "E-G53"},
                                                                    {"G18", "E-TOOL"},
                                                                    {"TRANS X1\nG505", "E-FRAME"},
                                                                    {"TRANS X1 G1", "E-BLOCK"},
                                                                    {"ROT RPL=5\nATRANS X1", "E-ROTATION"},
                                                                    {"G70", "E-GCODE"},
                                                                    {"TRANS X1\nG91 G1 X1", "E-POS"},
                                                                    {"FGROUP(X,Y)", "E-GCODE"}};
  for (const auto& [line, code] : refused) {
    const std::string program = changed("G4 F2", line);
    const VerifyReport report = compared(program, program);
    ASSERT_FALSE(report.agrees) << line;
    ASSERT_FALSE(report.diagnostics.empty()) << line;
    EXPECT_EQ(report.diagnostics.front().code, code) << line << "\n" << texts(report);
  }
}

TEST(NamedWords, AnyBytesAreReadOrRefused) {
  const auto profile = embedded_profile("siemens");
  std::mt19937 random(11);
  Block block;
  Fault fault;
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string line = std::string(kProgram).substr(random() % 200, 5 + random() % 40);
    line[random() % line.size()] = "()[]=\"/:;%_.+-X9\n\x80"[random() % 18];
    if (read_block(line, *profile, block, fault))
      ++read;
    else
      ASSERT_GE(fault.column, 1U) << line;
  }
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace abbe::verifying
