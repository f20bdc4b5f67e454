#include "abbe/cl/rewrite_cl.h"

#include <Eigen/Geometry>

#include "abbe/cl/record.h"
#include "abbe/cl/test_cl_files.h"

namespace abbe::cl {
namespace {

constexpr double kDigit = 0.6e-5;  // mm: half of the fifth decimal, and rounding

/// The numbers of the n-th record with this major word.
std::vector<double> numbers_of(const std::string& text, const std::string& major, std::size_t n = 0) {
  RecordReader reader;
  std::istringstream lines(text);
  std::string line;
  for (std::uint64_t number = 1; std::getline(lines, line); ++number) {
    if (reader.add(line + "\n", number) != RecordReader::State::complete || reader.record().major != major ||
        n-- > 0)
      continue;
    std::vector<double> numbers;
    for (const Item& item : reader.record().items) numbers.push_back(item.value);
    return numbers;
  }
  return {};
}

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

// tip = (x + a x, y + b x, z) shall be p: x = p_x / (1 + a), y = p_y - b x
void expect_inverted(const std::vector<double>& written, const Vec3& p) {
  ASSERT_GE(written.size(), 3U);
  const double x = p.x() / (1 + kScale);
  EXPECT_NEAR(written[0], x, kDigit);
  EXPECT_NEAR(written[1], p.y() - kShear * x, kDigit);
  EXPECT_NEAR(written[2], p.z(), kDigit);
}

TEST(RewriteCl, TipsAreInvertedAsOnPaper) {
  const ClRun run = run_cl(
      plan_of(kThreeAxes),
      "UNITS/MM\nFROM/10,0,50\nRAPID\nGOTO/100,20,5\nFEDRAT/100,MMPM\nGOTO/100,20,0\nGODLTA/-50,5,0\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  expect_inverted(numbers_of(run.output, "FROM"), {10, 0, 50});
  expect_inverted(numbers_of(run.output, "GOTO"), {100, 20, 5});
  expect_inverted(numbers_of(run.output, "GOTO", 1), {100, 20, 0});
  const auto step = numbers_of(run.output, "GODLTA"), before = numbers_of(run.output, "GOTO", 1);
  expect_inverted({before[0] + step[0], before[1] + step[1], before[2] + step[2]}, {50, 25, 0});
}

TEST(RewriteCl, IncrementsDoNotDrift) {
  std::string text = "UNITS/MM\nGOTO/0,0,0\n";
  for (int i = 0; i < 1000; ++i) text += "GODLTA/0.1,0.01,0\n";
  const ClRun run = run_cl(plan_of(kThreeAxes), text + "FINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  Vec3 at = Vec3::Zero();
  RecordReader reader;
  std::istringstream lines(run.output);
  std::string line;
  while (std::getline(lines, line)) {
    if (reader.add(line + "\n", 1) != RecordReader::State::complete || reader.record().major != "GODLTA")
      continue;
    for (int k = 0; k < 3; ++k) at[k] += reader.record().items[static_cast<std::size_t>(k)].value;
  }
  EXPECT_NEAR(at.x(), 100 / (1 + kScale), kDigit);
  EXPECT_NEAR(at.y(), 10 - kShear * 100 / (1 + kScale), kDigit);
}

TEST(RewriteCl, InchesAndLiteralFramesAreFollowed) {
  const ClRun inches = run_cl(plan_of(kThreeAxes), "UNITS/INCHES\nGOTO/4.0,1.0,0.5\nFINI\n");
  ASSERT_TRUE(inches.verify.agrees) << inches.findings();
  const auto written = numbers_of(inches.output, "GOTO");
  expect_inverted({written[0] * 25.4, written[1] * 25.4, written[2] * 25.4}, Vec3(4, 1, 0.5) * 25.4);

  const ClRun moved =
      run_cl(plan_of(kThreeAxes), "UNITS/MM\nTRANS/100,10,0\nORIGIN/20,0,-5\nGOTO/10,10,0\nFINI\n");
  ASSERT_TRUE(moved.verify.agrees) << moved.findings();
  const auto shifted = numbers_of(moved.output, "GOTO");
  expect_inverted({shifted[0] + 80, shifted[1] + 10, shifted[2] + 5}, {90, 20, 5});
}

TEST(RewriteCl, ASecondAxisSystemStandsToTheFirst) {
  // its X is the first one's Y: a point (u, v) of it is (40 - v, 10 + u)
  const ClRun run = run_cl(
      plan_of(kThreeAxes),
      "UNITS/MM\nMSYS/5,5,0,1,0,0,0,1,0\nGOTO/0,0,10\nMSYS/45,15,0,0,1,0,-1,0,0\nGOTO/30,-60,10\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_TRUE(run.warns("W-FRAME"));
  const auto written = numbers_of(run.output, "GOTO", 1);
  expect_inverted({40 - written[1], 10 + written[0], written[2]}, {100, 40, 10});
}

TEST(RewriteCl, TheWorkOffsetPlacesThePart) {
  Options options;
  options.g54 = WorkOffset{{200, 30, -100}, 0};
  const ClRun run = run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/100,20,5\nFINI\n", options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  const auto written = numbers_of(run.output, "GOTO");
  expect_inverted({written[0] + 200, written[1] + 30, written[2] - 100}, {300, 50, -95});
}

TEST(RewriteCl, AProbedDatumTakesItsOwnDeviationOff) {
  Options options;
  options.g54 = WorkOffset{{200, 0, 0}, 0};
  options.probed = true;
  const ClRun run = run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/0,0,0\nGOTO/100,0,0\nFINI\n", options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_NEAR(numbers_of(run.output, "GOTO")[0], 0, kDigit);
  // 300 + e(300) - e(200) = 300 + a 100
  EXPECT_NEAR(numbers_of(run.output, "GOTO", 1)[0], 100 - kScale * 100, 2 * kDigit);
  ASSERT_FALSE(run.verify.datums.empty());
  EXPECT_NEAR(run.verify.datums.front().removed.x(), 200 * kScale, 1e-9);
}

// 1 mm where the tip is off by 100 sqrt(a^2 + b^2), 99 mm where it is not off at all; the places of the first
// are equally bad, and what rounding makes of them decides nothing.
TEST(VerifyCl, TheRmsCountsThePathAndTheFirstWorstPlaceIsNamed) {
  const ClRun run = run_cl(plan_of(kThreeAxes),
                           "UNITS/MM\nFEDRAT/100,MMPM\nRAPID\nGOTO/100,0,0\nGOTO/100,0.4,0\nGOTO/100,0.7,0\n"
                           "GOTO/100,1,0\nRAPID\nGOTO/0,0,0\nGOTO/0,99,0\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  const double off = 100 * std::hypot(kScale, kShear);
  EXPECT_NEAR(run.verify.before.max, off, 1e-3 * off);
  EXPECT_NEAR(run.verify.before.rms, off / 10, 1e-3 * off);
  EXPECT_EQ(run.verify.before.max_line, 5U);
  EXPECT_NEAR(run.verify.before.max_component[1], 100 * kShear, 1e-3 * off);
}

TEST(RewriteCl, ZeroErrorsChangeNoByte) {
  const std::string text =
      "PARTNO/X\r\nUNITS / MM\r\nGOTO / 1.,2.500,  .3 $$ "
      "remark\r\nRAPID\r\nGOTO/10,0,0\r\nCIRCLE/0,0,0,0,0,1,10.0\r\nGOTO/0,10,0\r\n"
      "CIRCLE/0,0,0,0,0,-1\r\nGOTO/0,10,0\r\nGODLTA/1,1,$\r\n "
      "1\r\nCYCLE/DRILL,FEDTO,5,RAPTO,2,MMPM,100\r\nGOTO/5,5,0\r\nCYCLE/OFF\r\nINSERT G4\r\nFINI";
  const ClRun run = run_cl(plan_of(kPerfect), text);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_EQ(run.output, text);
  EXPECT_TRUE(run.warns("W-INSERT"));
}

TEST(RewriteCl, ZeroErrorsChangeNoByteOfFiveAxes) {
  const std::string text =
      "UNITS/MM\nMULTAX/ON\nGOTO/10,20,30,0.1,0.5,0.8602325\nGOTO/60,20,0,0.3,0.5,0.8124\nGOTO/61,20,0\nGOTO/"
      "61,20,0,-0.3,0.5,0.8124\nMULTAX/OFF\nGOTO/0,0,0,0,0,1\nFINI\n";
  const ClRun run = run_cl(plan_of(five_axes("")), text);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_EQ(run.output, text);
}

// A tilted table: the tool axis written is turned back by the error, the tip follows.
TEST(RewriteCl, ToolAxesAreTurnedBack) {
  std::string machine = five_axes("[errors]\nEA0A = 100\n");
  machine.insert(machine.find("[axis.A]\n") + 9, "errors_seen = \"body\"\n");
  const Plan plan = plan_of(machine);
  const std::string text = "UNITS/MM\nMULTAX/ON\nGOTO/10,20,30,0,0.5,0.8660254\nFINI\n";
  Options options;
  options.start[1] = 30 * deg;
  const ClRun run = run_cl(plan, text, options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_GT(run.verify.direction_before, 50 * urad);
  EXPECT_LT(run.verify.direction_after, 0.1 * urad);
  const auto written = numbers_of(run.output, "GOTO");
  const double turn = std::atan2(written[4], written[5]) - std::atan2(0.5, 0.8660254);
  EXPECT_NEAR(std::abs(turn), 100 * urad, 0.1 * urad);
  // Kept: the same axis, another tip, that is right as well.
  options.conventions.axis_rule = AxisRule::keep;
  const ClRun kept = run_cl(plan, text, options);
  ASSERT_TRUE(kept.verify.agrees) << kept.findings();
  EXPECT_EQ(numbers_of(kept.output, "GOTO")[4], 0.5);
  EXPECT_GT(kept.verify.direction_after, 50 * urad);
}

TEST(RewriteCl, TurningMotionsAreSplitWhereTheCorrectionBends) {
  Options options;
  options.start[1] = 30 * deg;
  const ClRun run = run_cl(plan_of(five_axes_with_errors()),
                           "UNITS/MM\nMULTAX/ON\nGOTO/160,120,-10,0.3,0.5,0.8124038 $$ "
                           "here\nGOTO/160,120,-10,0.5,-0.5,0.7071068 $$ there\nFINI\n",
                           options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_EQ(run.rewrite.blocks.split, 1U);
  EXPECT_GT(count_of(run.output, "GOTO"), 4U);
  EXPECT_EQ(count_of(run.output, "$$ there"), 1U);
  EXPECT_LT(run.verify.after.max, run.verify.allowed);
  EXPECT_GT(run.verify.before.max, 10 * um);
}

TEST(RewriteCl, RapidsAreNeverSplit) {
  Options options;
  options.start[1] = 30 * deg;
  const ClRun run = run_cl(plan_of(five_axes_with_errors()),
                           "UNITS/MM\nMULTAX/ON\nGOTO/160,120,-10,0.3,0.5,0.8124038\nRAPID\nGOTO/"
                           "160,120,-10,0.5,-0.5,0.7071068\nFINI\n",
                           options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_EQ(count_of(run.output, "GOTO"), 2U);
}

TEST(RewriteCl, NearTheSingularityTheAxisIsKept) {
  const ClRun run =
      run_cl(plan_of(five_axes_with_errors()), "UNITS/MM\nMULTAX/ON\nGOTO/10,20,30,0,0,1\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_TRUE(run.warns("W-SINGULAR"));
  EXPECT_EQ(numbers_of(run.output, "GOTO")[5], 1);
  EXPECT_NE(numbers_of(run.output, "GOTO")[0], 10);
}

TEST(RewriteCl, ArcsStayArcs) {
  const ClRun run = run_cl(plan_of(kThreeAxes),
                           "UNITS/MM\nGOTO/20,0,0\nFEDRAT/100,MMPM\nCIRCLE/0,0,0,0,0,1,20.0000\nGOTO/"
                           "0,20,0\nCIRCLE/0,0,0,0,0,1,20.0000\nGOTO/0,20,0\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_EQ(run.rewrite.arcs_in, 2U);
  EXPECT_GE(run.rewrite.arcs_out, 2U);
  EXPECT_LT(run.rewrite.arcs_out, 20U);
  EXPECT_LT(run.verify.after.max, run.verify.allowed);
}

TEST(RewriteCl, AWholeTurnEndsWhereItBegins) {
  const ClRun run = run_cl(plan_of(five_axes_with_errors()),
                           "UNITS/MM\nGOTO/10,0,0\nFEDRAT/100,MMPM\nCIRCLE/0,0,0,0,0,1\nGOTO/10,0,0\nFINI\n");
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  const auto first = numbers_of(run.output, "GOTO"),
             last = numbers_of(run.output, "GOTO", count_of(run.output, "GOTO") - 1);
  EXPECT_EQ(first, last);
}

TEST(RewriteCl, ATiltedHoleIsMovedAsAWhole) {
  Options options;
  options.start[1] = 30 * deg;
  const ClRun run =
      run_cl(plan_of(five_axes_with_errors()),
             "UNITS/MM\nRAPID\nGOTO/10,20,30,0,0.6,0.8\nCYCLE/"
             "DRILL,FEDTO,8,RAPTO,2,MMPM,100,RTRCTO,300\nGOTO/10,20,0,0,0.6,0.8\nCYCLE/OFF\nFINI\n",
             options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_GT(run.rewrite.cycle_residual, 0);
}

TEST(RewriteCl, AHeaderMarksTheFileAndIsSeen) {
  Options options;
  options.header = {"ABBE COMPENSATED - DO NOT EDIT", "ABBE MACHINE X"};
  const ClRun run = run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/1,2,3\nFINI\n", options);
  ASSERT_TRUE(run.verify.agrees) << run.findings();
  EXPECT_TRUE(run.output.starts_with("$$ ABBE COMPENSATED - DO NOT EDIT\n$$ ABBE MACHINE X\nUNITS/MM\n"));
  EXPECT_EQ(run_cl(plan_of(kThreeAxes), run.output).refusal(), "E-COMPENSATED");
}

TEST(RewriteCl, TheGuardsOfProgramsHoldHereToo) {
  Options small;
  small.max_correction = 5 * um;
  EXPECT_EQ(run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/100,0,0\nFINI\n", small).refusal(), "E-CORRECTION");
  EXPECT_EQ(run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/600,0,0\nFINI\n").refusal(), "E-TRAVEL");
  EXPECT_TRUE(run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/600,0,0\nFINI\n").rewrite.out_of_volume);
  std::string table = kThreeAxes;
  table.replace(table.find("EXX"), std::string("EXX = { poly = [0, 0.1] }").size(),
                "EXX = { table = [[0, 0], [100, 1]] }");
  EXPECT_EQ(run_cl(plan_of(table), "UNITS/MM\nGOTO/300,0,0\nFINI\n").refusal(), "E-VOL");
  std::string step = kThreeAxes;
  step.replace(step.find("EXX"), std::string("EXX = { poly = [0, 0.1] }").size(),
               "EXX = { table = [[-500, 0], [10, 0], [10.1, 30], [500, 30]] }");
  EXPECT_EQ(run_cl(plan_of(step), "UNITS/MM\nGOTO/9,0,0\nGOTO/11,0,0\nFINI\n").refusal(), "E-GRADIENT");
  EXPECT_EQ(run_cl(plan_of(kThreeAxes), "UNITS/MM\nGOTO/1,0,0,0,0.6,0.8\nFINI\n").refusal(), "E-REACH");
  EXPECT_EQ(run_cl(plan_of(kThreeAxes), "").refusal(), "E-EMPTY");
}

}  // namespace
}  // namespace abbe::cl
