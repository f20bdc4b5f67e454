// Cutter radius compensation as the verifying control follows it: G41 G42 G40 and what may stand under them.
#include <fmt/format.h>

#include <cmath>

#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

using Phase = CutterUse::Phase;

constexpr int kOff = 400, kLeft = 410, kLeftDirect = 411, kRightDirect = 421;
/// A way in XY below this is no way.
constexpr double kNoWay = 1e-7;  // mm

}  // namespace

/// Codes and words that may not stand between G41 and the motion of G40.
bool Control::cutter_permits() {
  if (cutter_.phase == Phase::off) return true;
  const Block& b = *block_;
  constexpr std::uint32_t frames = 1u << 2 | 1u << 6 | 1u << 8 | 1u << 11 | 1u << 12;
  const int once = b.g_code(0), stop = b.m_code(Block::kStops);
  const bool edge = b.has('D') && profile_.tools.edges != Profile::Tools::Edges::none;
  const bool changes = (b.g_groups & frames) != 0 || b.tcp_code >= 0 || edge || (once >= 0 && once != 40);
  const bool leaves = (b.m_groups >> 6 & 1) != 0 || stop == 2 || stop == 17 || stop >= 30;
  const bool turns = (b.words & letters('A', 'B', 'C')) != 0;
  if (!changes && (!leaves || stop == 60) && !turns && motion_code_ <= 30) return true;
  return refuse(1, "E-CUTCOM", "this block may not stand under cutter compensation",
                "controls refuse it, or differ in where the cutter goes then",
                "end the compensation with G40 and a motion before");
}

bool Control::switch_cutter(int code) {
  const auto bad = [&](std::string message, const char* why, const char* fix) {
    return refuse(block_->g_column[7], "E-CUTCOM", std::move(message), why, fix);
  };
  Letters words = 0;
  const bool stays = profile_.text.conversational && code == cutter_code_ &&
                     (cutter_.phase == Phase::begins || cutter_.phase == Phase::on);
  if (stays) {  // RL in every block says nothing new
    add(EventKind::g_code, code);
    return true;
  }
  if (code == kOff) {
    if (cutter_.phase == Phase::on) cutter_.phase = Phase::ends;
    if (cutter_.phase == Phase::begins) cutter_ = {};
  } else {
    if (cutter_.phase != Phase::off)
      return bad("G41 or G42 while cutter compensation is on", "the path in between depends on the control",
                 "end it with G40 and a motion before");
    if (plane_ != 170 || tcp_)
      return bad("cutter compensation outside the XY plane of the axes",
                 "what is offset depends on the control", "use G17, without tool centre point control");
    if (frames_.placement.on())
      return bad("cutter compensation where the program's axes are not those of its work offset",
                 "the radius may be scaled, and its side mirrored", "end the frame before");
    if (block_->has('D') && profile_.tools.edges == Profile::Tools::Edges::none) {
      words = letter_bit('D');
      if (!use('D')) return false;
    }
    const auto radius = radius_in_force(code);
    if (!radius || !(*radius >= 0))
      return bad(radius ? "the radius of the cutter is negative" : "the radius of the cutter is not known",
                 "where the cutter's centre goes depends on it",
                 "give --radius D3=5.0, or D in the tool table");
    const bool left = code == kLeft || code == kLeftDirect;
    cutter_ = {Phase::begins, left ? *radius : -*radius};
    cutter_code_ = code;
  }
  add(EventKind::g_code, code, words);
  return true;
}

/// mm; nothing: not known.
std::optional<double> Control::radius_in_force(int code) const {
  using Edges = Profile::Tools::Edges;
  const Block& b = *block_;
  const auto of = [&](std::optional<int> number) {
    if (!number) return std::optional<double>();
    if (const auto given = radii_.find(*number); given != radii_.end()) return std::optional(given->second);
    const auto entry = tools_.find(*number);
    const bool stated = entry != tools_.end() && entry->second.diameter != 0;
    return stated ? std::optional(entry->second.diameter / 2) : std::nullopt;
  };
  if (code == kLeftDirect || code == kRightDirect)
    return b.has('D') ? std::optional(b['D'] * unit_ / 2) : std::nullopt;
  if (profile_.tools.edges != Edges::none) {
    if (!edge_number_) return std::nullopt;
    if (*edge_number_ == 0) return 0;
    return of(profile_.tools.edges == Edges::tool ? tool_ : edge_number_);
  }
  const double d = b.has('D') ? b['D'] : 0;
  if (d != std::floor(d) || std::abs(d) > 1e6) return std::nullopt;
  if (d != 0) return of(static_cast<int>(d));
  if (!profile_.tools.h_needed) return of(tool_);  // no D, or D0: the tool in the spindle
  return b.has('D') ? std::optional(0.0) : std::nullopt;
}

/// The motion of this block has been read: what it is to the compensation.
bool Control::move_beside() {
  if (cutter_.phase == Phase::off) return true;
  const bool arc = motion_.kind == MotionKind::arc;
  if (motion_.start.known != kAllAxes || motion_.end.known != kAllAxes)
    return refuse(1, "E-CUTCOM",
                  "a motion under cutter compensation with an axis whose position is not known",
                  "the side of the cutter cannot be followed", "command X, Y and Z before");
  if (arc && (cutter_.phase != Phase::on || motion_.arc.turns > 1))
    return refuse(1, "E-CUTCOM",
                  motion_.arc.turns > 1 ? "an arc of several turns under cutter compensation"
                                        : "cutter compensation begins or ends on an arc",
                  "the path depends on the control", "use straight motions, and arcs of one turn");
  if (frames_.placement.on())
    return refuse(1, "E-CUTCOM", "the program's axes change under cutter compensation",
                  "what is offset depends on the control", "end the compensation with G40 before");
  const Vec3 way = motion_.end.at - motion_.start.at;
  const double length = std::hypot(way.x(), way.y());
  motion_.cutter = cutter_;
  if (cutter_.phase == Phase::begins) {
    if (!(length > std::abs(cutter_.offset) + kNoWay))
      return refuse(1, "E-CUTCOM", "cutter compensation begins on a motion not longer than the radius",
                    "the control cannot get beside the contour", "begin it on a longer motion in X and Y");
    cutter_.phase = Phase::on;
  } else if (cutter_.phase == Phase::ends && length > kNoWay) {
    cutter_ = {};
  }
  return true;
}

}  // namespace abbe::verifying
