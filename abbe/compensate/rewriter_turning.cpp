// Rotary axes and tool centre point control (docs/theory/five-axes.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// A turning move is looked into at least this often.
constexpr double kLookSpacing = 10;  // mm
constexpr double kLookTurn = 2 * deg;
constexpr int kFewestLooks = 3, kMostLooks = 2000;
constexpr int kDeepest = 12;
// Between two stops the tool axis may be farther off than at both by this, rad.
constexpr double kDirectionTolerance = 20 * urad;
// Shorter pieces help nothing: the digits of their ends are larger than what they bend.
constexpr double kShortestPiece = 0.05;  // mm
constexpr double kSmallestTurn = 0.02 * deg;
// The feed of the linear axes may change by this share.
constexpr double kFeedChange = 0.1;
// Smaller ways of rotary axes are no motion: the correction of a turn does not go into them, rad.
constexpr double kNoTurn = 0.5e-4 * deg;
// Smaller ways of linear axes are rounding of double arithmetic, mm.
constexpr double kNoWay = 1e-7;
constexpr double kSamePlace = 1e-12;  // rad
// Where the rotary axes are this near to zero, a point of the tip is the axes' position but for a correction.
constexpr double kHome = 0.5 * deg;

/// The number with as many digits as it needs.
void append_exact(std::string& out, double number) {
  constexpr int kMost = 9;
  for (int decimals = 1; decimals <= kMost; ++decimals) {
    std::string text;
    if (append_fixed(text, number, decimals) != number && decimals < kMost) continue;
    out += text;
    return;
  }
}

bool near_home(const Turns& turns) {
  return std::all_of(turns.begin(), turns.end(), [](double turn) { return std::abs(turn) <= kHome; });
}

}  // namespace

Turning Rewriter::turning_of(int axis) const {
  const auto i = static_cast<std::size_t>(axes_.rotary[static_cast<std::size_t>(axis)]);
  return i < machine_.control.axes.size() ? machine_.control.axes[i].turning : Turning::linear;
}

int Rewriter::turn_decimals(int axis) const {
  const Word* word = turn_word_of(axis);
  return turn_decimals(axis, word ? word->decimals : -1);
}

int Rewriter::turn_decimals(int axis, int written) const {
  const auto i = static_cast<std::size_t>(axes_.rotary[static_cast<std::size_t>(axis)]);
  if (i < machine_.control.axes.size() && machine_.control.axes[i].resolution) {
    const double digits = -std::log10(*machine_.control.axes[i].resolution / deg);
    return std::clamp(static_cast<int>(std::floor(digits + 1e-9)), 0, 9);
  }
  const int profile = profile_.numbers.decimals_degree;
  return profile_.numbers.finer ? std::max(profile, written) : profile;
}

bool Rewriter::turn_words_allowed() {
  for (int k = 0; k < 3; ++k) {
    const Word* word = turn_word_of(k);
    if (!word) continue;
    if (axes_.rotary[static_cast<std::size_t>(k)] < 0) {
      refuse(*word, "E-ROTARY", fmt::format("the machine has no rotary axis with the address {}", "ABC"[k]),
             "where the tool goes is not known",
             "describe the axis, or set its `address` in the machine file");
      return false;
    }
    if (!machine_.control.declared) {
      refuse(*word, "E-ROTARY", "what rotary words do to X Y Z is not declared",
             "with tool centre point control X Y Z are of the tip, without it of the axes: the correction is "
             "another one",
             "state it in the machine file: [control] mode = \"axis\" or mode = \"tcp\"");
      return false;
    }
  }
  return true;
}

// Where the original turns to.
bool Rewriter::read_turns(Move& move) {
  move.turns0 = move.turns1 = in_.turns;
  if (instruction_.directs_tool) return read_vector(move);
  if (!instruction_.turns_axes) return true;
  const bool machine_frame = instruction_.zero == 530;
  const auto offsets = machine_frame ? Turns{} : in_.frames.turn_offset();
  for (int k = 0; k < 3; ++k) {
    const Word* word = turn_word_of(k);
    if (!word) continue;
    const auto i = static_cast<std::size_t>(k);
    move.named |= 8u << k;
    if (modal_.incremental && !machine_frame) {
      move.turns1[i] = in_.turns[i] + word->value * deg;
    } else {
      if (turning_of(k) == Turning::sign && offsets[i] != 0) {
        refuse(*word, "E-TURN", "a rotary offset on an axis whose sign is its direction",
               "how the control adds them is not known", "set the offset to zero");
        return false;
      }
      const TurnTarget target = turn_target(turning_of(k), word->value, in_.turns[i], offsets[i]);
      if (target.ambiguous && (known_ & (8u << k)) != 0) {
        refuse(*word, "E-TURN", fmt::format("{} turns by half a turn the shorter way", "ABC"[k]),
               "a correction decides which way round it goes", "put a block between, a quarter turn away");
        return false;
      }
      move.turns1[i] = target.position;
      move.known1 |= 8u << k;
    }
    const bool moves = std::abs(move.turns1[i] - move.turns0[i]) > kNoTurn || (move.known0 & (8u << k)) == 0;
    if (moves) move.turning |= 1u << k;
    turned_ |= 1u << k;
  }
  return true;
}

// An axis that is named but does not turn stays where the output has it.
void Rewriter::keep_turns(const Move& move) {
  if (!instruction_.turns_axes || move.known1 != needed_) return;
  const auto offsets = in_.frames.turn_offset();
  for (int k = 0; k < 3; ++k) {
    const Word* word = turn_word_of(k);
    const auto i = static_cast<std::size_t>(k);
    if (!word || (move.turning & (1u << k)) != 0) continue;
    if (modal_.incremental) {
      out_.turns[i] += move.turns1[i] - move.turns0[i];  // copied
      continue;
    }
    // as many digits as the axis was sent there with: one less, and it may have to turn on
    constexpr int kMostDecimals = 9;
    int decimals = turn_decimals(k);
    TurnWord kept;
    for (; decimals <= kMostDecimals; ++decimals) {
      kept = turn_word(turning_of(k), word->value, move.turns1[i], out_.turns[i], out_.turns[i], offsets[i],
                       decimals);
      if (std::abs(kept.position - out_.turns[i]) < kSamePlace) break;
    }
    if (kept.number != word->value)
      put("ABC"[k], word, kept.number, std::min(decimals, kMostDecimals), true, nullptr);
  }
}

void Rewriter::command_turns(const Move& move, const Piece& piece, bool first, std::string* extra) {
  out_.turns = move.by_vector ? piece.turns : out_.turns;
  if (move.by_vector) return command_vector(piece, first, extra);
  for (int k = 0; k < 3; ++k) {
    if ((move.turning & (1u << k)) == 0) continue;
    const auto i = static_cast<std::size_t>(k);
    const Word* word = first ? turn_word_of(k) : nullptr;
    if (!word || piece.turn_numbers[i] != word->value)
      put("ABC"[k], word, piece.turn_numbers[i], turn_decimals(k), first, extra);
    out_.turns[i] = piece.turns[i];
  }
}

// The axes stand; the point that the program speaks of becomes another one.
void Rewriter::switch_tcp(bool on) {
  if (on == tcp_) return;
  const Vec3 axes_in = field_.commanded_axes(in_.m), axes_out = field_.standing_axes(out_.m);
  tcp_ = on;
  if (!stand(in_.turns, out_.turns)) return;
  const auto in = field_.commanded_point(axes_in), out = field_.standing_point(axes_out);
  if (!in || !out) return;
  in_.m = *in;
  out_.m = *out;
  // Turned away from home the point depends on the control's numbers alone: no word is added for a linear
  // axis until the program has named it. The same where a rotary axis is not known.
  if ((known_ & needed_ & ~7u) != (needed_ & ~7u) || !near_home(in_.turns) || !near_home(out_.turns))
    known_ &= ~7u;
  withheld_ = 0;
  last_correction_.reset();
  start_corrected_ = false;
}

bool Rewriter::stand(const Turns& commanded, const Turns& standing) {
  last_correction_.reset();
  if (field_.set_stance({commanded, standing, tcp_}) || !tcp_) return true;
  refuse_block("E-TCP", "the linear axes cannot follow the tip there",
               "with the rotary axes at these positions they do not reach every point",
               "check the machine file: origins and directions of the rotary axes");
  return false;
}

std::optional<Rewriter::Stop> Rewriter::stop_at(const Move& move, double s, const Turns& from) {
  Stop stop;
  stop.s = s;
  stop.m = move.m0 + s * (move.m1 - move.m0);
  Turns turns = move.turns0;
  for (std::size_t k = 0; k < 3; ++k) turns[k] += s * (move.turns1[k] - move.turns0[k]);
  field_.set_stance({turns, from, tcp_});
  const auto answer = field_.turns_at(stop.m, turns, move.turning);
  if (answer.trouble != CorrectionField::Trouble::none) {
    report_.out_of_volume = report_.out_of_volume || answer.trouble == CorrectionField::Trouble::outside;
    if (answer.trouble == CorrectionField::Trouble::outside)
      refuse_block("E-VOL", "the rotary axes turn out of the volume in which the errors are known",
                   "beyond the measured range the errors are not known",
                   "measure a larger range, or state `periodic` for a table of a whole turn");
    else
      refuse_block("E-SOLVE", "no correction was found along this turn",
                   "the errors of the machine file are too large or not finite there",
                   "check the machine file with `abbe predict`");
    return std::nullopt;
  }
  stop.held = answer.held;
  stop.turns = from;
  if (move.by_vector && !settle_vector(s, turns, answer.turns, from, stop)) return std::nullopt;
  const auto offsets = in_.frames.turn_offset();
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Word* named = turn_word_of(k);
    if ((move.turning & (1u << k)) == 0 || !named) continue;
    TurnWord word;
    if (modal_.incremental) {
      // the increment that leads there from where the output stands
      word = turn_word(Turning::linear, named->value, move.turns1[i] - move.turns0[i], 0,
                       answer.turns[i] - from[i], 0, turn_decimals(k));
      word.position += from[i];
    } else {
      word = turn_word(turning_of(k), named->value, move.turns1[i], from[i], answer.turns[i], offsets[i],
                       turn_decimals(k));
    }
    if (word.clamped) stop.cut_short[i] = answer.turns[i] - turns[i];
    stop.turns[i] = word.position;
    stop.numbers[i] = word.number;
  }
  // the linear axes, for the rotary ones as they will stand
  field_.set_stance({turns, stop.turns, tcp_});
  const auto c = correction_at(stop.m, withheld_, {});
  if (!c) return std::nullopt;
  stop.direction = field_.miss(stop.m, stop.m + *c).direction;
  stop.m += *c;
  return stop;
}

// Where both stops are right but for rounding: what is between them is, too.
bool Rewriter::sure_of(const Move& move, const Stop& a, const Stop& b) const {
  if (tcp_) return false;
  Move part;
  part.m0 = move.m0 + a.s * (move.m1 - move.m0);
  part.m1 = move.m0 + b.s * (move.m1 - move.m0);
  for (std::size_t k = 0; k < 3; ++k) {
    part.turns0[k] = move.turns0[k] + a.s * (move.turns1[k] - move.turns0[k]);
    part.turns1[k] = move.turns0[k] + b.s * (move.turns1[k] - move.turns0[k]);
  }
  return surely_straight(part, a.m, a.turns, b.m, b.turns, rounded_away());
}

// Is some place between two stops farther off than the interpolation may leave?
bool Rewriter::bends(const Move& move, const Stop& a, const Stop& b, double tolerance) {
  const double length = (b.m - a.m).norm();
  double angle = 0;
  for (std::size_t k = 0; k < 3; ++k) angle = std::max(angle, std::abs(b.turns[k] - a.turns[k]));
  if (length < kShortestPiece && angle < kSmallestTurn) return false;
  Stance first{move.turns0, a.turns, tcp_};
  for (std::size_t k = 0; k < 3; ++k) first.commanded[k] += a.s * (move.turns1[k] - move.turns0[k]);
  field_.set_stance(first);
  const double at_start = field_.miss(move.m0 + a.s * (move.m1 - move.m0), a.m).position;
  if (at_start <= rounded_away() && sure_of(move, a, b)) return false;
  const double direction = std::max(a.direction, b.direction) + kDirectionTolerance;
  const int looks =
      std::clamp(static_cast<int>(std::ceil(std::max(length / kLookSpacing, angle / kLookTurn))),
                 kFewestLooks, kMostLooks);
  for (int i = 1; i <= looks; ++i) {
    const double t = static_cast<double>(i) / (looks + 1), s = a.s + t * (b.s - a.s);
    Stance stance{move.turns0, a.turns, tcp_};
    for (std::size_t k = 0; k < 3; ++k) {
      stance.commanded[k] += s * (move.turns1[k] - move.turns0[k]);
      stance.standing[k] += t * (b.turns[k] - a.turns[k]);
    }
    field_.set_stance(stance);
    const auto miss = field_.miss(move.m0 + s * (move.m1 - move.m0), a.m + t * (b.m - a.m));
    if (!(miss.position <= tolerance && (miss.direction <= direction || a.held || b.held))) return true;
  }
  return false;
}

bool Rewriter::split_turn(const Move& move, const Stop& a, const Stop& b, int depth,
                          std::vector<Stop>& stops) {
  const bool bent = depth < kDeepest && bends(move, a, b, interpolation_);
  if (bent && move.by_vector && !says_how_it_turns() &&
      machine_.control.vectors.between == VectorRule::Between::unstated) {
    refuse_block("E-VECTOR", "the correction bends along a block with the tool's direction",
                 "how the tool turns between its ends is not known, so it cannot be split",
                 "state vectors.between in [control] of the machine file, or allow more with "
                 "--tolerance-um");
    return false;
  }
  const bool too_short = (b.s - a.s) / 2 < splitting_.least;
  if (bent && too_short) {
    if (bends(move, a, b, job_.tolerance)) return refuse_short_blocks(job_.tolerance);
    hold_splits(job_.tolerance);
  }
  if (bent && !too_short) {
    const auto middle = stop_at(move, (a.s + b.s) / 2, a.turns);
    if (!middle) return false;
    if (!split_turn(move, a, *middle, depth + 1, stops)) return false;
    // what follows begins where the middle was rounded to
    const auto end = stop_at(move, b.s, middle->turns);
    return end && split_turn(move, *middle, *end, depth + 1, stops);
  }
  stops.push_back(b);
  return true;
}

// F is of the linear axes as long as they move, else in degrees per minute. Where a correction would change
// which, in any piece, the time is stated instead: for rotary axes alone  T = sqrt(sum of squared ways) / F.
bool Rewriter::choose_turning_feed(const Move& move, const Stop& start, const std::vector<Stop>& stops) {
  timed_feed_ = 0;
  if (modal_.feed_mode == 930) return true;
  const double whole = (move.m1 - move.m0).norm();
  const double digit = half_digit(decimals_of(nullptr)) * modal_.unit();
  const bool linear = whole > kNoWay;
  bool same = true;
  const Stop* from = &start;
  for (const Stop& stop : stops) {
    const double meant = (stop.s - from->s) * whole, now = (stop.m - from->m).norm();
    same = same && (linear ? std::abs(now - meant) <= kFeedChange * meant
                           : (stop.m - from->m).cwiseAbs().maxCoeff() <= digit);
    from = &stop;
  }
  if (same) return true;
  double angle = 0;
  for (std::size_t k = 0; k < 3; ++k) angle = std::hypot(angle, (move.turns1[k] - move.turns0[k]) / deg);
  const double distance = linear ? whole / modal_.unit() : angle;
  const bool states_mode = instruction_.feed_mode >= 0;  // a G94 of its own would take the time back
  constexpr std::size_t inverse_time = 930;
  const bool may_state_times =
      profile_.feed_of_linear && profile_.g[inverse_time].meaning == Meaning::inverse_time;
  if (may_state_times && modal_.feed_mode == 940 && !states_mode && modal_.has_feed && modal_.feed > 0) {
    timed_feed_ = modal_.feed / distance;
    return true;
  }
  refuse_block(
      "E-ROTFEED",
      fmt::format("a correction changes the way of the linear axes ({:.4f} mm) while rotary axes turn",
                  whole),
      "the control's F is of the linear axes where these move: the rotary axes would turn at another speed",
      states_mode ? "put G94 into a block of its own" : "post with inverse time (G93)");
  return false;
}

// G93 before the block and the feed mode of the original behind it.
void Rewriter::write_timed(const Move& move, const std::vector<Piece>& pieces, std::string& out) {
  const std::string inner_eol = file_eol_.empty() ? std::string("\n") : file_eol_;
  const std::string_view line_eol = eol_;
  const char* const slash = block_->slash ? "/" : "";
  eol_ = inner_eol;
  out += fmt::format("{}G93{}", slash, inner_eol);
  // what acts after the motion comes behind it
  stops_to_last(true, nullptr);
  write_pieces(move, pieces, out);
  eol_ = line_eol;
  std::string tail;
  append_exact(tail, modal_.feed);
  stops_to_last(false, &tail);
  out += fmt::format("{}G94 F{}{}", slash, tail, line_eol);
  report_.lines_out += 2;
}

// How steeply the correction of the linear axes changes along the way of the tool. How it turns with the axes
// is in it, so it says nothing about the machine file: reported only.
void Rewriter::note_turning_gradient(const Vec3& meant, const Vec3& done) {
  if (meant.squaredNorm() > kGradientBase * kGradientBase)
    report_.max_gradient = std::max(report_.max_gradient, (done - meant).norm() / meant.norm());
}

bool Rewriter::turn(const Move& move, std::string& out) {
  const bool feed = instruction_.motion == 10;
  if (feed && !feed_allowed(move)) return false;
  if (feed) judge_way(move);
  if (withheld_ != 0 && feed) {
    refuse_block("E-POS", "a turning feed move while an axis stands where G53 put it",
                 "its correction is not in force", "command X, Y and Z in the work offset first");
    return false;
  }
  follow(move.m1 - move.m0, move.known0);
  Stop start;
  start.m = out_.m;
  start.turns = out_.turns;
  start.direction = field_.miss(move.m0, start.m).direction;
  const auto end = stop_at(move, 1, out_.turns);
  if (!end) return false;
  last_correction_.reset();  // the tip's error turns with the axes: no gradient along this move
  for (std::size_t k = 0; k < 3; ++k) {
    if (end->cut_short[k] == 0) continue;
    warn("W-TURN",
         fmt::format("{}: the correction of {:.4f} deg is cut short", "ABC"[k], end -> cut_short[k] / deg),
         "it would turn the axis the other way, or once more around",
         "none is needed: what is left of the direction is in the report");
  }
  const Vec3 nominal_axes = field_.commanded_axes(move.m1);
  note_correction(move.m1, field_.standing_axes(end->m) - nominal_axes);
  std::vector<Stop> stops;
  double angle = 0;
  for (std::size_t k = 0; k < 3; ++k) angle = std::hypot(angle, (move.turns1[k] - move.turns0[k]) / deg);
  measure_split((move.m1 - move.m0).norm(), angle);
  if (feed) {
    if (!split_turn(move, start, *end, 0, stops) || !choose_turning_feed(move, start, stops)) return false;
  } else {
    stops.push_back(*end);
  }
  std::vector<Piece> pieces;
  const Stop* from = start_corrected_ ? &start : nullptr;
  for (const Stop& stop : stops) {
    if (from != nullptr) note_turning_gradient((stop.s - from->s) * (move.m1 - move.m0), stop.m - from->m);
    from = &stop;
    pieces.push_back({pieces.empty() ? 0 : pieces.back().s1, stop.s, out_.frames.to_program(stop.m),
                      stop.turns, stop.numbers});
    if (stop.held) ++report_.held_blocks;
  }
  if (feed && timed_feed_ > 0) {
    write_timed(move, pieces, out);
  } else {
    write_pieces(move, pieces, out);
  }
  timed_feed_ = 0;
  if (number_ == job_.trace_line) {
    move_text_ = fmt::format(
        "{} with rotary axes, in {} piece{}: rotary axes restore the tool's direction, linear ones its "
        "place{}",
        feed ? "feed move" : "rapid", pieces.size(), pieces.size() == 1 ? "" : "s",
        end->held ? "; a rotary axis is held near a singularity" : "");
  }
  in_.m = move.m1;
  in_.turns = move.turns1;
  known_ = move.known1;
  start_corrected_ = withheld_ == 0;
  stands_ = approach_;
  return stand(in_.turns, out_.turns);
}

}  // namespace abbe
