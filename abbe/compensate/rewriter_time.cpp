// No split makes blocks faster than the control can read them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"

namespace abbe {

// The least time that the feed motion can take: T = length / F, of turning axes alone angle / F (deg), in
// inverse time 60 s / F. With G95 the spindle decides it: not known. A conversational program in inches
// counts its F in tenths of an inch; whether of degrees, too, is not sure, so the shorter time is taken
// there.
void Rewriter::measure_split(double length, double angle) {
  splitting_ = {length, 0, 0};
  const Word* f = instruction_.find(*block_, 'F');
  const double way = length > 0 ? length / modal_.unit() : angle;
  if (modal_.feed_mode == 930 && f != nullptr && f->value > 0) {
    splitting_.time = 60 / f->value;
  } else if (modal_.feed_mode == 940 && modal_.has_feed && modal_.feed > 0) {
    const double counted = profile_.text.conversational && modal_.inch && length > 0 ? 0.1 : 1;
    splitting_.time = 60 * way / (counted * modal_.feed);
  }
  if (job_.block_time > 0 && splitting_.time > 0)
    splitting_.least = std::min(1.0, job_.block_time / splitting_.time);
  // behind F AUTO the feed is not known: no piece may be made
  if (job_.block_time > 0 && profile_.text.conversational && !modal_.has_feed) splitting_.least = 1;
}

// A piece of the motion measured last. One that only takes up lost motion is none.
void Rewriter::note_piece(double share) {
  if (!(share > 0)) return;
  const auto keep_least = [](double& least, double value) {
    if (value > 0 && (least == 0 || value < least)) least = value;
  };
  keep_least(report_.shortest_split, share * splitting_.length);
  keep_least(report_.shortest_split_time, share * splitting_.time);
}

// Joins the pieces of the line in samples_ that would be too short. False: refused, too much would remain.
bool Rewriter::keep_block_time(std::vector<std::size_t>& ends) {
  const std::vector<std::size_t> joined = join_short(samples_, ends, splitting_.least);
  if (joined.size() == ends.size()) return true;
  ends = joined;
  const double residual = farthest_off(samples_, ends);
  if (residual > job_.tolerance) return refuse_short_blocks(residual);
  hold_splits(residual);
  return true;
}

// The motion has fewer pieces than half the tolerance asks for.
void Rewriter::hold_splits(double residual) {
  ++report_.held_splits;
  report_.held_residual = std::max(report_.held_residual, residual);
}

// Always false.
bool Rewriter::refuse_short_blocks(double residual) {
  refuse_block("E-TOL",
               fmt::format("{:.2f} um would remain, because blocks below {:g} ms are not made", residual / um,
                           job_.block_time * 1e3),
               "the correction bends along this motion faster than the control reads blocks at this feed",
               "a slower F, a larger --tolerance-um, or a smaller --min-block-time if the control allows it");
  return false;
}

}  // namespace abbe
