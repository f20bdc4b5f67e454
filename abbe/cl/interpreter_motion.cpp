#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/cl/interpreter.h"
#include "abbe/core/units.h"

namespace abbe::cl {
namespace {

constexpr double kUnitLength = 1e-3;      // what three printed digits leave of a unit vector
constexpr double kSameAxis = 1e-6;        // rad: six printed digits
constexpr double kRadiusMismatch = 0.01;  // mm between both ends of an arc, and the radius stated
constexpr double kLeastArc = 1e-3;        // mm: shorter, it might as well be a whole turn
constexpr double kOnCircle = 3e-5;        // mm
constexpr double kAngleMismatch = 0.1 * deg;
constexpr double kLargestCoordinate = 1e7;  // mm

Vec3 vector_at(const Record& record, std::size_t first) {
  return {record.items[first].value, record.items[first + 1].value, record.items[first + 2].value};
}

bool has_unit_length(const Vec3& v) { return std::abs(v.norm() - 1) < kUnitLength; }

}  // namespace

Interpreter::Outcome Interpreter::move(const Record& record, Findings& findings) {
  if (!has_unit(record, findings)) return Outcome::refused;
  if (record.major == "CIRCLE" || record.major == "MOVARC") return hold_arc(record, findings);
  const bool after_arc = arc_just_made_;
  arc_just_made_ = false;
  motion_ = Motion{};
  motion_.incremental = record.major == "GODLTA";
  motion_.start = at_;
  motion_.start_known = at_known_;
  motion_.cutter_compensated = cutcom_;
  const bool target = read_target(record, findings);
  const bool was_rapid = rapid_;
  if (record.major != "FROM") rapid_ = false;
  at_known_ = target;
  if (!target) {
    arc_waits_ = false;
    return Outcome::refused;
  }
  at_ = motion_.end;
  if (record.major == "FROM") {
    motion_.kind = MotionKind::from;
    motion_.may_split = false;
    return Outcome::motion;
  }
  if (arc_waits_) {
    arc_waits_ = false;
    return make_arc_motion(record, findings) ? Outcome::motion : Outcome::refused;
  }
  motion_.kind = cycle_on_                      ? MotionKind::hole
                 : was_rapid && !rapid_unclear_ ? MotionKind::rapid
                                                : MotionKind::line;
  motion_.above = above_;
  motion_.below = below_;
  // Start-up and cancel blocks of the cutter compensation stay one block.
  motion_.may_split = motion_.kind == MotionKind::line && motion_.start_known && !was_rapid && !cutcom_edge_;
  cutcom_edge_ = rapid_unclear_ = false;
  arc_turns_ = 1;
  if (after_arc && motion_.kind == MotionKind::line && continues_circle()) {
    findings.refuse(
        record,
        {"E-ARC", "a second GOTO on the circle before it",
         "whether the points are chords of that circle or a path of their own depends on the post-processor",
         "write circles with one GOTO each, or points only"});
    return Outcome::refused;
  }
  return Outcome::motion;
}

bool Interpreter::read_target(const Record& record, Findings& findings) {
  const std::size_t count = record.items.size();
  if (record.leading_numbers() != count || (count != 3 && count != 6) ||
      (motion_.incremental && count != 3)) {
    const auto odd = std::find_if(record.items.begin(), record.items.end(),
                                  [](const Item& item) { return !item.is_number; });
    Complaint complaint{"E-RECORD",
                        fmt::format("{} has not {} numbers and nothing else", record.major,
                                    motion_.incremental ? "three" : "three or six"),
                        "where the tool goes is not known",
                        "write x,y,z or x,y,z,i,j,k, each a number without blanks in it"};
    if (odd != record.items.end())
      findings.refuse(record, *odd, std::move(complaint));
    else
      findings.refuse(record, std::move(complaint));
    return false;
  }
  if (motion_.incremental && !at_known_) {
    findings.refuse(record, {"E-POS", "GODLTA from a position that is not known",
                             "where the tool goes depends on where it stands", "write FROM or GOTO before"});
    return false;
  }
  const Vec3 numbers = vector_at(record, 0);
  motion_.end.tip = motion_.incremental ? Vec3(at_.tip + frame_.rotation * (frame_.unit * numbers))
                                        : frame_.to_program(numbers);
  if (!(motion_.end.tip.cwiseAbs().maxCoeff() < kLargestCoordinate)) {
    findings.refuse(record, {"E-RANGE", "a coordinate of more than 10 km", "the unit or the number is wrong",
                             "correct it"});
    return false;
  }
  return read_axis(record, findings);
}

bool Interpreter::read_axis(const Record& record, Findings& findings) {
  motion_.axis_given = record.items.size() == 6;
  motion_.end.axis = at_.axis;
  if (!motion_.axis_given) {
    if (axis_sure_) return true;
    axis_sure_ = true;  // said once
    findings.refuse(record, {"E-TLAXIS", "the tool axis is not stated here, and was not Z before",
                             "readers differ on whether it stays or becomes Z",
                             "write six numbers, or TLAXIS/i,j,k before"});
    return false;
  }
  const Vec3 axis = vector_at(record, 3);
  if (!has_unit_length(axis)) {
    findings.refuse(record, record.items[3],
                    {"E-TLAXIS", fmt::format("the tool axis i,j,k has the length {:.6f}", axis.norm()),
                     "it is a unit vector from the tip to the spindle", "correct it"});
    return false;
  }
  motion_.end.axis = (frame_.rotation * axis).normalized();
  if (multax_ == std::optional(false) && (motion_.end.axis - at_.axis).norm() > kSameAxis &&
      (motion_.end.axis - Vec3::UnitZ()).norm() > kSameAxis) {
    findings.refuse(
        record, record.items[3],
        {"E-TLAXIS", "a tool axis while MULTAX is off", "a post-processor may obey it or ignore it",
         "write MULTAX/ON before, or leave the axis out"});
    return false;
  }
  const bool turned = motion_.start_known && (motion_.end.axis - at_.axis).norm() > kSameAxis;
  if (conventions_.axis_rule == AxisRule::automatic && !multax_ && turned && !axis_warned_) {
    axis_warned_ = true;
    findings.warn(record,
                  {"W-TLAXIS",
                   "tool axes turn although the file never says MULTAX/ON: they are kept, tips are corrected",
                   "they may be indexed positions, which no correction moves",
                   "--tool-axis correct corrects them, --tool-axis keep says that this is meant"});
  }
  motion_.axis_free = conventions_.axis_rule == AxisRule::correct ||
                      (conventions_.axis_rule == AxisRule::automatic && multax_.value_or(false));
  axis_sure_ = true;
  return true;
}

/// CIRCLE/x,y,z,i,j,k[,r[,tolerances]][,TIMES,n] and MOVARC/x,y,z,i,j,k,r,ANGLE,a.
Interpreter::Outcome Interpreter::hold_arc(const Record& record, Findings& findings) {
  const bool movarc = record.major == "MOVARC";
  const std::size_t numbers = record.leading_numbers(), count = record.items.size();
  const bool tagged = count == numbers + 2 && record.items[numbers + 1].is_number &&
                      record.items[numbers].word == (movarc ? "ANGLE" : "TIMES");
  const bool formed = movarc
                          ? numbers == 7 && tagged
                          : (numbers == 6 || numbers == 7 || numbers == 11) && (tagged || count == numbers);
  const auto refused = [&](const char* message, const char* why, const char* fix) {
    findings.refuse(record, {"E-ARC", message, why, fix});
    return Outcome::refused;
  };
  if (!formed)
    return refused("the numbers of this circle are not understood",
                   "its centre, axis and radius are not known", "write CIRCLE/x,y,z,i,j,k[,r][,TIMES,n]");
  if (rapid_)
    return refused("RAPID before a circle",
                   "whether the circle or its end is the rapid motion depends on the post-processor",
                   "remove RAPID");
  if (cycle_on_)
    return refused("a circle while CYCLE is on", "each point would be a hole", "write CYCLE/OFF before");
  const Vec3 normal = vector_at(record, 3);
  if (!has_unit_length(normal))
    return refused("the axis of the circle is no unit vector", "its plane is not known", "correct i,j,k");
  const bool nx = nx_ || numbers == 11;
  if (nx && conventions_.circle_hand == CircleHand::unknown)
    return refused("the sense of this circle is not known",
                   "this writer's manual counts it clockwise about the axis, which is read in two ways",
                   "look at one circle in the CAM system: --circle-hand right if the right hand about i,j,k "
                   "gives its sense, else left");
  arc_turns_ = 1;
  if (tagged && !movarc) {
    const double turns = record.items[numbers + 1].value;
    if (!(turns >= 1 && turns <= 1e4 && turns == std::floor(turns)))
      return refused("TIMES without a whole number", "the number of turns is not known", "correct it");
    arc_turns_ = static_cast<int>(turns);
  }
  arc_angle_ = movarc ? record.items[8].value * deg : 0;
  arc_centre_ = frame_.to_program(vector_at(record, 0));
  arc_normal_ = (frame_.rotation * normal).normalized();
  if (nx && conventions_.circle_hand == CircleHand::left) arc_normal_ = -arc_normal_;
  arc_radius_ = numbers >= 7 ? std::abs(record.items[6].value) * frame_.unit : 0;
  arc_waits_ = true;
  return Outcome::held;
}

bool Interpreter::make_arc_motion(const Record& record, Findings& findings) {
  motion_.kind = MotionKind::arc;
  const auto refused = [&](std::string message, const char* why, const char* fix) {
    findings.refuse(record, {"E-ARC", std::move(message), why, fix});
    return false;
  };
  if (!motion_.start_known)
    return refused("a circle from a position that is not known", "its start decides its radius",
                   "write FROM or GOTO before");
  if ((motion_.end.axis - motion_.start.axis).norm() > kSameAxis)
    return refused("the tool axis turns along a circle", "how it turns is not stated",
                   "write points instead of the circle");
  motion_.end.axis = motion_.start.axis;
  at_.axis = motion_.start.axis;
  motion_.axis_free = false;
  motion_.arc = make_arc(arc_centre_, arc_normal_, motion_.start.tip, motion_.end.tip, arc_turns_);
  const Arc& arc = motion_.arc;
  const double radius = arc.start_radius;
  if (!(radius > kLeastArc))
    return refused("a circle without radius", "its start is its centre", "correct the centre");
  if (std::abs(arc.end_radius - radius) > kRadiusMismatch)
    return refused(
        fmt::format("the radius is {:.4f} mm at the start and {:.4f} mm at the end", radius, arc.end_radius),
        "the path between them is not defined", "correct the centre or the end");
  if (arc_radius_ > 0 && std::abs(arc_radius_ - radius) > kRadiusMismatch)
    return refused(fmt::format("the radius is stated as {:.4f} mm and is {:.4f} mm", arc_radius_, radius),
                   "centre and start do not belong to one circle", "correct the record");
  const double turn = 2 * std::numbers::pi, rest = arc.sweep - turn * std::floor(arc.sweep / turn);
  const bool closed = std::min(rest, turn - rest) * radius < 1e-9;
  if (!closed && std::min(rest, turn - rest) * radius < kLeastArc)
    return refused("the end of the circle is almost its start", "it is a whole turn or nearly nothing",
                   "write the same numbers for a whole turn");
  if (arc_turns_ > 1 && !closed)
    return refused("TIMES for a circle that does not end over its start",
                   "the number of turns is read in two ways", "write the turns one by one");
  if (arc_angle_ != 0 && std::abs(std::abs(arc_angle_) - arc.sweep) > kAngleMismatch)
    return refused(
        fmt::format("the angle is stated as {:.3f} deg and is {:.3f} deg", arc_angle_ / deg, arc.sweep / deg),
        "the sense or the end is not what it seems", "correct the record");
  motion_.may_split = arc_turns_ == 1 && arc_angle_ == 0 && !cutcom_edge_;
  cutcom_edge_ = rapid_unclear_ = false;
  last_arc_ = arc;
  arc_just_made_ = true;
  return true;
}

/// The line just read ends on the circle before it, some way on in its sense: a chord of it?
bool Interpreter::continues_circle() const {
  const Vec3 out = motion_.end.tip - last_arc_.centre, from = motion_.start.tip - last_arc_.centre;
  const Vec3& n = last_arc_.normal;
  const Vec3 v = out - n * n.dot(out), u = from - n * n.dot(from);
  const double step = std::atan2(n.dot(u.cross(v)), u.dot(v)), radius = last_arc_.end_radius;
  const double height = n.dot(motion_.end.tip - motion_.start.tip);
  if (std::abs(v.norm() - radius) > kOnCircle || std::abs(height) > kOnCircle) return false;
  // A tangent as short as this is on the circle too: r (1 / cos(step) - 1) = r step^2 / 2.
  return step > 0 && step < 45 * deg && 0.5 * radius * step * step > 4 * kOnCircle;
}

}  // namespace abbe::cl
