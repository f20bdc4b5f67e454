#include "abbe/gear/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "abbe/machine/error_body.h"

namespace abbe {
namespace {

constexpr std::size_t kPoseNodes = 9;

/// A figure of a flank over all teeth of one side, without that of the process.
template <class Figure>
TeethFigure over_teeth(const GearFigures& figures, const GearFigures& process, std::size_t side,
                       const Figure& figure) {
  if (figures.teeth.empty()) return {};
  TeethFigure out;
  double lo = 0, hi = 0;
  for (std::size_t i = 0; i < figures.teeth.size(); ++i) {
    const double value = figure(figures.teeth[i][side]) - figure(process.teeth[i][side]);
    out.mean += value / static_cast<double>(figures.teeth.size());
    lo = i == 0 ? value : std::min(lo, value);
    hi = i == 0 ? value : std::max(hi, value);
  }
  out.range = hi - lo;
  return out;
}

double largest(const GearFigures& figures, TraceFigures FlankFigures::*trace, double TraceFigures::*figure) {
  double most = 0;
  for (const auto& tooth : figures.teeth)
    for (const FlankFigures& flank : tooth) most = std::max(most, flank.*trace.*figure);
  return most;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

GearFigures figures_of_process(const GearJob& job, const WheelInGap& wheel,
                               const GearInspection& inspection) {
  const Stroke stroke = stroke_of(job, wheel);
  return inspection.figures(WheelDeviations(stroke.low, stroke.high, 4, job.gear.spec.teeth));
}

/// Effects of a machine with some errors; nullopt: sensors are missing, or it was stopped.
std::optional<GearEffects> effects_on(const Machine& machine, const GearJob& job, const WheelInGap& wheel,
                                      const CuttingMotion& motion, const GearInspection& inspection,
                                      const GearFigures& process, const CutOptions& options) {
  const auto cut = cut_on_machine(machine, job, wheel, motion, options);
  if (!std::holds_alternative<MachineCut>(cut)) return std::nullopt;
  return effects_of(inspection.figures(std::get<MachineCut>(cut).deviations), process);
}

/// Names of errors a chain can have, with the mountings of tool and work.
std::vector<std::string> possible_errors(const Machine& machine) {
  std::vector<std::string> names = error_inventory(machine);
  for (const char* body : {"t", "w"})
    for (const char direction : std::string_view("XYZABC"))
      names.push_back(std::string("E") + direction + body);
  return names;
}

/// The machine with one error of one unit.
std::optional<Machine> with_error(const Machine& machine, const ErrorName& name,
                                  const SensitivityUnits& units) {
  std::optional<Machine> single = with_unit_error(machine, name);
  if (single) single->errors.front().scale = name.is_rotation() ? units.angle : units.length;
  return single;
}

}  // namespace

GearEffects effects_of(const GearFigures& figures, const GearFigures& process) {
  GearEffects out;
  for (std::size_t side = 0; side < 2; ++side) {
    out.profile_slope[side] =
        over_teeth(figures, process, side, [](const FlankFigures& flank) { return flank.profile.slope; });
    out.helix_slope[side] =
        over_teeth(figures, process, side, [](const FlankFigures& flank) { return flank.helix.slope; });
    out.f_p = std::max(out.f_p, figures.pitch[side].f_p);
    out.F_p = std::max(out.F_p, figures.pitch[side].F_p);
  }
  const auto beyond = [&](TraceFigures FlankFigures::*trace) {
    return std::max(
        0.0, largest(figures, trace, &TraceFigures::form) - largest(process, trace, &TraceFigures::form));
  };
  out.profile_form = beyond(&FlankFigures::profile);
  out.helix_form = beyond(&FlankFigures::helix);
  out.F_r = figures.F_r;
  out.depth = mean_of(figures.ball) - mean_of(process.ball);
  return out;
}

std::vector<SensitivityRow> pose_sensitivity(const GearJob& job, const WheelInGap& wheel,
                                             const GearInspection& inspection,
                                             const SensitivityUnits& units) {
  const GearFigures process = figures_of_process(job, wheel, inspection);
  std::vector<SensitivityRow> rows;
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    const PoseUnknown unknown = pose_unknown(i);
    const bool rotation = unknown.direction >= 3;
    PoseValues values{};
    values[i] = rotation ? units.angle : units.length;
    const WheelDeviations deviations = deviations_of(job, wheel, values, stroke_of(job, wheel), kPoseNodes);
    rows.push_back({name_of(unknown), rotation, effects_of(inspection.figures(deviations), process)});
  }
  return rows;
}

std::vector<SensitivityRow> machine_sensitivity(const Machine& machine, const GearJob& job,
                                                const WheelInGap& wheel, const CuttingMotion& motion,
                                                const GearInspection& inspection,
                                                const SensitivityUnits& units, const Progress& progress) {
  const GearFigures process = figures_of_process(job, wheel, inspection);
  const std::vector<std::string> names = possible_errors(machine);
  CutOptions options;
  options.model = ErrorModel::first_order;
  std::vector<SensitivityRow> rows;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::optional<ErrorName> name = read_error_name(names[i]);
    const std::optional<Machine> single = name ? with_error(machine, *name, units) : std::nullopt;
    const auto effects =
        single ? effects_on(*single, job, wheel, motion, inspection, process, options) : std::nullopt;
    if (effects) rows.push_back({names[i], name->is_rotation(), *effects});
    if (progress && !progress(i + 1, names.size())) return rows;
  }
  return rows;
}

std::vector<SensitivityRow> error_budget(const Machine& machine, const GearJob& job, const WheelInGap& wheel,
                                         const CuttingMotion& motion, const GearInspection& inspection,
                                         const CutOptions& options, const Progress& progress) {
  const GearFigures process = figures_of_process(job, wheel, inspection);
  std::vector<SensitivityRow> rows;
  for (std::size_t i = 0; i < machine.errors.size(); ++i) {
    Machine single = machine;
    single.errors = {machine.errors[i]};
    const auto effects = effects_on(single, job, wheel, motion, inspection, process, options);
    if (effects)
      rows.push_back({to_string(machine.errors[i].name), machine.errors[i].name.is_rotation(), *effects});
    if (progress && !progress(i + 1, machine.errors.size())) return rows;
  }
  return rows;
}

}  // namespace abbe
