#include "abbe/verify/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "abbe/core/number.h"
#include "abbe/machine/read_machine.h"
#include "abbe/verify/test_files.h"

namespace abbe::verifying {
namespace {

// A machine of three linear axes whose correction can be written down:
//   tip = (x + 1e-4 x + dx, y + 2e-6 x^2 um.. , z + dz): see Pen::corrected.
constexpr double kScale = 1e-4;     // EXX per mm: 0.1 um per mm
constexpr double kBow = 1e-3 * um;  // EYX = kBow * x^2, mm
constexpr double kShiftZ = 7 * um;  // EZZ, constant

const char* const kMachine = R"(format = 1
[machine]
name = "test"
chain = "w b X Y Z t"
[axis.X]
range = [-500, 500]
[axis.Y]
range = [-500, 500]
[axis.Z]
range = [-500, 500]
[errors]
EXX = { poly = [0, 0.1] }
EYX = { poly = [0, 0, 0.001] }
EZZ = 7
)";

const char* const kPerfect = R"(format = 1
[machine]
name = "perfect"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
)";

Plan plan_of(const std::string& text) {
  auto machine = read_machine({"m.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  if (!machine.value) {
    for (const Diagnostic& d : machine.diagnostics) ADD_FAILURE() << to_text(d);
    std::abort();
  }
  return std::get<Plan>(make_plan(*machine.value, {}));
}

/// Writes points as the original means them, or as this machine must be told them.
class Pen {
 public:
  explicit Pen(bool corrected, double unit = mm) : corrected_(corrected), unit_(unit) {}

  /// q with tip(q) = m:  x + kScale x = m_x,  y + kBow x^2 = m_y,  z + kShiftZ = m_z
  static Vec3 corrected(const Vec3& m) {
    const double x = m.x() / (1 + kScale);
    return {x, m.y() - kBow * x * x, m.z() - kShiftZ};
  }
  [[nodiscard]] Vec3 command(double x, double y, double z) const {
    return corrected_ ? corrected(Vec3(x, y, z)) : Vec3(x, y, z);
  }
  [[nodiscard]] std::string number(double value) const {
    std::string text;
    append_fixed(text, value / unit_, unit_ == mm ? 4 : 5);
    return text;
  }
  /// " X.. Y.. Z.." of a point in mm
  [[nodiscard]] std::string at(double x, double y, double z) const {
    const Vec3 q = command(x, y, z);
    return " X" + number(q.x()) + " Y" + number(q.y()) + " Z" + number(q.z());
  }
  /// " I.. J.." from a start to a centre
  [[nodiscard]] std::string centre(double x, double y, double z, double cx, double cy) const {
    const Vec3 q = rounded_command(x, y, z), c = command(cx, cy, z);
    return " I" + number(c.x() - q.x()) + " J" + number(c.y() - q.y());
  }
  [[nodiscard]] Vec3 rounded_command(double x, double y, double z) const {
    const Vec3 q = command(x, y, z);
    return {rounded(q.x(), 4), rounded(q.y(), 4), rounded(q.z(), 4)};
  }
  [[nodiscard]] bool writes_output() const { return corrected_; }

 private:
  bool corrected_;
  double unit_;
};

using Draw = std::function<std::string(const Pen&)>;

ControlSetup setup_at_zero() {
  ControlSetup setup;
  setup.work_offsets[0] = WorkOffset{};
  return setup;
}

VerifyReport verify(const Plan& plan, const std::string& original, const std::string& output, VerifyJob job) {
  const TestFile a(original), b(output);
  job.original_path = a.path();
  job.output_path = b.path();
  job.original_name = "in.ngc";
  job.output_name = "out.ngc";
  return verify_program(plan, job);
}

VerifyJob ideal_job() {
  VerifyJob job;
  job.setup = setup_at_zero();
  job.datum = DatumRule::ideal;
  return job;
}

std::string texts(const VerifyReport& report) {
  std::string text;
  for (const Diagnostic& d : report.diagnostics) text += to_text(d) + "\n";
  return text;
}

VerifyReport verify_drawn(const Draw& draw, VerifyJob job = ideal_job()) {
  return verify(plan_of(kMachine), draw(Pen(false)), draw(Pen(true)), std::move(job));
}

// ---- good pairs

struct Good {
  const char* name;
  Draw draw;
};

std::string rapid_lines(const Pen& p) {
  return "%\nO7 (part)\nG21 G90 (setup)\nT1 M6\nS1000 M3\nG0" + p.at(10, 20, 30) + "\nM8\nG1 F200" + p.at(40, 20, 30) +
         "\nF300" + p.at(40, 60, 30) + "; up\nG4 P0.5\nM9\nG0" + p.at(0, 0, 100) + "\nM5 M2\n%\ntrailing (text\n";
}

/// A line of 200 mm bends by kBow * 100^2 = 10 um: ten pieces leave 0.1 um.
std::string split_line(const Pen& p) {
  std::string text = "G0" + p.at(-100, 0, 0) + "\n";
  if (!p.writes_output()) return text + "N5 G1 F500" + p.at(100, 50, 0) + " M0\n";
  for (int k = 1; k <= 10; ++k)
    text += (k == 1 ? "N5 G1 F500" : "") + p.at(-100 + 20 * k, 5 * k, 0) + (k == 10 ? " M0\n" : "\n");
  return text;
}

std::string split_line_inverse_time(const Pen& p) {
  std::string text = "G93\nG0" + p.at(-100, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G1 F2" + p.at(100, 50, 0) + "\n";
  for (int k = 1; k <= 10; ++k) text += "G1 F20" + p.at(-100 + 20 * k, 5 * k, 0) + "\n";
  return text;
}

std::string quarter_arcs(const Pen& p) {
  return "G0" + p.at(10, 0, 0) + "\nG3 F100" + p.at(0, 10, 2) + p.centre(10, 0, 0, 0, 0) + "\nG2" + p.at(10, 0, 0) +
         p.centre(0, 10, 2, 0, 0) + "\n";
}

std::string full_circle(const Pen& p) {
  return "G0" + p.at(10, 0, 0) + "\nG3 F100" + p.at(10, 0, 0) + p.centre(10, 0, 0, 0, 0) + "\n";
}

/// The circle of 50 mm radius becomes an ellipse: quarters keep it.
std::string circle_in_pieces(const Pen& p) {
  std::string text = "G0" + p.at(50, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G2 F100 I-50 J0\n";
  const double points[9][2] = {{50, 0}, {35.355339, -35.355339}, {0, -50}, {-35.355339, -35.355339}, {-50, 0},
                               {-35.355339, 35.355339}, {0, 50}, {35.355339, 35.355339}, {50, 0}};
  for (int k = 0; k < 8; ++k) {
    const auto& a = points[k];
    const auto& b = points[k + 1];
    // centre of the corrected piece: equidistant from its corrected ends, on the side of (0, 0)
    const Vec3 qa = p.rounded_command(a[0], a[1], 0), qb = p.rounded_command(b[0], b[1], 0);
    const double angle = -(2 * k + 1) * 22.5 * deg;
    const Vec3 qm = p.command(50 * std::cos(angle), 50 * std::sin(angle), 0);
    // circle through qa, qm, qb
    const double ax = qa.x() - qm.x(), ay = qa.y() - qm.y(), bx = qb.x() - qm.x(), by = qb.y() - qm.y();
    const double d = 2 * (ax * by - ay * bx);
    const double ux = (by * (ax * ax + ay * ay) - ay * (bx * bx + by * by)) / d;
    const double uy = (ax * (bx * bx + by * by) - bx * (ax * ax + ay * ay)) / d;
    text += "G2" + std::string(k == 0 ? " F100" : "") + p.at(b[0], b[1], 0) + " I" + p.number(qm.x() + ux - qa.x()) +
            " J" + p.number(qm.y() + uy - qa.y()) + "\n";
  }
  return text;
}

std::string helix_turns(const Pen& p) {
  std::string text = "G0" + p.at(5, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G3 F100" + p.at(5, 0, 6) + " I-5 J0 P3\nG1" + p.at(9, 9, 9) + "\n";
  for (int k = 1; k <= 3; ++k)
    text += "G3" + std::string(k == 1 ? " F100" : "") + p.at(5, 0, 2 * k) + p.centre(5, 0, 0, 0, 0) + "\n";
  return text + "G1" + p.at(9, 9, 9) + "\n";
}

std::string other_planes(const Pen& p) {
  const Vec3 a = p.command(10, 0, 0), b = p.command(0, 0, 10);
  return "G18 G0" + p.at(10, 0, 0) + "\nG2 F10" + p.at(0, 0, 10) + " I" + p.number(-10) + " K0\nG19\nG0" +
         p.at(3, 10, 0) + "\nG3" + p.at(3, 0, 10) + " J-10. K0\nG2" + p.at(3, 10, 0) + " R10\n" +
         (a == b ? "" : "");
}

std::string increments(const Pen& p) {
  std::string text = "G0" + p.at(0, 0, 0) + "\nG91\n";
  Vec3 from = p.rounded_command(0, 0, 0);
  for (int k = 1; k <= 20; ++k) {
    const Vec3 to = p.rounded_command(1.5 * k, -0.7 * k, 0.1 * k), step = to - from;
    text += std::string(k == 1 ? "G1 F100" : "") + " X" + p.number(step.x()) + " Y" + p.number(step.y()) + " Z" +
            p.number(step.z()) + "\n";
    from = to;
  }
  return text;
}

std::string position_set(const Pen& p) {
  // At x = 30 the output stands at q; after G92 X5 both programs have the same offset.
  const Vec3 m(30, 10, 0), q = p.rounded_command(30, 10, 0);
  const Vec3 c = q - m;
  const auto shifted = [&](double x, double y, double z) {
    const Vec3 v = p.command(x, y, z) - Vec3(25, 10, 0);
    return " X" + p.number(v.x()) + " Y" + p.number(v.y()) + " Z" + p.number(v.z());
  };
  return "G0" + p.at(30, 10, 0) + "\nG92 X" + p.number(5 + c.x()) + " Y" + p.number(c.y()) + "\nG1 F100" +
         shifted(60, 10, 0) + "\nG92.2\nG1" + p.at(70, 20, 5) + "\nG92.3\nG0" + shifted(10, 0, 0) + "\n";
}

std::string machine_moves(const Pen& p) {
  return "G0" + p.at(10, 10, 10) + "\nG53 G0 Z200\nG0 X" + p.number(p.command(50, 20, 200).x()) + " Y" +
         p.number(p.command(50, 20, 200).y()) + "\nG1 F100" + p.at(50, 20, 100) + "\nG1" + p.at(60, 20, 100) +
         "\nG91 G28 Z5\nG90\nG0 X5\nG0" + p.at(6, 7, 80) + "\nM30\n";
}

std::string holes(const Pen& p) {
  const auto hole = [&](double x, double y, double bottom, double r) {
    const Vec3 q = p.command(x, y, (bottom + r) / 2) - Vec3(0, 0, (bottom + r) / 2);
    return " X" + p.number(q.x()) + " Y" + p.number(q.y()) + " Z" + p.number(bottom + q.z()) + " R" +
           p.number(r + q.z());
  };
  return "G0" + p.at(0, 0, 50) + "\nG98 G81 F100" + hole(10, 10, -5, 2) + "\n" + hole(40, 10, -5, 2) +
         "\nG99 G83 Q1.5" + hole(60, 20, -9, 1) + "\nG82 P0.2" + hole(20, 30, -1, 1) + "\nG80\nG0" + p.at(0, 0, 50) + "\n";
}

std::string carriage_returns(const Pen& p) {
  return std::string("\0\0\0%\r\n", 6) + "(a) (b)\r\n\r\nG0" + p.at(1, 2, 3) + "\r\n/G1 F5" + p.at(2, 3, 4) + "\r\n/ M8\r\nG1 F6" +
         p.at(7, 8, 9) + "\r\n%";
}

class GoodPair : public testing::TestWithParam<Good> {};

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

INSTANTIATE_TEST_SUITE_P(
    All, GoodPair,
    testing::Values(Good{"RapidLines", rapid_lines}, Good{"SplitLine", split_line},
                    Good{"SplitLineInverseTime", split_line_inverse_time}, Good{"QuarterArcs", quarter_arcs},
                    Good{"FullCircle", full_circle}, Good{"CircleInPieces", circle_in_pieces},
                    Good{"HelixTurns", helix_turns}, Good{"OtherPlanes", other_planes}, Good{"Increments", increments},
                    Good{"PositionSet", position_set}, Good{"MachineMoves", machine_moves}, Good{"Holes", holes},
                    Good{"CarriageReturns", carriage_returns}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Verify, InchesHaveTheirOwnDigits) {
  const auto draw = [](const Pen& p) { return "G20\nG0" + p.at(10, 20, 30) + "\nG1 F10" + p.at(90, 20, 30) + "\nG2" +
                                              p.at(110, 20, 30) + " I" + p.number(10) + " J0\n"; };
  const VerifyReport report = verify(plan_of(kMachine), draw(Pen(false, inch)), draw(Pen(true, inch)), ideal_job());
  // The line of 80 mm bends by kBow * 40^2 = 1.6 um.
  EXPECT_FALSE(report.agrees);
  VerifyJob loose = ideal_job();
  loose.tolerance = 2 * um;
  const VerifyReport good = verify(plan_of(kMachine), draw(Pen(false, inch)), draw(Pen(true, inch)), loose);
  EXPECT_TRUE(good.agrees) << texts(good);
  EXPECT_NEAR(good.quantisation, 2 * std::sqrt(3.0) * 0.127 * um, 1e-9);
}

TEST(Verify, SeesABowBetweenTheEnds) {
  const auto draw = [](const Pen& p) { return "G0" + p.at(-100, 0, 0) + "\nG1 F10" + p.at(100, 0, 0) + "\n"; };
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
    return "G0" + p.at(50, 0, 0) + "\n/G1 F9" + p.at(90, 0, 0) + "\nG1 F10 X" + p.number(p.command(90, 0, 0).x()) +
           " Y" + p.number(p.command(p.writes_output() ? 50 : 90, 0, 0).y()) + "\n";
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
  const std::string taken_up = "G0 X-1.0030 Y0 Z0\nG0 X-0.0030\nG1 F10 X9.9970\nX10.0030\nX0.0030\nX0.0030 Y5\n";
  // The first rapid has no direction known (start unknown): its error is the mean.
  const std::string output = "G0 X-1 Y0 Z0" + taken_up.substr(taken_up.find('\n'));
  report = verify(plan, original, output, job);
  EXPECT_TRUE(report.agrees) << texts(report);
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
  const VerifyReport report = verify_program(plan_of(kPerfect), job, [](std::uint64_t, std::uint64_t) { return false; });
  EXPECT_TRUE(report.stopped);
  EXPECT_FALSE(report.agrees);
}

}  // namespace
}  // namespace abbe::verifying
