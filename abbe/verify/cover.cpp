// One feed motion of the original and the output's motions that together cover it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

/// Sampling. Lines along which the machine's tables cannot bend by kBend of the tolerance are looked at in
/// their end only. Longer pieces are cut into intervals of kInterval; an inner point at kInner of each says
/// whether the error bends there, and then the interval is halved on.
constexpr double kInterval = 3.3;  // mm
constexpr double kInner = 0.4;
constexpr double kBend = 0.1;  // of the tolerance
constexpr int kMaxDepth = 6;
constexpr double kArcIntervalsPerTurn = 10;  // with the inner points: 20 samples per turn
constexpr double kMaxIntervals = 2e4;        // 66 m of path, 2000 turns

/// Lengths below this are no motion: rounding of double arithmetic.
constexpr double kNoMotion = 1e-6;     // mm
constexpr double kSameCommand = 1e-7;  // mm
/// Arcs with a radius below this many allowances are followed by their parameter: an angle means nothing.
constexpr double kSmallArc = 20;

/// An axis has turned round when it has moved back by this share of the tolerance: twice what the outputs of
/// this program are written with, so that a place where it turns belongs to the piece before or after it.
constexpr double kTurned = 0.2;

/// A motion no longer than the tolerance and this has no room for another one that takes up lost motion: it
/// does so itself, and only where it ends counts.
constexpr double kCoarsestDigit = 0.5 * um;

constexpr double kTimeTolerance = 1e-3;   // of the whole time in G93
constexpr double kShareTolerance = 1e-2;  // of a piece's share of it

}  // namespace

struct Comparison::Cover {
  Cover(const TipModel& model, const Motion& original, const Vec3& datum)
      : motion(original), path(model, original, datum), length(path.length()) {}

  const Motion& motion;
  NominalPath path;
  double length;              ///< of the original, mm
  double allowed = 0;         ///< distance from the path
  bool by_parameter = false;  ///< small arcs
  int pieces = 0;
  double last_s = 0;        ///< of the last sample
  double furthest = 0;      ///< largest s so far
  Vec3 tip = Vec3::Zero();  ///< of the last sample

  // A start that was not corrected (G53, a changed frame or tool): its deviation may fade out linearly.
  double excess = 0, excess_from = 0;

  double worst = 0, worst_allowed = 0, worst_s = 0;  ///< distance from the path beyond what is allowed
  double worst_back = 0;                             ///< mm
  double shortfall = 0, last_shortfall = 0;          ///< of the last piece's end and the one before, mm
  bool outside = false;
  int beyond_travel = -1;
  double beyond_at = 0;
  double time = 0;              ///< G93: sum of the pieces' shares, 1 in the end
  double travelled_before = 0;  ///< path before this motion, mm
  Axes moving = 0;              ///< axes that the original moves
  double turning = 0;           ///< s that an axis needs to turn round on an arc
  double from = 0,
         share = 0;  ///< s at the start of the present piece, and how much of the original it covers

  [[nodiscard]] double allowed_at(double s) const {
    if (excess <= 0) return allowed;
    return allowed + excess * std::clamp((1 - s) / (1 - excess_from), 0.0, 1.0);
  }
  [[nodiscard]] bool violated() const { return worst > 0 || worst_back > 0; }
};

void Comparison::look_up_straight_reach() {
  straight_reach_ = std::min(model_.straight_reach(kBend * job_.tolerance), kInterval);
}

void Comparison::cover(const Motion& original) {
  withheld_ &= ~commanded(original);
  Cover cover(model_, original, datum_);
  cover.allowed = allowed_for(original.kind == MotionKind::arc ? 2 * quantum() : quantum());
  if (original.kind == MotionKind::arc)
    cover.by_parameter =
        std::min(original.arc.start_radius, original.arc.end_radius) < kSmallArc * cover.allowed;
  for (int i = 0; job_.reversal && i < 3; ++i) {
    const Arc& arc = original.arc;
    const bool moves = original.kind == MotionKind::arc
                           ? std::abs(arc.first[i]) + std::abs(arc.second[i]) > kNoMotion ||
                                 std::abs(arc.normal[i] * arc.rise) > kNoMotion
                           : std::abs(original.end.at[i] - original.start.at[i]) > kNoMotion;
    if (moves) cover.moving |= Axes{1} << i;
  }
  if (original.kind ==
      MotionKind::arc)  // beside its turning point an axis is displaced by r (sweep ds)^2 / 2
    cover.turning = std::sqrt(2 * kTurned * job_.tolerance /
                              std::min(original.arc.start_radius, original.arc.end_radius)) /
                    std::abs(original.arc.sweep);
  cover.travelled_before = travelled_;
  ++report_.feed_motions;
  while (!stop_) {
    const Item item = pull();
    const bool goes_on = item == Item::motion && output_.motion().feeds() && !output_.motion().machine_words;
    if (!goes_on) {
      if (item == Item::refused) return refused(output_);
      if (cover.pieces > 0 && item != Item::refused)
        return disagree_and_stop(
            "V-END",
            fmt::format("the output stops {:.3f} um before the end of this motion", cover.shortfall / um));
      if (item == Item::motion) {
        const bool hole = output_.motion().kind == MotionKind::cycle;
        return disagree(hole ? "V-CYCLE" : "V-CLASS", "the original feeds here, the output does not");
      }
      return explain_disorder(item, nullptr);
    }
    if (cover_piece(cover, output_.motion())) break;
  }
  conclude(cover);
}

/// One motion of the output; true if the original is covered or no further piece makes sense.
bool Comparison::cover_piece(Cover& cover, const Motion& piece) {
  const Motion& original = cover.motion;
  if (model_.rotary().any() && !check_turns(original, piece)) return true;
  if (original_.deletable() != output_.deletable())
    disagree("V-EVENT", "one of the blocks can be deleted with '/', the other not");
  const double piece_length = length_of(piece);
  const bool first = cover.pieces++ == 0;
  check_beside(original, piece, first ? 0 : std::clamp(cover.last_s, 0.0, 1.0));
  if (stop_) return true;
  if (job_.reversal) follow_at(cover, std::clamp(cover.last_s, 0.0, 1.0) + cover.turning);
  const bool beside = piece.cutter.phase != CutterUse::Phase::off;
  cover.tip = beside ? tip_beside(piece, 0, piece.start.at, nullptr) : start_tip(piece.start.at);
  if (first) {
    const Vec3 deviation = cover.tip - cover.path.point(0);
    if (deviation.squaredNorm() > cover.allowed * cover.allowed)
      cover.excess = deviation.norm() - cover.allowed;
    if (!cover.by_parameter) cover.last_s = cover.path.foot(cover.tip).s;
  }
  // both ends of a motion no longer than its digits may be rounded to one point
  if (piece_length < kNoMotion && cover.length >= kNoMotion && !(first && cover.length <= 2 * quantum())) {
    disagree("V-EXTRA", "a feed motion of no length that the original does not have");
    return stop_;
  }
  if (job_.reversal) {
    if (!beside && take_up(cover, piece)) return false;
    cover.from = std::clamp(cover.last_s, 0.0, 1.0);
    cover.share = piece.kind == original.kind && piece.kind == MotionKind::arc
                      ? piece.arc.sweep / original.arc.sweep
                      : piece_length / std::max(cover.length, kNoMotion);
    follow_along(cover, 0);
  }
  if (cover.by_parameter && !first) {
    disagree_and_stop("V-PATH", "an arc this small must stay one block");
    return true;
  }

  const double before_piece = std::clamp(cover.last_s, 0.0, 1.0);
  const bool takes_up_itself = job_.reversal && cover.length <= job_.tolerance + kCoarsestDigit;
  const bool looks_inside = (piece_length > straight_reach_ && !takes_up_itself) ||
                            piece.kind == MotionKind::arc || original.kind == MotionKind::arc;
  double intervals = 1;
  if (looks_inside) {
    intervals = std::ceil(piece_length / kInterval);
    if (piece.kind == MotionKind::arc)
      intervals = std::max(
          intervals, std::ceil(std::abs(piece.arc.sweep) * kArcIntervalsPerTurn / (2 * std::numbers::pi)));
    else if (original.kind == MotionKind::arc)
      intervals = std::max(intervals, 4.0);
  }
  const int n = static_cast<int>(std::clamp(intervals, 1.0, kMaxIntervals));
  const auto error_of = [&](const Vec3& tip, const Vec3& command) {
    return Vec3(tip - model_.nominal(command));
  };
  Vec3 error = looks_inside ? error_of(cover.tip, piece.start.at) : Vec3(Vec3::Zero());
  double from = 0;
  for (int k = 1; k <= n; ++k) {
    const double to = k == n ? 1 : static_cast<double>(k) / n;
    const Vec3 command = k == n ? piece.end.at : point_at(piece, to);
    if (job_.reversal) follow_along(cover, to);
    const Vec3 tip = tip_beside(piece, to, command, &cover.outside);
    if (looks_inside) {
      const Vec3 error_to = error_of(tip, command);
      sample_interval(cover, piece, from, error, to, error_to, tip, 0);
      error = error_to;
    }
    account(cover, piece, to, command, tip);
    from = to;
  }
  reached_ = {!beside, piece.end.at, cover.tip, approach_};
  if (piece.kind == MotionKind::line && cover.beyond_travel < 0) {
    cover.beyond_travel = model_.beyond_travel(centre_of(piece, 1, piece.end.at), &cover.beyond_at);
  }

  // How much of the original is left?
  cover.last_shortfall = cover.shortfall;
  cover.shortfall = (1 - cover.last_s) * cover.length;
  const bool complete = cover.length < kNoMotion || cover.by_parameter || cover.shortfall <= cover.allowed;
  if (original.feed_mode == 930) {
    // time of the piece / time of the whole = (1 / F_k) / (1 / F)
    const double path_share = std::clamp(cover.last_s, 0.0, 1.0) - before_piece;
    const double time_share = original.feed / piece.feed;
    cover.time += time_share;
    if (!(complete && cover.pieces == 1) && !(std::abs(time_share - path_share) <= kShareTolerance))
      disagree("V-FEED", fmt::format("F{:g} gives this piece {:.2f} % of the time for {:.2f} % of the path",
                                     piece.feed, 100 * time_share, 100 * path_share));
  }
  if (!(complete && cover.pieces == 1)) check_time(piece, piece_length);
  if (!complete && !(cover.worst < job_.max_correction && cover.worst_back < job_.max_correction)) {
    // This piece does not belong to the original: what comes after it cannot be matched either.
    stop_ = true;
    return true;
  }
  if (cover.violated()) return complete;  // said once, by conclude()
  const Vec3 meant = complete ? original.end.at : point_at(original, std::clamp(cover.last_s, 0.0, 1.0));
  const double reach = job_.max_correction + quantum();
  if (const Vec3 moved = piece.end.at - meant; !(moved.squaredNorm() <= reach * reach))
    disagree("V-LIMIT",
             fmt::format("the commanded point is {:.1f} um from the original's, {:.1f} um are allowed",
                         moved.norm() / um, job_.max_correction / um));
  if (!complete) return false;

  const Vec3 deviation = cover.tip - cover.path.point(1);
  if (!(deviation.squaredNorm() <= cover.allowed * cover.allowed))
    disagree("V-END", fmt::format("this motion ends {:.3f} um from its target, {:.3f} um are allowed",
                                  deviation.norm() / um, cover.allowed / um));
  for (int i = 0; i < 3; ++i)
    if ((withheld_ >> i & 1) != 0 && !(std::abs(piece.end.at[i] - original.end.at[i]) <= kSameCommand))
      disagree("V-END", fmt::format("{} was left in machine coordinates (G53) and may not be moved here",
                                    static_cast<char>('X' + i)));
  return true;
}

/// A piece of a split motion may not be faster than the control reads blocks:  T = length / F, in inverse
/// time 60 s / F. Where lost motion is taken up, pieces end where an axis turns, however short they are. F100
/// of a conversational program in inches is 10 inches per minute.
void Comparison::check_time(const Motion& piece, double length) {
  if (!(job_.block_time > 0) || job_.reversal || !(piece.feed > 0) || piece.feed_mode == 950) return;
  const double inches = output_.profile().text.conversational ? abbe::inch / 10 : abbe::inch;
  const double unit = output_.inch() ? inches : abbe::mm;
  const double time = piece.feed_mode == 930 ? 60 / piece.feed : 60 * length / unit / piece.feed;
  if (time < (1 - kShareTolerance) * job_.block_time) disagree_on_time(time);
}

void Comparison::disagree_on_time(double time) {
  disagree("V-FEED", fmt::format("this piece lasts {:.3g} ms, the control reads blocks of {:.3g} ms",
                                 time * 1e3, job_.block_time * 1e3));
}

Vec3 Comparison::start_tip(const Vec3& command) {
  if (reached_.valid && reached_.command == command && reached_.approach == approach_) return reached_.tip;
  return model_.actual(command, approach_, nullptr);
}

/// Approach at t of the present piece. Where an axis has only begun to turn round, or has not quite turned,
/// it is as on the rest of the piece.
void Comparison::follow_along(const Cover& cover, double t) {
  const double middle = cover.from + cover.share / 2;
  const double half = std::max(0.0, std::abs(cover.share) / 2 - cover.turning);
  follow_at(cover, std::clamp(cover.from + t * cover.share, middle - half, middle + half));
}

/// Approach at s of the original, for the axes that it moves: an axis that only follows corrections by
/// fractions of a micrometre does not take up its lost motion.
void Comparison::follow_at(const Cover& cover, double s) {
  Vec3 direction = derivative_at(cover.motion, s);
  for (int i = 0; i < 3; ++i)
    if ((cover.moving >> i & 1) == 0) direction[i] = 0;
  follow(direction);
}

/// A short motion at a reversal that only takes up the lost motion: the path does not advance, and with the
/// new direction of approach the tip is where it belongs.
bool Comparison::take_up(Cover& cover, const Motion& piece) {
  if (cover.by_parameter || cover.length <= cover.allowed || length_of(piece) > job_.max_correction)
    return false;
  const double s = std::clamp(cover.pieces == 1 ? 0.0 : cover.furthest, 0.0, 1.0);
  const Vec3 tip = model_.actual(piece.end.at, approach_, &cover.outside);
  const Vec3 deviation = tip - cover.path.point(s);
  if (!(deviation.norm() <= cover.allowed)) return false;
  // A motion of few micrometres may be done in one piece: then this is its end.
  if (cover.length <= 2 * cover.allowed && (tip - cover.path.point(1)).norm() < deviation.norm())
    return false;
  if (!cover.by_parameter) cover.last_s = cover.path.foot(tip).s;
  cover.furthest = std::max(cover.furthest, cover.last_s);
  cover.tip = tip;
  cover.excess = 0;
  ++report_.points;
  return true;
}

/// Samples the inside of an interval, in the order of cutting; more densely where the error bends.
void Comparison::sample_interval(Cover& cover, const Motion& piece, double from, const Vec3& error_from,
                                 double to, const Vec3& error_to, const Vec3& tip_to, int depth) {
  const double middle = from + kInner * (to - from);
  const Vec3 command = point_at(piece, middle);
  if (job_.reversal) follow_along(cover, middle);
  const Vec3 tip = tip_beside(piece, middle, command, &cover.outside);
  const Vec3 error = tip - model_.nominal(command);
  // How far the error is from the straight line between the ends of the interval.
  const Vec3 bend = error - ((1 - kInner) * error_from + kInner * error_to);
  const double limit = kBend * job_.tolerance;
  const bool bends = bend.squaredNorm() > limit * limit && depth < kMaxDepth;
  if (bends) sample_interval(cover, piece, from, error_from, middle, error, tip, depth + 1);
  account(cover, piece, middle, command, tip);
  if (bends) sample_interval(cover, piece, middle, error, to, error_to, tip_to, depth + 1);
}

/// One sample of the output at t of its piece: where on the original it is, and how far off.
void Comparison::account(Cover& cover, const Motion& piece, double t, const Vec3& command, const Vec3& tip) {
  const NominalPath::Foot foot = cover.by_parameter ? cover.path.foot_at(tip, t) : cover.path.foot(tip);
  const double s = cover.length < kNoMotion ? 1 : foot.s;
  const double inside = std::clamp(s, 0.0, 1.0);
  const double allowed = cover.allowed_at(inside);
  ++report_.points;

  if (!(foot.across.squaredNorm() <= allowed * allowed) && !(foot.across.norm() <= cover.worst)) {
    cover.worst = foot.across.norm();
    cover.worst_allowed = allowed;
    cover.worst_s = inside;
  }
  const double back = std::max(cover.furthest - s, s - 1) * cover.length;
  if (back > allowed) cover.worst_back = std::max(cover.worst_back, back);
  if (piece.kind == MotionKind::arc && cover.beyond_travel < 0) {
    cover.beyond_travel = model_.beyond_travel(centre_of(piece, t, command), &cover.beyond_at);
  }

  const double weight = std::max(0.0, inside - std::clamp(cover.last_s, 0.0, 1.0)) * cover.length;
  cover.last_s = s;
  cover.furthest = std::max(cover.furthest, s);
  cover.tip = tip;
  // The error at the output's command, where it is known already: from the one at the original's it differs
  // by the correction times the gradient of the error, nanometres.
  const Vec3 before = tip - model_.nominal(command) - datum_;
  travelled_ = cover.travelled_before + inside * cover.length;
  before_.add(before, weight, original_.line());
  after_.add(foot.across, weight, original_.line());
  if (samples_.wants_next())
    keep_sample(cover.path.point(inside) - datum_, before, foot.across, false);
  else
    samples_.skip();
}

void Comparison::conclude(Cover& cover) {
  travelled_ = cover.travelled_before + cover.length;
  if (cover.motion.feed_mode == 930 && disagreements_ == 0 && !(std::abs(cover.time - 1) <= kTimeTolerance))
    disagree("V-FEED",
             fmt::format("the F words give {:.3f} % of the time of the original", 100 * cover.time));
  const bool lost = stop_ && cover.pieces > 1 && cover.last_shortfall < job_.max_correction;
  if (lost)
    disagree("V-END",
             fmt::format("the output ends {:.3f} um before the end of this motion and goes elsewhere",
                         cover.last_shortfall / um));
  else if (cover.worst > 0)
    disagree("V-PATH",
             fmt::format("the path is {:.3f} um off at {:.1f} % of the motion, {:.3f} um are allowed",
                         cover.worst / um, 100 * cover.worst_s, cover.worst_allowed / um));
  else if (cover.worst_back > 0)
    disagree(cover.furthest > 1 ? "V-END" : "V-PATH",
             fmt::format("the output goes {:.3f} um {} on this motion", cover.worst_back / um,
                         cover.furthest > 1 ? "beyond its end" : "backwards"));
  if (cover.outside) disagree("V-VOL", "this motion leaves the volume in which the errors are known");
  if (cover.beyond_travel >= 0) disagree("V-TRAVEL", travel_message(cover.beyond_travel, cover.beyond_at));
  measure_lost_motion(cover.motion.end.at);
}

}  // namespace abbe::verifying
