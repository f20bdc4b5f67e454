#pragma once

#include <array>
#include <optional>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/identify/model_term.h"

namespace abbe {

/// How a machine's axes serve the axes X Y Z of a circular test: index of the moving axis of that name.
using TestAxes = std::array<int, 3>;

/// The linear axes of the machine named X, Y, Z; -1 where there is none.
[[nodiscard]] TestAxes test_axes(const Machine& machine);

/// Motion along one run, per sample.
///
///     q = centre + R u(t),  q' = R u'(t) t',  q'' = R (u''(t) t'^2 + u'(t) t'')
///
/// t' and t'' are fitted to the times of 2 kHalfWindow + 1 samples (a parabola); without times the feed is
/// steady: t' = s v / R. Recorded positions replace q and leave the rates.
class CircleMotion {
 public:
  static constexpr std::size_t kHalfWindow = 5;

  CircleMotion(const BallbarTest& test, const BallbarRun& run, const TestAxes& axes);

  /// At sample i, `shift` seconds later (along the motion of that sample).
  [[nodiscard]] AxisState state(std::size_t i, double shift = 0) const;
  /// Of sample i, rad.
  [[nodiscard]] double angle(std::size_t i, double shift = 0) const;
  /// Where the bar points: the angle, or, where positions were recorded, that of the actual one. With a lag
  /// the two differ, and a rotation about the centre would seem to lengthen the bar.
  [[nodiscard]] double bar_angle(std::size_t i, double shift = 0) const;
  [[nodiscard]] double angular_rate(std::size_t i) const { return rate_[i]; }
  /// False near a reversal of one of the two axes, within `window` seconds: the sense is not sure there.
  [[nodiscard]] bool sense_is_sure(std::size_t i, double window) const;
  [[nodiscard]] std::size_t size() const { return run_->angle.size(); }

 private:
  const BallbarTest* test_;
  const BallbarRun* run_;
  TestAxes axes_;
  std::vector<double> rate_, acceleration_;  ///< rad/s, rad/s^2
};

}  // namespace abbe
