#include "abbe/chain/table_bounds.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kOpenTravel = 5000;  // mm, of an axis without travels
// Slope jumps below this (mm/mm, and rad/mm times the lever) are rounding of splines and of tabulated sines.
constexpr double kNoJump = 1e-9;
// Steps of the errors themselves below this (mm) are rounding: knots closer than rounding are one.
constexpr double kNoStep = 1e-8;

class TableReader {
 public:
  TableReader(const Plan::Impl& plan, const AxisTable& table) : plan_(plan), table_(table) {
    const auto k = static_cast<std::size_t>(table.axis);
    const double open = (plan.rotary >> table.axis & 1) != 0 ? kOpenTurn : kOpenTravel;
    lo_ = std::isfinite(plan.lo[k]) ? plan.lo[k] : -open;
    hi_ = std::isfinite(plan.hi[k]) ? plan.hi[k] : open;
  }

  [[nodiscard]] TableBounds bounds(double lever) {
    for (std::uint32_t i = 0; i < table_.segments; ++i) add_segment(i);
    for (std::uint32_t i = 1; i < table_.segments; ++i) add_jump(i, lever);
    // Beyond their tables sines are added one by one.
    const bool beyond = table_.wave_count > 0 && !(table_.waves_lo <= lo_ && table_.waves_hi >= hi_);
    for (std::uint32_t w = 0; beyond && w < table_.wave_count; ++w) {
      const Wave& wave = plan_.waves[table_.first_wave + w];
      const double slope = std::abs(wave.amplitude * wave.frequency);
      const bool shift = wave.component < 3;
      (shift ? out_.d2 : out_.e2) += slope * std::abs(wave.frequency);
      (shift ? out_.d1 : out_.e1) += slope;
      (shift ? out_.d0 : out_.e0) += std::abs(wave.amplitude);
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
    TableBounds here;
    for (int component = 0; component < kComponents; ++component) {
      // |p| <= sum |c_k| h^k, |p'| <= sum k |c_k| h^(k-1), |p''| <= sum k (k-1) |c_k| h^(k-2)
      double values = 0, first = 0, second = 0;
      for (std::uint32_t power = 0; power < table_.rows; ++power) {
        const double c = std::abs(coefficient(i, power, component)), k = power;
        if (c == 0) continue;
        values += c * std::pow(reach, k);
        if (power > 0) first += k * c * std::pow(reach, k - 1);
        if (power > 1) second += k * (k - 1) * c * std::pow(reach, k - 2);
      }
      (component < 3 ? here.d0 : here.e0) += values;
      (component < 3 ? here.d1 : here.e1) += first;
      (component < 3 ? here.d2 : here.e2) += second;
    }
    for (double TableBounds::*bound : {&TableBounds::d0, &TableBounds::d1, &TableBounds::d2, &TableBounds::e0,
                                       &TableBounds::e1, &TableBounds::e2})
      out_.*bound = std::max(out_.*bound, here.*bound);
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
    if (step > kNoStep) out_.d_jump = std::numeric_limits<double>::infinity();  // no length is short enough
    if (d + e * lever <= kNoJump) return;
    out_.d_jump = std::max(out_.d_jump, d);
    out_.e_jump = std::max(out_.e_jump, e);
    out_.knot_distance = std::min(out_.knot_distance, at - last_jump_);
    last_jump_ = at;
    out_.jumps_at.push_back(at);
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
  double lo_ = 0, hi_ = 0, last_jump_ = -std::numeric_limits<double>::infinity();
  TableBounds out_;
};

}  // namespace

TableBounds table_bounds(const Plan::Impl& plan, const AxisTable& table, double lever) {
  return TableReader(plan, table).bounds(lever);
}

double chain_length(const Plan::Impl& plan, const Tool& tool) {
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

}  // namespace abbe
