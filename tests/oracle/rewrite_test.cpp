// Compensated programs as LinuxCNC runs them: on the machine with its errors their path is the original's
// path on the ideal machine, within the tolerance and the rounding of the digits written.

#include "abbe/compensate/rewrite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"
#include "abbe/machine/read_machine.h"
#include "tests/oracle/follow.h"
#include "tests/oracle/oracle_fixture.h"
#include "tests/oracle/random_program.h"

namespace abbe::oracle {
namespace {

constexpr double kTolerance = 1 * um;
constexpr double kCycleTolerance = 20 * um;  // a cycle can only be shifted as a whole
// Half a last digit per axis and, of arcs, of centre and end: 4 digits in mm, 5 in inches.
constexpr double kDigitsMm = 3 * 0.05 * um, kDigitsInch = 3 * 0.127 * um;

// A three-axis machine with all 21 errors, drawn at random: some ten um and ten urad over a metre.
Machine random_machine(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random() >> 11U) * 0x1p-53);
  };
  static constexpr std::array<const char*, 5> kChains = {"w b X Y Z t", "w Y b X Z t", "w Y X b Z t",
                                                         "w X b Z Y t", "w Z Y X b t"};
  std::string text = "format = 1\n[machine]\nname = \"random " + std::to_string(seed) + "\"\n";
  const std::string chain = kChains[random() % kChains.size()];
  text += "chain = \"" + chain + "\"\n";
  for (const char axis : {'X', 'Y', 'Z'}) {  // axes that carry the workpiece say where their errors are seen
    if (chain.find(axis) > chain.find('b')) continue;
    text +=
        std::string("[axis.") + axis + "]\nerrors_seen = \"" + (random() % 2 == 0 ? "tool" : "body") + "\"\n";
  }
  text += "[tool]\nlength = 150\n[errors]\n";
  for (const char axis : {'X', 'Y', 'Z'}) {
    for (const std::string kind : {"EX", "EY", "EZ", "EA", "EB", "EC"}) {
      const bool turns = kind[1] <= 'C';
      const double size = turns ? 20 : 8;  // urad, um
      text += kind + axis + " = [{ poly = [" + std::to_string(between(-size, size)) + ", " +
              std::to_string(between(-0.03, 0.03)) + "] }, { sine = [" +
              std::to_string(between(0, size / 3)) + ", " + std::to_string(between(0.01, 0.04)) + ", " +
              std::to_string(between(-3, 3)) + "] }]\n";
    }
  }
  text += "EC0Y = " + std::to_string(between(-30, 30)) + "\nEA0Z = " + std::to_string(between(-30, 30)) +
          "\nEB0Z = " + std::to_string(between(-30, 30)) + "\n";
  const auto parsed =
      read_machine({"random.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  for (const auto& diagnostic : parsed.diagnostics) {
    if (diagnostic.severity == Severity::error) ADD_FAILURE() << to_text(diagnostic);
  }
  return parsed.value.value_or(Machine{});
}

// Tip in the workpiece for commands of X Y Z.
Tip tip_of(const Plan& plan, const ControlSetup& setup, bool actual) {
  return [&plan, setup, actual](const Vec3& commands, int tool) {
    const Machine& machine = plan.machine();
    const auto number = tool < 0 ? std::nullopt : std::optional<int>(tool);
    Query query;
    query.tool = tool_of(machine, gauge_length(setup, machine, number).length);
    for (int k = 0; k < 3; ++k) {
      query.q[static_cast<std::size_t>(machine.find_axis(std::string(1, "XYZ"[k])))] = commands[k];
    }
    return actual ? actual_tip(plan, query) : nominal_tip(plan, query);
  };
}

// Where a contour is almost smooth the control puts arcs between its offsets, or not, as the last digits
// fall.
constexpr double kSpeck = 5 * um;
std::vector<Motion> without_specks(std::vector<Motion> motions) {
  std::erase_if(motions, [](const Motion& motion) {
    const auto is_near = [&](double s) { return (point_at(motion, s) - motion.start).norm() < kSpeck; };
    // whole turns come back to the start, two of them half-way, too
    return motion.kind == Motion::Kind::arc && is_near(1) && is_near(0.5) && is_near(0.3);
  });
  return motions;
}

// Compensates `program`; what is wrong with the result, in words. `untouched` grows to the largest deviation,
// mm, that the program would have had, left alone.
std::string wrong_with(const std::string& program, const Run& original, std::uint64_t seed, double tolerance,
                       double& untouched) {
  const Machine machine = random_machine(seed);
  const auto made = make_plan(machine, {});
  const auto* plan = std::get_if<Plan>(&made);
  if (plan == nullptr) return "no plan";

  RewriteJob job;
  job.path = job.name = program;
  job.setup = setup_of_oracle();
  job.probed_datum = false;
  job.tolerance = tolerance;
  const std::string output = scratch() + "/seed_" + std::to_string(seed) + "_rewritten.ngc";
  auto created = SpoolFile::create(output);
  auto* spool = std::get_if<SpoolFile>(&created);
  if (spool == nullptr) return "no spool";
  const RewriteReport report = rewrite_program(*plan, job, *spool);
  if (!report.complete) {
    const auto reason = std::find_if(report.diagnostics.begin(), report.diagnostics.end(),
                                     [](const Diagnostic& d) { return d.severity == Severity::error; });
    return "refused: " + (reason == report.diagnostics.end() ? "" : to_text(*reason));
  }
  if (!spool->publish()) return "not published";

  const auto rewritten = run(output);
  if (!rewritten) return "the oracle did not start";
  if (!rewritten->accepted && !rewritten->open_end) return "LinuxCNC refuses it: " + rewritten->message;
  const Tip nominal = tip_of(*plan, job.setup, false), actual = tip_of(*plan, job.setup, true);

  for (const Motion& motion : original.motions) {
    untouched =
        std::max(untouched, (actual(motion.end, motion.tool) - nominal(motion.end, motion.tool)).norm());
  }
  const double allowed = tolerance + std::max(kDigitsMm, kDigitsInch) + report.cycle_residual;
  const Following following =
      follow(without_specks(original.motions), without_specks(rewritten->motions), nominal, actual, allowed);
  if (!following.fault.empty()) return following.fault;
  if (original.motions.size() > 10 && following.before > original.motions.size() / 2)
    return "it never comes to the path";
  std::filesystem::remove(output);
  return {};
}

class RewrittenPrograms : public testing::TestWithParam<Listed> {};

TEST_P(RewrittenPrograms, FollowTheOriginal) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  const Listed& listed = GetParam();
  if (!std::filesystem::exists(listed.file())) GTEST_SKIP() << listed.file() << " is absent";
  if (listed.has("g53") || listed.has("rotated")) GTEST_SKIP() << "not to be compared:" << listed.needs;
  const auto original = run(listed.file());
  ASSERT_TRUE(original.has_value());
  const bool cycles = listed.path.find("-g8") != std::string::npos;
  const double tolerance = cycles ? kCycleTolerance : kTolerance;
  double untouched = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_THAT(wrong_with(listed.file(), *original, seed, tolerance, untouched), testing::IsEmpty())
        << "machine " << seed;
  }
  if (!original->motions.empty()) {
    EXPECT_GT(untouched, 2 * kTolerance) << "nothing was compensated";
  }
}

INSTANTIATE_TEST_SUITE_P(MustAccept, RewrittenPrograms, testing::ValuesIn(must_accept()), test_name);

class RewrittenRandomPrograms : public testing::TestWithParam<int> {};

void expect_rewritten_programs_follow(int block, bool with_cycles) {
  constexpr int kPerBlock = 30, kShown = 3;
  // Rotated work offsets with arcs in other planes and with cycles are refused (E-ROTATION): one without the
  // other.
  const bool rotations = block == 0 && !with_cycles;
  const Ingredients ingredients{.cycles = with_cycles,
                                .machine_moves = false,
                                .tool_numbers = false,
                                .rotations = rotations,
                                .all_planes = !rotations};
  const std::string folder = scratch();
  int different = 0;
  double untouched = 0;
  for (int k = 0; k < kPerBlock && different < kShown; ++k) {
    const auto seed = static_cast<std::uint64_t>(block * kPerBlock + k + 1);
    const std::string program = folder + "/seed_" + std::to_string(seed) + ".ngc";
    std::ofstream(program, std::ios::binary) << random_program(seed, ingredients);
    const auto original = run(program);
    ASSERT_TRUE(original.has_value());
    ASSERT_TRUE(original->accepted) << program << "\n" << original->message;
    const std::string wrong =
        wrong_with(program, *original, seed, with_cycles ? kCycleTolerance : kTolerance, untouched);
    if (wrong.empty()) {
      std::filesystem::remove(program);
    } else {
      ++different;
      ADD_FAILURE() << program << "\n" << wrong;
    }
  }
  EXPECT_GT(untouched, 20 * kTolerance) << "nothing was compensated";
}

TEST_P(RewrittenRandomPrograms, FollowTheOriginal) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  expect_rewritten_programs_follow(GetParam(), false);
}

TEST_P(RewrittenRandomPrograms, WithCyclesFollowTheOriginal) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  expect_rewritten_programs_follow(GetParam(), true);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RewrittenRandomPrograms, testing::Range(0, 3));

// Cutter compensation by LinuxCNC itself: on the machine with its errors the centre that it runs beside the
// rewritten contour goes where, on the ideal machine, it goes beside the original one.
void expect_rewritten_contours_follow(bool worn_only, double tolerance) {
  constexpr int kContours = 25, kShown = 3;
  const std::string folder = scratch();
  int different = 0, followed = 0;
  double untouched = 0;
  for (int k = 1; k <= kContours && different < kShown; ++k) {
    const auto seed = static_cast<std::uint64_t>(k);
    const std::string program = folder + "/contour_" + std::to_string(seed) + ".ngc";
    std::ofstream(program, std::ios::binary) << random_contour(seed, worn_only);
    const auto original = run(program);
    ASSERT_TRUE(original.has_value());
    ASSERT_TRUE(original->accepted) << program << "\n" << original->message;
    const std::string wrong = wrong_with(program, *original, seed, tolerance, untouched);
    const bool refused = wrong.starts_with("refused") && wrong.find("E-TOL") != std::string::npos;
    followed += wrong.empty() ? 1 : 0;
    if (wrong.empty() || refused) {  // a helix that may not be split
      std::filesystem::remove(program);
    } else {
      ++different;
      ADD_FAILURE() << program << "\n" << wrong;
    }
  }
  EXPECT_GT(followed, kContours / 2);
  EXPECT_GT(untouched, 5 * tolerance) << "nothing was compensated";
}

TEST(RewrittenContours, TheCutterFollowsTheOriginal) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  constexpr double kWithRadius = 3 * um;  // the radius costs its part
  expect_rewritten_contours_follow(false, kWithRadius);
}

TEST(RewrittenContours, OfWearAloneNothingIsLeft) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  expect_rewritten_contours_follow(true, kTolerance);
}

}  // namespace
}  // namespace abbe::oracle
