#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "abbe/core/least_squares.h"
#include "test_hidden_machine.h"

namespace abbe {
namespace {

using test::kChain;
using test::kHiddenErrors;
using test::machine_of;
using test::measure;

constexpr int kSamples = 400;

/// Truth minus prediction at another radius and feed, centre and length of the bar taken off, and the
/// prediction's standard uncertainty.
struct Unseen {
  double worst = 0;  ///< largest |difference| / uncertainty
  double rms = 0;    ///< mm
  bool determined = true;
};

Unseen unseen_trace(const Machine& machine, const Identification& found) {
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  const BallbarTest truth = simulate_circle(plan, test::circle_of(125, 60, 360), {}).test;
  Unseen out;
  for (std::size_t run = 0; run < 2; ++run) {
    const TracePrediction trace = predict_trace(machine, found, truth, run);
    out.determined = out.determined && trace.determined;
    TriangularFactor factor(3);
    std::vector<double> difference;
    for (std::size_t i = 0; i < trace.deviation.size(); ++i) {
      const double t = truth.runs[run].angle[i];
      difference.push_back(truth.runs[run].deviation[i] - trace.deviation[i]);
      factor.add(std::array{1.0, std::cos(t), std::sin(t)}, difference.back());
    }
    const LeastSquaresSolution setup = solve(factor, {});
    for (std::size_t i = 0; i < difference.size(); ++i) {
      const double t = truth.runs[run].angle[i];
      // Near a reversal the sense of motion is not sure.
      if (std::min(std::abs(std::sin(t)), std::abs(std::cos(t))) < 0.02) continue;
      const double rest = difference[i] - setup.x[0] - setup.x[1] * std::cos(t) - setup.x[2] * std::sin(t);
      out.rms = std::max(out.rms, std::abs(rest));
      out.worst = std::max(out.worst, std::abs(rest) / trace.uncertainty[i]);
    }
  }
  return out;
}

TEST(ClosedLoop, UnseenTraceIsWithinThreeSigma) {
  const Machine machine = machine_of(kChain + kHiddenErrors);
  for (const std::uint64_t seed : {1, 2, 3}) {
    SimulationSettings settings = test::quiet();
    settings.seed = seed;
    const Identification found =
        identify_jointly(machine_of(kChain), measure(machine, settings, kSamples), {});
    ASSERT_TRUE(found.ok());
    EXPECT_TRUE(found.trusted) << found.doubts[0];
    const Unseen unseen = unseen_trace(machine, found);
    EXPECT_TRUE(unseen.determined);
    EXPECT_LT(unseen.worst, 3) << seed;
    EXPECT_LT(unseen.rms, 0.1 * um) << seed;
  }
}

TEST(ClosedLoop, ServoLagsAreSeenByTheServo) {
  const Machine machine = machine_of(kChain + kHiddenErrors);
  SimulationSettings settings = test::quiet();
  settings.lag = {1e-3, 1.4e-3, 0};
  settings.positions = true;
  const Identification found = identify_jointly(machine_of(kChain), measure(machine, settings, kSamples), {});
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found.trusted) << found.doubts[0];
  EXPECT_GT(found.runs.back().servo, 5 * um);
  // The mechanical rest is what it is without lag.
  const Identification stiff =
      identify_jointly(machine_of(kChain), measure(machine, test::quiet(), kSamples), {});
  for (std::size_t k = 0; k < found.terms.size(); ++k) {
    if (!found.terms[k].identifiable || !found.terms[k].term.is_dynamic()) continue;
    EXPECT_NEAR(found.terms[k].value, stiff.terms[k].value, 5 * stiff.terms[k].uncertainty);
  }
}

TEST(ClosedLoop, UnmodelledErrorsAreFlagged) {
  std::string cyclic = kChain + kHiddenErrors;
  cyclic.replace(cyclic.find("EXX = ["), 7, "EXX = [ { sine = [0.15, 1.2566, 0.4] },");
  const Identification one =
      identify_jointly(machine_of(kChain), measure(machine_of(cyclic), test::quiet(), kSamples), {});
  EXPECT_FALSE(one.trusted);
  EXPECT_GT(one.inflation, 1.5);
  SimulationSettings coloured = test::quiet();
  coloured.colour = 0.8;
  const Identification two = identify_jointly(
      machine_of(kChain), measure(machine_of(kChain + kHiddenErrors), coloured, kSamples), {});
  EXPECT_FALSE(two.trusted);
  EXPECT_GT(two.inflation, 4);  // tau = 9
}

TEST(ClosedLoop, ClocksThatDisagreeAreFound) {
  const Machine machine = machine_of(kChain + kHiddenErrors);
  SimulationSettings settings = test::quiet();
  settings.clock_offset = 20e-3;
  const std::vector<BallbarTest> tests = measure(machine, settings, kSamples);
  IdentifyOptions options;
  options.reversal_window = 0.1;
  options.time_offset = 20e-3;
  const Identification found = identify_jointly(machine_of(kChain), tests, options);
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found.trusted) << found.doubts[0];
  EXPECT_NEAR(found.chi_square, 1, 0.1);
}

// As identify_coverage, with fewer seeds: the pooled share of intervals that hold the truth. Its standard
// deviation over 30 seeds of some fifteen terms is about 1 %.
TEST(ClosedLoop, IntervalsCoverTheTruth) {
  const Machine machine = machine_of(kChain + kHiddenErrors);
  SimulationSettings exact = test::quiet();
  exact.noise = 0;
  IdentifyOptions options;
  options.noise = 0.1 * um;
  const Identification truth = identify_jointly(machine_of(kChain), measure(machine, exact, 120), options);
  int covered = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SimulationSettings settings = test::quiet();
    settings.seed = seed;
    const Identification found =
        identify_jointly(machine_of(kChain), measure(machine, settings, 120), options);
    for (std::size_t k = 0; k < found.terms.size(); ++k) {
      if (!found.terms[k].identifiable) continue;
      ++all;
      covered +=
          std::abs(found.terms[k].value - truth.terms[k].value) <= 1.96 * found.terms[k].uncertainty ? 1 : 0;
    }
  }
  ASSERT_GT(all, 200);
  EXPECT_NEAR(static_cast<double>(covered) / all, 0.95, 0.03);
}

}  // namespace
}  // namespace abbe
