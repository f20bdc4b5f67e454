#pragma once

#include <vector>

#include "abbe/ballbar/circle.h"
#include "abbe/ballbar/trace.h"

namespace abbe {

/// Figures of one direction of contouring, in the manner of ISO 230-4; lengths in mm.
struct CircularFigures {
  int direction = +1;
  FittedCircle least_squares;   ///< G about the least-squares centre
  FittedCircle minimum_zone;    ///< G about the centre of the narrowest zone
  double f_max = 0, f_min = 0;  ///< F: radial deviation from the nominal path about the least-squares
                                ///< centre; positive = away from the centre; contains the size error
  double f_max_set_up = 0, f_min_set_up = 0;  ///< F about the centre as it was set up
  double travel = 0;                          ///< rad covered by the runs
  std::size_t samples = 0;
};

/// All of a test. Runs of one direction are one path.
struct TestFigures {
  std::vector<CircularFigures> directions;  ///< one or two: CCW first
  bool both = false;                        ///< the following need both directions
  FittedCircle least_squares_both;          ///< G(b): both paths about one common centre
  FittedCircle minimum_zone_both;
  double mean_radial_deviation = 0;  ///< D: mean radius of both paths about their centres - nominal radius
};

/// errors   a direction whose centre cannot be found has found = false and zeros
/// laws     WorkedExample, BothDirectionsAreAtLeastAsWideAsEach
/// source   docs/theory/ball-bar.md, section 2
[[nodiscard]] TestFigures circular_figures(const BallbarTest& test);

}  // namespace abbe
