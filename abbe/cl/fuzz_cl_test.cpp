#include "abbe/cl/test_random_cl.h"

// Any bytes: refused, or an output that the second reader agrees with; no crash, no hang.

namespace abbe::cl {
namespace {

/// ABBE_CL_MUTANTS=100000 for a long run.
int mutant_count() {
  const char* asked = std::getenv("ABBE_CL_MUTANTS");
  return asked != nullptr ? std::atoi(asked) : 2000;
}

std::string mutated(Random& random, std::string text) {
  static const std::string kBytes = "0123456789.,/$-+ \nGOTCIRLEFANX\t\r\"'\xff";
  for (int edits = 1 + random.below(4); edits > 0 && !text.empty(); --edits) {
    const auto at = static_cast<std::size_t>(random.below(static_cast<int>(text.size())));
    const std::string byte(1,
                           kBytes[static_cast<std::size_t>(random.below(static_cast<int>(kBytes.size())))]);
    switch (random.below(5)) {
      case 0:
        text.erase(at, 1);
        break;
      case 1:
        text.insert(at, byte);
        break;
      case 2:
        text.replace(at, 1, byte);
        break;
      case 3:
        text.insert(at,
                    text.substr(static_cast<std::size_t>(random.below(static_cast<int>(text.size()))), 20));
        break;
      default:
        text.erase(at, static_cast<std::size_t>(random.below(60)));
        break;
    }
  }
  return text;
}

TEST(FuzzCl, MutantsAreRefusedOrRoundTrip) {
  const int mutants = mutant_count();
  Random random(7);
  const Plan perfect = plan_of(five_axes("")), bent = plan_of(five_axes_with_errors());
  std::string seed_text;
  int accepted = 0;
  for (int i = 0; i < mutants; ++i) {
    if (i % 50 == 0) seed_text = ClWriter(random, true).write(12);
    const std::string text = mutated(random, seed_text);
    const ClRun run = run_cl(i % 2 == 0 ? perfect : bent, text);
    if (!run.rewrite.complete) {
      EXPECT_FALSE(run.refusal().empty()) << text;
      continue;
    }
    ++accepted;
    // What the first reader accepts the second one does as well, and finds the same path in it.
    ASSERT_TRUE(run.verify.agrees) << "mutant " << i << "\n" << run.findings() << text;
    EXPECT_TRUE(i % 2 != 0 || run.output == text) << "mutant " << i << "\n" << text << "----\n" << run.output;
  }
  EXPECT_GT(accepted, mutants / 20);
}

}  // namespace
}  // namespace abbe::cl
