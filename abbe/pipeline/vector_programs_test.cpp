// Random programs whose blocks state the tool's direction as a vector, on random five-axis machines of every
// structure, through the whole way.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "abbe/chain/control_kinematics.h"
#include "abbe/pipeline/test_five_axis_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

const char* const kControl =
    "[control]\nmode = \"axis\"\ncodes = { \"G43.5\" = \"tcp-vectors\" }\n"
    "vectors = { turns = \"nearest\", between = \"axes\" }\n";

/// A program in directions that the nominal machine has at random tilts.
class Writer {
 public:
  Writer(Random& random, const Structure& structure, const std::string& machine, double least_tilt)
      : random_(random), structure_(structure), plan_(plan_of(machine)), least_tilt_(least_tilt) {}

  std::string write(int blocks, bool inverse_time) {
    std::string text = fmt::format(
        "G21 G90 G17 G54 G94\nT1 M6\nG0 X0 Y0 Z200 {}{} {}0\nG43.5 H1\nG0 X0 Y0\nZ60\nF800 S1000 M3\n",
        structure_.tilt, tilt_, structure_.turn);
    for (int i = 0; i < blocks; ++i) {
      const bool rapid = random_.chance(0.2), turns = random_.chance(0.8);
      at_.x() = std::round((at_.x() + (at_.x() > 0 ? -30 : 30)) * 1e3) / 1e3;
      if (random_.chance(0.5)) at_.y() = std::round(random_.between(-90, 90) * 1e3) / 1e3;
      if (turns) turn();
      const std::string words =
          fmt::format(" X{:.3f} Y{:.3f}{}", at_.x(), at_.y(), turns ? direction() : std::string());
      if (rapid)
        text += "G0" + words + "\n";
      else
        text += inverse_time ? fmt::format("G93 G1{} F{:.2f}\nG94 F800\n", words, random_.between(1, 6))
                             : fmt::format("G1{} (turned)\n", words);
    }
    return text + "G0 Z80\nM5\nM30\n";
  }

 private:
  void turn() {
    tilt_ = std::clamp(tilt_ + random_.between(-20, 20), least_tilt_, 70.0);
    turn_ += random_.between(-25, 25);
  }
  std::string direction() {
    const Machine& machine = plan_.machine();
    Turns turns{};
    turns[static_cast<std::size_t>(structure_.tilt - 'A')] = tilt_ * deg;
    turns[static_cast<std::size_t>(structure_.turn - 'A')] = turn_ * deg;
    const Vec3 v = ControlKinematics(machine, addressed_axes(machine))
                       .pose(Vec3::Zero(), turns, tool_of(machine, kToolLength))
                       .tool_axis *
                   (random_.chance(0.3) ? random_.between(0.2, 40) : 1);
    return fmt::format(" I{:.6f} J{:.6f} K{:.6f}", v.x(), v.y(), v.z());
  }

  Random& random_;
  Structure structure_;
  Plan plan_;
  double least_tilt_, tilt_ = 25, turn_ = 0;
  Vec3 at_ = Vec3::Zero();
};

TEST(VectorPrograms, AreVerifiedOnMachinesOfEveryStructure) {
  const testing::Seeds seeds = testing::random_seeds(42);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, kControl);
    const std::string program = Writer(random, structure, machine, 8).write(12, seed % 3 == 0);
    const ProgramRun result = run_program(plan_of(machine), program, plain_program_job(kToolLength));
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << machine << "\n----\n"
                                                    << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
    EXPECT_LE(result.outcome.verify.direction_after, result.outcome.verify.direction_before + 30 * urad);
  }
}

TEST(VectorPrograms, AMachineWithoutErrorsChangesNoByte) {
  for (std::uint64_t seed = 1; seed <= 14; ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, kControl, 0);
    const std::string program = Writer(random, structure, machine, 2).write(20, seed % 3 == 0);
    const ProgramRun result = run_program(plan_of(machine), program, plain_program_job(kToolLength));
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << findings(result.outcome) << program;
    EXPECT_EQ(result.output, program) << "seed " << seed;
  }
}

// A correction with the wrong sign doubles the error: the verifier must not take it for a good one.
TEST(VectorPrograms, OppositeErrorsAreNotVerified) {
  for (std::uint64_t seed = 1; seed <= 7; ++seed) {
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    Random random(seed), same(seed);
    const std::string machine = machine_text(random, structure, kControl),
                      opposite = machine_text(same, structure, kControl, -1);
    const std::string program = Writer(random, structure, machine, 12).write(12, true);
    const auto judge = [&](const ProgramJob& job, ProgramOutcome& outcome) {
      outcome = verify_programs(plan_of(machine), job, job.output);
    };
    const ProgramRun wrong = run_program(plan_of(opposite), program, plain_program_job(kToolLength), judge);
    EXPECT_NE(wrong.outcome.end, ProgramEnd::done) << "seed " << seed;
  }
}

}  // namespace
}  // namespace abbe
