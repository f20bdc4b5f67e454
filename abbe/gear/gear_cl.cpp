#include "abbe/gear/gear_cl.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>

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
    out_radius_ = wheel.centre_distance + approach.down;
  }

  std::string write() {
    header();
    for (std::size_t gap = 0; gap < static_cast<std::size_t>(job_.gear.spec.teeth); ++gap) {
      go_to(gap);
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

  /// The wheel outside the tip cylinder, at any angle and height.
  void outside(double angle, double height) {
    const Mat3 R = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    text_ += "RAPID\n";
    point(
        {R * Vec3(out_radius_, 0, 0) + Vec3(0, 0, job_.cutting.middle + height), sign_ * (R * wheel_.axis)});
  }

  [[nodiscard]] double angle_of(std::size_t gap, double height) const {
    return job_.cutting.first_gap + 2 * std::numbers::pi * static_cast<double>(gap) / job_.gear.spec.teeth +
           job_.gear.turn_per_mm * height;
  }

  /// From the upper end of one gap to the lower end of the next.
  void go_to(std::size_t gap) {
    const double to = angle_of(gap, low_);
    if (gap == 0) return outside(to, low_);
    const double from = angle_of(gap - 1, high_);
    // r (1 - cos(step / 2)) <= clearance / 4
    const double step = 2 * std::acos(std::max(0.0, 1 - job_.cutting.clearance / (4 * out_radius_)));
    const int count = std::clamp(static_cast<int>(std::ceil(std::abs(to - from) / step)), 1, kMostPoints);
    for (int i = 1; i <= count; ++i) {
      const double part = static_cast<double>(i) / count;
      outside(from + part * (to - from), high_ + part * (low_ - high_));
    }
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
    outside(angle_of(gap, high_), high_);
  }

  const GearJob& job_;
  const WheelInGap& wheel_;
  double sign_, tolerance_;
  const PoseChange& change_;
  double low_ = 0, high_ = 0, out_radius_ = 0;
  std::string text_;
};

}  // namespace

std::string write_gear_cl(const GearJob& job, const WheelInGap& wheel, double axis_sign, double tolerance,
                          const PoseChange& change) {
  return Writer(job, wheel, axis_sign, tolerance, change).write();
}

}  // namespace abbe
