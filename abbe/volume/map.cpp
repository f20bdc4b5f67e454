#include "abbe/volume/map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace abbe {
namespace {

[[nodiscard]] VolumeMap unfinished(VolumeMap::Status status) {
  VolumeMap map;
  map.status = status;
  return map;
}

/// Deviations may be finite and their squares not.
[[nodiscard]] bool sums_are_finite(const VolumeMap& map) {
  double sum = map.tilt.rms + map.figures.length.rms + map.from_datum.length.rms + map.fitted.length.rms;
  for (const ErrorShare& share : map.budget) sum += share.rms + share.rms_without;
  for (const LostMotion& lost : map.lost_motion) sum += lost.rms;
  return std::isfinite(sum);
}

}  // namespace

VolumeMap map_volume(const Plan& plan, const VolumeQuestion& question, const Progress& progress) {
  using Status = VolumeMap::Status;
  const VolumeGrid& grid = question.grid;
  const std::size_t points = grid.size();
  assert(points > 0 && points <= kMostMapPoints);
  const FieldCircumstances& circumstances = question.circumstances;
  const Machine& machine = plan.machine();

  // Work is counted in poses, as far as the callback sees it.
  const std::size_t chunks = chunk_count(points), errors = machine.errors.size();
  const std::size_t total = chunks * (1 + errors + directional_axes(machine).size());
  bool stopped = false;
  const Progress poses = [&](std::uint64_t done, std::uint64_t all) {
    if (progress && !progress(done * kFieldChunk, all * kFieldChunk)) stopped = true;
    return !stopped;
  };

  VolumeMap map;
  map.field = deviation_field(plan, grid, circumstances, poses, 0, total);
  if (!map.field.complete) return unfinished(Status::stopped);
  Query at_datum;
  at_datum.q = question.datum;
  at_datum.approach = circumstances.approach;
  at_datum.tool = circumstances.tool;
  const Prediction datum = predict(plan, at_datum);
  if (!map.field.finite || !datum.finite) return unfinished(Status::overflow);

  map.figures = figures_of(map.field);
  map.tilt = amount_of(map.field.tilt);
  map.datum.t = datum.deviation.position;
  map.from_datum = figures_of(map.field, map.datum);
  map.fit = best_fit(map.field);
  map.fitted = figures_of(map.field, map.fit);
  map.accuracy = volumetric_accuracy(map.field);
  map.fitted_accuracy = volumetric_accuracy(map.field, map.fit);
  map.extrapolated =
      static_cast<std::size_t>(std::count(map.field.extrapolated.begin(), map.field.extrapolated.end(), 1));
  map.diagonals = diagonals(plan, grid, circumstances.tool, question.datum);
  map.budget = error_budget(plan, grid, circumstances, map.field, poses, chunks, total);
  if (!stopped) map.lost_motion = lost_motion(plan, grid, circumstances, poses, chunks * (1 + errors), total);
  if (stopped) return unfinished(Status::stopped);
  return sums_are_finite(map) ? map : unfinished(Status::overflow);
}

}  // namespace abbe
