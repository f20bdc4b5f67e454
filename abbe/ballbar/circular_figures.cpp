#include "abbe/ballbar/circular_figures.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// Samples of all runs of one direction (0: of both).
struct Path {
  std::vector<double> angle, deviation;
  double travel = 0;
};

Path path_of(const BallbarTest& test, int direction) {
  Path path;
  for (const BallbarRun& run : test.runs) {
    if (direction != 0 && run.direction != direction) continue;
    path.angle.insert(path.angle.end(), run.angle.begin(), run.angle.end());
    path.deviation.insert(path.deviation.end(), run.deviation.begin(), run.deviation.end());
    path.travel += travel_of(run);
  }
  return path;
}

CircularFigures figures_of(const Path& path, int direction) {
  CircularFigures out;
  out.direction = direction;
  out.travel = path.travel;
  out.samples = path.angle.size();
  out.least_squares = least_squares_circle(path.angle, path.deviation);
  out.minimum_zone = minimum_zone_circle(path.angle, path.deviation);
  // F = r' about the centre, size error included
  out.f_max = out.least_squares.high;
  out.f_min = out.least_squares.low;
  const auto [least, most] = std::minmax_element(path.deviation.begin(), path.deviation.end());
  out.f_min_set_up = *least;
  out.f_max_set_up = *most;
  return out;
}

}  // namespace

TestFigures circular_figures(const BallbarTest& test) {
  TestFigures out;
  for (const int direction : {+1, -1}) {
    const Path path = path_of(test, direction);
    if (!path.angle.empty()) out.directions.push_back(figures_of(path, direction));
  }
  out.both = out.directions.size() == 2;
  if (!out.both) return out;
  const Path path = path_of(test, 0);
  out.least_squares_both = least_squares_circle(path.angle, path.deviation);
  out.minimum_zone_both = minimum_zone_circle(path.angle, path.deviation);
  // D = (mean_ccw + mean_cw) / 2
  out.mean_radial_deviation =
      (out.directions[0].least_squares.mean + out.directions[1].least_squares.mean) / 2;
  return out;
}

}  // namespace abbe
