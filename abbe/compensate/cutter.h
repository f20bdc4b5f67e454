#pragma once

#include <cstdint>
#include <optional>

#include "abbe/compensate/arc.h"
#include "abbe/core/linear_algebra.h"

namespace abbe {

/// Cutter radius compensation by the control (G41 G42) between two blocks. `begins` and `ends`: the code has
/// been read, the motion in the plane that belongs to it has not.
struct CutterState {
  enum class Phase : std::uint8_t { off, begins, on, ends } phase = Phase::off;
  double offset = 0;  ///< mm to the left of the path: +r for G41, -r for G42
  bool left = true;   ///< G41; r may be 0

  [[nodiscard]] bool acts() const { return phase != Phase::off; }
  [[nodiscard]] bool on() const { return phase == Phase::on; }
};

/// What a block that is written does in XY: unit tangents at both ends, length and curvature.
struct PlaneWay {
  Vec3 first = Vec3::Zero(), last = Vec3::Zero();
  double length = 0;  ///< mm
  double radius = 0;  ///< mm, > 0 turning left, < 0 turning right, 0: straight
};

/// errors   nullopt: nothing moves in XY
[[nodiscard]] std::optional<PlaneWay> straight_way(const Vec3& start, const Vec3& end);
/// cost     as arc_about
[[nodiscard]] std::optional<PlaneWay> arc_way(const Vec3& start, const Vec3& end, const Centre& centre,
                                              bool clockwise);

/// The point of the cutter's centre belongs to the contour's by this vector: offset times the left normal of
/// the tangent t in XY, (-t_y, t_x) / |t|; zero where t has no part in XY. mm
[[nodiscard]] Vec3 to_centre(const Vec3& tangent, double offset);

/// How much of both neighbours the control cuts off at a corner, mm: with the angle theta by which the path
/// turns towards the cutter
///
///   l = |offset| tan(theta / 2) k_before, k_after     k = R / (R - |offset|) on an arc around the cutter, or
///   1
///
/// 0 where it turns away or not at all; infinite where it turns back or an arc is too narrow.
/// laws     ACornerAwayFromTheCutterCutsNothingOff, ARightAngleCutsOffTheRadius, MirroredPathsAreMirrored
/// source   the tangent length of two lines that touch a circle
[[nodiscard]] double cut_off(const PlaneWay& before, const PlaneWay& after, double offset);

/// The arc lies around the cutter, and its radius is not larger than the cutter's: it cannot be cut.
[[nodiscard]] bool too_narrow(const PlaneWay& way, double offset);

/// Both neighbours of the corner are long enough for the control to find the centre's corner, with 5 % to
/// spare.
[[nodiscard]] bool corner_fits(const PlaneWay& before, const PlaneWay& after, double offset);

}  // namespace abbe
