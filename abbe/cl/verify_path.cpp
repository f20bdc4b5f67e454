#include "abbe/cl/verify_path.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "abbe/core/units.h"

namespace abbe::cl::verifying {
namespace {

constexpr double kAlmostOne = 1e-3;   // of vectors with few digits
constexpr double kAlmostSame = 1e-6;  // rad
constexpr double kRound = 0.01;       // mm: how unround a circle may be
constexpr double kTurn = 2 * std::numbers::pi;

enum class Sort { harmless, mode, frame, tool, cycle, circle, motion };

const std::unordered_map<std::string_view, Sort>& vocabulary() {
  static const std::unordered_map<std::string_view, Sort> words = [] {
    std::unordered_map<std::string_view, Sort> all;
    for (const char* w : {"PARTNO",
                          "PPRINT",
                          "REMARK",
                          "INSERT",
                          "PPFUN",
                          "TPRINT",
                          "LETTER",
                          "TITLES",
                          "DISPLY",
                          "AIR",
                          "AUXFUN",
                          "BREAK",
                          "CHECK",
                          "CLAMP",
                          "CLEARP",
                          "COOLNT",
                          "CSI_SET_EXTENSION_LENGTH",
                          "CSI_SET_FLUTE_LENGTH",
                          "CUTTER",
                          "CUTCOM",
                          "DELAY",
                          "END",
                          "END-OF-PATH",
                          "INTOL",
                          "LEADER",
                          "LINTOL",
                          "MACHIN",
                          "MCHTOL",
                          "OPSTOP",
                          "OUTTOL",
                          "PAINT",
                          "PRINT",
                          "REWIND",
                          "SELECT",
                          "SEQNO",
                          "SETUP",
                          "SPINDL",
                          "STOP",
                          "TLDATA",
                          "TOLER",
                          "TOOLNO"})
      all[w] = Sort::harmless;
    for (const char* w : {"RAPID", "FEDRAT", "MULTAX", "GOHOME", "FINI", "TOOL PATH", "UNIT", "UNITS"})
      all[w] = Sort::mode;
    for (const char* w : {"TRANS", "ORIGIN", "MSYS", "CSYS", "TRNTYP", "TLAXIS"}) all[w] = Sort::frame;
    for (const char* w : {"LOAD", "LOADTL", "TURRET"}) all[w] = Sort::tool;
    for (const char* w : {"GOTO", "GODLTA", "FROM"}) all[w] = Sort::motion;
    for (const char* w : {"CIRCLE", "MOVARC"}) all[w] = Sort::circle;
    all["CYCLE"] = Sort::cycle;
    return all;
  }();
  return words;
}

Vec3 triple(const Statement& s, std::size_t first) { return {s.at(first), s.at(first + 1), s.at(first + 2)}; }

bool orthonormal(const Mat3& m) {
  return (m.transpose() * m - Mat3::Identity()).norm() < 3e-4 && m.determinant() > 0;
}

}  // namespace

bool PathReader::fail(const Statement& at, const char* code, std::string message) {
  if (!fault_)
    fault_ = finding(name(), at, code, std::move(message),
                     "the second reader does not surely understand the file", "see docs/cl-data.md");
  return false;
}

Vec3 PathReader::point(const Statement& s, std::size_t first) const {
  return turn_ * (triple(s, first) * unit_) + moved_ + added_ - taken_;
}
Vec3 PathReader::direction(const Statement& s, std::size_t first) const {
  return (turn_ * triple(s, first)).normalized();
}

std::optional<Step> PathReader::next() {
  if (fault_) return std::nullopt;
  auto statement = statements_.next();
  if (!statement) {
    fault_ = statements_.fault();
    return std::nullopt;
  }
  Step step;
  step.statement = std::move(*statement);
  if (!over_ && !step.statement.word.empty() && !understand(step)) return std::nullopt;
  step.tool = tool_;
  return step;
}

bool PathReader::understand(Step& step) {
  const Statement& s = step.statement;
  if (reading_.pass_words.contains(s.word)) return true;
  const auto known = vocabulary().find(s.word);
  if (known == vocabulary().end())
    return fail(s, "E-RECORD", fmt::format("'{}' is not a record that is understood", s.word));
  if (circle_open_ && s.word != "GOTO" && known->second != Sort::harmless)
    return fail(s, "E-ARC", "something stands between a circle and its GOTO");
  switch (known->second) {
    case Sort::harmless:
      return true;
    case Sort::mode:
      return modes(s);
    case Sort::frame:
      return frames(s);
    case Sort::tool:
      return tools(s);
    case Sort::cycle:
      return hole_cycle(s);
    case Sort::circle:
      return open_circle(step);
    case Sort::motion:
      return motion(step);
  }
  return false;
}

bool PathReader::modes(const Statement& s) {
  const bool vertical = (axis_ - Vec3::UnitZ()).norm() == 0;
  if (s.word == "RAPID") {
    rapid_ = true;
    rapid_ended_ = false;
  } else if (s.word == "FEDRAT") {
    rapid_ended_ = rapid_;
  } else if (s.word == "MULTAX") {
    if (s.count() > 1 || (s.count() == 1 && s.fields[0].text != "ON" && s.fields[0].text != "OFF"))
      return fail(s, "E-RECORD", "MULTAX is neither ON nor OFF");
    multax_ = s.has("OFF") ? -1 : 1;
    if (multax_ < 0) axis_known_ = vertical;
  } else if (s.word == "GOHOME") {
    rapid_ = place_known_ = false;
  } else if (s.word == "TOOL PATH") {
    clsf_ = true;
    axis_known_ = vertical;
  } else if (s.word == "FINI") {
    over_ = true;
  } else {
    const std::string unit = s.count() == 1 ? s.fields[0].text : std::string();
    unit_ = unit == "MM" || unit == "MILLIMETERS"                ? mm
            : unit == "INCH" || unit == "INCHES" || unit == "IN" ? inch
                                                                 : 0;
    if (unit_ == 0) return fail(s, "E-UNITS", "the unit is not understood");
  }
  return true;
}

bool PathReader::frames(const Statement& s) {
  if (s.word == "TRNTYP") {
    world_ = s.count() == 4 && s.fields[0].text == "WORLD" && s.at(1) == 0 && s.at(2) == 0 && s.at(3) == 0;
    return world_ || fail(s, "E-FRAME", "coordinates are not those of the world");
  }
  if (unit_ == 0) return fail(s, "E-UNITS", "the unit is not stated");
  if (s.word == "TLAXIS") {
    if (s.count() != 3 || !s.numbers(3) || std::abs(triple(s, 0).norm() - 1) > kAlmostOne)
      return fail(s, "E-TLAXIS", "TLAXIS is no unit vector");
    axis_ = direction(s, 0);
    axis_known_ = true;
    return true;
  }
  if (s.word == "TRANS" || s.word == "ORIGIN") {
    if (s.count() != 3 || !s.numbers(3)) return fail(s, "E-FRAME", s.word + " is no literal shift");
    (s.word == "TRANS" ? added_ : taken_) = triple(s, 0) * unit_;
    return true;
  }
  Mat3 system;
  if (s.word == "CSYS") {
    if (s.count() != 12 || !s.numbers(12)) return fail(s, "E-FRAME", "CSYS has not twelve numbers");
    system << triple(s, 0).transpose(), triple(s, 4).transpose(), triple(s, 8).transpose();
    if (!orthonormal(system) || (!world_ && system != Mat3(Mat3::Identity())))
      return fail(s, "E-FRAME", "CSYS is no rotation, or not in the world");
    axis_ = system.col(2).normalized();
    if ((axis_ - Vec3::UnitZ()).norm() < 1e-4) axis_ = Vec3::UnitZ();
    axis_known_ = axis_ == Vec3(Vec3::UnitZ());
    return true;
  }
  if (s.count() != 9 || !s.numbers(9)) return fail(s, "E-FRAME", "MSYS has not nine numbers");
  system << triple(s, 3), triple(s, 6), triple(s, 3).cross(triple(s, 6));
  if (!orthonormal(system)) return fail(s, "E-FRAME", "MSYS is no right-angled system");
  if (!system_known_) {
    first_system_ = system;
    first_origin_ = triple(s, 0) * unit_;
  }
  const Mat3 turn = system_known_ ? Mat3(first_system_.transpose() * system) : Mat3(Mat3::Identity());
  const Vec3 moved = system_known_ ? Vec3(first_system_.transpose() * (triple(s, 0) * unit_ - first_origin_))
                                   : Vec3(Vec3::Zero());
  system_known_ = true;
  if (turn == turn_ && moved == moved_) return true;
  turn_ = turn;
  moved_ = moved;
  place_known_ = false;
  axis_ = turn.col(2).normalized();
  axis_known_ = axis_ == Vec3(Vec3::UnitZ());
  return true;
}

bool PathReader::tools(const Statement& s) {
  if (s.word == "LOAD" && !s.has("TOOL")) return fail(s, "E-RECORD", "LOAD of something else than a tool");
  for (const Field& field : s.fields) {
    if (!field.value) continue;
    if (*field.value < 0 || *field.value > 1e6 || *field.value != std::floor(*field.value)) break;
    tool_ = static_cast<int>(*field.value);
    if (!reading_.tool_change_keeps_place) place_known_ = false;
    return true;
  }
  return fail(s, "E-TOOL", "no tool number");
}

bool PathReader::hole_cycle(const Statement& s) {
  const std::string kind = s.count() == 0 ? std::string() : s.fields[0].text;
  if (kind == "INIT") return true;
  if (kind == "OFF" || kind == "ON") {
    drilling_ = kind == "ON";
    return true;
  }
  static const std::set<std::string> kinds = {"DRILL", "DEEP", "DEEP2", "BRKCHP", "TAP", "BORE",
                                              "REAM",  "FACE", "CSINK", "CBORE",  "SPOT"};
  static const std::set<std::string> other = {"RTRCTO", "DWELL",  "REV",   "1STPECK", "SUBPECK",
                                              "STEP",   "INCR",   "TPI",   "DIAMET",  "ORIENT",
                                              "CAM",    "PERMIN", "PERREV"};
  static const std::set<std::string> feeds = {"MMPM", "MMPR", "IPM", "IPR"};
  if (!kinds.contains(kind)) return fail(s, "E-CYCLE", "a cycle that is not understood: " + kind);
  if (unit_ == 0) return fail(s, "E-UNITS", "the unit is not stated");
  up_ = down_ = 0;
  std::string name = kind;
  for (std::size_t i = 1; i < s.count(); ++i) {
    if (!s.fields[i].value) {
      name = s.fields[i].text;
      continue;
    }
    const double length = std::abs(s.at(i)) * unit_;
    if (feeds.contains(name)) {
      name = "CLEAR";
      continue;
    }
    if (other.contains(name)) continue;
    const bool deep = name == kind || name == "FEDTO" || name == "DEPTH" || name == "CSINK" || name == "THRU";
    const bool high = name == "RAPTO" || name == "CLEAR";
    if (!high) down_ = std::max(down_, length);
    if (!deep) up_ = std::max(up_, length);
  }
  drilling_ = true;
  return true;
}

bool PathReader::open_circle(Step& step) {
  const Statement& s = step.statement;
  if (unit_ == 0) return fail(s, "E-UNITS", "the unit is not stated");
  if (rapid_ || drilling_) return fail(s, "E-ARC", "a circle behind RAPID, or while a cycle is on");
  std::size_t count = 0;
  while (count < s.count() && s.fields[count].value) ++count;
  const bool move = s.word == "MOVARC";
  const bool tail = s.count() == count + 2 && s.fields[count].text == (move ? "ANGLE" : "TIMES") &&
                    s.fields[count + 1].value;
  const bool good =
      move ? count == 7 && tail : (count == 6 || count == 7 || count == 11) && (tail || s.count() == count);
  if (!good || std::abs(triple(s, 3).norm() - 1) > kAlmostOne)
    return fail(s, "E-ARC", "the numbers of the circle are not understood");
  int hand = 1;
  if (clsf_ || count == 11) hand = reading_.hand;
  if (hand == 0) return fail(s, "E-ARC", "the sense of the circle is not known");
  circle_.centre = point(s, 0);
  circle_.axis = hand * direction(s, 3);
  circle_radius_ = count >= 7 ? std::abs(s.at(6)) * unit_ : 0;
  const double turns = !move && tail ? s.at(7 + (count - 6)) : 1;
  if (!(turns >= 1 && turns <= 1e4 && turns == std::floor(turns)))
    return fail(s, "E-ARC", "TIMES is no whole number");
  turns_ = static_cast<int>(turns);
  circle_open_ = step.opens_circle = true;
  return true;
}

bool PathReader::close_circle(Step& step) {
  const Statement& s = step.statement;
  circle_open_ = false;
  const Vec3 a = step.start - circle_.centre, b = step.end - circle_.centre;
  const Vec3 from = a - circle_.axis * circle_.axis.dot(a), to = b - circle_.axis * circle_.axis.dot(b);
  if (std::abs(from.norm() - to.norm()) > kRound || from.norm() < 1e-3)
    return fail(s, "E-ARC", "the circle has different radii at its ends, or none");
  if (circle_radius_ > 0 && std::abs(from.norm() - circle_radius_) > kRound)
    return fail(s, "E-ARC", "the circle has another radius than it states");
  double angle = std::atan2(from.cross(to).dot(circle_.axis), from.dot(to));
  if ((from - to).norm() < 1e-7) angle = 0;
  while (angle <= 0) angle += kTurn;
  step.circle = circle_;
  step.circle->angle = angle + kTurn * (turns_ - 1);
  return true;
}

bool PathReader::motion(Step& step) {
  const Statement& s = step.statement;
  if (unit_ == 0) return fail(s, "E-UNITS", "the unit is not stated");
  const bool step_wise = s.word == "GODLTA";
  const bool six = s.count() == 6 && s.numbers(6) && !step_wise;
  if (!six && !(s.count() == 3 && s.numbers(3)))
    return fail(s, "E-RECORD", s.word + " has not three or six numbers");
  if (step_wise && !place_known_) return fail(s, "E-POS", "GODLTA from nowhere");
  if (!six && !axis_known_) return fail(s, "E-TLAXIS", "the tool axis is not stated");
  step.start = place_;
  step.start_axis = axis_;
  step.starts_somewhere = place_known_;
  step.end = step_wise ? Vec3(place_ + turn_ * (triple(s, 0) * unit_)) : point(s, 0);
  step.end_axis = axis_;
  step.axis_stated = six;
  if (six) {
    if (std::abs(triple(s, 3).norm() - 1) > kAlmostOne)
      return fail(s, "E-TLAXIS", "the tool axis is no unit vector");
    step.end_axis = direction(s, 3);
    step.rotation_free = !reading_.turn_none && (reading_.turn_all || multax_ > 0);
  }
  if (!step.end.allFinite() || step.end.norm() > 2e7) return fail(s, "E-RANGE", "a coordinate is too large");
  step.up = up_;
  step.down = down_;
  if (s.word == "FROM") {
    step.move = Move::from;
  } else {
    step.move = drilling_ ? Move::hole : rapid_ && !rapid_ended_ ? Move::rapid : Move::feed;
    rapid_ = rapid_ended_ = false;
  }
  place_ = step.end;
  axis_ = step.end_axis;
  place_known_ = axis_known_ = true;
  if (!circle_open_) return true;
  if (!step.starts_somewhere) return fail(s, "E-ARC", "a circle from nowhere");
  if ((step.end_axis - step.start_axis).norm() > kAlmostSame)
    return fail(s, "E-ARC", "the tool axis turns along the circle");
  // An arc keeps the tool axis: what is printed again is its rounding.
  step.end_axis = step.start_axis;
  axis_ = step.start_axis;
  step.rotation_free = false;
  return close_circle(step);
}

}  // namespace abbe::cl::verifying
