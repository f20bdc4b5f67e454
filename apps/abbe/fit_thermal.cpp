#include "fit_thermal.h"

#include <fmt/core.h>

#include <algorithm>

#include "abbe/fit/drift_courses.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

Diagnostic about(const FitJob& job, Severity severity, const char* code, std::string message, std::string why,
                 std::string fix) {
  return {severity, code, {job.file, 0, 0, 1, {}}, std::move(message), std::move(why), std::move(fix)};
}

constexpr double kSensor = 0.1;  // K: as well as sensors agree, and as ranges are printed

const char* unit_of(const ThermalModel& model) { return model.rotation ? "urad" : "um"; }

std::string joined(const std::vector<std::string>& names, const char* separator) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : separator) + name;
  return text;
}

/// The files of the logs fitted, in the order of ThermalStart::log.
std::vector<std::string> fitted_files(const FitJob& job) {
  std::vector<std::string> out;
  for (const FitDrift& drift : job.drifts)
    if (!drift.validation) out.push_back(drift.file);
  return out;
}

void doubt_model(const FitJob& job, const ThermalModel& model, Session& session) {
  constexpr double kWorse = 2;
  const auto warn = [&](const char* code, std::string message, const char* why, const char* fix) {
    session.report(about(job, Severity::warning, code, std::move(message), why, fix));
  };
  if (model.misfit)
    warn("W-THERMAL-MODEL",
         fmt::format("{}: the model leaves {:.3g} {} rms, {:.1f} times the noise", model.name, model.left,
                     unit_of(model), model.left / std::max(model.noise, 1e-9)),
         "a heat source without a sensor, a lag, or a drift that is not of temperature",
         "add a sensor, model = \"lag\", or more sensors (most_sensors)");
  for (const std::string& sensor : model.undetermined)
    warn("W-THERMAL-START",
         fmt::format("{}: the part of {} cannot be told from the state in which the logs began", model.name,
                     sensor),
         "its temperature stepped as a log began and stayed: what follows dies away as an unknown start does",
         "log more changes of load; or start = \"settled\" if the machine had stood for hours");
  const double expected = std::max(model.left, model.noise);
  if (model.validated && *model.validated > kWorse * expected)
    warn("W-THERMAL-VALIDATION",
         fmt::format("{}: {:.3g} {} rms are left of logs that were not fitted, {:.3g} of those that were",
                     model.name, *model.validated, unit_of(model), model.left),
         "the model does not hold for other work of the machine",
         "fit logs of more kinds of work, or fewer sensors");
}

}  // namespace

std::optional<ThermalFit> thermal_or_report(const FitJob& job, Session& session) {
  const Parsed<std::vector<DriftCourse>> courses = drift_courses(job);
  session.report(courses.diagnostics);
  if (!courses.value) return std::nullopt;
  ThermalFit fit = fit_thermal(job.thermal, *courses.value);
  if (fit.finite) return fit;
  session.report(about(job, Severity::error, "E-RANGE", "the numbers are too large to calculate with", "",
                       "check the units of the logs"));
  return std::nullopt;
}

void report_thermal_doubts(const FitJob& job, const ThermalFit& fit, Session& session) {
  const auto warn = [&](const char* code, std::string message, std::string why, std::string fix_it) {
    session.report(
        about(job, Severity::warning, code, std::move(message), std::move(why), std::move(fix_it)));
  };
  for (const std::string& sensor : fit.still)
    warn("W-THERMAL-SENSOR", sensor + " did not change", "it explains nothing",
         "look whether it is connected");
  for (const std::string& sensor : fit.outside)
    warn("W-THERMAL-RANGE", sensor + " leaves the temperatures of the logs fitted in a log that judges",
         "there the model is not held back as it is in use, so it looks better or worse than it is",
         "fit a log that covers them");
  for (const ThermalModel& model : fit.models) {
    doubt_model(job, model, session);
    for (const ThermalTerm& term : model.terms)
      if (job.thermal.reference < term.lo - kSensor || job.thermal.reference > term.hi + kSensor)
        warn("W-THERMAL-RANGE",
             fmt::format("{}: the reference {:g} degC is outside {:.1f} to {:.1f} degC of {}", model.name,
                         job.thermal.reference, term.lo, term.hi, variable_of(term)),
             "what is zero there was never seen", "state a reference within the logs, or begin them colder");
  }
  const bool judged =
      std::any_of(job.drifts.begin(), job.drifts.end(), [](const FitDrift& d) { return d.validation; });
  if (!job.drifts.empty() && !judged)
    warn("W-THERMAL-VALIDATION", "no log only judges the model",
         "a fit always meets the logs it was made from", "keep one back: use = \"validation\"");
}

std::string thermal_text(const FitJob& job, const ThermalFit& fit) {
  if (fit.models.empty()) return {};
  const std::vector<std::string> files = fitted_files(job);
  std::string text = "\nthermal errors\n  sensors that say nearly the same:";
  for (const auto& group : fit.groups) text += " {" + joined(group, " ") + "}";
  text += '\n';
  for (const ThermalModel& model : fit.models) {
    text += fmt::format("  {:<6} drift {:8.3f} rms, left {:7.3f}, noise {:7.3f}", model.name, model.before,
                        model.left, model.noise);
    if (model.validated)
      text += fmt::format("; not fitted: {:.3f} of {:.3f}", *model.validated, *model.validated_before);
    text += fmt::format("   u {:.3f} {}\n", model.u, unit_of(model));
    for (const ThermalTerm& term : model.terms)
      text += fmt::format("           {:+9.4f} u {:.4f} {}/K  {:<24} {:6.1f} to {:6.1f} degC\n", term.slope,
                          term.u, unit_of(model), variable_of(term), term.lo, term.hi);
    if (model.terms.empty()) text += "           no sensor explains it\n";
    for (const ThermalStart& start : model.starts)
      text += fmt::format("           {:+9.3f} u {:.3f} {} left over when {} began, dying away in {:.0f} s\n",
                          start.value, start.u, unit_of(model), files[start.log], start.lag);
  }
  return text;
}

void write_thermal(JsonWriter& json, const FitJob& job, const ThermalFit& fit) {
  const std::vector<std::string> files = fitted_files(job);
  json.key("thermal").begin_object().key("groups").begin_array();
  for (const auto& group : fit.groups) json.begin_object(Layout::one_line).member("sensors", group).end();
  json.end().key("models").begin_array();
  for (const ThermalModel& model : fit.models) {
    json.begin_object().member("name", model.name).member("unit", unit_of(model));
    json.member("before_rms", model.before).member("left_rms", model.left).member("noise", model.noise);
    json.member("cross_validated_rms", model.crossed).member("u", model.u).member("misfit", model.misfit);
    if (model.validated)
      json.member("validation_before_rms", *model.validated_before)
          .member("validation_rms", *model.validated);
    json.key("terms").begin_array();
    for (const ThermalTerm& term : model.terms)
      json.begin_object(Layout::one_line)
          .member("variable", variable_of(term))
          .member("sensor", term.sensor)
          .member("lag_s", term.lag)
          .member("slope_per_K", term.slope)
          .member("u", term.u)
          .member("from_degC", term.lo)
          .member("to_degC", term.hi)
          .end();
    json.end().key("starts").begin_array();
    for (const ThermalStart& start : model.starts)
      json.begin_object(Layout::one_line)
          .member("file", files[start.log])
          .member("lag_s", start.lag)
          .member("value", start.value)
          .member("u", start.u)
          .end();
    json.end().member("undetermined", model.undetermined).end();
  }
  json.end().end();
}

}  // namespace abbe::app
