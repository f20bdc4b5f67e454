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

/// Square of the sine between unit vectors; 1 if they point apart.
double sine_square(const Vec3& a, const Vec3& b) { return a.dot(b) > 0 ? a.cross(b).squaredNorm() : 1; }
double angle_of(double square) { return std::asin(std::sqrt(std::min(1.0, square))); }

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

/// Where both programs stand before the run.
void Comparison::find_start() {
  PlainLane::End& start = lane_.ends[0];
  if (!lane_.follows) {
    lane_.follows = true;
    lane_.last_original = original_.here();
    lane_.last_output = output_.here();
    TipModel::Poses poses;
    model_.nominal_poses({&lane_.last_original, 1}, poses);
    const TipAndAxis meant = poses.at(0);
    model_.actual_poses({&lane_.last_output, 1}, poses);
    start.meant = meant.position;
    start.miss = poses.at(0).position - meant.position - datum_;
    start.lean_square = sine_square(poses.at(0).tool_axis, meant.tool_axis);
  }
  start.original = &lane_.last_original;
  start.output = &lane_.last_output;
  enter_end(0);
}

void Comparison::enter_end(std::size_t at) {
  const PlainLane::End& end = lane_.ends[at];
  model_.place(end.original->m, end.original->turns, lane_.run.meant, at);
  model_.place(end.output->m, end.output->turns, lane_.run.done, at);
}

void Comparison::plain_end(std::size_t i, std::size_t j, PlainLane::End& end) const {
  end.original = &lane_.original.motions[i];
  end.output = &lane_.output.motions[j];
  const TipAndAxis meant = lane_.meant.at(i), before = lane_.uncorrected.at(i), after = lane_.done.at(j);
  const Vec3 wanted = meant.position + datum_;
  end.meant = meant.position;
  end.miss = after.position - wanted;
  end.before = before.position - wanted;
  end.lean_square = sine_square(after.tool_axis, meant.tool_axis);
  end.lean_before_square = sine_square(before.tool_axis, meant.tool_axis);
}

/// Both programs turn the same axes the same way, to within what a correction may be, and F means the same.
bool Comparison::commands_agree(const PlainLane::End& from, const PlainLane::End& to) const {
  const PlainMotion &wanted = *to.original, &found = *to.output;
  bool turns = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const double way = wanted.turns[k] - from.original->turns[k];
    const double its_way = found.turns[k] - from.output->turns[k];
    if (std::abs(way) < kNoTurn && std::abs(its_way) > kNoTurn) return false;
    if (!(std::abs(found.turns[k] - wanted.turns[k]) <= kMaxTurn)) return false;
    turns = turns || way != 0;
  }
  const Vec3 way = wanted.m - from.original->m, now = found.m - from.output->m;
  // | |now| - |way| | <= |now - way|
  const double square = way.squaredNorm();
  const bool same_speed = (now - way).squaredNorm() <= kFeedChange * kFeedChange * square ||
                          std::abs(now.norm() - way.norm()) <= kFeedChange * way.norm();
  const bool same_words = wanted.states_feed == found.states_feed && wanted.feed == found.feed &&
                          wanted.states_number == found.states_number && wanted.number == found.number;
  const double most = job_.max_correction + lane_.quantum;
  return turns && same_words && square > kNoWay * kNoWay && same_speed &&
         (found.m - wanted.m).squaredNorm() <= most * most && !model_.beyond_travel(found);
}

/// The tip stays within what is allowed from end `first` to end `last`, and so does the tool axis, without
/// what else cover_turning() grants.
bool Comparison::stays_within(std::size_t first, std::size_t last) const {
  double miss = 0, lean = 0;
  for (std::size_t i = first; i <= last; ++i) {
    miss = std::max(miss, lane_.ends[i].miss.squaredNorm());
    lean = std::max(lean, lane_.ends[i].lean_square);
  }
  const auto axes = static_cast<std::size_t>(model_.axis_count());
  const TurningBend::Bound inside = lane_.bend.bound(lane_.run.extent(first, last, axes));
  return std::sqrt(miss) + inside.position <= job_.tolerance + lane_.quantum &&
         angle_of(lean) + inside.direction <= kDirectionTolerance;
}

/// Enters an accepted motion into the report.
void Comparison::count_plain(const PlainLane::End& from, const PlainLane::End& to, std::uint64_t line) {
  report_.events += (to.original->states_feed ? 1 : 0) + (to.original->states_number ? 1 : 0);
  // what is left across the way: along it the tip is only earlier or later
  const Vec3 way = to.meant - from.meant;
  const double square = way.squaredNorm();
  const Vec3 across = to.miss - way * (way.dot(to.miss) / square);
  const double weight = std::sqrt(std::max((to.original->m - from.original->m).squaredNorm(), square));
  travelled_ += weight;
  before_.add(to.before, weight, line);
  after_.add(across, weight, line);
  if (samples_.wants_next())
    samples_.add({line, to.meant, travelled_, to.before, across, false});
  else
    samples_.skip();
}

/// The motions of the run that are accepted: of all whose ends are, those inside which nothing can be wrong.
void Comparison::count_run(std::size_t count) {
  double lean = 0, lean_before = 0;
  for (std::size_t i = 1; i <= count; ++i) {
    count_plain(lane_.ends[i - 1], lane_.ends[i], original_.line() + i);
    lean = std::max(lean, lane_.ends[i].lean_square);
    lean_before = std::max(lean_before, lane_.ends[i].lean_before_square);
  }
  report_.feed_motions += count;
  report_.together += count;
  report_.points += count;
  allowed_for(lane_.quantum);
  report_.direction_before = std::max(report_.direction_before, angle_of(lean_before));
  report_.direction_after = std::max(report_.direction_after, angle_of(lean));
}

/// Judges the plain motions that come next in both programs, as far as nothing about them is unusual. False:
/// there were none.
bool Comparison::compare_plain() {
  if (!lane_is_open()) return false;
  lane_.original = original_.plain();
  if (lane_.original.left() == 0) return false;
  lane_.output = output_.plain();
  const std::size_t count = std::min({lane_.original.left(), lane_.output.left(), PlainLane::kMost});
  if (count == 0) return false;
  find_poses();
  find_start();
  lane_.quantum = quantum();
  std::size_t done = 0;
  for (; done < count; ++done) {
    const std::size_t i = lane_.original.next + done, j = lane_.output.next + done;
    PlainLane::End &from = lane_.ends[done], &end = lane_.ends[done + 1];
    plain_end(i, j, end);
    const bool known = lane_.uncorrected.lanes[i] == 0 && lane_.done.lanes[j] == 0;
    if (!known || !((end.meant - from.meant).squaredNorm() > kStill * kStill) || !commands_agree(from, end))
      break;
    enter_end(done + 1);
  }
  if (done > 0 && !stays_within(0, done)) {
    const std::size_t most = done;
    for (done = 0; done < most && stays_within(done, done + 1);) ++done;
  }
  if (done == 0) return false;
  count_run(done);
  lane_.last_original = *lane_.ends[done].original;
  lane_.last_output = *lane_.ends[done].output;
  lane_.ends[0] = lane_.ends[done];
  original_.take(done);
  output_.take(done);
  output_turns_ = lane_.last_output.turns;
  reached_.valid = false;
  return true;
}

}  // namespace abbe::verifying
