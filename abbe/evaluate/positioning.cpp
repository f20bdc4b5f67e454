#include "abbe/evaluate/positioning.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// Lower and upper end of what was seen.
struct Band {
  double lo = 0, hi = 0;
  bool empty = true;

  void add(double a, double b) {
    lo = empty ? a : std::min(lo, a);
    hi = empty ? b : std::max(hi, b);
    empty = false;
  }
  void add(double value) { add(value, value); }
  [[nodiscard]] double width() const { return empty ? 0 : hi - lo; }
};

double sample_deviation(const Eigen::MatrixXd& values, Eigen::Index row, double mean) {
  if (values.cols() < 2) return 0;
  // s^2 = sum (x_j - mean)^2 / (n - 1)
  return std::sqrt((values.row(row).array() - mean).square().sum() / static_cast<double>(values.cols() - 1));
}

PositioningTarget target_of(const RunTable& table, Eigen::Index i) {
  PositioningTarget out;
  out.position = table.targets[static_cast<std::size_t>(i)];
  const bool up = table.forward.cols() > 0, down = table.backward.cols() > 0;
  if (up) out.mean_forward = table.forward.row(i).mean();
  if (down) out.mean_backward = table.backward.row(i).mean();
  if (up) out.s_forward = sample_deviation(table.forward, i, out.mean_forward);
  if (down) out.s_backward = sample_deviation(table.backward, i, out.mean_backward);
  if (!up) out.mean_forward = out.mean_backward;
  if (!down) out.mean_backward = out.mean_forward;
  // B_i = x_f - x_b;  x = (x_f + x_b) / 2
  out.reversal = out.mean_forward - out.mean_backward;
  out.mean = (out.mean_forward + out.mean_backward) / 2;
  // R_i = max(2 s_f + 2 s_b + |B_i|, 4 s_f, 4 s_b); one direction alone has 4 s
  out.repeatability = std::max(4 * out.s_forward, 4 * out.s_backward);
  if (up && down)
    out.repeatability =
        std::max(out.repeatability, 2 * out.s_forward + 2 * out.s_backward + std::abs(out.reversal));
  return out;
}

}  // namespace

bool PositioningFigures::has_spread() const {
  return (runs_forward > 0 || runs_backward > 0) && runs_forward != 1 && runs_backward != 1;
}

PositioningFigures positioning_figures(const RunTable& table) {
  PositioningFigures out;
  out.runs_forward = static_cast<int>(table.forward.cols());
  out.runs_backward = static_cast<int>(table.backward.cols());
  Band E_forward, E_backward, E, A_forward, A_backward, A, M;
  for (Eigen::Index i = 0; i < table.target_count(); ++i) {
    const PositioningTarget& t = out.targets.emplace_back(target_of(table, i));
    M.add(t.mean);
    if (out.runs_forward > 0) {
      E_forward.add(t.mean_forward);
      A_forward.add(t.mean_forward - 2 * t.s_forward, t.mean_forward + 2 * t.s_forward);
      out.R.forward = std::max(out.R.forward, 4 * t.s_forward);
    }
    if (out.runs_backward > 0) {
      E_backward.add(t.mean_backward);
      A_backward.add(t.mean_backward - 2 * t.s_backward, t.mean_backward + 2 * t.s_backward);
      out.R.backward = std::max(out.R.backward, 4 * t.s_backward);
    }
    out.R.both = std::max(out.R.both, t.repeatability);
    out.B = std::max(out.B, std::abs(t.reversal));
    out.mean_reversal += t.reversal / static_cast<double>(table.target_count());
  }
  for (const Band& band : {E_forward, E_backward})
    if (!band.empty) E.add(band.lo, band.hi);
  for (const Band& band : {A_forward, A_backward})
    if (!band.empty) A.add(band.lo, band.hi);
  out.E = {E_forward.width(), E_backward.width(), E.width()};
  out.A = {A_forward.width(), A_backward.width(), A.width()};
  out.M = M.width();
  return out;
}

}  // namespace abbe
