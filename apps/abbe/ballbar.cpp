#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "abbe/ballbar/b5r.h"
#include "abbe/ballbar/circular_figures.h"
#include "abbe/ballbar/diagnosis.h"
#include "abbe/core/units.h"
#include "abbe/report/ballbar_figure.h"
#include "abbe/report/json_writer.h"
#include "ballbar_source.h"
#include "bus_record.h"
#include "common.h"
#include "output_file.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

struct BallbarVerb {
  BallbarArguments source;
  std::vector<std::string> pitch;
  bool no_search = false, json = false;
  std::string bus, svg, out;
};

/// One test with everything that is said about it.
struct Answer {
  BallbarTest test;
  TestFigures figures;
  Diagnosis diagnosis;
};

std::string direction_name(int direction) { return direction > 0 ? "CCW" : "CW"; }

std::string conditions_text(const BallbarTest& test) {
  return fmt::format(
      "{}: plane {} (angles from +{} to +{}), radius {:g} mm, {:g} mm/min, {} samples in {} runs\n",
      test.file, to_string(test.plane), axis_letter(test.plane.first), axis_letter(test.plane.second),
      test.radius, test.feed * 60, test.samples(), test.runs.size());
}

std::string figures_text(const TestFigures& figures) {
  std::string text =
      "\nin the manner of ISO 230-4, um          least squares centre       minimum zone centre\n";
  const auto row = [&](const std::string& name, const FittedCircle& a, const FittedCircle& b) {
    text += fmt::format("  {:<22}{:>14.3f}  ({:+.2f}, {:+.2f}){:>12.3f}  ({:+.2f}, {:+.2f})\n", name,
                        a.width() / um, a.x / um, a.y / um, b.width() / um, b.x / um, b.y / um);
  };
  for (const CircularFigures& f : figures.directions)
    row(fmt::format("G {} ({:.0f} deg)", direction_name(f.direction), f.travel / deg), f.least_squares,
        f.minimum_zone);
  if (figures.both) row("G(b)", figures.least_squares_both, figures.minimum_zone_both);
  for (const CircularFigures& f : figures.directions)
    text += fmt::format("  F {:<20}{:>+14.3f} {:+.3f}   (centre as set up: {:+.3f} {:+.3f})\n",
                        direction_name(f.direction), f.f_max / um, f.f_min / um, f.f_max_set_up / um,
                        f.f_min_set_up / um);
  if (figures.both) text += fmt::format("  {:<22}{:>+14.3f}\n", "D", figures.mean_radial_deviation / um);
  return text;
}

std::string cause_text(const DiagnosisTerm& term) {
  return fmt::format("{}{}{}", to_string(term.kind), term.axis.empty() ? "" : " ", term.axis);
}

std::string_view judgement(const Diagnosis& d) {
  constexpr double kPicometre = 1e-9;  // mm: rounding
  if (d.spare < kFewestSpare) return "too few samples to judge it";
  if (d.residuals.largest < kPicometre) return "the causes explain everything";
  return d.residuals.white ? "noise" : "not only noise: some cause is not in this list";
}

std::string diagnosis_text(const Diagnosis& d) {
  if (!d.solved) return "\nthe numbers are too large for a diagnosis\n";
  std::string text =
      "\ncause                          value  standard uncertainty        largest radial effect, um\n";
  for (const DiagnosisTerm& term : d.terms) {
    const TermText shown = text_of(term);
    text += term.separable ? fmt::format("  {:<22}{:>12} {:>10} {:<10}{:>14.3f}\n", cause_text(term),
                                         shown.value, shown.uncertainty, shown.unit, term.effect / um)
                           : fmt::format("  {:<22}{:>12}\n", cause_text(term),
                                         "cannot be told from others by these runs");
  }
  for (std::size_t i = 0; i < 2; ++i)
    if (d.pitch[i])
      text += fmt::format("  pitch of the cyclic error of the {} axis {:.4f} mm ({})\n",
                          i == 0 ? "first" : "second", *d.pitch[i],
                          d.pitch_found[i] ? "found in the trace" : "given");
  if (d.spike_time) text += fmt::format("  reversal spikes decay in {:.1f} ms\n", *d.spike_time * 1e3);
  text += fmt::format("  unexplained: rms {:.3f} um, largest {:.3f} um; neighbours {:+.2f}, tau {:.1f}: {}\n",
                      d.residuals.rms / um, d.residuals.largest / um, d.residuals.lag_one, d.residuals.tau,
                      judgement(d));
  return text;
}

void write_circle(JsonWriter& json, std::string_view name, const FittedCircle& circle) {
  json.key(name).begin_object(Layout::one_line);
  json.member("found", circle.found).member("width_um", circle.width() / um);
  json.member("centre_um", std::array{circle.x / um, circle.y / um})
      .member("mean_um", circle.mean / um)
      .end();
}

void write_figures(JsonWriter& json, const TestFigures& figures) {
  json.key("figures").begin_object();
  json.key("directions").begin_array();
  for (const CircularFigures& f : figures.directions) {
    json.begin_object();
    json.member("direction", direction_name(f.direction)).member("travel_deg", f.travel / deg);
    json.member("samples", static_cast<std::uint64_t>(f.samples));
    write_circle(json, "G_least_squares", f.least_squares);
    write_circle(json, "G_minimum_zone", f.minimum_zone);
    json.member("F_um", std::array{f.f_max / um, f.f_min / um});
    json.member("F_set_up_um", std::array{f.f_max_set_up / um, f.f_min_set_up / um}).end();
  }
  json.end();
  if (figures.both) {
    write_circle(json, "Gb_least_squares", figures.least_squares_both);
    write_circle(json, "Gb_minimum_zone", figures.minimum_zone_both);
    json.member("D_um", figures.mean_radial_deviation / um);
  }
  json.end();
}

/// Values in mm, rad, s and their quotients.
void write_diagnosis(JsonWriter& json, const Diagnosis& d) {
  json.key("diagnosis").begin_object();
  json.member("solved", d.solved).key("causes").begin_array();
  for (const DiagnosisTerm& term : d.terms) {
    json.begin_object(Layout::one_line);
    json.member("cause", to_string(term.kind)).member("axis", term.axis).member("value", term.value);
    json.member("uncertainty", term.uncertainty).member("effect_um", term.effect / um);
    json.member("separable", term.separable).end();
  }
  json.end();
  json.key("pitch_mm").begin_array(Layout::one_line);
  for (const auto& pitch : d.pitch) pitch ? json.value(*pitch) : json.null();
  json.end();
  json.key("spike_time_s");
  d.spike_time ? json.value(*d.spike_time) : json.null();
  json.member("harmonic_only_servo_s", d.harmonic_only_servo);
  json.key("residuals").begin_object(Layout::one_line);
  json.member("rms_um", d.residuals.rms / um).member("largest_um", d.residuals.largest / um);
  json.member("lag_one", d.residuals.lag_one)
      .member("tau", d.residuals.tau)
      .member("white", d.residuals.white)
      .end();
  json.end();
}

void write_answer(JsonWriter& json, const Answer& answer) {
  const BallbarTest& test = answer.test;
  json.begin_object();
  json.member("file", test.file).member("plane", to_string(test.plane)).member("radius_mm", test.radius);
  json.member("feed_mm_per_min", test.feed * 60).member("runs", static_cast<std::uint64_t>(test.runs.size()));
  write_figures(json, answer.figures);
  write_diagnosis(json, answer.diagnosis);
  json.end();
}

void write_features(JsonWriter& json, const std::string& file, const B5rReport& report) {
  json.begin_object();
  json.member("file", file).member("test", report.test).member("machine", report.machine);
  json.member("date", report.date).member("plane", report.plane ? to_string(*report.plane) : "");
  json.key("features").begin_array();
  for (const B5rFeature& feature : report.features) {
    json.begin_object(Layout::one_line);
    json.member("name", feature.name).member("type", feature.type).member("value", feature.value);
    json.member("unit", feature.unit).end();
  }
  json.end().end();
}

std::string features_text(const std::string& file, const B5rReport& report) {
  std::string text = fmt::format("{}: {} on {}, {}; figures as the maker's program states them\n", file,
                                 report.test, report.machine, report.date);
  for (const B5rFeature& feature : report.features)
    text += fmt::format("  {:<32}{:>14.4f} {}\n", feature.name, feature.value,
                        feature.unit.empty() ? feature.type : feature.unit);
  return text;
}

/// --pitch X=5,Y=4 for the axes of the test's plane.
std::optional<DiagnosisOptions> diagnosis_options(const BallbarVerb& verb, TestPlane plane,
                                                  Session& session) {
  DiagnosisOptions options;
  options.find_pitch = options.find_spikes = !verb.no_search;
  Diagnostics findings;
  for (const Assignment& given : split_assignments("--pitch", verb.pitch, findings)) {
    const std::optional<double> pitch = option_number("--pitch", given.name, given.text, findings);
    if (!pitch) continue;
    const int axis = given.name.size() == 1 ? given.name[0] - 'X' : -1;
    if (axis < 0 || axis > 2 || *pitch <= 0)
      findings.push_back(
          option_error("--pitch", fmt::format("'{}={}'", given.name, given.text), "--pitch X=5,Y=5"));
    else if (axis == plane.first || axis == plane.second)
      options.pitch[axis == plane.first ? 0 : 1] = *pitch;
  }
  session.report(findings);
  if (has_errors(findings)) return std::nullopt;
  return options;
}

bool write_files(const BallbarVerb& verb, const std::vector<Answer>& answers, Session& session) {
  if (verb.svg.empty() && verb.out.empty()) return true;
  if (answers.size() != 1) {
    session.report(
        option_error(verb.svg.empty() ? "--out" : "--svg", "one file shows one test", "name one test"));
    return false;
  }
  const Answer& answer = answers.front();
  return write_outputs({{"--svg", verb.svg, figure_of_ballbar(answer.test, answer.figures, answer.diagnosis)},
                        {"--out", verb.out, write_ballbar(answer.test)}},
                       verb.source.files, session);
}

bool is_xml(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return first != std::string_view::npos && text[first] == '<';
}

void run_ballbar(const BallbarVerb& verb, Session& session) {
  const std::optional<BallbarDefaults> defaults = ballbar_defaults(verb.source, session);
  if (!defaults) return;
  if (!verb.bus.empty() && verb.source.files.size() != 1) {
    session.report(option_error("--bus", "one record belongs to one test", "name one test"));
    return;
  }
  std::vector<Answer> answers;
  std::vector<std::pair<std::string, B5rReport>> reports;
  for (const std::string& file : verb.source.files) {
    const std::optional<std::string> text = read_input(file, session);
    if (!text) continue;
    const std::string name = file == "-" ? "<stdin>" : file;
    if (is_xml(*text)) {
      Parsed<B5rReport> report = read_b5r(name, *text);
      session.report(report.diagnostics);
      if (report.value) reports.emplace_back(name, std::move(*report.value));
      continue;
    }
    Parsed<BallbarTest> test = read_ballbar(name, *text, *defaults);
    session.report(test.diagnostics);
    if (!test.value) continue;
    if (!verb.bus.empty()) test.value = with_bus(std::move(*test.value), verb.bus, session);
    if (!test.value) return;
    const auto options = diagnosis_options(verb, test.value->plane, session);
    if (!options) return;
    TestFigures figures = circular_figures(*test.value);
    Diagnosis diagnosis = diagnose(*test.value, *options);
    answers.push_back({std::move(*test.value), std::move(figures), std::move(diagnosis)});
  }
  if (answers.size() + reports.size() != verb.source.files.size() || !write_files(verb, answers, session))
    return;
  if (verb.json) {
    JsonWriter json;
    json.begin_object();
    json.member("format", 1).member("verb", "ballbar").key("tests").begin_array();
    for (const Answer& answer : answers) write_answer(json, answer);
    for (const auto& [file, report] : reports) write_features(json, file, report);
    json.end().end();
    session.out.write(json.take());
    return;
  }
  for (const Answer& answer : answers)
    session.out.write(conditions_text(answer.test) + figures_text(answer.figures) +
                      diagnosis_text(answer.diagnosis));
  for (const auto& [file, report] : reports) session.out.write(features_text(file, report));
}

}  // namespace

Verb ballbar_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("ballbar", "circular tests: ISO 230-4 figures and their causes");
  auto verb = std::make_shared<BallbarVerb>();
  command->add_option("FILE", verb->source.files, "ball-bar traces (CSV), or .b5r features")->required();
  add_ballbar_options(*command, verb->source);
  command->add_option("--pitch", verb->pitch, "screw pitches for cyclic errors: X=5,Y=5")->type_name("A=MM");
  command->add_flag("--no-search", verb->no_search, "do not look for cyclic errors and reversal spikes");
  command
      ->add_option("--bus", verb->bus,
                   "positions of the drives while it ran: CSV of `abbe capture`; --out gets them")
      ->type_name("FILE");
  command->add_option("--svg", verb->svg, "polar plot with causes (SVG)")->type_name("FILE");
  command->add_option("--out", verb->out, "the trace in the neutral format (CSV)")->type_name("FILE");
  command->add_flag("--json", verb->json, "JSON instead of text");
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [verb, &session] { run_ballbar(*verb, session); }};
}

}  // namespace abbe::app
