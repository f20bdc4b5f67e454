#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "abbe/machine/machine.h"

namespace abbe {

/// Every combination of positions of the moving axes: the points at which a volume is looked at.
///
/// shapes   positions[i]: those of moving axis i, at least one; an axis with one position is held
/// units    mm (linear axes) | rad (rotary axes)
/// order    index 0 is the first position of every axis; the last axis of the chain runs fastest
struct VolumeGrid {
  std::vector<std::vector<double>> positions;

  /// Product of the counts. 0: an axis without positions, or more points than a size can count.
  [[nodiscard]] std::size_t size() const;
  /// Positions of point `index` < size().
  [[nodiscard]] std::array<double, kMaxAxes> at(std::size_t index) const;
  /// True if axis i has more than one position.
  [[nodiscard]] bool varies(int axis) const;
};

/// `count` positions from lo to hi, both ends exactly; the middle for a count of one.
/// nullopt: not lo < hi (with a count of one: lo > hi), not finite, or no count.
[[nodiscard]] std::optional<std::vector<double>> spaced(double lo, double hi, std::size_t count);

/// Positions per axis that keep a grid of `varying` axes near ten thousand points (always an odd number, so
/// that the middle of the travel is among them): 101, 51, 21, 11, 7, 5, 3 ..
[[nodiscard]] std::size_t default_count(std::size_t varying);

/// The point that deviations are held against unless another one is named: every axis at 0, or at the
/// end of its positions nearest to 0.
[[nodiscard]] std::array<double, kMaxAxes> default_datum(const VolumeGrid& grid);

}  // namespace abbe
