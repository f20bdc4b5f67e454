// The motions of a block: straight lines, arcs, canned cycles.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
/// A chord shorter than this is no chord: positions of one program differ by less only through rounding.
constexpr double kSamePoint = 1e-9;  // mm
/// Arcs of a smaller angle become full circles in LinuxCNC.
constexpr double kSmallestSweep = 1e-6;  // rad
/// How much too short R may be for its chord.
constexpr double kRadiusMm = 0.0127;
constexpr int kMaxRepeats = 9999;  // holes, pecks
constexpr int kMaxTurns = 999;

struct Plane {
  int number, first, second, third;  ///< 17 18 19 and the indices of its axes
};

constexpr Plane plane_of(int code) {
  if (code == 180) return {18, 2, 0, 1};
  if (code == 190) return {19, 1, 2, 0};
  return {17, 0, 1, 2};
}

constexpr char axis_letter(int axis) { return static_cast<char>('X' + axis); }
constexpr char centre_letter(int axis) { return static_cast<char>('I' + axis); }

/// The angle from a to b turning in the given sense, in (0, 2 pi].
double angle_between(double a, double b, bool clockwise) {
  double angle = clockwise ? a - b : b - a;
  angle = std::fmod(angle, kTurn);
  if (angle <= 0) angle += kTurn;
  return angle;
}

}  // namespace

void Control::begin_motion(MotionKind kind) {
  moves_ = true;
  motion_.kind = kind;
  motion_.code = motion_code_;
  motion_.machine_words = motion_.to_hole = false;
  motion_.incremental = incremental_ || block_->increments != 0;
  motion_.named = named_axes(*block_);
  for (int i = 0; i < 3; ++i)
    motion_.words[i] = (motion_.named >> i & 1) != 0 ? length_word(axis_letter(i)) : 0;
  motion_.start = m_;
  motion_.tcp = tcp_;
  motion_.turns_start = motion_.turns_end = turns_;
  motion_.named_turns = 0;
  motion_.by_direction = false;
  motion_.feed_mode = feed_mode_;
  motion_.feed = feed_;
  motion_.cutter = {};
  used_ |= letters('X', 'Y', 'Z');
}

bool Control::move() {
  if (nurbs_open_ && motion_code_ != 62 && (block_->words & ~letters('N')) != 0)
    return refuse(1, "E-SPLINE", "a block of something else before the curve has all its knots",
                  "what the control makes of it is not known", "complete the knots of the curve");
  if (motion_code_ < 0) return true;
  if (!edge_stated_) [[unlikely]]
    return refuse(1, "E-TOOL", "a motion before D says which tool offset is in force",
                  "the control's settings decide it otherwise", "write D1, or D0");
  const bool feeds = motion_code_ != 0;
  if (feeds && feed_mode_ == 930) {
    if (motion_code_ > 30)
      return refuse(1, "E-CYCLE", "canned cycle in G93", "its time is not defined", "use G94 for cycles");
    if (!block_->has('F') || !(feed_ > 0))
      return refuse(1, "E-FEED", "G93 needs an F word above 0 in every feed block",
                    "it states the time of that block", "add F");
  }
  if (feeds && feed_mode_ != 930 && feed_stated_ && !(feed_ > 0))
    return refuse(1, "E-FEED", "a feed motion with F0", "the control stops with an alarm",
                  "state a feed above 0");
  const bool machine_words = block_->g_code(0) == 530;
  if (!machine_words && (!frame_known() || !increments_sure())) return false;
  if (machine_words) moved_zeros_ |= named_axes(*block_);
  if (!stand_on_plane()) return false;
  if (motion_code_ == 62) return nurbs_block();
  const bool done = motion_code_ <= 10 ? straight() : motion_code_ <= 30 ? arc() : canned_cycle();
  if (!done || (frames_.placement.on() && !placement_allows_motion())) return false;
  if (!turns_known()) motion_.end.known = 0;  // where the tip goes depends on all axes
  if (feeds && (motion_.start.known != kAllAxes || motion_.end.known != kAllAxes)) {
    const Axes missing = kAllAxes & ~(motion_.start.known & motion_.end.known);
    const int axis = (missing & 1) != 0 ? 0 : (missing & 2) != 0 ? 1 : 2;
    return refuse(1, "E-POS",
                  fmt::format("feed motion while the position of {} is not known", axis_letter(axis)),
                  "the path cannot be compared without it",
                  "command the axis with a rapid first, or give the start position");
  }
  return move_beside();
}

bool Control::straight() {
  begin_motion(motion_code_ == 0 ? MotionKind::rapid : MotionKind::line);
  const bool turns = (block_->words & letters('A', 'B', 'C')) != 0;
  if (turns && !read_turns(block_->g_code(0) == 530)) return false;
  if (direction_named() && !read_direction(block_->g_code(0) == 530)) return false;
  if (motion_code_ != 0 && motion_.turns() && !way_is_sure()) return false;
  if (block_->g_code(0) == 530) {
    if (tcp_ && (motion_.named | motion_.named_turns) != 0)
      return refuse(block_->g_column[0], "E-TCP", "machine coordinates while tool centre point control is on",
                    "controls differ on what they mean then", "switch it off before");
    if (profile_.tools.in_machine_coordinates && frames_.tool_offset != Vec3::Zero())
      return refuse(block_->g_column[0], "E-G53", "machine coordinates with a tool offset",
                    "this control takes the tip there, not the axes", "write D0 in the block");
    motion_.machine_words = true;
    for (int i = 0; i < 3; ++i)
      if ((motion_.named >> i & 1) != 0) m_.at[i] = motion_.words[i];
    m_.known |= motion_.named;
    motion_.end = m_;
    u_ = program_of(frames_, m_);
    return true;
  }
  const Position u = led(*block_, u_), m = machine_of(frames_, u);
  u_ = u;
  m_ = m;
  motion_.end = m;
  return true;
}

bool Control::arc() {
  const Plane plane = plane_of(plane_);
  begin_motion(MotionKind::arc);
  if (directs_by_centre_words_)
    return refuse(1, "E-VECTOR", "an arc in a mode whose I J K are the tool's direction",
                  "its centre is not surely stated", "post it as lines");
  if (!read_turns(false)) return false;
  if (motion_.turns())
    return refuse(1, "E-ROTARY", "a rotary axis turns along an arc",
                  "how both motions are joined is not known", "post such paths as lines");
  const Position from = u_, to = led(*block_, u_);
  motion_.end = machine_of(frames_, to);
  if (from.known != kAllAxes || to.known != kAllAxes) return true;  // refused by move()

  const int a = plane.first, b = plane.second, c = plane.third;
  Vec3 centre = from.at;
  if (!arc_centre(from.at, to.at, a, b, centre)) return false;
  const bool clockwise = motion_code_ == 20;
  const double start_radius = std::hypot(from.at[a] - centre[a], from.at[b] - centre[b]);
  const double end_radius = std::hypot(to.at[a] - centre[a], to.at[b] - centre[b]);
  if (start_radius < 1e-6 || end_radius < 1e-6)
    return refuse(1, "E-ARC", "arc of radius zero", "it has no direction", "correct the centre");
  const double mismatch = std::abs(end_radius - start_radius);
  const Profile::Arcs& rules = profile_.arcs;
  const double scale = inch() ? rules.inch_scale : 1;
  if (mismatch > rules.limit * scale ||
      (mismatch > rules.tolerance * scale && mismatch > rules.relative * std::max(start_radius, end_radius)))
    return refuse(1, "E-ARC",
                  fmt::format("the radius is {:.4f} mm at the start and {:.4f} mm at the end", start_radius,
                              end_radius),
                  "the control stops at such an arc", "correct the centre or the end point");

  Arc& arc = motion_.arc;
  arc.plane = plane.number;
  arc.turns = 1;
  if (block_->has('P') && rules.turns) {
    if (!use('P') || !whole_word('P', arc.turns, "E-ARC")) return false;
    if (arc.turns < 1 || arc.turns > kMaxTurns)
      return refuse_at('P', "E-ARC", fmt::format("P{} turns", arc.turns),
                       fmt::format("P counts turns: 1 to {}", kMaxTurns), "correct the P word");
  }
  arc.start_angle = std::atan2(from.at[b] - centre[b], from.at[a] - centre[a]);
  const double end_angle = std::atan2(to.at[b] - centre[b], to.at[a] - centre[a]);
  double sweep = kTurn;  // end on start: a full circle
  if (std::hypot(to.at[a] - from.at[a], to.at[b] - from.at[b]) > kSamePoint) {
    sweep = angle_between(arc.start_angle, end_angle, clockwise);
    if (sweep < kSmallestSweep)
      return refuse(1, "E-ARC", "the end is so near to the start that the control may make a full circle",
                    "an arc of almost no angle is read as one turn", "use a line or move the end point");
  }
  sweep += kTurn * (arc.turns - 1);
  arc.sweep = clockwise ? -sweep : sweep;
  arc.start_radius = start_radius;
  arc.end_radius = end_radius;
  arc.rise = to.at[c] - from.at[c];
  arc.first = vector_of(frames_, Vec3::Unit(a));
  arc.second = vector_of(frames_, Vec3::Unit(b));
  arc.normal = vector_of(frames_, Vec3::Unit(c));
  if (frames_.placement.kind == Placement::Kind::scale) {  // the axes are unit vectors, the lengths scaled
    const double length = arc.first.norm();
    for (Vec3* axis : {&arc.first, &arc.second, &arc.normal}) *axis /= length;
    for (double* value : {&arc.start_radius, &arc.end_radius, &arc.rise}) *value *= length;
  }
  arc.centre = machine_of(frames_, {centre, kAllAxes}).at;
  u_ = to;
  m_ = motion_.end;
  return true;
}

/// Sets the coordinates a and b of the centre, in u.
bool Control::arc_centre(const Vec3& start, const Vec3& end, int a, int b, Vec3& centre) {
  if (block_->pole == Block::Pole::used) {
    if (!pole_)
      return refuse(1, "E-ARC", "C without a pole CC in the frame in force", "its centre is not defined",
                    "write CC X.. Y.. before it");
    centre[0] = (*pole_)[0];
    centre[1] = (*pole_)[1];
    return true;
  }
  const int c = 3 - a - b;
  const bool by_radius = block_->has('R');
  const bool has_a = block_->has(centre_letter(a)), has_b = block_->has(centre_letter(b));
  if (block_->has(centre_letter(c)))
    return refuse_at(centre_letter(c), "E-ARC",
                     fmt::format("{} is no centre word of this plane", centre_letter(c)),
                     "the control stops here", "select the plane or correct the word");
  if (by_radius == (has_a || has_b))
    return refuse(1, "E-ARC",
                  by_radius ? "centre words and R in one arc" : "arc without centre words and without R",
                  "its centre is not defined", "give either the centre or R");
  if (!by_radius) {
    const auto is_place = [&](int axis) {
      return absolute_centres_ || (block_->places >> (3 + axis) & 1) != 0;
    };
    if ((is_place(a) || is_place(b)) && !(has_a && has_b))
      return refuse(1, "E-ARC", "absolute centre (G90.1, AC) with one centre word",
                    "both coordinates are needed", "give both");
    for (const int axis : {a, b}) {
      const char letter = centre_letter(axis);
      if (!block_->has(letter)) continue;
      if (!use(letter)) return false;
      centre[axis] =
          is_place(axis) ? length_word(letter) + frames_.g92[axis] : start[axis] + length_word(letter);
    }
    return true;
  }
  if (!use('R')) return false;
  const double r = length_word('R');
  const double da = end[a] - start[a], db = end[b] - start[b];
  const double chord = std::hypot(da, db);
  if (chord < 1e-7)
    return refuse_at('R', "E-ARC", "R form with the end on the start", "any centre would fit",
                     "give the centre");
  if (!(std::abs(r) > 0) || chord / 2 - std::abs(r) > kRadiusMm)
    return refuse_at('R', "E-ARC", "R is too small to reach the end point", "no such arc exists",
                     "correct R");
  // h^2 = R^2 - (chord/2)^2; the minor arc (R > 0) counter-clockwise has its centre left of the chord
  const double h = std::sqrt(std::max(0.0, r * r - chord * chord / 4));
  const double side = (motion_code_ == 30) == (r > 0) ? 1 : -1;
  centre[a] = (start[a] + end[a]) / 2 - side * h * db / chord;
  centre[b] = (start[b] + end[b]) / 2 + side * h * da / chord;
  return true;
}

/// Takes R, the depth, P and Q of the block or, inside one kind of cycle, the last ones.
bool Control::cycle_words(int axis) {
  const bool goes_on = mode_ == motion_code_;
  if (mode_ < 730 || mode_ == 800) cycle_p_ = cycle_q_ = std::nullopt;  // a new sequence
  const auto take = [&](char letter, std::optional<double>& sticky, double unit, bool needed) {
    if (block_->has(letter)) {
      if (letter != axis_letter(axis) && !use(letter)) return false;
      sticky = (*block_)[letter] * unit;
    } else if (needed && !(goes_on && sticky)) {
      return refuse(1, "E-CYCLE", fmt::format("canned cycle without {}", letter), "the control stops here",
                    fmt::format("give {} in the first block of the cycle", letter));
    }
    return true;
  };
  const int code = motion_code_;
  const bool dwells = code == 820 || code == 860 || code == 890;
  const bool pecks = code == 730 || code == 830;
  if (!take('R', cycle_r_, unit_, true) || !take(axis_letter(axis), cycle_z_, unit_, true)) return false;
  if ((dwells || code == 740 || code == 840) &&
      !take('P', cycle_p_, 1, dwells && profile_.cycles.dwell_needed))
    return false;
  if (code == 760 && !(take('P', cycle_p_, 1, false) && take('Q', cycle_q_, unit_, false))) return false;
  if (pecks && !take('Q', cycle_q_, unit_, true)) return false;
  if (pecks && !(*cycle_q_ > 0))
    return refuse_at('Q', "E-CYCLE", "peck depth Q must be above 0", "the hole would never be finished",
                     "correct Q");
  motion_.cycle.dwell =
      dwells || code == 760 || ((code == 740 || code == 840) && block_->has('P')) ? cycle_p_.value_or(0) : 0;
  motion_.cycle.peck = pecks ? *cycle_q_ : 0;
  motion_.cycle.aside = code == 760 ? cycle_q_.value_or(0) : 0;
  return true;
}

bool Control::canned_cycle() {
  const Plane plane = plane_of(plane_);
  const int a = plane.first, b = plane.second, c = plane.third;
  begin_motion(MotionKind::cycle);
  motion_.end = m_;
  if (u_.known != kAllAxes) return true;  // refused by move()
  Cycle& cycle = motion_.cycle;
  if (!cycle_words(c)) return false;
  cycle.plane = plane.number;
  cycle.retracts_to_r = retracts_to_r_;
  cycle.holes = 1;
  if (const char repeats = profile_.cycles.repeats; block_->has(repeats)) {
    if (!use(repeats) || !whole_word(repeats, cycle.holes, "E-CYCLE")) return false;
    if (cycle.holes < 1 || cycle.holes > kMaxRepeats)
      return refuse_at(repeats, "E-CYCLE", fmt::format("{}{} repeats", repeats, cycle.holes),
                       "it counts holes: 1 or more", "correct the word");
  }
  const bool sequence_begins = mode_ < 730 || mode_ == 800;
  if (sequence_begins) cycle_level_ = u_.at[c] - frames_.g92[c];
  if (!cycle_level_)
    return refuse(1, "E-CYCLE", "the units change inside a sequence of canned cycles",
                  "its initial level would be read in other units", "end the cycle with G80 first");

  // Heights in u along the cycle's axis. As in LinuxCNC the level before the whole sequence is what G98
  // retracts to and what R adds to in G91; it is a number of the program, whatever frame it meets.
  const Vec3 start = u_.at;
  double old = *cycle_level_ + frames_.g92[c], current = start[c];
  const bool levels = profile_.cycles.sticky == Profile::Sticky::levels;
  if (levels && incremental_) {  // from now on R and the bottom are heights
    if (block_->has('R')) *cycle_r_ += *cycle_level_;
    if (block_->has(axis_letter(c))) *cycle_z_ += *cycle_r_;
  }
  const bool relative = incremental_ && !levels;
  const double r = relative ? old + *cycle_r_ : *cycle_r_ + frames_.g92[c];
  const double bottom = relative ? r + *cycle_z_ : *cycle_z_ + frames_.g92[c];
  if (!(r >= bottom))
    return refuse(1, "E-CYCLE", "the R level is below the bottom of the hole", "the control stops here",
                  "correct R or the depth");
  if (cycle.peck > 0 && r - bottom > kMaxRepeats * cycle.peck)
    return refuse(1, "E-CYCLE", "too many pecks", "Q is far too small for this depth", "correct Q");
  if (old < r) old = current = r;  // straight to R first
  const double clear = retracts_to_r_ ? r : old;

  Vec3 step = Vec3::Zero(), hole = start;
  for (const int axis : {a, b}) {
    if (!block_->has(axis_letter(axis))) continue;
    const double word = length_word(axis_letter(axis));
    if (incremental_) {
      step[axis] = word;
      hole[axis] += word;
    } else {
      hole[axis] = word + frames_.g92[axis];
    }
  }
  const auto at_height = [&](Vec3 u, double height) {
    u[c] = height;
    return machine_of(frames_, {u, kAllAxes}).at;
  };
  cycle.lifted = at_height(start, current);
  cycle.travel = at_height(hole, current > r ? current : clear);
  cycle.retract = at_height(hole, r);
  cycle.bottom = at_height(hole, bottom);
  cycle.clear = at_height(hole, clear);
  cycle.step = vector_of(frames_, step);

  u_.at = hole + step * (cycle.holes - 1);
  u_.at[c] = clear;
  m_ = machine_of(frames_, u_);
  motion_.end = m_;
  mode_ = motion_code_;
  return true;
}

}  // namespace abbe::verifying
