#include "abbe/kernel/single_steps.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace abbe::kernel {
namespace {

using Kind = FlatStep::Kind;
using Six = std::array<double, kComponents>;

/// A step and what its table gains.
struct Folded {
  FlatOp op;
  Six gain{};
};

[[nodiscard]] bool takes_constants(const FlatOp& op) { return op.kind == Kind::twist && op.table != nullptr; }

/// The constant twist `op` for points that are still to be moved by t, or with sign -1 for moved ones.
[[nodiscard]] Six seen_across(const FlatOp& op, const double* t, double sign) {
  const double* const e = op.a;
  return {op.u[0] + sign * (e[1] * t[2] - e[2] * t[1]),
          op.u[1] + sign * (e[2] * t[0] - e[0] * t[2]),
          op.u[2] + sign * (e[0] * t[1] - e[1] * t[0]),
          e[0],
          e[1],
          e[2]};
}

void gain(Folded& twist, const Six& constant) {
  for (std::size_t k = 0; k < constant.size(); ++k)
    twist.gain[k] += twist.op.inverse ? -constant[k] : constant[k];
}

void move_on(FlatOp& op, const double* t) {
  for (int k = 0; k < 3; ++k) op.t[k] += t[k];
  op.moves_on = op.t[0] != 0 || op.t[1] != 0 || op.t[2] != 0;
}

/// Constant twists into the tables beside them; the first step, which is the tip, takes translations in need.
[[nodiscard]] std::vector<Folded> fold(const std::vector<FlatOp>& steps) {
  std::vector<Folded> out;
  for (const FlatOp& op : steps) {
    if (op.kind == Kind::fixed_twist && !out.empty() && takes_constants(out.back().op)) {
      gain(out.back(), seen_across(op, out.back().op.t, +1));
      move_on(out.back().op, op.t);
    } else if (takes_constants(op) && out.size() > 1 && out.back().op.kind == Kind::fixed_twist) {
      const FlatOp constant = out.back().op;
      out.pop_back();
      move_on(out.back().op, constant.t);
      gain(out.emplace_back(Folded{op, {}}), seen_across(constant, constant.t, -1));
    } else {
      out.push_back({op, {}});
    }
  }
  return out;
}

template <std::size_t kCount>
void round(const double (&from)[kCount], float (&to)[kCount]) {
  std::transform(std::begin(from), std::end(from), to, [](double x) { return static_cast<float>(x); });
}

/// The table with constants added to its polynomials.
[[nodiscard]] std::vector<double> raised(const FlatTable& table, const Six& by) {
  const std::size_t count = static_cast<std::size_t>(table.segments) * table.row_count;
  std::vector<double> rows(table.rows, table.rows + count * kRow);
  for (std::size_t row = table.row_count - 1; row < count; row += table.row_count)
    for (std::size_t k = 0; k < by.size(); ++k) rows[row * kRow + k] += by[k];
  return rows;
}

}  // namespace

void give_windows(FlatTable& table, std::vector<std::vector<WindowRow>>& windows) {
  windows.push_back(windows_of(table));
  table.windows = windows.back().front().value;
  table.window_size = kFirstCoefficient + kWindow * kComponents * table.row_count;
}

SingleSteps single_steps(const std::vector<FlatOp>& steps) {
  SingleSteps out;
  for (const Folded& from : fold(steps)) {
    FlatOpOf<float>& to = out.steps.emplace_back();
    static_cast<FlatStep&>(to) = from.op;
    round(from.op.u, to.u);
    round(from.op.t, to.t);
    round(from.op.a, to.a);
    if (!takes_constants(from.op)) continue;
    auto table = std::make_unique<FlatTable>(*from.op.table);
    out.rows.push_back(raised(*table, from.gain));
    table->rows = out.rows.back().data();
    give_windows(*table, out.windows);
    to.table = table.get();
    out.tables.push_back(std::move(table));
  }
  return out;
}

}  // namespace abbe::kernel
