#pragma once

#include <optional>

#include "abbe/chain/solve_path.h"
#include "abbe/machine/control_setup.h"

namespace abbe::cl::verifying {

/// What a file's pose makes the machine do, in the program's frame.
struct Outcome {
  std::array<double, kMaxAxes> commands{};
  Vec3 tip = Vec3::Zero();    ///< of the real tool, datum taken off, mm
  Vec3 axis = Vec3::UnitZ();  ///< of the real tool, unit vector
  bool reachable = false, outside = false;
  int side = 0;     ///< of the singularity, +1 or -1; 0: none
  int beyond = -1;  ///< axis past its travel
};

/// The forward model of the verification: ideal post-processor, then the machine with its errors.
class ForwardMachine {
 public:
  ForwardMachine(const Plan& plan, AxisSet free, const std::optional<WorkOffset>& offset, bool probed,
                 const std::array<double, kMaxAxes>& start);

  void use_tool(const Tool& tool);
  /// The next pose of the original: its branch follows the one before.
  [[nodiscard]] Outcome along(const Vec3& tip, const Vec3& axis);
  /// Any other pose, near known commands and on their side of the singularity (0: on any).
  [[nodiscard]] Outcome near(const Vec3& tip, const Vec3& axis, const std::array<double, kMaxAxes>& commands,
                             int side) const;
  [[nodiscard]] Vec3 in_workpiece(const Vec3& p) const { return turn_ * p + zero_; }
  [[nodiscard]] Vec3 vector_in_workpiece(const Vec3& v) const { return turn_ * v; }
  [[nodiscard]] const Vec3& removed() const { return removed_; }

 private:
  [[nodiscard]] Outcome act(const InverseResult& post, const Vec3& axis) const;
  [[nodiscard]] Query with_linear(const Vec3& w) const;

  Plan plan_;
  AxisSet free_;
  bool probed_;
  Mat3 turn_ = Mat3::Identity();
  Vec3 zero_ = Vec3::Zero(), removed_ = Vec3::Zero();
  Tool tool_;
  PathSolver solver_;
};

}  // namespace abbe::cl::verifying
