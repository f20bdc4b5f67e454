// Drilling cycles of conversational programs through the whole way: what is written, what is left alone, what
// is refused.
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

ProgramJob hole_job() {
  ProgramJob job = plain_program_job();
  job.setup.profile = embedded_profile("heidenhain");
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.tools[1].offset = {};
  job.datum = DatumRule::ideal;
  return job;
}

std::string machine_with(const std::string& errors) {
  return "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\n" + errors;
}

ProgramRun run(const std::string& errors, const std::string& program) {
  return run_program(plan_of(machine_with(errors)), program, hole_job());
}

constexpr const char* kHead =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 R0 FMAX M3\n3 L Z+50 FMAX\n";
constexpr const char* kDrill =
    "4 CYCL DEF 200 DRILLING ~\n  Q200=+2 ;SET-UP CLEARANCE ~\n  Q201=-10 ;DEPTH ~\n"
    "  Q206=+150 ;FEED ~\n  Q202=+5 ;PECK ~\n  Q210=+0 ;DWELL ~\n  Q203=+0 ;SURFACE ~\n"
    "  Q204=+20 ;2ND CLEARANCE ~\n  Q211=+0 ;DWELL\n";
// 0.2 um per mm too far along X; Z too high by as much along X, so that each hole has its own height.
constexpr const char* kScale = "EXX = { poly = [0, 0.2] }\n";
constexpr const char* kSlope = "EZX = { poly = [0, 0.2] }\n";

// What the words of the original say, moved by minus the error: X by 0.2 um per mm.
TEST(KlartextHoles, TheBlockThatGoesThereIsMoved) {
  const ProgramRun result = run(
      kScale, std::string(kHead) + kDrill + "5 L X+100 Y+10 FMAX M99\n6 L X+50 FMAX M99\n7 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("5 L X+99.98"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("6 L X+49.99"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("Q203=+0 ;SURFACE"), std::string::npos) << "Z has no error";
  EXPECT_EQ(result.output.find("CYCL DEF"), result.output.rfind("CYCL DEF"));
}

// The first hole sets Q203 in the definition itself; one that needs another height gets its own definition.
TEST(KlartextHoles, EachHeightHasItsDefinition) {
  const ProgramRun result =
      run(kSlope, std::string(kHead) + kDrill +
                      "5 L X+100 Y+10 FMAX M99\n6 L X+101 FMAX M99\n7 L X+50 FMAX M99\n8 L Z+80 FMAX\n"
                      "9 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("  Q203=-0.0200 ;SURFACE ~\n"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find(
                "6 L X+101 Z+19.9798 FMAX M99\n7 CYCL DEF 200 DRILLING ~\n Q200=+2 ~\n Q201=-10 ~\n"),
            std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find(
                "\n Q203=-0.0100 ~\n Q204=+20 ~\n Q211=+0\n8 L X+50 Z+19.9900 FMAX M99\n9 L Z+79.9900 FMAX"),
            std::string::npos)
      << result.output;
}

// A definition inside a subprogram is not the one that is held: 201 keeps its Q203, 200 gets its own.
TEST(KlartextHoles, DefinitionsInsideSubprogramsAreApart) {
  const std::string ream =
      "4 CYCL DEF 201 REAM Q200=2 Q201=-9 Q206=100 Q211=0 Q208=500 Q203=+1.2345 Q204=20\n";
  const ProgramRun result =
      run(kSlope, std::string(kHead) + ream +
                      "5 CYCL DEF 200 DRILL Q200=2 Q201=-10 Q206=150 Q202=5 Q210=0 Q203=+0 Q204=20 Q211=0\n"
                      "6 CALL LBL 1\n7 L Z+100 FMAX\n8 M30\n9 LBL 1\n10 L X+100 Y+10 FMAX M99\n"
                      "11 CYCL DEF 201 REAM Q200=2 Q201=-10 Q206=150 Q211=0 Q208=500 Q203=+0 Q204=20\n"
                      "12 L X+50 FMAX M99\n13 LBL 0\n14 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << result.output;
  EXPECT_NE(result.output.find(ream), std::string::npos) << result.output;
}

TEST(KlartextHoles, WithoutErrorsNoByteChanges) {
  const std::string program = std::string(kHead) + kDrill +
                              "5 L X+100 Y+10 FMAX M99\n6 L X+50 FMAX\n7 CYCL CALL M8\n8 L X+20 FMAX M89\n"
                              "9 L X+30 FMAX\n10 L X+40 FMAX M99\n11 L M8\n12 L Z+70 FMAX\n13 END PGM A MM\n";
  const ProgramRun result = run("EXX = 0\n", program);
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_EQ(result.output, program);
}

constexpr const char* kPeck =
    "4 CYCL DEF 1.0 PECKING\n5 CYCL DEF 1.1 SET UP 2\n6 CYCL DEF 1.2 DEPTH -10\n7 CYCL DEF 1.3 PECKG 5\n"
    "8 CYCL DEF 1.4 DWELL 0\n9 CYCL DEF 1.5 F100\n";

// The older cycles begin where the tool stands: its height is corrected with X and Y. At the middle of the
// hole, Z-5, X is 0.5 um short.
TEST(KlartextHoles, OlderCyclesAreMovedByTheToolsHeight) {
  const ProgramRun result = run(std::string(kSlope) + "EXZ = { poly = [0, 0.1] }\n",
                                std::string(kHead) + kPeck +
                                    "10 L X+100 Y+10 FMAX\n11 L Z+2 FMAX M99\n12 L X+50 FMAX M99\n"
                                    "13 L X+20 FMAX\n14 CYCL CALL\n15 L Z+50 FMAX\n16 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("\n11 L Z+1.9800 X+100.0005 FMAX M99\n12 L X+50.0005 Z+1.9900 FMAX M99\n"),
            std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("\n13 L X+19.9998 Z+1.9960 FMAX\n14 L X+20.0005 FMAX\n15 CYCL CALL\n"),
            std::string::npos)
      << result.output;
}

TEST(KlartextHoles, OlderCyclesThatWereSpoiledAreFound) {
  const Plan plan = plan_of(machine_with(kSlope));
  const std::string program = std::string(kHead) + kPeck +
                              "10 L X+100 Y+10 FMAX\n11 L Z+2 FMAX M99\n12 L X+50 FMAX M89\n13 L X+20 FMAX\n"
                              "14 L X+10 FMAX M99\n15 END PGM A MM\n";
  run_program(plan, program, hole_job(), [&](const ProgramJob& job, ProgramOutcome& outcome) {
    ASSERT_EQ(outcome.end, ProgramEnd::done) << findings(outcome);
    for (const auto& [from, to] :
         std::vector<std::pair<std::string, std::string>>{{"Z+1.9800", "Z+1.9780"},
                                                          {"DEPTH -10", "DEPTH -10.001"},
                                                          {"SET UP 2", "SET UP 3"},
                                                          {"PECKG 5", "PECKG 2"},
                                                          {"DWELL 0", "DWELL 1"},
                                                          {" Z+1.9900", ""},
                                                          {"F100", "F200"},
                                                          {"M89", "M99"},
                                                          {"X+50", "X+50.002"}}) {
      EXPECT_NE(judge_spoiled(plan, job, from, to).end, ProgramEnd::done) << to;
    }
  });
}

// Forms in which programs have their Q words.
TEST(KlartextHoles, DefinitionsInOneLineAndWithoutTildes) {
  const std::string call = "5 L X+100 Y+10 FMAX M99\n6 END PGM A MM\n";
  for (const std::string definition :
       {"4 CYCL DEF 201 REAMING Q200=2 Q201=-10 Q206=100 Q211=0 Q208=FMAX Q203=0 Q204=50\n",
        "4 CYCL DEF 207 TAPPING\n Q200=2 ;A ~\n Q201=-10 ~\n Q239=+1 ~\n Q203=+0 ~\n Q204=3\n",
        "4 CYCL DEF 208\nQ200=2\nQ201=-5\nQ206=100\nQ334=1\nQ203=0,0\nQ204=3\nQ335=4\nQ342=0\n"}) {
    const ProgramRun result = run(kSlope, kHead + definition + call);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << definition;
    EXPECT_NE(result.output.find("Q203=-0"), std::string::npos) << result.output;
  }
}

// CYCL CALL drills where the block before it ended; with a tilt in height that place is not the hole's.
TEST(KlartextHoles, ACallThatGoesNowhereGetsAStep) {
  const std::string tilt = "EXZ = { poly = [0, 0.1] }\n";
  const ProgramRun result =
      run(tilt, std::string(kHead) + kDrill + "5 L X+100 Y+10 FMAX\n6 CYCL CALL\n7 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("\n6 L X+100.0004 FMAX\n7 CYCL CALL\n8 END"), std::string::npos)
      << result.output;
}

// The mean of both directions is compensated unless --reversal asks for the one in which the drill goes.
TEST(KlartextHoles, LostMotionAlongTheHoleIsLeftAlone) {
  const std::string lost = "EZZ = { forward = { poly = [6] }, backward = { poly = [-6] } }\n";
  const std::string call = "5 L X+100 Y+10 FMAX M99\n6 END PGM A MM\n";
  const ProgramRun mean = run(lost, std::string(kHead) + kDrill + call);
  ASSERT_EQ(mean.outcome.end, ProgramEnd::done) << findings(mean.outcome);
  EXPECT_NE(mean.output.find("Q203=+0 ;"), std::string::npos) << mean.output;
  ProgramJob job = hole_job();
  job.reversal = true;
  const ProgramRun down = run_program(plan_of(machine_with(lost)), std::string(kHead) + kDrill + call, job);
  ASSERT_EQ(down.outcome.end, ProgramEnd::done) << findings(down.outcome);
  EXPECT_NE(down.output.find("Q203=+0.0060 ;"), std::string::npos) << down.output;
}

// The direction in which a fine correction changes inside a hole cannot be followed.
TEST(KlartextHoles, TooDeepAHoleIsRefused) {
  const std::string tilt = "EXZ = { poly = [0, 0.5] }\n";
  const ProgramRun result = run(tilt, std::string(kHead) + kDrill + "5 L X+9 Y+1 FMAX M99\n6 END PGM A MM\n");
  EXPECT_EQ(result.outcome.end, ProgramEnd::refused);
  EXPECT_NE(findings(result.outcome).find("E-CYCLE"), std::string::npos) << findings(result.outcome);
}

// A bore that is milled is as wide as its diameter.
TEST(KlartextHoles, AWideBoreIsJudgedOverItsWidth) {
  const std::string wide = "4 CYCL DEF 208 Q200=2 Q201=-5 Q206=100 Q334=1 Q203=0 Q204=3 Q335={} Q342=0\n";
  for (const auto& [diameter, end] :
       std::vector<std::pair<int, ProgramEnd>>{{5, ProgramEnd::done}, {15, ProgramEnd::refused}}) {
    const ProgramRun result = run(kScale, kHead + fmt::format(fmt::runtime(wide), diameter) +
                                              "5 L X+100 Y+10 FMAX M99\n6 END PGM A MM\n");
    EXPECT_EQ(result.outcome.end, end) << diameter << findings(result.outcome);
  }
}

TEST(KlartextHoles, WhatIsNotSureIsRefused) {
  const std::string shallow = "4 CYCL DEF 200 Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=3 Q211=0\n";
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"4 CYCL CALL\n", "E-CYCLE"},
      {"4 L X+5 FMAX M99\n", "E-CYCLE"},
      {shallow + "5 L X+5 FMAX M99 M9\n", "E-AUX"},
      {shallow + "5 L Z-1 FMAX M91 M99\n", "E-CYCLE"},
      {shallow + "5 TOOL CALL 1 Z\n6 L X+5 FMAX M99\n", "E-POS"},
      {shallow + "5 L X+5 FMAX M89\n6 L Z+5 FMAX\n", "E-CYCLE"},
      {shallow + "5 L X+5 FMAX M89\n6 L Y+5 F500\n", "E-CYCLE"},
      {shallow + "5 L X+5 FMAX M89\n6 CYCL CALL\n", "E-CYCLE"},
      {shallow + "5 L X+5 FMAX M89\n6 CYCL DEF 201\n", "E-CYCLE"},
      {shallow + "5 CC X+5 Y+0\n6 C X+10 Y+0 DR+ F200 M99\n", "E-CYCLE"},
      {"4 CYCL DEF 200 Q200=2 Q201=-5 Q203=0\n5 L X+5 FMAX M99\n", "E-CYCLE"},
      {"4 CYCL DEF 200 Q200=2 Q201=5 Q203=0 Q204=0\n5 L X+5 FMAX M99\n", "E-CYCLE"},
      {"4 CYCL DEF 200 Q200=2 Q201=Q5 Q203=0 Q204=0\n", "E-EXPR"},
      {"4 CYCL DEF 200 Q200=2 Q335=5\n", "E-CYCLE"},
      {shallow + "5 Q203=7\n6 L X+5 FMAX M99\n", "E-EXPR"},
      {shallow + "5 CYCL CALL PAT\n", "E-GCODE"},
      {"4 CYCL DEF 251 Q215=0\n", "E-CYCLE"},
      {"4 CYCL DEF 1 PECKING\n", "E-GCODE"},
      {"4 CYCL DEF 200.0 DRILLING\n", "E-GCODE"},
      {"4 CYCL DEF 1.1 SET UP 2\n", "E-CYCLE"},
      {"4 CYCL DEF 1.0 PECKING\n5 CYCL DEF 1.7 X 2\n", "E-CYCLE"},
      {"4 CYCL DEF 1.0 PECKING\n5 CYCL DEF 1.1 SET UP Q2\n", "E-EXPR"},
      {"4 CYCL DEF 1.0 P\n5 CYCL DEF 1.2 DEPTH -5\n6 L X+5 FMAX M99\n", "E-CYCLE"},
      {kPeck + std::string("10 CYCL DEF 1.2 DEPTH -5\n"), "E-CYCLE"},
      {kPeck + std::string("10 CYCL DEF 2.1 SET UP 5\n"), "E-CYCLE"},
      {kPeck + std::string("10 L X+5 F100 M99\n11 L Z-1 FMAX M91 M99\n"), "E-CYCLE"},
      {"4 CYCL DEF 247\n", "E-WCS"},
      {"4 L X+5 F500 FMAX\n", "E-FEED"},
      {"4 L X+5 FMAX F500\n", "E-FEED"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun result = run(kScale, kHead + blocks + "90 END PGM A MM\n");
    EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(result.outcome).find(code), std::string::npos) << blocks << findings(result.outcome);
  }
}

}  // namespace
}  // namespace abbe
