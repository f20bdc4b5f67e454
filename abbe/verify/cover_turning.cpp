// One feed motion with turning rotary axes, and the output's motions that together cover it.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

constexpr double kInterval = 3.3;  // mm between samples
constexpr double kTurnInterval = 1 * deg;
constexpr int kFewestIntervals = 3, kMostIntervals = 2000;
constexpr double kSlope = 1e-4;  // of s, for derivatives of the path
constexpr double kStill = 5e-3;  // mm of path per unit of s: the tip does not tell where on the path it is
constexpr double kFootTolerance = 2e-5;  // mm
constexpr double kNoSwing = 1e-5;        // rad of direction per unit of s: the direction does not tell either
constexpr double kFootAngle = 1e-7;      // rad
constexpr int kFootSteps = 6;
constexpr double kBehind = 0.1;  // share of a turn that a correction may lack at its end

constexpr double kTimeTolerance = 1e-3, kShareTolerance = 2e-2;  // G93, as for other lines
constexpr double kFeedChange = 0.1;                              // of the way that F is of
constexpr double kRounding = 1e-6;                               // of that share

constexpr double kMaxTurn = 0.5 * deg;  // a rotary command may not be corrected by more
constexpr double kDirectionTolerance = 30 * urad;
constexpr double kTurnDigit = 0.5e-4 * deg;
constexpr double kNoWay = 1e-7;   // mm: rounding of double arithmetic
constexpr double kNoTurn = 1e-9;  // rad

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

Turns along(const Turns& from, const Turns& to, double t) {
  Turns turns = from;
  for (std::size_t k = 0; k < 3; ++k) turns[k] += t * (to[k] - from[k]);
  return turns;
}

/// How far along its way `turns` is, by all axes together; `square` is the sum of their squared ways.
double turn_share(const Motion& motion, const Turns& turns, double& square) {
  double dot = 0;
  square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double way = motion.turns_end[k] - motion.turns_start[k];
    dot += (turns[k] - motion.turns_start[k]) * way;
    square += way * way;
  }
  return square > 0 ? dot / square : 1;
}

}  // namespace

struct Comparison::TurnCover {
  const Motion& motion;
  Vec3 way = Vec3::Zero();
  double allowed = 0;
  int pieces = 0;
  double s = 0, last_s = 0;                       ///< foot of the last sample, and the one before
  double speed = 0;                               ///< of the tip there, mm per unit of s
  double swing = 0;                               ///< of the tool axis there, rad per unit of s
  Vec3 start = Vec3::Zero(), end = Vec3::Zero();  ///< points of the output
  Turns turns_start{};                            ///< of the output
  double worst = 0, worst_s = 0, worst_back = 0, shortfall = 0;
  double excess = 0;  ///< a start that was not corrected: may fade out
  double time = 0;
  bool rushes = false;      ///< a piece in which F means another speed
  double askew = 0;         ///< of the tool without compensation, at the last sample, rad
  double askew_excess = 0;  ///< at the start, beyond what is allowed: axes stand as another place needed it
  double worst_direction = 0, worst_askew = 0;  ///< beyond what is allowed, and without compensation there
  bool outside = false;
  int beyond_travel = -1;
  double beyond_at = 0;

  [[nodiscard]] double allowed_at(double at) const { return allowed + excess * std::clamp(1 - at, 0.0, 1.0); }
};

/// Tip and tool axis that the original means at s of its motion.
TipAndAxis Comparison::meant(const TurnCover& cover, double s) {
  Stance stance = model_.stance();
  stance.original = along(cover.motion.turns_start, cover.motion.turns_end, s);
  model_.stand(stance);
  TipAndAxis pose = model_.nominal_pose(cover.motion.start.at + s * cover.way);
  pose.position += datum_;
  return pose;
}

/// Tip and tool axis of the machine at t of a piece of the output.
TipAndAxis Comparison::done(TurnCover& cover, const Motion& piece, double t) {
  Stance stance = model_.stance();
  stance.output = along(piece.turns_start, piece.turns_end, t);
  model_.stand(stance);
  return model_.actual_pose(piece.start.at + t * (piece.end.at - piece.start.at), &cover.outside);
}

/// The place of the original's path nearest to a tip, by Gauss-Newton from the last one. Where the tip stands
/// still the direction of the tool axis says where, and where that stands still too the rotary axes.
void Comparison::find_foot(TurnCover& cover, const TipAndAxis& is, const Turns& turns) {
  for (int i = 0; i < kFootSteps; ++i) {
    const TipAndAxis behind = meant(cover, cover.s - kSlope), ahead = meant(cover, cover.s + kSlope),
                     at = meant(cover, cover.s);
    const Vec3 slope = (ahead.position - behind.position) / (2 * kSlope);
    const Vec3 swing = (ahead.tool_axis - behind.tool_axis) / (2 * kSlope);
    cover.speed = slope.norm();
    const bool by_tip = cover.speed >= kStill;
    cover.swing = swing.norm();
    if (!by_tip && cover.swing < kNoSwing) {
      double square = 0;
      cover.s = turn_share(cover.motion, turns, square);
      return;
    }
    // s := s + T'.(P - T) / T'.T'
    const double step = by_tip ? slope.dot(is.position - at.position) / slope.squaredNorm()
                               : swing.dot(is.tool_axis - at.tool_axis) / swing.squaredNorm();
    cover.s += std::clamp(step, -0.5, 0.5);
    if (std::abs(step) * (by_tip ? cover.speed / kFootTolerance : swing.norm() / kFootAngle) < 1) return;
  }
}

void Comparison::cover_turning(const Motion& original) {
  withheld_ &= ~commanded(original);
  TurnCover cover{original};
  cover.way = original.end.at - original.start.at;
  cover.allowed = allowed_for(quantum());
  ++report_.feed_motions;
  while (!stop_) {
    const Item item = pull();
    if (item == Item::event && cover.pieces == 0 && original.feed_mode == 940 &&
        begins_timed(output_.event())) {
      timed_ = true;
      continue;
    }
    const bool goes_on =
        item == Item::motion && output_.motion().kind == MotionKind::line && !output_.motion().machine_words;
    if (!goes_on) {
      if (item == Item::refused) return refused(output_);
      if (cover.pieces > 0)
        return disagree_and_stop(
            "V-END",
            fmt::format("the output stops {:.3f} um before the end of this motion", cover.shortfall / um));
      if (item == Item::motion)
        return disagree("V-CLASS", "the original feeds along a line here, the output does not");
      return explain_disorder(item, nullptr);
    }
    if (turn_piece(cover, output_.motion())) break;
  }
  conclude_turning(cover);
}

/// One motion of the output; true if the original is covered or no further piece makes sense.
bool Comparison::turn_piece(TurnCover& cover, const Motion& piece) {
  const Motion& original = cover.motion;
  if (original_.deletable() != output_.deletable())
    disagree("V-EVENT", "one of the blocks can be deleted with '/', the other not");
  const bool first = cover.pieces++ == 0;
  const double s_before = first ? 0 : std::clamp(cover.s, 0.0, 1.0);
  if (first) {
    cover.start = piece.start.at;
    cover.turns_start = piece.turns_start;
    const double off = (done(cover, piece, 0).position - meant(cover, 0).position).norm();
    cover.excess = std::max(0.0, off - cover.allowed);
    const double askew = angle_between(done(cover, piece, 0).tool_axis, meant(cover, 0).tool_axis);
    cover.askew_excess = std::max(0.0, askew - direction_allowed(original, 0));
  }
  double turned = 0;
  for (std::size_t k = 0; k < 3; ++k)
    turned = std::max(turned, std::abs(piece.turns_end[k] - piece.turns_start[k]));
  const double length = (piece.end.at - piece.start.at).norm();
  const int n = static_cast<int>(std::clamp(std::ceil(std::max(length / kInterval, turned / kTurnInterval)),
                                            static_cast<double>(kFewestIntervals),
                                            static_cast<double>(kMostIntervals)));
  for (int i = 1; i <= n && cover.worst < job_.max_correction; ++i)
    turn_sample(cover, piece, static_cast<double>(i) / n);
  cover.end = piece.end.at;
  output_turns_ = piece.turns_end;
  if (cover.beyond_travel < 0) cover.beyond_travel = model_.beyond_travel(piece.end.at, &cover.beyond_at);

  double square = 0;
  // a correction that is the same at both ends is no turn that is missing
  Turns since_start = original.turns_start;
  for (std::size_t k = 0; k < 3; ++k) since_start[k] += piece.turns_end[k] - cover.turns_start[k];
  const double turn_left = std::min(std::abs(1 - turn_share(original, piece.turns_end, square)),
                                    std::abs(1 - turn_share(original, since_start, square)));
  const bool still = cover.speed < kStill;
  cover.shortfall = (1 - cover.s) * (still ? 0 : cover.speed);
  const double turn_missing = turn_left * std::sqrt(square);
  const bool turned_round = turn_missing < std::min(kMaxTurn, kBehind * std::sqrt(square)) &&
                            angle_between(done(cover, piece, 1).tool_axis, meant(cover, 1).tool_axis) <=
                                direction_allowed(original, cover.askew);
  const bool complete = still ? turned_round : cover.shortfall <= cover.allowed;
  const double share = (complete ? 1 : std::clamp(cover.s, 0.0, 1.0)) - s_before;
  const bool whole_motion = complete && cover.pieces == 1;
  check_share(cover, piece, share, whole_motion);
  if (!whole_motion) check_turning_time(cover, share);
  if (piece.feed_mode == 940) {
    // F is of the linear axes where they move, else of the rotary ones, in every piece.
    const double whole = cover.way.norm(), meant_way = whole * share;
    cover.rushes = cover.rushes ||
                   (whole > kNoWay ? std::abs(length - meant_way) >
                                         kFeedChange * meant_way * (1 + kRounding) + cover.excess + quantum()
                                   : length > quantum());
  }
  if (cover.worst >= job_.max_correction) {
    stop_ = true;  // this piece does not belong to the original
    return true;
  }
  if (!complete) return false;

  const TipAndAxis end = meant(cover, 1);
  const double off = (done(cover, piece, 1).position - end.position).norm();
  if (!(off <= cover.allowed))
    disagree("V-END", fmt::format("this motion ends {:.3f} um from its target, {:.3f} um are allowed",
                                  off / um, cover.allowed / um));
  if (!check_turns(original, piece)) return true;
  if (stand(original.turns_end, piece.turns_end)) check_reach(original.end.at, piece.end.at);
  return true;
}

/// One sample of the output: where on the original it is, and how far off.
void Comparison::turn_sample(TurnCover& cover, const Motion& piece, double t) {
  const TipAndAxis is = done(cover, piece, t);
  const Turns turns = along(piece.turns_start, piece.turns_end, t);
  cover.last_s = cover.s;
  find_foot(cover, is, turns);
  const double inside = std::clamp(cover.s, 0.0, 1.0);
  const TipAndAxis wanted = meant(cover, cover.speed < kStill ? inside : cover.s);
  const Vec3 after = is.position - wanted.position;
  const double direction = angle_between(is.tool_axis, wanted.tool_axis);
  ++report_.points;
  if (!(after.norm() <= cover.allowed_at(inside)) && !(after.norm() <= cover.worst)) {
    cover.worst = after.norm();
    cover.worst_s = inside;
  }
  const double back = std::max(cover.last_s - cover.s, cover.s - 1) * cover.speed;
  if (cover.speed >= kStill && back > 2 * cover.allowed) cover.worst_back = std::max(cover.worst_back, back);

  // the machine without compensation, at the same place
  Stance stance = model_.stance();
  stance.output = stance.original;
  model_.stand(stance);
  const TipAndAxis uncorrected =
      model_.actual_pose(cover.motion.start.at + inside * cover.way, &cover.outside);
  const double askew = angle_between(uncorrected.tool_axis, wanted.tool_axis);
  cover.askew = askew;
  // what the tip is off along a short path is much of a fast turn
  const double fading = cover.askew_excess * (1 - inside) +
                        (cover.speed < kStill ? 0 : cover.swing * cover.allowed / cover.speed);
  if (direction > direction_allowed(cover.motion, askew) + fading &&
      !(direction - askew <= cover.worst_direction - cover.worst_askew)) {
    cover.worst_direction = direction;
    cover.worst_askew = askew;
  }
  report_.direction_before = std::max(report_.direction_before, askew);
  report_.direction_after = std::max(report_.direction_after, direction);
  const double weight =
      std::max(0.0, inside - std::clamp(cover.last_s, 0.0, 1.0)) * std::max(cover.way.norm(), cover.speed);
  travelled_ += weight;
  const Vec3 before = uncorrected.position - wanted.position;
  before_.add(before, weight, original_.line());
  after_.add(after, weight, original_.line());
  if (samples_.wants_next())
    keep_sample(wanted.position - datum_, before, after, false);
  else
    samples_.skip();
}

void Comparison::conclude_turning(TurnCover& cover) {
  reached_.valid = false;
  check_turning_feed(cover);
  if (cover.worst > 0)
    disagree("V-PATH",
             fmt::format("the path is {:.3f} um off at {:.1f} % of the motion, {:.3f} um are allowed",
                         cover.worst / um, 100 * cover.worst_s, cover.allowed_at(cover.worst_s) / um));
  else if (cover.worst_back > 0)
    disagree("V-PATH", fmt::format("the output goes {:.3f} um backwards or beyond the end of this motion",
                                   cover.worst_back / um));
  if (cover.worst_direction > 0) disagree_direction(cover.worst_direction, cover.worst_askew);
  if (cover.outside) disagree("V-VOL", "this motion leaves the volume in which the errors are known");
  if (cover.beyond_travel >= 0) disagree("V-TRAVEL", travel_message(cover.beyond_travel, cover.beyond_at));
}

/// 1 / T of a feed motion, 1/min: in inverse time F, else  1 / T = F / distance,  F being of the linear axes
/// where they move, else of the rotary ones (deg). 0 where the spindle decides it (G95) or no feed is known.
double Comparison::times_per_minute(const Motion& original) const {
  if (original.feed_mode == 930) return original.feed;
  if (original.feed_mode != 940) return 0;
  double angle = 0;
  for (std::size_t k = 0; k < 3; ++k)
    angle = std::hypot(angle, (original.turns_end[k] - original.turns_start[k]) / deg);
  const double way = (original.end.at - original.start.at).norm();
  const double distance = way > kNoWay ? way / (original_.inch() ? inch : mm) : angle;
  return distance > 0 ? original.feed / distance : 0;
}

/// A piece may not be faster than the control reads blocks: it lasts its share of the original's time, which
/// is known as well as its ends are found on the path.
void Comparison::check_turning_time(const TurnCover& cover, double share) {
  const double per_minute = times_per_minute(cover.motion);
  if (!(job_.block_time > 0) || job_.reversal || !(per_minute > 0)) return;
  const double found_within = cover.speed < kStill ? 0 : 2 * cover.allowed / cover.speed;
  const double time = 60 / per_minute * share, slack = 60 / per_minute * found_within;
  if (time + slack < (1 - kShareTolerance) * job_.block_time) disagree_on_time(time);
}

/// In inverse time each piece takes its share of the original's time.
void Comparison::check_share(TurnCover& cover, const Motion& piece, double share, bool whole) {
  if (piece.feed_mode != 930) return;
  const double per_minute = times_per_minute(cover.motion);
  const double time = per_minute / piece.feed;
  cover.time += time;
  if (!whole && !(std::abs(time - share) <= kShareTolerance))
    disagree("V-FEED", fmt::format("F{:g} gives this piece {:.2f} % of the time for {:.2f} % of the path",
                                   piece.feed, 100 * time, 100 * share));
}

void Comparison::check_turning_feed(const TurnCover& cover) {
  const Motion& original = cover.motion;
  if (original.feed_mode == 930 || timed_) {
    if (disagreements_ == 0 && !(std::abs(cover.time - 1) <= kTimeTolerance))
      disagree("V-FEED",
               fmt::format("the F words give {:.3f} % of the time of the original", 100 * cover.time));
    if (timed_ && !stop_) end_timed(original);
    return;
  }
  // F is of the linear axes where they move, else of the rotary ones.
  const double way = cover.way.norm(), now = (cover.end - cover.start).norm();
  const bool same = cover.rushes   ? false
                    : way > kNoWay ? std::abs(now - way) <= kFeedChange * way * (1 + kRounding) + cover.excess
                                   : now <= quantum();
  if (!same)
    disagree(
        "V-FEED",
        fmt::format(
            "the linear axes move {:.4f} mm instead of {:.4f} mm while others turn: F means another speed",
            now, way));
}

/// Rotary axes turn in the output if and only if they do in the original, to within what a correction may be.
bool Comparison::check_turns(const Motion& original, const Motion& output) {
  for (std::size_t k = 0; k < 3; ++k) {
    const double way = original.turns_end[k] - original.turns_start[k];
    const double its_way = output.turns_end[k] - output.turns_start[k];
    const double off = output.turns_end[k] - original.turns_end[k];
    const bool uncommanded = original.end.known != kAllAxes || original.machine_words;
    const bool named = (original.named_turns >> k & 1) != 0;
    // a direction's digits turn axes, too
    const bool turns_on = !original.by_direction && std::abs(way) < kNoTurn && std::abs(its_way) > kNoTurn &&
                          !(named && uncommanded);
    if (turns_on || (!uncommanded && !(std::abs(off) <= kMaxTurn + kTurnDigit))) {
      disagree_and_stop("V-TURN",
                        fmt::format("{} turns to {:.4f} deg here, the original to {:.4f} deg", "ABC"[k],
                                    output.turns_end[k] / deg, original.turns_end[k] / deg));
      return false;
    }
  }
  return true;
}

/// The tool may not stand more askew than without compensation, but for axes that do not turn here: they keep
/// the correction of the place where they last turned.
double Comparison::direction_allowed(const Motion& original, double before) const {
  double digits = kTurnDigit, standing = 0;
  for (int k = 0; k < 3; ++k) {
    if (!model_.rotary().has(k)) continue;
    const auto i = static_cast<std::size_t>(k);
    digits = std::max(digits, model_.rotary().resolution(k) / 2);
    if (original.turns_start[i] == original.turns_end[i])
      standing += std::abs(output_turns_[i] - original.turns_end[i]);
  }
  return kDirectionTolerance + 2 * digits + before + standing;
}

void Comparison::check_direction(const Motion& original, double after, double before) {
  report_.direction_before = std::max(report_.direction_before, before);
  report_.direction_after = std::max(report_.direction_after, after);
  if (!(after <= direction_allowed(original, before))) disagree_direction(after, before);
}

void Comparison::disagree_direction(double after, double before) {
  disagree("V-AXIS", fmt::format("the tool axis is {:.1f} urad askew, {:.1f} urad without compensation",
                                 after / urad, before / urad));
}

}  // namespace abbe::verifying
