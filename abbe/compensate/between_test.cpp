// ORIWKS ORIMKS ORIAXES ORIVECT: which blocks go the same way whatever the machine data say, and the others.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;

/// A table A with a table C on it, both with an error of 100 urad about X.
Rewritten traori(const std::string& blocks, const std::string& between = "") {
  const std::string machine =
      "format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[axis.A]\ndirection = [1, 0, 0]\nerrors_seen = "
      "\"body\"\n[axis.C]\ndirection = [0, 0, 1]\n[tool]\norigin = [0, 0, 100]\nlength = 100\n[control]\n"
      "mode = \"axis\"\nvectors = { turns = \"nearest\"" +
      between + " }\n[errors]\nEAA = 100\n";
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile("siemens");
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, "name=\"T\""};
  job.setup.loaded_tool = 1;
  job.setup.start = {0.0, 0.0, 0.0};
  return rewrite(plan_of(machine).machine(),
                 "G17 G90 G94 G710 G54 D1\nG0 X0 Y0 Z0 A-30 C0\nTRAORI\n" + blocks + "M30\n", job);
}
const char* const kFar = "G0 X0 Y0 Z0 A-30 C0\nG1 X5 A-40 C60 F500\n";
const char* const kNear = "G0 X0 Y0 Z0 A-30 C0\nG1 X5 A-30.5 C1 F500\n";
const char* const kEvenly = ", between = \"axes\"";

// At A = -30 the tool describes a cone: sagitta of its chord sin 30 cos 30 C^2 / 8, that is 0.001 degrees for
// C = 1 degree and several for 60.
TEST(Between, BothCodesTogetherAreSure) {
  const Rewritten result = traori(std::string("ORIMKS\nORIAXES\n") + kFar);
  EXPECT_TRUE(result.report.diagnostics.empty()) << result.findings();
  EXPECT_THAT(result.text, HasSubstr("ORIMKS\nORIAXES\n"));
  EXPECT_THAT(result.text, HasSubstr("A-40.00"));
}

TEST(Between, OneCodeIsSureWhereTheMachineFileSaysSo) {
  EXPECT_TRUE(traori(std::string("ORIWKS ORIAXES\n") + kFar).has("E-TCP"));
  EXPECT_FALSE(traori(std::string("ORIWKS ORIAXES\n") + kFar, kEvenly).has("E-TCP"));
  EXPECT_TRUE(traori(std::string("ORIMKS\n") + kFar).has("E-TCP"));
  EXPECT_FALSE(traori(std::string("ORIMKS\n") + kFar, kEvenly).has("E-TCP"));
}

TEST(Between, ARefusedBlockLeavesThoseBehindItAlone) {
  const Rewritten result =
      traori(std::string("ORIVECT\n") + kFar + "X5.01 A-40.2 C60.2\nX5.02 A-40.4 C60.4\n");
  EXPECT_EQ(result.report.diagnostics.size(), 1u) << result.findings();
}

TEST(Between, WhatContradictsIsRefused) {
  EXPECT_TRUE(traori(std::string("ORIVECT\n") + kFar, kEvenly).has("E-TCP"));
  EXPECT_TRUE(traori(std::string("ORIMKS ORIVECT\n") + kFar, kEvenly).has("E-TCP"));
  EXPECT_TRUE(traori(std::string("ORIWKS\n") + kFar, kEvenly).has("E-TCP"));
  EXPECT_TRUE(traori(std::string("ORIAXES ORIVECT\n") + kNear).has("E-BLOCK")) << "one group";
}

TEST(Between, ShortTurnsGoOneWayWhateverTheCodesSay) {
  for (const char* const codes : {"ORIWKS\n", "ORIWKS ORIAXES\n", "ORIVECT\n", "ORIMKS\n", "ORIPLANE\n"}) {
    const Rewritten result = traori(std::string(codes) + kNear);
    EXPECT_TRUE(result.report.diagnostics.empty()) << codes << result.findings();
  }
}

// Where the tool stands along the table's axis, C turns far although the tool hardly does.
TEST(Between, NearThePoleThereAreTwoWays) {
  EXPECT_TRUE(traori("ORIVECT\nG0 X0 Y0 Z0 A0 C0\nG1 X5 A-0.001 C20 F500\n").has("E-TCP"));
  EXPECT_TRUE(traori("ORIVECT\nG0 X0 Y0 Z0 A0 C0\nG1 X5 C20 F500\n").has("E-TCP"));
  EXPECT_FALSE(traori("ORIVECT\nG0 X0 Y0 Z0 A-20 C0\nG1 X5 A20 F500\n").has("E-TCP"))
      << "in one plane through it";
}

TEST(Between, RapidsAndStandingAxesAreNotConcerned) {
  const Rewritten result = traori("ORIVECT\nG0 X1 Y1 Z1 A-40 C60\nG1 X5 F500\nG1 X8 A-40 C60\n");
  EXPECT_TRUE(result.report.diagnostics.empty()) << result.findings();
}

TEST(Between, WhatIsLeftToMachineDataIsReported) {
  EXPECT_TRUE(traori(kFar).has("W-ORI"));
  EXPECT_FALSE(traori(kFar).has("E-TCP"));
  EXPECT_FALSE(traori(kFar, kEvenly).has("W-ORI"));
  EXPECT_FALSE(traori(kNear).has("W-ORI"));
}

TEST(Between, ADirectionBesideOrimksIsNotSure) {
  const char* const vector = "G0 X0 Y0 Z0\nG1 X1 A3=0 B3=-0.5 C3=0.866025 F500\n";
  EXPECT_TRUE(traori(std::string("ORIMKS\n") + vector).has("E-VECTOR"));
  EXPECT_FALSE(traori(std::string("ORIWKS\n") + vector).has("E-VECTOR"));
}

}  // namespace
}  // namespace abbe::testing
