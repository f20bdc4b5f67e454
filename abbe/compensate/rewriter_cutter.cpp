// Cutter radius compensation: the control offsets the contour that the program states, so the contour is what
// is corrected, and only so much of it is changed that the control finds the same path beside it
// (docs/theory/compensation.md).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

using Phase = CutterState::Phase;

// A block may be split where the pieces at its ends are this many radii long, so that the control finds its
// corners there up to an angle of 2 atan(4), and with a cutter that is only stated as wear, mm.
constexpr double kEndRadii = 4;
constexpr double kShortestEnd = 2;
// Digits may turn a short block by this, rad: more, and it is another block to the control.
constexpr double kMostTurn = 0.3;
constexpr int kArcLooks = 16;
// Smaller ways across a plane or along it are rounding, mm.
constexpr double kNoWay = 1e-7;

}  // namespace

double Rewriter::shortest_end() const {
  if (slopes_) return std::numeric_limits<double>::infinity();
  return std::max(kShortestEnd, kEndRadii * std::abs(cutter_.offset));
}

// G40 G41 G42 of the block, and whether what else it says may stand under them.
bool Rewriter::cutter_settings() {
  const GCode code = instruction_.cutter;
  constexpr GCode off = 400;
  if (cutter_.acts() && !cutter_permits()) return false;
  if (code < 0) return true;
  if (code == off) {
    const bool moved = cutter_.phase == Phase::on || cutter_.phase == Phase::ends;
    cutter_.phase = moved ? Phase::ends : Phase::off;
    return true;
  }
  const auto bad = [&](const char* what, const char* why, const char* fix) {
    refuse_block("E-CUTCOM", what, why, fix);
    return false;
  };
  const bool left = code == 410 || code == 411;
  // conversational programs may say it in every block
  if (profile_.text.conversational && cutter_.left == left &&
      (cutter_.phase == Phase::begins || cutter_.phase == Phase::on))
    return true;
  if (cutter_.acts())
    return bad("cutter compensation is switched while it is on", "controls refuse it, or differ in the path",
               profile_.text.conversational ? "write R0 on an L with X or Y before"
                                            : "write G40 with a motion before");
  if (modal_.plane != Plane::xy)
    return bad("cutter compensation in another plane than XY", "controls differ in what they offset there",
               "post it in G17");
  if (tcp_)
    return bad("cutter compensation on a tilted plane, or with tool centre point control",
               "the plane of the offset turns", "post the tool-centre path");
  if (in_.frames.placed())
    return bad("cutter compensation in a tilted, scaled or mirrored frame",
               "controls differ in what becomes of the radius and of its side", "post the tool-centre path");
  if (job_.reversal && field_.depends_on_direction())
    return bad("cutter compensation with --reversal",
               "a block that takes up lost motion would be a corner of the contour",
               "leave --reversal away: the mean is compensated and the lost motion reported");
  const auto radius = stated_radius();
  if (!radius) return false;
  cutter_ = {Phase::begins, left ? *radius : -*radius, left};
  last_way_.reset();
  report_.cutter_radius = std::max(report_.cutter_radius, *radius);
  return true;
}

bool Rewriter::cutter_permits() {
  constexpr GCode dwell = 40;
  const Instruction& in = instruction_;
  const bool frame = in.wcs >= 0 || in.tool_length >= 0 || in.frame != FrameChange::none || in.tcp >= 0 ||
                     (in.zero >= 0 && in.zero != dwell);
  const bool other = in.plane >= 0 || in.units >= 0 || in.tool_change || in.set_tool || in.flow != 0;
  const char* what = frame                 ? "a frame, an offset or a machine position"
                     : other               ? "a plane, a unit, a tool or a subprogram"
                     : is_cycle(in.motion) ? "a drilling cycle"
                     : in.motion == kNurbs ? "a curve by control points"
                     : in.ends             ? "the end of the program"
                     : in.turns_axes       ? "a word of a rotary axis"
                                           : nullptr;
  if (what == nullptr) return true;
  refuse_block("E-CUTCOM", fmt::format("{} while cutter compensation is on", what),
               "controls refuse it, or differ in where the cutter goes",
               profile_.text.conversational ? "write R0 on an L with X or Y before"
                                            : "write G40 with a motion before");
  cutter_.phase = Phase::off;  // said once
  return false;
}

// The radius that the control takes, mm. Nothing: refused.
std::optional<double> Rewriter::stated_radius() {
  using Edges = Profile::Tools::Edges;
  const Word* d = instruction_.find(*block_, 'D');
  const auto bad = [&](const std::string& what) -> std::optional<double> {
    refuse_block("E-CUTCOM", what, "how far the cutter runs beside the contour depends on it",
                 "give it: --radius D3=5.0 (0 where the program states the centre's path), or D in the tool "
                 "table");
    return std::nullopt;
  };
  if (instruction_.cutter == 411 || instruction_.cutter == 421) {
    if (d == nullptr || !(d->value >= 0)) return bad("no diameter D, or a negative one");
    return d->value * modal_.unit() / 2;
  }
  std::optional<int> number;
  if (profile_.tools.edges == Edges::tool) {
    number = edge_ == 0 ? 0 : loaded_tool_;
    if (edge_ == 0) return 0.0;
  } else if (profile_.tools.edges == Edges::table) {
    number = edge_;
    if (edge_ == 0) return 0.0;
  } else if (d == nullptr || d->value == 0) {
    // where offsets are numbered apart D0 is none, else it is the tool in the spindle
    if (profile_.tools.h_needed && d != nullptr) return 0.0;
    if (!profile_.tools.h_needed) number = loaded_tool_;
  } else if (d->value > 0 && d->value == std::floor(d->value) && d->value <= 1e6) {
    number = static_cast<int>(d->value);
  }
  if (!number) return bad("no D names the radius of the cutter");
  const auto radius = cutter_radius(job_.setup, *number);
  if (!radius) return bad(fmt::format("the radius of offset D{} is not known", *number));
  if (!(*radius >= 0)) return bad(fmt::format("the radius of offset D{} is negative", *number));
  return radius;
}

// Whether a motion may be made under cutter compensation. False: refused.
bool Rewriter::cutter_allows(const Move& move) {
  const auto bad = [&](const std::string& what, const char* why, const char* fix) {
    refuse_block("E-CUTCOM", what, why, fix);
    cutter_.phase = Phase::off;  // said once
    return false;
  };
  if (move.known1 != needed_ || move.known0 != needed_)
    return bad("a motion under cutter compensation while the position of an axis is not known",
               "the path, and so the side of the cutter, cannot be followed",
               "begin with rapid moves that name X, Y and Z, or give --start X..,Y..,Z..");
  // What a control cuts off at a corner it takes off the way in Z as well, of the block beside the corner.
  slopes_ = cutter_.offset != 0 && std::abs(move.m1.z() - move.m0.z()) > job_.tolerance;
  const bool changes = cutter_.phase == Phase::begins || cutter_.phase == Phase::ends;
  if (is_arc(instruction_.motion)) {
    if (changes)
      return bad("cutter compensation begins or ends on an arc", "controls refuse it, or differ in the path",
                 "begin and end it on a straight motion");
    const Word* p = instruction_.find(*block_, 'P');
    if (p != nullptr && p->value > 1)
      return bad("an arc of several turns under cutter compensation", "controls differ in its path",
                 "post one block for each turn");
    return true;
  }
  const Vec3 way = in_.frames.to_program(move.m1) - in_.frames.to_program(move.m0);
  const double length = std::hypot(way.x(), way.y());
  if (cutter_.phase == Phase::begins && !(length > std::abs(cutter_.offset) + kNoWay))
    return bad(fmt::format("cutter compensation begins on a motion of {:.3f} mm in the plane, with a radius "
                           "of {:.3f} mm",
                           length, std::abs(cutter_.offset)),
               "the control needs a longer one to get beside the contour",
               "begin it on a straight motion in X and Y that is longer than the radius");
  still_ = length > kNoWay ? 0 : 3;
  return true;
}

// Behind a straight motion that was written: what follows stands under G41, or no longer. A motion across the
// plane has left X and Y where they were: a word of them would be a corner of the contour. `wanted` (machine
// coordinates) is where they should be. False: refused.
bool Rewriter::cutter_moved(const Vec3& wanted) {
  const bool still = std::exchange(still_, 0) != 0;
  if (still) {
    const double aside = std::hypot(wanted.x() - out_.m.x(), wanted.y() - out_.m.y());
    // of a rapid nothing is cut
    return instruction_.motion == 0 || within_tolerance(0, aside);
  }
  if (cutter_.phase == Phase::begins) cutter_.phase = Phase::on;
  if (cutter_.phase == Phase::ends) cutter_.phase = Phase::off;
  return true;
}

// The control offsets what is written: its corners must still be there for it.
bool Rewriter::follow_offset(const std::optional<PlaneWay>& way, const Vec3& meant) {
  if (still_ != 0) return true;
  const std::optional<PlaneWay> before = std::exchange(last_way_, way);
  const auto bad = [&](const char* what) {
    refuse_block("E-CUTCOM", what,
                 "the control would not find the corner of the cutter's path, and gouge or stop",
                 "post the contour without such short blocks, or with a smaller cutter");
    return false;
  };
  const double along = way ? way->first.dot(Vec3(meant.x(), meant.y(), 0).normalized()) : 0;
  if (!(along >= std::cos(kMostTurn))) return bad("a block so short that its corrected digits turn it");
  if (too_narrow(*way, cutter_.offset))
    return bad("an arc around the cutter that is not larger than the cutter");
  const bool ends = cutter_.phase == Phase::ends;
  if (!ends && before && !corner_fits(*before, *way, cutter_.offset))
    return bad("an inside corner beside a block that is too short for the cutter");
  return true;
}

// What the correction leaves across the path at the cutter's centre, mm: with normal n and offset d
//   |(c(m + d n) - c(m)) . n, z|
std::optional<double> Rewriter::left_at_centre(const Vec3& m, const Vec3& tangent) {
  const Vec3 beside = in_.frames.vector_to_machine(to_centre(tangent, cutter_.offset));
  const double radius = beside.norm();
  if (radius == 0) return 0;
  const auto here = correction_at(m, withheld_, approach_),
             there = correction_at(m + beside, withheld_, approach_);
  if (!here || !there) return std::nullopt;
  const Vec3 change = *there - *here;
  const double left = std::hypot(change.dot(beside) / radius, change.z());
  report_.cutter_residual = std::max(report_.cutter_residual, left);
  return left;
}

bool Rewriter::within_tolerance(double left, double bend) {
  if (left + bend <= job_.tolerance) return true;
  refuse_block("E-TOL",
               fmt::format("under cutter compensation {:.2f} um stay: {:.2f} um because the block may not be "
                           "split, {:.2f} um between the contour and the cutter's centre",
                           (left + bend) / um, bend / um, left / um),
               "the control offsets the corrected contour by the radius",
               "allow more with --tolerance-um, or post the tool-centre path (D 0)");
  return false;
}

// Where a straight feed may be split under cutter compensation: nowhere at its ends, not at all where
// it begins and ends. Drops such ends of pieces, and judges what that leaves. False: refused.
bool Rewriter::keep_ends_whole(const Move& move, std::vector<std::size_t>& ends) {
  if (!cutter_.on()) {
    ends.clear();
    return true;  // beside no contour yet
  }
  const Vec3 way = in_.frames.vector_to_program(move.m1 - move.m0);
  const double length = std::hypot(way.x(), way.y()), whole = shortest_end();
  const bool looked = !ends.empty();
  const auto drops = [&, last = looked ? ends.back() : 0](std::size_t i) {
    const double s = samples_[i].s;
    return i != last && (still_ != 0 || s * length < whole || (1 - s) * length < whole);
  };
  std::erase_if(ends, drops);
  double left = 0;
  const std::size_t places = still_ != 0 ? 0 : looked ? samples_.size() : 3;
  for (std::size_t i = 0; i < places; ++i) {
    const double s = looked ? samples_[i].s : static_cast<double>(i) / 2;
    const auto here = left_at_centre(move.m0 + s * (move.m1 - move.m0), way);
    if (!here) return false;
    left = std::max(left, *here);
  }
  return within_tolerance(left, looked ? bend_between(ends) : 0);
}

// How far the corrections are from straight lines between the samples where pieces end, mm.
double Rewriter::bend_between(const std::vector<std::size_t>& ends) const {
  double bend = 0;
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    const MoveSample &a = samples_[begin], &b = samples_[end];
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double t = (samples_[i].s - a.s) / (b.s - a.s);
      bend = std::max(bend, (samples_[i].correction - (1 - t) * a.correction - t * b.correction).norm());
    }
    begin = end;
  }
  return bend;
}

// An arc: what stays at the cutter's centre along it. False: refused.
bool Rewriter::arc_beside(const Arc& nominal) {
  double left = 0;
  for (int i = 0; i <= kArcLooks; ++i) {
    const double s = static_cast<double>(i) / kArcLooks;
    const auto here = left_at_centre(in_.frames.to_machine(nominal.at(s)), nominal.direction(s));
    if (!here) return false;
    left = std::max(left, *here);
  }
  return within_tolerance(left, left > 0 ? interpolation_ : 0);
}

}  // namespace abbe
