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

}  // namespace

Frames frames_of(const ControlSetup& setup) {
  Frames frames;
  for (std::size_t i = 0; i < frames.systems.size(); ++i) {
    const auto& given = setup.work_offsets[i];
    if (!given) continue;
    frames.systems[i] = {Vec3(given->origin[0], given->origin[1], given->origin[2]), given->rotation,
                         kAllAxes, given->turns};
  }
  return frames;
}

Position machine_of_partly_known(const Frames& frames, const Position& u) {
  const Frames::System& system = frames.system();
  Position m;
  m.known = known_after_rotation(u.known, system.rotation);
  // m = Rz u + origin + tool_offset
  m.at = rotated_about_z(u.at, system.rotation) + system.origin + frames.tool_offset;
  if (m.known != kAllAxes) forget_unknown(m);
  return m;
}

Position program_of(const Frames& frames, const Position& m) {
  const Frames::System& system = frames.system();
  Position u;
  u.known = known_after_rotation(m.known, system.rotation);
  // u = Rz^-1 (m - origin - tool_offset)
  u.at = rotated_about_z(m.at - system.origin - frames.tool_offset, -system.rotation);
  if (u.known != kAllAxes) forget_unknown(u);
  return u;
}

}  // namespace abbe::verifying
