#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "abbe/cl/test_cl_files.h"

/// Machines and CL files drawn at random, for the laws of the rewriter. Test support.
namespace abbe::cl {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(engine_() >> 11U) * 0x1p-53);
  }
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  bool chance(double p) { return between(0, 1) < p; }

 private:
  std::mt19937_64 engine_;
};

/// Three axes; tables, a head and a table, a head: gentle errors of every kind.
inline std::string random_machine_text(Random& random, int kind, double scale) {
  static constexpr const char* kChains[] = {"w b X Y Z t", "w C A Y b X Z t", "w C B X b Y Z t",
                                            "w C Y b X Z A t", "w b X Y Z C A t"};
  const std::string chain = kChains[kind];
  std::string text = fmt::format("format = 1\n[machine]\nname = \"random\"\nchain = \"{}\"\n", chain),
              errors = "[errors]\n";
  const std::size_t bed = chain.find('b');
  for (const char axis : std::string("XYZABC")) {
    const std::size_t at = chain.find(axis);
    if (at == std::string::npos) continue;
    const bool rotary = axis <= 'C', table = at < bed;
    text += fmt::format("[axis.{}]\n", axis);
    if (table && rotary)
      text += axis == 'C'   ? "direction = [0, 0, -1]\n"
              : axis == 'A' ? "direction = [-1, 0, 0]\n"
                            : "direction = [0, -1, 0]\n";
    if (table) text += "errors_seen = \"body\"\n";
    if (!rotary) text += "range = [-1500, 1500]\n";
    if (axis == 'A' || axis == 'B') text += "range = [-115, 115]\n";
    if (rotary)
      text += fmt::format("origin = [{:.3f}, {:.3f}, {:.3f}]\n", random.between(-5, 5), random.between(-5, 5),
                          table ? random.between(-100, 0) : 200.0);
    for (const char direction : std::string("XYZABC")) {
      if (!random.chance(0.5)) continue;
      const double a = scale * random.between(-10, 10);
      const double wave = rotary ? std::numbers::pi / 180 : 2 * std::numbers::pi / random.between(300, 900);
      if (random.chance(0.5))
        errors += fmt::format("E{}{} = {{ sine = [{:.6g}, {:.6g}, {:.6g}] }}\n", direction, axis, a, wave,
                              random.between(-3, 3));
      else if (!rotary)
        errors += fmt::format(
            "E{}{} = {{ table = [[-1500, {:.6g}], [-200, {:.6g}], [100, {:.6g}], [1500, {:.6g}]], "
            "interpolation = \"cubic\" }}\n",
            direction, axis, a, -a / 2, a / 3, a);
      else
        errors += fmt::format("E{}{} = {{ poly = [0, {:.6g}] }}\n", direction, axis, a / 100);
    }
    if (rotary)
      errors +=
          fmt::format("E{}0{} = {:.6g}\n", axis == 'A' ? 'B' : 'A', axis, scale * random.between(-40, 40));
  }
  text += fmt::format("[tool]\norigin = [0, 0, {0}]\nlength = 100\n", 100);
  for (const char* name : {"EC0Y", "EB0Z", "EA0Z"})
    errors += fmt::format("{} = {:.6g}\n", name, scale * random.between(-40, 40));
  return text + errors;
}

/// A CL file as CAM systems write them, that Abbe understands.
class ClWriter {
 public:
  ClWriter(Random& random, bool five) : random_(random), five_(five) {}

  std::string write(int records) {
    eol_ = random_.chance(0.3) ? "\r\n" : "\n";
    line("PARTNO/TEST");
    line("UNITS/MM");
    line("LOADTL/1");
    line("CUTTER/8.0,0,4.0,0,0,0,60.0");
    if (five_) line("MULTAX/ON");
    tip_ = Vec3(0, 0, 50);
    axis_ = five_ ? tilted() : Vec3::UnitZ();
    line("RAPID");
    go(true);
    line("FEDRAT/200.0,MMPM");
    for (int i = 0; i < records; ++i) one();
    line("FINI");
    return text_;
  }

 private:
  void line(const std::string& record) { text_ += record + eol_; }
  Vec3 tilted() {
    const double tilt = random_.between(0.15, 0.7), turn = random_.between(-2.8, 2.8);
    return {std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
  }
  Vec3 near_axis() {
    const double tilt = std::clamp(std::acos(axis_.z()) + random_.between(-0.1, 0.1), 0.1, 0.8),
                 turn = std::atan2(axis_.y(), axis_.x()) + random_.between(-0.3, 0.3);
    return {std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt)};
  }
  static double rounded(double v) { return std::round(v * 1e4) / 1e4; }
  Vec3 target(double reach) {
    Vec3 p;
    for (int k = 0; k < 3; ++k)
      p[k] = rounded(std::clamp(tip_[k] + random_.between(-reach, reach), k == 2 ? -20.0 : -150.0,
                                k == 2 ? 80.0 : 150.0));
    return p;
  }
  std::string numbers(const Vec3& v) const {
    return fmt::format("{:.4f},{:.4f},{:.4f}", v.x(), v.y(), v.z());
  }
  void go(bool with_axis, const char* tail = "") {
    // what stands in the file is the axis from now on
    if (with_axis && five_) {
      const std::string digits = fmt::format("{:.7f},{:.7f},{:.7f}", axis_.x(), axis_.y(), axis_.z());
      line(random_.chance(0.2) ? fmt::format("GOTO / {},${}  {}{}", numbers(tip_), eol_, digits, tail)
                               : fmt::format("GOTO/{},{}{}", numbers(tip_), digits, tail));
    } else {
      line(fmt::format("GOTO/{}{}", numbers(tip_), tail));
    }
  }
  void arc() {
    const double radius = random_.between(2, 15), start = random_.between(0, 6.28),
                 sweep = random_.chance(0.2) ? 2 * std::numbers::pi : random_.between(0.3, 5.5);
    const Vec3 centre = tip_ - radius * Vec3(std::cos(start), std::sin(start), 0);
    const bool right = random_.chance(0.5), radius_stated = random_.chance(0.5);
    const double end = start + (right ? sweep : -sweep);
    if (sweep < 6) {
      tip_ = centre + radius * Vec3(std::cos(end), std::sin(end), 0);
      for (int k = 0; k < 3; ++k) tip_[k] = rounded(tip_[k]);
      if (random_.chance(0.3)) tip_.z() = rounded(tip_.z() + 1);
    }
    line(fmt::format("CIRCLE/{:.4f},{:.4f},{:.4f},0,0,{}{}", centre.x(), centre.y(), centre.z(),
                     right ? "1." : "-1.", radius_stated ? fmt::format(",{:.4f}", radius) : ""));
    go(random_.chance(0.3));
  }
  void one() {
    switch (random_.below(12)) {
      case 0:
        line("$$ a remark");
        line("PPRINT TEXT, $$ TEXT");
        break;
      case 1:
        line(random_.chance(0.5) ? "COOLNT/ON" : "SPINDL/2000,RPM,CLW");
        break;
      case 2:
        tip_ = target(80);
        line("RAPID");
        go(false);
        break;
      case 3:
      case 4:
      case 5:
        tip_ = target(random_.chance(0.3) ? 150 : 10);
        go(random_.chance(0.2), random_.chance(0.2) ? " $$ here" : "");
        break;
      case 6:
      case 7:
        if (five_) axis_ = near_axis();
        tip_ = target(random_.chance(0.2) ? 60 : 5);
        go(true);
        break;
      case 8:
        arc();
        break;
      case 9: {
        const Vec3 to = target(3);
        const Vec3 step = to - tip_;
        line("GODLTA/" + numbers(step));
        tip_ = to;
        break;
      }
      case 10:
        line("CYCLE/DRILL,FEDTO,4.0,RAPTO,2.0,MMPM,100.0");
        for (int i = random_.below(3); i >= 0; --i) {
          tip_ = target(20);
          go(false);
        }
        line("CYCLE/OFF");
        break;
      default:
        line(fmt::format("FEDRAT/{:.1f},MMPM", random_.between(50, 500)));
        break;
    }
  }

  Random& random_;
  bool five_;
  std::string text_, eol_;
  Vec3 tip_ = Vec3::Zero(), axis_ = Vec3::UnitZ();
};

}  // namespace abbe::cl
