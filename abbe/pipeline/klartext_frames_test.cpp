// Rotation, mirror image and scaling of conversational programs (cycles 10, 8, 26 and 11), through the whole
// way.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

using ScaleAxes = Profile::Numbers::ScaleAxes;

ProgramJob frame_job(ScaleAxes axes = ScaleAxes::ask) {
  ProgramJob job = plain_program_job();
  Profile profile = *embedded_profile("heidenhain");
  profile.numbers.scale_axes = axes;
  job.setup.profile = std::make_shared<const Profile>(profile);
  return job;
}

// X is 0.2 um per mm too long, Y 0.1 um per mm too short.
constexpr const char* kMachine =
    "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEXX = { poly = [0, 0.2] }\n"
    "EYY = { poly = [0, -0.1] }\n";
constexpr const char* kHead =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 R0 FMAX M3\n3 L Z+50 FMAX\n";

ProgramRun run(const std::string& blocks, ScaleAxes axes = ScaleAxes::ask, const char* machine = kMachine) {
  ProgramJob job = frame_job(axes);
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.tools[1].offset = {};
  job.datum = DatumRule::ideal;
  return run_program(plan_of(machine), kHead + blocks + "90 END PGM A MM\n", job);
}

/// What becomes of `L X+100 Y+50 Z+9 FMAX` behind these blocks: its words, or what was found.
std::string goes(const std::string& blocks, ScaleAxes axes = ScaleAxes::ask) {
  const ProgramRun result = run(blocks + "80 L X+100 Y+50 Z+9 FMAX\n", axes);
  if (result.outcome.end != ProgramEnd::done) return findings(result.outcome);
  const std::size_t at = result.output.find("\n80 ") + 4;
  return result.output.substr(at, result.output.find('\n', at) - at);
}

// 90 degrees: the machine goes to X-50 Y100, 10 um too far to the left and 10 um short.
TEST(KlartextFrames, ARotationTurnsTheCorrection) {
  EXPECT_EQ(goes("4 CYCL DEF 10.0 ROTATION\n5 CYCL DEF 10.1 ROT+90\n"), "L X+100.0100 Y+49.9900 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 10.1 ROT -90\n"), "L X+100.0100 Y+49.9900 Z+9 FMAX");
  // the datum first: X-40
  EXPECT_EQ(goes("4 CYCL DEF 7.1 X+10\n5 CYCL DEF 10.1 ROT+90\n"), "L X+100.0100 Y+49.9920 Z+9 FMAX");
  // the last one holds, and 0 ends it
  EXPECT_EQ(goes("4 CYCL DEF 10.1 ROT+30\n5 CYCL DEF 10.1 ROT+90\n"), "L X+100.0100 Y+49.9900 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 10.1 ROT+90\n5 CYCL DEF 10.1 ROT+0\n"), "L X+99.9800 Y+50.0050 Z+9 FMAX");
}

// X-100 on the machine is 20 um too far to the left, which is too far to the right in the program.
TEST(KlartextFrames, AMirrorImageTurnsTheCorrectionRound) {
  EXPECT_EQ(goes("4 CYCL DEF 8.0 MIRROR IMAGE\n5 CYCL DEF 8.1 X\n"), "L X+99.9800 Y+50.0050 Z+9 FMAX");
  // about X30, whose mirror image of X100 is X-70: 14 um
  EXPECT_EQ(goes("4 CYCL DEF 7.1 X+30\n5 CYCL DEF 8.1 X Y\n"), "L X+99.9860 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 7.1 X+30\n5 CYCL DEF 8.1 Y\n"), "L X+99.9740 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 7.1 X+30\n5 CYCL DEF 8.1 X\n6 CYCL DEF 8.1\n"),
            "L X+99.9740 Y+50.0050 Z+9 FMAX");
}

// Axis by axis about X50: 2 (100 - 50) + 50 = 150 on the machine, 30 um too far, 15 um in the program; Y25.
TEST(KlartextFrames, AScaleDividesTheCorrection) {
  EXPECT_EQ(goes("4 CYCL DEF 26.0 SCALING\n5 CYCL DEF 26.1 X2 Y0.5 CCX+50\n"),
            "L X+99.9850 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 26.1 X4\n5 CYCL DEF 26.1 X1 Y2\n"), "L X+99.9800 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 26.1 X4 CCX+50\n5 CYCL DEF 26.1 X1\n6 CYCL DEF 7.1 X+10\n"),
            "L X+99.9780 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 11.1 SCL2\n", ScaleAxes::plane), "L X+99.9800 Y+50.0050 Z+9 FMAX");
  EXPECT_EQ(goes("4 CYCL DEF 11.1 SCL2\n5 CYCL DEF 11.1 SCL0.5\n", ScaleAxes::space),
            "L X+99.9800 Y+50.0050 Z+9 FMAX");
  // what it scales along Z is asked for; 1 ends nothing
  EXPECT_NE(goes("4 CYCL DEF 11.1 SCL2\n").find("scale_axes"), std::string::npos);
  EXPECT_EQ(goes("4 CYCL DEF 11.0 SCALING\n5 CYCL DEF 11.1 SCL 1\n"), "L X+99.9800 Y+50.0050 Z+9 FMAX");
}

// Z is scaled where the profile says so: 9 mm are 18 mm, and with 0.1 um per mm of Z 1.8 um.
TEST(KlartextFrames, TheProfileSaysWhetherZIsScaled) {
  const char* heights =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEZZ = { poly = [0, 0.2] }\n";
  const std::string blocks = "4 CYCL DEF 11.1 SCL2\n5 L X+1 Y+1 Z+9 FMAX\n";
  EXPECT_NE(run(blocks, ScaleAxes::space, heights).output.find("Z+8.9982 "), std::string::npos);
  EXPECT_NE(run(blocks, ScaleAxes::plane, heights).output.find("Z+8.9982 "), std::string::npos)
      << "the factor cancels where the error is proportional";
  const char* curved =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEZZ = { poly = [0, 0, 0.1] }\n";
  // 0.1 um/mm^2: 8.1 um at 9; d = 1e-4 (18 - d)^2 = 32.28 um at 18, which are 16.14 um in the program
  EXPECT_NE(run(blocks, ScaleAxes::plane, curved).output.find("Z+8.9919 "), std::string::npos);
  EXPECT_NE(run(blocks, ScaleAxes::space, curved).output.find("Z+8.9839 "), std::string::npos);
}

TEST(KlartextFrames, WhatIsNotSureIsRefused) {
  const std::string turn = "4 CYCL DEF 10.1 ROT+30\n", mirror = "4 CYCL DEF 8.1 X\n",
                    scale = "4 CYCL DEF 26.1 X2 Y2 Z2\n", over = "5 L X+5 Y+5 Z+9 FMAX\n";
  const std::string hole = "6 CYCL DEF 200 Q200=1 Q201=-2 Q203=0 Q204=0\n7 L X+9 FMAX M99\n";
  const std::string bore = "6 CYCL DEF 202 Q200=1 Q201=-2 Q203=0 Q204=0\n7 L X+9 FMAX M99\n";
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"4 CYCL DEF 10.1 IROT+30\n", "E-FRAME"},
      {"4 CYCL DEF 10.1\n", "E-FRAME"},
      {"4 CYCL DEF 10.1 ROT+Q1\n", "E-EXPR"},
      {"4 CYCL DEF 10.1 ROT+30 ROT+30\n", "E-FRAME"},
      {"4 CYCL DEF 10.2 ROT+30\n", "E-FRAME"},
      {"4 CYCL DEF 8.1 Z\n", "E-FRAME"},
      {"4 CYCL DEF 8.1 X+5\n", "E-FRAME"},
      {"4 CYCL DEF 8.1 X X\n", "E-BLOCK"},
      {"4 CYCL DEF 26.1\n", "E-FRAME"},
      {"4 CYCL DEF 26.1 X0\n", "E-FRAME"},
      {"4 CYCL DEF 26.1 X-1\n", "E-FRAME"},
      {"4 CYCL DEF 26.1 X2 A2\n", "E-FRAME"},
      {"4 CYCL DEF 11.1 X2\n", "E-FRAME"},
      {"4 CYCL DEF 7.1 ROT+30\n", "E-FRAME"},
      {turn + "5 L X+5 F500\n", "E-POS"},
      {turn + over + "6 CYCL DEF 7.1 X+5\n", "E-ROTATION"},
      {turn + over + "6 CYCL DEF 247 P Q339=+5\n", "E-ROTATION"},
      {turn + over + "6 L Z-1 FMAX M91\n", "E-ROTATION"},
      {turn + over + "6 CYCL DEF 8.1 X\n", "E-FRAME"},
      {turn + over + "6 CYCL DEF 26.1 X2\n", "E-FRAME"},
      {mirror + "5 L X+5 F500\n", "E-POS"},
      {mirror + over + "6 CYCL DEF 8.1 Y\n", "E-FRAME"},
      {mirror + over + "6 CYCL DEF 10.1 ROT+30\n", "E-ROTATION"},
      {mirror + over + "6 CYCL DEF 7.1 X+5\n", "E-ROTATION"},
      {mirror + over + "6 L X+50 RL F500\n", "E-CUTCOM"},
      {mirror + over + bore, "E-CYCLE"},
      {scale + over + hole, "E-CYCLE"},
      {scale + over + "6 CYCL DEF 26.1 X1\n", "E-FRAME"},
      {scale + over + "6 CYCL DEF 11.1 SCL1\n", "E-FRAME"},
      {"4 CYCL DEF 26.1 X2\n" + over + "6 CC X+15 Y+5\n7 C X+25 DR+ F100\n", "E-FRAME"},
      {turn + over + "6 CYCL DEF 10.1 ROT+60\n7 L X+9 F500\n", "E-POS"},
      {over + "6 CC X+15 Y+5\n7 CYCL DEF 10.1 ROT+60\n8 L X+9 Y+9 Z+9 FMAX\n9 C X+25 Y+5 DR+ F100\n",
       "E-ARC"},
      {over + "6 L X+50 RL F500\n7 CYCL DEF 10.1 ROT+60\n", "E-CUTCOM"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun result = run(blocks);
    EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(result.outcome).find(code), std::string::npos) << blocks << findings(result.outcome);
  }
}

/// Some frames, one after the other, and in each of them lines, arcs and holes.
class FrameWriter {
 public:
  explicit FrameWriter(Random& random) : random_(random) {}

  std::string write() {
    std::string text = "BEGIN PGM FRAMES MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 FMAX M3\nL Z+60 FMAX\n";
    if (random_.chance(0.5))
      text += fmt::format("CYCL DEF 7.0 DATUM\nCYCL DEF 7.1 X{:+.3f}\nCYCL DEF 7.2 Z{:+.3f}\n", place(0.3),
                          place(0.1));
    for (int i = 0; i < 4; ++i) text += frame();
    return text + "L Z+90 FMAX M30\nEND PGM FRAMES MM\n";
  }

 private:
  double place(double share = 1) { return std::round(share * random_.between(-100, 100) * 1e3) / 1e3; }

  std::string frame() {
    switch (random_.below(4)) {
      case 0:
        return fmt::format("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT{:+.3f}\n", random_.between(-180, 180)) +
               blocks(true) + "CYCL DEF 10.1 ROT+0\nL X+0 Y+0 FMAX\n";
      case 1:
        return fmt::format("CYCL DEF 8.0 MIRROR\nCYCL DEF 8.1{}\n", random_.chance(0.3)   ? " X Y"
                                                                    : random_.chance(0.5) ? " X"
                                                                                          : " Y") +
               blocks(true) + "CYCL DEF 8.1\nL X+0 Y+0 Z+60 FMAX\n";
      case 2: {
        const double factor = std::round(random_.between(0.5, 1.5) * 1e4) / 1e4;
        return fmt::format("CYCL DEF 26.0 SCALING\nCYCL DEF 26.1 X{0} Y{0} Z{0} CCX{1:+.3f} CCY+3\n", factor,
                           place(0.2)) +
               blocks(false) + "CYCL DEF 26.1 X1 Y1 Z1\nL X+0 Y+0 Z+60 FMAX\n";
      }
      default:
        return blocks(true);
    }
  }
  std::string blocks(bool drills) {
    const double x = place(), y = place(), r = std::round(random_.between(3, 20) * 1e3) / 1e3;
    std::string text = fmt::format("L X{:+.3f} Y{:+.3f} Z+50 FMAX\nL Z{:+.3f} F500\n", x, y, place(0.05));
    text += fmt::format("CC X{:+.3f} Y{:+.3f}\nC X{:+.3f} Y{:+.3f} DR{}\n", x + r, y, x + 2 * r, y,
                        random_.chance(0.5) ? '+' : '-');
    text += fmt::format("CR X{:+.3f} Y{:+.3f} R{:+.3f} DR+\n", x + r, y + r, 1.2 * r);
    text += fmt::format("L X{:+.3f} IY{:+.3f}\nL Z+50 FMAX\n", place(), place(0.2));
    if (!drills) return text;
    return text + fmt::format(
                      "CYCL DEF 201 REAM Q200=2 Q201=-2 Q203={:.3f} Q204=20\nL X{:+.3f} Y{:+.3f} FMAX M99\n"
                      "L Y{:+.3f} FMAX\nCYCL CALL\nL Z+60 FMAX\n",
                      place(0.1), place(), place(), place());
  }

  Random& random_;
};

TEST(KlartextFrames, RandomProgramsAreVerified) {
  const Seeds seeds = random_seeds(20);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.5);
    const std::string program = FrameWriter(random).write();
    const ProgramRun result = run_program(plan_of(machine), program, frame_job());
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
  }
}

TEST(KlartextFrames, WithoutErrorsNoByteChanges) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = FrameWriter(random).write();
    const ProgramRun result = run_program(plan_of(machine), program, frame_job());
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << program;
    EXPECT_EQ(result.output, program) << "seed " << seed;
  }
}

// The verifying reader finds a frame that is another one.
TEST(KlartextFrames, AnotherFrameIsFound) {
  const Plan plan = plan_of(kMachine);
  const std::vector<std::pair<std::string, std::string>> spoiled = {
      {"CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 ROT+30.001"},
      {"CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 ROT-30"},
      {"CYCL DEF 8.1 X Y", "CYCL DEF 8.1 X"},
      {"CYCL DEF 8.1 X", "CYCL DEF 8.1"},
      {"CYCL DEF 26.1 X2 Y2", "CYCL DEF 26.1 X2 Y1"},
      {"CYCL DEF 26.1 X2 Y2 CCX+5", "CYCL DEF 26.1 X2 Y2 CCY+5"}};
  for (const auto& change : spoiled) {
    const std::string program =
        kHead + ("4 " + change.first) + "\n5 L X+10 Y+10 Z+9 FMAX\n6 L X+20 F500\n7 END PGM A MM\n";
    run_program(plan, program, frame_job(), [&](const ProgramJob& job, ProgramOutcome& outcome) {
      ASSERT_EQ(outcome.end, ProgramEnd::done) << findings(outcome);
      EXPECT_NE(judge_spoiled(plan, job, change.first, change.second).end, ProgramEnd::done) << change.second;
    });
  }
}

}  // namespace
}  // namespace abbe
