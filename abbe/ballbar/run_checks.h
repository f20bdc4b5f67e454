#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/core/diagnostic.h"

namespace abbe {

/// Something about a run that its reader has to tell, with the place it knows.
struct RunFinding {
  Severity severity = Severity::error;
  std::string code;
  std::string message, why, fix;
};

/// Completes a run as it was read: angles continue without jumps at a turn, the direction is the declared
/// one, else the sense of the angle. Reports what cannot be a ball-bar trace of this test: too few samples,
/// angles that jump, stand still or go to and fro, a direction that contradicts the times, lengths that are
/// not those of this radius, positions that are not on the circle.
[[nodiscard]] std::vector<RunFinding> complete_run(const BallbarTest& test, BallbarRun& run,
                                                   std::optional<int> declared);

}  // namespace abbe
