#pragma once

#include <array>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/volume/grid.h"

namespace abbe {

/// Positions on a diagonal, both ends included.
inline constexpr std::size_t kDiagonalPoints = 41;

/// A line through the volume, measured as a laser along it would: ISO 230-6 in manner. With u the unit vector
/// from the first nominal tip to the last one and d the deviation,
///
///   e(s) = u . (d(s) - d(0)),   s = nominal distance from the start                              (1)
///
/// mm. `forward` travels from the start to the end, every axis with its direction of approach;
/// `backward` the other way; d(0) is the mean of both at the start, so that change, range and reversal do not
/// depend on the datum.
struct Diagonal {
  struct Point {
    double s = 0, forward = 0, backward = 0;
  };
  std::vector<int> axes;   ///< that move: two (face) or three (body)
  std::vector<int> signs;  ///< of each: +1 from the low end to the high end, -1 the other way
  std::array<double, kMaxAxes> from{}, to{};
  double length = 0;    ///< nominal, mm
  double change = 0;    ///< mean of both directions at the end: by how much it is too long
  double range = 0;     ///< max - min over both directions (bidirectional systematic deviation E)
  double reversal = 0;  ///< largest |forward - backward| (B)
  std::vector<Point> points;
};

/// "+X -Y" of a diagonal.
[[nodiscard]] std::string name_of(const Diagonal& diagonal, const Machine& machine);

/// The linear axes that span the volume: those with more than one position, at most three (axes with a digit
/// in the name, then U V W are left out first), by name.
[[nodiscard]] std::vector<int> diagonal_axes(const Machine& machine, const VolumeGrid& grid);

/// The face diagonals (two per pair of axes) and, of three axes, the four body diagonals; none of fewer than
/// two axes. Axes that do not move stand at `rest`.
/// errors   a diagonal whose numbers are too large is left out
/// laws     SquarenessChangesFaceDiagonalsOppositely
[[nodiscard]] std::vector<Diagonal> diagonals(const Plan& plan, const VolumeGrid& grid, const Tool& tool,
                                              const std::array<double, kMaxAxes>& rest);

}  // namespace abbe
