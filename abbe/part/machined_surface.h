#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "abbe/part/cutter.h"
#include "abbe/part/sweep.h"

namespace abbe {

/// What is left of a part after a cutter went along pieces of way: the surface, asked point by point.
///
///     deviation(P) = least t in [-reach, reach] at which P + t n is inside what was swept
///
/// n points out of the material, so that material left on counts +, material missing -. The stock is taken to
/// be everywhere: a point that no piece reaches within `reach` is uncut.
///
/// A tree of boxes over the pieces, four to a leaf; the nearest box along the line is opened first, and none
/// beyond the best entry found so far.
///
/// errors   nullopt: uncut. A cut deeper than `reach` gives -reach.
/// laws     EqualsTheBruteForceReference, APerfectBallLeavesTheKnownScallop, MoreCuttingNeverAddsMaterial
/// cost     building: O(n log n), 0.7 us per piece; 200 bytes per piece; asking: about 30 us where the
///          passes of 100000 pieces of a 3 mm ball lie 0.25 mm apart (docs/performance.md); immutable, shared
///          by threads
/// source   Kay, Kajiya: Ray tracing complex scenes (1986), for the tree
class MachinedSurface {
 public:
  /// cutter is_valid(), numbers of the pieces are finite.
  MachinedSurface(const Cutter& cutter, std::vector<SweepPiece> pieces);

  [[nodiscard]] std::optional<double> deviation(const Vec3& point, const Vec3& normal, double reach) const;
  [[nodiscard]] std::size_t piece_count() const { return pieces_.size(); }

 private:
  struct Box {
    Vec3 low, high;
  };
  /// A leaf holds pieces first .. first + count; another has its children at `first` and `first` + 1.
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;
  };
  [[nodiscard]] Box box_of(const SweepPiece& piece) const;
  void split(std::size_t node, const std::vector<Box>& boxes, std::vector<std::uint32_t>& order);

  Cutter cutter_;
  std::vector<SweepPiece> pieces_;  ///< in the order of the leaves
  std::vector<Node> nodes_;
};

}  // namespace abbe
