#include "abbe/verify/frames.h"

namespace abbe::verifying {
namespace {

constexpr Axes kPlaneXy = 3;

Axes known_after_rotation(Axes known, double angle) {
  return angle == 0 || (known & kPlaneXy) == kPlaneXy ? known : known & ~kPlaneXy;
}

void forget_unknown(Position& position) {
  for (int i = 0; i < 3; ++i)
    if ((position.known >> i & 1) == 0) position.at[i] = 0;
}

/// Rz(angle) (u - k) + k with k = pivot + g92.
Vec3 turned(const Frames& frames, const Vec3& u, double angle) {
  if (angle == 0) return u;
  const Vec3 k = frames.pivot + frames.g92;
  return rotated_about_z(u - k, angle) + k;
}

/// Of a tilted plane every axis of the machine depends on all coordinates, and the other way round.
Axes known_through(const Frames& frames, Axes known) {
  if (frames.placement.kind == Placement::Kind::plane) return known == kAllAxes ? known : 0;
  return known_after_rotation(known, frames.rotation());
}

}  // namespace

bool Placement::even() const {
  constexpr double same = 1e-12;
  const double x = axes[0].norm();
  return std::abs(axes[1].norm() - x) <= same * x && std::abs(axes[2].norm() - x) <= same * x;
}

Vec3 Placement::back(const Vec3& q) const {
  // the axes are at right angles: each coordinate alone
  Vec3 p;
  for (std::size_t i = 0; i < 3; ++i)
    p[static_cast<Eigen::Index>(i)] = axes[i].dot(q - origin) / axes[i].squaredNorm();
  return p;
}

Vec3 vector_of(const Frames& frames, const Vec3& v) {
  return frames.placement.on() ? frames.placement.along(v) : rotated_about_z(v, frames.rotation());
}

Frames frames_of(const ControlSetup& setup, const Profile& profile) {
  const auto known = [](const WorkOffset& given) {
    return Frames::System{Vec3(given.origin[0], given.origin[1], given.origin[2]), given.rotation, kAllAxes,
                          given.turns};
  };
  Frames frames;
  for (const auto& given : setup.work_offsets)
    frames.systems.push_back(given ? known(*given) : Frames::System{});
  for (int number = 1; number <= profile.offsets.further; ++number) {
    const auto given = setup.further_offsets.find(number);
    frames.systems.push_back(given == setup.further_offsets.end() ? Frames::System{} : known(given->second));
  }
  return frames;
}

Position machine_of_any(const Frames& frames, const Position& u) {
  const Frames::System& system = frames.system();
  Position m;
  m.known = known_through(frames, u.known);
  if (frames.placement.on()) {
    m.at = frames.placement.of(u.at - frames.g92) + frames.g92 + system.origin + frames.tool_offset;
    if (m.known != kAllAxes) forget_unknown(m);
    return m;
  }
  // m = Rz u + origin + tool_offset
  m.at = rotated_about_z(turned(frames, u.at, frames.turn), system.rotation) + system.origin +
         frames.tool_offset;
  if (m.known != kAllAxes) forget_unknown(m);
  return m;
}

Position program_of(const Frames& frames, const Position& m) {
  const Frames::System& system = frames.system();
  Position u;
  u.known = known_through(frames, m.known);
  if (frames.placement.on()) {
    u.at = frames.placement.back(m.at - system.origin - frames.tool_offset - frames.g92) + frames.g92;
    if (u.known != kAllAxes) forget_unknown(u);
    return u;
  }
  // u = Rz^-1 (m - origin - tool_offset)
  u.at = turned(frames, rotated_about_z(m.at - system.origin - frames.tool_offset, -system.rotation),
                -frames.turn);
  if (u.known != kAllAxes) forget_unknown(u);
  return u;
}

}  // namespace abbe::verifying
