#pragma once

#include <array>
#include <vector>

namespace abbe {

/// The natural cubic spline that is 1 at one of evenly spaced nodes and 0 at the others, less the line of its
/// trend over the nodes through its middle: no value in the middle, no slope. Beyond the ends it is held.
/// Sums of these, of a constant and of a line are all natural splines with these nodes.
///
/// laws     NodalSplinesHaveNoTrend, NodalSplinesAndALineAreAllNaturalSplines
/// cost     O(1) per value
/// source   docs/theory/identification.md
class NodalSpline {
 public:
  /// Node `node` of `count` (at least 3) over travel[0] < travel[1].
  NodalSpline(std::array<double, 2> travel, int count, int node);

  [[nodiscard]] double operator()(double q) const;
  [[nodiscard]] const std::vector<double>& nodes() const { return nodes_; }

 private:
  [[nodiscard]] double spline(double q) const;

  std::vector<double> nodes_, values_, curvatures_;
  double offset_ = 0, slope_ = 0;
};

}  // namespace abbe
