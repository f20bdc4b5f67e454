// Random contours under cutter radius compensation on random machines, through the whole way.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

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

/// Verified: true. Where it may be, refused because what stays is too much: false.
bool is_verified(const ProgramRun& run, bool may_be_refused, const std::string& context) {
  if (may_be_refused && run.outcome.end == ProgramEnd::refused) {
    for (const Diagnostic& d : run.outcome.diagnostics)
      EXPECT_TRUE(d.code == "E-TOL" || d.severity != Severity::error) << context << to_text(d);
    return false;
  }
  EXPECT_EQ(run.outcome.end, ProgramEnd::done) << context << findings(run.outcome) << run.output;
  EXPECT_LE(run.outcome.verify.after.max, run.outcome.verify.allowed) << context;
  return true;
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
    // a helix that may not be split
    const std::string context = fmt::format("seed {}\n{}{}\n----\n", seed, machine, program);
    if (!is_verified(result, !worn_only, context)) continue;
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
    // an arc that leaves its plane may not become lines beside a contour
    done += is_verified(result, true, fmt::format("seed {}\n{}{}\n----\n", seed, machine, program)) ? 1 : 0;
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
