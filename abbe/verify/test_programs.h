#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "abbe/chain/test_plan.h"
#include "abbe/core/number.h"
#include "abbe/core/test_files.h"
#include "abbe/verify/verify.h"

/// Programs drawn twice for the tests of the comparison: as the original means them, and as a machine whose
/// errors can be inverted on paper must be told them.
namespace abbe::verifying {

using abbe::testing::kPerfect;
using abbe::testing::plan_of;
using abbe::testing::TestFile;

// A machine of three linear axes whose correction can be written down:
//   tip = (x + kScale x, y + kBow x^2, z + kShiftZ)
inline constexpr double kScale = 1e-4;     // EXX per mm: 0.1 um per mm
inline constexpr double kBow = 1e-3 * um;  // EYX = kBow * x^2, mm
inline constexpr double kShiftZ = 7 * um;  // EZZ, constant

inline const char* const kMachine = R"(format = 1
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

inline ControlSetup setup_at_zero() {
  ControlSetup setup;
  setup.work_offsets[0] = WorkOffset{};
  return setup;
}

inline VerifyReport verify(const Plan& plan, const std::string& original, const std::string& output,
                           VerifyJob job) {
  const TestFile a(original), b(output);
  job.original_path = a.path();
  job.output_path = b.path();
  job.original_name = "in.ngc";
  job.output_name = "out.ngc";
  return verify_program(plan, job);
}

inline VerifyJob ideal_job() {
  VerifyJob job;
  job.setup = setup_at_zero();
  job.datum = DatumRule::ideal;
  return job;
}

inline std::string texts(const VerifyReport& report) {
  std::string text;
  for (const Diagnostic& d : report.diagnostics) text += to_text(d) + "\n";
  return text;
}

inline VerifyReport verify_drawn(const Draw& draw, VerifyJob job = ideal_job()) {
  return verify(plan_of(kMachine), draw(Pen(false)), draw(Pen(true)), std::move(job));
}

struct Pair {
  const char* name;
  Draw draw;
};

inline std::string rapid_lines(const Pen& p) {
  return "%\nO7 (part)\nG21 G90 (setup)\nT1 M6\nS1000 M3\nG0" + p.at(10, 20, 30) + "\nM8\nG1 F200" +
         p.at(40, 20, 30) + "\nF300" + p.at(40, 60, 30) + "; up\nG4 P0.5\nM9\nG0" + p.at(0, 0, 100) +
         "\nM5 M2\n%\ntrailing (text\n";
}

/// A line of 200 mm bends by kBow * 100^2 = 10 um: ten pieces leave 0.1 um.
inline std::string split_line(const Pen& p) {
  std::string text = "G0" + p.at(-100, 0, 0) + "\n";
  if (!p.writes_output()) return text + "N5 G1 F500" + p.at(100, 50, 0) + " M0\n";
  for (int k = 1; k <= 10; ++k)
    text += (k == 1 ? "N5 G1 F500" : "") + p.at(-100 + 20 * k, 5 * k, 0) + (k == 10 ? " M0\n" : "\n");
  return text;
}

inline std::string split_line_inverse_time(const Pen& p) {
  std::string text = "G93\nG0" + p.at(-100, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G1 F2" + p.at(100, 50, 0) + "\n";
  for (int k = 1; k <= 10; ++k) text += "G1 F20" + p.at(-100 + 20 * k, 5 * k, 0) + "\n";
  return text;
}

inline std::string quarter_arcs(const Pen& p) {
  return "G0" + p.at(10, 0, 0) + "\nG3 F100" + p.at(0, 10, 2) + p.centre(10, 0, 0, 0, 0) + "\nG2" +
         p.at(10, 0, 0) + p.centre(0, 10, 2, 0, 0) + "\n";
}

inline std::string full_circle(const Pen& p) {
  return "G0" + p.at(10, 0, 0) + "\nG3 F100" + p.at(10, 0, 0) + p.centre(10, 0, 0, 0, 0) + "\n";
}

/// The circle of 50 mm radius becomes an ellipse: quarters keep it.
inline std::string circle_in_pieces(const Pen& p) {
  std::string text = "G0" + p.at(50, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G2 F100 I-50 J0\n";
  const double points[9][2] = {{50, 0},  {35.355339, -35.355339}, {0, -50}, {-35.355339, -35.355339},
                               {-50, 0}, {-35.355339, 35.355339}, {0, 50},  {35.355339, 35.355339},
                               {50, 0}};
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
    text += "G2" + std::string(k == 0 ? " F100" : "") + p.at(b[0], b[1], 0) + " I" +
            p.number(qm.x() + ux - qa.x()) + " J" + p.number(qm.y() + uy - qa.y()) + "\n";
  }
  return text;
}

inline std::string helix_turns(const Pen& p) {
  std::string text = "G0" + p.at(5, 0, 0) + "\n";
  if (!p.writes_output()) return text + "G3 F100" + p.at(5, 0, 6) + " I-5 J0 P3\nG1" + p.at(9, 9, 9) + "\n";
  for (int k = 1; k <= 3; ++k)
    text += "G3" + std::string(k == 1 ? " F100" : "") + p.at(5, 0, 2 * k) + p.centre(5, 0, 0, 0, 0) + "\n";
  return text + "G1" + p.at(9, 9, 9) + "\n";
}

inline std::string other_planes(const Pen& p) {
  return "G18 G0" + p.at(10, 0, 0) + "\nG2 F10" + p.at(0, 0, 10) + " I" + p.number(-10) + " K0\nG19\nG0" +
         p.at(3, 10, 0) + "\nG3" + p.at(3, 0, 10) + " J-10. K0\nG2" + p.at(3, 10, 0) + " R10\n";
}

inline std::string increments(const Pen& p) {
  std::string text = "G0" + p.at(0, 0, 0) + "\nG91\n";
  Vec3 from = p.rounded_command(0, 0, 0);
  for (int k = 1; k <= 20; ++k) {
    const Vec3 to = p.rounded_command(1.5 * k, -0.7 * k, 0.1 * k), step = to - from;
    text += std::string(k == 1 ? "G1 F100" : "") + " X" + p.number(step.x()) + " Y" + p.number(step.y()) +
            " Z" + p.number(step.z()) + "\n";
    from = to;
  }
  return text;
}

inline std::string position_set(const Pen& p) {
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

inline std::string machine_moves(const Pen& p) {
  return "G0" + p.at(10, 10, 10) + "\nG53 G0 Z200\nG0 X" + p.number(p.command(50, 20, 200).x()) + " Y" +
         p.number(p.command(50, 20, 200).y()) + "\nG1 F100" + p.at(50, 20, 100) + "\nG1" + p.at(60, 20, 100) +
         "\nG91 G28 Z5\nG90\nG0 X5\nG0" + p.at(6, 7, 80) + "\nM30\n";
}

inline std::string holes(const Pen& p) {
  const auto hole = [&](double x, double y, double bottom, double r) {
    const Vec3 q = p.command(x, y, (bottom + r) / 2) - Vec3(0, 0, (bottom + r) / 2);
    return " X" + p.number(q.x()) + " Y" + p.number(q.y()) + " Z" + p.number(bottom + q.z()) + " R" +
           p.number(r + q.z());
  };
  return "G0" + p.at(0, 0, 50) + "\nG98 G81 F100" + hole(10, 10, -5, 2) + "\n" + hole(40, 10, -5, 2) +
         "\nG99 G83 Q1.5" + hole(60, 20, -9, 1) + "\nG82 P0.2" + hole(20, 30, -1, 1) + "\nG80\nG0" +
         p.at(0, 0, 50) + "\n";
}

inline std::string carriage_returns(const Pen& p) {
  return std::string("\0\0\0%\r\n", 6) + "(a) (b)\r\n\r\nG0" + p.at(1, 2, 3) + "\r\n/G1 F5" + p.at(2, 3, 4) +
         "\r\n/ M8\r\nG1 F6" + p.at(7, 8, 9) + "\r\n%";
}

inline std::vector<Pair> good_pairs() {
  return {{"RapidLines", rapid_lines},
          {"SplitLine", split_line},
          {"SplitLineInverseTime", split_line_inverse_time},
          {"QuarterArcs", quarter_arcs},
          {"FullCircle", full_circle},
          {"CircleInPieces", circle_in_pieces},
          {"HelixTurns", helix_turns},
          {"OtherPlanes", other_planes},
          {"Increments", increments},
          {"PositionSet", position_set},
          {"MachineMoves", machine_moves},
          {"Holes", holes},
          {"CarriageReturns", carriage_returns}};
}

}  // namespace abbe::verifying
