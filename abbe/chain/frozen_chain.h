#pragma once

#include <array>
#include <span>

#include "abbe/chain/correct.h"
#include "abbe/chain/walk.h"

namespace abbe {

/// The chain with everything frozen but its free axes: constant rigid matrices with motions between them,
///
///     x_w = G_n M_n .. G_2 M_2 G_1 M_1 G_0 x_t
///
/// in the order in which a tool point meets them, M_i = Trans(q u) or Rot(u, q). Errors have the values
/// they take at the commands it was frozen at. Linear axes never turn the tool, so the direction is a
/// problem of the rotary axes alone and the position then a linear one (docs/theory/correction.md,
/// section 3). Axis lines may be skew to each other in any way.
class FrozenChain {
 public:
  using Commands = std::array<double, kMaxAxes>;

  /// Two rotary axes have two solutions, one has one (the best it can do).
  struct Turns {
    enum class Kind {
      found,         ///< the direction is reached, or with fewer than two axes at its minimum
      out_of_reach,  ///< two axes cannot turn the tool there; `change` is as near as they come
    } kind = Kind::found;
    int count = 0;
    std::array<std::array<double, 2>, 2> change{};  ///< rad from the commands: nearest solution first,
                                                    ///< {axis near the tool, axis near the workpiece}
    int resting = -1;  ///< moving axis that turns the tool least: the one to hold where out of reach
  };

  /// ops   Plan::Impl::nominal or, in the rigid model, actual: all other models are not rigid
  /// cost  one walk with three directions; no allocation
  void freeze(const Plan::Impl& plan, std::span<const Op> ops, const Inputs<double>& in, AxisSet free,
              bool* outside);

  /// Turns of the free rotary axes from `q` that bring `tool_axis` to `target` (unit vectors). More than
  /// two free rotary axes: none.
  [[nodiscard]] Turns aim(const Commands& q, const Vec3& tool_axis, const Vec3& target) const;
  [[nodiscard]] int rotary_count() const { return rotary_count_; }
  /// Axis of Turns::change[..][i].
  [[nodiscard]] int rotary(int i) const { return links_[rotary_[static_cast<std::size_t>(i)]].axis; }

  /// Moves the free linear axes of q so that the tip comes to `target`, or as near as they can. Returns
  /// the number of independent directions among them.
  int reach(Commands& q, const Vec3& target) const;

  /// sin of the angle between the lines of the two rotary axes, and between the tool and the axis near
  /// it; the volume spanned by three linear axes (unit directions) at q.
  struct Shape {
    double between_axes = 1, tool_to_axis = 1, volume = 1;
  };
  [[nodiscard]] Shape shape(const Commands& q, const Vec3& tool_axis) const;

 private:
  struct Constant {
    Mat3 r = Mat3::Identity();
    Vec3 t = Vec3::Zero();
  };
  struct Link {
    int axis = 0;
    bool rotary = false;
    Vec3 u = Vec3::UnitZ();
    Constant after;
  };
  /// Columns of the free linear axes and the tip.
  struct Affine {
    Vec3 tip = Vec3::Zero();
    std::array<Vec3, kMaxAxes> column;
    std::array<int, kMaxAxes> axis{};
    std::size_t count = 0;
  };
  [[nodiscard]] Affine affine(const Commands& q) const;
  /// Product of the constant rotations of links [first, last).
  [[nodiscard]] Mat3 rotation(std::size_t first, std::size_t last) const;
  [[nodiscard]] Turns aim_two(const Commands& q, const Vec3& tool_axis, const Vec3& target) const;

  Constant base_;
  std::array<Link, kMaxAxes> links_;
  std::array<std::size_t, kMaxAxes> rotary_{};  ///< links that are rotary
  std::size_t link_count_ = 0;
  int rotary_count_ = 0;
};

}  // namespace abbe
