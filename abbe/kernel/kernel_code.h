// The kernels, compiled once per instruction set (kernel_baseline.cpp, kernel_avx2.cpp, kernel_avx512.cpp).
// Everything is in an unnamed namespace and nothing of the standard library or Eigen is called: an inline
// function that two of those files shared could end up with instructions that this processor does not have.
//
// V is a packet of poses: one double, or a vector register of them. The same templates compute all widths.
#pragma once

#include "abbe/kernel/kernel_math.h"

namespace abbe::kernel {
namespace {

/// Where the poses of a packet come from.
struct Source {
  const double* const* q;
  std::size_t first, count;  ///< lanes beyond `count` repeat the last pose
};

template <class V>
V load(const Source& from, int axis) {
  const double* const q = from.q[axis];
  V v{};
  if (from.first + lanes_of<V> <= from.count) {
    __builtin_memcpy(&v, q + from.first, sizeof v);
  } else {
    for (int i = 0; i < lanes_of<V>; ++i) {
      const std::size_t at = from.first + static_cast<std::size_t>(i);
      set_lane(v, i, q[at < from.count ? at : from.count - 1]);
    }
  }
  return v;
}

template <class V>
void store(double* to, std::size_t first, std::size_t count, V v) {
  if (first + lanes_of<V> <= count) {
    __builtin_memcpy(to + first, &v, sizeof v);
  } else {
    for (int i = 0; first + static_cast<std::size_t>(i) < count && i < lanes_of<V>; ++i)
      to[first + static_cast<std::size_t>(i)] = lane(v, i);
  }
}

/// Commands of a packet and the flags of its lanes (bit i = lane i).
template <class V>
struct State {
  const V* q = nullptr;                          ///< per axis
  const double *tip = nullptr, *axis = nullptr;  ///< of the tool
  const signed char* approach = nullptr;
  unsigned outside = 0;
};

template <class S>
inline void use(const Setting& setting, S& state) {
  state.tip = setting.tip;
  state.axis = setting.axis;
  state.approach = setting.approach;
}

template <class V>
using Op = FlatOpOf<Number<V>>;

template <class V>
inline void sine_and_cosine(const State<V>& state, int axis, V& s, V& c) {
  sine_and_cosine(state.q[axis], s, c);
}

inline std::uint32_t segment_of(const FlatTable& table, double x) {
  const double place = (x - table.bucket_lo) * table.buckets_per_unit;
  // No number is below the first bucket.
  const double bucket = place > 0 ? (place < table.most_bucket ? place : table.most_bucket) : 0.0;
  std::uint32_t i = table.buckets[static_cast<std::int64_t>(bucket)];
  // Mostly here or next door; where knots crowd in one bucket, by bisection: the work stays bounded.
  for (int steps = 0; steps < 3; ++steps) {
    if (i + 1 >= table.segments || !(table.knots[i + 1] <= x)) return i;
    ++i;
  }
  for (std::uint32_t left = table.segments - i; left > 1;) {
    const std::uint32_t half = left / 2;
    i = table.knots[i + half] <= x ? i + half : i;
    left -= half;
  }
  return i;
}

inline double sine_of_wave(const Wave& wave, double x) {
  const double held = x < wave.lo ? wave.lo : x > wave.hi ? wave.hi : x;
  return wave.amplitude * __builtin_sin(wave.frequency * held + wave.phase);
}

/// One pose: the six polynomials side by side in registers.
inline void horner(const double* row, std::uint32_t rows, double x, double* six) {
  Native r[kNatives];
  for (std::size_t k = 0; k < kNatives; ++k) __builtin_memcpy(&r[k], row + k * kNativeLanes, sizeof(Native));
  for (std::uint32_t power = 1; power < rows; ++power) {
    row += kRow;
    for (std::size_t k = 0; k < kNatives; ++k) {
      Native c;
      __builtin_memcpy(&c, row + k * kNativeLanes, sizeof c);
      r[k] = r[k] * x + c;
    }
  }
  for (std::size_t k = 0; k < kNatives; ++k) __builtin_memcpy(six + k * kNativeLanes, &r[k], sizeof(Native));
}

inline const double* rows_of(const FlatTable& table, std::uint32_t segment) {
  return table.rows + static_cast<std::size_t>(segment) * table.row_count * kRow;
}

/// six = the functions of a table.
template <class V>
[[gnu::always_inline]] inline void read_table(const FlatTable& table, State<V>& state, V* six) {
  const V q = state.q[table.axis];
  state.outside |= lanes_outside(q, table.lo, table.hi);
  const V x = table.period > 0 ? wrapped(q, table.period_lo, table.period) : q;
  if constexpr (lanes_of<V> <= 2) {
    // So few poses are done one after the other.
    alignas(64) double values[lanes_of<V>][kRow];
    for (int p = 0; p < lanes_of<V>; ++p) {
      const double at = lane(x, p);
      const std::uint32_t i = segment_of(table, at);
      horner(rows_of(table, i), table.row_count, at - table.knots[i], values[p]);
    }
    for (int k = 0; k < kComponents; ++k)
      for (int p = 0; p < lanes_of<V>; ++p) set_lane(six[k], p, values[p][k]);
  } else {
    const std::uint32_t s0 = segment_of(table, lane(x, 0)), s1 = segment_of(table, lane(x, lanes_of<V> - 1));
    const std::uint32_t i = s0 < s1 ? s0 : s1, j = s0 < s1 ? s1 : s0;
    const double lo = i > 0 ? table.knots[i] : -__builtin_inf();
    const double hi = j + 1 < table.segments ? table.knots[j + 1] : __builtin_inf();
    const bool near = j <= i + 1 && lanes_outside(x, lo, hi) == 0;
    if (near && i == j) {
      // All poses in one segment: its coefficients for everyone.
      const double* row = rows_of(table, i);
      const V t = x - table.knots[i];
      for (int k = 0; k < kComponents; ++k) six[k] = all<V>(row[k]);
      for (std::uint32_t power = 1; power < table.row_count; ++power) {
        row += kRow;
        for (int k = 0; k < kComponents; ++k) six[k] = six[k] * t + row[k];
      }
    } else if (near) {
      // In two neighbours: each lane takes the coefficients of its own.
      const double *row = rows_of(table, i), *next = rows_of(table, j);
      const auto later = x >= table.knots[j];
      const V t = x - (later ? all<V>(table.knots[j]) : all<V>(table.knots[i]));
      for (int k = 0; k < kComponents; ++k) six[k] = later ? all<V>(next[k]) : all<V>(row[k]);
      for (std::uint32_t power = 1; power < table.row_count; ++power) {
        row += kRow;
        next += kRow;
        for (int k = 0; k < kComponents; ++k)
          six[k] = six[k] * t + (later ? all<V>(next[k]) : all<V>(row[k]));
      }
    } else {
      alignas(64) double values[lanes_of<V>][kRow];
      for (int p = 0; p < lanes_of<V>; ++p) {
        const double at = lane(x, p);
        const std::uint32_t s = segment_of(table, at);
        horner(rows_of(table, s), table.row_count, at - table.knots[s], values[p]);
      }
      for (int k = 0; k < kComponents; ++k)
        for (int p = 0; p < lanes_of<V>; ++p) set_lane(six[k], p, values[p][k]);
    }
  }
  if (lanes_outside(q, table.waves_lo, table.waves_hi) == 0) return;
  for (int p = 0; p < lanes_of<V>; ++p) {
    const double at = lane(q, p);
    if (at >= table.waves_lo && at <= table.waves_hi) continue;
    for (std::uint32_t w = 0; w < table.wave_count; ++w) {
      const Wave& wave = table.waves[w];
      set_lane(six[wave.component], p, lane(six[wave.component], p) + sine_of_wave(wave, at));
    }
  }
}

/// Displacement d and rotation e of an error factor.
template <class V>
[[gnu::always_inline]] inline void evaluate(const FlatView& plan, const Op<V>& op, State<V>& state,
                                            Triple<V>& d, Triple<V>& e) {
  V six[kComponents];
  if (op.table != nullptr) {
    read_table(*op.table, state, six);
    d = {six[0], six[1], six[2]};
    e = {six[3], six[4], six[5]};
    return;
  }
  const FlatGroup& group = plan.groups[op.group];
  if (group.table_count == 0) {
    for (int k = 0; k < kComponents; ++k) six[k] = all<V>(static_cast<Number<V>>(group.constant[k]));
  } else {
    read_table(group.tables[0], state, six);
    for (std::uint32_t b = 1; b < group.table_count; ++b) {
      const FlatTable& table = group.tables[b];
      const auto weight =
          static_cast<Number<V>>(weight_of(table.direction, state.approach[table.direction_axis]));
      if (weight == 0) continue;
      V more[kComponents];
      read_table(table, state, more);
      for (int k = 0; k < kComponents; ++k) six[k] = six[k] + more[k] * weight;
    }
  }
  d = {six[0], six[1], six[2]};
  e = {six[3], six[4], six[5]};
  // d = d_file - e x (measured_at - origin)
  if (group.has_lever) d = d - cross(e, broadcast<V>(group.lever));
  if (op.part == 0) return;
  const Triple<V> u = broadcast<V>(op.u);
  const Triple<V> e_along = u * dot(u, e), d_along = u * dot(u, d);
  if (op.part == 1) {
    e = e_along;
    if (group.is_rotary) d = d_along;
  } else {
    e = e - e_along;
    d = group.is_rotary ? d - d_along : Triple<V>{};
  }
}

/// Rot(u, q) of a turn of a kind, ready to act on several vectors.
template <class V, FlatStep::About kAbout>
struct Turn {
  V s, c;

  Turn(const Op<V>& op, V sine, V cosine) : s(sine * (op.u[0] + op.u[1] + op.u[2])), c(cosine) {}
  [[nodiscard]] Triple<V> operator()(const Triple<V>& p) const {
    using About = FlatStep::About;
    if constexpr (kAbout == About::x) return {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
    if constexpr (kAbout == About::y) return {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
    if constexpr (kAbout == About::z) return {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
  }
};
template <class V>
struct Turn<V, FlatStep::About::other> {
  V m[9];

  Turn(const Op<V>& op, V s, V c) {
    const V v = Number<V>(1) - c;
    const Number<V> x = op.u[0], y = op.u[1], z = op.u[2];
    m[0] = v * (x * x) + c, m[1] = v * (x * y) - s * z, m[2] = v * (x * z) + s * y;
    m[3] = v * (x * y) + s * z, m[4] = v * (y * y) + c, m[5] = v * (y * z) - s * x;
    m[6] = v * (x * z) - s * y, m[7] = v * (y * z) + s * x, m[8] = v * (z * z) + c;
  }
  [[nodiscard]] Triple<V> operator()(const Triple<V>& p) const {
    return {m[0] * p.x + m[1] * p.y + m[2] * p.z, m[3] * p.x + m[4] * p.y + m[5] * p.z,
            m[6] * p.x + m[7] * p.y + m[8] * p.z};
  }
};

/// act(turn): asks for the kind of a turn once, not for every vector.
template <class V, class Act>
[[gnu::always_inline]] inline void with_turn(const Op<V>& op, const State<V>& state, const Act& act) {
  using About = FlatStep::About;
  V s, c;
  sine_and_cosine(state, op.axis, s, c);
  switch (op.about) {
    case About::x:
      return act(Turn<V, About::x>(op, s, c));
    case About::y:
      return act(Turn<V, About::y>(op, s, c));
    case About::z:
      return act(Turn<V, About::z>(op, s, c));
    case About::other:
      return act(Turn<V, About::other>(op, s, c));
  }
}

/// p + q u
template <class V>
[[gnu::always_inline]] inline void slide(const Op<V>& op, const State<V>& state, Triple<V>& p) {
  using About = FlatStep::About;
  const V q = state.q[op.axis];
  switch (op.about) {
    case About::x:
      p.x = p.x + q * op.u[0];
      break;
    case About::y:
      p.y = p.y + q * op.u[1];
      break;
    case About::z:
      p.z = p.z + q * op.u[2];
      break;
    case About::other:
      p = p + broadcast<V>(op.u) * q;
      break;
  }
}

/// Exp(e) p with the coefficients s = sin t / t, k = (1 - cos t) / t^2.
template <class V>
Triple<V> rotated(const Triple<V>& e, V s, V k, const Triple<V>& p) {
  const Triple<V> c = cross(e, p);
  return p + c * s + cross(e, c) * k;
}

/// The point, and if `Axis` the tool axis, through one step of the exact walk.
template <class V, bool Axis>
[[gnu::always_inline]] inline void step(const FlatView& plan, const Op<V>& op, State<V>& state, Triple<V>& p,
                                        Triple<V>& a) {
  using Kind = FlatStep::Kind;
  switch (op.kind) {
    case Kind::tip:
      p = p + broadcast<V>(state.tip);
      break;
    case Kind::slide:
      slide(op, state, p);
      break;
    case Kind::turn:
      with_turn(
          op, state, [&](const auto& turn) __attribute__((always_inline)) {
            p = turn(p);
            if (Axis) a = turn(a);
          });
      break;
    case Kind::affine: {
      const auto act = [&](const Triple<V>& v) {
        const double* m = op.a;
        return Triple<V>{v.x * m[0] + v.y * m[1] + v.z * m[2], v.x * m[3] + v.y * m[4] + v.z * m[5],
                         v.x * m[6] + v.y * m[7] + v.z * m[8]};
      };
      p = act(p);
      if (Axis) a = act(a);
      break;
    }
    case Kind::shift:
    case Kind::rigid:
    case Kind::linear: {
      Triple<V> d, e;
      evaluate(plan, op, state, d, e);
      if (op.kind == Kind::shift) {
        p = op.inverse ? p - d : p + d;
      } else if (op.kind == Kind::rigid) {
        V s, k;
        rotation_coefficients(dot(e, e), s, k);
        if (op.inverse) {
          // Err^-1 p = Exp(-e) (p - d)
          e = -e;
          p = rotated(e, s, k, p - d);
        } else {
          p = rotated(e, s, k, p) + d;
        }
        if (Axis) a = rotated(e, s, k, a);
      } else if (op.inverse) {
        // (I + [e]x)^-1 x = (x + e (e.x) - e x x) / (1 + |e|^2)
        const V scale = 1.0 / (1.0 + dot(e, e));
        const auto undo = [&](const Triple<V>& x) { return (x + e * dot(e, x) - cross(e, x)) * scale; };
        p = undo(p - d);
        if (Axis) a = undo(a);
      } else {
        p = p + cross(e, p) + d;
        if (Axis) a = a + cross(e, a);
      }
      break;
    }
    case Kind::twist:
    case Kind::fixed_twist:
      break;
  }
  if (op.moves_on) p = p + broadcast<V>(op.t);
}

/// Steps of a walk, one after the other: without errors if they are those of first order, whose twists only
/// the first-order walk heeds.
template <class V, bool Axis>
void walk(const FlatView& plan, const FlatOp* steps, std::uint32_t count, State<V>& state, Triple<V>& p,
          Triple<V>& a) {
  p = Triple<V>{};
  if (Axis) a = broadcast<V>(state.axis);
  for (std::uint32_t i = 0; i < count; ++i) step<V, Axis>(plan, steps[i], state, p, a);
}
template <class V, bool Axis>
void walk_actual(const FlatView& plan, State<V>& state, Triple<V>& p, Triple<V>& a) {
  walk<V, Axis>(plan, plan.actual, plan.actual_count, state, p, a);
}
template <class V>
void walk_nominal(const FlatView& plan, State<V>& state, Triple<V>& p, Triple<V>& a) {
  walk<V, true>(plan, plan.first_order, plan.first_order_count, state, p, a);
}

}  // namespace
}  // namespace abbe::kernel
