#include "abbe/chain/bend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "abbe/chain/plan_impl.h"

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOpenTravel = 5000;   // mm, of an axis without travels
constexpr double kSecondOrder = 1.01;  // products of errors, which the sum above leaves out
// Slope jumps below this (mm/mm, and rad/mm times the lever) are rounding of splines and of tabulated sines.
constexpr double kNoJump = 1e-9;
// Steps of the errors themselves below this (mm) are rounding: knots closer than rounding are one.
constexpr double kNoStep = 1e-8;

/// Largest first and second derivatives and slope jumps, one number for displacements, one for rotations.
struct Bounds {
  double d2 = 0, e1 = 0, e2 = 0;
  double d_jump = 0, e_jump = 0;
  double knot_distance = kInfinity;  ///< of knots with a jump
};

class TableBounds {
 public:
  TableBounds(const Plan::Impl& plan, const AxisTable& table) : plan_(plan), table_(table) {
    const auto k = static_cast<std::size_t>(table.axis);
    lo_ = std::isfinite(plan.lo[k]) ? plan.lo[k] : -kOpenTravel;
    hi_ = std::isfinite(plan.hi[k]) ? plan.hi[k] : kOpenTravel;
  }

  [[nodiscard]] Bounds bounds(double lever) {
    for (std::uint32_t i = 0; i < table_.segments; ++i) add_segment(i);
    for (std::uint32_t i = 1; i < table_.segments; ++i) add_jump(i, lever);
    // Beyond their tables sines are added one by one.
    const bool beyond = table_.wave_count > 0 && !(table_.waves_lo <= lo_ && table_.waves_hi >= hi_);
    for (std::uint32_t w = 0; beyond && w < table_.wave_count; ++w) {
      const Wave& wave = plan_.waves[table_.first_wave + w];
      const double slope = std::abs(wave.amplitude * wave.frequency);
      (wave.component < 3 ? out_.d2 : out_.e2) += slope * std::abs(wave.frequency);
      if (wave.component >= 3) out_.e1 += slope;
      // They begin where the tables end, within the rounding of the tables.
    }
    return out_;
  }

 private:
  [[nodiscard]] double knot(std::uint32_t i) const { return plan_.knots[table_.knots + i]; }
  /// The coefficient of t^power in a segment.
  [[nodiscard]] double coefficient(std::uint32_t segment, std::uint32_t power, int component) const {
    const std::size_t row = static_cast<std::size_t>(segment) * table_.rows + (table_.rows - 1 - power);
    return plan_.coefficients[table_.data + row * kComponents + static_cast<std::size_t>(component)];
  }
  [[nodiscard]] double begin_of(std::uint32_t i) const { return i > 0 ? std::max(lo_, knot(i)) : lo_; }
  [[nodiscard]] double end_of(std::uint32_t i) const {
    return i + 1 < table_.segments ? std::min(hi_, knot(i + 1)) : hi_;
  }

  void add_segment(std::uint32_t i) {
    // A periodic table is used over and over, whatever the travels are.
    const bool clipped = table_.period == 0;
    const double begin = clipped ? begin_of(i) : knot(i), end = clipped ? end_of(i) : last_of(i);
    if (!(begin <= end)) return;
    const double reach = std::max(std::abs(begin - knot(i)), std::abs(end - knot(i)));
    double d2 = 0, e1 = 0, e2 = 0;
    for (int component = 0; component < kComponents; ++component) {
      // |p'| <= sum k |c_k| h^(k-1), |p''| <= sum k (k-1) |c_k| h^(k-2)
      double first = 0, second = 0;
      for (std::uint32_t power = 1; power < table_.rows; ++power) {
        const double c = std::abs(coefficient(i, power, component)), k = power;
        first += k * c * std::pow(reach, k - 1);
        if (power > 1) second += k * (k - 1) * c * std::pow(reach, k - 2);
      }
      (component < 3 ? d2 : e2) += second;
      if (component >= 3) e1 += first;
    }
    out_.d2 = std::max(out_.d2, d2);
    out_.e1 = std::max(out_.e1, e1);
    out_.e2 = std::max(out_.e2, e2);
  }
  [[nodiscard]] double last_of(std::uint32_t i) const {
    return i + 1 < table_.segments ? knot(i + 1) : table_.period_lo + table_.period;
  }

  /// The slope before and behind the knot at which segment i begins.
  void add_jump(std::uint32_t i, double lever) {
    const double at = knot(i);
    if (table_.period == 0 && (at < lo_ || at > hi_)) return;
    double d = 0, e = 0, step = 0;
    for (int component = 0; component < kComponents; ++component) {
      const double before = slope(i - 1, at - knot(i - 1), component);
      const double behind = slope(i, 0, component);
      (component < 3 ? d : e) += std::abs(behind - before);
      step += std::abs(value(i - 1, at - knot(i - 1), component) - value(i, 0, component)) *
              (component < 3 ? 1 : lever);
    }
    if (step > kNoStep) out_.d_jump = kInfinity;  // no length is short enough
    if (d + e * lever <= kNoJump) return;
    out_.d_jump = std::max(out_.d_jump, d);
    out_.e_jump = std::max(out_.e_jump, e);
    out_.knot_distance = std::min(out_.knot_distance, at - last_jump_);
    last_jump_ = at;
  }
  [[nodiscard]] double value(std::uint32_t segment, double t, int component) const {
    double sum = 0;
    for (std::uint32_t power = table_.rows; power-- > 0;)
      sum = sum * t + coefficient(segment, power, component);
    return sum;
  }
  [[nodiscard]] double slope(std::uint32_t segment, double t, int component) const {
    double value = 0;
    for (std::uint32_t power = table_.rows - 1; power > 0; --power)
      value = value * t + power * coefficient(segment, power, component);
    return value;
  }

  const Plan::Impl& plan_;
  const AxisTable& table_;
  double lo_ = 0, hi_ = 0, last_jump_ = -kInfinity;
  Bounds out_;
};

/// No point of the chain, and no place where an error was measured, is farther from the tip.
[[nodiscard]] double chain_length(const Plan::Impl& plan, const Tool& tool) {
  double length = tool.tip.norm();
  for (const Op& op : plan.first_order) {
    length += op.t.norm();
    if (op.kind != Op::Kind::slide) continue;
    const auto k = static_cast<std::size_t>(op.axis);
    const double reach = std::max(std::abs(plan.lo[k]), std::abs(plan.hi[k]));
    length += std::isfinite(reach) ? reach : kOpenTravel;
  }
  // Displacements that were measured elsewhere turn about that place.
  double lever = 0;
  for (const Group& group : plan.groups)
    if (group.has_lever) lever = std::max(lever, group.lever.norm());
  length += lever;
  return length;
}

}  // namespace

double straight_reach(const Plan& plan, const Tool& tool, double bend) {
  const Plan::Impl& impl = plan.impl();
  if (!impl.terms.empty() || !(bend > 0)) return 0;
  const double lever = chain_length(impl, tool);
  double curvature = 0, jump = 0, reach = kInfinity;
  for (const AxisTable& table : impl.tables) {
    if ((impl.rotary >> table.axis & 1) != 0) continue;
    const Bounds b = TableBounds(impl, table).bounds(lever);
    curvature += b.d2 + b.e2 * lever + 2 * b.e1;
    jump += b.d_jump + b.e_jump * lever;
    reach = std::min(reach, b.knot_distance);
  }
  curvature *= kSecondOrder;
  jump *= kSecondOrder;
  if (!std::isfinite(curvature) || !std::isfinite(jump)) return 0;
  // L^2/8 K + L/4 J = bend
  const double a = curvature / 8, b = jump / 4;
  const double length = a > 0   ? (-b + std::sqrt(b * b + 4 * a * bend)) / (2 * a)
                        : b > 0 ? bend / b
                                : kInfinity;
  return std::min(length, reach);
}

}  // namespace abbe
