// Programs with rotary axes: what must be the same, and every way in which an output can be wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/test_files.h"
#include "abbe/verify/verify.h"

namespace abbe {
namespace {

using testing::plan_of;
using testing::TestFile;

const char* const kMachine = R"(
format = 1
[machine]
chain = "w C A b Y X Z t"
[axis.A]
direction = [1, 0, 0]
origin = [0, 20, -50]
[axis.C]
direction = [0, 0, 1]
[tool]
length = 100
[control]
mode = "axis"
codes = { "G43.4" = "tcp", G49 = "axis" }
)";

const char* const kProgram = R"(G21 G90 G94 G17 G54
T1 M6
G0 X0 Y0 Z50 A0 C0
G43.4 H1
G0 X10 Y10 Z20
G1 Z5 F500
G1 X20 Y0 A20 C30
G1 A25 C40 F900
G93 G1 X0 Y5 A10 C-20 F4
G94
G0 Z50 A0 C0
G49
M30
)";

class Pair {
 public:
  explicit Pair(const std::string& machine = kMachine) : plan_(plan_of(machine)) {}
  VerifyReport judge(const std::string& original, const std::string& output, double block_time = 0) const {
    const TestFile a(original), b(output);
    VerifyJob job;
    job.original_path = a.path();
    job.output_path = b.path();
    job.block_time = block_time;
    job.original_name = "original.ngc";
    job.output_name = "output.ngc";
    job.setup.work_offsets[0] = WorkOffset{};
    job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 100}, 100.0, 10, ""};
    return verify_program(plan_, job);
  }

 private:
  Plan plan_;
};

std::string codes(const VerifyReport& report) {
  std::string all;
  for (const auto& d : report.diagnostics) all += d.code + " ";
  return all;
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// 14.14 mm at 500 mm/min last 1.70 s, 11.18 deg at 900 deg/min 0.745 s, F4 of G93 15 s: each half a half of
/// that.
TEST(TurningPrograms, PiecesMustNotBeFasterThanTheControlReads) {
  struct Halves {
    const char *whole, *halves;
    double least;  // s
  };
  for (const Halves& h : {Halves{"G1 X20 Y0 A20 C30\n", "G1 X15 Y5 A10 C15\nG1 X20 Y0 A20 C30\n", 0.849},
                          Halves{"G1 A25 C40 F900\n", "G1 A22.5 C35 F900\nG1 A25 C40\n", 0.3727}}) {
    const std::string split = changed(kProgram, h.whole, h.halves);
    EXPECT_EQ(codes(Pair().judge(kProgram, split, 0.97 * h.least)), "") << h.whole;
    EXPECT_THAT(codes(Pair().judge(kProgram, split, 1.05 * h.least)), ::testing::StartsWith("V-FEED"))
        << h.whole;
  }
  const std::string timed =
      changed(kProgram, "G1 X0 Y5 A10 C-20 F4\n", "G1 X10 Y2.5 A17.5 C10 F8\nG1 X0 Y5 A10 C-20 F8\n");
  EXPECT_EQ(codes(Pair().judge(kProgram, timed, 7.3)), "");
  EXPECT_THAT(codes(Pair().judge(kProgram, timed, 7.9)), ::testing::StartsWith("V-FEED"));
  EXPECT_EQ(codes(Pair().judge(kProgram, kProgram, 60)), "") << "no motion is split";
}

TEST(TurningPrograms, TheSameProgramAgrees) {
  const VerifyReport report = Pair().judge(kProgram, kProgram);
  EXPECT_TRUE(report.agrees) << (report.diagnostics.empty() ? "" : to_text(report.diagnostics.front()));
  EXPECT_LT(report.after.max, 1e-8);
  EXPECT_LT(report.direction_after, 1e-7);
}

// A machine without errors: the same motion in pieces, and with its time stated, is the same program.
TEST(TurningPrograms, PiecesAndStatedTimesAgree) {
  const std::string pieces = changed(kProgram, "G1 X20 Y0 A20 C30\n", "G1 X15 Y5 A10 C15\nX20 Y0 A20 C30\n");
  EXPECT_TRUE(Pair().judge(kProgram, pieces).agrees);
  // sqrt(5^2 + 10^2) degrees at 900 degrees a minute
  const std::string timed = changed(kProgram, "G1 A25 C40 F900\n", "G93\nG1 A25 C40 F80.4984\nG94 F900\n");
  const VerifyReport report = Pair().judge(kProgram, timed);
  EXPECT_TRUE(report.agrees) << codes(report);
}

struct Mutation {
  const char* name;
  const char* from;
  const char* to;
  const char* code;
};

class Mutations : public ::testing::TestWithParam<Mutation> {};

TEST_P(Mutations, AreFound) {
  const VerifyReport report = Pair().judge(kProgram, changed(kProgram, GetParam().from, GetParam().to));
  EXPECT_FALSE(report.agrees);
  EXPECT_THAT(codes(report), ::testing::HasSubstr(GetParam().code)) << codes(report);
}

INSTANTIATE_TEST_SUITE_P(
    Turning, Mutations,
    ::testing::Values(
        Mutation{"SwappedSign", "A20 C30", "A-20 C30", "V-"},
        Mutation{"LostRotaryWord", "A20 C30", "A20", "V-"},
        Mutation{"OtherRotaryAxis", "A25 C40", "A40 C25", "V-"},
        Mutation{"HundredthOfADegree", "A20 C30", "A20.01 C30", "V-AXIS"},
        Mutation{"AnotherTurn", "C30", "C390", "V-"}, Mutation{"LostPlace", "X20 Y0 A20", "X20 A20", "V-"},
        Mutation{"ThreeMicrometres", "X20 Y0", "X20.003 Y0", "V-"},
        Mutation{"RapidForFeed", "G1 X20 Y0 A20", "G0 X20 Y0 A20", "V-CLASS"},
        Mutation{"FeedForRapid", "G0 Z50 A0", "G1 Z50 A0", "V-CLASS"},
        Mutation{"ChangedFeed", "F900", "F9000", "V-FEED"}, Mutation{"ChangedTime", "F4\n", "F5\n", "V-FEED"},
        Mutation{"LostTcp", "G43.4 H1", "G43 H1", "V-"},
        Mutation{"RapidEndsTurned", "Z50 A0 C0\nG49", "Z50 A1 C0\nG49", "V-TURN"},
        Mutation{"TimeNotRestored", "G1 A25 C40 F900\n", "G93\nG1 A25 C40 F80.4984\nG94 F800\n", "V-FEED"},
        Mutation{"WrongTimeOfRotaryAxes", "G1 A25 C40 F900\n", "G93\nG1 A25 C40 F60\nG94 F900\n", "V-FEED"},
        Mutation{"LinearWordBesideRotaryFeed", "G1 A25 C40 F900", "G1 A25 C40 X20.0004 F900", "V-FEED"},
        Mutation{"LostSpindle", "T1 M6\n", "T1 M6\nM3\n", "V-"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(TurningPrograms, TheOtherWayRoundIsFound) {
  const std::string machine = std::string(kMachine) + "[control.axis.C]\nturning = \"sign\"\n";
  const std::string program = "G21 G90 G94 G17 G54\nG0 X0 Y0 Z50 A10 C10.\nG1 X5 C20. F100\nC-10.\nM2\n";
  EXPECT_TRUE(Pair(machine).judge(program, program).agrees);
  const VerifyReport report = Pair(machine).judge(program, changed(program, "C-10.", "C10."));
  EXPECT_FALSE(report.agrees);
}

// C stands 0.0005 degrees too far everywhere: a tenth of the turn of one block, and no part of it is missing.
TEST(TurningPrograms, ACorrectionAsLargeAsTheTurnIsNoMissingPart) {
  const std::string machine =
      changed(kMachine, "direction = [0, 0, 1]\n", "direction = [0, 0, 1]\nerrors_seen = \"body\"\n") +
      "[errors]\nECC = 8.72664626\n";
  const std::string start = "G21 G90 G94 G17 G54\n";
  const VerifyReport report =
      Pair(machine).judge(start + "G0 X0 Y0 Z50 A10 C10.\nG1 C20. F100\nC20.005\nC21.\nM2\n",
                          start + "G0 X0 Y0 Z50 A10 C9.9995\nG1 C19.9995 F100\nC20.0045\nC20.9995\nM2\n");
  EXPECT_TRUE(report.agrees) << (report.diagnostics.empty() ? "" : to_text(report.diagnostics.front()));
}

TEST(TurningPrograms, WithoutADeclaredModeTheyAreRefused) {
  const std::string machine = changed(kMachine, "mode = \"axis\"\n", "");
  const VerifyReport report = Pair(machine).judge(kProgram, kProgram);
  EXPECT_FALSE(report.agrees);
  EXPECT_THAT(codes(report), ::testing::HasSubstr("E-ROTARY"));
}

}  // namespace
}  // namespace abbe
