#include "abbe/volume/budget.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "abbe/chain/plan_impl.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"
#include "abbe/volume/parallel.h"

namespace abbe {
namespace {

/// Sums over the points of one chunk.
struct ChunkSums {
  Vec3 squares = Vec3::Zero();
  double without = 0;
  double max = -1, max_tilt = -1;
  std::size_t at = 0, at_tilt = 0;
};

/// The machine with one error only, ready for batches.
struct SingleError {
  Plan plan;
  std::shared_ptr<const kernel::FlatPlan> flat;
  bool rotates;
};

/// Positions of a chunk by axis, and tips by component.
struct Batch {
  std::vector<std::vector<double>> q;
  std::vector<const double*> columns;
  std::array<std::vector<double>, 3> tip;
  std::vector<unsigned char> lanes;
};

/// Tips of the chunk by a kernel; points stand side by side.
void tips_by_kernel(const kernel::FlatPlan& flat, const VolumeGrid& grid, ChunkRange range, const Tool& tool,
                    std::vector<Vec3>& tips) {
  const std::size_t axes = grid.positions.size(), count = range.last - range.first;
  Batch batch;
  batch.q.assign(axes, std::vector<double>(count));
  for (std::size_t i = 0; i < count; ++i) {
    const std::array<double, kMaxAxes> q = grid.at(range.first + i);
    for (std::size_t a = 0; a < axes; ++a) batch.q[a][i] = q[a];
  }
  for (const std::vector<double>& column : batch.q) batch.columns.push_back(column.data());
  for (std::vector<double>& column : batch.tip) column.resize(count);
  batch.lanes.assign(count, kernel::Lane::ordinary);
  kernel::Setting setting;
  for (int k = 0; k < 3; ++k) setting.tip[k] = tool.tip[k];
  const std::array<double*, 3> to = {batch.tip[0].data(), batch.tip[1].data(), batch.tip[2].data()};
  kernel::best().tips(flat.view(), setting, batch.columns.data(), count, to.data(), batch.lanes.data());
  for (std::size_t i = 0; i < count; ++i) tips[i] = {batch.tip[0][i], batch.tip[1][i], batch.tip[2][i]};
}

[[nodiscard]] ChunkSums sums_of(const SingleError& single, const VolumeGrid& grid,
                                const FieldCircumstances& circumstances, const DeviationField& field,
                                ChunkRange range) {
  ChunkSums part;
  std::vector<Vec3> tips(range.last - range.first);
  // A displacement tilts nothing: the tip is enough.
  const bool by_kernel = !single.rotates && single.flat != nullptr;
  if (by_kernel) tips_by_kernel(*single.flat, grid, range, circumstances.tool, tips);
  Query query;
  query.approach = circumstances.approach;
  query.tool = circumstances.tool;
  for (std::size_t i = range.first; i < range.last; ++i) {
    Vec3& tip = tips[i - range.first];
    if (!by_kernel) query.q = grid.at(i);
    if (single.rotates) {
      const Pose actual = actual_pose(single.plan, query);
      tip = actual.p;
      const double tilt =
          angle_between(nominal_pose(single.plan, query).R * query.tool.axis, actual.R * query.tool.axis);
      if (tilt > part.max_tilt) part.max_tilt = tilt, part.at_tilt = i;
    } else if (!by_kernel) {
      tip = actual_tip(single.plan, query);
    }
    const Vec3 d = tip - field.nominal[i];
    const double length = d.norm();
    part.squares += d.cwiseAbs2();
    part.without += (field.deviation[i] - d).squaredNorm();
    if (length > part.max) part.max = length, part.at = i;
  }
  return part;
}

}  // namespace

std::vector<ErrorShare> error_budget(const Plan& plan, const VolumeGrid& grid,
                                     const FieldCircumstances& circumstances, const DeviationField& field,
                                     const Progress& progress, std::size_t done_before, std::size_t total) {
  const Plan::Impl& impl = plan.impl();
  const std::size_t errors = plan.machine().errors.size();
  const std::size_t points = field.nominal.size(), chunks = chunk_count(points);
  std::vector<SingleError> singles;
  for (std::size_t e = 0; e < errors; ++e) {
    Plan alone = compile_plan(impl.machine, impl.variables, impl.model, static_cast<int>(e));
    auto flat = kernel::FlatPlan::make(alone);
    singles.push_back({std::move(alone), std::move(flat), plan.machine().errors[e].name.is_rotation()});
  }
  std::vector<ChunkSums> parts(errors * chunks);
  const bool complete = for_each_chunk(
      parts.size(), circumstances.threads,
      [&](std::size_t k) {
        parts[k] = sums_of(singles[k / chunks], grid, circumstances, field, chunk_range(k % chunks, points));
      },
      progress, done_before, total);
  if (!complete || points == 0) return {};

  std::vector<ErrorShare> shares;
  for (std::size_t e = 0; e < errors; ++e) {
    ChunkSums sum;
    for (std::size_t c = 0; c < chunks; ++c) {
      const ChunkSums& part = parts[e * chunks + c];
      sum.squares += part.squares;
      sum.without += part.without;
      if (part.max > sum.max) sum.max = part.max, sum.at = part.at;
      if (part.max_tilt > sum.max_tilt) sum.max_tilt = part.max_tilt, sum.at_tilt = part.at_tilt;
    }
    const double n = static_cast<double>(points);
    ErrorShare share;
    share.error = e;
    share.max = sum.max;
    share.at = sum.at;
    share.rms = std::sqrt(sum.squares.sum() / n);
    share.rms_component = (sum.squares / n).cwiseSqrt();
    share.rms_without = std::sqrt(sum.without / n);
    share.max_tilt = std::max(sum.max_tilt, 0.0);
    share.at_tilt = sum.at_tilt;
    shares.push_back(share);
  }
  std::stable_sort(shares.begin(), shares.end(),
                   [](const ErrorShare& a, const ErrorShare& b) { return a.rms > b.rms; });
  return shares;
}

std::vector<int> directional_axes(const Machine& machine) {
  std::vector<int> axes;
  for (const ErrorTerm& error : machine.errors) {
    for (const ErrorFunction::Node& node : error.function.nodes()) {
      if (node.form != ErrorFunction::Form::directional || node.variable < 0) continue;
      const int axis = machine.variables[static_cast<std::size_t>(node.variable)].axis;
      if (axis >= 0 && std::find(axes.begin(), axes.end(), axis) == axes.end()) axes.push_back(axis);
    }
  }
  std::sort(axes.begin(), axes.end());
  return axes;
}

std::vector<LostMotion> lost_motion(const Plan& plan, const VolumeGrid& grid,
                                    const FieldCircumstances& circumstances, const Progress& progress,
                                    std::size_t done_before, std::size_t total) {
  const std::vector<int> axes = directional_axes(plan.machine());
  const std::size_t points = grid.size(), chunks = chunk_count(points);
  std::vector<ChunkSums> parts(axes.size() * chunks);
  const bool complete = for_each_chunk(
      parts.size(), circumstances.threads,
      [&](std::size_t k) {
        const auto axis = static_cast<std::size_t>(axes[k / chunks]);
        const ChunkRange range = chunk_range(k % chunks, points);
        Query query;
        query.tool = circumstances.tool;
        for (std::size_t i = range.first; i < range.last; ++i) {
          query.q = grid.at(i);
          query.approach[axis] = 1;
          const Vec3 from_below = actual_tip(plan, query);
          query.approach[axis] = -1;
          const Vec3 step = from_below - actual_tip(plan, query);
          parts[k].squares += step.cwiseAbs2();
          if (step.norm() > parts[k].max) parts[k].max = step.norm(), parts[k].at = i;
        }
      },
      progress, done_before, total);
  if (!complete || points == 0) return {};
  std::vector<LostMotion> result;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    LostMotion lost;
    lost.axis = axes[a];
    lost.max = -1;
    double squares = 0;
    for (std::size_t c = 0; c < chunks; ++c) {
      const ChunkSums& part = parts[a * chunks + c];
      squares += part.squares.sum();
      if (part.max > lost.max) lost.max = part.max, lost.at = part.at;
    }
    lost.rms = std::sqrt(squares / static_cast<double>(points));
    result.push_back(lost);
  }
  return result;
}

}  // namespace abbe
