// The last lines of every kernel_*.cpp: its table of functions. No #pragma once: one inclusion per file.

#include "abbe/kernel/kernel_correct.h"

namespace abbe::kernel {
namespace {

void one_tip(const FlatView& plan, const double* tool_tip, const signed char* approach, const double* q,
             double* tip, unsigned char* lane) {
  State<double> state;
  state.tip = tool_tip;
  state.approach = approach;
  for (int i = 0; i < plan.axis_count; ++i) state.q[i] = q[i];
  Triple<double> p, a;
  walk_actual<double, false>(plan, state, p, a);
  tip[0] = p.x, tip[1] = p.y, tip[2] = p.z;
  if (state.outside != 0) *lane |= Lane::outside;
}

void tips(const FlatView& plan, const double* tool_tip, const signed char* approach, const double* const* q,
          std::size_t count, double* const* tip, unsigned char* lanes) {
  for (std::size_t first = 0; first < count; first += lanes_of<Packet>) {
    State<Packet> state;
    state.tip = tool_tip;
    state.approach = approach;
    for (int i = 0; i < plan.axis_count; ++i) state.q[i] = load<Packet>({q, first, count}, i);
    Triple<Packet> p, a;
    walk_actual<Packet, false>(plan, state, p, a);
    store(tip[0], first, count, p.x);
    store(tip[1], first, count, p.y);
    store(tip[2], first, count, p.z);
    for (std::size_t i = first; state.outside != 0 && i < count && i < first + lanes_of<Packet>; ++i)
      if ((state.outside >> (i - first) & 1) != 0) lanes[i] |= Lane::outside;
  }
}

void correct_poses(const FlatView& plan, const Setting& setting, const double* const* q, std::size_t count,
                   double* const* corrected, double* last, unsigned char* lanes) {
  const FreeAxes axes = free_axes_of(plan, setting);
  if (count == 1) return correct_packet<double>(plan, setting, axes, {q, 0, 1}, corrected, last, lanes);
  for (std::size_t i = 0; i < count; i += lanes_of<Packet>)
    correct_packet<Packet>(plan, setting, axes, {q, i, count}, corrected, last, lanes);
}

}  // namespace

const Kernel& ABBE_KERNEL_FUNCTION() {
  static constexpr Kernel kernel = {ABBE_KERNEL_NAME, lanes_of<Packet>, one_tip, tips, correct_poses};
  return kernel;
}

}  // namespace abbe::kernel
