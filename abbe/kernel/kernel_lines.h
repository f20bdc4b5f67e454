// Correction of poses in two halves, between which somebody decides how the rotary axes will stand. See
// kernel_code.h for what may stand here.
#pragma once

#include "abbe/kernel/kernel_correct_single.h"

namespace abbe::kernel {
namespace {

/// What refine_poses needs of a solver: its rows, and the ways of the linear axes that keep the tip where it
/// is when a rotary axis turns.
template <class V, class Store>
[[gnu::always_inline]] inline void keep_rows(const Solver<V>& solver, const FreeAxes& axes,
                                             const FirstOrder<V>& f, PoseWork& work, const Store& store_row) {
  const auto store_triple = [&](double(*rows)[PoseWork::kMost], const Triple<V>& v) {
    store_row(rows[0], v.x);
    store_row(rows[1], v.y);
    store_row(rows[2], v.z);
  };
  for (int j = 0; j < 2; ++j) {
    store_triple(work.turn_rows + 3 * j, solver.turn_rows[j]);
    const Triple<V>& by_turn = f.position[axes.rotary[j]];
    for (int k = 0; k < 3; ++k) store_row(work.follow[3 * j + k], -dot(solver.move_rows[k], by_turn));
  }
  for (int k = 0; k < 3; ++k) store_triple(work.move_rows + 3 * k, solver.move_rows[k]);
}

template <class V>
V row_of(const double* row, std::size_t first) {
  V v;
  __builtin_memcpy(&v, row + first, sizeof v);
  return v;
}

template <class V>
void estimate_packet(const FlatView& plan, const Setting& setting, const FreeAxes& axes,
                     const double* const* q, std::size_t first, double* const* estimate, PoseWork& work,
                     unsigned char* lanes) {
  V at[kMaxFlatAxes];
  for (int i = 0; i < plan.axis_count; ++i) at[i] = row_of<V>(q[i], first);
  State<V> state;
  state.q = at;
  use(setting, state);
  FirstOrder<V> f;
  walk_first_order(plan, setting, state, f);
  const Solver<V> solver(axes, f);
  const auto store_row = [&](double* row, const V& v) { store(row, first, PoseWork::kMost, v); };
  const V nominal[6] = {f.p.x, f.p.y, f.p.z, f.a.x, f.a.y, f.a.z};
  for (int k = 0; k < 6; ++k) store_row(work.nominal[k], nominal[k]);
  keep_rows(solver, axes, f, work, store_row);
  V turned[2];
  for (int j = 0; j < 2; ++j) turned[j] = at[axes.rotary[j]];
  const V size = solver.step(f.dp - broadcast<V>(setting.shift), cross(f.e, f.a), at);
  unsigned unusual = solver.unusual | lanes_outside(size, 0.0, kMostStep);
  for (int j = 0; j < 2; ++j)
    unusual |= lanes_outside(at[axes.rotary[j]] - turned[j], -setting.max_rotary, setting.max_rotary);
  for (int i = 0; i < plan.axis_count; ++i) store_row(estimate[i], at[i]);
  mark(state.outside, unusual, {nullptr, first, PoseWork::kMost}, lanes_of<V>, lanes);
}

#if defined(ABBE_KERNEL_HAS_SINGLES)
/// As estimate_packet; false, and nothing is said, where single precision would show and for every pose that
/// is not ordinary.
[[gnu::always_inline]] inline bool estimate_singles(const FlatView& plan, const Setting& setting,
                                                    const FreeAxes& axes, const double* const* q,
                                                    std::size_t first, double* const* estimate,
                                                    PoseWork& work, Place* places) {
  State<Single> state;
  use(setting, state);
  state.places = places;
  Commands commands[kMaxFlatAxes];
  Single change[kMaxFlatAxes];
  unsigned refused = load_poses(plan, q, first, state, commands);
  FirstOrder<Single> f;
  walk_first_order(plan, setting, state, f);
  const Solver<Single> solver(axes, f);
  for (int i = 0; i < plan.axis_count; ++i) change[i] = Single{};
  const Single size = solver.step(f.dp - broadcast<Single>(setting.shift), cross(f.e, f.a), change);
  const auto most = static_cast<float>(setting.max_rotary * (1 - 1e-6));
  refused |= solver.unusual | lanes_outside(size, 0.0f, static_cast<float>(kMostStep));
  for (int j = 0; j < 2; ++j) refused |= lanes_outside(change[axes.rotary[j]], -most, most);
  if (state.refused || refused != 0) return false;
  const auto store_row = [&](double* row, const Single& v) {
    Commands wide = {};
    add(wide, v);
    store_commands(row + first, wide);
  };
  keep_rows(solver, axes, f, work, store_row);
  Poses nominal;
  walk_poses<true>(plan, setting, commands, nominal);
  for (int k = 0; k < 6; ++k) store_commands(work.nominal[k] + first, load_commands(nominal.number[k]));
  for (int i = 0; i < plan.axis_count; ++i) {
    add(commands[i], change[i]);
    store_commands(estimate[i] + first, commands[i]);
  }
  return true;
}
#endif

/// How far each lane's step goes, larger of the two rotary ones and all linear ones together.
template <class V>
void refine_packet(const FlatView& plan, const Setting& setting, const FreeAxes& axes, const PoseWork& work,
                   const double* const* estimate, const double* const* stand, std::size_t first,
                   double* const* found, double* turn_left, double* way_left, unsigned char* lanes) {
  const auto triple = [&](const double(*rows)[PoseWork::kMost]) {
    return Triple<V>{row_of<V>(rows[0], first), row_of<V>(rows[1], first), row_of<V>(rows[2], first)};
  };
  V q[kMaxFlatAxes];
  for (int i = 0; i < plan.axis_count; ++i) q[i] = row_of<V>(estimate[i], first);
  for (int j = 0; j < 2; ++j) {
    const int axis = axes.rotary[j];
    const V stands = row_of<V>(stand[j], first), turned = stands - q[axis];
    q[axis] = stands;
    const Triple<V> follow = triple(work.follow + 3 * j);
    q[axes.linear[0]] = q[axes.linear[0]] + follow.x * turned;
    q[axes.linear[1]] = q[axes.linear[1]] + follow.y * turned;
    q[axes.linear[2]] = q[axes.linear[2]] + follow.z * turned;
  }
  State<V> state;
  state.q = q;
  use(setting, state);
  Triple<V> p, a;
  walk_actual<V, true>(plan, state, p, a);
  const Triple<V> off = p - triple(work.nominal) - broadcast<V>(setting.shift);
  const Triple<V> leans = a - triple(work.nominal + 3);
  V turn_square{}, way_square{};
  for (int j = 0; j < 2; ++j) {
    const V turn = -dot(triple(work.turn_rows + 3 * j), leans);
    turn_square = turn_square + turn * turn;
    store(found[axes.rotary[j]], first, PoseWork::kMost, q[axes.rotary[j]] + turn);
  }
  for (int k = 0; k < 3; ++k) {
    const V way = -dot(triple(work.move_rows + 3 * k), off);
    way_square = way_square + way * way;
    store(found[axes.linear[k]], first, PoseWork::kMost, q[axes.linear[k]] + way);
  }
  store(turn_left, first, PoseWork::kMost, root(turn_square));
  store(way_left, first, PoseWork::kMost, root(way_square));
  mark(state.outside, lanes_outside(way_square, 0.0, kMostStep * kMostStep),
       {nullptr, first, PoseWork::kMost}, lanes_of<V>, lanes);
}

}  // namespace
}  // namespace abbe::kernel
