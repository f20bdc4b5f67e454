#include "abbe/volume/budget.h"

#include <algorithm>
#include <cmath>

#include "abbe/chain/plan_impl.h"
#include "abbe/volume/parallel.h"
#include "abbe/volume/statistics.h"

namespace abbe {
namespace {

/// The largest value so far and the place where it was reached first.
struct Largest {
  double value = -1, place_value = -1;
  std::size_t at = 0;
  void add(double v, double at_place, std::size_t place) {
    value = std::max(value, v);
    if (at_place > place_value + kSameValue) place_value = at_place, at = place;
  }
  void add(double v, std::size_t place) { add(v, v, place); }
  void add(const Largest& other) { add(other.value, other.place_value, other.at); }
};

/// Sums over the points of one chunk.
struct ChunkSums {
  Vec3 squares = Vec3::Zero();
  double without = 0;
  Largest length, tilt;

  void add(const ChunkSums& other) {
    squares += other.squares;
    without += other.without;
    length.add(other.length);
    tilt.add(other.tilt);
  }
};

/// `single` has one error only. The general walk, not the kernels: with one error it is as fast, and rounds
/// like the field it is held against.
[[nodiscard]] ChunkSums sums_of(const Plan& single, bool rotates, const VolumeGrid& grid,
                                const FieldCircumstances& circumstances, const DeviationField& field,
                                ChunkRange range) {
  ChunkSums sums;
  Query query;
  query.approach = circumstances.approach;
  query.tool = circumstances.tool;
  for (std::size_t i = range.first; i < range.last; ++i) {
    query.q = grid.at(i);
    Vec3 tip;
    if (rotates) {
      const Pose actual = actual_pose(single, query);
      tip = actual.p;
      sums.tilt.add(angle_between(field.nominal_axis[i], actual.R * query.tool.axis), i);
    } else {
      tip = actual_tip(single, query);  // a displacement tilts nothing
    }
    const Vec3 d = tip - field.nominal[i];
    sums.squares += d.cwiseAbs2();
    sums.without += (field.deviation[i] - d).squaredNorm();
    sums.length.add(d.norm(), i);
  }
  return sums;
}

}  // namespace

std::vector<ErrorShare> error_budget(const Plan& plan, const VolumeGrid& grid,
                                     const FieldCircumstances& circumstances, const DeviationField& field,
                                     const Progress& progress, std::size_t done_before, std::size_t total) {
  const Plan::Impl& impl = plan.impl();
  const std::size_t errors = plan.machine().errors.size();
  const std::size_t points = field.nominal.size(), chunks = chunk_count(points);
  std::vector<Plan> singles;
  for (std::size_t e = 0; e < errors; ++e)
    singles.push_back(compile_plan(impl.machine, impl.variables, impl.model, static_cast<int>(e)));
  std::vector<ChunkSums> parts(errors * chunks);
  const bool complete = for_each_chunk(
      parts.size(), circumstances.threads,
      [&](std::size_t k) {
        const std::size_t e = k / chunks;
        parts[k] = sums_of(singles[e], plan.machine().errors[e].name.is_rotation(), grid, circumstances,
                           field, chunk_range(k % chunks, points));
      },
      progress, done_before, total);
  if (!complete || points == 0) return {};

  std::vector<ErrorShare> shares;
  for (std::size_t e = 0; e < errors; ++e) {
    ChunkSums sum;
    for (std::size_t c = 0; c < chunks; ++c) sum.add(parts[e * chunks + c]);
    const double n = static_cast<double>(points);
    ErrorShare share;
    share.error = e;
    share.max = sum.length.value;
    share.at = sum.length.at;
    share.rms = std::sqrt(sum.squares.sum() / n);
    share.rms_component = (sum.squares / n).cwiseSqrt();
    share.rms_without = std::sqrt(sum.without / n);
    share.max_tilt = std::max(sum.tilt.value, 0.0);
    share.at_tilt = sum.tilt.at;
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
          parts[k].length.add(step.norm(), i);
        }
      },
      progress, done_before, total);
  if (!complete || points == 0) return {};
  std::vector<LostMotion> result;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    ChunkSums sum;
    for (std::size_t c = 0; c < chunks; ++c) sum.add(parts[a * chunks + c]);
    LostMotion lost;
    lost.axis = axes[a];
    lost.max = sum.length.value;
    lost.at = sum.length.at;
    lost.rms = std::sqrt(sum.squares.sum() / static_cast<double>(points));
    result.push_back(lost);
  }
  return result;
}

}  // namespace abbe
