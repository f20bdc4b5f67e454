// The last lines of every kernel_*.cpp: its table of functions. No #pragma once: one inclusion per file.

#include "abbe/kernel/kernel_correct_single.h"
#include "abbe/kernel/kernel_lines.h"

namespace abbe::kernel {
namespace {

void one_tip(const FlatView& plan, const double* tool_tip, const signed char* approach, const double* q,
             double* tip, unsigned char* lane) {
  State<double> state;
  state.tip = tool_tip;
  state.approach = approach;
  state.q = q;
  Triple<double> p, a;
  walk_actual<double, false>(plan, state, p, a);
  tip[0] = p.x, tip[1] = p.y, tip[2] = p.z;
  if (state.outside != 0) *lane |= Lane::outside;
}

/// Tips, and if `kAxis` tool axes behind them, packet by packet.
template <bool kAxis>
void find_poses(const FlatView& plan, const double* tool_tip, const double* tool_axis,
                const signed char* approach, const double* const* q, std::size_t count, double* const* to,
                unsigned char* lanes) {
  for (std::size_t first = 0; first < count; first += lanes_of<Packet>) {
    Packet commands[kMaxFlatAxes];
    const Source from = {q, first, count};
    for (int i = 0; i < plan.axis_count; ++i) commands[i] = load<Packet>(from, i);
    State<Packet> state;
    state.q = commands;
    state.tip = tool_tip;
    state.axis = tool_axis;
    state.approach = approach;
    Triple<Packet> p, a;
    walk_actual<Packet, kAxis>(plan, state, p, a);
    store(to[0], first, count, p.x);
    store(to[1], first, count, p.y);
    store(to[2], first, count, p.z);
    if (kAxis) {
      store(to[3], first, count, a.x);
      store(to[4], first, count, a.y);
      store(to[5], first, count, a.z);
    }
    mark(state.outside, 0, from, lanes_of<Packet>, lanes);
  }
}

void tips(const FlatView& plan, const double* tool_tip, const signed char* approach, const double* const* q,
          std::size_t count, double* const* tip, unsigned char* lanes) {
  find_poses<false>(plan, tool_tip, nullptr, approach, q, count, tip, lanes);
}

void poses(const FlatView& plan, const Setting& setting, const double* const* q, std::size_t count,
           double* const* pose, unsigned char* lanes) {
  find_poses<true>(plan, setting.tip, setting.axis, setting.approach, q, count, pose, lanes);
}

void estimate_poses(const FlatView& plan, const Setting& setting, const double* const* q,
                    double* const* estimate, PoseWork& work, unsigned char* lanes) {
  const FreeAxes axes = free_axes_of(plan, setting);
  std::size_t i = 0;
#if defined(ABBE_KERNEL_HAS_SINGLES)
  while (i < PoseWork::kMost && estimate_singles(plan, setting, axes, q, i, estimate, work, work.places))
    i += kSingles;
#endif
  for (; i < PoseWork::kMost; i += lanes_of<Packet>)
    estimate_packet<Packet>(plan, setting, axes, q, i, estimate, work, lanes);
}

void refine_poses(const FlatView& plan, const Setting& setting, const PoseWork& work,
                  const double* const* estimate, const double* const* stand, double* const* found,
                  double* turn_left, double* way_left, unsigned char* lanes) {
  const FreeAxes axes = free_axes_of(plan, setting);
  for (std::size_t i = 0; i < PoseWork::kMost; i += lanes_of<Packet>)
    refine_packet<Packet>(plan, setting, axes, work, estimate, stand, i, found, turn_left, way_left, lanes);
}

void correct_poses(const FlatView& plan, const Setting& setting, const double* const* q, std::size_t count,
                   double* const* corrected, double* last, unsigned char* lanes) {
  const FreeAxes axes = free_axes_of(plan, setting);
  if (count == 1) return correct_packet<double>(plan, setting, axes, {q, 0, 1}, corrected, last, lanes);
  std::size_t i = 0;
#if defined(ABBE_KERNEL_HAS_SINGLES)
  // Where single precision is refused, it is so for a while: the pause before the next trial doubles.
  std::size_t pause = 0, wait = 0;
  Place places[kPlaces];
  // With one rotary axis the direction is a least-squares answer and only as exact as the Jacobian.
  const bool in_singles = setting.exact_steps == 0 || axes.rotary_count != 1;
  for (; in_singles && i + kSingles <= count; i += kSingles) {
    if (wait == 0) {
      if (correct_singles(plan, setting, axes, q, i, corrected, last, places, walk_first_order<Single>)) {
        pause = 0;
        continue;
      }
      pause = pause < 8 ? 2 * pause + 1 : pause;
      wait = pause;
    } else {
      --wait;
    }
    for (std::size_t k = i; k < i + kSingles; k += lanes_of<Packet>)
      correct_packet<Packet>(plan, setting, axes, {q, k, count}, corrected, last, lanes);
  }
#endif
  for (; i < count; i += lanes_of<Packet>)
    correct_packet<Packet>(plan, setting, axes, {q, i, count}, corrected, last, lanes);
}

}  // namespace

const Kernel& ABBE_KERNEL_FUNCTION() {
  static constexpr Kernel kernel = {ABBE_KERNEL_NAME, lanes_of<Packet>, one_tip,     tips, poses,
                                    correct_poses,    estimate_poses,   refine_poses};
  return kernel;
}

}  // namespace abbe::kernel
