// Conversational programs through the whole way: subprograms that are called once, tools that the program
// describes, codes that say where rotary axes and tips are.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

constexpr double kToolLength = 120;

ProgramJob flow_job() {
  ProgramJob job = plain_program_job(kToolLength);
  job.setup.profile = embedded_profile("heidenhain");
  job.datum = DatumRule::ideal;
  job.setup.work_offsets[0] = WorkOffset{};
  return job;
}

ProgramRun run(const std::string& machine, const std::string& program) {
  return run_program(plan_of(machine), program, flow_job());
}

// 0.2 um per mm too far along X.
constexpr const char* kScale =
    "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEXX = { poly = [0, 0.2] }\n";
constexpr const char* kBent =
    "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEYX = { poly = [0, 0, 2e-3] }\n";
constexpr const char* kHead =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 R0 FMAX M3\n3 L Z+50 FMAX\n";

// What is called once is rewritten where it stands, in the state of its call, and counted there.
TEST(KlartextFlow, ASubprogramThatIsCalledOnceIsRewrittenWhereItStands) {
  const std::string program = std::string(kHead) +
                              "4 L X+100 F500\n5 CALL LBL 1\n6 L Z+60 FMAX\n7 M30\n8 LBL 1\n9 L X+200 F800\n"
                              "10 L IY+5\n11 LBL 0\n12 END PGM A MM\n";
  const ProgramRun result = run(kScale, program);
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("8 LBL 1\n9 L X+199.96"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("5 CALL LBL 1\n6 L Z+60 FMAX\n"), std::string::npos) << result.output;
  const ProgramRun split = run(kBent, program);
  ASSERT_EQ(split.outcome.end, ProgramEnd::done) << findings(split.outcome);
  int expected = 0;
  for (std::size_t at = 0; at < split.output.size(); at = split.output.find('\n', at) + 1)
    ASSERT_EQ(std::stoi(split.output.substr(at)), expected++) << split.output;
  EXPECT_GT(expected, 13) << "blocks were added";
  const ProgramRun exact = run("format = 1\n[machine]\nchain = \"w b X Y Z t\"\n", program);
  EXPECT_EQ(exact.output, program);
}

TEST(KlartextFlow, ADrillingCycleInASubprogram) {
  const std::string program =
      std::string(kHead) +
      "4 CALL LBL \"HOLES\"\n5 M30\n6 LBL \"HOLES\"\n7 CYCL DEF 200 DRILL ~\n Q200=2 ~\n"
      " Q201=-5 ~\n Q203=0 ~\n Q204=0\n8 L X+100 FMAX M99\n9 LBL 0\n10 END PGM A MM\n";
  const std::string machine =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEZX = { poly = [0, 0.2] }\n";
  const ProgramRun result = run(machine, program);
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(
      result.output.find("8 CYCL DEF 200 DRILL ~\n Q200=2 ~\n Q201=-5 ~\n Q203=-0.0200 ~\n Q204=0\n9 L X"),
      std::string::npos)
      << result.output;
}

TEST(KlartextFlow, WhatIsNotSureIsRefused) {
  const std::string sub = "20 LBL 1\n21 L X+5 F500\n22 LBL 0\n";
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"4 CALL LBL 1\n5 CALL LBL 1\n6 M30\n" + sub, "E-OWORD"},
      {"4 CALL LBL 1 REP 2\n6 M30\n" + sub, "E-OWORD"},
      {"4 CALL LBL 2\n6 M30\n" + sub, "E-OWORD"},
      {"4 CALL LBL 0\n6 M30\n" + sub, "E-OWORD"},
      {"4 CALL LBL 1\n" + sub, "E-OWORD"},
      {sub + "30 CALL LBL 1\n31 M30\n", "E-OWORD"},
      {"4 CALL LBL 1\n6 M30\n20 LBL 1\n21 L X+5 F500\n", "E-OWORD"},
      {"4 CALL LBL 1\n6 M30\n20 LBL 1\n21 M30\n22 LBL 0\n", "E-OWORD"},
      {"4 CALL PGM B.H\n", "E-OWORD"},
      {"4 TOOL DEF 1 L+119 R+5\n", "E-TOOL"},
      {"4 TOOL DEF 9 L+119 R+5\n", "E-TOOL"},
      {"4 TOOL DEF 1 L+120 R+5 X\n", "E-TOOL"},
      {"4 TOOL DEF 1 L+120 R+7\n", "E-TOOL"},
      {"4 M140 MB MAX\n5 L X+5 F500\n", "E-POS"},
      {"4 M140\n", "E-MCODE"},
      {"4 L X+5 FMAX M140 MB MAX\n", "E-MCODE"},
      {"4 PLANE SPATIAL SPA+0 SPB+30 SPC+0\n", "E-PLANE"},
      {"4 FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\n", "E-TCP"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun result = run(kScale, kHead + blocks + "90 END PGM A MM\n");
    EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(result.outcome).find(code), std::string::npos) << blocks << findings(result.outcome);
  }
}

TEST(KlartextFlow, WhatSaysNothingNewIsCopied) {
  const std::string program =
      std::string(kHead) +
      "4 TOOL DEF 1 L+120.000 R+5\n5 PLANE RESET STAY\n6 M126\n7 M140 MB MAX\n"
      "8 L Z+20 FMAX\n9 L M124 T0.0005\n10 M140 MB+5\n11 L Z+30 FMAX\n12 END PGM A MM\n";
  const ProgramRun result = run("format = 1\n[machine]\nchain = \"w b X Y Z t\"\n", program);
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_EQ(result.output, program);
}

/// The machine with these rotary axes in `chain`.
std::string five_axes(const std::string& chain, const std::string& errors) {
  std::string text = "format = 1\n[machine]\nchain = \"" + chain + "\"\n[control]\nmode = \"axis\"\n" +
                     "codes = { M128 = \"tcp\", M129 = \"axis\" }\n";
  for (const char axis : {'A', 'B', 'C'}) {
    if (chain.find(axis) == std::string::npos) continue;
    text += fmt::format("[axis.{}]\ndirection = [{}, {}, {}]\n", axis, axis == 'A' ? 1 : 0,
                        axis == 'B' ? 1 : 0, axis == 'C' ? 1 : 0);
  }
  return text + "[errors]\n" + errors;
}

std::string tip_program(const std::string& turn, const std::string& to) {
  return "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 Z+300 " + turn +
         " R0 FMAX\n3 M128\n4 L X+0 Y+0 Z+200 FMAX\n5 L " + to +
         " FMAX\n6 L Z+250 FMAX\n7 M129\n8 END PGM A MM\n";
}

/// The number behind a letter of the block that begins with `start`.
double word_in(const std::string& output, const std::string& start, char letter) {
  const std::size_t line = output.find(start), at = output.find(letter, line + start.size());
  EXPECT_LT(at, output.find('\n', line + 1)) << output;
  return std::stod(output.substr(at + 1));
}

// The head turns by B = 30 deg about +Y: the tool axis is (sin B, 0, cos B), and the axes stand at tip + L
// axis. So X stands at 100 + 120 sin 30 = 160 mm, where it is 32 um too far; turned the other way it would
// stand at 40 mm, 8 um too far.
TEST(KlartextFlow, OfAHeadTheAxesStandAlongTheTool) {
  const std::string machine = five_axes("w b X Y Z C B t", "EXX = { poly = [0, 0.2] }\n");
  for (const auto& [turn, error] :
       std::vector<std::pair<const char*, double>>{{"B+30", 0.032}, {"B-30", 0.008}}) {
    const ProgramRun result = run(machine, tip_program(turn, "X+100"));
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
    EXPECT_NEAR(word_in(result.output, "\n5 L", 'X'), 100 - error, 2e-4) << turn << result.output;
  }
}

// The table turns by A = 30 deg about +X and carries the point y = 100 to y = 100 cos 30, z = 100 sin 30. Y
// is 0.2 um per mm too far there; the correction -17.3 um along the machine's Y is cos 30 of it along the
// part's Y, and + sin 30 of it along its Z: with the other sign of A the Z word would go down.
TEST(KlartextFlow, OfATableTheCorrectionTurnsWithThePart) {
  const std::string machine = five_axes("w C A b X Y Z t", "EYY = { poly = [0, 0.2] }\n");
  const double turned = 0.2e-3 * 100 * 0.8660254;
  for (const auto& [turn, sign] : std::vector<std::pair<const char*, double>>{{"A+30", 1}, {"A-30", -1}}) {
    const ProgramRun result = run(machine, tip_program(turn, "Y+100 Z+100"));
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
    const double y = word_in(result.output, "\n5 L", 'Y'), z = word_in(result.output, "\n5 L", 'Z');
    // the height of 100 mm over the table adds its part to the machine's Y: - sin A 100
    const double e = turned - sign * 0.2e-3 * 100 * 0.5;
    EXPECT_NEAR(y, 100 - e * 0.8660254, 2e-4) << turn << result.output;
    EXPECT_NEAR(z, 100 + sign * e * 0.5, 2e-4) << turn << result.output;
  }
}

// FUNCTION TCPM in the form that means M128.
TEST(KlartextFlow, TipControlHasTwoNames) {
  const std::string machine = five_axes("w b X Y Z C B t", "EXX = { poly = [0, 0.2] }\n");
  std::string program = tip_program("B+30", "X+100");
  const std::string with_codes = run(machine, program).output;
  program.replace(program.find("M128"), 4, "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS");
  program.replace(program.find("M129"), 4, "FUNCTION RESET TCPM");
  const ProgramRun named = run(machine, program);
  ASSERT_EQ(named.outcome.end, ProgramEnd::done) << findings(named.outcome);
  EXPECT_EQ(word_in(named.output, "\n5 L", 'X'), word_in(with_codes, "\n5 L", 'X'));
}

}  // namespace
}  // namespace abbe
