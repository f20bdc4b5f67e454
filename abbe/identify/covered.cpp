#include "abbe/identify/covered.h"

#include <algorithm>
#include <cmath>

#include "abbe/identify/circle_motion.h"

namespace abbe {

std::vector<Covered> covered_by(const Machine& machine, const std::vector<BallbarTest>& tests) {
  std::vector<Covered> out(static_cast<std::size_t>(machine.axis_count()));
  std::vector<bool> seen(out.size());
  const TestAxes axes = test_axes(machine);
  for (const BallbarTest& test : tests) {
    for (const BallbarRun& run : test.runs) {
      const CircleMotion motion(test, run, axes);
      for (std::size_t i = 0; i < motion.size(); ++i) {
        const AxisState state = motion.state(i);
        for (const int axis : {axes[static_cast<std::size_t>(test.plane.first)],
                               axes[static_cast<std::size_t>(test.plane.second)]}) {
          if (axis < 0) continue;
          const auto k = static_cast<std::size_t>(axis);
          out[k].lo = seen[k] ? std::min(out[k].lo, state.q[k]) : state.q[k];
          out[k].hi = seen[k] ? std::max(out[k].hi, state.q[k]) : state.q[k];
          out[k].speed = std::max(out[k].speed, std::abs(state.v[k]));
          out[k].acceleration = std::max(out[k].acceleration, std::abs(state.a[k]));
          seen[k] = true;
        }
      }
    }
  }
  return out;
}

}  // namespace abbe
