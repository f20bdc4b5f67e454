// A drilling cycle of the original (G81, G82) that the output has as the motions which the cycle makes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

constexpr int kDwell = 40, kExactStop = 90;  // ten times G4, G9
constexpr double kSpacing = 2;               // mm between samples of a way out
constexpr double kMostSamples = 1000;
constexpr double kSameHeight = 1e-7;  // mm

}  // namespace

/// Every hole: rapids above it and to R, the feed to its bottom (a line like any other), the dwell or a
/// stop, rapids back to R and to the level where the cycle ends. Anything else is V-CYCLE.
void Comparison::cover_drill(const Motion& original) {
  const Cycle& cycle = original.cycle;
  const int axis = cycle.plane == 17 ? 2 : cycle.plane == 18 ? 1 : 0;
  const Axes along = Axes{1} << axis;
  withheld_ &= ~(commanded(original) | along);
  if (withheld_ != 0 || original.feed_mode == 930 ||
      original.start.at[axis] < cycle.retract[axis] - kSameHeight)
    return disagree_and_stop("V-CYCLE", "this cycle is more than the lines and rapids found here");
  Vec3 stood = output_.motion().start.at;
  Vec3 at = original.start.at;
  for (int k = 0; k < cycle.holes && !stop_; ++k) {
    const Vec3 shift = cycle.step * k;
    Motion stroke = original;
    stroke.kind = MotionKind::line;
    stroke.code = 10;
    stroke.named |= along;
    stroke.start.at = cycle.retract + shift;
    stroke.end.at = cycle.bottom + shift;
    stroke.start.known = stroke.end.known = kAllAxes;
    Vec3 above = stroke.start.at;
    above[axis] = at[axis];
    if (!rapid_to(above, above - at, stood) || !drill_hole(stroke, cycle.clear + shift, stood)) return;
    at = cycle.clear + shift;
  }
}

/// From above the hole to the level where the cycle ends. False after a disagreement that ends the
/// comparison. `stood`: the output's command before and after.
bool Comparison::drill_hole(const Motion& stroke, const Vec3& clear, Vec3& stood) {
  const Vec3 down = stroke.end.at - stroke.start.at;
  if (!rapid_to(stroke.start.at, down, stood)) return false;
  reached_.valid = false;
  cover(stroke);
  if (stop_ || !reached_.valid) return false;
  stood = reached_.command;
  if (!stops_at_bottom(stroke) || !rise(stroke, stood)) return false;
  return (clear - stroke.start.at).norm() <= kSameHeight || rapid_to(clear, -down, stood);
}

/// The output's next motion, which must be a rapid in the work offset; false: it is none, and put back.
bool Comparison::pull_rapid(Vec3& end) {
  const Item item = pull();
  const bool rapid = item == Item::motion && output_.motion().kind == MotionKind::rapid &&
                     !output_.motion().machine_words && output_.motion().end.known == kAllAxes;
  if (!rapid) {
    put_back(item);
    return false;
  }
  end = output_.motion().end.at;
  return true;
}

/// The rapid pulled belongs to the cycle. False: it may not be used (reported).
bool Comparison::take_rapid() {
  if (original_.deletable() != output_.deletable())
    disagree("V-EVENT", "one of the blocks can be deleted with '/', the other not");
  output_turns_ = output_.motion().turns_end;
  ++report_.rapid_motions;
  ++report_.points;
  return !stop_ && (!model_.rotary().any() || check_turns(original_.motion(), output_.motion()));
}

/// A rapid to this place of the original, unless the output stands there already.
bool Comparison::rapid_to(const Vec3& place, const Vec3& way, Vec3& stood) {
  follow(way);
  const Vec3 target = model_.nominal(place) + datum_;
  const auto distance = [&](const Vec3& command) {
    return (model_.actual(command, approach_, nullptr) - target).norm();
  };
  const double allowed = allowed_for(quantum());
  Vec3 end = stood;
  bool moved = pull_rapid(end);
  if (moved && distance(end) > allowed && distance(stood) <= allowed) {
    put_back(Item::motion);  // it goes on from here
    moved = false;
  }
  if (moved && !take_rapid()) return false;
  if (moved) stood = end;
  check_reach(place, stood);
  if (const double missed = distance(stood); !(missed <= allowed)) {
    disagree_and_stop("V-CYCLE", fmt::format("a place of this cycle is missed by {:.3f} um, {:.3f} um are "
                                             "allowed, or the rapid to it is missing",
                                             missed / um, allowed / um));
    return false;
  }
  return true;
}

/// G82: its dwell. G81: an exact stop (G9) or a dwell of no time, for else the control may turn back early.
bool Comparison::stops_at_bottom(const Motion& original) {
  const double time = original.cycle.dwell;
  const Item item = pull();
  const bool event = item == Item::event && output_.event().kind == EventKind::g_code;
  const bool dwell = event && output_.event().code == kDwell && output_.event().words == letter_bit('P') &&
                     output_.event().values[0] == time;
  const bool stop = event && output_.event().code == kExactStop && time == 0;
  if (dwell || stop) return true;
  disagree_and_stop("V-CYCLE",
                    fmt::format("the dwell of P{:g}, or the exact stop, at the bottom is missing", time));
  return false;
}

/// The way back to R: rapids in the hole, each of them upwards and within tolerance of its axis.
bool Comparison::rise(const Motion& stroke, Vec3& stood) {
  NominalPath path(model_, stroke, datum_);
  const double length = path.length(), allowed = allowed_for(quantum());
  follow(stroke.start.at - stroke.end.at);
  double lowest = 1;  // s of the last sample
  while (!stop_) {
    const Vec3 from = stood;
    const bool rises = pull_rapid(stood) && (stood - from).norm() > kSameHeight;
    if (!rises || !take_rapid()) {
      disagree_and_stop("V-CYCLE", "the drill is not brought out of the hole at rapid");
      return false;
    }
    const int n = 1 + static_cast<int>(std::min(kMostSamples, (stood - from).norm() / kSpacing));
    for (int i = 1; i <= n; ++i) {
      const double t = static_cast<double>(i) / n;
      const auto foot = path.foot(model_.actual(from + t * (stood - from), approach_, nullptr));
      const bool good = foot.across.norm() <= allowed && (foot.s - lowest) * length <= allowed &&
                        -foot.s * length <= allowed;
      lowest = std::min(lowest, foot.s);
      if (good) continue;
      disagree_and_stop("V-CYCLE",
                        fmt::format("the way out of the hole is {:.3f} um off, or goes down, or beyond R",
                                    foot.across.norm() / um));
      return false;
    }
    check_reach(point_at(stroke, std::clamp(lowest, 0.0, 1.0)), stood);
    if (lowest * length <= allowed) return true;
  }
  return false;
}

}  // namespace abbe::verifying
