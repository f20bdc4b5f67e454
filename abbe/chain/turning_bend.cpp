#include "abbe/chain/turning_bend.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "abbe/chain/table_bounds.h"
#include "abbe/machine/machine.h"

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSecondOrder = 1.05;  // products of errors, which the sums leave out

/// The control reckons with the chain of the machine file, and every error is a table of one axis.
[[nodiscard]] bool is_known(const Plan::Impl& plan) {
  if (!plan.terms.empty()) return false;
  const auto& axes = plan.machine->control.axes;
  if (std::any_of(axes.begin(), axes.end(),
                  [](const ControlAxis& axis) { return axis.origin || axis.direction; }))
    return false;
  // A position that jumps by a turn needs functions that do not mind.
  return std::all_of(plan.tables.begin(), plan.tables.end(), [&](const AxisTable& table) {
    const auto k = static_cast<std::size_t>(table.axis);
    return table.period > 0 || k >= axes.size() || axes[k].turning == Turning::linear;
  });
}

}  // namespace

struct TurningBend::Constants {
  /// What one axis contributes, its tables added up: the bound's terms in s^2, in s w and in s v.
  struct Axis {
    double turns = 0;  ///< 1: a rotary axis
    double square = 0, with_turn = 0, with_slide = 0, jump = 0;
    double turn_square = 0, turn_with_turn = 0, turn_jump = 0;  ///< of the direction
    double reach = kInfinity;                                   ///< farther, and a table jumps twice
    double open = kInfinity;                                    ///< positions beyond were not looked at
    std::vector<double> jumps_at;
    bool jumps_everywhere = false;  ///< a periodic table jumps: positions beyond a turn are not looked up

    [[nodiscard]] bool jumps_between(double lo, double hi) const {
      if (jumps_everywhere) return true;
      const auto next = std::lower_bound(jumps_at.begin(), jumps_at.end(), lo);
      return next != jumps_at.end() && *next <= hi;
    }
  };
  std::array<Axis, kMaxAxes> axes{};
  int axis_count = 0;
  double lever = 0;                     ///< L
  double displacement = 0, turned = 0;  ///< D, e

  void add(const TableBounds& b, Axis& axis) {
    axis.square += b.d2 + b.e2 * lever;
    axis.with_turn += 2 * (b.d1 + 2 * b.e1 * lever);
    axis.with_slide += 2 * b.e1;
    axis.jump += b.d_jump + b.e_jump * lever;
    axis.turn_square += b.e2;
    axis.turn_with_turn += 4 * b.e1;
    axis.turn_jump += b.e_jump;
    axis.reach = std::min(axis.reach, b.knot_distance);
    axis.jumps_at.insert(axis.jumps_at.end(), b.jumps_at.begin(), b.jumps_at.end());
    std::sort(axis.jumps_at.begin(), axis.jumps_at.end());
    displacement += b.d0;
    turned += b.e0;
  }
  void add(const Plan::Impl& plan, const Group& group) {
    for (int k = 0; group.table_count == 0 && k < kComponents; ++k)
      (k < 3 ? displacement : turned) += std::abs(group.constant[static_cast<std::size_t>(k)]);
    for (std::uint32_t b = 0; b < group.table_count; ++b) {
      const AxisTable& table = plan.tables[group.first_table + b];
      Axis& axis = axes[static_cast<std::size_t>(table.axis)];
      add(table_bounds(plan, table, lever), axis);
      axis.jumps_everywhere = axis.jumps_everywhere || (table.period > 0 && !axis.jumps_at.empty());
    }
  }
};

TurningBend::TurningBend(const Plan& plan, const Tool& tool) {
  const Plan::Impl& impl = plan.impl();
  if (!is_known(impl)) return;
  auto constants = std::make_unique<Constants>();
  constants->axis_count = impl.axis_count;
  constants->lever = chain_length(impl, tool);
  for (std::size_t k = 0; k < static_cast<std::size_t>(impl.axis_count); ++k) {
    if ((impl.rotary >> k & 1) == 0) continue;
    constants->axes[k].turns = 1;
    if (!(std::isfinite(impl.lo[k]) && std::isfinite(impl.hi[k]))) constants->axes[k].open = kOpenTurn;
  }
  for (const Op& op : impl.first_order)
    if (op.kind == Op::Kind::twist) constants->add(impl, impl.groups[static_cast<std::size_t>(op.index)]);
  constants_ = std::move(constants);
}
TurningBend::~TurningBend() = default;
TurningBend::TurningBend(TurningBend&&) noexcept = default;
TurningBend& TurningBend::operator=(TurningBend&&) noexcept = default;

MoveExtent extent_of(const EvenMove& move) {
  MoveExtent extent;
  for (std::size_t k = 0; k < kMaxAxes; ++k) {
    const double from = move.done_from[k] - move.meant_from[k], to = move.done_to[k] - move.meant_to[k];
    const auto [lo, hi] = std::minmax(move.done_from[k], move.done_to[k]);
    extent.axes[k] = {lo, hi, hi - lo, std::abs(to - from), std::max(std::abs(from), std::abs(to))};
  }
  return extent;
}

namespace {

/// Of one axis, whose positions these are; kPlaces: as many as there are, or Eigen::Dynamic.
template <int kPlaces>
MoveExtent::Axis extent_of_row(const double* done, const double* meant, Eigen::Index places) {
  using Row = Eigen::Array<double, kPlaces, 1, 0, MoveRun::kMost + 1, 1>;  // not from the heap
  constexpr int kMoves = kPlaces == Eigen::Dynamic ? Eigen::Dynamic : kPlaces - 1;
  using Moves = Eigen::Map<const Eigen::Array<double, kMoves, 1>>;
  const Eigen::Map<const Row> is(done, places), wanted(meant, places);
  const Row off = is - wanted;
  const auto farthest = [&](const auto& row) {
    return (Moves(row.data() + 1, places - 1) - Moves(row.data(), places - 1)).abs().maxCoeff();
  };
  return {is.minCoeff(), is.maxCoeff(), farthest(is), farthest(off), off.abs().maxCoeff()};
}

}  // namespace

MoveExtent MoveRun::extent(std::size_t first, std::size_t end, std::size_t axis_count) const {
  constexpr int kFull = static_cast<int>(kMost) + 1;
  MoveExtent extent;
  const auto places = static_cast<Eigen::Index>(end - first + 1);
  for (std::size_t k = 0; k < axis_count; ++k) {
    const double *is = done[k].data() + first, *wanted = meant[k].data() + first;
    extent.axes[k] = places == kFull ? extent_of_row<kFull>(is, wanted, places)
                                     : extent_of_row<Eigen::Dynamic>(is, wanted, places);
  }
  return extent;
}

double TurningBend::rotations() const { return constants_ == nullptr ? kInfinity : constants_->turned; }

TurningBend::Bound TurningBend::bound(const MoveExtent& extent) const {
  if (constants_ == nullptr) return {};
  const Constants& c = *constants_;
  std::array<bool, kMaxAxes> jumps_in{};
  double way = 0, change = 0, offset = 0, turn = 0, turn_change = 0, turn_offset = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(c.axis_count); ++k) {
    const auto& [lo, hi, its_way, changed, off] = extent.axes[k];
    const Constants::Axis& axis = c.axes[k];
    jumps_in[k] = axis.jumps_between(lo, hi);
    if (!(lo > -axis.open && hi < axis.open) || (jumps_in[k] && !(its_way < axis.reach))) return {};
    // in registers: sums in an array would have to be waited for
    const double is_turn = axis.turns, is_slide = 1 - is_turn;
    way += is_slide * its_way;
    turn += is_turn * its_way;
    change += is_slide * changed;
    turn_change += is_turn * changed;
    offset += is_slide * off;
    turn_offset += is_turn * off;
  }
  // Both, what is meant and what is done, go no farther than this.
  const double v = way + change, w = turn + turn_change, lever = c.lever;
  const double nominal = turn_change * (2 * w * lever + 2 * v) + 2 * change * w +
                         turn_offset * (w * w * lever + 2 * w * v) + offset * w * w;
  const double nominal_turn = 2 * turn_change * w + turn_offset * w * w;
  double errors = w * w * (c.displacement + 4 * c.turned * lever) + 4 * c.turned * w * v;
  double errors_turn = 4 * w * w * c.turned;
  double jumps = 0, jumps_turn = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(c.axis_count); ++k) {
    const Constants::Axis& axis = c.axes[k];
    const double s = extent.axes[k].way;
    if (s == 0) continue;
    errors += s * (s * axis.square + w * axis.with_turn + v * axis.with_slide);
    errors_turn += s * (s * axis.turn_square + w * axis.turn_with_turn);
    if (!jumps_in[k]) continue;
    jumps += s * axis.jump;
    jumps_turn += s * axis.turn_jump;
  }
  const Bound bound = {(nominal + kSecondOrder * errors) / 8 + kSecondOrder * jumps / 4,
                       (nominal_turn + kSecondOrder * errors_turn) / 8 + kSecondOrder * jumps_turn / 4};
  return std::isfinite(bound.position) && std::isfinite(bound.direction) ? bound : Bound{};
}

}  // namespace abbe
