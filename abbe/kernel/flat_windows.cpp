#include "abbe/kernel/flat_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe::kernel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kUnit = 0x1p-24;
constexpr float kNever = std::numeric_limits<float>::infinity();
/// How far beyond its last knot a table is used at most, mm or rad; halved until the bound holds.
constexpr double kMostReach = 0x1p14, kLeastReach = 0x1p-10;
/// Widths that differ by less than this part are equal.
constexpr double kSameWidth = 0x1p-22;
/// By which part of its position a knot may be missed: by comparisons (it is rounded, and so is the position)
/// and by the product (widths, the margin of segments_per_unit, rounding).
constexpr double kMissedByComparison = 2 * kUnit, kMissedByProduct = 4 * kSameWidth;
/// A step below this part of the bounds is rounding of splines and of tabulated sines.
constexpr double kNoStep = 0.5;

[[nodiscard]] double most(int component) { return component < 3 ? kSingleMm : kSingleRad; }

/// One window of a table: `count` segments from `first` on.
class Window {
 public:
  Window(const FlatTable& table, std::uint32_t first)
      : table_(table),
        first_(first),
        count_(std::min(kWindow, table.segments - first)),
        base_(table.knots[first]) {
    const bool repeats = table.period > 0;
    lo_ = repeats ? table.period_lo : std::max(table.lo, table.waves_lo);
    hi_ = repeats ? table.period_lo + table.period : std::min(table.hi, table.waves_hi);
    for (reach_ = kMostReach; reach_ >= kLeastReach && !precise(); reach_ /= 2) {
    }
    usable_ = reach_ >= kLeastReach && joins(kMissedByComparison);
  }

  void append_to(std::vector<WindowRow>& rows) const {
    WindowRow begins, origins, limits;
    for (std::uint32_t k = 0; k < kWindow; ++k) {
      begins.value[k] = usable_ && k < count_ ? begin_number(k) : kNever;
      origins.value[k] = k < count_ ? static_cast<float>(origin(k) - base_) : 0.0f;
    }
    limits.value[kEndNumber % kWindow] = usable_ ? end_number() : -kNever;
    limits.value[kPerUnitNumber % kWindow] = segments_per_unit();
    rows.insert(rows.end(), {begins, origins, limits});
    for (std::uint32_t row = 0; row < table_.row_count; ++row) {
      for (int component = 0; component < kComponents; ++component) {
        WindowRow& numbers = rows.emplace_back();
        for (std::uint32_t k = 0; usable_ && k < count_; ++k)
          numbers.value[k] = static_cast<float>(coefficient(k, table_.row_count - 1 - row, component));
      }
    }
  }

 private:
  [[nodiscard]] double origin(std::uint32_t k) const { return table_.knots[first_ + k]; }
  [[nodiscard]] double begin(std::uint32_t k) const {
    const bool open = first_ + k == 0;
    return std::max(lo_, open ? origin(k) - reach_ : origin(k));
  }
  [[nodiscard]] double end(std::uint32_t k) const {
    const bool open = first_ + k + 1 == table_.segments;
    return std::min(hi_, open ? origin(k) + reach_ : table_.knots[first_ + k + 1]);
  }
  /// Rounded so that no position before lo_ passes for one behind it.
  [[nodiscard]] float begin_number(std::uint32_t k) const {
    const double exact = begin(k) - base_;
    const auto number = static_cast<float>(exact);
    return begin(k) == lo_ && exact != 0 ? std::nextafter(number, kNever) : number;
  }
  /// The largest number that no position from the end on rounds to.
  [[nodiscard]] float end_number() const {
    return std::nextafter(static_cast<float>(end(count_ - 1) - base_), -kNever);
  }
  /// Rounded down by so much that no x <= end is in a segment behind the last one.
  [[nodiscard]] float segments_per_unit() const {
    const double width = end(0) - begin(0);
    if (!(width > 0) || !joins(kMissedByProduct)) return 0;
    for (std::uint32_t k = 0; k < count_; ++k) {
      const double limit = kSameWidth * width;
      const bool same = std::abs(begin(k) - base_ - k * width) <= limit &&
                        std::abs(origin(k) - begin(k)) <= limit &&
                        std::abs(end(k) - base_ - (k + 1) * width) <= limit;
      if (!same) return 0;
    }
    return static_cast<float>((1 - 2 * kSameWidth) / width);
  }
  [[nodiscard]] double coefficient(std::uint32_t k, std::uint32_t power, int component) const {
    const std::size_t row =
        static_cast<std::size_t>(first_ + k) * table_.row_count + (table_.row_count - 1 - power);
    return table_.rows[row * kRow + static_cast<std::size_t>(component)];
  }

  /// u ( (2 n + 1) sum |c_k| h^k + 2 s sum k |c_k| h^(k-1) ) is not more than it may be.
  [[nodiscard]] bool precise(std::uint32_t k, int component, double h, double s) const {
    double value = 0, slope = 0, before = 0, h_power = 1;
    for (std::uint32_t power = 0; power < table_.row_count; ++power) {
      const double c = std::abs(coefficient(k, power, component));
      value += c * h_power;
      slope += power * c * before;
      before = h_power;
      h_power *= h;
    }
    return kUnit * ((2.0 * table_.row_count - 1) * value + 2 * s * slope) <=
           most(component) + kSinglePart * value;
  }

  [[nodiscard]] bool precise() const {
    for (std::uint32_t k = 0; k < count_; ++k) {
      if (!(begin(k) < end(k))) continue;
      const double h = std::max(std::abs(begin(k) - origin(k)), std::abs(end(k) - origin(k)));
      const double s = std::max(std::abs(begin(k) - base_), std::abs(end(k) - base_));
      for (int component = 0; component < kComponents; ++component)
        if (!precise(k, component, h, s)) return false;
    }
    return true;
  }

  /// p_(k-1) is p_k at the knot k, and does not leave it too far where the knot is missed by `part` of its
  /// position x:
  ///   |p_(k-1) - p_k| is rounding,   part x |p_(k-1)' - p_k'| <= what single precision may miss
  [[nodiscard]] bool joins(double part) const {
    for (std::uint32_t k = 1; k < count_; ++k) {
      if (!(origin(k) > lo_ && origin(k) < hi_)) continue;
      for (int component = 0; component < kComponents; ++component)
        if (!joins(k, component, part * (origin(k) - base_))) return false;
    }
    return true;
  }

  [[nodiscard]] bool joins(std::uint32_t k, int component, double missed) const {
    const double t = origin(k) - origin(k - 1), next = coefficient(k, 0, component);
    double value = 0, slope = 0, terms = 0;
    for (std::uint32_t power = table_.row_count; power-- > 0;) {
      const double c = coefficient(k - 1, power, component);
      slope = slope * t + value;
      value = value * t + c;
      terms = terms * t + std::abs(c);
    }
    const double bend = slope - (table_.row_count > 1 ? coefficient(k, 1, component) : 0.0);
    return std::abs(value - next) <= kNoStep * most(component) &&
           missed * std::abs(bend) <= most(component) + kSinglePart * terms;
  }

  const FlatTable& table_;
  std::uint32_t first_, count_;
  double base_;
  double lo_ = -kInfinity, hi_ = kInfinity;  ///< where the functions are these polynomials
  double reach_ = 0;
  bool usable_ = false;
};

}  // namespace

std::vector<WindowRow> windows_of(const FlatTable& table) {
  std::vector<WindowRow> rows;
  for (std::uint32_t first = 0; first < table.segments; first += kWindowStep)
    Window(table, first).append_to(rows);
  return rows;
}

}  // namespace abbe::kernel
