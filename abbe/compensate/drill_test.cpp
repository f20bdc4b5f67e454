// --expand-drill: cycles whose correction changes inside the hole, as G0, G1 and G4.
#include <gtest/gtest.h>

#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

using testing::plain_job;
using testing::poly;
using testing::rewrite;
using testing::three_axes;

/// Z leans by 0.2 mm per m in X: at depth z the output stands at X - 2e-4 z.
Machine leaning_machine() { return three_axes({{"EXZ", poly(2, {0, 2e-4})}}); }

RewriteJob expanding(const char* control = "linuxcnc") {
  RewriteJob job = plain_job();
  job.expand_drill = true;
  job.setup.profile = embedded_profile(control);
  return job;
}

TEST(ExpandDrill, NeverUnlessAsked) {
  const auto result = rewrite(leaning_machine(), "G0 X0 Y0 Z10\nG99 G81 X5 Y5 Z-30 R2 F100\nG80\nM2\n");
  EXPECT_TRUE(result.has("E-CYCLE")) << result.findings();
  EXPECT_NE(result.findings().find("--expand-drill"), std::string::npos);
}

TEST(ExpandDrill, WritesTheMotionsOfTheCycle) {
  const auto result =
      rewrite(leaning_machine(), "G0 X0 Y0 Z10\nN5 G99 G81 X5 Y5 Z-30. R2 F100 (hole)\nX9\nG80\nG0 Z10\nM2\n",
              expanding());
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text,
            "G0 X-0.0020 Y0 Z10\n"
            "N5 G99 G0 X4.9980 Y5 F100 (hole)\n"
            "G0 X4.9996 Z2.0000\n"
            "G1 X5.0060 Z-30.0000\n"
            "G4 P0\n"
            "G0 X4.9996 Z2.0000\n"
            "X8.9996\n"
            "G1 X9.0060 Z-30.0000\n"
            "G4 P0\n"
            "G0 X8.9996 Z2.0000\n"
            "G80\n"
            "G0 Z10 X8.9980\n"
            "M2\n");
  EXPECT_EQ(result.report.expanded_holes, 2U);
  EXPECT_EQ(result.report.cycle_residual, 0);
  EXPECT_EQ(result.report.lines_out, 13U);
}

TEST(ExpandDrill, ShallowHolesStayCycles) {
  const auto result = rewrite(
      leaning_machine(), "G0 X0 Y0 Z10\nG98 G81 X5 Y5 Z-1 R2 F100\nX9 Z-30\nX10 Z-1\nG80\nM2\n", expanding());
  ASSERT_TRUE(result.report.complete) << result.findings();
  // once the sequence is left, later holes of it are written out, too
  EXPECT_EQ(result.text,
            "G0 X-0.0020 Y0 Z10\n"
            "G98 G81 X4.9999 Y5 Z-1 R2 F100\n"
            "X8.9980 G0\n"
            "G0 X8.9996 Z2.0000\nG1 X9.0060 Z-30.0000\nG4 P0\nG0 X8.9996 Z2.0000\nG0 X8.9980 Z10.0000\n"
            "X9.9980\n"
            "G0 X9.9996 Z2.0000\nG1 X10.0002 Z-1.0000\nG4 P0\nG0 X9.9996 Z2.0000\nG0 X9.9980 Z10.0000\n"
            "G80\nM2\n");
  EXPECT_EQ(result.report.expanded_holes, 2U);
}

TEST(ExpandDrill, DwellsAsTheCycleDoesAndRepeatsInIncrements) {  // H16
  const auto result = rewrite(leaning_machine(),
                              "G0 X0 Y0 Z10\nG91 G98 G82 X5 Z-32 R-8 P0.50 F100 L2\nG80\nM2\n", expanding());
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text,
            "G0 X-0.0020 Y0 Z10\n"
            "G91 G98 G0 X5 F100\n"
            "G0 X0.0016 Z-8.0000\nG1 X0.0064 Z-32.0000\nG4 P0.50\nG0 X-0.0064 Z32.0000\nG0 X-0.0016 Z8.0000\n"
            "G0 X5.0000\n"
            "G0 X0.0016 Z-8.0000\nG1 X0.0064 Z-32.0000\nG4 P0.50\nG0 X-0.0064 Z32.0000\nG0 X-0.0016 Z8.0000\n"
            "G80\nM2\n");
}

/// In G90 a count drills the same hole again.
TEST(ExpandDrill, TheSameHoleTwiceIsDrilledTwice) {
  const auto result =
      rewrite(leaning_machine(), "G0 X0 Y0 Z2\nG99 G81 X5 Y5 Z-30 R2 F100 L2\nG80\nM2\n", expanding());
  ASSERT_TRUE(result.report.complete) << result.findings();
  const std::string hole = "G1 X5.0060 Z-30.0000\nG4 P0\nG0 X4.9996 Z2.0000\n";
  EXPECT_EQ(result.text, "G0 X-0.0004 Y0 Z2\nG99 G0 X4.9996 Y5 F100\n" + hole + hole + "G80\nM2\n");
}

TEST(ExpandDrill, FanucStopsExactlyAndKeepsWhatComesLast) {
  const auto result =
      rewrite(leaning_machine(),
              "G21 G90 G54\nG0 X0. Y0. Z10.\n/2 G99 G81 X5. Y5. Z-30. R2. F100 M8 M9\nG80\nM30\n", [] {
                RewriteJob job = expanding("fanuc");
                job.setup.block_delete = ControlSetup::BlockDelete::off;
                return job;
              }());
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_NE(result.text.find("/2 G99 G0 X4.998 Y5. F100 M8\n"
                             "/2 G0 X5.000 Z2.000\n"
                             "/2 G9 G1 X5.006 Z-30.000\n"
                             "/2 G0 X5.000 Z2.000 M9\n"),
            std::string::npos)
      << result.text;
}

/// A correction that bends along the hole: in pieces, and out again the same way.
TEST(ExpandDrill, BentHolesGoInPiecesAndComeOutTheSameWay) {
  const auto result = rewrite(three_axes({{"EYZ", poly(2, {0, 0, 1e-5})}}),
                              "G0 X0 Y0 Z2\nG99 G81 X5 Y5 Z-30 R2 F100\nG80\nM2\n", expanding());
  ASSERT_TRUE(result.report.complete) << result.findings();
  std::vector<std::string> down, up;
  for (std::size_t at = 0; at < result.text.size();) {
    const std::size_t end = result.text.find('\n', at);
    const std::string line = result.text.substr(at, end - at);
    if (line.rfind("G1 ", 0) == 0) down.push_back(line.substr(3));
    if (line.rfind("G0 Y", 0) == 0) up.push_back(line.substr(3));
    at = end + 1;
  }
  ASSERT_GE(down.size(), 2U) << result.text;
  ASSERT_EQ(up.size(), down.size()) << result.text;
  for (std::size_t i = 0; i + 1 < down.size(); ++i) EXPECT_EQ(down[i], up[down.size() - 2 - i]);
  EXPECT_EQ(result.text.find("G80"), result.text.rfind("Z2.0000\n") + 8) << result.text;
}

/// The pieces of the way down keep the least time of a block: 32 mm at F100 last 19 s.
TEST(ExpandDrill, ItsPiecesLastAsLongAsBlocksMust) {
  RewriteJob job = expanding();
  job.block_time = 15;
  const auto result = rewrite(three_axes({{"EYZ", poly(2, {0, 0, 1e-5})}}),
                              "G0 X0 Y0 Z2\nG99 G81 X5 Y5 Z-30 R2 F100\nG80\nM2\n", job);
  EXPECT_FALSE(result.report.complete) << result.text;
  EXPECT_NE(result.findings().find("E-TOL"), std::string::npos) << result.findings();
}

TEST(ExpandDrill, OtherCyclesAndStatesAreRefused) {
  const std::string start = "G0 X0 Y0 Z10\n";
  for (const char* cycle :
       {"G73 X5 Y5 Z-30 R2 Q3 F100", "G83 X5 Y5 Z-30 R2 Q3 F100", "G84 X5 Y5 Z-30 R2 F100",
        "G85 X5 Y5 Z-30 R2 F100", "G89 X5 Y5 Z-30 R2 P1 F100"}) {
    const auto result = rewrite(leaning_machine(), start + cycle + "\nG80\nM2\n", expanding());
    EXPECT_TRUE(result.has("E-CYCLE")) << cycle << result.findings();
    EXPECT_EQ(result.findings().find("--expand-drill"), std::string::npos);
  }
  const auto below =
      rewrite(leaning_machine(), "G0 X0 Y0 Z1\nG81 X5 Y5 Z-30 R2 F100\nG80\nM2\n", expanding());
  EXPECT_NE(below.findings().find("below its R level"), std::string::npos) << below.findings();
  // G99 has left the drill at R: G83 would take that for its initial level
  const auto mixed = rewrite(
      leaning_machine(), start + "G99 G81 X5 Y5 Z-30 R2 F100\nG98 G83 X9 Z-1 R2 Q1\nG80\nM2\n", expanding());
  EXPECT_TRUE(mixed.has("E-CYCLE")) << mixed.findings();
  // of a profile that does not say that both P mean the same
  auto profile = std::make_shared<Profile>(*embedded_profile("linuxcnc"));
  profile->cycles.dwell_as_g4 = false;
  RewriteJob job = expanding();
  job.setup.profile = profile;
  const auto dwell = rewrite(leaning_machine(), start + "G82 X5 Y5 Z-30 R2 P1 F100\nG80\nM2\n", job);
  EXPECT_TRUE(dwell.has("E-CYCLE")) << dwell.findings();
}

}  // namespace
}  // namespace abbe
