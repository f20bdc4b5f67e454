#pragma once

#include <array>
#include <optional>

#include "abbe/chain/correct.h"
#include "abbe/chain/plan.h"

namespace abbe {

/// Positions of the rotary axes addressed A, B and C, rad; 0 for those a machine does not have.
using Turns = std::array<double, 3>;

/// The axes a program addresses, as indices of moving axes; -1: the machine has none.
struct AddressedAxes {
  std::array<int, 3> linear{-1, -1, -1};  ///< X Y Z
  std::array<int, 3> rotary{-1, -1, -1};  ///< A B C
};
[[nodiscard]] AddressedAxes addressed_axes(const Machine& machine);

/// y = A x + b, mm.
struct Affine {
  Mat3 A = Mat3::Identity();
  Vec3 b = Vec3::Zero();
  [[nodiscard]] Vec3 operator()(const Vec3& x) const { return A * x + b; }
};
[[nodiscard]] Affine after(const Affine& first, const Affine& second);  ///< second(first(x))
[[nodiscard]] std::optional<Affine> inverse(const Affine& map);         ///< nullopt: |det A| < 1e-3

/// What a control makes of programmed points (docs/theory/five-axes.md). It knows the nominal chain by its
/// own numbers (Machine::control), and a tool length L.
///
///   tip(m, r; L)   of the believed chain, workpiece axes
///   axis mode      the program states m and r, the commands of the linear and the rotary axes
///   TCP            the program states v and r; the control seeks m with  tip(m, r; L) = tip(v, 0; L)   (1)
///
/// So v is where the linear axes would stand with all rotary axes at zero and the tip at the same place of
/// the workpiece: the programmed frame is fixed to the table. A point of a program passes through work
/// offsets and tool offset to m in axis mode and to v with TCP, by the same sums.
/// laws     TcpOfATiltingTableIsTheFormulaOfItsDesigners, PointsAndAxesAreInverse
/// source   docs/theory/five-axes.md
class ControlKinematics {
 public:
  ControlKinematics(const Machine& machine, const AddressedAxes& axes);

  [[nodiscard]] const Machine& believed() const { return believed_.machine(); }
  /// m -> tip of `tool` at these turns.
  [[nodiscard]] Affine tip_of_axes(const Turns& turns, const Tool& tool) const;
  /// v -> m with the control's tool length, (1). nullopt: the linear axes cannot reach every point.
  [[nodiscard]] std::optional<Affine> axes_of_points(const Turns& turns, double length) const;
  /// Tip and direction of a tool at commands m, r.
  [[nodiscard]] TipAndAxis pose(const Vec3& m, const Turns& turns, const Tool& tool) const;

 private:
  [[nodiscard]] Query query(const Vec3& m, const Turns& turns, const Tool& tool) const;
  Plan believed_;
  AddressedAxes axes_;
};

}  // namespace abbe
