// Runs of plain motions that turn rotary axes, one block of the output to each of the original, judged many
// at a time. What is accepted here would be accepted by cover_turning(); whatever is not goes there.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

constexpr double kMaxTurn = 0.5 * deg;  // a rotary command may not be corrected by more
constexpr double kNoTurn = 1e-9;        // rad
constexpr double kNoWay = 1e-7;         // mm
constexpr double kFeedChange = 0.1;     // of the way that F is of
constexpr double kStill = 5e-3;         // mm: the tip does not tell where on the path it is
constexpr double kDirectionTolerance = 30 * urad;

/// Between unit vectors.
double angle_between(const Vec3& a, const Vec3& b) {
  const double sine = a.cross(b).norm();
  // arcsin x = x + x^3 / 6 + ..
  constexpr double kFew = 1e-3;
  return sine < kFew && a.dot(b) > 0 ? sine * (1 + sine * sine / 6) : std::atan2(sine, a.dot(b));
}

}  // namespace

bool Comparison::lane_is_open() const {
  return !job_.one_by_one && !stop_ && !job_.reversal && !model_.no_poses() && !timed_ && !context_changed_ &&
         !tcp_ && withheld_ == 0 && disagreements_ == 0;
}

/// Poses for the motions that came since.
void Comparison::find_poses() {
  if (lane_.original.serial != lane_.original_serial) {
    lane_.original_serial = lane_.original.serial;
    model_.nominal_poses(lane_.original.motions, lane_.meant);
    model_.actual_poses(lane_.original.motions, lane_.uncorrected);
  }
  if (lane_.output.serial != lane_.output_serial) {
    lane_.output_serial = lane_.output.serial;
    model_.actual_poses(lane_.output.motions, lane_.done);
  }
}

/// Where both programs stand before the lane.
void Comparison::find_start() {
  if (lane_.follows) return;
  lane_.follows = true;
  PlainLane::End& last = lane_.last;
  last.original = original_.here();
  last.output = output_.here();
  TipModel::Poses poses;
  model_.nominal_poses({&last.original, 1}, poses);
  const TipAndAxis meant = poses.at(0);
  model_.actual_poses({&last.output, 1}, poses);
  last.meant = meant.position;
  last.miss = poses.at(0).position - meant.position - datum_;
  last.lean = angle_between(poses.at(0).tool_axis, meant.tool_axis);
}

PlainLane::End Comparison::plain_end(std::size_t i, std::size_t j) const {
  PlainLane::End end;
  end.original = lane_.original.motions[i];
  end.output = lane_.output.motions[j];
  const TipAndAxis meant = lane_.meant.at(i), before = lane_.uncorrected.at(i), after = lane_.done.at(j);
  end.meant = meant.position;
  end.miss = after.position - meant.position - datum_;
  end.before = before.position - meant.position - datum_;
  end.lean = angle_between(after.tool_axis, meant.tool_axis);
  end.lean_before = angle_between(before.tool_axis, meant.tool_axis);
  return end;
}

/// Both programs turn the same axes the same way, to within what a correction may be, and F means the same.
bool Comparison::commands_agree(const PlainLane::End& from, const PlainLane::End& to) const {
  bool turns = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const double way = to.original.turns[k] - from.original.turns[k];
    const double its_way = to.output.turns[k] - from.output.turns[k];
    if (std::abs(way) < kNoTurn && std::abs(its_way) > kNoTurn) return false;
    if (!(std::abs(to.output.turns[k] - to.original.turns[k]) <= kMaxTurn)) return false;
    turns = turns || way != 0;
  }
  const double way = (to.original.m - from.original.m).norm(), now = (to.output.m - from.output.m).norm();
  const bool same_words =
      to.original.states_feed == to.output.states_feed && to.original.feed == to.output.feed &&
      to.original.states_number == to.output.states_number && to.original.number == to.output.number;
  return turns && same_words && way > kNoWay && std::abs(now - way) <= kFeedChange * way &&
         (to.output.m - to.original.m).norm() <= job_.max_correction + quantum() &&
         !model_.beyond_travel(to.output);
}

/// The tip stays within what is allowed from one end to the other, and so does the tool axis, without what
/// else cover_turning() grants.
bool Comparison::stays_within(const PlainLane::End& from, const PlainLane::End& to) const {
  const double allowed = job_.tolerance + quantum();
  EvenMove move;
  model_.place(from.original.m, from.original.turns, move.meant_from);
  model_.place(to.original.m, to.original.turns, move.meant_to);
  model_.place(from.output.m, from.output.turns, move.done_from);
  model_.place(to.output.m, to.output.turns, move.done_to);
  const TurningBend::Bound inside = lane_.bend.bound(move);
  return std::sqrt(std::max(from.miss.squaredNorm(), to.miss.squaredNorm())) + inside.position <= allowed &&
         std::max(from.lean, to.lean) + inside.direction <= kDirectionTolerance;
}

/// Enters an accepted motion into the report.
void Comparison::count_plain(const PlainLane::End& from, const PlainLane::End& to, std::uint64_t line) {
  ++report_.feed_motions;
  ++report_.together;
  ++report_.points;
  report_.events += (to.original.states_feed ? 1 : 0) + (to.original.states_number ? 1 : 0);
  allowed_for(quantum());
  report_.direction_before = std::max(report_.direction_before, to.lean_before);
  report_.direction_after = std::max(report_.direction_after, to.lean);
  // what is left across the way: along it the tip is only earlier or later
  const Vec3 way = to.meant - from.meant;
  const Vec3 across = to.miss - way * (way.dot(to.miss) / way.squaredNorm());
  const double weight = std::max((to.original.m - from.original.m).norm(), way.norm());
  travelled_ += weight;
  before_.add(to.before, weight, line);
  after_.add(across, weight, line);
  if (samples_.wants_next())
    samples_.add({line, to.meant, travelled_, to.before, across, false});
  else
    samples_.skip();
}

/// Judges the plain motions that come next in both programs, as far as nothing about them is unusual. False:
/// there were none.
bool Comparison::compare_plain() {
  if (!lane_is_open()) return false;
  lane_.original = original_.plain();
  if (lane_.original.left() == 0) return false;
  lane_.output = output_.plain();
  const std::size_t count = std::min(lane_.original.left(), lane_.output.left());
  if (count == 0) return false;
  find_poses();
  find_start();
  std::size_t done = 0;
  for (; done < count; ++done) {
    const std::size_t i = lane_.original.next + done, j = lane_.output.next + done;
    const PlainLane::End end = plain_end(i, j);
    const bool known = lane_.uncorrected.lanes[i] == 0 && lane_.done.lanes[j] == 0;
    if (!known || !((end.meant - lane_.last.meant).norm() > kStill) || !commands_agree(lane_.last, end) ||
        !stays_within(lane_.last, end))
      break;
    count_plain(lane_.last, end, original_.line() + 1 + done);
    lane_.last = end;
  }
  original_.take(done);
  output_.take(done);
  if (done == 0) return false;
  output_turns_ = lane_.last.output.turns;
  reached_.valid = false;
  return true;
}

}  // namespace abbe::verifying
