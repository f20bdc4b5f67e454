#include "abbe/verify/verify.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

class GoodPair : public ::testing::TestWithParam<Pair> {};

TEST_P(GoodPair, Agrees) {
  const VerifyReport report = verify_drawn(GetParam().draw);
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_LT(report.after.max, report.allowed);
  EXPECT_GT(report.before.max, 6 * um) << "the errors of this machine were seen";
  EXPECT_LE(report.after.rms, report.after.max);
  EXPECT_GT(report.points, 0u);
}

TEST_P(GoodPair, UncompensatedOutputIsCaught) {
  const std::string original = GetParam().draw(Pen(false));
  const VerifyReport report = verify(plan_of(kMachine), original, original, ideal_job());
  EXPECT_FALSE(report.agrees);
}

TEST_P(GoodPair, IdentityAgreesOnAPerfectMachine) {
  const std::string original = GetParam().draw(Pen(false));
  const VerifyReport report = verify(plan_of(kPerfect), original, original, ideal_job());
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_LT(report.after.max, 1e-9);
  EXPECT_EQ(report.original.sha256, report.output.sha256);
  EXPECT_EQ(report.original.bytes, original.size());
}

TEST_P(GoodPair, WrongSignIsCaught) {
  // The output of a compensator with the sign wrong: m + c in place of m - c.
  const Plan mirrored = plan_of(R"(format = 1
[machine]
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { poly = [0, -0.1] }
EYX = { poly = [0, 0, -0.001] }
EZZ = -7
)");
  const VerifyReport report =
      verify(mirrored, GetParam().draw(Pen(false)), GetParam().draw(Pen(true)), ideal_job());
  EXPECT_FALSE(report.agrees);
}

INSTANTIATE_TEST_SUITE_P(All, GoodPair, ::testing::ValuesIn(good_pairs()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(Verify, InchesHaveTheirOwnDigits) {
  const auto draw = [](const Pen& p) {
    return "G20\nG0" + p.at(10, 20, 30) + "\nG1 F10" + p.at(90, 20, 30) + "\nG2" + p.at(110, 20, 30) + " I" +
           p.number(10) + " J0\n";
  };
  const VerifyReport report =
      verify(plan_of(kMachine), draw(Pen(false, inch)), draw(Pen(true, inch)), ideal_job());
  // The line of 80 mm bends by kBow * 40^2 = 1.6 um.
  EXPECT_FALSE(report.agrees);
  VerifyJob loose = ideal_job();
  loose.tolerance = 2 * um;
  const VerifyReport good = verify(plan_of(kMachine), draw(Pen(false, inch)), draw(Pen(true, inch)), loose);
  EXPECT_TRUE(good.agrees) << texts(good);
  EXPECT_NEAR(good.quantisation, 2 * std::sqrt(3.0) * 0.127 * um, 1e-9);
}

TEST(Verify, AMotionShorterThanItsDigitsMayVanish) {
  const auto ends_at = [](const char* x) {
    return fmt::format("G21 G90 G0 X0 Y0 Z0\nG1 X10 F100\nX{}\nX20\nM2\n", x);
  };
  EXPECT_TRUE(verify(plan_of(kPerfect), ends_at("10.0001"), ends_at("10.0000"), ideal_job()).agrees);
  EXPECT_FALSE(verify(plan_of(kPerfect), ends_at("10.0009"), ends_at("10.0000"), ideal_job()).agrees);
}

TEST(Verify, SeesABowBetweenTheEnds) {
  const auto draw = [](const Pen& p) {
    return "G0" + p.at(-100, 0, 0) + "\nG1 F10" + p.at(100, 0, 0) + "\n";
  };
  const VerifyReport report = verify_drawn(draw);
  ASSERT_EQ(report.diagnostics.size(), 1u);
  EXPECT_EQ(report.diagnostics[0].code, "V-PATH");
  EXPECT_NEAR(report.after.max, 10 * um, 0.1 * um);
  EXPECT_EQ(report.diagnostics[0].place.line, 2u);
}

TEST(Verify, ProbedDatumRemovesTheDeviationAtTheOffset) {
  VerifyJob job = ideal_job();
  job.datum = DatumRule::probed;
  job.setup.work_offsets[0]->origin = {100, 0, 0};
  // deviation at x = 100: (10, 10, 7) um
  const auto draw = [](const Pen& p) {
    const auto at = [&](double x, double y, double z) {
      const Vec3 shift = p.writes_output() ? Vec3(10, 10, 7) * um : Vec3::Zero().eval();
      const Vec3 q = p.command(x + 100 + shift.x(), y + shift.y(), z + shift.z()) - Vec3(100, 0, 0);
      return " X" + p.number(q.x()) + " Y" + p.number(q.y()) + " Z" + p.number(q.z());
    };
    return "G0" + at(0, 0, 0) + "\nG1 F10" + at(20, 30, 10) + "\n";
  };
  const VerifyReport report = verify_drawn(draw, job);
  EXPECT_TRUE(report.agrees) << texts(report);
  ASSERT_EQ(report.datums.size(), 1u);
  EXPECT_EQ(report.datums[0].frame, "G54");
  EXPECT_LT((report.datums[0].removed - Vec3(10, 10, 7) * um).norm(), 1e-9);
  EXPECT_NEAR(report.before.max, std::hypot(2.0, 4.4) * um, 1e-6) << "relative to the datum, at x = 120";
}

TEST(Verify, StatesLimitsVolumeAndTravel) {
  VerifyJob job = ideal_job();
  job.max_correction = 5 * um;
  VerifyReport report = verify_drawn(rapid_lines, job);
  EXPECT_EQ(report.diagnostics.front().code, "V-LIMIT") << texts(report);

  const auto far = [](const Pen& p) { return "G0" + p.at(490, 0, 0) + "\nG1 F1" + p.at(505, 0, 0) + "\n"; };
  report = verify_drawn(far);
  EXPECT_EQ(report.diagnostics.front().code, "V-TRAVEL") << texts(report);

  const Plan table = plan_of(R"(format = 1
[machine]
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { table = [[0, 0], [100, 0]] }
)");
  report = verify(table, "G0 X0 Y0 Z0\nG1 F1 X101\n", "G0 X0 Y0 Z0\nG1 F1 X101\n", ideal_job());
  ASSERT_EQ(report.diagnostics.size(), 1u);
  EXPECT_EQ(report.diagnostics.front().code, "V-VOL");
}

TEST(Verify, DeletableBlocksAreComparedBothWays) {
  // Executed, both agree; skipped, the output never corrects Y.
  const Plan plan = plan_of(kMachine);
  const Pen in(false), out(true);
  const auto draw = [](const Pen& p) {
    return "G0" + p.at(50, 0, 0) + "\n/G1 F9" + p.at(90, 0, 0) + "\nG1 F10 X" +
           p.number(p.command(90, 0, 0).x()) + " Y" +
           p.number(p.command(p.writes_output() ? 50 : 90, 0, 0).y()) + "\n";
  };
  VerifyReport report = verify(plan, draw(in), draw(out), ideal_job());
  EXPECT_FALSE(report.agrees);
  VerifyJob job = ideal_job();
  job.setup.block_delete = ControlSetup::BlockDelete::on;
  report = verify(plan, draw(in), draw(in), job);
  EXPECT_FALSE(report.agrees);
}

TEST(Verify, DirectionalErrorsAreMeasuredAndTakenUp) {
  const Plan plan = plan_of(R"(format = 1
[machine]
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { forward = { poly = [3] }, backward = { poly = [-3] } }
)");
  const std::string original = "G0 X-1 Y0 Z0\nG0 X0\nG1 F10 X10\nX0\nX0 Y5\n";
  VerifyJob job = ideal_job();
  VerifyReport report = verify(plan, original, original, job);
  EXPECT_TRUE(report.agrees) << "the mean is 0" << texts(report);
  EXPECT_NEAR(report.lost_motion, 6 * um, 1e-12);
  job.reversal = true;
  report = verify(plan, original, original, job);
  EXPECT_FALSE(report.agrees);
  const std::string taken_up =
      "G0 X-1.0030 Y0 Z0\nG0 X-0.0030\nG1 F10 X9.9970\nX10.0030\nX0.0030\nX0.0030 Y5\n";
  // The first rapid has no direction known (start unknown): its error is the mean.
  const std::string output = "G0 X-1 Y0 Z0" + taken_up.substr(taken_up.find('\n'));
  report = verify(plan, original, output, job);
  EXPECT_TRUE(report.agrees) << texts(report);
}

TEST(Verify, DirectionalErrorsAreTakenUpOnArcs) {
  const Plan plan = plan_of(R"(format = 1
[machine]
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { forward = { poly = [3] }, backward = { poly = [-3] } }
)");
  VerifyJob job = ideal_job();
  job.reversal = true;
  job.setup.start = {-1.0, 0.0, 0.0};
  // X goes up to 20 and back
  const std::string original = "G0 X0\nG3 F10 X10 Y10 I10 J0\n";
  const std::string right = "G0 X-0.0030\nG3 F10 X19.9970 Y0 I10 J0\nG1 X20.0030\nG3 X10.0030 Y10 I-10 J0\n";
  EXPECT_TRUE(verify(plan, original, right, job).agrees) << texts(verify(plan, original, right, job));
  const std::string not_taken_up = "G0 X-0.0030\nG3 F10 X19.9970 Y0 I10 J0\nG3 X9.9970 Y10 I-10 J0\n";
  EXPECT_EQ(verify(plan, original, not_taken_up, job).diagnostics.front().code, "V-PATH");
  const std::string wrong_way =
      "G0 X-0.0030\nG3 F10 X19.9970 Y0 I10 J0\nG1 X19.9910\nG3 X9.9910 Y10 I-10 J0\n";
  EXPECT_FALSE(verify(plan, original, wrong_way, job).agrees);
  // too early: where X has not turned yet
  const std::string early =
      "G0 X-0.0030\nG3 F10 X17.0681 Y-7.0711 I10 J0\nG1 X17.0741\nG3 X10.0030 Y10 I-7.0711 J7.0711\n";
  EXPECT_FALSE(verify(plan, original, early, job).agrees);
}

TEST(Verify, HolesAreDrilledDownwards) {
  const Plan plan = plan_of(R"(format = 1
[machine]
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
[errors]
EXX = { forward = { poly = [2] }, backward = { poly = [-2] } }
EZZ = { forward = { poly = [5] }, backward = { poly = [-5] } }
)");
  VerifyJob job = ideal_job();
  job.reversal = true;
  job.setup.start = {0.0, 0.0, 0.0};
  const std::string original = "G0 Z50\nG98 G81 X10 Y10 Z-5 R5 F9\nX-10\nG80\nG0 X-20\n";
  // Up: -5 um. Down in the hole: +5 um. Up again behind it: -5 um. X by its direction.
  const std::string output =
      "G0 Z49.9950\nG98 G81 X9.9980 Y10 Z-4.9950 R5.0050 F9\nX-9.9980 Z-4.9950 R5.0050\nG80\nG0 X-19.9980 "
      "Z49.9950\n";
  const VerifyReport report = verify(plan, original, output, job);
  EXPECT_TRUE(report.agrees) << texts(report);
  EXPECT_EQ(verify(plan, original, original, job).diagnostics.front().code, "V-END");
}

TEST(Verify, KeepsSamplesSpreadOverThePath) {
  VerifyJob job = ideal_job();
  job.samples = 100;
  const VerifyReport report = verify_drawn(increments, job);
  EXPECT_LE(report.samples.size(), 100u);
  ASSERT_GE(report.samples.size(), 20u);
  EXPECT_NEAR(report.path_length, 20 * std::hypot(1.5, 0.7, 0.1), 1e-6);
  for (std::size_t i = 1; i < report.samples.size(); ++i) {
    EXPECT_GE(report.samples[i].travelled, report.samples[i - 1].travelled);
    EXPECT_LT(report.samples[i].after.norm(), report.allowed);
  }
}

TEST(Verify, MissingFileAndWrongMachineAreSaid) {
  VerifyJob job = ideal_job();
  job.original_path = job.output_path = "/nonexistent/a.ngc";
  EXPECT_EQ(verify_program(plan_of(kMachine), job).diagnostics.front().code, "E-FILE");
  const Plan lathe = plan_of("format = 1\n[machine]\nchain = \"w b X Z t\"\n[axis.X]\n[axis.Z]\n");
  EXPECT_EQ(verify(lathe, "", "", ideal_job()).diagnostics.front().code, "E-AXIS");
}

TEST(Verify, StopsWhenAsked) {
  std::string program;
  for (int i = 0; i < 20000; ++i) program += "G0 X1 Y1 Z1\n";
  const TestFile file(program);
  VerifyJob job = ideal_job();
  job.original_path = job.output_path = file.path();
  const VerifyReport report =
      verify_program(plan_of(kPerfect), job, [](std::uint64_t, std::uint64_t) { return false; });
  EXPECT_TRUE(report.stopped);
  EXPECT_FALSE(report.agrees);
}

/// Ten pieces of 20.6 mm at 500 mm/min last 2.47 s each; a motion that is not split may be as short as it is.
TEST(Verify, PiecesMustNotBeFasterThanTheControlReads) {
  VerifyJob job = ideal_job();
  job.block_time = 2.4;
  EXPECT_TRUE(verify_drawn(split_line, job).agrees);
  EXPECT_TRUE(verify_drawn(rapid_lines, job).agrees);
  EXPECT_TRUE(verify_drawn(split_line_inverse_time, job).agrees);  // 60 s / 20
  job.block_time = 2.6;
  const VerifyReport fast = verify_drawn(split_line, job);
  ASSERT_FALSE(fast.agrees);
  EXPECT_EQ(fast.diagnostics.front().code, "V-FEED") << texts(fast);
  EXPECT_TRUE(verify_drawn(rapid_lines, job).agrees);
  job.block_time = 3.1;
  EXPECT_FALSE(verify_drawn(split_line_inverse_time, job).agrees);
}

}  // namespace
}  // namespace abbe::verifying
