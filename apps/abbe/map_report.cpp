#include "map_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "map_uncertainty.h"
#include "map_volume.h"
#include "text.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::string_view kRangeDefinition =
    "in the manner of the volumetric accuracy V of ISO 230-1: largest minus smallest deviation (actual - "
    "nominal, tool seen from the workpiece) along x y z, and of the orientation of the tool about x y z, "
    "over "
    "all points of the grid, in workpiece axes";
constexpr std::string_view kDiagonalDefinition =
    "in the manner of ISO 230-6: deviation along the line from its first to its last point, zero at the "
    "start (mean of both directions)";
constexpr std::string_view kBudgetDefinition =
    "effect of each error alone, all others off; without: rms of the distance if this error were corrected, "
    "to first order. Shares are vectors that can cancel, so they do not add up to the whole";
constexpr std::string_view kPercentileDefinition =
    "95 %: the smallest value that at least 95 % of the points do not exceed (of magnitudes)";

constexpr std::array<std::string_view, 3> kComponent = {"x", "y", "z"};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
  return text;
}

/// "X 400 mm  C 90 deg": as short as a position may be said.
std::string place_text(const Machine& machine, const std::array<double, kMaxAxes>& q) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    text += fmt::format("{}{} {:.7g}{}", text.empty() ? "" : "  ", axis.name,
                        json_position(axis, q[static_cast<std::size_t>(i)]) + 0.0,
                        axis.type == AxisType::rotary ? " deg" : "");
  }
  return text;
}

/// "V_XYZAC": the axes that vary.
std::string name_of_volume(const Machine& machine, const VolumeGrid& grid) {
  std::string name = "V_";
  std::vector<std::string> axes;
  for (int i = 0; i < machine.axis_count(); ++i)
    if (grid.varies(i)) axes.push_back(machine.axis(i).name);
  std::sort(axes.begin(), axes.end(), [](const std::string& a, const std::string& b) {
    const auto rank = [](const std::string& s) { return std::string_view("XYZUVWABC").find(s.front()); };
    return rank(a) != rank(b) ? rank(a) < rank(b) : a < b;
  });
  for (const std::string& axis : axes) name += axis;
  return name;
}

/// Words filled into lines of a terminal.
std::string filled(std::string_view text) {
  constexpr std::size_t kColumns = 110;
  std::string lines;
  std::size_t used = 0;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), word.size() + 1));
    if (used > 0 && used + 1 + word.size() > kColumns) lines += '\n', used = 0;
    if (used > 0) lines += ' ', ++used;
    lines += word;
    used += word.size();
  }
  return lines + '\n';
}

std::string spread_row(std::string_view name, const Spread& s) {
  return fmt::format("{:<18}{:>+11.3f}{:>+11.3f}{:>11.3f}{:>11.3f}{:>+11.3f}{:>11.3f}\n", name, s.min / um,
                     s.max / um, s.percentile95 / um, s.rms / um, s.mean / um, s.range() / um);
}

std::string amount_row(std::string_view name, const Amount& a, double unit, std::string_view where) {
  return fmt::format("{:<18}{:>11}{:>11.3f}{:>11.3f}{:>11.3f}{:>11.3f}{:>11}  largest at {}\n", name, "",
                     a.max / unit, a.percentile95 / unit, a.rms / unit, a.mean / unit, "", where);
}

std::string heading_text(const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  const VolumeGrid& grid = answer.question.grid;
  std::string text = fmt::format("machine           {} ({} model, {} errors)\n", machine.name,
                                 to_string(answer.setting.model), machine.errors.size());
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const std::vector<double>& positions = grid.positions[static_cast<std::size_t>(i)];
    const auto [lo, hi] = std::minmax_element(positions.begin(), positions.end());
    const std::string_view unit = axis.type == AxisType::rotary ? "deg" : "mm";
    text += fmt::format("{:<18}", i == 0 ? "volume" : "");
    text += positions.size() > 1
                ? fmt::format("{:<3} {:.7g} to {:.7g} {}, {} positions\n", axis.name,
                              json_position(axis, *lo), json_position(axis, *hi), unit, positions.size())
                : fmt::format("{:<3} {:.7g} {}\n", axis.name, json_position(axis, *lo) + 0.0, unit);
  }
  return text + fmt::format("points            {}\n", answer.map.field.deviation.size());
}

std::string deviation_text(const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  const VolumeMap& map = answer.map;
  const auto place = [&](std::size_t point) { return place_text(machine, answer.question.grid.at(point)); };
  std::string text = '\n' +
                     filled(fmt::format("Deviation of the tip, actual - nominal, in workpiece axes, um. {}.",
                                        kPercentileDefinition)) +
                     fmt::format("{:<18}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "", "min", "max", "95 %",
                                 "rms", "mean", "range");
  for (std::size_t c = 0; c < 3; ++c) text += spread_row(kComponent[c], map.figures.component[c]);
  text += amount_row("distance", map.figures.length, um, place(map.figures.length.at));
  text += amount_row("from the datum", map.from_datum.length, um, place(map.from_datum.length.at));
  text += amount_row("after best fit", map.fitted.length, um, place(map.fitted.length.at));
  text += amount_row("tilt, urad", map.tilt, urad, place(map.tilt.at));
  const Vec3 d = map.datum.t / um, t = map.fit.t / um, w = map.fit.w / urad;
  text += fmt::format("datum: {}; there the deviation is {:+.3f} {:+.3f} {:+.3f} um\n",
                      place_text(machine, answer.question.datum), d.x(), d.y(), d.z());
  text +=
      filled(fmt::format("best fit: the rigid motion of the workpiece nearest to the map is taken away, "
                         "{:+.3f} {:+.3f} {:+.3f} um "
                         "at the centre and {:+.3f} {:+.3f} {:+.3f} urad",
                         t.x(), t.y(), t.z(), w.x(), w.y(), w.z()));
  return text;
}

std::string accuracy_text(const MapAnswer& answer) {
  const VolumeMap& map = answer.map;
  const std::string name = name_of_volume(answer.setting.machine, answer.question.grid);
  std::string text = '\n' + filled(fmt::format("Range {}, {}.", name, kRangeDefinition)) +
                     fmt::format("{:<18}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}\n", "", "X um", "Y um", "Z um",
                                 "A urad", "B urad", "C urad");
  const auto row = [&](std::string_view label, const VolumetricAccuracy& v) {
    const Vec3 p = v.position / um, o = v.orientation / urad;
    text += fmt::format("{:<18}{:>11.3f}{:>11.3f}{:>11.3f}{:>11.3f}{:>11.3f}{:>11.3f}\n", label, p.x(), p.y(),
                        p.z(), o.x(), o.y(), o.z());
  };
  row("as the file aligns", map.accuracy);
  row("after best fit", map.fitted_accuracy);
  return text;
}

std::string diagonals_text(const MapAnswer& answer) {
  if (answer.map.diagonals.empty()) return {};
  std::string text =
      '\n' + filled(fmt::format("Diagonals, {}; other axes at the datum.", kDiagonalDefinition)) +
      fmt::format("{:<18}{:>11}{:>17}{:>11}{:>11}\n", "", "length mm", "too long by um", "range E", "lost B");
  for (const Diagonal& d : answer.map.diagonals) {
    text += fmt::format("{:<18}{:>11.3f}{:>+17.3f}{:>11.3f}{:>11.3f}\n", name_of(d, answer.setting.machine),
                        d.length, d.change / um, d.range / um, d.reversal / um);
  }
  return text;
}

std::string budget_text(const MapAnswer& answer, std::size_t most) {
  const Machine& machine = answer.setting.machine;
  const std::vector<ErrorShare>& budget = answer.map.budget;
  std::string text = '\n' + filled(fmt::format("Error budget: {}.", kBudgetDefinition)) +
                     fmt::format("{:<8}{:>10}{:>10}{:>10}{:>10}{:>10}{:>11}{:>10}\n", "", "rms um", "rms x",
                                 "rms y", "rms z", "max um", "tilt urad", "without");
  std::size_t listed = 0;
  for (const ErrorShare& share : budget) {
    if (most > 0 && listed == most) break;
    ++listed;
    const Vec3 c = share.rms_component / um;
    text +=
        fmt::format("{:<8}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>10.3f}{:>11.3f}{:>10.3f}  largest at {}\n",
                    abbe::to_string(machine.errors[share.error].name), share.rms / um, c.x(), c.y(), c.z(),
                    share.max / um, share.max_tilt / urad, share.rms_without / um,
                    place_text(machine, answer.question.grid.at(share.at)));
  }
  if (listed < budget.size())
    text += fmt::format("and {} smaller ones (--most 0 lists all)\n", budget.size() - listed);
  if (budget.empty()) text += "the machine file has no errors\n";
  return text;
}

std::string closing_text(const MapAnswer& answer) {
  const VolumeMap& map = answer.map;
  const Machine& machine = answer.setting.machine;
  std::string text;
  for (const LostMotion& lost : map.lost_motion) {
    text += fmt::format("{}lost motion of {}: {:.3f} um at most, rms {:.3f} um, at {}\n",
                        text.empty() ? "\n" : "", machine.axis(lost.axis).name, lost.max / um, lost.rms / um,
                        place_text(machine, answer.question.grid.at(lost.at)));
  }
  if (map.extrapolated > 0)
    text += fmt::format("\nextrapolated      {} (held beyond their last value at {} points)\n",
                        joined(map.field.extrapolated_names), map.extrapolated);
  const std::vector<std::string> outside = outside_travel(machine, answer.question.grid);
  if (!outside.empty()) text += fmt::format("\noutside travel    {}\n", joined(outside));
  if (answer.setting.limits.given())
    text += fmt::format("\n{}: {} of {} points within the limits\n", answer.pass ? "pass" : "FAIL",
                        answer.within, map.field.deviation.size());
  return text;
}

void write_spread(JsonWriter& json, std::string_view name, const Spread& s, const MapAnswer& answer) {
  json.key(name).begin_object(Layout::one_line);
  json.member("min_um", s.min / um).member("max_um", s.max / um);
  json.member("percentile95_um", s.percentile95 / um).member("rms_um", s.rms / um);
  json.member("mean_um", s.mean / um).member("range_um", s.range() / um);
  write_positions(json, "min_at", answer.setting.machine, answer.question.grid.at(s.at_min));
  write_positions(json, "max_at", answer.setting.machine, answer.question.grid.at(s.at_max));
  json.end();
}

void write_amount(JsonWriter& json, std::string_view name, const Amount& a, bool angle,
                  const MapAnswer& answer) {
  const auto member = [&](std::string_view what, double value) {
    json.member(fmt::format("{}_{}", what, angle ? "rad" : "um"), angle ? value : value / um);
  };
  json.key(name).begin_object(Layout::one_line);
  member("max", a.max);
  member("percentile95", a.percentile95);
  member("rms", a.rms);
  member("mean", a.mean);
  write_positions(json, "at", answer.setting.machine, answer.question.grid.at(a.at));
  json.end();
}

void write_figures(JsonWriter& json, const FieldFigures& figures, const MapAnswer& answer) {
  for (std::size_t c = 0; c < 3; ++c) write_spread(json, kComponent[c], figures.component[c], answer);
  write_amount(json, "distance", figures.length, false, answer);
}

void write_accuracy(JsonWriter& json, std::string_view name, const VolumetricAccuracy& v) {
  json.key(name).begin_object(Layout::one_line);
  json.member("position_um", Vec3(v.position / um)).member("orientation_rad", v.orientation).end();
}

void write_volume(JsonWriter& json, const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  json.key("volume").begin_object();
  json.key("positions").begin_object();
  for (int i = 0; i < machine.axis_count(); ++i) {
    std::vector<double> positions;
    for (const double p : answer.question.grid.positions[static_cast<std::size_t>(i)])
      positions.push_back(json_position(machine.axis(i), p));
    json.member(machine.axis(i).name, std::span<const double>(positions));
  }
  json.end();
  json.member("points", static_cast<std::uint64_t>(answer.map.field.deviation.size())).end();
}

void write_diagonals(JsonWriter& json, const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  json.member("diagonals_definition", kDiagonalDefinition).key("diagonals").begin_array();
  for (const Diagonal& d : answer.map.diagonals) {
    json.begin_object(Layout::one_line);
    json.member("name", name_of(d, machine));
    write_positions(json, "from", machine, d.from);
    write_positions(json, "to", machine, d.to);
    json.member("length_mm", d.length).member("change_um", d.change / um);
    json.member("range_um", d.range / um).member("reversal_um", d.reversal / um);
    const auto column = [&](std::string_view name, double Diagonal::Point::*value, double unit) {
      std::vector<double> numbers;
      for (const Diagonal::Point& point : d.points) numbers.push_back(point.*value / unit);
      json.member(name, std::span<const double>(numbers));
    };
    column("s_mm", &Diagonal::Point::s, mm);
    column("forward_um", &Diagonal::Point::forward, um);
    column("backward_um", &Diagonal::Point::backward, um);
    json.end();
  }
  json.end();
}

void write_budget(JsonWriter& json, const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  json.member("budget_definition", kBudgetDefinition).key("budget").begin_array();
  for (const ErrorShare& share : answer.map.budget) {
    json.begin_object(Layout::one_line);
    json.member("error", abbe::to_string(machine.errors[share.error].name));
    json.member("rms_um", share.rms / um).member("rms_xyz_um", Vec3(share.rms_component / um));
    json.member("max_um", share.max / um);
    write_positions(json, "at", machine, answer.question.grid.at(share.at));
    json.member("max_tilt_rad", share.max_tilt);
    write_positions(json, "tilt_at", machine, answer.question.grid.at(share.at_tilt));
    json.member("rms_without_um", share.rms_without / um).end();
  }
  json.end();
  json.key("lost_motion").begin_array();
  for (const LostMotion& lost : answer.map.lost_motion) {
    json.begin_object(Layout::one_line);
    json.member("axis", machine.axis(lost.axis).name);
    json.member("max_um", lost.max / um).member("rms_um", lost.rms / um);
    write_positions(json, "at", machine, answer.question.grid.at(lost.at));
    json.end();
  }
  json.end();
}

}  // namespace

std::string map_text(const MapAnswer& answer, std::size_t most) {
  return heading_text(answer) + deviation_text(answer) + accuracy_text(answer) + diagonals_text(answer) +
         budget_text(answer, most) +
         (answer.uncertainty != nullptr ? uncertainty_text(*answer.uncertainty) : std::string()) +
         closing_text(answer);
}

std::string map_json(const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  const VolumeMap& map = answer.map;
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "map", machine);
  json.member("model", to_string(answer.setting.model));
  write_volume(json, answer);
  json.member("percentile_definition", kPercentileDefinition);
  json.key("deviation").begin_object();
  write_figures(json, map.figures, answer);
  json.end();
  write_amount(json, "tilt", map.tilt, true, answer);
  json.key("from_datum").begin_object();
  write_positions(json, "datum", machine, answer.question.datum);
  json.member("datum_deviation_um", Vec3(map.datum.t / um));
  write_figures(json, map.from_datum, answer);
  json.end();
  json.key("best_fit").begin_object();
  json.member("centre_mm", map.fit.centre).member("translation_um", Vec3(map.fit.t / um));
  json.member("rotation_rad", map.fit.w);
  write_figures(json, map.fitted, answer);
  json.end();
  json.key("volumetric_accuracy").begin_object();
  json.member("name", name_of_volume(machine, answer.question.grid)).member("definition", kRangeDefinition);
  write_accuracy(json, "as_stated", map.accuracy);
  write_accuracy(json, "best_fit", map.fitted_accuracy);
  json.end();
  write_diagonals(json, answer);
  write_budget(json, answer);
  if (answer.uncertainty != nullptr) write_uncertainty(json, *answer.uncertainty);
  json.member("extrapolated", map.field.extrapolated_names);
  json.member("extrapolated_points", static_cast<std::uint64_t>(map.extrapolated));
  json.member("outside_travel", outside_travel(machine, answer.question.grid));
  if (answer.setting.limits.given()) {
    json.member("points_within", static_cast<std::uint64_t>(answer.within)).member("pass", answer.pass);
  }
  write_findings(json, "warnings", answer.setting.findings);
  json.end();
  return json.take();
}

std::string csv_header(const MapAnswer& answer) {
  const Machine& machine = answer.setting.machine;
  std::string header;
  for (int i = 0; i < machine.axis_count(); ++i) header += machine.axis(i).name + ',';
  return header + "dx_um,dy_um,dz_um,distance_um,ex_urad,ey_urad,ez_urad,tilt_urad," +
         (answer.uncertainty != nullptr ? "u_x_um,u_y_um,u_z_um," : "") + "extrapolated\n";
}

void append_csv_row(std::string& out, const MapAnswer& answer, std::size_t point) {
  const Machine& machine = answer.setting.machine;
  const DeviationField& field = answer.map.field;
  const std::array<double, kMaxAxes> q = answer.question.grid.at(point);
  const auto number = [&](double value) {
    out += to_shortest(value);
    out += ',';
  };
  for (int i = 0; i < machine.axis_count(); ++i)
    number(q[static_cast<std::size_t>(i)] / machine.axis_unit(i));
  for (int c = 0; c < 3; ++c) number(field.deviation[point][c] / um);
  number(field.deviation[point].norm() / um);
  for (int c = 0; c < 3; ++c) number(field.rotation[point][c] / urad);
  number(field.tilt[point] / urad);
  for (int c = 0; answer.uncertainty != nullptr && c < 3; ++c) number(answer.uncertainty->u[point][c] / um);
  out += field.extrapolated[point] != 0 ? "1\n" : "0\n";
}

}  // namespace abbe::app
