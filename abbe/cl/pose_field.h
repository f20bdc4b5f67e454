#pragma once

#include <array>
#include <optional>

#include "abbe/chain/solve_path.h"
#include "abbe/cl/motion.h"
#include "abbe/machine/control_setup.h"

namespace abbe::cl {

using Commands = std::array<double, kMaxAxes>;

/// Where the program's frame stands in the workpiece frame: w = rotation p + origin.
/// With G54 given: its origin is where a spindle nose (no tool) stands when the axes are at the offset and
/// the rotary axes at zero; its rotation is about Z. Without: the workpiece frame itself.
struct Placement {
  Mat3 rotation = Mat3::Identity();
  Vec3 origin = Vec3::Zero();  ///< mm
  [[nodiscard]] Vec3 to_workpiece(const Vec3& p) const { return rotation * p + origin; }
  [[nodiscard]] Vec3 to_program(const Vec3& w) const { return rotation.transpose() * (w - origin); }
};
[[nodiscard]] Placement placement_of(const Plan& plan, const std::optional<WorkOffset>& offset);

/// Axis commands that hold the tip of `tool` at a point of the workpiece, rotary axes at zero: the linear
/// axes by least squares.
[[nodiscard]] Query at_rest(const Plan& plan, const Tool& tool, const Vec3& w);

/// The correction of CL data: a pose p becomes the pose p' whose commands, as an ideal post-processor finds
/// them, are those that bring the real tool to p.
///
///   q = post(p),   axis' = nominal axis at correct(q),   tip': actual_tip(post(tip', axis')) = tip(p) + D0
///
/// post   the ideal inverse of the machine's chain, on one branch along the path
/// D0     the deviation at the program's origin, rotary axes at zero, for a probed datum, else 0
/// source docs/theory/cl-data.md
class PoseField {
 public:
  PoseField(const Plan& plan, const Placement& placement, bool probed, AxisSet free, const Commands& start);

  void set_tool(const Tool& tool);
  [[nodiscard]] const Vec3& datum() const { return datum_; }

  enum class Trouble { none, unreachable, failed, outside, travel };
  /// A pose and what the post-processor makes of it.
  struct Place {
    ToolPose pose;  ///< as in the program
    Commands q{};
    Side side;
    bool singular = false;  ///< nearer than 1 deg to where the rotary axes turn the tool about one line
    Trouble trouble = Trouble::none;
    int axis = 0;  ///< of `travel`
  };

  /// The next pose of the path: unwrapped, on the branch of the one before.
  [[nodiscard]] Place follow(const ToolPose& pose);
  /// A pose between two others.
  [[nodiscard]] Place between(const ToolPose& pose, const Place& a, const Place& b, double s) const;

  /// The tool axis to write, in the program's frame; that of the pose where the correction cannot turn it.
  [[nodiscard]] Vec3 corrected_axis(const Place& place) const;

  /// Commands that bring the real tool to the pose: where the axes are commanded directly. The rotary axes
  /// stay unless `turn`, and near the singularity.
  [[nodiscard]] Correction corrected_commands(const Place& place, bool turn) const;
  /// Tip of the tool at these commands, with all errors or without any (`ideal`), minus what is wanted at
  /// `place` (ideal: without the datum), mm.
  [[nodiscard]] Vec3 off_at(const Place& place, const Commands& q, bool ideal) const;

  struct Answer {
    Vec3 tip = Vec3::Zero();  ///< to write
    Commands q{};             ///< what the post-processor makes of it
    Trouble trouble = Trouble::none;
    int axis = 0;
  };
  /// The tip to write when `axis` is written: `first_guess` is where the search starts.
  [[nodiscard]] Answer corrected_tip(const Place& place, const Vec3& axis, const Vec3& first_guess) const;

  /// What is left at `place` when `written` is in the file: actual tip - (nominal tip + D0), mm; nullopt: not
  /// reachable.
  [[nodiscard]] std::optional<Vec3> left_at(const Place& place, const ToolPose& written) const;

 private:
  [[nodiscard]] InverseResult post(const ToolPose& pose, const Commands& near, int side) const;
  [[nodiscard]] Place place_of(const ToolPose& pose, const InverseResult& found) const;
  [[nodiscard]] Vec3 target(const ToolPose& pose) const { return placement_.to_workpiece(pose.tip) + datum_; }
  [[nodiscard]] Query query(const Commands& q) const;
  void check(const Commands& q, Trouble& trouble, int& axis) const;

  Plan plan_;
  Placement placement_;
  bool probed_;
  AxisSet free_;
  int rotary_axes_ = 0;  ///< free ones
  AxisSet rotary_ = 0;
  Tool tool_;
  Vec3 datum_ = Vec3::Zero();
  PathSolver path_;
};

}  // namespace abbe::cl
