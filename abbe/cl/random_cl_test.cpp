#include "abbe/cl/test_random_cl.h"

// Random files on random machines: the output is verified, or refused for one of few reasons.

namespace abbe::cl {
namespace {

/// ABBE_CL_FILES=100000 for a long run; every test of this kind prints the seed that fails.
int file_count() {
  const char* asked = std::getenv("ABBE_CL_FILES");
  return asked != nullptr ? std::atoi(asked) : 300;
}

TEST(RandomCl, IsVerifiedOnRandomMachines) {
  int done = 0, refused = 0;
  const int files = file_count();
  for (int seed = 1; seed <= files; ++seed) {
    Random random(static_cast<std::uint64_t>(seed));
    const int kind = random.below(5);
    const std::string machine = random_machine_text(random, kind, 1);
    const std::string text = ClWriter(random, kind > 0).write(25);
    Options options;
    options.probed = random.chance(0.5);
    if (random.chance(0.5)) options.g54 = WorkOffset{{30, -20, 15}, random.chance(0.3) ? 0.3 : 0};
    if (random.chance(0.5)) options.gauges[1] = 80;
    const ClRun run = run_cl(plan_of(machine), text, options);
    if (!run.rewrite.complete) {
      // an arc or a hole that the correction bends too much, nothing else
      ++refused;
      for (const Diagnostic& d : run.rewrite.diagnostics) {
        const bool expected = d.severity != Severity::error || d.code == "E-CYCLE" || d.code == "E-TOL";
        EXPECT_TRUE(expected) << "seed " << seed << "\n" << to_text(d);
      }
      continue;
    }
    ASSERT_TRUE(run.verify.agrees) << "seed " << seed << "\n"
                                   << run.findings() << machine << text << "----\n"
                                   << run.output;
    EXPECT_LE(run.verify.after.max, run.verify.allowed);
    ++done;
  }
  RecordProperty("refused", refused);
  EXPECT_GT(done, files * 3 / 4) << refused << " refused";
}

TEST(RandomCl, ZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const int kind = random.below(5);
    const std::string machine = random_machine_text(random, kind, 0);
    const std::string text = ClWriter(random, kind > 0).write(30);
    const ClRun run = run_cl(plan_of(machine), text);
    ASSERT_TRUE(run.verify.agrees) << "seed " << seed << "\n" << run.findings();
    ASSERT_EQ(run.output, text) << "seed " << seed;
  }
}

}  // namespace
}  // namespace abbe::cl
