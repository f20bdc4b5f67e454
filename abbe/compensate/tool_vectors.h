#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "abbe/chain/control_kinematics.h"
#include "abbe/core/linear_algebra.h"

namespace abbe {

/// The tool's direction as two rotary axes give it, and back. With the axis n next to the workpiece (the
/// outer one), the axis d next to the tool (the inner one), and the tool's direction a at home:
///
///   v(r) = Rot(n, s_n r_n) Rot(d, s_d r_d) a,   s = +1 of axes that carry the tool, -1 of those that carry
///                                               the workpiece
///
/// v is fixed to the table, from the tip to the spindle. Most directions are given by two positions; the
/// control is said to take the nearer one ([control] vectors.turns = "nearest"), and what is not clearly
/// nearer by any measure is refused.
/// laws     TheVectorOfItsTurnsLeadsBack, NearestIsNearInBothAxes, TheOuterAxisStaysAtThePole
/// cost     about 100 ns, no allocation
/// source   docs/theory/five-axes.md
class ToolVectors {
 public:
  ToolVectors(const Machine& machine, const AddressedAxes& axes);

  enum class Trouble {
    none,
    axes,         ///< not exactly two rotary axes that can tilt the tool
    unreachable,  ///< no position gives this direction
    travel,       ///< none within the travels
    pole,         ///< so near to the outer axis that this would turn far for almost nothing
    several,      ///< two positions, and which is nearer depends on how one measures
  };
  struct Answer {
    Turns turns{};  ///< rad, counted through whole turns; axes that are not of the two stay
    Trouble trouble = Trouble::none;
  };
  /// Where the control turns from `from` for the direction `v`, of any length above zero.
  [[nodiscard]] Answer turns_of(const Vec3& v, const Turns& from) const;
  /// v(r), of length one.
  [[nodiscard]] Vec3 vector_of(const Turns& turns) const;

 private:
  struct Axis {
    std::size_t letter = 0;         ///< 0 1 2 = A B C
    Vec3 direction = Vec3::Zero();  ///< times its sign s
    std::array<double, 2> travel{};
  };
  struct Candidate {
    double outer = 0, inner = 0;  ///< rad
    bool near_pole = false;
  };
  [[nodiscard]] std::optional<Candidate> candidate(const Vec3& v, double inner, const Turns& from) const;
  [[nodiscard]] static Trouble choose(std::array<std::optional<Candidate>, 2>& found, const Turns& from,
                                      const Axis& outer, const Axis& inner);

  bool usable_ = false;
  Axis outer_, inner_;
  Vec3 tool_ = Vec3::UnitZ();
};

}  // namespace abbe
