#pragma once

#include <functional>
#include <vector>

#include "abbe/core/least_squares.h"
#include "abbe/identify/joint.h"
#include "abbe/identify/joint_design.h"

namespace abbe {

/// How late the clock of every run is: sample i was taken `at` seconds after the time of its angle.
class RunClocks {
 public:
  explicit RunClocks(const std::vector<BallbarTest>& tests);
  [[nodiscard]] double at(std::size_t test, std::size_t run) const { return offset_[first_[test] + run]; }
  [[nodiscard]] double& at(std::size_t test, std::size_t run) { return offset_[first_[test] + run]; }
  [[nodiscard]] std::size_t index(std::size_t test, std::size_t run) const { return first_[test] + run; }
  [[nodiscard]] std::size_t count() const { return offset_.size(); }

 private:
  std::vector<std::size_t> first_;
  std::vector<double> offset_;
};

/// Adds the clocks of all runs as unknowns, each with the prior 0 +- options.time_offset, and iterates from
/// the linear solution `fit` within the combinations it determines. Values, names, covariance and null space
/// of `out` then include them.
///
/// noise    of a test, mm
/// errors   without convergence the clocks stay 0 and a doubt says so
void fit_time_offsets(Identification& out, RunClocks& clocks, const JointDesign& design,
                      const LeastSquaresSolution& fit, const IdentifyOptions& options,
                      const std::function<double(std::size_t)>& noise);

}  // namespace abbe
