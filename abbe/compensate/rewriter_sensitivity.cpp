// What the result owes to numbers that only the user knows: work offsets and gauge lengths.

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"

namespace abbe {
namespace {

constexpr double kStep = 1;  // mm

}  // namespace

// By differences: the correction for a stated offset or length that is 1 mm off, less the one for the true
// one. The work offset takes the datum along with the place.
std::optional<RewriteReport::Sensitivity> Rewriter::sensitivity() {
  constexpr unsigned linear = 7;
  if (needed_ != linear) return std::nullopt;
  RewriteReport::Sensitivity most;
  const auto correction = [&](const Extreme& place, const Vec3& offset,
                              double length) -> std::optional<Vec3> {
    field_.set_tool(tool_of(machine_, place.gauge + length));
    field_.set_datum_point(place.datum + offset);
    const Vec3 m = place.m + offset;
    const auto answer = field_.at(m);
    if (answer.trouble != CorrectionField::Trouble::none) return std::nullopt;
    return Vec3(answer.q - m);
  };
  // nothing was corrected: where the program ends
  const bool none =
      std::none_of(extremes_.begin(), extremes_.end(), [](const Extreme& place) { return place.set; });
  if (none && known_ == linear) extremes_[0] = {in_.m, in_.frames.datum_point(), gauge_, true};
  for (const Extreme& place : extremes_) {
    const auto stated = place.set ? correction(place, Vec3::Zero(), 0) : std::nullopt;
    if (!stated) continue;
    const auto change = [&](const Vec3& offset, double length) {
      auto other = correction(place, offset, length);
      if (!other) other = correction(place, -offset, -length);  // beyond the travel
      return other ? (*other - *stated).norm() / kStep : 0.0;
    };
    // in any direction at most the root of the sum of squares
    const Vec3 by_axis(change(kStep * Vec3::UnitX(), 0), change(kStep * Vec3::UnitY(), 0),
                       change(kStep * Vec3::UnitZ(), 0));
    most.offset = std::max(most.offset, by_axis.norm());
    most.length = std::max(most.length, change(Vec3::Zero(), kStep));
  }
  return most;
}

}  // namespace abbe
