#include "evaluate_report.h"

#include <fmt/core.h>

#include <utility>

#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

/// How deviations of a quantity are shown to people.
struct Shown {
  double factor;
  const char* unit;
};
Shown shown(Quantity quantity) {
  switch (quantity) {
    case Quantity::angle:
      return {urad, "urad"};
    case Quantity::temperature:
      return {1, "degC"};
    default:
      return {um, "um"};
  }
}
const char* json_unit(Quantity quantity) {
  switch (quantity) {
    case Quantity::angle:
      return "rad";
    case Quantity::temperature:
      return "degC";
    default:
      return "mm";
  }
}

/// A figure that may not be known: R and A of single runs.
struct Figure {
  const char* name;
  double value;
  bool known;
};
std::vector<Figure> figures_of(const PositioningFigures& f) {
  const bool spread = f.has_spread(), both = f.bidirectional();
  return {{"A", f.A.both, spread},
          {"A forward", f.A.forward, spread && f.runs_forward > 0},
          {"A backward", f.A.backward, spread && f.runs_backward > 0},
          {"R", f.R.both, spread},
          {"R forward", f.R.forward, spread && f.runs_forward > 0},
          {"R backward", f.R.backward, spread && f.runs_backward > 0},
          {"E", f.E.both, true},
          {"E forward", f.E.forward, f.runs_forward > 0},
          {"E backward", f.E.backward, f.runs_backward > 0},
          {"M", f.M, both},
          {"B", f.B, both},
          {"mean reversal", f.mean_reversal, both}};
}

std::vector<std::pair<const char*, const Straightness*>> lines_of(const StraightnessFigures& figures) {
  return {{"end points", &figures.end_points},
          {"least squares", &figures.least_squares},
          {"minimum zone", &figures.minimum_zone}};
}

std::string table_of_targets(const RunAnswer& answer) {
  const Shown s = shown(answer.quantity);
  const double position = answer.target_quantity == Quantity::angle ? deg : mm;
  std::string text = fmt::format("\n{:>12} {:>10} {:>10} {:>10} {:>9} {:>9} {:>9}\n", "target", "forward",
                                 "backward", "reversal", "s fwd", "s bwd", "R_i");
  for (const PositioningTarget& t : answer.figures.targets)
    text += fmt::format("{:>12.4f} {:>10.3f} {:>10.3f} {:>10.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n",
                        t.position / position, t.mean_forward / s.factor, t.mean_backward / s.factor,
                        t.reversal / s.factor, t.s_forward / s.factor, t.s_backward / s.factor,
                        t.repeatability / s.factor);
  return text;
}

std::string budget_text(const RunAnswer& answer) {
  const std::optional<CombinedUncertainty> combined = combine(answer.budget);
  if (!combined || combined->u == 0) return {};
  const Shown s = shown(answer.quantity);
  std::string text =
      "\nuncertainty of the mean deviation over the full length (standard, in the manner of ISO/TR 230-9)\n";
  for (const UncertaintyInput& input : answer.budget)
    text += fmt::format("  {:<16}{:>10.3f} {}\n", input.name,
                        std::abs(input.sensitivity) * input.u / s.factor, s.unit);
  text += fmt::format("  {:<16}{:>10.3f} {}   95 %: +-{:.3f} {}\n", "combined", combined->u / s.factor,
                      s.unit, combined->expanded_95() / s.factor, s.unit);
  return text;
}

std::vector<std::pair<const char*, const MonteCarloResult*>> drawn_of(const PositioningUncertainty& drawn) {
  return {{"E", &drawn.E}, {"A", &drawn.A}, {"M", &drawn.M}, {"B", &drawn.B}};
}

std::string drawn_text(const RunAnswer& answer) {
  if (!answer.drawn) return {};
  const Shown s = shown(answer.quantity);
  std::string text = "\nby Monte Carlo: standard uncertainty and 95 % interval\n";
  for (const auto& [name, result] : drawn_of(*answer.drawn))
    text += fmt::format("  {:<16}{:>10.3f} {}   {:.3f} to {:.3f}\n", name, result->u / s.factor, s.unit,
                        result->symmetric[0] / s.factor, result->symmetric[1] / s.factor);
  return text;
}

void write_head(JsonWriter& json, const char* as) {
  json.member("format", 1).member("verb", "evaluate").member("as", as);
}

void write_edition(JsonWriter& json) {
  json.member("edition", PositioningFigures::kEdition)
      .member("coverage_factor", PositioningFigures::kCoverage);
}

void write_figures(JsonWriter& json, const PositioningFigures& figures) {
  json.key("figures").begin_object();
  for (const Figure& figure : figures_of(figures)) {
    std::string name = figure.name;
    for (char& c : name)
      if (c == ' ') c = '_';
    json.key(name);
    figure.known ? json.value(figure.value) : json.null();
  }
  json.end();
}

void write_targets(JsonWriter& json, const RunAnswer& answer) {
  json.key("targets").begin_array();
  const double position = answer.target_quantity == Quantity::angle ? deg : mm;
  for (const PositioningTarget& t : answer.figures.targets) {
    json.begin_object(Layout::one_line);
    json.member("position", t.position / position).member("mean_forward", t.mean_forward);
    json.member("mean_backward", t.mean_backward).member("mean", t.mean).member("reversal", t.reversal);
    json.member("s_forward", t.s_forward).member("s_backward", t.s_backward);
    json.member("repeatability", t.repeatability).end();
  }
  json.end();
}

void write_uncertainty(JsonWriter& json, const RunAnswer& answer) {
  const std::optional<CombinedUncertainty> combined = combine(answer.budget);
  if (combined && combined->u > 0) {
    json.key("uncertainty").begin_object();
    for (const UncertaintyInput& input : answer.budget)
      json.member(input.name, std::abs(input.sensitivity) * input.u);
    json.member("combined", combined->u).member("expanded_95", combined->expanded_95()).end();
  }
  if (!answer.drawn) return;
  json.key("monte_carlo").begin_object();
  for (const auto& [name, result] : drawn_of(*answer.drawn)) {
    json.key(name).begin_object(Layout::one_line);
    json.member("u", result->u);
    json.key("interval_95").value(std::span<const double>(result->symmetric)).end();
  }
  json.end();
}

}  // namespace

std::optional<RunAnswer> answer_of_runs(const std::string& as, const RunTable& table,
                                        const SetupArguments& setup, Session& session) {
  constexpr double kPpm = 1e-6;
  RunAnswer answer{table.file, as, table.target_quantity, table.quantity, positioning_figures(table), {},
                   {},         {}};
  if (as == "straightness") {
    std::vector<double> means;
    for (const PositioningTarget& target : answer.figures.targets) means.push_back(target.mean);
    answer.straightness = straightness_figures(table.targets, means);
  }
  if (as != "positioning" || table.quantity != Quantity::length) return answer;
  const PositioningSetup known{setup.instrument_ppm * kPpm,      setup.misalignment_mm,
                               setup.temperature_range,          setup.expansion_ppm * kPpm,
                               setup.expansion_range_ppm * kPpm, setup.temperature_difference,
                               setup.environment_um * um};
  answer.budget = positioning_budget(known, answer.figures);
  if (setup.trials == 0) return answer;
  answer.drawn = positioning_uncertainty(table, known, static_cast<std::size_t>(setup.trials), setup.seed);
  if (answer.drawn) return answer;
  session.report(option_error("--trials", "a direction has only one run",
                              "without repeated runs there is no spread to draw from"));
  return std::nullopt;
}

std::vector<FigureFact> facts_of(const RunAnswer& answer) {
  const Shown s = shown(answer.quantity);
  std::vector<FigureFact> facts;
  if (answer.straightness)
    for (const auto& [name, straightness] : lines_of(*answer.straightness))
      facts.push_back({name, fmt::format("{:.3f} {}", straightness->value / s.factor, s.unit)});
  for (const Figure& figure : figures_of(answer.figures))
    if (figure.known)
      facts.push_back({figure.name, fmt::format("{:.3f} {}", figure.value / s.factor, s.unit)});
  facts.push_back(
      {std::string(PositioningFigures::kEdition), fmt::format("k = {}", PositioningFigures::kCoverage)});
  return facts;
}

std::string text_of(const RunAnswer& answer) {
  const Shown s = shown(answer.quantity);
  std::string text = fmt::format("{}: {}, {} runs forward, {} backward\n", answer.file, answer.as,
                                 answer.figures.runs_forward, answer.figures.runs_backward);
  if (answer.straightness) {
    text += "\nstraightness of the means about the line of\n";
    for (const auto& [name, straightness] : lines_of(*answer.straightness))
      text += fmt::format("  {:<16}{:>10.3f} {}   slope {:+.3f} urad\n", name, straightness->value / s.factor,
                          s.unit, straightness->line.slope / urad);
  }
  text += fmt::format("\n{}, k = {}{}\n", PositioningFigures::kEdition, PositioningFigures::kCoverage,
                      answer.as == "positioning" ? "" : " (its figures, of this quantity)");
  for (const Figure& figure : figures_of(answer.figures))
    text += figure.known ? fmt::format("  {:<16}{:>10.3f} {}\n", figure.name, figure.value / s.factor, s.unit)
                         : fmt::format("  {:<16}{:>10}\n", figure.name, "-");
  return text + table_of_targets(answer) + budget_text(answer) + drawn_text(answer);
}

std::string json_of(const RunAnswer& answer) {
  JsonWriter json;
  json.begin_object();
  write_head(json, answer.as.c_str());
  json.member("file", answer.file).member("unit", json_unit(answer.quantity));
  json.member("position_unit", answer.target_quantity == Quantity::angle ? "deg" : "mm");
  write_edition(json);
  json.key("runs").begin_object(Layout::one_line);
  json.member("forward", answer.figures.runs_forward).member("backward", answer.figures.runs_backward).end();
  write_figures(json, answer.figures);
  if (answer.straightness) {
    json.key("straightness").begin_object();
    for (const auto& [name, straightness] : lines_of(*answer.straightness)) {
      json.key(name[0] == 'e' ? "end_points" : name[0] == 'l' ? "least_squares" : "minimum_zone");
      json.begin_object(Layout::one_line).member("value", straightness->value);
      json.member("slope", straightness->line.slope).member("offset", straightness->line.offset).end();
    }
    json.end();
  }
  write_targets(json, answer);
  write_uncertainty(json, answer);
  json.end();
  return json.take();
}

DiagonalAnswer answer_of_diagonals(const std::vector<std::string>& files, const std::vector<RunTable>& tables,
                                   const std::vector<double>& sides) {
  DiagonalAnswer answer{files, diagonal_figures(tables), {}, {}};
  std::vector<double> longer;
  for (const PositioningFigures& figures : answer.figures.diagonals)
    longer.push_back(figures.targets.back().mean - figures.targets.front().mean);
  if (sides.size() == 2 && longer.size() == 2)
    answer.face = squareness_of_face(sides[0], sides[1], longer[0], longer[1]);
  if (sides.size() == 3 && longer.size() == 4)
    answer.box =
        squareness_of_box({sides[0], sides[1], sides[2]}, {longer[0], longer[1], longer[2], longer[3]});
  return answer;
}

std::string text_of(const DiagonalAnswer& answer) {
  std::string text = fmt::format("diagonals in the manner of ISO 230-6 ({}, k = {} along each)\n",
                                 PositioningFigures::kEdition, PositioningFigures::kCoverage);
  for (std::size_t i = 0; i < answer.files.size(); ++i) {
    const PositioningFigures& f = answer.figures.diagonals[i];
    text += fmt::format("  {:<24} E {:9.3f} um   B {:8.3f} um   longer by {:+.3f} um\n", answer.files[i],
                        f.E.both / um, f.B / um, (f.targets.back().mean - f.targets.front().mean) / um);
  }
  text += fmt::format("  E_d {:.3f} um   B_d {:.3f} um\n", answer.figures.E_d / um, answer.figures.B_d / um);
  if (answer.face)
    text += fmt::format(
        "squareness {:+.3f} urad = EC0Y of XY, EA0Z of YZ, -EB0Z of ZX (first order, linear errors alike)\n",
        *answer.face / urad);
  if (answer.box)
    text += fmt::format("squareness C0Y {:+.3f}  B0Z {:+.3f}  A0Z {:+.3f} urad; all longer by {:+.3f} um\n",
                        answer.box->C0Y / urad, answer.box->B0Z / urad, answer.box->A0Z / urad,
                        answer.box->mean_longer / um);
  return text;
}

std::string json_of(const DiagonalAnswer& answer) {
  JsonWriter json;
  json.begin_object();
  write_head(json, "diagonals");
  write_edition(json);
  json.key("diagonals").begin_array();
  for (std::size_t i = 0; i < answer.files.size(); ++i) {
    const PositioningFigures& f = answer.figures.diagonals[i];
    json.begin_object().member("file", answer.files[i]).member("unit", "mm");
    json.member("longer_mm", f.targets.back().mean - f.targets.front().mean);
    write_figures(json, f);
    json.end();
  }
  json.end().member("E_d_mm", answer.figures.E_d).member("B_d_mm", answer.figures.B_d);
  if (answer.face) json.member("squareness_rad", *answer.face);
  if (answer.box) {
    json.key("squareness").begin_object(Layout::one_line);
    json.member("EC0Y_rad", answer.box->C0Y).member("EB0Z_rad", answer.box->B0Z);
    json.member("EA0Z_rad", answer.box->A0Z).member("mean_longer_mm", answer.box->mean_longer).end();
  }
  json.end();
  return json.take();
}

std::vector<FigureFact> facts_of(const DriftFigures& figures) {
  std::vector<FigureFact> facts;
  for (const SensorDrift& sensor : figures.sensors) {
    const Shown s = shown(sensor.quantity);
    facts.push_back({sensor.name + " range", fmt::format("{:.3f} {}", sensor.range / s.factor, s.unit)});
    facts.push_back(
        {sensor.name + " 60 min", fmt::format("{:.3f} {}", sensor.range_first_hour / s.factor, s.unit)});
  }
  return facts;
}

std::string text_of(const std::string& file, const DriftFigures& figures) {
  std::string text =
      fmt::format("{}: drift in the manner of ISO 230-3, {:.1f} min\n\n{:<10} {:>10} {:>16} {:>16} {:>10}\n",
                  file, figures.duration / 60, "sensor", "range", "first 60 min", "any 60 min", "change");
  for (const SensorDrift& sensor : figures.sensors) {
    const Shown s = shown(sensor.quantity);
    text += fmt::format("{:<10} {:>10.3f} {:>16.3f} {:>16.3f} {:>+10.3f} {}\n", sensor.name,
                        sensor.range / s.factor, sensor.range_first_hour / s.factor,
                        sensor.most_in_an_hour / s.factor, sensor.change / s.factor, s.unit);
  }
  return text;
}

std::string json_of(const std::string& file, const DriftFigures& figures) {
  JsonWriter json;
  json.begin_object();
  write_head(json, "drift");
  json.member("file", file).member("duration_s", figures.duration);
  json.key("sensors").begin_array();
  for (const SensorDrift& sensor : figures.sensors) {
    json.begin_object(Layout::one_line)
        .member("name", sensor.name)
        .member("unit", json_unit(sensor.quantity));
    json.member("range", sensor.range).member("range_first_hour", sensor.range_first_hour);
    json.member("most_in_an_hour", sensor.most_in_an_hour).member("change", sensor.change).end();
  }
  json.end().end();
  return json.take();
}

}  // namespace abbe::app
