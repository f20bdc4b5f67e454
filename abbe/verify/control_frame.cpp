// Frames that stand between a program's numbers and its work offset: G68 G69, G51, G51.1, G68.2 and G53.1.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/verify/control.h"
#include "abbe/verify/plane.h"

namespace abbe::verifying {
namespace {

constexpr Letters kPlaneWords = letters('X', 'Y', 'Z', 'I', 'J', 'K');
/// The rotary axes are left no farther from where they stand on the plane than a correction would put them.
constexpr double kMostAskew = 0.6 * deg;
/// Where the program turns them itself they stand there but for the digits of their words.
constexpr double kMostAskewByWords = 0.01 * deg;
constexpr double kSmallestScale = 0.01, kLargestScale = 100;

/// v turned about the unit vector `axis`:  v cos + (axis x v) sin + axis (axis . v)(1 - cos).
Vec3 turned_about(const Vec3& axis, double angle, const Vec3& v) {
  return v * std::cos(angle) + axis.cross(v) * std::sin(angle) + axis * axis.dot(v) * (1 - std::cos(angle));
}

}  // namespace

bool Control::change_frame(int code) {
  const Block& b = *block_;
  if (code != 680 && code != 690 && code != 692 &&
      (b.g_code(0) >= 0 || b.g_code(1) >= 0 || b.g_code(8) >= 0 || b.g_code(12) >= 0 || b.m_code(6) >= 0 ||
       b.tcp_code >= 0 || (b.words & letters('A', 'B', 'C')) != 0))
    return refuse(b.g_column[11], "E-BLOCK", "a frame beside other codes", "their order is not defined",
                  "use two blocks");
  switch (code) {
    case 682:
      return begin_plane();
    case 683:
      return begin_spatial_plane();
    case 684:
      return swivel();
    case 691:
      return reset_plane();
    case 531:
      return tool_to_plane();
    case 510:
      return scale();
    case 511:
      return mirror(true);
    case 512:
      return mirror_at_datum();
    case 513:
      return scale_at_datum();
    case 692:
      return turn_about_datum();
    default:
      break;
  }
  if (code == 690 && frames_.placement.kind == Placement::Kind::plane) {
    end_placement(Placement::Kind::plane);
    add(EventKind::g_code, code).sets_frames = true;
    return true;
  }
  if (code == 680 && frames_.placement.on())
    return refuse(b.g_column[11], "E-ROTATION", "a rotation in a scaled, mirrored or tilted frame",
                  "in which order they act is not sure", "end the other frame first");
  turn(code);
  return true;
}

/// Nothing is known of positions until the program commands them in the new frame.
void Control::forget_positions() {
  m_ = Position{};
  u_ = program_of(frames_, m_);
  pole_.reset();
}

bool Control::frame_is_bare(std::size_t column) {
  const auto& shifts = frames_.system().turns;
  if (!frames_.placement.on() && frames_.turn == 0 && frames_.system().rotation == 0 && plane_ == 170 &&
      !incremental_ && !tcp_ && shifts == std::array<double, 3>{})
    return true;
  return refuse(column, "E-FRAME",
                "a scale, mirror or tilted plane in G91, G18, G19, with tool centre point control or in "
                "another frame",
                "in which order they act is not sure", "end the other frame first, write G17 G90");
}

/// G68.2: the axes of the plane are X Y Z turned by I about Z, then by J about the new X, by K about the new
/// Z.
bool Control::begin_plane() {
  const Block& b = *block_;
  if (!frame_is_bare(block_->g_column[11])) return false;
  if ((b.words & kPlaneWords) != kPlaneWords || rotary_ == nullptr || !rotary_->declared())
    return refuse(b.g_column[11], "E-PLANE",
                  "a tilted plane without all of X Y Z I J K, or without [control]",
                  "where it is, or how the tool gets there, is not known", "write all six words");
  if (!use_all(kPlaneWords)) return false;
  Placement& placement = frames_.placement;
  for (const auto& [letter, about] : {std::pair{'I', 2}, {'J', 0}, {'K', 2}}) {
    const Vec3 axis = placement.axes[static_cast<std::size_t>(about)];
    for (Vec3& v : placement.axes) v = turned_about(axis, b[letter] * deg, v);
  }
  add(EventKind::g_code, 682, kPlaneWords).sets_frames = true;
  return place_plane(Vec3(length_word('X'), length_word('Y'), length_word('Z')));
}

bool Control::place_plane(const Vec3& origin) {
  frames_.placement.kind = Placement::Kind::plane;
  frames_.placement.origin = origin;
  on_plane_ = laid_by_words_ = false;
  forget_positions();
  return true;
}

/// PLANE SPATIAL: the axes are turned about the fixed X, then Y, then Z.
bool Control::begin_spatial_plane() {
  const Block& b = *block_;
  constexpr Letters words = letters('I', 'J', 'K', 'P', 'Q');
  if (!frame_is_bare(block_->g_column[11])) return false;
  if (rotary_ == nullptr || !rotary_->declared())
    return refuse(b.g_column[11], "E-PLANE", "a tilted plane without [control]",
                  "how the tool gets there is not known", "declare [control] in the machine file");
  if (!use_all(words)) return false;
  for (int i = 0; i < 3; ++i)
    for (Vec3& v : frames_.placement.axes)
      v = turned_about(Vec3::Unit(i), b[static_cast<char>('I' + i)] * deg, v);
  add(EventKind::g_code, 683, words).sets_frames = true;
  place_plane(Vec3::Zero());
  laid_by_words_ = b['P'] == 0;
  if (laid_by_words_) return true;
  return b.has('Q') ? lay_tool(b['Q'] < 0 ? -1 : 1) : lay_tool(std::nullopt, true);
}

/// The numbers in the brackets of CYCLE800, blank ones as 0. False: something else stands there.
bool Control::read_swivel(std::array<double, 16>& numbers, std::size_t& count) const {
  std::string_view rest = block_->frame_text;
  rest.remove_prefix(std::min(rest.size(), rest.find('(') + 1));
  if (!rest.empty()) rest.remove_suffix(1);
  if (rest.find_first_not_of(" \t") == std::string_view::npos) return true;
  constexpr std::size_t data = 1;
  for (;; ++count) {
    if (count == numbers.size()) return false;
    rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of(" \t")));
    std::size_t end = 0;
    if (count == data) {
      const std::size_t close = rest.find('"', 1);
      if (rest.empty() || rest[0] != '"' || close == std::string_view::npos || rest.substr(0, close) == "\"0")
        return false;
      end = close + 1;
    } else if (const Decimal number = read_decimal(rest); number.length > 0) {
      numbers[count] = number.value;
      end = number.length;
    }
    rest.remove_prefix(end);
    rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of(" \t")));
    if (rest.empty()) break;
    if (rest[0] != ',') return false;
    rest.remove_prefix(1);
  }
  ++count;
  return true;
}

/// CYCLE800: the axes are moved to X0 Y0 Z0, turned one after the other about themselves, moved by X1 Y1 Z1.
bool Control::swivel() {
  std::array<double, 16> numbers{};
  std::size_t count = 0;
  const std::size_t column = block_->g_column[11];
  const auto unclear = [&] {
    return refuse(column, "E-PLANE", "CYCLE800 in a form that is not followed",
                  "where the plane lies, or how the tool gets there, is not sure",
                  "write it axis by axis, with literal numbers, ST 0 and no TRANS in force");
  };
  if (!read_swivel(numbers, count) || (count > 0 && frames_.g92 != Vec3::Zero())) return unclear();
  end_placement(Placement::Kind::plane);
  Event& event = add(EventKind::g_code, 684);
  event.text = block_->frame_text;
  event.sets_frames = true;
  if (count == 0) return true;
  enum { retract, data, state, mode, first_place, first_angle = 7, behind = 10, direction = 13, fewest };
  const auto whole = [&](int i, int least, int most) {
    const double value = numbers[static_cast<std::size_t>(i)];
    return value >= least && value <= most && value == std::round(value);
  };
  const int axes = whole(mode, 0, 63) ? static_cast<int>(numbers[mode]) : 0;
  const int all = 1 << (axes & 3) | 1 << (axes >> 2 & 3) | 1 << (axes >> 4 & 3);
  constexpr int x_y_z = 14;
  if (count < fewest || numbers[state] != 0 || all != x_y_z || !whole(direction, -1, 1) ||
      !whole(retract, 0, 8))
    return unclear();
  if (!frame_is_bare(block_->g_column[11])) return false;
  if (rotary_ == nullptr || !rotary_->declared()) return unclear();
  Placement& placement = frames_.placement;
  for (int i = 0; i < 3; ++i) {
    const Vec3 axis = placement.axes[static_cast<std::size_t>((axes >> 2 * i & 3) - 1)];
    for (Vec3& v : placement.axes)
      v = turned_about(axis, numbers[static_cast<std::size_t>(first_angle + i)] * deg, v);
  }
  const auto shift = [&](std::size_t i) -> Vec3 {
    return unit_ * Vec3(numbers[i], numbers[i + 1], numbers[i + 2]);
  };
  place_plane(shift(first_place) + placement.along(shift(behind)));
  const int side = static_cast<int>(numbers[direction]);
  laid_by_words_ = side == 0;
  return laid_by_words_ || lay_tool(side);
}

/// SCALE, ASCALE, MIRROR and AMIRROR: about the zero of the frame. SCALE and MIRROR put an end to what was there.
bool Control::stretch(int code) {
  const Block& b = *block_;
  constexpr Letters words = letters('X', 'Y', 'Z');
  const bool scales = code == 683 || code == 684, replaces = code == 683 || code == 685;
  if (b.g_code(1) >= 0 || b.g_code(12) >= 0 || b.g_code(8) >= 0 || b.g_code(11) >= 0 || b.has('D') ||
      b.tcp_code >= 0 || (b.words & letters('A', 'B', 'C')) != 0)
    return refuse(b.g_column[0], "E-BLOCK", "a frame beside other codes", "their order is not defined",
                  "use two blocks");
  if (replaces) {
    const Vec3 zero = zero_of(frames_);
    end_stretch();
    frames_.g92 = Vec3::Zero();
    if (frames_.turn != 0) {
      constexpr Axes plane_xy = 3;
      frames_.turn = 0;
      m_.known &= ~plane_xy;
    }
    u_ = program_of(frames_, m_);
    move_zero(zero);
  }
  add(EventKind::g_code, code, words).sets_frames = true;
  if ((b.words & words) == 0) return true;
  if (!frame_is_bare(b.g_column[0]) || !use_all(words)) return false;
  Placement& placement = frames_.placement;
  for (int i = 0; i < 3; ++i) {
    const char letter = static_cast<char>('X' + i);
    if (!b.has(letter)) continue;
    const double factor = scales ? b[letter] : -1;
    if (scales ? !(factor >= kSmallestScale && factor <= kLargestScale) : i == 2 || b[letter] != 0)
      return refuse_at(letter, "E-FRAME", "a scale out of range, or a mirror of Z or not at zero",
                       "what is meant is not sure", "scale or mirror in the CAM system");
    placement.axes[static_cast<std::size_t>(i)] *= factor;
  }
  placement.kind = scales ? Placement::Kind::scale : Placement::Kind::mirror;
  forget_positions();
  return true;
}

void Control::end_stretch() {
  end_placement(Placement::Kind::scale);
  end_placement(Placement::Kind::mirror);
}

/// PLANE RESET: if the control turns the axes back they stand where only it knows.
bool Control::reset_plane() {
  if (!use_all(letter_bit('P'))) return false;
  end_placement(Placement::Kind::plane);
  add(EventKind::g_code, 691, letter_bit('P')).sets_frames = true;
  if ((*block_)['P'] == 0 || rotary_ == nullptr) return true;
  for (int k = 0; k < 3; ++k)
    if (rotary_->has(k)) unknown_turns_ |= Axes{1} << k;
  commanded_turns_ |= unknown_turns_;
  return true;
}

/// The rotary axes that the program has turned itself lay the tool on the plane when X, Y or Z moves.
bool Control::stand_on_plane() {
  if (frames_.placement.kind != Placement::Kind::plane || on_plane_ || named_axes(*block_) == 0) return true;
  if (!laid_by_words_ || unknown_turns_ != 0 || (block_->words & letters('A', 'B', 'C')) != 0 ||
      askew(*rotary_, frames_.placement.axes[2], turns_) > kMostAskewByWords)
    return refuse(1, "E-PLANE", "X Y Z before the tool stands on the tilted plane",
                  "the tool is not square to it", "turn the rotary axes to the plane first");
  on_plane_ = tcp_ = true;
  forget_positions();
  return true;
}

/// G53.1: the rotary axes go where the tool is square to the plane.
bool Control::tool_to_plane() {
  if (frames_.placement.kind != Placement::Kind::plane || on_plane_)
    return refuse(block_->g_column[11], "E-PLANE", "no tilted plane is declared, or the tool stands on it",
                  "where the rotary axes go is not known", "write G68.2 first");
  add(EventKind::g_code, 531).sets_frames = true;
  return lay_tool(std::nullopt);
}

/// The control turns its axes to the plane. `side`: of zero, of the axis that the machine file names;
/// `stands`: where the tool stands on the plane already.
bool Control::lay_tool(std::optional<int> side, bool stands) {
  const Vec3& normal = frames_.placement.axes[2];
  std::optional<Turns> laid;
  if (auto tilt = rotary_->tilt(); tilt && !stands) {
    tilt->sign = side.value_or(tilt->sign);
    laid = laid_on_side(*rotary_, normal, turns_, *tilt);
  } else if (!side && unknown_turns_ == 0 && askew(*rotary_, normal, turns_) < kMostAskew) {
    laid = laid_along(*rotary_, normal, turns_);
  }
  if (!laid)
    return refuse(block_->g_column[11], "E-PLANE", "where the rotary axes go is not fixed",
                  "there is more than one way", "command them before, or state tilt_solution in [control]");
  turns_ = *laid;
  for (int k = 0; k < 3; ++k)
    if (rotary_->has(k)) commanded_turns_ |= Axes{1} << k;
  unknown_turns_ = 0;
  on_plane_ = tcp_ = true;
  forget_positions();
  return true;
}

void Control::end_placement(Placement::Kind kind) {
  if (frames_.placement.kind != kind) return;
  if (kind == Placement::Kind::plane && on_plane_) tcp_ = false;
  on_plane_ = false;
  frames_.placement = {};
  forget_positions();
}

/// G51 X Y Z P: away from the point X Y Z by the factor P.
bool Control::scale() {
  const Block& b = *block_;
  constexpr Letters words = letters('X', 'Y', 'Z', 'P');
  if (!frame_is_bare(b.g_column[11])) return false;
  if ((b.words & words) != words)
    return refuse(b.g_column[11], "E-FRAME", "a scale without all of X Y Z P",
                  "its centre, or its factor, is not known", "write them");
  using Scale = Profile::Numbers::Scale;
  const Scale rule = profile_.numbers.scale_words;
  const bool counted = (b.pointless & letter_bit('P')) != 0;
  if (counted && rule == Scale::ask)
    return refuse_at('P', "E-DECIMAL", "a scale factor without a point", "a parameter says what it counts",
                     "state numbers.scale_words in a profile, or post it with a point");
  const double factor = !counted ? b['P'] : rule == Scale::thousandths ? b['P'] / 1000 : b['P'] / 100000;
  if (!(factor >= kSmallestScale && factor <= kLargestScale))
    return refuse_at('P', "E-FRAME", fmt::format("the scale factor {:g}", factor),
                     "it is more likely a wrong unit", "scale in the CAM system");
  if (!use_all(words)) return false;
  const Vec3 centre(length_word('X'), length_word('Y'), length_word('Z'));
  Placement& placement = frames_.placement;
  placement.kind = Placement::Kind::scale;
  for (Vec3& axis : placement.axes) axis *= factor;
  placement.origin = centre - factor * centre;
  forget_positions();
  add(EventKind::g_code, 510, words).sets_frames = true;
  return true;
}

/// G50 and G50.1. Where no scale or mirror is in force they may stand beside anything.
bool Control::end_stretches() {
  const Block& b = *block_;
  const bool scales = b.g_code(16) >= 0, mirrors = b.g_code(17) >= 0;
  const Placement::Kind kind = frames_.placement.kind;
  const bool acts =
      (scales && kind == Placement::Kind::scale) || (mirrors && kind == Placement::Kind::mirror);
  if (acts &&
      (b.g_code(0) >= 0 || b.g_code(1) >= 0 || b.g_code(8) >= 0 || b.g_code(11) >= 0 || b.g_code(12) >= 0 ||
       b.m_code(6) >= 0 || b.tcp_code >= 0 || (b.words & letters('A', 'B', 'C')) != 0))
    return refuse(1, "E-BLOCK", "the end of a scale or mirror beside other codes",
                  "their order is not defined", "use two blocks");
  if (scales) {
    end_placement(Placement::Kind::scale);
    add(EventKind::g_code, 500).sets_frames = true;
  }
  if (!mirrors) return true;
  if (kind == Placement::Kind::mirror) return mirror(false);
  constexpr Letters words = letters('X', 'Y');
  add(EventKind::g_code, 501, words).sets_frames = true;
  return use_all(words);
}

/// G51.1 and G50.1: X, Y or both are counted the other way from a place, or no longer.
bool Control::mirror(bool on) {
  constexpr Letters words = letters('X', 'Y');
  Placement& placement = frames_.placement;
  const bool goes_on = placement.kind == Placement::Kind::mirror;
  if (!goes_on && on && !frame_is_bare(block_->g_column[11])) return false;
  if ((block_->words & words) == 0 || incremental_)
    return refuse(1, "E-FRAME", "a mirror without an axis, or in G91", "what is mirrored is not sure",
                  "name X, Y or both, in G90");
  if (!use_all(words)) return false;
  const Letters named = block_->words & words;
  add(EventKind::g_code, on ? 511 : 501, words).sets_frames = true;
  placement.kind = Placement::Kind::mirror;
  for (int i = 0; i < 2; ++i) {
    const char letter = static_cast<char>('X' + i);
    if ((named & letter_bit(letter)) == 0) continue;
    placement.axes[static_cast<std::size_t>(i)] = (on ? -1.0 : 1.0) * Vec3::Unit(i);
    placement.origin[i] = on ? 2 * length_word(letter) : 0;
  }
  if (placement.axes[0].x() > 0 && placement.axes[1].y() > 0) placement = {};
  forget_positions();
  return true;
}

/// What a block may do while a scale, mirror or plane is in force.
bool Control::placement_allows() {
  const Placement& placement = frames_.placement;
  if (!placement.on()) return true;
  const Block& b = *block_;
  const int zero = b.g_code(0);
  const bool replaces =
      placement.kind != Placement::Kind::plane && (zero == 521 || zero == 681 || zero == 683 || zero == 685);
  if ((zero >= 0 && zero != 40 && !replaces) || b.g_code(12) >= 0 || plane_ != 170)
    return refuse(1, "E-ROTATION",
                  "another frame, plane or machine position in a scaled, mirrored or tilted one",
                  "controls differ in what it means", "end it first");
  if (b.tcp_code >= 0)
    return refuse(1, "E-TCP", "tool centre point control in a scaled, mirrored or tilted frame",
                  "what its points are is not sure", "end it first");
  return true;
}

/// The same of its motion, whose words have been read.
bool Control::placement_allows_motion() {
  const Placement& placement = frames_.placement;
  if (placement.kind == Placement::Kind::plane) {
    if (on_plane_ && motion_.turns())
      return refuse(1, "E-PLANE", "a rotary axis turns on a tilted plane", "the plane may turn with it",
                    "end the plane first");
    return true;
  }
  if (motion_.kind == MotionKind::arc && !placement.even())
    return refuse(1, "E-FRAME", "an arc in axes of different scales", "it is no arc on the machine",
                  "post lines");
  if (motion_.kind == MotionKind::cycle && (placement.kind == Placement::Kind::scale || motion_code_ == 760))
    return refuse(1, "E-CYCLE", "a canned cycle in a scaled frame, or a fine bore in a mirrored one",
                  "what the control makes of its numbers is not sure", "post the hole as lines");
  return true;
}

}  // namespace abbe::verifying
