#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "abbe/pipeline/test_random_machine.h"

namespace abbe::testing {

/// Programs that mill one random contour under cutter radius compensation: lines of 4 radii to 250 mm, arcs
/// in both forms around and beside the cutter, corners to both sides up to 100 degrees, helices, plunges on
/// the way; in G90 or G91. LinuxCNC accepts them. Or in Klartext: RL and RR, places, arcs about a pole or by
/// radius, no helices.
class RandomContour {
 public:
  enum class Language : std::uint8_t { rs274, klartext };
  struct Tool {
    int number = 1;
    double diameter = 10;
  };
  /// `worn_only`: the program states the path of the centre, and the wear is zero (G41.1 D0).
  RandomContour(Random& random, const Tool& tool, bool worn_only, Language language = Language::rs274)
      : random_(random),
        tool_(tool.number),
        radius_(worn_only ? 0 : tool.diameter / 2),
        klartext_(language == Language::klartext) {}

  std::string write(bool turned_offset) {
    left_ = random_.chance(0.5);
    incremental_ = random_.chance(0.3) && !klartext_;
    text_ = klartext_ ? "BEGIN PGM CONTOUR MM\n" : "G21 G90 G54 G17 G94 G64 F500\n";
    if (turned_offset) text_ += fmt::format("G10 L2 P1 R{:.3f}\n", random_.between(-170, 170));
    text_ += klartext_ ? fmt::format("TOOL CALL {} Z S3000\n", tool_) : fmt::format("T{} M6 G43\n", tool_);
    heading_ = random_.between(-std::numbers::pi, std::numbers::pi);
    at_ = {digit(random_.between(-60, 60)), digit(random_.between(-60, 60)), -3};
    text_ += klartext_ ? fmt::format("L X{:.4f} Y{:.4f} Z20 R0 FMAX\nL Z-3 F500\n", at_[0], at_[1])
                       : fmt::format("G0 X{:.4f} Y{:.4f} Z20\nG1 Z-3\n", at_[0], at_[1]);
    if (incremental_) text_ += "G91\n";
    begin();
    line(3 * radius_ + random_.between(5, 40));
    for (int k = 4 + random_.below(10); k > 0; --k) segment();
    if (klartext_)
      side_ = " R0";
    else
      text_ += "G40 ";
    line(2 * radius_ + random_.between(5, 40));
    return text_ + (klartext_ ? "L Z+20 R0 FMAX M2\nEND PGM CONTOUR MM\n" : "G90\nG0 Z20\nM2\n");
  }

 private:
  using Place = std::array<double, 3>;
  static double digit(double value) { return std::round(value * 1e4) / 1e4; }

  void begin() {
    if (klartext_) {
      side_ = left_ ? " RL" : " RR";
      return;
    }
    const bool direct = radius_ == 0 || random_.chance(0.4);
    text_ += left_ ? "G41" : "G42";
    text_ += direct ? fmt::format(".1 D{:.1f}", 2 * radius_) : fmt::format(" D{}", tool_);
    text_ += random_.chance(0.5) ? "\n" : " ";
  }

  void segment() {
    constexpr double kFar = 250, kMost = 100 * std::numbers::pi / 180;
    const bool far = std::hypot(at_[0], at_[1]) > kFar;
    if (far) {  // back towards the middle
      const double back = std::remainder(std::atan2(-at_[1], -at_[0]) - heading_, 2 * std::numbers::pi);
      heading_ += std::clamp(back, -kMost, kMost);
    } else if (random_.chance(0.45)) {
      heading_ += random_.between(-kMost, kMost);
    }
    const int kind = random_.below(8);
    if (kind == 0 && !far) return line(random_.between(100, 250));
    if (kind <= 3) return arc();
    if (kind == 4) {
      at_[2] -= 0.5;
      text_ += fmt::format("{} Z{:.4f}\n", klartext_ ? "L" : "G1", incremental_ ? -0.5 : at_[2]);
    }
    line(4 * radius_ + random_.between(2, 40));
  }

  [[nodiscard]] std::string words(const Place& to, bool height) const {
    const Place from = incremental_ ? at_ : Place{};
    return fmt::format(" X{:.4f} Y{:.4f}", to[0] - from[0], to[1] - from[1]) +
           (height ? fmt::format(" Z{:.4f}", to[2] - from[2]) : "");
  }

  void line(double length) {
    const Place to{digit(at_[0] + length * std::cos(heading_)), digit(at_[1] + length * std::sin(heading_)),
                   at_[2]};
    text_ += (klartext_ ? "L" : "G1") + words(to, false) + side_ + "\n";
    if (!side_.empty() && random_.chance(0.7)) side_.clear();  // it stays in force
    at_ = to;
  }

  void arc() {
    const bool clockwise = random_.chance(0.5), helix = random_.chance(0.25) && !klartext_;
    const double sweep = random_.between(40, 170) * std::numbers::pi / 180,
                 wanted = 5 * radius_ + random_.between(4, 60);
    const double side = clockwise ? -std::numbers::pi / 2 : std::numbers::pi / 2;
    const double ca = digit(at_[0] + wanted * std::cos(heading_ + side)),
                 cb = digit(at_[1] + wanted * std::sin(heading_ + side));
    const double radius = std::hypot(at_[0] - ca, at_[1] - cb);
    const double to = std::atan2(at_[1] - cb, at_[0] - ca) + (clockwise ? -sweep : sweep);
    const Place end{digit(ca + radius * std::cos(to)), digit(cb + radius * std::sin(to)),
                    helix ? digit(at_[2] - 0.25) : at_[2]};
    const bool by_radius = random_.chance(0.25);
    if (klartext_) {
      if (!by_radius) text_ += fmt::format("CC X{:.4f} Y{:.4f}\n", ca, cb);
      text_ += (by_radius ? "CR" : "C") + words(end, false);
      if (by_radius) text_ += fmt::format(" R{:.4f}", radius);
      text_ += clockwise ? " DR-\n" : " DR+\n";
    } else {
      text_ += (clockwise ? "G2" : "G3") + words(end, helix);
      text_ += by_radius ? fmt::format(" R{:.4f}\n", radius)
                         : fmt::format(" I{:.4f} J{:.4f}\n", ca - at_[0], cb - at_[1]);
    }
    at_ = end;
    heading_ = to + side;
  }

  Random& random_;
  std::string text_, side_;
  int tool_;
  double radius_, heading_ = 0;
  bool klartext_, left_ = true, incremental_ = false;
  Place at_{};
};

}  // namespace abbe::testing
