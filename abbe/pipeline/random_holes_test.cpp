// Random holes on machines that lean and bend along Z, written out as G0 and G1: what the rewriter writes,
// the independent reader must find to do what the cycles do.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// Errors along Z that change by several micrometres in a hole; lost motion of all axes where asked.
std::string leaning_machine(Random& random, bool lost_motion) {
  std::string text = "format = 1\n[machine]\nname = \"leaning\"\nchain = \"w b X Y Z t\"\n";
  for (const char axis : {'X', 'Y', 'Z'}) text += fmt::format("[axis.{}]\nrange = [-600, 600]\n", axis);
  text += "[tool]\nlength = 80\n[errors]\n";
  for (const char direction : {'X', 'Y', 'Z'}) {
    const double lean = random.between(-0.2, 0.2), bow = random.between(-0.001, 0.001);
    const double play = lost_motion ? random.between(-6, 6) : 0;
    const auto poly = [&](double side) {
      return fmt::format("poly = [{:.4f}, {:.5f}, {:.6f}]", side * play, lean, bow);
    };
    text += lost_motion && direction == 'Z'
                ? fmt::format("EZZ = {{ forward = {{ {} }}, backward = {{ {} }} }}\n", poly(0.5), poly(-0.5))
                : fmt::format("E{}Z = {{ {} }}\n", direction, poly(0));
  }
  return text;
}

struct Place {
  double x = 0, y = 0;
};

std::string holes(Random& random, bool fanuc) {
  const bool inch = !fanuc && random.chance(0.3);
  const double unit = inch ? 25.4 : 1;
  const auto at = [&](char letter, double v) { return fmt::format(" {}{:.3f}", letter, v / unit); };
  std::string text = fmt::format("{} G90 G17 G54 G94\n", inch ? "G20" : "G21");
  text += "T1 M6\nG43 H1\nG0" + at('X', 0) + at('Y', 0) + at('Z', 40) + "\nF100 S1000 M3\n";
  for (int sequence = 0; sequence < 4; ++sequence) {
    // increments of R count from the level before the sequence: with G99 the tool would be below it
    const bool dwells = random.chance(0.5), steps = random.chance(0.3), twice = random.chance(0.1);
    text += "G0" + at('Z', random.between(20, 40)) + "\n";
    const Place place{random.between(-200, 200), random.between(-200, 200)};
    const double r = random.between(2, 15), z = random.between(-80, 1);
    text += fmt::format("N{} G9{} {}", 10 * sequence + 1, steps || random.chance(0.5) ? 8 : 9,
                        dwells ? "G82" : "G81");
    text += at('X', place.x) + at('Y', place.y) + at('R', r) + at('Z', z);
    text += dwells ? (fanuc ? " P300" : " P0.25") : "";
    text += twice ? (fanuc ? " K2" : " L2") : "";
    text += random.chance(0.3) ? " M8 (holes)\n" : "\n";
    if (steps && !fanuc) {
      text += "G91" + at('X', random.between(1, 9)) + at('R', -12) + at('Z', -15) + " L3\nG90\n";
    } else {
      for (int hole = random.below(3); hole-- > 0;)
        text +=
            at('X', random.between(-200, 200)).substr(1) + (random.chance(0.3) ? at('Z', z - 2) : "") + "\n";
    }
    text += random.chance(0.5) ? "G80\n" : "";
  }
  return text + "G80\nG0" + at('Z', 60) + "\nM30\n";
}

TEST(RandomHoles, AreWrittenOutAsTheirCyclesDrillThem) {
  std::uint64_t expanded = 0;
  const Seeds seeds = random_seeds(60);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const bool fanuc = seed % 3 == 0, reversal = seed % 2 == 0;
    const std::string machine = leaning_machine(random, reversal), program = holes(random, fanuc);
    ProgramJob job = plain_program_job();
    job.expand_drill = true;
    job.reversal = reversal;
    job.setup.profile = embedded_profile(fanuc ? "fanuc" : "linuxcnc");
    if (!fanuc) job.setup.work_offsets[0]->rotation = seed % 4 == 0 ? 0.3 : 0.0;
    const ProgramRun result = run_program(plan_of(machine), program, job);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done)
        << "seed " << seed << "\n"
        << machine << findings(result.outcome) << program << "\n----\n"
        << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    expanded += result.outcome.rewrite.expanded_holes;
  }
  EXPECT_GT(expanded, seeds.count);
}

}  // namespace
}  // namespace abbe
