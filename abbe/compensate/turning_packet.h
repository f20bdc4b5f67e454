#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "abbe/chain/control_kinematics.h"
#include "abbe/chain/plan.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"

namespace abbe {

/// Corrected commands of many places at which two rotary axes turn, found side by side: first nearly
/// (estimate), then, when it is decided how the rotary axes will stand, in full (settle).
///
///   turn     tip and tool axis of the machine at q are those of the control at (m, r), + datum
///   place    the same of the tip alone, for rotary axes that stand at r_out
///
/// A turn is within `turn_doubt`, a place within `place_doubt` of what CorrectionField gives.
/// units    mm, rad
/// laws     TurningPacket.PlacesAreThoseOfTheField
/// cost     some 80 ns per place, no allocation
class TurningPacket {
 public:
  static constexpr std::size_t kMost = kernel::PoseWork::kMost;

  TurningPacket(const Plan& plan, const AddressedAxes& axes);

  /// Three linear and two rotary axes, all addressed and correctable, in a chain that the control knows as
  /// built and of which the kernels know everything.
  [[nodiscard]] bool usable() const { return usable_; }

  void set_tool(const Tool& tool);
  /// The rotations of all errors together, rad (TurningBend::rotations): the larger they are, the more a step
  /// leaves.
  void set_rotations(double rotations) { trust_ = std::max(1.0, rotations / kCalibrated); }
  /// Place i of those to come: axis commands of the original.
  void command(std::size_t i, const Vec3& m, const Turns& turns);
  void estimate(std::size_t count, const Vec3& datum);
  /// A C of A B C and so on: the rotary axes that there are.
  [[nodiscard]] const std::array<std::size_t, 2>& rotary() const { return rotary_; }
  /// Axis k of A B C goes where its word says, whole turns and all.
  [[nodiscard]] bool goes_as_written(std::size_t k) const { return as_written_[k]; }
  /// Where rotary axis j (0 1, of rotary()) nearly belongs; what is set will be its stand.
  [[nodiscard]] double& stand(std::size_t i, std::size_t j) { return stand_[slot_[j]][i]; }
  void settle();

  /// Of place i, after settle. False: outside the volume or a travel (or near their ends), near a singularity
  /// or not converged: it must be asked for alone.
  [[nodiscard]] bool ordinary(std::size_t i) const {
    return lanes_[i] == kernel::Lane::ordinary && converged(i) && (all_within_ || within_travels(i));
  }
  [[nodiscard]] double turn(std::size_t i, std::size_t j) const { return found_[turn_axis_[j]][i]; }
  [[nodiscard]] double turn_doubt(std::size_t i) const {
    return trust_ * (kLeft * turn_left_[i] + kFieldTurn);
  }
  [[nodiscard]] Vec3 place(std::size_t i) const {
    return {found_[way_axis_[0]][i], found_[way_axis_[1]][i], found_[way_axis_[2]][i]};
  }
  [[nodiscard]] double place_doubt(std::size_t i) const {
    return trust_ * (kLeft * way_left_[i] + kFieldPlace);
  }

 private:
  // What is left behind a Newton step, as a part of it: five times what was found on machines with errors of
  // 100 um and 100 urad. Besides, the field's own answers are left as far from the solution when they end.
  static constexpr double kLeft = 1e-3, kFieldTurn = 2e-10, kFieldPlace = 2e-8;
  // The rotations of those machines, rad; both grow with them.
  static constexpr double kCalibrated = 2e-4;
  // The solution is at most so far from the estimate, rad, and from where the last step began, mm.
  static constexpr double kConvergedTurn = 3e-6, kConvergedPlace = 1e-3;

  [[nodiscard]] bool converged(std::size_t i) const {
    return way_left_[i] < kConvergedPlace &&
           std::abs(turn(i, 0) - estimate_[turn_axis_[0]][i]) < kConvergedTurn &&
           std::abs(turn(i, 1) - estimate_[turn_axis_[1]][i]) < kConvergedTurn;
  }
  [[nodiscard]] bool within_travels(std::size_t i) const;

  using Row = std::array<double, kMost>;
  using Rows = std::array<Row, kernel::kMaxFlatAxes>;
  std::shared_ptr<const kernel::FlatPlan> flat_;
  const kernel::Kernel* kernel_;
  std::array<std::size_t, 3> way_axis_{};  ///< of X Y Z: the machine's axes
  std::array<std::size_t, 2> rotary_{}, turn_axis_{}, slot_{};
  std::array<double, kMaxAxes> lo_{}, hi_{};
  kernel::Setting setting_;
  kernel::PoseWork work_{};
  alignas(64) Rows commanded_{}, estimate_{}, found_{};
  std::array<Row, 2> stand_{};  ///< in the order of the machine's axes
  Row turn_left_{}, way_left_{};
  std::array<unsigned char, kMost> lanes_{};
  std::array<bool, 3> as_written_{};
  double trust_ = 1;  ///< factor of the doubts
  bool usable_ = false, all_within_ = false;
};

}  // namespace abbe
