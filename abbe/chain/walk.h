#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include "abbe/chain/derivative.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/chain/predict.h"

namespace abbe {

/// What a walk reads: positions in mm and rad, the file's variables (only where general terms need
/// them), and the tool.
template <class T>
struct Inputs {
  const T* q = nullptr;
  const T* variables = nullptr;
  const signed char* approach = nullptr;
  Vec3 tip = Vec3::Zero();
};

/// A point and N directions of the tool, carried from the tool frame into the workpiece frame.
template <class T, int N>
struct Carried {
  Vec3T<T> p = Vec3T<T>::Zero();
  std::array<Vec3T<T>, static_cast<std::size_t>(N)> v;
};

/// First order: beside the nominal point its deviation dp = d + e x p and the rotation e of the tool.
template <class T, int N>
struct CarriedTwist : Carried<T, N> {
  Vec3T<T> dp = Vec3T<T>::Zero();
  Vec3T<T> e = Vec3T<T>::Zero();
};

/// The segment of a table that holds x. No number: some segment.
[[nodiscard]] inline std::uint32_t segment_of(const Plan::Impl& plan, const AxisTable& table, double x) {
  if (table.segments == 1) return 0;
  const double place = (x - table.bucket_lo) * table.buckets_per_unit;
  const std::uint32_t most = table.bucket_count - 1;
  const std::uint32_t bucket = place > 0 ? (place < most ? static_cast<std::uint32_t>(place) : most) : 0;
  std::uint32_t i = plan.buckets[table.first_bucket + bucket];
  const double* const knots = plan.knots.data() + table.knots;
  while (i + 1 < table.segments && knots[i + 1] <= x) ++i;
  return i;
}

/// Six components of an error factor side by side.
template <class T>
using Six = Eigen::Array<T, kComponents, 1>;

/// The sines of a table where they are not tabulated.
template <class T>
inline void add_waves(const Plan::Impl& plan, const AxisTable& table, const T& x, Six<T>& value) {
  using std::sin;
  for (std::uint32_t i = 0; i < table.wave_count; ++i) {
    const Wave& wave = plan.waves[table.first_wave + i];
    const double at = value_of(x);
    const T held = at < wave.lo ? T(wave.lo) : at > wave.hi ? T(wave.hi) : x;
    value[wave.component] += T(wave.amplitude) * sin(T(wave.frequency) * held + T(wave.phase));
  }
}

/// Horner's rule for six polynomials side by side: rows of coefficients, highest power first.
template <class T>
[[nodiscard]] inline Six<T> six_polynomials(const double* row, std::uint32_t rows, const T& x) {
  using Row = Eigen::Map<const Six<double>>;
  Six<T> value = Row(row).template cast<T>();
  for (std::uint32_t power = 1; power < rows; ++power) {
    row += kComponents;
    value = (value * x + Row(row).template cast<T>()).eval();
  }
  return value;
}
template <>
[[nodiscard]] inline Six<double> six_polynomials(const double* row, std::uint32_t rows, const double& x) {
  using Pair = double __attribute__((vector_size(16)));  // three registers, which the compiler does not find
  Pair a, b, c;
  const auto load = [&](Pair& to, int at) { std::memcpy(&to, row + at, sizeof to); };
  load(a, 0), load(b, 2), load(c, 4);
  for (std::uint32_t power = 1; power < rows; ++power) {
    row += kComponents;
    Pair ka, kb, kc;
    load(ka, 0), load(kb, 2), load(kc, 4);
    a = a * x + ka;
    b = b * x + kb;
    c = c * x + kc;
  }
  Six<double> value;
  value << a[0], a[1], b[0], b[1], c[0], c[1];
  return value;
}

/// The tabulated functions of one axis position.
template <class T>
[[nodiscard, gnu::always_inline]] inline Six<T> evaluate(const Plan::Impl& plan, const AxisTable& table,
                                                         const Inputs<T>& in, bool* outside) {
  const T q = in.q[table.axis];
  T x = q;
  if (table.bounded && !(value_of(x) >= table.lo && value_of(x) <= table.hi)) *outside = true;
  if (table.period > 0) {
    const double turns = std::floor((value_of(x) - table.period_lo) / table.period);
    if (turns != 0 && std::isfinite(turns)) x = x - T(turns * table.period);
  }
  const std::uint32_t i = segment_of(plan, table, value_of(x));
  x = x - T(plan.knots[table.knots + i]);
  const double* const row =
      plan.coefficients.data() + table.data + static_cast<std::size_t>(i) * table.rows * kComponents;
  Six<T> value = six_polynomials<T>(row, table.rows, x);
  if (table.wave_count > 0 && !(value_of(q) >= table.waves_lo && value_of(q) <= table.waves_hi))
    add_waves(plan, table, q, value);
  return value;
}

/// The six components of an error factor for these inputs (docs/theory/chain.md, equation 4).
template <class T>
inline void evaluate(const Plan::Impl& plan, const Group& group, const Inputs<T>& in, Vec3T<T>& d,
                     Vec3T<T>& e, bool* outside) {
  Six<T> sum;
  if (group.table_count > 0) {
    sum = evaluate<T>(plan, plan.tables[group.first_table], in, outside);
    for (std::uint32_t b = 1; b < group.table_count; ++b) {
      const AxisTable& table = plan.tables[group.first_table + b];
      const double weight =
          weight_of(table.direction, in.approach == nullptr ? 0 : in.approach[table.direction_axis]);
      if (weight != 0) sum += evaluate<T>(plan, table, in, outside) * T(weight);
    }
  } else {
    sum = Eigen::Map<const Six<double>>(group.constant.data()).template cast<T>();
  }
  for (std::uint32_t i = 0; i < group.term_count; ++i) {
    const GeneralTerm& term = plan.terms[group.first_term + i];
    sum[term.component] +=
        T(term.scale) * term.function->template value<T>(in.variables, in.approach, outside);
  }

  d = Vec3T<T>(sum[0], sum[1], sum[2]);
  e = Vec3T<T>(sum[3], sum[4], sum[5]);
  // d = d_file - e x (measured_at - origin)
  if (group.has_lever) d -= e.cross(group.lever.template cast<T>());
}

/// The along or across share of a location error about the axis direction u.
template <class T>
inline void take_part(Part part, bool is_rotary, const Vec3& axis, Vec3T<T>& d, Vec3T<T>& e) {
  if (part == Part::all) return;
  const Vec3T<T> u = axis.template cast<T>();
  const Vec3T<T> e_along = u * u.dot(e), d_along = u * u.dot(d);
  if (part == Part::along) {
    e = e_along;
    if (is_rotary) d = d_along;
  } else {
    e -= e_along;
    d = is_rotary ? Vec3T<T>(d - d_along) : Vec3T<T>(Vec3T<T>::Zero());
  }
}

/// Coefficients of Exp(e) x = x + s (e x x) + k (e x (e x x)), t2 = |e|^2:
/// s = sin t / t, k = (1 - cos t) / t^2. Below 0.01 rad the series are exact to 1e-16.
template <class T>
inline void rotation_coefficients(const T& t2, T& s, T& k) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  if (value_of(t2) < 1e-4) {
    s = T(1) - t2 * (T(1.0 / 6) - t2 * T(1.0 / 120));
    k = T(0.5) - t2 * (T(1.0 / 24) - t2 * T(1.0 / 720));
    return;
  }
  const T t = sqrt(t2);
  const T half = sin(t * T(0.5));
  s = sin(t) / t;
  k = T(2) * half * half / t2;
}

template <class T>
inline Vec3T<T> rotated(const Vec3T<T>& e, const T& s, const T& k, const Vec3T<T>& x) {
  const Vec3T<T> c = e.cross(x);
  return x + c * s + e.cross(c) * k;
}

/// Rot(u, q) as a matrix, u a unit vector.
template <class T>
inline Mat3T<T> turn_matrix(const Vec3& u, const T& q) {
  using std::cos;
  using std::sin;
  const T s = sin(q), c = cos(q), v = T(1) - c;
  const T x = T(u.x()), y = T(u.y()), z = T(u.z());
  Mat3T<T> r;
  r << x * x * v + c, x * y * v - z * s, x * z * v + y * s,  //
      y * x * v + z * s, y * y * v + c, y * z * v - x * s,   //
      z * x * v - y * s, z * y * v + x * s, z * z * v + c;
  return r;
}

/// One step on a point and N directions.
template <class T, int N>
inline void apply(const Plan::Impl& plan, const Op& op, const Inputs<T>& in, Carried<T, N>& c,
                  bool* outside) {
  switch (op.kind) {
    case Op::Kind::tip:
      c.p += in.tip.template cast<T>();
      break;
    case Op::Kind::slide:
      c.p += op.u.template cast<T>() * in.q[op.axis];
      break;
    case Op::Kind::turn: {
      const T& q = in.q[op.axis];
      if (q == T(0) && std::is_same_v<T, double>) break;
      const Mat3T<T> r = turn_matrix<T>(op.u, q);
      c.p = (r * c.p).eval();
      for (auto& v : c.v) v = (r * v).eval();
      break;
    }
    case Op::Kind::affine: {
      const Mat3T<T> a = plan.matrices[static_cast<std::size_t>(op.index)].template cast<T>();
      c.p = (a * c.p).eval();
      for (auto& v : c.v) v = (a * v).eval();
      break;
    }
    case Op::Kind::shift:
    case Op::Kind::rigid:
    case Op::Kind::linear: {
      const Group& group = plan.groups[static_cast<std::size_t>(op.index)];
      Vec3T<T> d, e;
      evaluate(plan, group, in, d, e, outside);
      take_part(op.part, group.is_rotary, op.u, d, e);
      if (op.kind == Op::Kind::shift) {
        if (op.inverse) {
          c.p -= d;
        } else {
          c.p += d;
        }
      } else if (op.kind == Op::Kind::rigid) {
        T s, k;
        rotation_coefficients<T>(e.squaredNorm(), s, k);
        if (op.inverse) {
          // Err^-1 p = Exp(-e) (p - d)
          e = -e;
          c.p = rotated<T>(e, s, k, c.p - d);
        } else {
          c.p = rotated<T>(e, s, k, c.p) + d;
        }
        for (auto& v : c.v) v = rotated<T>(e, s, k, v);
      } else if (op.inverse) {
        // (I + [e]x)^-1 x = (x + e (e.x) - e x x) / (1 + |e|^2)
        const T scale = T(1) / (T(1) + e.squaredNorm());
        const auto undo = [&](const Vec3T<T>& x) -> Vec3T<T> {
          return (x + e * e.dot(x) - e.cross(x)) * scale;
        };
        c.p = undo(c.p - d);
        for (auto& v : c.v) v = undo(v);
      } else {
        c.p += (e.cross(c.p) + d).eval();
        for (auto& v : c.v) v += e.cross(v).eval();
      }
      break;
    }
    case Op::Kind::twist:
      break;
  }
  c.p += op.t.template cast<T>();
}

/// T_wt applied to the tool's point and directions: one pass, no 4x4 products.
template <class T, int N>
inline void walk(const Plan::Impl& plan, std::span<const Op> ops, const Inputs<T>& in, Carried<T, N>& c,
                 bool* outside) {
  for (const Op& op : ops) apply<T, N>(plan, op, in, c, outside);
}

/// The sum of adjoints (docs/theory/chain.md, equation 8), accumulated as the derivative of the
/// nominal walk: at a factor dp += d + e x p, at a rotation dp and e turn along.
template <class T, int N>
inline void walk_first_order(const Plan::Impl& plan, const Inputs<T>& in, CarriedTwist<T, N>& c,
                             bool* outside) {
  for (const Op& op : plan.first_order) {
    if (op.kind == Op::Kind::twist) {
      const Group& group = plan.groups[static_cast<std::size_t>(op.index)];
      Vec3T<T> d, e;
      evaluate(plan, group, in, d, e, outside);
      take_part(op.part, group.is_rotary, op.u, d, e);
      if (op.inverse) {
        c.dp -= d + e.cross(c.p);
        c.e -= e;
      } else {
        c.dp += d + e.cross(c.p);
        c.e += e;
      }
    } else if (op.kind == Op::Kind::turn && (!std::is_same_v<T, double> || in.q[op.axis] != T(0))) {
      const Mat3T<T> r = turn_matrix<T>(op.u, in.q[op.axis]);
      c.p = (r * c.p).eval();
      c.dp = (r * c.dp).eval();
      c.e = (r * c.e).eval();
      for (auto& v : c.v) v = (r * v).eval();
    } else {
      apply<T, N>(plan, op, in, c, outside);
      continue;
    }
    c.p += op.t.template cast<T>();
  }
}

/// The nominal tip and tool axis with their derivatives by every moving axis.
struct CarriedColumns : Carried<double, 1> {
  Eigen::Matrix<double, 3, kMaxAxes> position, tool_axis;  ///< columns by axis; unused ones are not set
};

/// Adjoint columns (docs/theory/chain.md, equation 9), carried along with the point: a slide's column
/// is u, a turn's u x p; later rotations turn the columns that exist.
inline void walk_columns(const Plan::Impl& plan, const Inputs<double>& in, CarriedColumns& c) {
  std::array<int, kMaxAxes> seen;
  int count = 0;
  c.position.leftCols(plan.axis_count).setZero();
  c.tool_axis.leftCols(plan.axis_count).setZero();
  for (const Op& op : plan.nominal) {
    if (op.kind == Op::Kind::turn) {
      if (in.q[op.axis] != 0) {
        const Mat3 r = turn_matrix<double>(op.u, in.q[op.axis]);
        c.p = (r * c.p).eval();
        c.v[0] = (r * c.v[0]).eval();
        for (int i = 0; i < count; ++i) {
          const int k = seen[static_cast<std::size_t>(i)];
          c.position.col(k) = (r * c.position.col(k)).eval();
          c.tool_axis.col(k) = (r * c.tool_axis.col(k)).eval();
        }
      }
      c.position.col(op.axis) = op.u.cross(c.p);
      c.tool_axis.col(op.axis) = op.u.cross(c.v[0]);
      seen[static_cast<std::size_t>(count++)] = op.axis;
      c.p += op.t;
      continue;
    }
    apply<double, 1>(plan, op, in, c, nullptr);
    if (op.kind == Op::Kind::slide) {
      c.position.col(op.axis) = op.u;
      seen[static_cast<std::size_t>(count++)] = op.axis;
    }
  }
}

/// Positions as the file's functions see them: q / unit, with the last bits tidied so that 30 deg
/// through radians is 30 again and not beyond a table that ends at 30.
[[nodiscard]] inline double file_position(double q, double unit) {
  if (unit == 1.0) return q;
  const double v = q / unit;
  constexpr double kGrid = 1e9, kShift = 6755399441055744.0;  // 1.5 * 2^52: rounds to an integer
  const double scaled = v * kGrid;
  if (!(std::abs(scaled) < 2e15)) return v;
  const double tidy = ((scaled + kShift) - kShift) / kGrid;
  return std::abs(tidy - v) <= 4 * std::numeric_limits<double>::epsilon() * std::abs(v) ? tidy : v;
}

/// Inputs of a query in double: owns the variables when general terms need them. No allocation up to
/// kSmall variables.
class QueryInputs {
 public:
  QueryInputs(const Plan::Impl& plan, const Query& query);
  QueryInputs(const QueryInputs&) = delete;
  QueryInputs& operator=(const QueryInputs&) = delete;
  /// New positions, all else as before.
  void move_to(const std::array<double, kMaxAxes>& q);
  [[nodiscard]] const Inputs<double>& inputs() const { return inputs_; }

 private:
  static constexpr std::size_t kSmall = 96;
  const Plan::Impl& plan_;
  Inputs<double> inputs_;
  double* variables_ = nullptr;
  std::array<double, kSmall> small_variables_;
  std::array<signed char, kSmall> small_approach_;
  std::vector<double> large_variables_;
  std::vector<signed char> large_approach_;
};

inline QueryInputs::QueryInputs(const Plan::Impl& plan, const Query& query) : plan_(plan) {
  inputs_.q = query.q.data();
  inputs_.tip = query.tool.tip;
  inputs_.approach = query.approach.data();
  if (!plan.needs_variables) return;
  const std::size_t count = plan.variables.size();
  signed char* approach = small_approach_.data();
  variables_ = small_variables_.data();
  if (count > kSmall) {
    large_variables_.resize(count);
    large_approach_.resize(count);
    variables_ = large_variables_.data();
    approach = large_approach_.data();
  }
  for (std::size_t i = 0; i < count; ++i) variables_[i] = plan.variables[i];
  if (plan.directional) {
    for (std::size_t i = 0; i < count; ++i) {
      approach[i] =
          i < static_cast<std::size_t>(plan.axis_count) ? query.approach[i] : static_cast<signed char>(0);
    }
    inputs_.approach = approach;
  }
  if (!query.velocity.empty() || !query.acceleration.empty()) {
    const auto& variables = plan.machine->variables;
    for (std::size_t i = static_cast<std::size_t>(plan.axis_count); i < count; ++i) {
      const auto& given = variables[i].kind == Variable::Kind::velocity ? query.velocity : query.acceleration;
      const auto axis = static_cast<std::size_t>(variables[i].axis);
      if (variables[i].kind != Variable::Kind::sensor && variables[i].kind != Variable::Kind::position &&
          variables[i].axis >= 0 && axis < given.size()) {
        variables_[i] = given[axis];
      }
    }
  }
  inputs_.variables = variables_;
  move_to(query.q);
}

inline void QueryInputs::move_to(const std::array<double, kMaxAxes>& q) {
  inputs_.q = q.data();
  if (variables_ == nullptr) return;
  for (std::size_t i = 0; i < static_cast<std::size_t>(plan_.axis_count); ++i) {
    variables_[i] = file_position(q[i], plan_.unit[i]);
  }
}

}  // namespace abbe
