// The verification follows the rewriter through a file that is being written: nothing of that may show.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// Several buffers long; `odd` stands in the middle.
std::string long_program(const std::string& odd = "") {
  Random random(3);
  std::string text = "G21 G90 G17 G54 G94\nT1 M6\nG0 G43 H1 X0. Y0. Z20.\nF500. S1000 M3\n";
  for (int i = 0; i < 20000; ++i) {
    text += fmt::format("G1 X{:.3f} Y{:.3f} Z{:.3f}\n", i % 200 + random.between(0, 1), random.between(0, 3),
                        random.between(-1, 1));
    if (i == 10000) text += odd;
  }
  return text + "G0 Z50.\nM30\n";
}

Plan random_plan() {
  Random random(4);
  return plan_of(random_machine(random, 0.3));
}

/// The same with one and with two threads; returns that of two.
ProgramRun run_both_ways(const std::string& program, ProgramJob job = plain_program_job()) {
  const Plan plan = random_plan();
  const TestFile original(program), corrected("");
  job.program = original.path();
  job.output = corrected.path();
  ProgramRun runs[2];
  for (const unsigned threads : {1U, 2U}) {
    job.threads = threads;
    runs[threads - 1].outcome = compensate_program(plan, job);
    runs[threads - 1].output = slurp(job.output);
  }
  EXPECT_EQ(runs[0].outcome.end, runs[1].outcome.end);
  EXPECT_TRUE(runs[0].output == runs[1].output);
  EXPECT_EQ(runs[0].outcome.json, runs[1].outcome.json);
  EXPECT_EQ(runs[0].outcome.text, runs[1].outcome.text);
  EXPECT_EQ(findings(runs[0].outcome), findings(runs[1].outcome));
  return runs[1];
}

TEST(TwoThreads, GiveTheSameOutputAndTheSameReport) {
  const ProgramRun run = run_both_ways(long_program());
  EXPECT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  EXPECT_GT(run.output.size(), std::size_t{1} << 19);
  EXPECT_EQ(run.outcome.verify.output.bytes, run.output.size());
}

TEST(TwoThreads, WhatIsRefusedHalfWayIsRefusedAlike) {
  const ProgramRun run = run_both_ways(long_program("G1 X#5\n"));
  EXPECT_EQ(run.outcome.end, ProgramEnd::refused);
  EXPECT_EQ(run.output, "");
}

// The subprogram stands behind the program: the verification must not look for it before it is written.
TEST(TwoThreads, FindASubprogramAtTheEnd) {
  std::string program = long_program("M98 P2000\n");
  program += "O2000\nG1 X5. Y5. Z1.\nX6. Y7. Z2.\nM99\n";
  ProgramJob job = plain_program_job();
  job.setup.profile = embedded_profile("fanuc");
  const ProgramRun run = run_both_ways(program, job);
  EXPECT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
}

TEST(TwoThreads, StopWhenAsked) {
  const Plan plan = random_plan();
  const TestFile original(long_program()), corrected("");
  ProgramJob job = plain_program_job();
  job.program = original.path();
  job.output = corrected.path();
  job.threads = 2;
  // At the first question, and later: in the rewriter or while the verification is waited for.
  for (const int most : {0, 1, 3}) {
    int calls = 0;
    const auto outcome =
        compensate_program(plan, job, [&](std::uint64_t, std::uint64_t) { return ++calls <= most; });
    const bool asked = calls > most;
    EXPECT_EQ(outcome.end, asked ? ProgramEnd::stopped : ProgramEnd::done) << most;
    EXPECT_EQ(slurp(job.output).empty(), asked) << most;
    EXPECT_TRUE(asked || most > 0);
  }
}

}  // namespace
}  // namespace abbe
