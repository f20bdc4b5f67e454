#pragma once

#include <array>
#include <cstdint>

#include "abbe/chain/inverse.h"

namespace abbe {

struct PathOptions {
  AxisSet free = 0;
  bool ideal = false;         ///< poses: of the nominal machine, errors ignored
  CorrectOptions correction;  ///< method, weights, limits
  /// Only between two points that are both nearer to the singularity than this sine may a path of poses
  /// go over to the other branch: there the way across is short, elsewhere it is a swing of half a turn.
  double singular_cone = 0.1;
};

/// What happened between neighbours. Only solved points count.
struct PathReport {
  std::uint64_t points = 0;                          ///< solved
  std::array<double, kMaxAxes> largest_step{};       ///< per moving axis, mm or rad, without sign
  std::array<std::uint64_t, kMaxAxes> largest_at{};  ///< the point that ends it, all points counted from 1
  std::uint64_t branch_changes = 0;                  ///< points on another side than the one before
};

/// Solves the points of a path one after the other, in constant memory: each goes on from the one before.
/// Rotary axes are unwrapped, and the branch is kept.
///
/// laws   OnePathKeepsItsBranch, UnwrappedStepsAreSmall, PointsOfAPathEqualSinglePoints
/// cost   that of `inverse` or `correct` per point; nothing grows
/// source docs/theory/correction.md, section 8
class PathSolver {
 public:
  /// start  where the machine stands; first poses are sought from there
  PathSolver(const PathOptions& options, const std::array<double, kMaxAxes>& start)
      : options_(options), last_(start) {}

  /// Commands for the next tool pose: the solution nearest to the one before, on the same side of the
  /// singularity unless both points are in the singular cone or the travels leave no other way.
  [[nodiscard]] InverseResult pose(const Plan& plan, const Tool& tool, const Vec3& position,
                                   const Vec3& direction);

  /// Corrected commands for the next commands of a path. Rotary commands in `query` are first moved by
  /// whole turns to the ones before, where the travel allows it: errors are those of the position the axis
  /// then has. The iteration starts at the correction of the point before.
  [[nodiscard]] Correction command(const Plan& plan, Query& query);

  /// The point just solved is on another side of the singularity than the one before.
  [[nodiscard]] bool branch_changed() const { return branch_changed_; }
  [[nodiscard]] const PathReport& report() const { return report_; }

 private:
  void unwrap(const Plan& plan, Query& query) const;
  void note(int axes, const std::array<double, kMaxAxes>& solved, const Side& side);

  PathOptions options_;
  std::array<double, kMaxAxes> last_;                       ///< solved commands of the point before
  std::array<double, kMaxAxes> last_command_{}, change_{};  ///< of command(): input, corrected - input
  Side side_;
  std::uint64_t seen_ = 0;  ///< points, solved or not
  bool branch_changed_ = false;
  PathReport report_;
};

}  // namespace abbe
