#include "abbe/cl/verify_compare.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace abbe::cl::verifying {
namespace {

constexpr int kMostDisagreements = 20;
constexpr double kDigits = 3e-5;     // mm: five decimals of end and centre, or six in inches
constexpr double kAxisSlack = 2e-6;  // rad: digits of a tool axis and what bends within a motion
constexpr double kSameAxis = 1e-9;
constexpr double kTurns = 1e-3;        // rad: a motion that turns the tool by more
constexpr double kLooks = 3.7;         // mm between looks
constexpr double kLooksTurn = 0.0227;  // rad
constexpr double kTurn = 2 * std::numbers::pi;
constexpr std::string_view kMark = "ABBE COMPENSATED";

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

Vec3 radial(const Circle& circle, const Vec3& p) {
  const Vec3 out = p - circle.centre;
  return out - circle.axis * circle.axis.dot(out);
}

double length_of(const Step& step) {
  if (!step.circle) return (step.end - step.start).norm();
  return std::hypot(radial(*step.circle, step.start).norm() * step.circle->angle,
                    step.circle->axis.dot(step.end - step.start));
}

const char* name_of(Move move) {
  switch (move) {
    case Move::from:
      return "FROM";
    case Move::rapid:
      return "a rapid motion";
    case Move::feed:
      return "a feed motion";
    case Move::hole:
      return "a hole of a cycle";
    case Move::none:
      break;
  }
  return "no motion";
}

}  // namespace

TipAxis on_step(const Step& step, double s) {
  const Vec3 way = step.end - step.start;
  TipAxis at{step.start + s * way, step.end_axis};
  if (const double turn = angle_between(step.start_axis, step.end_axis); turn > 0) {
    const Vec3 pole = step.start_axis.cross(step.end_axis).normalized();
    at.axis = Eigen::AngleAxisd(s * turn, pole) * step.start_axis;
  }
  if (step.circle) {
    const Circle& c = *step.circle;
    const Vec3 from = radial(c, step.start);
    const double grow = radial(c, step.end).norm() / from.norm();
    const Vec3 turned = Eigen::AngleAxisd(s * c.angle, c.axis) * from;
    const double height = c.axis.dot(step.start - c.centre) + s * c.axis.dot(way);
    at.tip = c.centre + c.axis * height + turned * (1 + s * (grow - 1));
  }
  return at;
}

Comparison::Comparison(const Plan& plan, AxisSet free, const ClVerifyJob& job, VerifyReport& report)
    : plan_(plan),
      job_(job),
      report_(report),
      machine_(plan, free, job.setup.work_offsets[0], job.probed_datum, job.start),
      samples_(job.samples) {
  report_.quantisation = kDigits;
  report_.allowed = job.tolerance + kDigits;
}

void Comparison::disagree(const char* code, const Step& original, const Step* output, std::string message) {
  if (++disagreements_ > kMostDisagreements) {
    going_on_ = false;
    return;
  }
  if (output != nullptr) message += fmt::format(" (line {} of {})", output->statement.line, job_.output_name);
  report_.diagnostics.push_back(finding(job_.original_name, original.statement, code, std::move(message),
                                        "the output would not make the part of the original",
                                        "do not use it; see docs/error-codes.md, Verification"));
}

bool Comparison::run(PathReader& original, PathReader& output, const Progress& progress) {
  constexpr std::uint64_t kLook = 256;
  std::uint64_t steps = 0;
  while (going_on_) {
    const auto step = original.next();
    if (!step) break;
    if (progress && ++steps % kLook == 0 &&
        !progress(original.file().bytes_read(), report_.original_identity.size)) {
      report_.stopped = true;
      return false;
    }
    if (!(step->move == Move::none ? record(*step, output) : motion(*step, output))) return false;
  }
  if (original.fault() || output.fault() || !going_on_) return false;
  if (auto more = output.next()) {
    disagree("V-EXTRA", *more, nullptr, "the output goes on after the end of the original");
    return false;
  }
  return !output.fault() && disagreements_ == 0;
}

void Comparison::finish() {
  report_.before = before_.summary();
  report_.after = after_.summary();
  report_.samples = samples_.take();
}

void Comparison::use_tool(const Step& original) {
  if (tool_used_ && tool_ == original.tool) return;
  tool_used_ = true;
  tool_ = original.tool;
  machine_.use_tool(tool_of(plan_.machine(), gauge_length(job_.setup, plan_.machine(), tool_).length));
  note_datum(report_.datums,
             {job_.setup.work_offsets[0] ? "G54" : "workpiece", tool_.value_or(-1), machine_.removed()});
}

/// The next step of the output. Our own header, before everything else, is none.
std::optional<Step> Comparison::next_step(PathReader& output) {
  auto step = output.next();
  if (!std::exchange(header_over_, true) && step && step->statement.remark.find(kMark) != std::string::npos) {
    while (step && step->statement.word.empty() && step->statement.remark.starts_with("$$ ABBE"))
      step = output.next();
  }
  return step;
}

/// Anything but a motion: the same bytes at the same place.
bool Comparison::record(const Step& original, PathReader& output) {
  auto other = next_step(output);
  ++report_.events;
  if (!other) {
    if (!output.fault()) disagree("V-MISSING", original, nullptr, "the output ends before this record");
    return false;
  }
  if (original.opens_circle) {
    if (!other->opens_circle || other->statement.skeleton != original.statement.skeleton ||
        other->statement.remark != original.statement.remark) {
      disagree("V-ORDER", original, &*other, "the circle has become something else");
      return false;
    }
    circle_skeleton_ = original.statement.skeleton;
    return true;
  }
  if (other->statement.bytes == original.statement.bytes) return true;
  disagree(other->move == Move::none ? "V-EVENT" : "V-ORDER", original, &*other,
           "the record is missing or changed in the output");
  return false;
}

bool Comparison::same_sort(const Step& original, const Step& output, bool first) {
  if (output.move == Move::none || output.statement.skeleton != original.statement.skeleton ||
      (first ? output.statement.remark != original.statement.remark : !output.statement.remark.empty())) {
    disagree(output.move == Move::none ? "V-ORDER" : "V-EVENT", original, &output,
             "the motion is missing, or more than its numbers changed");
    return false;
  }
  if (output.move == original.move && output.circle.has_value() == original.circle.has_value()) return true;
  disagree("V-CLASS", original, &output,
           fmt::format("{} has become {}", name_of(original.move), name_of(output.move)));
  return false;
}

bool Comparison::next_piece(const Step& original, PathReader& output, Step& piece) {
  for (int circles = original.circle ? 1 : 0; circles >= 0; --circles) {
    auto next = output.next();
    if (!next) {
      if (!output.fault())
        disagree("V-END", original, nullptr, "the motion does not reach its end before the output does");
      return false;
    }
    piece = std::move(*next);
    if (circles == 0) break;
    if (!piece.opens_circle || !circle_skeleton_ || piece.statement.skeleton != *circle_skeleton_ ||
        !piece.statement.remark.empty()) {
      disagree("V-END", original, &piece, "the arc ends elsewhere");
      return false;
    }
  }
  return same_sort(original, piece, false);
}

double Comparison::progress_of(const Step& original, const Vec3& tip, const Vec3& axis) const {
  if (original.circle) {
    const Vec3 from = radial(*original.circle, original.start), to = radial(*original.circle, tip);
    double angle = std::atan2(from.cross(to).dot(original.circle->axis), from.dot(to));
    if (angle < 0) angle += kTurn;
    const double sweep = original.circle->angle;
    if (sweep < kTurn && angle > 0.5 * (sweep + kTurn)) angle = 0;
    return angle / sweep;
  }
  const Vec3 way = original.end - original.start;
  if (way.norm() > 10 * report_.allowed) return way.dot(tip - original.start) / way.squaredNorm();
  const double turn = angle_between(original.start_axis, original.end_axis);
  return turn > kTurns ? angle_between(original.start_axis, axis) / turn : 1;
}

bool Comparison::close_to_end(const Step& original, const Outcome& there) const {
  if ((there.tip - original.end).norm() > report_.allowed) return false;
  return angle_between(original.start_axis, original.end_axis) < kTurns ||
         angle_between(there.axis, original.end_axis) < kTurns;
}

bool Comparison::fit_to_run(const Step& original, const Step& piece, const Outcome& there) {
  const auto no = [&](const char* code, std::string message) {
    disagree(code, original, &piece, std::move(message));
    return false;
  };
  if (!there.reachable) return no("V-TRAVEL", "the machine cannot reach a pose of the output");
  if (there.beyond >= 0)
    return no("V-TRAVEL", fmt::format("outside the travel of {}", plan_.machine().axis(there.beyond).name));
  if (there.outside) return no("V-VOL", "outside the volume in which the errors are known");
  return true;
}

bool Comparison::motion(const Step& original, PathReader& output) {
  use_tool(original);
  auto other = next_step(output);
  if (!other) {
    if (!output.fault()) disagree("V-MISSING", original, nullptr, "the output ends before this motion");
    return false;
  }
  Step piece = std::move(*other);
  if (!same_sort(original, piece, true)) return false;
  const Outcome nominal = machine_.along(original.end, original.end_axis);
  if (!fit_to_run(original, piece, nominal)) return false;
  const bool follows = original.starts_somewhere && stand_.known && original.move == Move::feed;
  ++(original.move == Move::feed ? report_.feed_motions : report_.rapid_motions);
  if (follows) report_.path_length += length_of(original);
  double from = 0;
  for (Stand begin = stand_;;) {
    const Outcome there = machine_.near(piece.end, piece.end_axis, nominal.commands, nominal.side);
    if (!fit_to_run(original, piece, there)) return false;
    const bool last = !follows || close_to_end(original, there);
    const double to = last ? 1 : progress_of(original, there.tip, there.axis);
    if (!last && !(to > from && to < 1)) {
      disagree("V-END", original, &piece,
               fmt::format("the tip ends {:.2f} um from where it should, {:.2f} um is allowed",
                           (there.tip - original.end).norm() / um, report_.allowed / um));
      return false;
    }
    const double moved = (piece.end - on_step(original, to).tip).norm();
    if (moved > job_.max_correction)
      disagree("V-LIMIT", original, &piece, fmt::format("a point moved by {:.1f} um", moved / um));
    if (follows && !inside(original, piece, from, to, begin, nominal)) return false;
    if (last) {
      const bool good = end_of(original, piece, there, nominal);
      stand_ = {true, nominal.commands, nominal.side};
      return good && going_on_;
    }
    from = to;
    begin.commands = there.commands;
    if (!next_piece(original, output, piece)) return false;
  }
}

bool Comparison::end_of(const Step& original, const Step& piece, const Outcome& there,
                        const Outcome& nominal) {
  const double off = (there.tip - original.end).norm();
  if (off > report_.allowed) {
    disagree("V-END", original, &piece,
             fmt::format("the tip ends {:.2f} um from where it should, {:.2f} um is allowed", off / um,
                         report_.allowed / um));
  }
  if (original.move == Move::hole && !hole(original, piece, nominal)) return false;
  if (original.move != Move::feed) ++report_.points;
  return direction_agrees(original, piece, there, nominal);
}

/// A tool axis is kept, or better than before.
bool Comparison::direction_agrees(const Step& original, const Step& piece, const Outcome& there,
                                  const Outcome& nominal) {
  const double before = angle_between(nominal.axis, original.end_axis),
               after = angle_between(there.axis, original.end_axis);
  report_.direction_before = std::max(report_.direction_before, before);
  report_.direction_after = std::max(report_.direction_after, after);
  worst_turn_ = std::max(worst_turn_, before);
  if (original.axis_stated && !original.rotation_free && !original.circle &&
      (piece.end_axis - original.end_axis).norm() > kSameAxis) {
    disagree("V-AXIS", original, &piece, "the tool axis changed, and may not");
    return false;
  }
  // A record without an axis takes the one before, which was corrected for another place: both errors may
  // add.
  const bool own = original.axis_stated && !original.circle;
  const double allowed = before + (own ? 0 : worst_turn_) + kAxisSlack;
  if (after <= allowed) return true;
  disagree("V-AXIS", original, &piece,
           fmt::format("the tool axis is {:.1f} urad off, {:.1f} urad without compensation", after / urad,
                       before / urad));
  return false;
}

bool Comparison::hole(const Step& original, const Step& piece, const Outcome& nominal) {
  for (const double reach : {original.up, -original.down}) {
    const Outcome there =
        machine_.near(piece.end + reach * piece.end_axis, piece.end_axis, nominal.commands, nominal.side);
    const double off = (there.tip - (original.end + reach * original.end_axis)).norm();
    if (!fit_to_run(original, piece, there)) return false;
    ++report_.points;
    if (off <= report_.allowed) continue;
    disagree("V-CYCLE", original, &piece,
             fmt::format("the hole is {:.2f} um off {:.2f} mm along the tool axis", off / um, reach));
    return false;
  }
  return true;
}

bool Comparison::inside(const Step& original, const Step& piece, double from, double to, const Stand& begin,
                        const Outcome& end) {
  const double part = to - from, way = length_of(original) * part;
  const double looks =
      way / kLooks + angle_between(original.start_axis, original.end_axis) * part / kLooksTurn;
  const int side = begin.side == end.side ? end.side : 0;
  const double share = from < 1 ? part / (1 - from) : 1;  // of the way to the end
  const int looked_at = std::clamp(static_cast<int>(std::min(looks, 1e4)) + 3, original.circle ? 9 : 3, 97);
  for (int i = 1; i <= looked_at; ++i) {
    const double t = static_cast<double>(i) / looked_at, s = from + t * part;
    const TipAxis nominal = on_step(original, s), written = on_step(piece, t);
    std::array<double, kMaxAxes> guess{};
    for (std::size_t k = 0; k < guess.size(); ++k)
      guess[k] = begin.commands[k] + t * share * (end.commands[k] - begin.commands[k]);
    const Outcome bare = machine_.near(nominal.tip, nominal.axis, guess, side),
                  there = machine_.near(written.tip, written.axis, guess, side);
    if (!fit_to_run(original, piece, there)) return false;
    const Vec3 before = bare.tip - nominal.tip, after = there.tip - nominal.tip;
    count(original, nominal.tip, before, after, way / looked_at);
    if (after.norm() <= report_.allowed) continue;
    disagree("V-PATH", original, &piece,
             fmt::format("the path is left by {:.2f} um, {:.2f} um is allowed", after.norm() / um,
                         report_.allowed / um));
    return false;
  }
  return true;
}

/// way: path since the look before, mm.
void Comparison::count(const Step& original, const Vec3& nominal, const Vec3& before, const Vec3& after,
                       double way) {
  ++report_.points;
  const std::uint64_t line = original.statement.line;
  const Vec3 before_w = machine_.vector_in_workpiece(before), after_w = machine_.vector_in_workpiece(after);
  before_.add(before_w, way, line);
  after_.add(after_w, way, line);
  if (!samples_.wants_next()) return samples_.skip();
  samples_.add({line, machine_.in_workpiece(nominal), report_.path_length, before_w, after_w, false});
}

}  // namespace abbe::cl::verifying
