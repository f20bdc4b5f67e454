// Linear axes that bring the tip to where it was meant to be, for rotary axes that are already decided. See
// kernel_code.h for what may stand here.
#pragma once

#include "abbe/kernel/kernel_correct.h"

namespace abbe::kernel {
namespace {

/// The nominal part of a FirstOrder: tip, tool axis and their derivatives.
template <class V>
[[gnu::always_inline]] inline void walk_columns(const FlatView& plan, const Setting& setting, State<V>& state,
                                                FirstOrder<V>& f) {
  using Kind = FlatStep::Kind;
  FirstOrderWalk<V> walk(plan, setting, state, f);
  for (std::uint32_t i = 0; i < plan.first_order_count; ++i) {
    const Op<V>& op = plan.first_order[i];
    if (op.kind == Kind::twist || op.kind == Kind::fixed_twist) {
      if (op.moves_on) walk.p = walk.p + broadcast<V>(op.t);
    } else {
      walk.take(op);
    }
  }
  walk.finish();
}

/// q := q - J_linear^-1 (tip_actual(q) - tip_nominal(commanded) - shift)
template <class V>
void settle_packet(const FlatView& plan, const Setting& setting, const FreeAxes& linear,
                   const Source& commanded, const Source& start, double* const* settled, double* last,
                   unsigned char* lanes) {
  V q[kMaxFlatAxes];
  State<V> state;
  state.q = q;
  state.tip = setting.tip;
  state.axis = setting.axis;
  state.approach = setting.approach;
  for (int i = 0; i < plan.axis_count; ++i) q[i] = load<V>(commanded, i);
  FirstOrder<V> f;
  walk_columns(plan, setting, state, f);
  const Solver<V> solver(linear, f);
  for (int i = 0; i < plan.axis_count; ++i) q[i] = load<V>(start, i);
  Triple<V> p, a;
  walk_actual<V, false>(plan, state, p, a);
  const V size = solver.step(p - f.p - broadcast<V>(setting.shift), Triple<V>{}, q);
  for (const int axis : linear.linear) store(settled[axis], start.first, start.count, q[axis]);
  store(last, start.first, start.count, size);
  mark(state.outside, solver.unusual | lanes_outside(size, 0.0, kMostStep), start, lanes_of<V>, lanes);
}

}  // namespace
}  // namespace abbe::kernel
