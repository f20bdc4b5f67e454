// How the tool turns between the ends of a block: with the axes, each of them evenly, or in one plane. Codes
// say, and machine data say which of them count.
#include <Eigen/Dense>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/verify/control.h"

namespace abbe::verifying {
namespace {

constexpr double kSameTurn = 0.011 * deg;  // of an axis, between the two ways
constexpr double kFarApart = 3;            // rad, of the tool: its plane is not sure
constexpr double kSwings = 0.015;          // rad of the tool per rad of an axis: less is near a pole
constexpr double kProbe = 1e-5;            // rad
constexpr int kParts = 8;

Turns between(const Turns& from, const Turns& to, double s) {
  Turns turns{};
  for (std::size_t k = 0; k < 3; ++k) turns[k] = (1 - s) * from[k] + s * to[k];
  return turns;
}

}  // namespace

void Control::note_turn_codes() {
  constexpr int frame = 18, way = 19;
  if (const int code = block_->g_code(frame); code >= 0) {
    turns_of_ = profile_.g[static_cast<std::size_t>(code)].meaning;
    add(EventKind::g_code, code);
  }
  if (const int code = block_->g_code(way); code >= 0) {
    turning_ = profile_.g[static_cast<std::size_t>(code)].meaning;
    add(EventKind::g_code, code);
  }
}

/// ORIMKS with ORIAXES is sure. One of them is if the machine file says what counts, and nothing contradicts.
bool Control::axes_go_evenly() const {
  if (profile_.turns_evenly) return true;
  if (turning_ == Meaning::unknown && turns_of_ == Meaning::unknown) return true;  // reported by the rewriter
  const bool axes = turning_ == Meaning::axes_evenly, machine = turns_of_ == Meaning::turns_of_machine;
  if (axes && machine) return true;
  const bool contradicted =
      turning_ == Meaning::tool_evenly || (turns_of_ == Meaning::turns_of_workpiece && !axes);
  return !contradicted && rotary_->between_evenly();
}

/// Whether the tool, turned in one plane, would need the axes elsewhere than on their even way. The tool's
/// lag e behind that plane is of turns J^-1 e; J from differences, by least squares.
bool Control::one_way(const Turns& from, const Turns& to) const {
  const Tool tool = tool_of(rotary_->kinematics().believed(), 0);
  const auto axis_at = [&](const Turns& turns) {
    return Vec3(rotary_->kinematics().pose(Vec3::Zero(), turns, tool).tool_axis.normalized());
  };
  const Vec3 first = axis_at(from), last = axis_at(to);
  const Vec3 across = first.cross(last);
  const double sweep = std::atan2(across.norm(), first.dot(last));
  if (!(sweep > 0 && sweep < kFarApart)) return false;
  const Vec3 pivot = across.normalized();
  for (int i = 0; i <= kParts; ++i) {
    const double s = static_cast<double>(i) / kParts;
    const Turns even = between(from, to, s);
    const Vec3 is = axis_at(even), flat = Eigen::AngleAxisd(s * sweep, pivot) * first;
    Mat3 slopes = Mat3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (from[k] == to[k]) continue;
      Turns on = even;
      on[k] += kProbe;
      const Vec3 slope = (axis_at(on) - is) / kProbe;
      if (slope.norm() < kSwings) return false;
      slopes.col(static_cast<Eigen::Index>(k)) = slope;
    }
    const Vec3 lag = flat - is;
    const Vec3 turns = slopes.completeOrthogonalDecomposition().solve(lag);
    if (!(turns.cwiseAbs().maxCoeff() <= kSameTurn && (lag - slopes * turns).norm() <= kSameTurn))
      return false;
  }
  return true;
}

bool Control::way_is_sure() {
  if (!tcp_ || axes_go_evenly() || one_way(motion_.turns_start, motion_.turns_end)) return true;
  return refuse(1, "E-TCP", "the rotary axes have two ways along this block",
                "codes and machine data decide whether each goes evenly or the tool stays in a plane",
                "write ORIMKS and ORIAXES behind TRAORI, or post shorter blocks");
}

}  // namespace abbe::verifying
