// Random contours under cutter radius compensation on random machines, through the whole way.

#include <gtest/gtest.h>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_contour.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

using Language = RandomContour::Language;

ProgramRun run(const std::string& machine, const std::string& program, double tolerance,
               Language language = Language::rs274, double radius = 5) {
  ProgramJob job = plain_program_job();
  if (language == Language::klartext) {
    job.setup.profile = embedded_profile("heidenhain");
    job.setup.radii[1] = radius;
  }
  job.tolerance = tolerance;
  job.setup.tool_change_keeps_place = true;
  job.setup.start = {0.0, 0.0, 0.0};
  return run_program(plan_of(machine), program, job);
}

TEST(RandomContours, AreVerifiedOnRandomMachines) {
  std::uint64_t done = 0, turned = 0;
  const Seeds seeds = random_seeds(80);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const bool worn_only = seed % 3 == 0, rotated = seed % 4 == 0;
    const std::string machine = random_machine(random, 1.0);
    const std::string program = RandomContour(random, {1, 10}, worn_only).write(rotated);
    const double tolerance = (worn_only ? 1 : 4) * um;  // the radius costs its part
    const ProgramRun result = run(machine, program, tolerance);
    if (!worn_only && result.outcome.end == ProgramEnd::refused) {
      // a helix that may not be split, nothing else
      for (const Diagnostic& d : result.outcome.diagnostics)
        EXPECT_TRUE(d.code == "E-TOL" || d.severity != Severity::error) << "seed " << seed << "\n"
                                                                        << to_text(d);
      continue;
    }
    ASSERT_EQ(result.outcome.end, ProgramEnd::done)
        << "seed " << seed << "\n"
        << machine << findings(result.outcome) << program << "\n----\n"
        << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    ++done;
    turned += rotated ? 1 : 0;
  }
  EXPECT_GT(done, seeds.count / 2);
  EXPECT_GT(turned, 0U);
}

TEST(RandomContours, ZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = RandomContour(random, {1, 10}, seed % 3 == 0).write(false);
    const ProgramRun result = run(machine, program, 1 * um);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program;
    ASSERT_EQ(result.output, program) << "seed " << seed;
  }
}

// RL and RR of conversational programs; the wear alone where the radius is 0.
TEST(RandomContours, OfKlartextAreVerifiedOnRandomMachines) {
  std::uint64_t done = 0;
  const Seeds seeds = random_seeds(40);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const bool worn_only = seed % 3 == 0;
    const std::string machine = random_machine(random, 0.3);
    const std::string program = RandomContour(random, {1, 10}, worn_only, Language::klartext).write(false);
    const ProgramRun result =
        run(machine, program, (worn_only ? 1 : 4) * um, Language::klartext, worn_only ? 0 : 5);
    if (result.outcome.end == ProgramEnd::refused) {
      // an arc that leaves its plane may not become lines beside a contour, nothing else
      for (const Diagnostic& d : result.outcome.diagnostics)
        EXPECT_TRUE(d.code == "E-TOL" || d.severity != Severity::error) << "seed " << seed << "\n"
                                                                        << to_text(d);
      continue;
    }
    ASSERT_EQ(result.outcome.end, ProgramEnd::done)
        << "seed " << seed << "\n"
        << machine << findings(result.outcome) << program << "\n----\n"
        << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    ++done;
  }
  EXPECT_GT(done, seeds.count / 4);
}

TEST(RandomContours, OfKlartextWithZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = RandomContour(random, {1, 10}, false, Language::klartext).write(false);
    const ProgramRun result = run(machine, program, 1 * um, Language::klartext);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program;
    ASSERT_EQ(result.output, program) << "seed " << seed;
  }
}

}  // namespace
}  // namespace abbe
