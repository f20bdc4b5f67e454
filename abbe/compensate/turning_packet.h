#pragma once

#include <array>
#include <memory>

#include "abbe/chain/control_kinematics.h"
#include "abbe/chain/plan.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"

namespace abbe {

/// Corrected commands of many places at which two rotary axes turn, found side by side: first where the
/// rotary axes belong (solve), then, when it is decided how they will stand, where the linear ones do
/// (settle).
///
///   solve    tip and tool axis of the machine at q are those of the control at (m, r), + datum
///   settle   the same of the tip alone, for rotary axes that stand at r_out
///
/// A value of solve is within `turn_doubt`, one of settle within `place_doubt` of what CorrectionField gives.
/// units    mm, rad
/// laws     TurningPacket.PlacesAreThoseOfTheField
/// cost     some 150 ns per place, no allocation
class TurningPacket {
 public:
  static constexpr std::size_t kMost = 16;

  TurningPacket(const Plan& plan, const AddressedAxes& axes);

  /// Three linear and two rotary axes, all addressed and correctable, in a chain that the control knows as
  /// built and of which the kernels know everything.
  [[nodiscard]] bool usable() const { return usable_; }

  void set_tool(const Tool& tool);
  /// Place i of those to come: axis commands of the original.
  void command(std::size_t i, const Vec3& m, const Turns& turns);
  void solve(std::size_t count, const Vec3& datum);
  /// The rotary axes of place i will stand here.
  void stand(std::size_t i, const Turns& turns);
  void settle(std::size_t count);

  /// Of place i, after solve. False: outside the volume or a travel (or near their ends), near a singularity
  /// or not converged: it must be asked for alone.
  [[nodiscard]] bool ordinary(std::size_t i) const;
  [[nodiscard]] double turn(std::size_t i, std::size_t axis) const {
    return found_[static_cast<std::size_t>(axes_.rotary[axis])][i];
  }
  [[nodiscard]] double turn_doubt(std::size_t i) const;
  /// After settle.
  [[nodiscard]] Vec3 place(std::size_t i) const;
  [[nodiscard]] double place_doubt(std::size_t i) const;

 private:
  [[nodiscard]] bool within_travels(std::size_t i) const;

  using Rows = std::array<std::array<double, kMost>, kernel::kMaxFlatAxes>;
  std::shared_ptr<const kernel::FlatPlan> flat_;
  const kernel::Kernel* kernel_;
  AddressedAxes axes_;
  std::array<double, kMaxAxes> lo_{}, hi_{};
  kernel::Setting setting_;
  Rows commanded_{}, found_{};
  std::array<double, kMost> turn_steps_{}, place_steps_{};
  std::array<unsigned char, kMost> lanes_{};
  bool usable_ = false;
};

}  // namespace abbe
