// Correction of a packet of poses: a first-order step from the sum of adjoints, then Newton steps on the
// exact residual with the same Jacobian. See kernel_code.h for what may stand here.
#pragma once

#include "abbe/kernel/kernel_code.h"

namespace abbe::kernel {
namespace {

/// |det| of the two direction columns below which the rotary axes turn the tool about one line, and of the
/// three linear directions below which they do not span space.
constexpr double kLeastTurn = 1e-6, kLeastVolume = 1e-2, kNoEffect = 1e-8;
/// The same where single precision would show.
constexpr float kLeastTurnSingle = 0.1f, kLeastVolumeSingle = 0.1f;
/// What a radian of a rotary step counts in Kernel::correct_poses' `last`, mm.
constexpr double kRadianLength = 300;
constexpr double kNowhere[3] = {0, 0, 0};
/// A step that is no correction any more, mm.
constexpr double kMostStep = 100;

/// Nominal tip and tool axis, their derivatives by the free axes, and the first-order deviation.
template <class V>
struct FirstOrder {
  Triple<V> p, a;   ///< nominal
  Triple<V> dp, e;  ///< deviation of the tip, small rotation of the tool; workpiece axes
  Triple<V> position[kMaxFlatAxes], direction[kMaxFlatAxes];
};

/// The walk that finds a FirstOrder, step by step.
template <class V>
struct FirstOrderWalk {
  const FlatView& plan;
  const Setting& setting;
  State<V>& state;
  FirstOrder<V>& f;
  // In registers as far as they go.
  Triple<V> p, a, dp, rotation;
  int seen[kMaxFlatAxes];  ///< free axes met so far
  int count = 0;

  [[gnu::always_inline]] FirstOrderWalk(const FlatView& of, const Setting& by, State<V>& at,
                                        FirstOrder<V>& to)
      : plan(of), setting(by), state(at), f(to) {
    p = dp = rotation = broadcast<V>(kNowhere);
    a = broadcast<V>(setting.axis);
  }

  [[gnu::always_inline]] void take(const Op<V>& op) {
    using Kind = FlatStep::Kind;
    switch (op.kind) {
      case Kind::tip:
        p = p + broadcast<V>(state.tip);
        break;
      case Kind::slide:
        slide(op, state, p);
        if (!is_free(op)) break;
        f.position[op.axis] = broadcast<V>(op.u);
        seen[count++] = op.axis;
        break;
      case Kind::turn:
        turn(op);
        break;
      case Kind::twist: {
        Triple<V> d, e;
        evaluate(plan, op, state, d, e);
        // dp += d + e x p, or -=
        const Triple<V> by = d + cross(e, p);
        dp = op.inverse ? dp - by : dp + by;
        rotation = op.inverse ? rotation - e : rotation + e;
        break;
      }
      case Kind::fixed_twist: {
        const Triple<V> e = broadcast<V>(op.a);
        dp = dp + broadcast<V>(op.u) + cross(e, p);
        rotation = rotation + e;
        break;
      }
      default:  // no other steps are of first order
        break;
    }
    if (op.moves_on) p = p + broadcast<V>(op.t);
  }

  [[gnu::always_inline]] void finish() {
    f.p = p;
    f.a = a;
    f.dp = dp;
    f.e = rotation;
  }

 private:
  [[nodiscard]] bool is_free(const Op<V>& op) const { return (setting.free >> op.axis & 1) != 0; }

  [[gnu::always_inline]] void turn(const Op<V>& op) {
    with_turn(
        op, state, [&](const auto& turned) __attribute__((always_inline)) {
          p = turned(p);
          a = turned(a);
          dp = turned(dp);
          rotation = turned(rotation);
          for (int k = 0; k < count; ++k) {
            const int axis = seen[k];
            f.position[axis] = turned(f.position[axis]);
            if ((plan.rotary >> axis & 1) != 0) f.direction[axis] = turned(f.direction[axis]);
          }
        });
    if (!is_free(op)) return;
    const Triple<V> u = broadcast<V>(op.u);
    f.position[op.axis] = cross(u, p);
    f.direction[op.axis] = cross(u, a);
    seen[count++] = op.axis;
  }
};

template <class V>
[[gnu::always_inline]] inline void walk_first_order(const FlatView& plan, const Setting& setting,
                                                    State<V>& state, FirstOrder<V>& f) {
  FirstOrderWalk<V> walk(plan, setting, state, f);
  if constexpr (sizeof(Number<V>) == sizeof(float)) {
    for (std::uint32_t i = 0; i < plan.single_count; ++i) walk.take(plan.single[i]);
  } else {
    for (std::uint32_t i = 0; i < plan.first_order_count; ++i) walk.take(plan.first_order[i]);
  }
  walk.finish();
}

/// The free axes, sorted: three linear ones and up to two rotary ones.
struct FreeAxes {
  int linear[3] = {0, 0, 0}, rotary[2] = {0, 0};
  int rotary_count = 0;
};
inline FreeAxes free_axes_of(const FlatView& plan, const Setting& setting) {
  FreeAxes axes;
  int linear = 0;
  for (int i = 0; i < plan.axis_count; ++i) {
    if ((setting.free >> i & 1) == 0) continue;
    if ((plan.rotary >> i & 1) != 0) {
      axes.rotary[axes.rotary_count++] = i;
    } else {
      axes.linear[linear++] = i;
    }
  }
  return axes;
}

/// The inverse of the Jacobian for all steps of a packet: the rotary axes restore the direction, the linear
/// ones then the position (docs/theory/correction.md, equations 3 to 6).
template <class V>
struct Solver {
  static constexpr bool kIsSingle = sizeof(Number<V>) == sizeof(float);
  static constexpr Number<V> kTurn = kIsSingle ? kLeastTurnSingle : static_cast<Number<V>>(kLeastTurn),
                             kVolume = kIsSingle ? kLeastVolumeSingle : static_cast<Number<V>>(kLeastVolume);
  const FreeAxes& axes;
  const FirstOrder<V>& f;
  Triple<V> turn_rows[2], move_rows[3];
  unsigned unusual = 0;

  Solver(const FreeAxes& free, const FirstOrder<V>& first_order) : axes(free), f(first_order) {
    constexpr Number<V> one = 1;
    if (axes.rotary_count == 2) {
      // x = -a.(r x c1) / det, y = -a.(c0 x r) / det with det = a.(c0 x c1)
      const Triple<V>&c0 = f.direction[axes.rotary[0]], &c1 = f.direction[axes.rotary[1]];
      const V det = dot(f.a, cross(c0, c1));
      const V inverse = one / det;
      unusual |= lanes_within(det, kTurn);
      turn_rows[0] = cross(c1, f.a) * inverse;
      turn_rows[1] = cross(f.a, c0) * inverse;
    } else if (axes.rotary_count == 1) {
      const Triple<V>& c = f.direction[axes.rotary[0]];
      turn_rows[0] = c * (one / square_of(c));
    }
    const Triple<V>&a = f.position[axes.linear[0]], &b = f.position[axes.linear[1]],
          &c = f.position[axes.linear[2]];
    const Triple<V> bc = cross(b, c);
    const V volume = dot(a, bc);
    const V inverse = one / volume;
    unusual |= lanes_within(volume, kVolume);
    move_rows[0] = bc * inverse;
    move_rows[1] = cross(c, a) * inverse;
    move_rows[2] = cross(a, b) * inverse;
  }

  /// |c|^2; infinite where the axis is parallel to the tool and turns it about itself: there it rests.
  V square_of(const Triple<V>& c) {
    V square = dot(c, c);
    if constexpr (kIsSingle) {
      unusual |= lanes_within(square, kTurn * kTurn);
    } else {
      const unsigned idle = lanes_within(square, kNoEffect * kNoEffect);
      for (int i = 0; idle != 0 && i < lanes_of<V>; ++i)
        if ((idle >> i & 1) != 0) set_lane(square, i, __builtin_inf());
    }
    return square;
  }

  /// q := q + dq that removes the residual; returns |dq|.
  V step(Triple<V> position, const Triple<V>& direction, V* q) const {
    constexpr auto kRadianSquare = static_cast<Number<V>>(kRadianLength * kRadianLength);
    V square{};
    for (int i = 0; i < axes.rotary_count; ++i) {
      const int axis = axes.rotary[i];
      const V dq = -dot(turn_rows[i], direction);
      q[axis] = q[axis] + dq;
      position = position + f.position[axis] * dq;
      square = square + dq * dq * kRadianSquare;
    }
    for (int i = 0; i < 3; ++i) {
      const V dq = -dot(move_rows[i], position);
      q[axes.linear[i]] = q[axes.linear[i]] + dq;
      square = square + dq * dq;
    }
    return root(square);
  }
};

/// The flags of a packet of `width` lanes, whose bits are those of its lanes.
inline void mark(unsigned outside, unsigned unusual, const Source& from, int width, unsigned char* lanes) {
  if ((unusual | outside) == 0) return;
  for (int i = 0; i < width && from.first + static_cast<std::size_t>(i) < from.count; ++i) {
    unsigned char& flag = lanes[from.first + static_cast<std::size_t>(i)];
    if ((outside >> i & 1) != 0) flag |= Lane::outside;
    if ((unusual >> i & 1) != 0) flag |= Lane::unusual;
  }
}

template <class V>
void correct_packet(const FlatView& plan, const Setting& setting, const FreeAxes& axes, const Source& from,
                    double* const* corrected, double* last, unsigned char* lanes) {
  V q[kMaxFlatAxes];
  for (int i = 0; i < plan.axis_count; ++i) q[i] = load<V>(from, i);
  State<V> state;
  state.q = q;
  use(setting, state);
  FirstOrder<V> f;
  walk_first_order(plan, setting, state, f);
  const Solver<V> solver(axes, f);
  const Triple<V> shift = broadcast<V>(setting.shift);
  const Triple<V> target = f.p + shift;
  V rotary_before[2] = {};
  for (int i = 0; i < axes.rotary_count; ++i) rotary_before[i] = q[axes.rotary[i]];
  V size = solver.step(f.dp - shift, cross(f.e, f.a), q);
  for (int i = 0; i < setting.exact_steps; ++i) {
    Triple<V> p, a;
    state.outside = 0;
    walk_actual<V, true>(plan, state, p, a);
    size = solver.step(p - target, a - f.a, q);
  }
  unsigned unusual = solver.unusual | lanes_outside(size, 0.0, kMostStep);
  for (int i = 0; i < axes.rotary_count; ++i) {
    unusual |= lanes_outside(q[axes.rotary[i]] - rotary_before[i], -setting.max_rotary, setting.max_rotary);
  }
  for (int i = 0; i < plan.axis_count; ++i) store(corrected[i], from.first, from.count, q[i]);
  store(last, from.first, from.count, size);
  mark(state.outside, unusual, from, lanes_of<V>, lanes);
}

}  // namespace
}  // namespace abbe::kernel
