// Motions under cutter radius compensation: what the cutter's centre, beside the contour, makes of it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/comparison.h"

namespace abbe::verifying {
namespace {

using Phase = CutterUse::Phase;

/// A way in XY below this is no way, mm.
constexpr double kNoWay = 1e-7;
/// Cosine of the angle by which digits may turn a block.
constexpr double kSameWay = 0.95;
/// Cosine of the angle by which a path turns, where it turns back.
constexpr double kTurnsBack = -1 + 1e-12;

Vec3 in_plane(const Vec3& v) { return {v.x(), v.y(), 0}; }

bool moves_in_plane(const Motion& motion) {
  return motion.kind == MotionKind::arc || in_plane(motion.end.at - motion.start.at).norm() > kNoWay;
}

/// The cutter's centre from the contour: offset times the left normal of the path, mm, axis commands.
Vec3 beside(const Motion& motion, double t) {
  const Vec3 along = in_plane(derivative_at(motion, t));
  const double length = along.norm();
  if (length < kNoWay || motion.cutter.phase != Phase::on) return Vec3::Zero();
  return Vec3(-along.y(), along.x(), 0) * (motion.cutter.offset / length);
}

/// Is the arc bent around the cutter? Its plane is XY: sweep > 0 turns left.
bool around_cutter(const Motion& motion) {
  return motion.kind == MotionKind::arc && motion.arc.sweep * motion.cutter.offset > 0;
}

double narrowest(const Arc& arc) { return std::min(arc.start_radius, arc.end_radius); }

double length_in_plane(const Motion& motion) {
  return motion.kind == MotionKind::arc ? narrowest(motion.arc) * std::abs(motion.arc.sweep)
                                        : in_plane(motion.end.at - motion.start.at).norm();
}

}  // namespace

/// The tip for the command at t of a piece. Under cutter compensation the machine stands beside the contour,
/// and its error there shows on the part across the path only:
///   tip = actual(m) + the part across the path of (actual(m + d) - nominal step of d - actual(m))
Vec3 Comparison::tip_beside(const Motion& piece, double t, const Vec3& command, bool* outside) {
  const Vec3 tip = model_.actual(command, approach_, outside);
  if (piece.cutter.offset == 0) return tip;
  const Vec3 aside = beside(piece, t);
  if (aside == Vec3::Zero()) return tip;
  const Vec3 change = model_.actual(command + aside, approach_, outside) - model_.nominal_step(aside) - tip;
  const Vec3 along = model_.nominal_step(derivative_at(piece, t));
  return tip + change - along * (along.dot(change) / along.squaredNorm());
}

/// Where the machine stands for the command at t of a piece.
Vec3 Comparison::centre_of(const Motion& piece, double t, const Vec3& command) const {
  return piece.cutter.offset == 0 ? command : command + beside(piece, t);
}

/// One motion of the output under cutter compensation against that of the original that it belongs to: side
/// and radius, and whether the control still finds its corner with the one before. `s`: where on the original
/// it begins.
void Comparison::check_beside(const Motion& original, const Motion& piece, double s) {
  if (original.cutter.phase != piece.cutter.phase || original.cutter.offset != piece.cutter.offset)
    return disagree_and_stop("V-CUTTER",
                             "cutter compensation is on another side, or another radius is in force");
  if (piece.cutter.phase == Phase::off) return;
  if (!moves_in_plane(original)) {
    if (moves_in_plane(piece))
      disagree("V-CUTTER", "X or Y moves where the original does not: the contour gets a corner");
    return;
  }
  const Vec3 from = in_plane(derivative_at(piece, 0)), to = in_plane(derivative_at(piece, 1));
  const Vec3 meant = in_plane(derivative_at(original, s));
  if (!(from.dot(meant) >= kSameWay * from.norm() * meant.norm()) || !moves_in_plane(piece))
    return disagree("V-CUTTER",
                    "this piece goes another way than the original, and so does the cutter's side");
  const double radius = std::abs(piece.cutter.offset);
  double narrowing = 1;
  if (around_cutter(piece)) {
    if (!(narrowest(piece.arc) > radius))
      return disagree("V-CUTTER", "the arc around the cutter is not larger than the cutter");
    narrowing = narrowest(piece.arc) / (narrowest(piece.arc) - radius);
  }
  const double length = length_in_plane(piece);
  if (piece.cutter.phase == Phase::on && last_beside_.length > 0) {
    // tangent length of an inside corner: r tan(theta / 2) = r sin(theta) / (1 + cos(theta))
    const Vec3 a = last_beside_.direction, b = from.normalized();
    const double sine = a.x() * b.y() - a.y() * b.x(), cosine = a.dot(b);
    const double needed =
        radius * std::abs(sine) / (1 + cosine) * std::max(narrowing, last_beside_.narrowing);
    // a turn back has no inner side
    const bool inside = sine * piece.cutter.offset > 0 || (cosine < kTurnsBack && radius > 0);
    if (inside && !(needed <= std::min(length, last_beside_.length)))
      disagree("V-CUTTER", fmt::format("the inside corner needs {:.4f} mm on both sides, {:.4f} mm are there",
                                       needed, std::min(length, last_beside_.length)));
  }
  last_beside_ = {to.normalized(), length, narrowing};
}

/// The motion with which compensation begins or ends: one block, as in the original. How the cutter's centre
/// gets beside the contour is the control's affair; the contour's point must be right, and the motion longer
/// than the radius.
void Comparison::compare_change(const Motion& original) {
  if (!pull_motion()) return;
  const Motion& found = output_.motion();
  output_turns_ = found.turns_end;
  reached_.valid = false;
  if (original.kind != found.kind || original.code != found.code || found.machine_words)
    return disagree_and_stop("V-CLASS", "another kind of motion where cutter compensation changes");
  if (original_.deletable() != output_.deletable())
    disagree("V-EVENT", "one of the blocks can be deleted with '/', the other not");
  ++(original.kind == MotionKind::rapid ? report_.rapid_motions : report_.feed_motions);
  if (original.feeds() && original.feed_mode == 930 && original.feed != found.feed)
    disagree("V-FEED", fmt::format("expected F{:g}, found F{:g}", original.feed, found.feed));
  check_beside(original, found, 0);
  if (stop_) return;
  constexpr Axes plane_xy = 3;
  const bool keeps_plane = original.kind == MotionKind::rapid && !moves_in_plane(original);
  compare_rapid(original, found, keeps_plane ? plane_xy : 0);
}

}  // namespace abbe::verifying
