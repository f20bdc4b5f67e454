#include "abbe/chain/solve_path.h"

#include <cmath>
#include <numbers>

#include "abbe/chain/plan_impl.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSlack = 1e-9;  // rad beyond the end of a travel that is still at it

}  // namespace

void PathSolver::note(int axes, const std::array<double, kMaxAxes>& solved, const Side& side) {
  branch_changed_ = report_.points > 0 && side.sign * side_.sign < 0;
  if (branch_changed_) ++report_.branch_changes;
  if (report_.points > 0) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(axes); ++k) {
      const double step = std::abs(solved[k] - last_[k]);
      if (step <= report_.largest_step[k]) continue;
      report_.largest_step[k] = step;
      report_.largest_at[k] = seen_;
    }
  }
  ++report_.points;
  last_ = solved;
  // On the singularity there is no side: the one before still says where the path comes from.
  side_ = side.sign != 0 ? side : Side{side_.sign, 0};
}

InverseResult PathSolver::pose(const Plan& plan, const Tool& tool, const Vec3& position,
                               const Vec3& direction) {
  ++seen_;
  branch_changed_ = false;
  InverseOptions options;
  options.ideal = options_.ideal;
  options.locked = options_.correction.locked;
  options.max_rotary_correction = options_.correction.max_rotary_correction;
  options.method = options_.correction.method;
  const auto solve = [&] { return inverse(plan, tool, position, direction, last_, options_.free, options); };
  InverseResult result = solve();
  const bool crosses = report_.points > 0 && result.side.sign * side_.sign < 0;
  const bool in_cone =
      result.side.distance < options_.singular_cone && side_.distance < options_.singular_cone;
  if (crosses && !in_cone) {
    options.side = side_.sign;
    result = solve();
  }
  if (result.status != Status::failed) note(plan.impl().axis_count, result.q, result.side);
  return result;
}

void PathSolver::unwrap(const Plan& plan, Query& query) const {
  const Plan::Impl& impl = plan.impl();
  for (std::size_t k = 0; k < static_cast<std::size_t>(impl.axis_count); ++k) {
    if ((impl.rotary >> k & 1U) == 0 || !std::isfinite(query.q[k])) continue;
    const double q = query.q[k] + kTurn * std::round((last_command_[k] - query.q[k]) / kTurn);
    if (q >= impl.lo[k] - kSlack && q <= impl.hi[k] + kSlack) query.q[k] = q;
  }
}

Correction PathSolver::command(const Plan& plan, Query& query) {
  ++seen_;
  branch_changed_ = false;
  const int axes = plan.impl().axis_count;
  std::array<double, kMaxAxes> start = query.q;
  if (report_.points > 0) {
    unwrap(plan, query);
    for (std::size_t k = 0; k < static_cast<std::size_t>(axes); ++k) start[k] = query.q[k] + change_[k];
  }
  const Correction result =
      correct(plan, query, options_.free, options_.correction, report_.points > 0 ? &start : nullptr);
  if (result.status == Status::failed) return result;
  note(axes, result.corrected, side_of(plan, query, options_.free & ~options_.correction.locked));
  last_command_ = query.q;
  for (std::size_t k = 0; k < static_cast<std::size_t>(axes); ++k)
    change_[k] = result.corrected[k] - query.q[k];
  return result;
}

}  // namespace abbe
