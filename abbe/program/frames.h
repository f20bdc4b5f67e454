#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/control_setup.h"

namespace abbe {

/// The coordinate systems of a control, and the way between program position p and the controlled
/// point m in machine coordinates (axis commands), mm:
///
///   m = Rz(rot) (p + g92) + g5x + tlo                                                     (1)
///
/// A rotation that the program makes (G68) turns p about the centre k first: p becomes Rz(a) (p - k) + k. It
/// is only followed in work offsets without a rotation of their own. So are scale, mirror and tilted plane, a
/// matrix M and an origin o: p becomes M p + o, the vector of a correction M^-1 c.
/// source   docs/theory/compensation.md
class Frames {
 public:
  explicit Frames(const ControlSetup& setup);

  void select(int index);  ///< G54 = 0 .. G59.3 = 8, then the further ones
  void set_work_offset(int index, const WorkOffset& offset);
  void set_tool_offset(const Vec3& tlo);
  void set_g92(const Vec3& offset);
  void turn(const Vec3& centre, double angle);  ///< G68, rad; angle 0 ends it
  /// G51, G51.1, G68.2: p becomes matrix p + at. Only in work offsets without a rotation.
  void place(const Mat3& matrix, const Vec3& at);
  void place_nothing();

  [[nodiscard]] int active() const { return active_; }
  [[nodiscard]] int count() const { return static_cast<int>(work_.size()); }
  [[nodiscard]] const std::optional<WorkOffset>& work_offset(int index) const {
    return work_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] bool known() const { return work_[static_cast<std::size_t>(active_)].has_value(); }
  [[nodiscard]] bool turned() const { return angle_ != 0; }
  [[nodiscard]] bool placed() const { return placed_; }
  /// M of `place`, else the identity.
  [[nodiscard]] const Mat3& matrix() const { return matrix_; }
  /// Coordinates mix X, Y and Z: an axis of the program is no axis of the machine.
  [[nodiscard]] bool tilted() const { return tilted_; }
  /// The longest that a program vector of length 1 becomes.
  [[nodiscard]] double stretch() const { return stretch_; }
  /// A circle stays one: all vectors become longer by the same factor.
  [[nodiscard]] bool stretches_evenly() const { return even_; }
  [[nodiscard]] bool rotated() const { return sin_ != 0.0 || cos_ != 1.0; }
  [[nodiscard]] const Vec3& g92() const { return g92_; }
  [[nodiscard]] const Vec3& tool_offset() const { return tlo_; }
  /// Where A B C are zero, rad: r = word + this.
  [[nodiscard]] std::array<double, 3> turn_offset() const {
    return known() ? work_[static_cast<std::size_t>(active_)]->turns : std::array<double, 3>{};
  }
  /// g5x + tlo: where the tool stands at the origin of the work offset.
  [[nodiscard]] const Vec3& datum_point() const { return origin_; }

  [[nodiscard]] Vec3 to_machine(const Vec3& p) const {
    if (placed_) [[unlikely]]
      return matrix_ * p + outer_;
    return rotate(p + inner_, sin_) + outer_;
  }
  [[nodiscard]] Vec3 to_program(const Vec3& m) const {
    if (placed_) [[unlikely]]
      return back_ * (m - outer_);
    return rotate(m - outer_, -sin_) - inner_;
  }
  [[nodiscard]] Vec3 vector_to_program(const Vec3& v) const {
    if (placed_) [[unlikely]]
      return back_ * v;
    return rotate(v, -sin_);
  }
  [[nodiscard]] Vec3 vector_to_machine(const Vec3& v) const {
    if (placed_) [[unlikely]]
      return matrix_ * v;
    return rotate(v, sin_);
  }

 private:
  [[nodiscard]] Vec3 rotate(const Vec3& v, double sine) const {
    if (sine == 0.0 && cos_ == 1.0) return v;
    return {cos_ * v.x() - sine * v.y(), sine * v.x() + cos_ * v.y(), v.z()};
  }
  void refresh();

  std::vector<std::optional<WorkOffset>> work_;
  int active_ = 0;
  Vec3 g92_ = Vec3::Zero(), tlo_ = Vec3::Zero(), origin_ = Vec3::Zero();
  Vec3 inner_ = Vec3::Zero(), outer_ = Vec3::Zero();  ///< added before and after the rotation
  Vec3 centre_ = Vec3::Zero();
  double angle_ = 0;
  double sin_ = 0, cos_ = 1;
  bool placed_ = false, tilted_ = false, even_ = true;
  double stretch_ = 1;
  Mat3 matrix_ = Mat3::Identity(), back_ = Mat3::Identity();  ///< M, M^-1
  Vec3 at_ = Vec3::Zero();
};

}  // namespace abbe
