// Random programs on tilted planes (G68.2 and G53.1) on random five-axis machines, through the whole way.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_five_axis_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// Two planes, each with lines, arcs and holes, between them a motion of the rotary axes.
class PlaneWriter {
 public:
  PlaneWriter(Random& random, const Structure& structure, const Plan& plan)
      : random_(random), structure_(structure), plan_(plan) {}

  std::string write() {
    std::string text = "O0001\nG21 G90 G17 G94 G54 G40 G80\nT1 M6\n";
    for (int i = 0; i < 2; ++i) text += plane();
    return text + "M5\nM30\n";
  }

 private:
  static double rounded(double value, double step) { return std::round(value / step) * step; }

  /// The Euler angles about Z X Z of a plane whose normal is the tool's direction with these turns; the angle
  /// in the plane is anything.
  std::string plane() {
    const auto [tilt, turn, n] = draw_stance(random_, structure_, plan_);
    // n = (sin i sin j, -cos i sin j, cos j)
    const double i = std::atan2(n.x(), -n.y()) / deg, j = std::atan2(std::hypot(n.x(), n.y()), n.z()) / deg;
    std::string text = fmt::format("G0 {}{:.3f} {}{:.3f}\n", structure_.tilt, tilt, structure_.turn, turn);
    text += fmt::format("G68.2 X{:.3f} Y{:.3f} Z{:.3f} I{:.3f} J{:.3f} K{:.3f}\nG53.1\n",
                        random_.between(-40, 40), random_.between(-40, 40), random_.between(-40, 40), i, j,
                        random_.between(-180, 180));
    text += "G0 X0. Y0.\nG43 H1 Z50. S1000 M3\nG1 Z5. F800.\n";
    for (int k = 0; k < 4; ++k) text += block();
    return text + "G0 Z80.\nG69\n";
  }
  std::string block() {
    const double x = rounded(random_.between(-120, 120), 0.001),
                 y = rounded(random_.between(-120, 120), 0.001);
    const double r = rounded(random_.between(2, 30), 0.001);
    switch (random_.below(4)) {
      case 0:
        return fmt::format("G1 X{:.3f} Y{:.3f} Z{:.3f}\n", x, y, random_.between(-20, 20));
      case 1:
        return fmt::format("G1 X{:.3f} Y{:.3f}\nG{} X{:.3f} I{:.3f} J0.\n", x, y, random_.chance(0.5) ? 2 : 3,
                           x + 2 * r, r);
      case 2:
        return fmt::format("G0 Z30.\nG98 G81 X{:.3f} Y{:.3f} Z2. R5.\nG80\nG0 Z29.\n", x, y);
      default:
        return fmt::format("G91 G1 X{:.3f} Z{:.3f}\nG90\n", random_.between(-20, 20), random_.between(-5, 5));
    }
  }

  Random& random_;
  Structure structure_;
  const Plan& plan_;
};

const std::string kControl = "[control]\nmode = \"axis\"\n";

ProgramRun run(const std::string& machine, const std::string& program, const std::string& judged_by = {}) {
  ProgramJob plain = plain_program_job(kToolLength);
  plain.setup.profile = embedded_profile("fanuc");
  return run_program(plan_of(machine), program, plain, [&](const ProgramJob& job, ProgramOutcome& outcome) {
    if (!judged_by.empty()) outcome = verify_programs(plan_of(judged_by), job, job.output);
  });
}

TEST(TiltedPlanePrograms, AreVerifiedOnMachinesOfEveryStructure) {
  const testing::Seeds seeds = testing::random_seeds(70);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, kControl);
    const std::string program = PlaneWriter(random, structure, plan_of(machine)).write();
    const ProgramRun result = run(machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << machine << "\n----\n"
                                                    << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
  }
}

TEST(TiltedPlanePrograms, AMachineWithoutErrorsChangesNoByte) {
  for (std::uint64_t seed = 1; seed <= 21; ++seed) {
    Random random(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, kControl, 0);
    const std::string program = PlaneWriter(random, structure, plan_of(machine)).write();
    const ProgramRun result = run(machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << program;
    EXPECT_EQ(result.output, program) << "seed " << seed;
  }
}

// A correction with the wrong sign doubles the error: the verifier must not take it for a good one.
TEST(TiltedPlanePrograms, OppositeErrorsAreNotVerified) {
  for (std::uint64_t seed = 1; seed <= 21; ++seed) {
    Random random(seed), same(seed);
    const Structure& structure = kStructures[seed % std::size(kStructures)];
    const std::string machine = machine_text(random, structure, kControl),
                      opposite = machine_text(same, structure, kControl, -1);
    const std::string program = PlaneWriter(random, structure, plan_of(machine)).write();
    EXPECT_EQ(run(machine, program, opposite).outcome.end, ProgramEnd::disagrees) << "seed " << seed;
  }
}

}  // namespace
}  // namespace abbe
