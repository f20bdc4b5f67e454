#include <fmt/core.h>

#include <array>
#include <memory>
#include <string>

#include "abbe/chain/solve_path.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "number_check.h"
#include "point_source.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::size_t kWriteAt = std::size_t{1} << 16;

struct CorrectArguments {
  CommonArguments common;
  PointArguments points;
  std::string method = "newton";
  std::vector<std::string> lock, weights;
  double max_rotary_correction_deg = 0.5;
  bool path = false;
};

/// --weights X=2,A=0.5: what moving an axis costs, for redundant axes.
std::array<double, kMaxAxes> read_weights(const Machine& machine, const std::vector<std::string>& weights,
                                          Diagnostics& diagnostics) {
  std::array<double, kMaxAxes> values{};
  for (const Assignment& given : split_assignments("--weights", weights, diagnostics)) {
    const int axis = machine.find_axis(given.name);
    const std::optional<double> value = option_number("--weights", given.name, given.text, diagnostics);
    if (axis < 0) {
      diagnostics.push_back(option_error("--weights",
                                         fmt::format("this chain has no moving axis '{}'", given.name),
                                         suggestion(machine, given.name)));
    } else if (value && !(*value > 0)) {
      diagnostics.push_back(option_error("--weights",
                                         fmt::format("the weight of '{}' is not positive", given.name),
                                         "an axis that shall not move at all is named with --lock"));
    } else if (value) {
      values[static_cast<std::size_t>(axis)] = *value;
    }
  }
  return values;
}

/// How many points ended how, and what is left at worst.
struct Tally {
  std::array<std::uint64_t, 4> by_status{};
  std::uint64_t points = 0, passed = 0;
  double max_distance = 0, max_angle = 0;
  std::string first_failed, first_degraded, first_partial;
  std::uint64_t outside_calibration = 0, outside_travels = 0;
  std::string first_outside_calibration, first_outside_travels;

  void add(const Correction& correction, const std::vector<std::string>& outside, bool pass,
           const std::string& where) {
    ++points;
    if (correction.outside && outside_calibration++ == 0) first_outside_calibration = where;
    if (!outside.empty() && outside_travels++ == 0) first_outside_travels = where;
    if (pass) ++passed;
    ++by_status[static_cast<std::size_t>(correction.status)];
    max_distance = std::max(max_distance, correction.residual_position);
    max_angle = std::max(max_angle, correction.residual_direction);
    std::string* first = correction.status == Status::failed     ? &first_failed
                         : correction.status == Status::degraded ? &first_degraded
                         : correction.status == Status::partial  ? &first_partial
                                                                 : nullptr;
    if (first != nullptr && first->empty()) *first = where;
  }
  [[nodiscard]] std::uint64_t count(Status status) const {
    return by_status[static_cast<std::size_t>(status)];
  }
};

void report_tally(const Tally& tally, Session& session) {
  const auto finding = [&](Severity severity, const char* code, const std::string& where,
                           std::string message) {
    Diagnostic diagnostic;
    diagnostic.severity = severity;
    diagnostic.code = code;
    diagnostic.place.file = where;
    diagnostic.message = std::move(message);
    return diagnostic;
  };
  if (const std::uint64_t n = tally.count(Status::failed); n > 0) {
    Diagnostic failed =
        finding(Severity::error, "E-CORRECT", tally.first_failed,
                fmt::format("no correction found for {} of {} points, the first here", n, tally.points));
    failed.why = "the iteration did not settle; the command is given back unchanged";
    session.report(failed, Exit::refused);
  }
  if (tally.outside_calibration > 0) {
    Diagnostic outside =
        finding(Severity::error, "E-VOL", tally.first_outside_calibration,
                fmt::format("{} of {} points are outside the calibrated volume, the first here",
                            tally.outside_calibration, tally.points));
    outside.why = "an error was held at the end of its table, where nobody has measured";
    session.report(outside, Exit::outside);
  }
  if (tally.outside_travels > 0) {
    session.report(finding(Severity::error, "E-TRAVEL", tally.first_outside_travels,
                           fmt::format("{} of {} points are outside the travels, the first here",
                                       tally.outside_travels, tally.points)),
                   Exit::outside);
  }
  if (const std::uint64_t n = tally.count(Status::degraded); n > 0) {
    Diagnostic degraded = finding(
        Severity::warning, "W-DEGRADED", tally.first_degraded,
        fmt::format("an axis was held at its command for {} of {} points, the first here", n, tally.points));
    degraded.why =
        "the correction would leave the travel, or, near a singularity, turn a rotary axis far for a small "
        "tilt";
    degraded.fix = "see residual.direction; --max-rotary-correction sets how far a rotary axis may be moved";
    session.report(degraded);
  }
  if (const std::uint64_t n = tally.count(Status::partial); n > 0) {
    Diagnostic partial = finding(
        Severity::warning, "W-PARTIAL", tally.first_partial,
        fmt::format("only a part of the position can be corrected for {} of {} points, the first here", n,
                    tally.points));
    partial.why =
        fmt::format("an axis is missing or locked; up to {:.3f} um remain", tally.max_distance / um);
    session.report(partial);
  }
}

void write_json_point(JsonWriter& json, const Setting& setting, const Query& query,
                      const Correction& correction, const std::vector<std::string>& outside, bool pass) {
  json.begin_object(Layout::one_line);
  write_positions(json, "commanded", setting.machine, query.q);
  write_positions(json, "corrected", setting.machine, correction.corrected);
  json.key("residual").begin_object();
  json.member("position_mm", correction.residual_position)
      .member("direction_rad", correction.residual_direction)
      .end();
  json.member("status", abbe::to_string(correction.status)).member("iterations", correction.iterations);
  json.member("outside_calibration", correction.outside).member("outside_travel", outside);
  std::vector<std::string> held;
  for (int i = 0; i < setting.machine.axis_count(); ++i) {
    if ((correction.held >> i & 1U) != 0) held.push_back(setting.machine.axis(i).name);
  }
  json.member("held", held);
  if (setting.limits.given()) json.member("pass", pass);
  json.end();
}

/// Correction of one axis for people: um, or urad and arcsec.
std::string change_text(const Body& axis, double change) {
  if (axis.type == AxisType::rotary) {
    return fmt::format("{:>+14.3f} urad  = {:+.3f} arcsec", change / urad, change / arcsec);
  }
  return fmt::format("{:>+14.3f} um", change / um);
}

std::string block_text(const Setting& setting, const Query& query, const Correction& correction,
                       const std::vector<std::string>& outside, bool pass) {
  const Machine& machine = setting.machine;
  std::string text = fmt::format("machine      {} ({} model, {} errors)\n\n", machine.name,
                                 to_string(setting.model), machine.errors.size());
  text += fmt::format("{:<6}{:>18}{:>18}{:>5}{:>14}\n", "axis", "commanded", "corrected", "", "change");
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const auto k = static_cast<std::size_t>(i);
    const bool rotary = axis.type == AxisType::rotary;
    text += fmt::format("{:<6}{:>18.{}f}{:>18.{}f} {:<4}{}{}\n", axis.name, json_position(axis, query.q[k]),
                        rotary ? 8 : 6, json_position(axis, correction.corrected[k]), rotary ? 8 : 6,
                        rotary ? "deg" : "mm", change_text(axis, correction.corrected[k] - query.q[k]),
                        (correction.held >> i & 1U) != 0 ? "  held" : "");
  }
  text += fmt::format("\nstatus       {} after {} iterations\n", abbe::to_string(correction.status),
                      correction.iterations);
  text += fmt::format("remains      {:.6f} um, tool axis {:.3f} urad = {:.3f} arcsec\n",
                      correction.residual_position / um, correction.residual_direction / urad,
                      correction.residual_direction / arcsec);
  if (correction.outside)
    text += "outside      the calibrated volume: an error was held beyond its last value\n";
  if (!outside.empty()) {
    text += "outside      the travel of";
    for (const std::string& name : outside) text += " " + name;
    text += "\n";
  }
  if (setting.limits.given()) text += fmt::format("limits       {}\n", pass ? "pass" : "FAIL");
  return text;
}

std::string table_heading(const Setting& setting) {
  std::string text;
  for (int i = 0; i < setting.machine.axis_count(); ++i) {
    const Body& axis = setting.machine.axis(i);
    const bool rotary = axis.type == AxisType::rotary;
    text += fmt::format("{:>15}{:>13}", fmt::format("{} {}", axis.name, rotary ? "deg" : "mm"),
                        fmt::format("d{} {}", axis.name, rotary ? "urad" : "um"));
  }
  return text + fmt::format("{:>13}{:>12}  status\n", "remains um", "tilt urad");
}

std::string table_row(const Setting& setting, const Query& query, const Correction& correction,
                      const std::vector<std::string>& outside, bool pass) {
  std::string text;
  for (int i = 0; i < setting.machine.axis_count(); ++i) {
    const Body& axis = setting.machine.axis(i);
    const auto k = static_cast<std::size_t>(i);
    const bool rotary = axis.type == AxisType::rotary;
    text += fmt::format("{:>15.6f}{:>+13.3f}", json_position(axis, correction.corrected[k]),
                        (correction.corrected[k] - query.q[k]) / (rotary ? urad : um));
  }
  text += fmt::format("{:>13.6f}{:>12.3f}  {}", correction.residual_position / um,
                      correction.residual_direction / urad, abbe::to_string(correction.status));
  if (setting.limits.given()) text += pass ? "  pass" : "  FAIL";
  if (correction.outside) text += "  outside the calibrated volume";
  for (std::size_t i = 0; i < outside.size(); ++i) text += (i == 0 ? "  outside travel: " : " ") + outside[i];
  return text + '\n';
}

void correct_points(const CorrectArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_controlled_setting(arguments.common, session);
  if (!setting) return;
  Diagnostics diagnostics;
  CorrectOptions options;
  options.method = method_of(arguments.method);
  options.max_rotary_correction = arguments.max_rotary_correction_deg * deg;
  options.locked = read_lock(setting->machine, arguments.lock, diagnostics);
  options.weights = read_weights(setting->machine, arguments.weights, diagnostics);
  session.report(diagnostics);
  if (has_errors(diagnostics)) return;
  std::optional<AxisSet> free = free_axes_or_report(setting->machine, options.locked, session);
  if (!free) return;
  // A weight asks for an axis that the rule for redundant ones would lock.
  for (int i = 0; i < setting->machine.axis_count(); ++i) {
    const AxisSet bit = AxisSet{1} << i;
    if (options.weights[static_cast<std::size_t>(i)] > 0 && setting->machine.axis(i).correctable &&
        !(options.locked & bit)) {
      *free |= bit;
    }
  }
  if (!method_fits_or_report(*setting, options.method, *free, session)) return;
  std::optional<PointSource> source = PointSource::open(arguments.points, *setting, session);
  if (!source) return;
  PathOptions path_options;
  path_options.free = *free;
  path_options.correction = options;
  PathSolver path(path_options, {});

  const bool as_json = arguments.common.json;
  JsonWriter json;
  if (as_json) {
    json.begin_object();
    write_preamble(json, "correct", setting->machine);
    json.member("model", to_string(setting->model))
        .member("method", arguments.method)
        .key("points")
        .begin_array();
  } else if (!source->single()) {
    session.out.write(table_heading(*setting));
  }

  Tally tally;
  ProgressBar bar("correct", as_json && !source->single());
  while (!interrupted() && session.out.ok() && source->next(session)) {
    Query query = source->query();
    const Correction correction =
        arguments.path ? path.command(source->plan(), query) : correct(source->plan(), query, *free, options);
    std::vector<std::string> outside = outside_travel(setting->machine, query.q);
    if (outside.empty()) outside = outside_travel(setting->machine, correction.corrected);
    const bool pass = correction.status != Status::failed &&
                      setting->limits.pass(correction.residual_position, correction.residual_direction);
    tally.add(correction, outside, pass, source->where());
    if (as_json) {
      write_json_point(json, *setting, query, correction, outside, pass);
      if (json.pending() > kWriteAt) session.out.write(json.take());
    } else if (source->single()) {
      session.out.write(block_text(*setting, query, correction, outside, pass));
    } else {
      session.out.write(table_row(*setting, query, correction, outside, pass));
    }
    bar.show(source->bytes_read(), source->bytes_total());
  }

  const bool complete = !interrupted() && !session.has(Exit::invalid) && !session.has(Exit::internal);
  report_tally(tally, session);
  const bool pass = tally.passed == tally.points;
  if (session.strict && setting->limits.given() && !pass) session.note(Exit::warnings);
  if (as_json) {
    json.end();
    json.key("summary").begin_object(Layout::one_line);
    json.member("points", tally.points);
    for (const Status status : {Status::ok, Status::partial, Status::degraded, Status::failed}) {
      json.member(abbe::to_string(status), tally.count(status));
    }
    json.member("max_residual_um", tally.max_distance / um).member("max_residual_rad", tally.max_angle).end();
    if (arguments.path) write_path(json, setting->machine, path.report());
    if (setting->limits.given()) json.member("pass", pass && complete);
    json.member("complete", complete).end();
    session.out.write(json.take());
  } else if (!source->single() && complete && tally.points > 0) {
    session.out.write(fmt::format(
        "\n{} points: {} ok, {} partial, {} degraded, {} failed; at most {:.6f} um and {:.3f} urad remain\n",
        tally.points, tally.count(Status::ok), tally.count(Status::partial), tally.count(Status::degraded),
        tally.count(Status::failed), tally.max_distance / um, tally.max_angle / urad));
    if (arguments.path) session.out.write(path_text(setting->machine, path.report()));
    if (setting->limits.given()) {
      session.out.write(fmt::format("{}: {} of {} points within the limits\n", pass ? "pass" : "FAIL",
                                    tally.passed, tally.points));
    }
  }
}

}  // namespace

Verb correct_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("correct", "commands that bring the tool where it was meant to be");
  auto arguments = std::make_shared<CorrectArguments>();
  add_common_options(*command, arguments->common, session);
  add_point_options(*command, arguments->points);
  add_method_option(*command, arguments->method);
  command->add_flag("--path", arguments->path,
                    "the points follow each other: rotary axes go on instead of jumping by a turn");
  command->add_option("--lock", arguments->lock, "axes that stay at their command: Z1,B1")
      ->type_name("AXIS,..")
      ->allow_extra_args(false);
  command
      ->add_option("--weights", arguments->weights,
                   "redundant axes: sum (weight dq)^2 is least, dq in mm and rad: X=1,U=3")
      ->type_name("AXIS=WEIGHT,..")
      ->allow_extra_args(false);
  command
      ->add_option("--max-rotary-correction", arguments->max_rotary_correction_deg,
                   "beyond it a rotary axis is held at its command (0.5)")
      ->check(above_zero())
      ->type_name("DEG");
  return {command, [arguments, &session] { correct_points(*arguments, session); }};
}

}  // namespace abbe::app
