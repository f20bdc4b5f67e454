#pragma once

#include <cmath>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/control_setup.h"

namespace abbe::verifying {

/// Sets of the axes X Y Z: bit 0, 1, 2.
using Axes = unsigned;
inline constexpr Axes kAllAxes = 7;

/// Axes of a program that are not those of its work offset: of a tilted plane, longer by a scale, turned
/// round by a mirror. They are at right angles to each other.
///   p becomes origin + axes[0] x + axes[1] y + axes[2] z
struct Placement {
  enum class Kind : std::uint8_t { none, plane, scale, mirror };
  Kind kind = Kind::none;
  std::array<Vec3, 3> axes{Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  Vec3 origin = Vec3::Zero();
  [[nodiscard]] bool on() const { return kind != Kind::none; }
  [[nodiscard]] bool even() const;  ///< all axes are as long
  [[nodiscard]] Vec3 of(const Vec3& p) const { return origin + along(p); }
  [[nodiscard]] Vec3 along(const Vec3& v) const {
    return v.x() * axes[0] + v.y() * axes[1] + v.z() * axes[2];
  }
  [[nodiscard]] Vec3 back(const Vec3& q) const;  ///< the inverse of `of`
};

/// What lies between a program's numbers and the axis commands:
///   m = Rz(rotation) (p + g92) + origin + tool_offset
/// p program position, m axis command; all in mm. Positions are kept as u = p + g92, which G92 and
/// G52 do not change. A rotation by the program (G68) turns u about k + g92 before that, a placement takes p.
struct Frames {
  struct System {
    Vec3 origin = Vec3::Zero();
    double rotation = 0;            ///< rad, about Z
    Axes defined = 0;               ///< axes whose origin is known
    std::array<double, 3> turns{};  ///< where A B C are zero, rad
  };
  std::vector<System> systems;  ///< G54 .. G59.3, then the further ones
  int active = 0;
  Vec3 g92 = Vec3::Zero();
  Vec3 tool_offset = Vec3::Zero();
  double turn = 0;            ///< rad, about `pivot`, made by the program
  Vec3 pivot = Vec3::Zero();  ///< program coordinates
  Placement placement;

  [[nodiscard]] const System& system() const { return systems[static_cast<std::size_t>(active)]; }
  [[nodiscard]] double rotation() const { return system().rotation + turn; }
};

/// Where an axis command reads zero but for rotations: origin + g92, mm.
[[nodiscard]] inline Vec3 zero_of(const Frames& frames) { return frames.system().origin + frames.g92; }

[[nodiscard]] Frames frames_of(const ControlSetup& setup, const Profile& profile);

/// Rz(angle) v.
[[nodiscard]] inline Vec3 rotated_about_z(const Vec3& v, double angle) {
  if (angle == 0) return v;
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

/// A position of which some axes may be unknown.
struct Position {
  Vec3 at = Vec3::Zero();  ///< unknown axes are 0
  Axes known = 0;
};

/// m = Rz(rotation) u + origin + tool_offset. A rotated X is known only together with Y.
[[nodiscard]] Position machine_of_any(const Frames& frames, const Position& u);
[[nodiscard]] inline Position machine_of(const Frames& frames, const Position& u) {
  const Frames::System& system = frames.system();
  if (u.known != kAllAxes || frames.turn != 0 || frames.placement.on()) return machine_of_any(frames, u);
  return {rotated_about_z(u.at, system.rotation) + system.origin + frames.tool_offset, kAllAxes};
}

/// What a vector of the program is in axis commands.
[[nodiscard]] Vec3 vector_of(const Frames& frames, const Vec3& v);

/// The inverse: u = Rz(-rotation) (m - origin - tool_offset).
[[nodiscard]] Position program_of(const Frames& frames, const Position& m);

}  // namespace abbe::verifying
