// The tool's direction as a vector: what is written for a block, and why it is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe::testing {
namespace {

using ::testing::HasSubstr;

/// A table A with a table C on it. A stands 100 urad farther than it is commanded; about the axis A nothing
/// else moves, so that only A is corrected where the point lies on it.
std::string machine_text(const std::string& control, double microradians = 100) {
  return "format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[axis.A]\ndirection = [1, 0, 0]\nerrors_seen = "
         "\"body\"\n[axis.C]\ndirection = [0, 0, 1]\n[tool]\norigin = [0, 0, 100]\nlength = 100\n" +
         control + "[errors]\nEAA = " + std::to_string(microradians) + "\n";
}
const char* const kDeclared =
    "[control]\nmode = \"axis\"\ncodes = { \"G43.5\" = \"tcp-vectors\", \"G43.4\" = \"tcp\" }\n"
    "vectors = { turns = \"nearest\", between = \"axes\" }\n";

RewriteJob job_for(const char* dialect) {
  RewriteJob job = plain_job();
  job.setup.profile = embedded_profile(dialect);
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, "name=\"T\""};
  job.setup.loaded_tool = 1;
  job.setup.start = {0.0, 0.0, 0.0};
  return job;
}

Rewritten fanuc(const std::string& blocks, const std::string& control = kDeclared, double error = 100) {
  return rewrite(plan_of(machine_text(control, error)).machine(),
                 "G21 G90 G94 G17 G54\nG0 A0. C0.\nG43.5 H1 X0. Y0. Z0.\n" + blocks + "M30\n",
                 job_for("fanuc"));
}

// v = (0, sin a, cos a) = (0, 0.6, 0.8). Corrected: a - 100 urad,
//   sin(a - 1e-4) = 0.6 - 0.8e-4 = 0.59992,  cos(a - 1e-4) = 0.8 + 0.6e-4 = 0.80006
TEST(VectorWords, TheDirectionIsCorrected) {
  const Rewritten result = fanuc("G0 X0. Y0. Z0. I0. J0.6 K0.8\n");
  EXPECT_THAT(result.text, HasSubstr(" I0. J0.599920 K0.800060\n")) << result.findings();
}

// c = 90 degrees: v = (sin a, 0, cos a)
TEST(VectorWords, TheDirectionIsFixedToTheTable) {
  const Rewritten result = fanuc("G0 X0. Y0. Z0. C90.\nI0.6 J0. K0.8\n",
                                 "[control]\nmode = \"tcp\"\ncodes = { \"G43.5\" = \"tcp-vectors\" }\n"
                                 "vectors = { turns = \"nearest\" }\n");
  EXPECT_THAT(result.text, HasSubstr("\nI0.599920 J0. K0.800060")) << result.findings();
}

TEST(VectorWords, ALongVectorKeepsItsLength) {
  const Rewritten result = fanuc("G0 X0. Y0. Z0. I0. J6. K8.\n");
  EXPECT_THAT(result.text, HasSubstr(" I0. J5.9992")) << result.findings();
  EXPECT_THAT(result.text, HasSubstr(" K8.0006"));
}

TEST(VectorWords, WordsWithNamesAreTheSame) {
  RewriteJob job = job_for("siemens");
  const auto program = [](const char* block) {
    return std::string("G17 G90 G94 G710 G54\nD1\nG0 X0 Y0 Z0 A0 C0\nTRAORI\nG0 X0 Y0 Z0\n") + block +
           "M30\n";
  };
  const Machine machine =
      plan_of(machine_text("[control]\nmode = \"axis\"\nvectors = { turns = \"nearest\" }\n")).machine();
  const Rewritten result = rewrite(machine, program("G0 X0 Y0 Z0 A3=0 B3=0.6 C3=0.8\n"), job);
  EXPECT_THAT(result.text, HasSubstr(" A3=0 B3=0.599920 C3=0.800060\n")) << result.findings();
  EXPECT_TRUE(rewrite(machine, program("G0 X1 A3=0 B3=0.6 C3=0.8 A30\n"), job).has("E-VECTOR"));
  EXPECT_TRUE(rewrite(machine, program("TRAFOOF\nG0 X1 A3=0 B3=0.6 C3=0.8\n"), job).has("E-VECTOR"));
  EXPECT_TRUE(rewrite(machine, program("G2 X1 I5 J0 A3=0 B3=0 C3=1\n"), job).has("E-VECTOR"));
}

TEST(VectorWords, WithoutErrorsNoByteChanges) {
  const Rewritten result =
      fanuc("G0 X10. Y5. Z3. I0. J0.6 K0.8\nG1 X20. F500.\nI0. J5. K1. X21.\nI0. J0. K1. Z20.\n",
            kDeclared, 0);
  EXPECT_THAT(result.text, HasSubstr("G0 X10. Y5. Z3. I0. J0.6 K0.8\nG1 X20. F500.\nI0. J5. K1. "
                                     "X21.\nI0. J0. K1. Z20.\n"))
      << result.findings();
}

TEST(VectorWords, WhatIsNotSureIsRefused) {
  const char* const block = "G0 X1. I0. J0.6 K0.8\n";
  EXPECT_TRUE(
      fanuc(block, "[control]\nmode = \"axis\"\ncodes = { \"G43.5\" = \"tcp-vectors\" }\n").has("E-VECTOR"));
  EXPECT_TRUE(fanuc("G0 X1. I0. J0.5\n").has("E-VECTOR")) << "a component is missing";
  EXPECT_TRUE(fanuc("G91 G0 X1. I0. J0.6 K0.8\n").has("E-VECTOR"));
  EXPECT_TRUE(fanuc("G2 X1. Y0. I0.5 J0. F100.\n").has("E-VECTOR")) << "a centre or a direction";
  EXPECT_TRUE(fanuc("G0 X1. I0. J0. K0.\n").has("E-VECTOR"));
  EXPECT_TRUE(fanuc("G43.4 H1\nG0 X1. I0. J0.6 K0.8\n").has("E-WORD")) << "G43.4 takes rotary words";
}

}  // namespace
}  // namespace abbe::testing
