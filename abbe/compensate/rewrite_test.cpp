#include "abbe/compensate/rewrite.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <vector>

#include "abbe/compensate/rewrite_fixture.h"

namespace abbe {
namespace {

using testing::plain_job;
using testing::poly;
using testing::rewrite;
using testing::three_axes;

/// The tool stands 10 um too far in +X, 20 um too low, everywhere: the output is X - 0.010, Z + 0.020.
Machine offset_machine() {
  return three_axes({{"EXX", ErrorFunction::constant(0.010)}, {"EZZ", ErrorFunction::constant(-0.020)}});
}
/// X is 1e-4 too long, and straightness bends Z: something varies along every move.
Machine bent_machine() {
  return three_axes(
      {{"EXX", poly(0, {0, 1e-4})}, {"EZX", poly(0, {0, 0, 2e-6})}, {"EYY", poly(1, {0, -5e-5})}});
}

TEST(Rewrite, ZeroErrorsChangeNoByte) {
  const std::string program =
      "%\r\nO1234\r\n(a comment \xE9)\r\nN10 G21 g90 G54\r\nG0 X0 Y0 Z5.\r\nG1 z-1.00 F300\r\nG1X+10.Y1 . "
      "5\r\n"
      "G91 G1 X-.5\r\nG2 X1 I.5\r\nG90\r\n\r\n; rest\r\nM30\r\n%\r\ntail without meaning #1";
  const auto result = rewrite(three_axes({}), program);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, program);
}

TEST(Rewrite, ZeroErrorsLeaveRadiusWordsAlone) {
  const std::string program =
      "G0 X0 Y0 Z5\nG2 X10 Y0 R5 F100\nG3 X0 Y0 R5\nG2 X19.99999 Y0 R10\nG3 X10 Y10 R-8\nM2\n";
  const auto result = rewrite(three_axes({}), program);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, program);
}

TEST(Rewrite, ZeroErrorsLeaveFullCirclesAloneInEveryFrame) {
  const std::string program =
      "G0 X1.222336 Y0.3 Z5\nG2 X1.222336 Y0.3 I-2.828427 J-2.828427 F100\nG3 X1.222336 Y0.3 Z4 I-2.828427 "
      "J-2.828427\n"
      "G91 G2 X0 Y0 I1.1 J0.7\nM2\n";
  for (const std::array<double, 3>& origin :
       {std::array<double, 3>{1, 2, 3}, {1.1, 2.7, 0.3}, {-120.5, 40.123, -210}}) {
    RewriteJob job = plain_job();
    job.setup.work_offsets[0] = WorkOffset{origin, 0};
    const auto result = rewrite(three_axes({}), program, job);
    ASSERT_TRUE(result.report.complete) << result.findings();
    EXPECT_EQ(result.text, program);
  }
}

TEST(Rewrite, CorrectionOpposesTheError) {
  const auto result = rewrite(offset_machine(), "G0 X0 Y0 Z5\nG1 X100 F500\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X-0.0100 Y0 Z5.0200\nG1 X99.9900 F500\nM2\n");
}

TEST(Rewrite, WordsOfAllAxesAreAddedOnlyWhenNeeded) {
  // Z bends along X: 2e-6 * 100^2 = 0.02 at X100, so Z gets a word of its own.
  const auto result =
      rewrite(three_axes({{"EZX", poly(0, {0, 2e-5})}}), "G0 X0 Y0 Z5\nG1 X100 F500 (cut)\nG1 Y10\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X0 Y0 Z5\nG1 X100 F500 Z4.9980 (cut)\nG1 Y10\nM2\n");
}

TEST(Rewrite, NothingIsInventedBeforeAllAxesAreKnown) {  // H19
  const auto result = rewrite(offset_machine(), "G0 X10 Y10\nG0 Z5\nG1 X20 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X10 Y10\nG0 Z5.0200 X9.9900\nG1 X19.9900 F100\nM2\n");
}

TEST(Rewrite, AToolChangeMayHaveMovedEveryAxis) {
  // The control may stand at its place for changing tools: a Z word from before would make the tool dive.
  const auto result = rewrite(offset_machine(), "G0 X0 Y0 Z5\nT1 M6\nG0 X50\nY20 Z30\nG1 X60 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text,
            "G0 X-0.0100 Y0 Z5.0200\nT1 M6\nG0 X50\nY20 Z30.0200 X49.9900\nG1 X59.9900 F100\nM2\n");
  const std::string goes_on = "G0 X0 Y0 Z5\nT1 M6\nG1 X50 F100\nM2\n";
  EXPECT_TRUE(rewrite(offset_machine(), goes_on).has("E-POS"));
  RewriteJob stays = plain_job();
  stays.setup.tool_change_keeps_place = true;
  EXPECT_EQ(rewrite(offset_machine(), goes_on, stays).text,
            "G0 X-0.0100 Y0 Z5.0200\nT1 M6\nG1 X49.9900 F100\nM2\n");
}

TEST(Rewrite, FeedFromAnUnknownPositionIsRefused) {
  const auto result = rewrite(offset_machine(), "G0 X10 Y10\nG1 Z-5 F100\nM2\n");
  EXPECT_FALSE(result.report.complete);
  EXPECT_TRUE(result.has("E-POS")) << result.findings();
}

TEST(Rewrite, MachineCoordinatesAreLeftAlone) {  // H1
  const auto result = rewrite(offset_machine(), "G0 X0 Y0 Z5\nG1 X10 F100\nG53 G0 Z0\nG0 X50\nG0 Z5\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X-0.0100 Y0 Z5.0200\nG1 X9.9900 F100\nG53 G0 Z0\nG0 X49.9900\nG0 Z5.0200\nM2\n");
}

TEST(Rewrite, IncrementsSumToTheCorrectedPosition) {  // H2
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nG91\nG1 X25 F100\nG1 X25\nG1 X-50\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  // X: -25e-4, Z: -2e-6*625 = -0.00125
  EXPECT_NE(result.text.find("G1 X24.9975 F100 Z-0.0012\n"), std::string::npos) << result.text;
  EXPECT_NE(result.text.find("G1 X24.9975 Z-0.0038\n"), std::string::npos) << result.text;
  // 50 mm back bend by 1.25 um: two pieces, which end where the absolute position says
  EXPECT_NE(result.text.find("G1 X-29.9970 Z0.0042\nX-19.9980 Z0.0008\n"), std::string::npos) << result.text;
}

TEST(Rewrite, LongMovesAreSplitWhereTheCorrectionBends) {
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nN10 G1 X200 F500 M8 (move)\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.report.blocks.split, 1u);
  // sagitta 2e-6 h^2 / 4 <= 0.5 um  =>  h <= 31.6 mm
  EXPECT_GE(result.report.lines_out, 3u + 6u);
  EXPECT_LE(result.report.lines_out, 3u + 10u);
  EXPECT_EQ(result.text.substr(result.text.find("N10"), 6), "N10 G1");
  EXPECT_NE(result.text.find("F500 M8"), std::string::npos) << result.text;
  EXPECT_NE(result.text.find("(move)\nX"), std::string::npos) << result.text;
}

TEST(Rewrite, ModalWordsOfASplitBlockSurviveOnce) {  // H3
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nG20 G90 G1 X8 F20\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_GT(result.report.blocks.split, 0u);
  EXPECT_EQ(result.text.find("G20"), result.text.rfind("G20"));
  EXPECT_NE(result.text.find("X7.99920"), std::string::npos) << result.text;  // five decimals in inch
}

TEST(Rewrite, InverseTimeIsSharedByThePieces) {  // H4
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nG93 G1 X200 F2\nG94\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  double time = 0;
  std::size_t at = result.text.find("G93");
  while ((at = result.text.find('F', at)) != std::string::npos)
    time += 1 / std::stod(result.text.substr(++at));
  EXPECT_NEAR(time, 0.5, 1e-4);
}

TEST(Rewrite, StopsComeAfterTheLastPieceAndCoolantBeforeTheFirst) {  // H26
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nG1 X200 F500 M5 M0\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  const std::size_t first = result.text.find('\n', result.text.find("G1"));
  EXPECT_LT(result.text.find("M5"), first);
  EXPECT_GT(result.text.find("M0"), first);
  EXPECT_NE(result.text.find("X199.9800 Z4.9200 M0\n"), std::string::npos) << result.text;
}

TEST(Rewrite, BlockDeleteStandsOnEveryPiece) {  // H13
  RewriteJob job = plain_job();
  job.setup.block_delete = ControlSetup::BlockDelete::off;
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\n/G1 X200 F500\nM2\n", job);
  ASSERT_TRUE(result.report.complete) << result.findings();
  std::size_t slashes = 0;
  for (const char c : result.text) slashes += c == '/' ? 1 : 0;
  EXPECT_EQ(slashes, result.report.lines_out - 2);
}

TEST(Rewrite, BlockDeleteMustBeStated) {
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\n/G1 X200 F500\nM2\n");
  EXPECT_TRUE(result.has("E-SKIP")) << result.findings();
}

TEST(Rewrite, G92KeepsTheFrame) {  // H15
  const auto result = rewrite(offset_machine(), "G0 X10 Y0 Z5\nG92 X0\nG1 X5 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X9.9900 Y0 Z5.0200\nG92 X-0.010000\nG1 X4.9900 F100\nM2\n");
}

TEST(Rewrite, G10L20KeepsTheFrame) {
  const auto result = rewrite(offset_machine(), "G0 X10 Y0 Z5\nG10 L20 P1 X0\nG1 X5 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X9.9900 Y0 Z5.0200\nG10 L20 P1 X-0.010000\nG1 X4.9900 F100\nM2\n");
}

TEST(Rewrite, FullCircleEndsWhereItStarts) {  // H10
  const auto result = rewrite(offset_machine(), "G0 X0 Y0 Z5\nG2 I10 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X-0.0100 Y0 Z5.0200\nG2 I10 F100\nM2\n");
}

TEST(Rewrite, ArcsStayArcs) {
  // squareness makes an ellipse: 50 urad on R50
  const auto result = rewrite(three_axes({{"EC0Y", ErrorFunction::constant(50e-6)}}),
                              "G0 X0 Y0 Z5\nG3 X0 Y0 I50 J0 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.report.arcs_in, 1u);
  EXPECT_GE(result.report.arcs_out, 3u);
  EXPECT_LE(result.report.arcs_out, 6u);
}

TEST(Rewrite, RadiusFormNearAHalfCircleGetsACentre) {  // H11
  const double x = 2 * 20 * std::sin(179.9 / 2 * deg);
  const auto result = rewrite(bent_machine(), "G0 X0 Y0 Z5\nG2 X" + std::to_string(x) + " Y0 R20 F100\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text.find('R'), std::string::npos) << result.text;
  EXPECT_NE(result.text.find('I'), std::string::npos) << result.text;
}

TEST(Rewrite, TinyArcNeverBecomesAFullCircle) {  // H9
  const auto result =
      rewrite(bent_machine(), "G0 X100.00004 Y0 Z5\nG2 X100.00006 Y0 I0.00001 J-10 F100\nG1 X90\nM2\n");
  if (!result.report.complete) return;  // refused is safe too
  EXPECT_EQ(result.text.find("G2 X100.0000 Y0"), std::string::npos) << result.text;
}

TEST(Rewrite, CyclesAreShiftedAsAWhole) {  // H16
  const auto result = rewrite(offset_machine(), "G0 X0 Y0 Z5\nG99 G81 X5 Y5 Z-3 R1 F100\nX9\nG80\nM2\n");
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text,
            "G0 X-0.0100 Y0 Z5.0200\nG99 G81 X4.9900 Y5 Z-2.9800 R1.0200 F100\nX8.9900\nG80\nM2\n");
}

TEST(Rewrite, FrameOfTheBlockHoldsForItsMotion) {  // H27
  RewriteJob job = plain_job();
  job.setup.work_offsets[1] = WorkOffset{{100, 0, 0}, 0};
  const auto result =
      rewrite(three_axes({{"EXX", poly(0, {0, 1e-4})}}), "G0 X10 Y0 Z5\nG0 G55 X10 Y0\nM2\n", job);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X9.9990 Y0 Z5\nG0 G55 X9.9890 Y0\nM2\n");
}

TEST(Rewrite, ProbedDatumIsNotCorrected) {
  RewriteJob job = plain_job();
  job.setup.work_offsets[0] = WorkOffset{{100, 0, 0}, 0};
  job.probed_datum = true;
  const auto result = rewrite(three_axes({{"EXX", poly(0, {0, 1e-4})}}), "G0 X0 Y0 Z5\nG0 X10\nM2\n", job);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_EQ(result.text, "G0 X0 Y0 Z5\nG0 X9.9990\nM2\n");
}

struct Refusal {
  const char* program;
  const char* code;
  std::size_t line, column;
};
class RewriteRefuses : public ::testing::TestWithParam<Refusal> {};

TEST_P(RewriteRefuses, WithPlaceAndReason) {
  const Refusal& refusal = GetParam();
  const auto result = rewrite(bent_machine(), refusal.program);
  EXPECT_FALSE(result.report.complete);
  bool found = false;
  for (const auto& d : result.report.diagnostics) {
    if (d.code != refusal.code) continue;
    found = true;
    EXPECT_EQ(d.place.line, refusal.line);
    EXPECT_EQ(d.place.column, refusal.column);
    EXPECT_FALSE(d.message.empty());
    EXPECT_FALSE(d.why.empty());
    EXPECT_FALSE(d.fix.empty());
    break;
  }
  EXPECT_TRUE(found) << refusal.code << "\n" << result.findings();
}

INSTANTIATE_TEST_SUITE_P(
    Programs, RewriteRefuses,
    ::testing::Values(Refusal{"G0 X0 Y0 Z0\nG1 X30 A90 F10\n", "E-ROTARY", 2, 8},  // H5
                      Refusal{"G0 X0 Y0 Z0\nG1 X30 E5 F10\n", "E-WORD", 2, 8},     // H5
                      Refusal{"G1 A90 F360\n", "E-ROTARY", 1, 4},                  // H6
                      Refusal{"G0 X#100\n", "E-EXPR", 1, 5},                       // H17
                      Refusal{"#100=#5041\n", "E-EXPR", 1, 1},                     // H17
                      Refusal{"G68 X0 Y0 R45\n", "E-FRAME", 1, 1},                 // H18
                      Refusal{"G77 X1\n", "E-GCODE", 1, 1},                        // H18
                      Refusal{"G0 X0 Y0 Z0\nG41 D1\n", "E-CUTCOM", 2, 1},          // H25
                      Refusal{"M98 P100\n", "E-MCODE", 1, 1},                      // H29
                      Refusal{"G0 X0\no100 call\n", "E-OWORD", 2, 1},
                      Refusal{"G0 X0\nO100\n", "E-OWORD", 2, 1}, Refusal{"G0 X1 X2\n", "E-BLOCK", 1, 7},
                      Refusal{"G0 G1 X2\n", "E-BLOCK", 1, 4}, Refusal{"X2\n", "E-MODE", 1, 1},
                      Refusal{"G0 X1 H3\n", "E-WORD", 1, 7}, Refusal{"G55 G0 X1\n", "E-WCS", 1, 1},
                      Refusal{"G43 H7\n", "E-TOOL", 1, 1}, Refusal{"G0 X0 Y0 Z0\nG2 X10\n", "E-ARC", 2, 1},
                      Refusal{"G0 X0 Y0 Z0\nG2 X10 Y0 I4\n", "E-ARC", 2, 1},
                      Refusal{"G0 X0 Y0 Z0\nG1 X10 F0\n", "E-FEED", 2, 1},
                      Refusal{"F0\nG0 X0 Y0 Z0\nG2 X10 Y0 I5\n", "E-FEED", 3, 1},
                      Refusal{"G0 X0 Y0 Z5\nG81 X10 Y0 R2 Z-3 F0\n", "E-FEED", 2, 1},
                      Refusal{"G0 X0 (open\n", "E-COMMENT", 1, 7}, Refusal{"G0 X0 \x01\n", "E-CHAR", 1, 7},
                      Refusal{"G0 X\n", "E-NUMBER", 1, 4},
                      Refusal{"(ABBE COMPENSATED)\nG0 X0\n", "E-COMPENSATED", 1, 2},  // H22
                      Refusal{"G92.3\n", "E-G92", 1, 1}, Refusal{"G92 X0\n", "E-POS", 1, 5}));

TEST(Rewrite, ArcFromAnUnknownPositionIsRefused) {
  const auto result = rewrite(three_axes({}), "G2 X10 Y0 I5 J0 F100\nM2\n");
  EXPECT_FALSE(result.report.complete);
  EXPECT_TRUE(result.has("E-POS")) << result.findings();
}

TEST(Rewrite, ARefusedMoveStillMoves) {
  Machine machine = bent_machine();
  machine.bodies[0].range = {{-10, 50}};
  const auto result = rewrite(machine, "G0 X0 Y0 Z0\nG1 X60 F100\nG3 X40 Y20 I-20 J0\nM2\n");
  EXPECT_TRUE(result.has("E-TRAVEL")) << result.findings();
  EXPECT_FALSE(result.has("E-ARC")) << "its centre counts from X60\n" << result.findings();
}

TEST(Rewrite, EveryRefusalIsListed) {
  const auto result = rewrite(bent_machine(), "G0 X0 A1\nG68\nG0 X#1\n");
  EXPECT_TRUE(result.has("E-ROTARY"));
  EXPECT_TRUE(result.has("E-FRAME"));
  EXPECT_TRUE(result.has("E-EXPR"));
}

TEST(Rewrite, TravelAndVolumeAreRefused) {  // H21
  Machine machine = bent_machine();
  machine.bodies[0].range = {{-10, 50}};
  const auto travel = rewrite(machine, "G0 X60 Y0 Z0\nM2\n");
  EXPECT_TRUE(travel.has("E-TRAVEL")) << travel.findings();
  EXPECT_TRUE(travel.report.out_of_volume);
  const auto table = ErrorFunction::table(0, {0, 50}, {0, 1e-3}, ErrorFunction::Interpolation::linear);
  const auto volume = rewrite(three_axes({{"EXX", *table}}), "G0 X60 Y0 Z0\nM2\n");
  EXPECT_TRUE(volume.has("E-VOL")) << volume.findings();
}

TEST(Rewrite, ACorrectionBeyondTheTravelIsRefusedNotCut) {
  Machine machine = offset_machine();  // wants X - 0.010
  machine.bodies[0].range = {{0, 50}};
  const auto result = rewrite(machine, "G0 X0 Y0 Z0\nM2\n");
  EXPECT_FALSE(result.report.complete) << result.text;
  EXPECT_TRUE(result.has("E-TRAVEL")) << result.findings();
}

TEST(Rewrite, LargeCorrectionsAndGradientsAreRefused) {
  EXPECT_TRUE(
      rewrite(three_axes({{"EXX", ErrorFunction::constant(0.6)}}), "G0 X0 Y0 Z0\nM2\n").has("E-CORRECTION"));
  EXPECT_TRUE(
      rewrite(three_axes({{"EXX", poly(0, {0, 2e-3})}}), "G0 X0 Y0 Z0\nG1 X100 F1\nM2\n").has("E-GRADIENT"));
}

TEST(Rewrite, LostMotionIsTakenUpWhereAnAxisTurnsRound) {
  RewriteJob job = plain_job();
  job.reversal = true;
  const auto machine = three_axes({{"EXX", ErrorFunction::directional(0, ErrorFunction::constant(0.005),
                                                                      ErrorFunction::constant(-0.005))}});
  const auto result = rewrite(machine, "G0 X0 Y0 Z5\nG1 X10 F100\nG1 X0\nM2\n", job);
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_NE(result.text.find("G1 X-0.0050 F100\nX9.9950\nG1 X10.0050\nX0.0050\n"), std::string::npos)
      << result.text;
}

/// X gets 5 um too far on its way up and too little on its way down, Z 4 um.
Machine play_machine() {
  const auto both = [](int k, double half) {
    return ErrorFunction::directional(k, ErrorFunction::constant(half), ErrorFunction::constant(-half));
  };
  return three_axes({{"EXX", both(0, 0.005)}, {"EZZ", both(2, 0.004)}});
}
RewriteJob reversal_job() {
  RewriteJob job = plain_job();
  job.reversal = true;
  return job;
}

TEST(Rewrite, LostMotionIsTakenUpWhereAnAxisTurnsRoundOnAnArc) {
  // counter-clockwise from the left: X + until it turns on the right, then - until the end
  const auto result =
      rewrite(play_machine(), "G0 X0 Y0 Z5\nG1 X10 F100\nG3 X30 Y0 I10 J0 M8\nG3 X20 Y10 I-10 J0\nM2\n",
              reversal_job());
  ASSERT_TRUE(result.report.complete) << result.findings();
  // the quarter from the right begins with X having turned: 29.995 -> 30.005 before the arc
  EXPECT_NE(result.text.find("G1 X-0.0050 F100\nX9.9950\nG3 X29.9950 Y0 I10 J0 M8\nG1 X30.0050 Y0.0000\nG3 "
                             "X20.0050 Y10.0000 I-10.0000\nM2"),
            std::string::npos)
      << result.text;
}

TEST(Rewrite, AFullCircleTakesUpAtEveryQuarterWhereItTurns) {
  const auto result = rewrite(play_machine(), "G0 X0 Y0 Z5\nG1 X10 F100\nN7 G2 I10 J0 (circle)\nG1 X20\nM2\n",
                              reversal_job());
  ASSERT_TRUE(result.report.complete) << result.findings();
  // X turns once, on the right; on the left it goes on as it came and turns in the end only
  EXPECT_NE(result.text.find("X9.9950\nN7 G2 I10 J0 X29.9950 (circle)\nG1 X30.0050\nG2 X10.0050 "
                             "I-10.0000\nG1 X9.9950\nX19.9950\n"),
            std::string::npos)
      << result.text;
}

TEST(Rewrite, AnArcOutOfALineTakesUpFirst) {
  // X has come upwards and goes on downwards: the arc's own block becomes the straight move
  const auto result =
      rewrite(play_machine(), "G0 X0 Y0 Z5\nG1 X10 F100\nG3X0Y10I-10J0F50\nM2\n", reversal_job());
  ASSERT_TRUE(result.report.complete) << result.findings();
  EXPECT_NE(result.text.find("X9.9950\nG1X10.0050Y0.0000F50\nG3 X0.0050 Y10.0000 I-10.0000\n"),
            std::string::npos)
      << result.text;
  EXPECT_EQ(result.text.find('R'), std::string::npos);
}

TEST(Rewrite, ArcsWithoutReversalStayAsTheyAre) {
  Machine machine = play_machine();
  const auto mean = rewrite(machine, "G0 X0 Y0 Z5\nG3 X0 Y0 I10 J0 F100\nM2\n");
  EXPECT_EQ(mean.text, "G0 X0 Y0 Z5\nG3 X0 Y0 I10 J0 F100\nM2\n");
  // a lost motion of 0.2 um does not deserve a block
  machine.errors[0].function =
      ErrorFunction::directional(0, ErrorFunction::constant(1e-4), ErrorFunction::constant(-1e-4));
  const auto small = rewrite(machine, "G0 X0 Y0 Z5\nG3 X0 Y0 I10 J0 F100\nM2\n", reversal_job());
  EXPECT_EQ(small.report.lines_out, 3u) << small.text;
}

TEST(Rewrite, LostMotionThatCannotBeTakenUpIsRefused) {
  const auto inverse_time =
      rewrite(play_machine(), "G0 X0 Y0 Z5\nG93 G3 X0 Y0 I10 J0 F2\nM2\n", reversal_job());
  EXPECT_TRUE(inverse_time.has("E-REVERSAL")) << inverse_time.findings();
  const auto tiny = rewrite(play_machine(), "G0 X0 Y0 Z5\nG3 X0 Y0 I0.02 J0 F2\nM2\n", reversal_job());
  EXPECT_TRUE(tiny.has("E-REVERSAL")) << tiny.findings();
}

TEST(Rewrite, HolesAreCorrectedForTheWayTheToolComes) {
  const auto result =
      rewrite(play_machine(), "G0 X0 Y0 Z20\nG0 X1 Z30\nG98 G81 X10 Y10 Z-5 R5 F9\nX-10\nG80\nG0 X-20\nM2\n",
              reversal_job());
  ASSERT_TRUE(result.report.complete) << result.findings();
  // Z up to 30: 4 um too high. Down into the hole: it stays 4 um too high. X by its way.
  EXPECT_NE(result.text.find(
                "G0 X0.9950 Z29.9960\nG98 G81 X9.9950 Y10 Z-4.9960 R5.0040 F9\nX-9.9950\nG80\nG0 X-19.9950"),
            std::string::npos)
      << result.text;
}

/// Z going up carries the drill aside by 0.6 um: nothing the cut sees, but the hole on the way out.
TEST(Rewrite, TheWayOutOfAHoleIsInWhatRemainsInside) {
  const Machine machine = three_axes({{"EXZ", ErrorFunction::directional(2, ErrorFunction::constant(0.0003),
                                                                         ErrorFunction::constant(-0.0003))}});
  const std::string program = "G0 X0 Y0 Z20\nG81 X10 Y10 Z-5 R5 F9\nG80\nM2\n";
  const auto followed = rewrite(machine, program, reversal_job());
  ASSERT_TRUE(followed.report.complete) << followed.findings();
  EXPECT_NEAR(followed.report.cycle_residual, 0.6 * um, 1e-6 * um);
  EXPECT_NEAR(rewrite(machine, program).report.cycle_residual, 0, 1e-6 * um);
}

TEST(Rewrite, ACycleBesideAnUncorrectedAxisIsRefused) {
  const std::string start = "G0 X0 Y0 Z5\nG53 G0 X10\n", hole = "G81 Y5 Z-3 R1 F100\nG80\nM2\n";
  EXPECT_TRUE(rewrite(offset_machine(), start + hole).has("E-POS"));
  EXPECT_TRUE(rewrite(offset_machine(), start + "G0 X11\n" + hole).report.complete);
}

TEST(Rewrite, ARefusedCycleIsSaidOnce) {
  const auto result =
      rewrite(offset_machine(), "G0 X0 Y0 Z5\nG81 X5 Y5 Z-3 F100\nX9\nX12\nG80\nG81 X5 R1 F100\nX9\nM2\n");
  std::vector<std::size_t> lines;
  for (const auto& d : result.report.diagnostics) lines.push_back(d.place.line);
  EXPECT_EQ(lines, (std::vector<std::size_t>{2, 6})) << result.findings();
}

TEST(Rewrite, AnAxisThatMayNotBeCorrectedIsNotMoved) {
  Machine machine = three_axes({{"EXX", poly(0, {0.01})}});
  machine.bodies[2].correctable = false;
  const auto result = rewrite(machine, "G21 G90\nG0 X0 Y0 Z0\nM2\n");
  EXPECT_TRUE(result.has("E-MACHINE")) << result.findings();
  EXPECT_FALSE(result.report.complete);
}

TEST(Rewrite, NoByteBehindTheEndIsLost) {
  const std::string program = "G0 X0 Y0 Z0\nM2\n";
  for (const std::size_t length : {1000U, 60000U}) {
    const std::string behind = "(" + std::string(length, 'x') + "\n";
    EXPECT_EQ(rewrite(three_axes({}), program + behind, plain_job()).text, program + behind);
  }
  // longer than what is read of a line
  EXPECT_TRUE(rewrite(three_axes({}), program + std::string(70000, 'x'), plain_job()).has("E-LINELEN"));
}

TEST(Sensitivity, ToAnOffsetIsTheSlopeOfTheError) {
  const Machine machine = three_axes({{"EXX", poly(0, {0, 1e-4})}});
  const std::string program = "G0 X0 Y0 Z0\nG0 X100\nM2\n";
  RewriteJob job = plain_job();
  const auto ideal = rewrite(machine, program, job);
  ASSERT_TRUE(ideal.report.sensitivity) << ideal.findings();
  EXPECT_NEAR(ideal.report.sensitivity->offset, 1e-4, 1e-7);
  EXPECT_NEAR(ideal.report.sensitivity->length, 0, 1e-12);
  job.probed_datum = true;
  const auto probed = rewrite(machine, program, job);
  ASSERT_TRUE(probed.report.sensitivity);
  EXPECT_NEAR(probed.report.sensitivity->offset, 0, 1e-7) << "the datum moves along";
}

// The carriage turns about Y by 1 urad per mm of X: 100 urad where the correction is largest.
TEST(Sensitivity, ToALengthIsTheAngleOfTheTool) {
  const auto result =
      rewrite(three_axes({{"EBX", poly(0, {0, 1e-6})}}), "G0 X0 Y0 Z0\nG0 X100\nM2\n", plain_job());
  ASSERT_TRUE(result.report.sensitivity) << result.findings();
  EXPECT_NEAR(result.report.sensitivity->length, 1e-4, 1e-6);
}

}  // namespace
}  // namespace abbe
