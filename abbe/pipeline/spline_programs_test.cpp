// Random curves by control points (G6.2) on random machines, through the whole way.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

ProgramRun run(const std::string& machine, const std::string& program) {
  ProgramJob job = plain_program_job();
  job.setup.profile = embedded_profile("fanuc");
  return run_program(plan_of(machine), program, job);
}

/// One curve from place to place in steps of about 10 mm, with random knots and weights.
std::string curve(Random& random, Vec3& at) {
  const int order = 2 + random.below(3), points = order + random.below(8);
  std::string text;
  double knot = 0;
  for (int i = 0; i < points + order; ++i) {
    if (i >= order && i <= points) knot += i == points ? 1 : std::round(random.between(0.2, 2) * 1e3) / 1e3;
    text += i == 0 ? fmt::format("G6.2 P{} K{:.3f}", order, knot) : fmt::format("K{:.3f}", knot);
    if (i < points) {
      if (i > 0)
        for (int k = 0; k < 3; ++k)
          at[k] = std::round(std::clamp(at[k] + random.between(-10, 10), -150.0, 150.0) * 1e3) / 1e3;
      text += fmt::format(" X{:.3f} Y{:.3f}", at.x(), at.y());
      if (i == 0 || random.chance(0.7))
        text += fmt::format(" Z{:.3f}", at.z());
      else
        at.z() = at.z();
      if (random.chance(0.3)) text += fmt::format(" R{:.2f}", random.between(0.5, 2));
    }
    text += i == 2 ? " (knot)\n" : "\n";
  }
  return text;
}

std::string random_program(Random& random) {
  Vec3 at(10, 20, 5);
  std::string text = "G21 G90 G94 G17 G54\nT1 M6\nG0 X10. Y20.\nG43 H1 Z5.\nF100. S1000 M3\n";
  for (int i = 0; i < 4; ++i) {
    // Z of points that do not name it is that of the point before
    const std::string blocks = curve(random, at);
    text += blocks;
    at.z() = std::round(random.between(-20, 20) * 1e3) / 1e3;
    at.x() = std::round(random.between(-50, 50) * 1e3) / 1e3;
    text += fmt::format("G1 X{:.3f} Y{:.3f} Z{:.3f}\n", at.x(), at.y(), at.z());
  }
  return text + "G0 Z80.\nM5\nM30\n";
}

TEST(SplinePrograms, AreVerifiedOnRandomMachines) {
  std::uint64_t done = 0;
  const testing::Seeds seeds = testing::random_seeds(60);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.5);
    const std::string program = random_program(random);
    const ProgramRun result = run(machine, program);
    if (result.outcome.end == ProgramEnd::refused) {  // the correction bends between knots that are far apart
      for (const Diagnostic& d : result.outcome.diagnostics)
        EXPECT_TRUE(d.code == "E-SPLINE" || d.severity != Severity::error) << seed << to_text(d);
      continue;
    }
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
    ++done;
  }
  EXPECT_GT(done, seeds.count / 2);
}

TEST(SplinePrograms, ZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = random_program(random);
    const ProgramRun result = run(machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << findings(result.outcome) << program;
    EXPECT_EQ(result.output, program) << "seed " << seed;
  }
}

TEST(SplinePrograms, AnyChangeIsVerifiedOrRefused) {
  Random random(11);
  const std::string machine = random_machine(random, 0.1), program = random_program(random);
  for (int i = 0; i < 200; ++i) {
    std::string changed = program;
    for (int k = random.below(3); k >= 0; --k) {
      const auto at = static_cast<std::size_t>(random.below(static_cast<int>(changed.size())));
      changed[at] = "0123456789.-KXYZPRG \n"[random.below(21)];
    }
    const ProgramRun result = run(machine, changed);
    EXPECT_NE(result.outcome.end, ProgramEnd::disagrees) << findings(result.outcome) << changed;
  }
}

}  // namespace
}  // namespace abbe
