// Correction of many poses side by side: the first-order step and the solutions in single precision, the
// residuals of Newton steps in double precision. See kernel_code.h for what may stand here.
#pragma once

#include "abbe/kernel/kernel_correct.h"
#include "abbe/kernel/kernel_single.h"

#if defined(ABBE_KERNEL_HAS_SINGLES)

namespace abbe::kernel {
namespace {

/// Rotary commands beyond this are refused: their multiples of pi/2 are no longer exact.
constexpr float kMostCommand = 1e5f;

/// Tip and tool axis of kSingles poses in double precision.
struct Poses {
  alignas(64) double number[6][kSingles];
};

template <bool kNominal>
inline unsigned walk_poses(const FlatView& plan, const Setting& setting, const Commands* q, Poses& to) {
  Packet lanes[kMaxFlatAxes];
  State<Packet> state;
  state.q = lanes;
  use(setting, state);
  constexpr int kLanes = lanes_of<Packet>;
  for (int first = 0; first < kSingles; first += kLanes) {
    for (int i = 0; i < plan.axis_count; ++i)
      __builtin_memcpy(&lanes[i], reinterpret_cast<const double*>(&q[i]) + first, sizeof(Packet));
    Triple<Packet> p, a;
    kNominal ? walk_nominal<Packet>(plan, state, p, a) : walk_actual<Packet, true>(plan, state, p, a);
    const Packet numbers[6] = {p.x, p.y, p.z, a.x, a.y, a.z};
    for (int k = 0; k < 6; ++k) __builtin_memcpy(to.number[k] + first, &numbers[k], sizeof(Packet));
  }
  return state.outside;
}

/// The difference of two poses is small enough for single precision.
inline Triple<Single> difference(const Poses& a, const Poses& b, int k, const double* shift) {
  const auto component = [&](int i) {
    const Commands x = load_commands(a.number[k + i]), y = load_commands(b.number[k + i]);
    return rounded({x.first - y.first - shift[i], x.second - y.second - shift[i]});
  };
  return {component(0), component(1), component(2)};
}

/// Loads kSingles poses; the lanes whose rotary commands are too far from zero.
inline unsigned load_poses(const FlatView& plan, const double* const* q, std::size_t first,
                           State<Single>& state, Commands* commands) {
  unsigned refused = 0;
  for (int i = 0; i < plan.axis_count; ++i) {
    state.commands[i] = q[i] + first;
    commands[i] = load_commands(state.commands[i]);
    state.q[i] = rounded(commands[i]);
    if ((plan.rotary >> i & 1) != 0) refused |= lanes_outside(state.q[i], -kMostCommand, kMostCommand);
  }
  return refused;
}

/// The corrections of kSingles poses from `first` on. False, and nothing is written, where single precision
/// would show, and for every pose that is not ordinary. `walk`: walk_first_order, or what does the same.
template <class Walk>
[[gnu::always_inline]] inline bool correct_singles(const FlatView& plan, const Setting& setting,
                                                   const FreeAxes& axes, const double* const* q,
                                                   std::size_t first, double* const* corrected, double* last,
                                                   Place* places, const Walk& walk) {
  State<Single> state;
  use(setting, state);
  state.places = places;
  Commands commands[kMaxFlatAxes];
  Single change[kMaxFlatAxes], turned[2] = {};
  unsigned refused = load_poses(plan, q, first, state, commands);
  FirstOrder<Single> f;
  walk(plan, setting, state, f);
  const Solver<Single> solver(axes, f);
  refused |= solver.unusual;

  const auto move = [&](const Triple<Single>& position, const Triple<Single>& direction) {
    for (int i = 0; i < plan.axis_count; ++i) change[i] = Single{};
    const Single size = solver.step(position, direction, change);
    refused |= lanes_outside(size, 0.0f, static_cast<float>(kMostStep));
    for (int i = 0; i < axes.rotary_count; ++i) turned[i] = turned[i] + change[axes.rotary[i]];
    for (int i = 0; i < plan.axis_count; ++i) add(commands[i], change[i]);
    return size;
  };
  Poses nominal, actual;
  if (setting.exact_steps > 0) walk_poses<true>(plan, setting, commands, nominal);
  Single size = move(f.dp - broadcast<Single>(setting.shift), cross(f.e, f.a));
  if (state.refused || refused != 0) return false;
  for (int i = 0; i < setting.exact_steps; ++i) {
    refused |= walk_poses<false>(plan, setting, commands, actual);
    size = move(difference(actual, nominal, 0, setting.shift), difference(actual, nominal, 3, kNowhere));
  }
  const auto most = static_cast<float>(setting.max_rotary * (1 - 1e-6));
  for (int i = 0; i < axes.rotary_count; ++i) refused |= lanes_outside(turned[i], -most, most);
  if (refused != 0) return false;
  for (int i = 0; i < plan.axis_count; ++i) store_commands(corrected[i] + first, commands[i]);
  Commands sizes = {};
  add(sizes, size);
  store_commands(last + first, sizes);
  return true;
}

}  // namespace
}  // namespace abbe::kernel

#endif
