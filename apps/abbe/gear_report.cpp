#include "gear_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe::app {
namespace {

constexpr std::array kFlankNames = {"right", "left"};

/// Name of a trace figure and where it is.
struct TraceColumn {
  const char* name;
  TraceFigures FlankFigures::*trace;
  double TraceFigures::*figure;
  double FlankTolerances::*which;
};
constexpr std::array<TraceColumn, 6> kColumns = {{
    {"F_alpha", &FlankFigures::profile, &TraceFigures::total, &FlankTolerances::F_alpha},
    {"f_H_alpha", &FlankFigures::profile, &TraceFigures::slope, &FlankTolerances::f_H_alpha},
    {"f_f_alpha", &FlankFigures::profile, &TraceFigures::form, &FlankTolerances::f_f_alpha},
    {"F_beta", &FlankFigures::helix, &TraceFigures::total, &FlankTolerances::F_beta},
    {"f_H_beta", &FlankFigures::helix, &TraceFigures::slope, &FlankTolerances::f_H_beta},
    {"f_f_beta", &FlankFigures::helix, &TraceFigures::form, &FlankTolerances::f_f_beta},
}};

std::string tolerance_text(const GearJob& job, const WorstFigure& worst) {
  std::string text;
  if (job.tolerance_class) {
    const auto tolerances = flank_tolerances(job.gear, *job.tolerance_class);
    if (tolerances) text += fmt::format("{:>10}", um_text(rounded_tolerance((*tolerances).*worst.which), 1));
  }
  const std::optional<int> best = class_of(job.gear, worst.which, worst.value);
  return text + (best ? fmt::format("{:>7}", *best) : fmt::format("{:>7}", "-"));
}

}  // namespace

std::string um_text(double length, int decimals) {
  std::string text;
  append_fixed(text, std::clamp(length / um, -1e11, 1e11), decimals);
  return text;
}

std::vector<WorstFigure> worst_of(const GearFigures& figures) {
  std::vector<WorstFigure> worst;
  for (const TraceColumn& column : kColumns) {
    double most = 0;
    for (const auto& tooth : figures.teeth)
      for (const FlankFigures& flank : tooth)
        most = std::max(most, std::abs(flank.*column.trace.*column.figure));
    worst.push_back({column.name, column.which, most});
  }
  worst.push_back({"f_p", &FlankTolerances::f_p, std::max(figures.pitch[0].f_p, figures.pitch[1].f_p)});
  worst.push_back({"F_p", &FlankTolerances::F_p, std::max(figures.pitch[0].F_p, figures.pitch[1].F_p)});
  worst.push_back({"F_r", &FlankTolerances::F_r, figures.F_r});
  return worst;
}

std::vector<int> shown_teeth(const GearJob& job, const std::vector<int>& asked) {
  std::vector<int> teeth = asked.empty() ? job.teeth : asked;
  if (teeth.empty())
    for (int tooth = 1; tooth <= job.gear.spec.teeth; ++tooth) teeth.push_back(tooth);
  return teeth;
}

std::string text_of_gear(const GearJob& job, const WheelInGap& wheel) {
  const Gear& gear = job.gear;
  const GearSpec& spec = gear.spec;
  std::string text = fmt::format("gear {}: module {:g} mm, {} teeth, {:g} deg, ", spec.name, spec.module,
                                 spec.teeth, spec.pressure_angle / deg);
  text += spec.helix_angle > 0
              ? fmt::format("helix {:g} deg {}", spec.helix_angle / deg, spec.hand > 0 ? "right" : "left")
              : std::string("spur");
  text += fmt::format(", profile shift {:g}, face {:g} mm\n", spec.profile_shift, spec.face_width);
  text +=
      fmt::format("diameters     base {:.4f}  root {:.4f}  form {:.4f}  reference {:.4f}  tip {:.4f} mm\n",
                  2 * gear.base_radius, 2 * gear.root_radius, 2 * gear.form_radius, 2 * gear.reference_radius,
                  2 * gear.tip_radius);
  text += fmt::format("roll lengths  form {:.4f}  reference {:.4f}  tip {:.4f} mm\n",
                      gear.base_radius * gear.form_roll, gear.base_radius * gear.reference_roll,
                      gear.base_radius * gear.tip_roll);
  text += fmt::format(
      "wheel         diameter {:g} mm, {:.4f} to {:.4f} mm wide; centre distance {:.4f} mm, swivel {:.4f} "
      "deg, contacts "
      "up to {:.3f} mm from its middle\n",
      job.wheel.diameter, wheel.root_width, wheel.tip_width, wheel.centre_distance,
      std::atan2(-wheel.axis.z(), wheel.axis.y()) / deg + 0.0, wheel.reach);
  return text;
}

void write_gear(JsonWriter& json, const GearJob& job, const WheelInGap& wheel) {
  const Gear& gear = job.gear;
  json.key("gear").begin_object();
  json.member("name", gear.spec.name).member("module_mm", gear.spec.module).member("teeth", gear.spec.teeth);
  json.member("helix_angle_deg", gear.spec.hand * gear.spec.helix_angle / deg);
  json.member("base_diameter_mm", 2 * gear.base_radius).member("root_diameter_mm", 2 * gear.root_radius);
  json.member("form_diameter_mm", 2 * gear.form_radius)
      .member("reference_diameter_mm", 2 * gear.reference_radius);
  json.member("tip_diameter_mm", 2 * gear.tip_radius);
  json.member("form_roll_mm", gear.base_radius * gear.form_roll)
      .member("reference_roll_mm", gear.base_radius * gear.reference_roll)
      .member("tip_roll_mm", gear.base_radius * gear.tip_roll)
      .end();
  json.key("wheel").begin_object();
  json.member("diameter_mm", job.wheel.diameter).member("centre_distance_mm", wheel.centre_distance);
  json.member("swivel_deg", std::atan2(-wheel.axis.z(), wheel.axis.y()) / deg);
  json.member("width_at_form_mm", wheel.root_width).member("width_at_tip_mm", wheel.tip_width);
  json.member("reach_mm", wheel.reach).end();
}

std::string text_of_figures(const GearJob& job, const GearFigures& figures, const std::vector<int>& teeth) {
  std::string text = fmt::format("{:<6}{:<7}", "tooth", "flank");
  for (const TraceColumn& column : kColumns) text += fmt::format("{:>11}", column.name);
  text += fmt::format("{:>11}  um\n", "position");
  for (const int tooth : shown_teeth(job, teeth))
    for (std::size_t side = 0; side < 2; ++side) {
      const FlankFigures& flank = figures.teeth[static_cast<std::size_t>(tooth - 1)][side];
      text += fmt::format("{:<6}{:<7}", tooth, kFlankNames[side]);
      for (const TraceColumn& column : kColumns)
        text += fmt::format("{:>11}", um_text(flank.*column.trace.*column.figure));
      text += fmt::format("{:>11}\n", um_text(flank.position));
    }
  text += fmt::format("\n{:<13}{:>10}", "all teeth", "um");
  if (job.tolerance_class) text += fmt::format("{:>10}", fmt::format("class {}", *job.tolerance_class));
  text += fmt::format("{:>7}\n", "class");
  for (const WorstFigure& worst : worst_of(figures))
    text += fmt::format("{:<13}{:>10}{}\n", worst.name, um_text(worst.value), tolerance_text(job, worst));
  return text;
}

void write_figures(JsonWriter& json, const GearJob& job, const GearFigures& figures,
                   const std::vector<int>& teeth) {
  json.key("teeth").begin_array();
  for (const int tooth : shown_teeth(job, teeth))
    for (std::size_t side = 0; side < 2; ++side) {
      const auto i = static_cast<std::size_t>(tooth - 1);
      json.begin_object(JsonWriter::Layout::one_line)
          .member("tooth", tooth)
          .member("flank", kFlankNames[side]);
      for (const TraceColumn& column : kColumns)
        json.member(fmt::format("{}_um", column.name),
                    figures.teeth[i][side].*column.trace.*column.figure / um);
      json.member("position_um", figures.teeth[i][side].position / um);
      json.member("F_pi_um", figures.pitch[side].index[i] / um)
          .member("f_pi_um", figures.pitch[side].single[i] / um);
      json.end();
    }
  json.end();
  json.key("worst").begin_array();
  for (const WorstFigure& worst : worst_of(figures)) {
    json.begin_object(JsonWriter::Layout::one_line)
        .member("name", worst.name)
        .member("value_um", worst.value / um);
    const auto tolerances =
        job.tolerance_class ? flank_tolerances(job.gear, *job.tolerance_class) : std::nullopt;
    if (tolerances) json.member("tolerance_um", rounded_tolerance((*tolerances).*worst.which) / um);
    json.key("class");
    if (const std::optional<int> best = class_of(job.gear, worst.which, worst.value)) {
      json.value(*best);
    } else {
      json.null();
    }
    json.end();
  }
  json.end();
}

}  // namespace abbe::app
