#include "abbe/chain/axis_table_builder.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Sines are tabulated as polynomials of this degree: about 21 segments a period at micrometres.
constexpr int kWaveDegree = 5;
constexpr std::size_t kMaxWaveSegments = 4096;
// Where sines are tabulated on an axis without travels.
constexpr double kOpenTravel = 1500, kOpenTurns = 4 * std::numbers::pi;
// Knots closer than this, relative to their size, are one: rounding of units and references.
constexpr double kSameKnot = 64 * kEpsilon;
constexpr std::size_t kBucketsPerSegment = 4, kMaxBuckets = 1 << 14;

/// c_0 + c_1 t + c_2 t^2 ..
using Polynomial = std::vector<double>;

/// The coefficients about `by`: p(t + by).
[[nodiscard]] Polynomial shifted(Polynomial p, double by) {
  for (std::size_t k = 0; k < p.size(); ++k) {
    for (std::size_t i = p.size() - 1; i > k; --i) p[i - 1] += by * p[i];
  }
  return p;
}

[[nodiscard]] double value_of_polynomial(const Polynomial& p, double t) {
  double value = 0;
  for (std::size_t k = p.size(); k-- > 0;) value = value * t + p[k];
  return value;
}

/// The polynomial through f at the Chebyshev nodes of [-h, h] (Newton's divided differences).
template <class F>
[[nodiscard]] Polynomial interpolated(const F& f, double h) {
  constexpr std::size_t count = kWaveDegree + 1;
  std::array<double, count> t{}, d{};
  for (std::size_t i = 0; i < count; ++i) {
    t[i] = h * std::cos(std::numbers::pi * (static_cast<double>(i) + 0.5) / count);
    d[i] = f(t[i]);
  }
  for (std::size_t order = 1; order < count; ++order) {
    for (std::size_t i = count - 1; i >= order; --i) d[i] = (d[i] - d[i - 1]) / (t[i] - t[i - order]);
  }
  Polynomial p = {d[count - 1]};
  for (std::size_t i = count - 1; i-- > 0;) {
    p.insert(p.begin(), 0.0);  // p * t - p * t_i + d_i
    for (std::size_t k = 0; k + 1 < p.size(); ++k) p[k] -= t[i] * p[k + 1];
    p[0] += d[i];
  }
  return p;
}

/// A leaf in internal units: pieces about their knots, or a sine.
class Leaf {
 public:
  Leaf(const AxisLeaf& source, double unit) : component(source.component) {
    if (source.node == nullptr) {
      knots.push_back(0);
      pieces.push_back({source.factor});
      return;
    }
    using Form = ErrorFunction::Form;
    namespace detail = error_function_detail;
    const ErrorFunction::Node& node = *source.node;
    const double* data = source.function->data().data() + node.data;
    const double reference = node.reference * unit;
    // The ends are widened by rounding, so that 30 deg through radians is not beyond 30 deg.
    const auto end = [&](double v, double outward) {
      const double slack = 4 * kEpsilon * (std::abs(v) + std::abs(node.reference));
      return (v + outward * slack) * unit + reference;
    };
    lo = end(node.lo, -1);
    hi = end(node.hi, +1);
    period = node.periodic ? node.period * unit : 0;
    if (node.form == Form::sine) {
      // A sin(w (q / unit - r) + phi)
      wave = {component, source.factor * data[0], data[1] / unit, data[2] - data[1] * node.reference, lo, hi};
      return;
    }
    const bool table = node.form != Form::polynomial;
    const std::size_t record = !table                      ? node.count
                               : node.form == Form::linear ? detail::kLinearRecord
                                                           : detail::kCubicRecord;
    for (std::size_t i = 0; i < (table ? node.count : 1); ++i, data += record) {
      knots.push_back((table ? data[0] * unit : 0.0) + reference);
      Polynomial& p = pieces.emplace_back();
      double power = 1;
      // c_k (v - x)^k with v = q / unit is (c_k / unit^k) (q - x unit)^k
      for (std::size_t k = table ? 1 : 0; k < record; ++k, power *= unit)
        p.push_back(source.factor * data[k] / power);
    }
  }

  [[nodiscard]] bool is_wave() const { return pieces.empty(); }
  [[nodiscard]] double slack() const { return component < 3 ? kTabulatedMm : kTabulatedRad; }

  /// The function about `origin` on the segment [a, b] around `inside`: constant where it is held.
  [[nodiscard]] Polynomial around(double origin, double inside, double a, double b) const {
    if (inside < lo || inside > hi) return {value(inside < lo ? lo : hi)};
    if (is_wave()) {
      const double middle = (a + b) / 2;
      return shifted(interpolated([&](double t) { return value(middle + t); }, (b - a) / 2), origin - middle);
    }
    const std::size_t i = piece(inside);
    return shifted(pieces[i], origin - knots[i]);
  }

  int component = 0;
  double lo = -kInfinity, hi = kInfinity, period = 0;
  std::vector<double> knots;
  std::vector<Polynomial> pieces;
  Wave wave;

 private:
  [[nodiscard]] std::size_t piece(double x) const {
    const auto above = std::upper_bound(knots.begin(), knots.end(), x);
    return above == knots.begin() ? 0 : static_cast<std::size_t>(above - knots.begin()) - 1;
  }
  [[nodiscard]] double value(double x) const {
    if (is_wave()) return wave.amplitude * std::sin(wave.frequency * x + wave.phase);
    const std::size_t i = piece(x);
    return value_of_polynomial(pieces[i], x - knots[i]);
  }
};

class AxisTableBuilder {
 public:
  AxisTableBuilder(Plan::Impl& plan, int axis, ApproachKey approach, std::vector<Leaf> leaves,
                   const std::array<double, kComponents>& constant)
      : plan_(plan), leaves_(std::move(leaves)), constant_(constant) {
    table_.axis = axis;
    table_.direction = static_cast<std::int8_t>(approach.direction);
    table_.direction_axis = static_cast<std::int8_t>(approach.axis);
  }

  void append() {
    table_.period = leaves_.empty() ? 0 : leaves_.front().period;
    set_ends();
    choose_knots();
    write_segments();
    write_buckets();
    plan_.tables.push_back(table_);
  }

 private:
  void set_ends() {
    table_.first_wave = static_cast<std::uint32_t>(plan_.waves.size());
    for (const Leaf& leaf : leaves_) {
      table_.lo = std::max(table_.lo, leaf.lo);
      table_.hi = std::min(table_.hi, leaf.hi);
      if (leaf.is_wave()) plan_.waves.push_back(leaf.wave);
    }
    table_.wave_count = static_cast<std::uint32_t>(plan_.waves.size()) - table_.first_wave;
    table_.bounded = table_.period == 0 && (std::isfinite(table_.lo) || std::isfinite(table_.hi));
  }

  void choose_knots() {
    for (const Leaf& leaf : leaves_) {
      knots_.insert(knots_.end(), leaf.knots.begin(), leaf.knots.end());
      if (leaf.period == 0 && std::isfinite(leaf.lo)) knots_.push_back(leaf.lo);
      if (leaf.period == 0 && std::isfinite(leaf.hi)) knots_.push_back(leaf.hi);
    }
    add_wave_knots();
    std::sort(knots_.begin(), knots_.end());
    const double size = knots_.empty() ? 0 : std::max(std::abs(knots_.front()), std::abs(knots_.back()));
    knots_.erase(std::unique(knots_.begin(), knots_.end(),
                             [size](double a, double b) { return b - a <= kSameKnot * size; }),
                 knots_.end());
    table_.period_lo = knots_.empty() ? 0 : knots_.front();
  }

  /// |A| (W h)^6 / (2^5 6!) bounds what the polynomial through six Chebyshev nodes of [-h, h] misses.
  void add_wave_knots() {
    double step = kInfinity;
    for (const Leaf& leaf : leaves_) {
      if (!leaf.is_wave() || leaf.wave.amplitude == 0 || leaf.wave.frequency == 0) continue;
      const double h = std::pow(leaf.slack() * 32 * 720 / std::abs(leaf.wave.amplitude), 1.0 / 6) /
                       std::abs(leaf.wave.frequency);
      step = std::min(step, 2 * h);
    }
    const auto k = static_cast<std::size_t>(table_.axis);
    const bool rotary = (plan_.rotary >> table_.axis & 1) != 0;
    const double open = rotary ? kOpenTurns : kOpenTravel;
    double lo = std::isfinite(plan_.lo[k]) ? plan_.lo[k] : -open;
    double hi = std::isfinite(plan_.hi[k]) ? plan_.hi[k] : open;
    const double margin = 0.01 * (hi - lo);
    lo -= margin;
    hi += margin;
    if (table_.wave_count == 0) return;
    const double count = std::max(1.0, std::ceil((hi - lo) / step));
    if (!(hi > lo && count <= static_cast<double>(kMaxWaveSegments))) {
      waves_directly_ = true;
      return;
    }
    for (int i = 0; i <= static_cast<int>(count); ++i) knots_.push_back(lo + (hi - lo) * i / count);
    table_.waves_lo = lo;
    table_.waves_hi = hi;
  }

  void write_segments() {
    if (knots_.empty() || waves_only_directly()) knots_ = {knots_.empty() ? 0.0 : knots_.front()};
    // One more segment than knots where something is different before the first one.
    const bool before = !(knots_.size() == 1 && single_piece());
    if (before) knots_.insert(knots_.begin(), knots_.front());
    table_.segments = static_cast<std::uint32_t>(knots_.size());
    table_.knots = static_cast<std::uint32_t>(plan_.knots.size());
    table_.data = static_cast<std::uint32_t>(plan_.coefficients.size());
    plan_.knots.insert(plan_.knots.end(), knots_.begin(), knots_.end());

    const double far = 1 + std::abs(knots_.front()) + std::abs(knots_.back());
    std::vector<std::vector<std::array<double, kComponents>>> segments(knots_.size());
    for (std::size_t i = 0; i < knots_.size(); ++i) {
      const double a = i == 0 && before ? knots_[0] - far : knots_[i];
      const double b = i == 0 && before ? knots_[0] : i + 1 < knots_.size() ? knots_[i + 1] : knots_[i] + far;
      auto& rows = segments[i];
      rows.push_back(constant_);
      for (const Leaf& leaf : leaves_) add(leaf, knots_[i], a, b, rows);
      table_.rows = std::max(table_.rows, static_cast<std::uint32_t>(rows.size()));
    }
    for (auto& rows : segments) {
      rows.resize(table_.rows, {});
      for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
        plan_.coefficients.insert(plan_.coefficients.end(), row->begin(), row->end());
      }
    }
  }

  void add(const Leaf& leaf, double origin, double a, double b,
           std::vector<std::array<double, kComponents>>& rows) const {
    const double inside = (a + b) / 2;
    if (leaf.is_wave() && !(inside >= table_.waves_lo && inside <= table_.waves_hi && !waves_directly_))
      return;
    const Polynomial p = leaf.around(origin, inside, a, b);
    if (rows.size() < p.size()) rows.resize(p.size(), {});
    for (std::size_t k = 0; k < p.size(); ++k) rows[k][static_cast<std::size_t>(leaf.component)] += p[k];
  }

  /// One polynomial everywhere.
  [[nodiscard]] bool single_piece() const {
    return std::all_of(leaves_.begin(), leaves_.end(), [](const Leaf& leaf) {
      return leaf.pieces.size() <= 1 && !std::isfinite(leaf.lo) && !std::isfinite(leaf.hi);
    });
  }
  [[nodiscard]] bool waves_only_directly() const { return waves_directly_ && single_piece(); }

  void write_buckets() {
    if (waves_directly_) {
      table_.waves_lo = kInfinity;
      table_.waves_hi = -kInfinity;
    }
    table_.first_bucket = static_cast<std::uint32_t>(plan_.buckets.size());
    const std::size_t last = knots_.size() - 1;
    // The lower ends of all segments but the first.
    const double lo = knots_[std::min<std::size_t>(1, last)], hi = knots_[last];
    const std::size_t count =
        hi > lo ? std::min(kMaxBuckets, kBucketsPerSegment * knots_.size()) : std::size_t{1};
    table_.bucket_count = static_cast<std::uint32_t>(count) + 2;
    table_.buckets_per_unit = hi > lo ? static_cast<double>(count) / (hi - lo) : 0;
    // One bucket below the first end and one above the last.
    table_.bucket_lo = hi > lo ? lo - 1 / table_.buckets_per_unit : lo;
    std::uint32_t i = 0;
    for (std::size_t b = 0; b < table_.bucket_count; ++b) {
      const double edge =
          hi > lo ? table_.bucket_lo + static_cast<double>(b) / table_.buckets_per_unit : -kInfinity;
      while (i < last && knots_[i + 1] <= edge) ++i;
      plan_.buckets.push_back(b == 0 ? 0 : i);
    }
  }

  Plan::Impl& plan_;
  std::vector<Leaf> leaves_;
  const std::array<double, kComponents>& constant_;
  AxisTable table_;
  std::vector<double> knots_;
  bool waves_directly_ = false;
};

}  // namespace

void append_tables(Plan::Impl& plan, int axis, std::span<const AxisLeaf> leaves,
                   const std::array<double, kComponents>& constant) {
  const double unit = plan.unit[static_cast<std::size_t>(axis)];
  // What repeats needs its own position; several tables of one period and start share it.
  std::map<std::pair<double, double>, std::vector<Leaf>> kinds;
  for (const AxisLeaf& source : leaves) {
    Leaf leaf(source, unit);
    const double start = leaf.period > 0 ? leaf.knots.front() : 0;
    kinds[{leaf.period, start}].push_back(std::move(leaf));
  }
  const ApproachKey approach = leaves.empty() ? ApproachKey{} : leaves.front().approach;
  if (leaves.empty()) kinds[{0.0, 0.0}] = {};
  std::array<double, kComponents> first = constant;
  for (auto& [kind, members] : kinds) {
    AxisTableBuilder(plan, axis, approach, std::move(members), first).append();
    first = {};
  }
}

}  // namespace abbe
