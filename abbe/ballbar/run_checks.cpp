#include "abbe/ballbar/run_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/ballbar/ballbar_file.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kLargestStep = 45 * deg;  // between neighbouring samples
constexpr double kShortestArc = 30 * deg;
constexpr double kMostTravel = 50 * kTurn;    // a run is a few turns at most
constexpr double kLargestDeviation = 2 * mm;  // beyond the travel of any ball bar
constexpr double kOffCircle = 0.05;           // of the radius: positions that belong to another circle
constexpr double kOffCommanded = 0.01;        // of the radius: commands lie on the circle itself

class Checks {
 public:
  Checks(const BallbarTest& test, BallbarRun& run) : test_(test), run_(run) {}

  std::vector<RunFinding> complete(std::optional<int> declared) {
    if (run_.angle.size() < kFewestSamples) {
      error("E-SAMPLES", fmt::format("{} samples", run_.angle.size()),
            fmt::format("at least {} are needed", kFewestSamples), "record the whole arc");
      return std::move(findings_);
    }
    if (!unwrap() || !times_increase() || !direction(declared)) return std::move(findings_);
    lengths();
    if (!run_.actual.empty()) positions(run_.actual, "x_mm y_mm z_mm");
    if (!run_.commanded.empty() && positions(run_.commanded, "x_cmd_mm y_cmd_mm z_cmd_mm")) commands();
    return std::move(findings_);
  }

 private:
  bool unwrap() {
    double variation = 0;
    for (std::size_t i = 1; i < run_.angle.size(); ++i) {
      const double raw = run_.angle[i] - run_.angle[i - 1];
      const double step = std::remainder(raw, kTurn);
      run_.angle[i] = run_.angle[i - 1] + step;
      variation += std::abs(step);
      if (std::abs(step) <= kLargestStep) continue;
      error("E-ANGLE", fmt::format("the angle jumps by {:.1f} deg at sample {}", step / deg, i + 1),
            "samples are missing, or runs are not told apart", "number the runs in a column 'run'");
      return false;
    }
    const double travel = travel_of(run_);
    if (travel < kShortestArc || travel > kMostTravel || travel < 0.9 * variation) {
      error("E-ANGLE",
            variation < kShortestArc ? fmt::format("the angle covers {:.1f} deg only", travel / deg)
            : travel > kMostTravel   ? fmt::format("the angle covers {:.0f} turns", travel / kTurn)
                                     : std::string("the angle goes to and fro"),
            "a run is one arc in one direction", "correct angle_deg, or number the runs in a column 'run'");
      return false;
    }
    return true;
  }

  bool times_increase() {
    for (std::size_t i = 1; i < run_.time.size(); ++i) {
      if (run_.time[i] > run_.time[i - 1]) continue;
      error("E-TIME", fmt::format("time_s does not increase at sample {}", i + 1), "",
            "sort the samples, or leave the column out");
      return false;
    }
    return true;
  }

  bool direction(std::optional<int> declared) {
    const int sense = run_.angle.back() > run_.angle.front() ? +1 : -1;
    run_.direction = declared.value_or(sense);
    if (run_.direction == sense || run_.time.empty()) return true;
    error("E-ANGLE",
          fmt::format("the direction is {}, but the angle {} with time", run_.direction > 0 ? "CCW" : "CW",
                      sense > 0 ? "grows" : "falls"),
          "every sign of backlash and servo mismatch hangs on the direction",
          fmt::format("angles count from +{} towards +{}: correct the direction, the angles or the plane",
                      axis_letter(test_.plane.first), axis_letter(test_.plane.second)));
    return false;
  }

  void lengths() {
    const auto [least, most] = std::minmax_element(run_.deviation.begin(), run_.deviation.end());
    if (*least == *most)
      findings_.push_back({Severity::warning, "W-BALLBAR", "every deviation is the same",
                           "an instrument that measures always shows some change", "check the record"});
    const double largest = std::max(std::abs(*least), std::abs(*most));
    if (largest <= kLargestDeviation) return;
    error("E-RADIUS",
          fmt::format("the bar is up to {:.3f} mm longer or shorter than its nominal {:.3f} mm", largest,
                      test_.radius),
          "a ball bar measures a millimetre or two", "correct the radius or the unit of the column");
  }

  /// True if they may be on the circle.
  bool positions(const std::vector<Vec3>& positions, const char* columns) {
    double off = 0, off_swapped = 0;
    const TestPlane swapped{test_.plane.second, test_.plane.first};
    for (std::size_t i = 0; i < positions.size(); ++i) {
      const Vec3 from_centre = positions[i] - test_.centre;
      off = std::max(off, (from_centre - test_.radius * radial_direction(test_.plane, run_.angle[i])).norm());
      off_swapped = std::max(off_swapped,
                             (from_centre - test_.radius * radial_direction(swapped, run_.angle[i])).norm());
    }
    if (off <= kOffCircle * test_.radius) return true;
    const bool exchanged = off_swapped <= kOffCircle * test_.radius;
    error("E-AXES",
          fmt::format("the positions {} are up to {:.3f} mm away from the circle of {}", columns, off,
                      to_string(test_.plane)),
          exchanged ? "with the two axes exchanged they would be on it" : "",
          exchanged ? fmt::format("the plane is {}, or the columns are swapped", to_string(swapped))
                    : "check centre_mm, radius_mm, the plane and angle_deg");
    return false;
  }

  void commands() {
    double off = 0;
    for (const Vec3& q : run_.commanded)
      off = std::max(off, std::abs((q - test_.centre).norm() - test_.radius));
    if (off <= kOffCommanded * test_.radius) return;
    error("E-RADIUS",
          fmt::format("the positions x_cmd_mm y_cmd_mm z_cmd_mm are up to {:.3f} mm off the radius {:.3f} mm",
                      off, test_.radius),
          "what the servo sees is counted from them",
          "check radius_mm, centre_mm and the counts per mm of the drives");
  }

  void error(std::string code, std::string message, std::string why, std::string fix) {
    findings_.push_back(
        {Severity::error, std::move(code), std::move(message), std::move(why), std::move(fix)});
  }

  const BallbarTest& test_;
  BallbarRun& run_;
  std::vector<RunFinding> findings_;
};

}  // namespace

std::vector<RunFinding> complete_run(const BallbarTest& test, BallbarRun& run, std::optional<int> declared) {
  return Checks(test, run).complete(declared);
}

}  // namespace abbe
