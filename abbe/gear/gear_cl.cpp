#include "abbe/gear/gear_cl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "abbe/core/number.h"

namespace abbe {
namespace {

// So many that a machine of three axes, which cannot give way, still reaches what they say within 1e-8 mm.
constexpr int kLengthDecimals = 9, kAxisDecimals = 12;
constexpr int kPointsWithChange = 17;  // a correction changes over the face
constexpr int kMostPoints = 2000;

class Writer {
 public:
  Writer(const GearJob& job, const WheelInGap& wheel, double axis_sign, double tolerance,
         const PoseChange& change)
      : job_(job), wheel_(wheel), sign_(axis_sign), tolerance_(tolerance), change_(change) {
    const Stroke stroke = stroke_of(job, wheel);
    const Approach approach = approach_of(job);
    low_ = stroke.low - approach.along;
    high_ = stroke.high + approach.along;
  }

  std::string write() {
    header();
    for (std::size_t gap = 0; gap < static_cast<std::size_t>(job_.gear.spec.teeth); ++gap) {
      for (const TipAndAxis& pose : poses_before_gap(job_, wheel_, gap, sign_)) rapid_to(pose);
      stroke(gap);
    }
    text_ += "FINI\n";
    return std::move(text_);
  }

 private:
  void header() {
    std::string name;
    for (const char c : job_.gear.spec.name)
      name += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == ' ' || c == '.' ? c : '-';
    text_ += fmt::format("PARTNO {}\n", name.empty() ? "GEAR" : name);
    text_ += fmt::format(
        "$$ {} gaps, wheel diameter {:g} mm; wheel centre and wheel axis in the workpiece frame\n",
        job_.gear.spec.teeth, job_.wheel.diameter);
    text_ += "UNITS/MM\nMULTAX/ON\n";
  }

  void point(const TipAndAxis& pose) {
    text_ += "GOTO/";
    for (int i = 0; i < 6; ++i) {
      if (i > 0) text_ += ',';
      append_fixed(text_, i < 3 ? pose.position[i] : pose.tool_axis[i - 3],
                   i < 3 ? kLengthDecimals : kAxisDecimals);
    }
    text_ += '\n';
  }

  void rapid_to(const TipAndAxis& pose) {
    text_ += "RAPID\n";
    point(pose);
  }

  /// Straight pieces of a helix of radius a and of the crowning's parabola.
  [[nodiscard]] int pieces() const {
    const double length = high_ - low_, b = job_.gear.spec.face_width;
    const double helix =
        std::abs(job_.gear.turn_per_mm) * length * std::sqrt(wheel_.centre_distance / (8 * tolerance_));
    // |c''| = 8 C / (b^2 sin phi); sin phi is not below 0.1.
    const double crowning = length / b * std::sqrt(job_.gear.spec.helix_crowning * 10 / tolerance_);
    const int least = change_ ? kPointsWithChange : 1;
    return std::clamp(static_cast<int>(std::ceil(std::max(helix, crowning))), least, kMostPoints);
  }

  void stroke(std::size_t gap) {
    text_ += fmt::format("$$ gap {}\nFEDRAT/MMPM,{:.3f}\n", gap + 1, job_.cutting.feed * 60);
    const int count = pieces();
    for (int i = 0; i <= count; ++i) {
      const double height = low_ + (high_ - low_) * i / count;
      const TipAndAxis nominal = wheel_pose(job_, wheel_, gap, height, sign_);
      point(change_ ? change_(gap, height, nominal) : nominal);
    }
    rapid_to(pose_after_gap(job_, wheel_, gap, sign_));
  }

  const GearJob& job_;
  const WheelInGap& wheel_;
  double sign_, tolerance_;
  const PoseChange& change_;
  double low_ = 0, high_ = 0;
  std::string text_;
};

}  // namespace

std::string write_gear_cl(const GearJob& job, const WheelInGap& wheel, double axis_sign, double tolerance,
                          const PoseChange& change) {
  return Writer(job, wheel, axis_sign, tolerance, change).write();
}

}  // namespace abbe
