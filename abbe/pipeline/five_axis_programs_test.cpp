// Random programs with rotary axes on random five-axis machines of every structure, through the whole way.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "abbe/core/units.h"
#include "abbe/pipeline/test_five_axis_machine.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// A program that knows where its axes stand.
class Writer {
 public:
  Writer(Random& random, const Structure& structure, bool near_singularity)
      : random_(random), structure_(structure), tilt_low_(near_singularity ? -20 : 12) {}

  std::string write(int blocks, bool inverse_time) {
    text_ = fmt::format("G21 G90 G17 G54 G94\nT1 M6\nG43 H1\nG0 {}{} {}0 X0 Y0\nG0 Z60\nF800 S1000 M3\n",
                        structure_.tilt, tilt_, structure_.turn);
    for (int i = 0; i < blocks; ++i) block(inverse_time);
    return text_ + "G0 Z80\nM5\nM30\n";
  }

 private:
  std::string linear(double reach) {
    std::string words;
    for (int k = 0; k < 3; ++k) {
      if (!random_.chance(0.75)) continue;
      at_[k] = std::round(std::clamp(at_[k] + random_.between(-reach, reach), -150.0, 150.0) * 1e3) / 1e3;
      words += fmt::format(" {}{:.3f}", "XYZ"[k], at_[k]);
    }
    return words;
  }
  std::string turning(double reach) {
    std::string words;
    if (random_.chance(0.7)) {
      tilt_ = std::round(std::clamp(tilt_ + random_.between(-reach, reach), tilt_low_, 70.0) * 1e3) / 1e3;
      words += fmt::format(" {}{:.3f}", structure_.tilt, tilt_);
    }
    if (random_.chance(0.7)) {
      turn_ = std::round((turn_ + random_.between(-reach, reach)) * 1e3) / 1e3;
      words += fmt::format(" {}{:.3f}", structure_.turn, turn_);
    }
    return words;
  }
  void block(bool inverse_time) {
    const std::string g93 = inverse_time ? "G93 " : "",
                      f = inverse_time ? fmt::format(" F{:.2f}", random_.between(1, 6)) : "";
    const std::string after = inverse_time ? "\nG94 F800" : "";
    switch (random_.below(9)) {
      case 0:
        text_ += "G0" + moved(linear(60) + turning(40));
        break;
      case 1:
        text_ += "G1" + moved(linear(100));
        break;
      case 2:
        text_ += fmt::format("N{} G1 M8{} (turned)\n", random_.below(900), moved(turning(30), false));
        break;
      case 3:
        at_.x() = std::round((at_.x() + 6) * 1e3) / 1e3;
        text_ += fmt::format("G2 X{:.3f} I3 J0\n", at_.x());
        break;
      case 8:
        text_ += fmt::format("G98 G81 X{:.3f} Y{:.3f} R{:.3f} Z{:.3f}\nG80\n", at_.x(), at_.y(), at_.z() - 1,
                             at_.z() - 3);
        break;
      default: {
        at_.x() = std::round((at_.x() + (at_.x() > 0 ? -30 : 30)) * 1e3) / 1e3;
        text_ += fmt::format("{}G1 X{:.3f}{}{}{}\n", g93, at_.x(), turning(25), f, after);
        break;
      }
    }
  }
  static std::string moved(const std::string& words, bool end = true) {
    return (words.empty() ? " Z60" : words) + (end ? "\n" : "");
  }

  Random& random_;
  Structure structure_;
  double tilt_low_, tilt_ = 25, turn_ = 0;
  Vec3 at_ = Vec3(0, 0, 60);
  std::string text_;
};

/// Corrected on one machine, and where another is named, verified on that.
ProgramRun run(const std::string& machine, const std::string& program, const std::string& judged_by = {}) {
  ProgramJob plain = plain_program_job(kToolLength);
  plain.setup.tools[2] = ToolEntry{2, 2, {0, 0, kToolLength + 40}, kToolLength + 40, 10, ""};
  return run_program(plan_of(machine), program, plain, [&](const ProgramJob& job, ProgramOutcome& outcome) {
    if (!judged_by.empty()) outcome = verify_programs(plan_of(judged_by), job, job.output);
  });
}

std::string control_of(Random& random) {
  return fmt::format("[control]\nmode = \"{}\"\n", random.chance(0.5) ? "axis" : "tcp");
}

TEST(FiveAxisPrograms, AreVerifiedOnMachinesOfEveryStructure) {
  std::uint64_t done = 0;
  const testing::Seeds seeds = testing::random_seeds(210);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, control_of(random));
    const std::string program = Writer(random, structure, seed % 5 == 0).write(12, seed % 3 == 0);
    const ProgramRun result = run(machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << machine << "\n----\n"
                                                    << program << "\n----\n"
                                                    << result.output;
    // A feed move out of a drilling cycle starts where the shift for the hole left the tool, above it.
    const bool drills = program.find("G81") != std::string::npos;
    EXPECT_LE(result.outcome.verify.after.max, (drills ? 2 : 1) * result.outcome.verify.allowed)
        << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
    EXPECT_GT(result.outcome.rewrite.max_gradient, 0) << "seed " << seed;
    ++done;
  }
  EXPECT_EQ(done, seeds.count);
}

TEST(FiveAxisPrograms, AMachineWithoutErrorsChangesNoByte) {
  for (std::uint64_t seed = 1; seed <= 28; ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, control_of(random), 0);
    const std::string program = Writer(random, structure, seed % 2 == 0).write(20, seed % 3 == 0);
    const ProgramRun result = run(machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << program;
    EXPECT_EQ(result.output, program) << "seed " << seed;
  }
}

// A correction with the wrong sign doubles the error: the verifier must not take it for a good one.
TEST(FiveAxisPrograms, OppositeErrorsAreNotVerified) {
  for (std::uint64_t seed = 1; seed <= 28; ++seed) {
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string control =
        seed % 2 == 0 ? "[control]\nmode = \"tcp\"\n" : "[control]\nmode = \"axis\"\n";
    Random random(seed), same(seed);
    const std::string machine = machine_text(random, structure, control),
                      opposite = machine_text(same, structure, control, -1);
    const std::string program = Writer(random, structure, false).write(12, true);
    EXPECT_EQ(run(machine, program, opposite).outcome.end, ProgramEnd::disagrees) << "seed " << seed;
  }
}

// What a review found: programs that must come out right, or not at all.
const char* const kTable = R"(
format = 1
[machine]
chain = "w C A b Y X Z t"
[axis.Z]
range = [-600, 600]
[axis.A]
direction = [1, 0, 0]
origin = [0, 5, -100]
range = [-110, 110]
errors_seen = "body"
[axis.C]
direction = [0, 0, 1]
errors_seen = "body"
[tool]
origin = [0, 0, 100]
length = 120
[control]
mode = "axis"
codes = { M428 = "tcp", M429 = "axis" }
[errors]
EXX = { poly = [0, 0.05] }
EC0Y = 30
EB0A = 25
EZ0A = -9
EA0C = 22
EX0C = 14
EAC = { sine = [12, 0.0174533, 1.0] }
EBA = { sine = [15, 0.0174533, 0.4] }
)";
const std::string kStart = "G21 G90 G94 G17 G54\nG0 X10 Y20 Z50 A0 C0\n";

struct TurningCase {
  const char* name;
  std::string program;
  ProgramEnd end;
  std::string code;   ///< among the findings
  std::string holds;  ///< part of the output
};

class TurningCases : public ::testing::TestWithParam<TurningCase> {};

TEST_P(TurningCases, ComeOutRightOrNotAtAll) {
  const TurningCase& one = GetParam();
  const ProgramRun result = run(kTable, one.program);
  EXPECT_EQ(result.outcome.end, one.end) << findings(result.outcome) << result.output;
  EXPECT_NE(findings(result.outcome).find(one.code), std::string::npos) << findings(result.outcome);
  EXPECT_NE(result.output.find(one.holds), std::string::npos) << result.output;
}

INSTANTIATE_TEST_SUITE_P(
    FiveAxis, TurningCases,
    ::testing::Values(
        TurningCase{"TcpWhileARotaryAxisIsUnknown",
                    kStart + "A30\nT1 M6\nG0 X10 Y20 Z50\nM428\nG0 A0 C0\nG1 X40 F500\nM2\n",
                    ProgramEnd::refused, "E-POS", ""},
        TurningCase{"TcpOnTurnedAxesNeedsAllLinearOnes", kStart + "A30\nM428\nG1 X40 F500\nM2\n",
                    ProgramEnd::refused, "E-POS", ""},
        TurningCase{"TcpOnTurnedAxesThenAllNamed", kStart + "A30\nM428\nG0 X40 Y20 Z60\nG1 X30 F500\nM2\n",
                    ProgramEnd::done, "", "M428\nG0 X"},
        TurningCase{"RotaryFeedThatReturnsToItsStart", kStart + "G1 C360 F360\nM2\n", ProgramEnd::done, "",
                    "\nG93\n"},
        TurningCase{"StopBehindAStatedTime", kStart + "G1 A20 F300 M9\nM2\n", ProgramEnd::done, "",
                    "\nG94 F300.0"},
        TurningCase{"EndBehindAStatedTime", kStart + "G1 A20 F300 M2\n", ProgramEnd::done, "",
                    "\nG94 F300.0 M2\n"},
        TurningCase{"OwnG94OfATimedBlock", kStart + "G93 G1 X11 F5\nG94 G1 A20 F300\nM2\n",
                    ProgramEnd::refused, "E-ROTFEED", ""},
        TurningCase{"FeedOfManyDigits", kStart + "G1 A20 F7.874015\nM2\n", ProgramEnd::done, "",
                    "\nG94 F7.874015\n"},
        TurningCase{"NamedLinearAxesThatStand",
                    kStart + "G91 G1 X0 Y0 Z0 A10 F300\nG90 X10 Y20 Z50 A20\nM2\n", ProgramEnd::done, "",
                    "G93"},
        TurningCase{"MachineMoveThenTcp",
                    kStart + "G53 G0 Z200\nM428\nG0 X10 Y20 A30 C40\nZ50\nG1 X12 F500\nM2\n",
                    ProgramEnd::done, "", "G53 G0 Z200"},
        TurningCase{
            "AnotherLengthInTcp",
            kStart + "G43 H1\nM428\nG0 A30 X10 Y20 Z50\nG43 H2\nG0 X10 Y20 Z90\nG1 A35 X12 F300\nM2\n",
            ProgramEnd::done, "", "G43 H2"},
        TurningCase{"AnotherLengthInTcpNamesNothing",
                    kStart + "G43 H1\nM428\nG0 A30 X10 Y20 Z50\nG43 H2\nG1 A35 F300\nM2\n",
                    ProgramEnd::refused, "E-POS", ""},
        TurningCase{"ArcAndHoleOnATurnedTable",
                    kStart + "G0 A15 C40\nG2 X14 I2 J0 F200\nG98 G81 X10 Y20 R48 Z45\nG80\nM2\n",
                    ProgramEnd::done, "", "G81"},
        TurningCase{"MachineTurnInTcp", kStart + "M428\nG53 G0 A10\nM2\n", ProgramEnd::refused, "E-TCP", ""},
        TurningCase{"MachineMoveBeyondTheTravel", kStart + "G53 G0 Z700\nM2\n", ProgramEnd::outside,
                    "E-TRAVEL", ""},
        TurningCase{"MachineTurnBeyondTheTravel", kStart + "G53 G0 A115\nM2\n", ProgramEnd::outside,
                    "E-TRAVEL", ""},
        TurningCase{"IncrementsFromAPlaceThatIsCopied",
                    kStart + "A30 C20\nG91 G28 X0\nG0 A5 C5\nG90 G0 X10 Y20 Z50\nM2\n", ProgramEnd::done, "",
                    "G91"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace abbe
