// Motions of which points count: rapids, moves in machine coordinates, moves home, canned cycles.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

constexpr double kSameWord = 1e-9;     // mm: words that are equal in the text
constexpr double kSameCommand = 1e-7;  // mm: the same axis command, computed through two frames
constexpr double kStrokeSpacing = 2;   // mm
constexpr double kMaxSamples = 1e5;    // of one cycle block

Axes bit(int axis) { return Axes{1} << axis; }

bool same_words(const Motion& a, const Motion& b) {
  for (std::size_t k = 0; k < 3; ++k)
    if ((a.named_turns >> k & 1) != 0 && !(std::abs(a.turn_words[k] - b.turn_words[k]) <= kSameWord))
      return false;
  return a.named == b.named && a.named_turns == b.named_turns && a.incremental == b.incremental &&
         (a.words - b.words).cwiseAbs().maxCoeff() <= kSameWord;
}

/// The part of a step along the holes that are drilled in this frame: n (n . step).
Vec3 along_hole(const Frames& frames, const Vec3& step) {
  const Vec3 n = vector_of(frames, Vec3::UnitZ()).normalized();
  return n * n.dot(step);
}

}  // namespace

/// The machine axes that a motion commands by its words. In a rotated frame X and Y move together.
Axes Comparison::commanded(const Motion& original) const {
  constexpr Axes plane_xy = 3;
  const bool turned = !original.machine_words && original_.frames().rotation() != 0;
  return turned && (original.named & plane_xy) != 0 ? original.named | plane_xy : original.named;
}

/// Approach after a motion of which only some axes may be known.
void Comparison::follow_known(const Motion& original) {
  Vec3 direction = original.end.at - original.start.at;
  for (int i = 0; i < 3; ++i)
    if ((original.start.known & original.end.known & bit(i)) == 0) direction[i] = 0;
  follow(direction);
}

/// A rapid whose end is known in all axes: the corrected axes must bring the tip where it belongs, the
/// withheld ones must stay where they are. Of `unjudged` axes the output says where they are.
void Comparison::compare_rapid(const Motion& original, const Motion& output, Axes unjudged) {
  withheld_ &= ~commanded(original);
  follow_known(original);
  if (output.end.known != kAllAxes)
    return disagree("V-END", "an axis position is not known after this rapid");
  const Vec3 target = model_.nominal(original.end.at) + datum_;
  const Vec3 deviation = model_.actual(output.end.at, approach_, nullptr) - target;
  ++report_.points;
  if (!check_withheld(original, output)) return;
  // Deviation in steps of the axes; what withheld axes leave is theirs.
  Vec3 steps = model_.command_step(deviation);
  for (int i = 0; i < 3; ++i)
    if (((withheld_ | unjudged) & bit(i)) != 0) steps[i] = 0;
  // X and Y of the frame belong to the hole below, and are looked at there.
  if (original.to_hole && output.to_hole)
    steps = original.with_height ? Vec3::Zero() : along_hole(original_.frames(), steps);
  const double distance = model_.nominal_step(steps).norm();
  const double allowed = allowed_for(quantum());
  if (!(distance <= allowed))
    disagree("V-END", fmt::format("this motion ends {:.3f} um from its target, {:.3f} um are allowed",
                                  distance / um, allowed / um));
  check_reach(original.end.at, output.end.at);
  if (original.turns() || original.by_direction) {
    const Vec3 axis = model_.nominal_pose(original.end.at).tool_axis;
    const auto angle = [&](const Vec3& other) {
      return std::atan2(axis.cross(other).norm(), axis.dot(other));
    };
    const double after = angle(model_.actual_pose(output.end.at, nullptr).tool_axis);
    const Turns output_turns = output_turns_;
    if (!stand(original.turns_end, original.turns_end)) return;
    const double before = angle(model_.actual_pose(original.end.at, nullptr).tool_axis);
    if (!stand(original.turns_end, output_turns)) return;
    check_direction(original, after, before);
  }
  if (!samples_.wants_next()) return samples_.skip();
  keep_sample(target - datum_, model_.actual(original.end.at, approach_, nullptr) - target, deviation, true);
}

/// Rapids to places that are not known in all axes, and G28 G30: the words must be the same.
void Comparison::compare_words(const Motion& original, const Motion& output) {
  withheld_ &= ~commanded(original);
  ++report_.points;
  if (!same_words(original, output) || original.end.known != output.end.known)
    disagree("V-END", original.kind == MotionKind::home
                          ? "the words of a move home must stay as they are"
                          : "the position is not known in all axes, so the words must stay as they are");
}

/// G53: words are axis commands and must stay; the axes named keep their uncorrected position afterwards.
void Comparison::compare_machine_move(const Motion& original, const Motion& output) {
  withheld_ |= original.named;
  follow_known(original);
  ++report_.points;
  if (!same_words(original, output))
    disagree("V-END", "a move in machine coordinates (G53) must stay as it is");
  double at = 0;
  if (const int axis = output.end.known == kAllAxes ? model_.beyond_travel(output.end.at, &at) : -1;
      axis >= 0)
    disagree("V-TRAVEL", travel_message(axis, at));
}

/// False if a withheld axis was moved (and that was reported).
bool Comparison::check_withheld(const Motion& original, const Motion& output) {
  for (int i = 0; i < 3; ++i) {
    if ((withheld_ & bit(i)) == 0 || std::abs(output.end.at[i] - original.end.at[i]) <= kSameCommand)
      continue;
    disagree("V-END",
             fmt::format("{} was left in machine coordinates (G53) and is moved by {:.3f} um although the "
                         "original does not command it",
                         static_cast<char>('X' + i), (output.end.at[i] - original.end.at[i]) / um));
    return false;
  }
  return true;
}

std::string travel_message(int axis, double at) {
  return axis < 3 ? fmt::format("{} leaves its travel: {:.4f} mm", "XYZ"[axis], at)
                  : fmt::format("{} leaves its travel: {:.4f} deg", "ABC"[axis - 3], at / deg);
}

void Comparison::check_reach(const Vec3& original, const Vec3& output) {
  const double moved = (model_.axes_of(output) - model_.original_axes_of(original)).norm();
  if (!(moved <= job_.max_correction + quantum()))
    disagree("V-LIMIT",
             fmt::format("the commanded point is {:.1f} um from the original's, {:.1f} um are allowed",
                         moved / um, job_.max_correction / um));
  double at = 0;
  if (const int axis = model_.beyond_travel(output, &at); axis >= 0)
    disagree("V-TRAVEL", travel_message(axis, at));
}

/// In front of a hole the output may go to where it needs the tool: a rapid in X and Y, and in Z if the hole
/// counts from there, no further than a correction. False: there is no motion behind it (reported).
bool Comparison::skip_step_to_hole(const Motion& expected) {
  const Motion& step = output_.motion();
  const bool before_hole = expected.kind == MotionKind::cycle && expected.cycle.words != nullptr;
  const Axes z = before_hole && of_lines(expected.cycle.words->cycle) ? 0 : 4;
  if (!before_hole || step.kind != MotionKind::rapid || step.machine_words || step.to_hole ||
      (step.named & z) != 0 || step.named_turns != 0 || step.start.known != kAllAxes)
    return true;
  if (!((step.end.at - step.start.at).norm() <= job_.max_correction)) return true;
  return pull_motion();
}

void Comparison::compare_cycle(const Motion& original, const Motion& output) {
  const Cycle& a = original.cycle;
  const Cycle& b = output.cycle;
  const int axis = a.plane == 17 ? 2 : a.plane == 18 ? 1 : 0;
  withheld_ &= ~(commanded(original) | bit(axis));
  const bool same =
      a.words == nullptr || b.words == nullptr ? a.words == b.words : same_hole(*a.words, *b.words);
  if (!same || a.plane != b.plane || a.holes != b.holes || a.retracts_to_r != b.retracts_to_r ||
      a.dwell != b.dwell || std::abs(a.peck - b.peck) > kSameWord || std::abs(a.aside - b.aside) > kSameWord)
    return disagree("V-CYCLE",
                    "plane, number of holes, retract level, dwell, peck or another word of the cycle differ");
  if (!check_withheld(original, output)) return;
  for (int k = 0; k < a.holes && !stop_; ++k) {
    const Vec3 shift = a.step * k, output_shift = b.step * k;
    follow(k == 0 ? Vec3(a.travel - original.start.at) : a.step);
    compare_hole(original, output, shift, output_shift);
    follow(a.clear - a.bottom);
    check_reach(a.clear + shift, b.clear + output_shift);
  }
}

/// The strokes of one hole: along its axis, and around it if the tool goes to its side.
void Comparison::compare_hole(const Motion& original, const Motion& output, const Vec3& shift,
                              const Vec3& output_shift) {
  compare_stroke(original, output, shift, output_shift);
  constexpr int around = 8;
  for (int k = 0; original.cycle.reach > 0 && k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    const auto& [x, y] = original.cycle.aside_axes;
    const Vec3 aside = original.cycle.reach * (std::cos(angle) * x + std::sin(angle) * y);
    compare_stroke(original, output, shift + aside, output_shift + aside);
  }
}

/// One hole: from R to the bottom the tip must stay within tolerance, at both ends in all directions.
void Comparison::compare_stroke(const Motion& original, const Motion& output, const Vec3& shift,
                                const Vec3& output_shift) {
  Motion stroke, cut;
  stroke.kind = cut.kind = MotionKind::line;
  stroke.start.at = original.cycle.retract + shift;
  stroke.end.at = original.cycle.bottom + shift;
  cut.start.at = output.cycle.retract + output_shift;
  cut.end.at = output.cycle.bottom + output_shift;
  ++report_.feed_motions;
  check_reach(stroke.start.at, cut.start.at);
  check_reach(stroke.end.at, cut.end.at);

  follow(stroke.end.at - stroke.start.at);
  NominalPath path(model_, stroke, datum_);
  const double allowed = allowed_for(quantum());
  const int intervals =
      1 + static_cast<int>(std::min(kMaxSamples / original.cycle.holes, path.length() / kStrokeSpacing));
  double worst = 0;
  bool outside = false;
  for (int i = 0; i <= intervals; ++i) {
    const double t = static_cast<double>(i) / intervals;
    const Vec3 tip = model_.actual(point_at(cut, t), approach_, &outside);
    const bool at_end = i == 0 || i == intervals;
    const Vec3 deviation = at_end ? Vec3(tip - path.point(t)) : path.foot(tip).across;
    const Vec3 before = model_.actual(point_at(stroke, t), approach_, nullptr) - path.point(t);
    worst = std::max(worst, deviation.norm());
    const double weight = i == 0 ? 0 : path.length() / intervals;
    travelled_ += weight;
    before_.add(before, weight, original_.line());
    after_.add(deviation, weight, original_.line());
    ++report_.points;
    if (samples_.wants_next())
      keep_sample(path.point(t) - datum_, before, deviation, false);
    else
      samples_.skip();
  }
  measure_lost_motion(stroke.end.at);
  if (outside) disagree("V-VOL", "the hole leaves the volume in which the errors are known");
  if (!(worst <= allowed))
    disagree("V-CYCLE",
             fmt::format("the hole is {:.3f} um off, {:.3f} um are allowed", worst / um, allowed / um));
}

/// Largest difference of the tip between coming from below and from above with one axis.
void Comparison::measure_lost_motion(const Vec3& command) {
  if (!model_.directional()) return;
  for (std::size_t i = 0; i < 3; ++i) {
    Approach forward{}, backward{};
    forward[i] = 1;
    backward[i] = -1;
    const Vec3 lost = model_.actual(command, forward, nullptr) - model_.actual(command, backward, nullptr);
    report_.lost_motion = std::max(report_.lost_motion, lost.norm());
  }
}

}  // namespace abbe::verifying
