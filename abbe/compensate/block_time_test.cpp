// RewriteJob::block_time: no split makes a block faster than the control reads them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/line_split.h"
#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/core/number.h"
#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

using testing::plain_job;
using testing::poly;
using testing::rewrite;
using testing::three_axes;

/// Z sags by 2e-6 x^2 mm: over a chord of length h it bends by 2e-6 h^2 / 4.
Machine sagging_machine() { return three_axes({{"EZX", poly(0, {0, 0, 2e-6})}}); }

RewriteJob timed_job(double block_time) {
  RewriteJob job = plain_job();
  job.block_time = block_time;
  return job;
}

std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

std::vector<MoveSample> sagging_samples() {
  std::vector<MoveSample> samples;
  for (int i = 0; i <= 10; ++i) samples.push_back({0.1 * i, Vec3(0, 0, 0.01 * i * i)});
  return samples;
}

TEST(JoinShort, LeavesNoPieceShorterThanTheShare) {
  const auto samples = sagging_samples();
  const std::vector<std::size_t> ends{1, 2, 4, 7, 9, 10};
  EXPECT_EQ(join_short(samples, ends, 0), ends);
  EXPECT_EQ(join_short(samples, ends, 0.1), ends);
  EXPECT_EQ(join_short(samples, ends, 0.2), (std::vector<std::size_t>{2, 4, 7, 10}));
  EXPECT_EQ(join_short(samples, ends, 0.4), (std::vector<std::size_t>{4, 10}));
  EXPECT_EQ(join_short(samples, ends, 1), (std::vector<std::size_t>{10}));
}

/// 0.01 i^2 is off its chord between i and j by 0.01 ((j - i) / 2)^2.
TEST(FarthestOff, IsTheLargestDistanceFromTheChords) {
  const auto samples = sagging_samples();
  EXPECT_NEAR(farthest_off(samples, {10}), 0.25, 1e-12);
  EXPECT_NEAR(farthest_off(samples, {4, 10}), 0.09, 1e-12);
  EXPECT_EQ(farthest_off(samples, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}), 0);
}

TEST(BlockTime, ALongEnoughBlockIsSplitAsEver) {
  const std::string program = "G0 X0 Y0 Z0\nG1 X100 F600\nM2\n";  // 10 s
  const auto usual = rewrite(sagging_machine(), program);
  EXPECT_EQ(rewrite(sagging_machine(), program, timed_job(0.1)).text, usual.text);
  EXPECT_GT(usual.report.shortest_split, 0);
  // T = L / F
  EXPECT_NEAR(usual.report.shortest_split_time, usual.report.shortest_split / 10, 1e-9);
}

TEST(BlockTime, PiecesAreNotShorter) {
  // 100 mm in 100 ms sag by 5 um: 5 pieces of 20 mm leave 0.2 um, 3 of 33 mm 0.55 um
  const std::string program = "G0 X0 Y0 Z0\nG1 X100 F60000\nM2\n";
  const auto usual = rewrite(sagging_machine(), program);
  const auto held = rewrite(sagging_machine(), program, timed_job(0.030));
  ASSERT_TRUE(held.report.complete) << held.findings();
  EXPECT_LT(lines_of(held.text), lines_of(usual.text));
  EXPECT_GE(held.report.shortest_split_time, 0.030 * 0.999);
  EXPECT_EQ(held.report.held_splits, 1U);
  EXPECT_GT(held.report.held_residual, 0.5 * um);
  EXPECT_LE(held.report.held_residual, 1 * um);
  const auto refused = rewrite(sagging_machine(), program, timed_job(0.060));
  EXPECT_TRUE(refused.has("E-TOL")) << refused.findings();
}

TEST(BlockTime, InverseTimeStatesIt) {
  const std::string program = "G0 X0 Y0 Z0\nG93 G1 X100 F600\nG94\nM2\n";  // 100 ms
  EXPECT_EQ(rewrite(sagging_machine(), program, timed_job(0.030)).report.held_splits, 1U);
  EXPECT_TRUE(rewrite(sagging_machine(), program, timed_job(0.060)).has("E-TOL"));
}

TEST(BlockTime, InchesAndFeedPerTurn) {
  const auto inches =
      rewrite(sagging_machine(), "G20\nG0 X0 Y0 Z0\nG1 X4 F2400\nM2\n", timed_job(0.060));  // 100 ms
  EXPECT_TRUE(inches.has("E-TOL")) << inches.findings();
  const auto turns = rewrite(sagging_machine(), "G0 X0 Y0 Z0\nG95 G1 X100 F0.2\nG94\nM2\n", timed_job(10));
  ASSERT_TRUE(turns.report.complete) << turns.findings();
  EXPECT_EQ(turns.report.shortest_split_time, 0);
  EXPECT_GT(turns.report.blocks.split, 0U);
}

// F of a conversational program in inches counts tenths of an inch per minute: F24000 goes 4 inches in 100 ms.
TEST(BlockTime, TenthsOfAnInchInKlartext) {
  RewriteJob job = timed_job(0.060);
  job.setup.profile = embedded_profile("heidenhain");
  const std::string begin = "0 BEGIN PGM A INCH\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+4 F";
  const auto fast = rewrite(sagging_machine(), begin + "24000\n3 END PGM A INCH\n", job);
  EXPECT_TRUE(fast.has("E-TOL")) << fast.findings();
  const auto slow = rewrite(sagging_machine(), begin + "2400\n3 END PGM A INCH\n", job);
  ASSERT_TRUE(slow.report.complete) << slow.findings();
  EXPECT_NEAR(slow.report.shortest_split_time, slow.report.shortest_split / 101.6, 1e-9);
}

// Behind F AUTO the feed is that of TOOL CALL, not the last F: no piece may be made of a time that is not known.
TEST(BlockTime, AutomaticFeedHasNoKnownTime) {
  RewriteJob job = timed_job(0.060);
  job.setup.profile = embedded_profile("heidenhain");
  const std::string program =
      "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+0 FMAX\n2 L X+1 F100\n3 L X+100 F AUTO\n4 END PGM A MM\n";
  EXPECT_TRUE(rewrite(sagging_machine(), program, job).has("E-TOL"));
  job.block_time = 0;
  EXPECT_TRUE(rewrite(sagging_machine(), program, job).report.complete);
}

/// An arc of 157 mm in 100 ms.
TEST(BlockTime, ArcsAreHeldToo) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 3e-4})}});
  const std::string program = "G0 X50 Y0 Z0\nG3 X-50 Y0 I-50 J0 F94248\nM2\n";
  const auto usual = rewrite(machine, program);
  ASSERT_GT(usual.report.arcs_out, 1U) << usual.findings();
  const auto held = rewrite(machine, program, timed_job(0.060));
  EXPECT_TRUE(held.has("E-TOL") || held.report.held_splits > 0) << held.text;
  EXPECT_LT(held.report.arcs_out, usual.report.arcs_out);
}

}  // namespace
}  // namespace abbe
