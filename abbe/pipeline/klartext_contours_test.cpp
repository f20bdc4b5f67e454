// RL, RR and R0 of conversational programs: the contour is corrected, the control runs beside it.
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

// X is 0.2 um per mm too long.
constexpr const char* kMachine =
    "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEXX = { poly = [0, 0.2] }\n";
constexpr const char* kHead =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y-20 R0 FMAX M3\n3 L Z-5 R0 FMAX\n";

ProgramJob contour_job() {
  ProgramJob job = plain_program_job();
  job.setup.profile = embedded_profile("heidenhain");
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.tools[1].offset = {};
  job.setup.tools[1].diameter = 6;
  job.datum = DatumRule::ideal;
  job.tolerance = 2 * um;
  return job;
}

ProgramRun run(const std::string& blocks, const ProgramJob& job = contour_job()) {
  return run_program(plan_of(kMachine), kHead + blocks + "90 END PGM A MM\n", job);
}

const std::string kContour =
    "4 L X+100 Y+0 RL F300\n5 L Y+60\n6 CC X+110 Y+60\n7 C X+110 Y+70 DR-\n8 L X+160 RL\n"
    "9 CR X+170 Y+60 R+10 DR-\n10 L Y+0\n11 L X+80 Y-20 R0 FMAX\n12 L Z+50 R0 FMAX M2\n";

// X + e(X) = what is meant: 20 um less at X100, 32 um at X160, whatever the radius is.
TEST(KlartextContours, TheContourIsCorrected) {
  const ProgramRun result = run(kContour);
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  for (const char* block : {"\n4 L X+99.9800 Y+0 RL F300\n", "\n5 L Y+60\n", "\n8 L X+159.9680 RL\n",
                            "\n11 L X+79.9840 Y-20 R0 FMAX\n", "\n12 L Z+50 R0 FMAX M2\n"})
    EXPECT_NE(result.output.find(block), std::string::npos) << block << result.output;
  EXPECT_NEAR(result.outcome.rewrite.cutter_radius, 3, 1e-12);
  // 3 mm beside the contour X is 0.6 um more off, or less
  EXPECT_NEAR(result.outcome.rewrite.cutter_residual, 0.6 * um, 0.01 * um);
}

TEST(KlartextContours, AnotherSideOrRadiusIsFound) {
  const Plan plan = plan_of(kMachine);
  const std::vector<std::pair<std::string, std::string>> spoiled = {
      {"Y+0 RL F300", "Y+0 RR F300"},        {"Y+0 RL F300", "Y+0 F300"}, {"9680 RL", "9680"},
      {"Y-20 R0 FMAX\n12", "Y-20 FMAX\n12"}, {"5 L Y+60", "5 L Y+60 R0"}, {"5 L Y+60", "5 L Y+60.004"},
      {"Y+0\n11", "Y+0 X+169.97\n11"},       {"9680 RL", "9680 RR"}};
  const std::string program = kHead + kContour + "90 END PGM A MM\n";
  run_program(plan, program, contour_job(), [&](const ProgramJob& job, ProgramOutcome& outcome) {
    ASSERT_EQ(outcome.end, ProgramEnd::done) << findings(outcome);
    for (const auto& [from, to] : spoiled)
      EXPECT_NE(judge_spoiled(plan, job, from, to).end, ProgramEnd::done) << to;
  });
}

TEST(KlartextContours, WhatIsNotSureIsRefused) {
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"4 L X+2 RL F300\n", "E-CUTCOM"},                           // shorter than the radius
      {"4 L Z-6 RL F300\n", "E-CUTCOM"},                           // not in the plane
      {"4 CC X+20 Y-20\n5 C X+20 Y+0 DR- RL F300\n", "E-CUTCOM"},  // on an arc
      {"4 L X+50 RL F300\n5 L Y+50 RR\n", "E-CUTCOM"},             // side to side
      {"4 L X+50 RL F300\n5 L Z+9 FMAX M91\n", "E-CUTCOM"},
      {"4 L X+50 RL F300\n5 CYCL DEF 7.1 X+5\n", "E-CUTCOM"},
      {"4 L X+50 RL F300\n5 TOOL CALL 1 Z\n", "E-CUTCOM"},
      {"4 L X+50 RL F300\n5 CYCL CALL\n", "E-CYCLE"},
      {"4 L X+50 RL F300\n5 CALL LBL 1\n6 M30\n7 LBL 1\n8 LBL 0\n", "E-CUTCOM"},
      {"4 L X+50 RL F300\n5 M30\n", "E-CUTCOM"},
      {"4 L X+50 RL F300\n5 APPR LT X+90 Y+9 LEN15\n", "E-GCODE"},
      {"4 L X+50 R+ F300\n", "E-GCODE"},
      {"4 L X+50 RLX F300\n", "E-GCODE"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun result = run(blocks);
    EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(result.outcome).find(code), std::string::npos) << blocks << findings(result.outcome);
  }
  ProgramJob unknown = contour_job();
  unknown.setup.tools[1].diameter = 0;
  EXPECT_NE(findings(run(kContour, unknown).outcome).find("E-CUTCOM"), std::string::npos);
  ProgramJob reversal = contour_job();
  reversal.reversal = true;
  EXPECT_EQ(run(kContour, reversal).outcome.end, ProgramEnd::done) << "no error depends on the direction";
}

// Beside a contour the lines that an arc would become are corners.
TEST(KlartextContours, AnArcThatLeavesItsPlaneIsNotMadeLines) {
  const std::string slope =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEZX = { poly = [0, 0.3] }\n";
  const ProgramRun result =
      run_program(plan_of(slope), kHead + kContour + "90 END PGM A MM\n", contour_job());
  EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << result.output;
  EXPECT_NE(findings(result.outcome).find("E-TOL"), std::string::npos) << findings(result.outcome);
}

}  // namespace
}  // namespace abbe
