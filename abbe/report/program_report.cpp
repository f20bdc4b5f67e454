#include "abbe/report/program_report.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <string_view>
#include <tuple>

#include "abbe/core/diagnostic.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"

namespace abbe {
namespace {

using Layout = JsonWriter::Layout;

void write_facts(JsonWriter& json, std::string_view name, const std::string& file,
                 const ProgramFacts& facts) {
  json.key(name).begin_object();
  json.member("name", file).member("lines", facts.lines).member("bytes", facts.bytes);
  json.member("sha256", facts.sha256).end();
}

ProgramFacts input_facts(const ProgramReport& report) {
  if (report.verify != nullptr) return report.verify->original;
  if (report.rewrite != nullptr)
    return {report.rewrite->lines_in, report.rewrite->bytes_in, report.rewrite->sha256_in};
  return {};
}

void write_deviation(JsonWriter& json, std::string_view name, const DeviationSummary& summary) {
  json.key(name).begin_object();
  json.member("max_um", summary.max / um)
      .member("rms_um", summary.rms / um)
      .member("max_line", summary.max_line);
  json.member("max_component_um",
              Vec3(summary.max_component[0], summary.max_component[1], summary.max_component[2]) / um);
  json.end();
}

void write_machine(JsonWriter& json, const Machine& machine) {
  const Calibration& calibration = machine.calibration;
  json.key("machine").begin_object();
  json.member("name", machine.name).member("id", calibration.machine_id).member("sha256", machine.sha256);
  json.member("chain", machine.chain)
      .member("date", calibration.date)
      .member("valid_to", calibration.valid_to)
      .end();
  json.key("calibration").begin_object();
  json.member("date", calibration.date).member("machine_id", calibration.machine_id);
  json.member("valid_to", calibration.valid_to)
      .member("control_compensation", calibration.control_compensation);
  json.key("temperature_degc");
  if (calibration.temperature) {
    json.value(*calibration.temperature);
  } else {
    json.null();
  }
  json.end();
}

std::string_view model_name(ErrorModel model) {
  switch (model) {
    case ErrorModel::linear:
      return "linear";
    case ErrorModel::first_order:
      return "first-order";
    case ErrorModel::rigid:
      break;
  }
  return "rigid";
}

void write_settings(JsonWriter& json, const ProgramReport& report) {
  json.key("settings").begin_object();
  json.member("dialect", report.dialect).member("model", model_name(report.model));
  json.member("datum", report.datum == DatumRule::probed ? "probed" : "ideal")
      .member("reversal", report.reversal);
  json.member("tolerance_um", report.tolerance / um).member("max_correction_um", report.max_correction / um);
  json.key("environment").begin_object(Layout::one_line);
  for (const auto& [name, value] : report.environment) json.member(name, value);
  json.end();
  json.key("work_offsets").begin_array();
  for (std::size_t i = 0; i < report.setup.work_offsets.size(); ++i) {
    if (!report.setup.work_offsets[i]) continue;
    const WorkOffset& offset = *report.setup.work_offsets[i];
    json.begin_object(Layout::one_line);
    json.member("frame", work_offset_name(i))
        .member("origin_mm", Vec3(offset.origin[0], offset.origin[1], offset.origin[2]));
    json.member("rotation_rad", offset.rotation).end();
  }
  json.end();
  json.key("tools").begin_array();
  std::set<int> numbers;
  for (const auto& [number, entry] : report.setup.tools) numbers.insert(number);
  for (const auto& [number, gauge] : report.setup.gauges) numbers.insert(number);
  for (const int number : numbers) {
    json.begin_object(Layout::one_line);
    json.member("number", number);
    const auto entry = report.setup.tools.find(number);
    if (entry != report.setup.tools.end()) {
      const auto& offset = entry->second.offset;
      json.member("offset_mm", Vec3(offset[0], offset[1], offset[2]));
    }
    json.member("gauge_mm", gauge_length(report.setup, *report.machine, number).length).end();
  }
  json.end().end();
}

void write_datum(JsonWriter& json, const ProgramReport& report) {
  json.key("datum").begin_object();
  json.member("rule", report.datum == DatumRule::probed ? "probed" : "ideal");
  const bool some = report.verify != nullptr && !report.verify->datums.empty();
  json.member("removed_um", some ? Vec3(report.verify->datums.front().removed / um) : Vec3(Vec3::Zero()));
  json.key("frames").begin_array();
  if (some) {
    for (const DatumShift& datum : report.verify->datums) {
      json.begin_object(Layout::one_line);
      json.member("frame", datum.frame);
      json.key("tool");
      if (datum.tool >= 0) {
        json.value(datum.tool);
      } else {
        json.null();
      }
      json.member("removed_um", Vec3(datum.removed / um)).end();
    }
  }
  json.end().end();
}

/// Findings of both passes, each once, in the order of the program.
Diagnostics findings_of(const ProgramReport& report) {
  Diagnostics all;
  std::set<std::tuple<std::size_t, std::size_t, std::string, std::string>> seen;
  const auto add = [&](const Diagnostics& diagnostics) {
    for (const Diagnostic& d : diagnostics) {
      if (seen.emplace(d.place.line, d.place.column, d.code, d.message).second) all.push_back(d);
    }
  };
  if (report.rewrite != nullptr) add(report.rewrite->diagnostics);
  if (report.verify != nullptr) add(report.verify->diagnostics);
  std::stable_sort(all.begin(), all.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return a.place.line < b.place.line; });
  return all;
}

void write_findings(JsonWriter& json, std::string_view name, const Diagnostics& findings, Severity severity) {
  json.key(name).begin_array();
  for (const Diagnostic& d : findings) {
    if (d.severity != severity) continue;
    json.begin_object(Layout::one_line);
    json.member("code", d.code).member("line", static_cast<std::uint64_t>(d.place.line));
    json.member("column", static_cast<std::uint64_t>(d.place.column)).member("message", d.message).end();
  }
  json.end();
}

}  // namespace

std::string_view work_offset_name(std::size_t index) {
  static constexpr std::array<std::string_view, 9> kNames = {"G54", "G55",   "G56",   "G57",  "G58",
                                                             "G59", "G59.1", "G59.2", "G59.3"};
  return index < kNames.size() ? kNames[index] : std::string_view();
}

ProgramResult result_of(const ProgramReport& report) {
  const RewriteReport* rewrite = report.rewrite;
  const VerifyReport* verify = report.verify;
  if ((rewrite != nullptr && rewrite->stopped) || (verify != nullptr && verify->stopped))
    return ProgramResult::stopped;
  if (rewrite != nullptr && !rewrite->complete) {
    return rewrite->out_of_volume ? ProgramResult::outside : ProgramResult::refused;
  }
  if (verify == nullptr) return ProgramResult::refused;
  if (verify->agrees) return ProgramResult::verified;
  // A program the verifying reader does not understand is refused, not found wrong.
  const bool refused = std::any_of(
      verify->diagnostics.begin(), verify->diagnostics.end(),
      [](const Diagnostic& d) { return d.severity == Severity::error && d.code.starts_with("E-"); });
  return refused ? ProgramResult::refused : ProgramResult::disagrees;
}

std::string_view to_string(ProgramResult result) {
  switch (result) {
    case ProgramResult::refused:
      return "refused";
    case ProgramResult::outside:
      return "outside";
    case ProgramResult::disagrees:
      return "disagrees";
    case ProgramResult::stopped:
      return "stopped";
    case ProgramResult::verified:
      break;
  }
  return "verified";
}

std::string json_report(const ProgramReport& report) {
  JsonWriter json;
  json.begin_object();
  json.member("format", 1).member("verb", report.verb).member("abbe", report.program_version);
  json.member("result", to_string(result_of(report)));
  write_facts(json, "input", report.input_name, input_facts(report));
  if (report.verify != nullptr) {
    write_facts(json, "output", report.output_name, report.verify->output);
  } else {
    json.key("output").null();
  }
  write_machine(json, *report.machine);
  write_settings(json, report);
  if (report.verify != nullptr) {
    const VerifyReport& verify = *report.verify;
    write_deviation(json, "before", verify.before);
    write_deviation(json, "after", verify.after);
    json.member("quantisation_um", verify.quantisation / um).member("tolerance_um", report.tolerance / um);
    json.member("allowed_um", verify.allowed / um).member("lost_motion_um", verify.lost_motion / um);
    json.key("tool_axis").begin_object(Layout::one_line);
    json.member("before_max_urad", verify.direction_before / urad)
        .member("after_max_urad", verify.direction_after / urad)
        .end();
    json.key("compared").begin_object(Layout::one_line);
    json.member("feed_motions", verify.feed_motions).member("rapid_motions", verify.rapid_motions);
    json.member("points", verify.points)
        .member("events", verify.events)
        .member("feed_path_mm", verify.path_length)
        .end();
    if (report.limit) json.member("pass", verify.agrees && verify.after.max <= *report.limit);
  } else {
    for (const char* name : {"before", "after", "quantisation_um"}) json.key(name).null();
    json.member("tolerance_um", report.tolerance / um);
    if (report.limit) json.member("pass", false);
  }
  write_datum(json, report);
  if (report.rewrite != nullptr) {
    const RewriteReport& rewrite = *report.rewrite;
    json.key("blocks").begin_object(Layout::one_line);
    json.member("motion", rewrite.blocks.motion).member("rewritten", rewrite.blocks.rewritten);
    json.member("split", rewrite.blocks.split).member("passed", rewrite.blocks.passed);
    json.member("held", rewrite.held_blocks).end();
    json.key("arcs")
        .begin_object(Layout::one_line)
        .member("in", rewrite.arcs_in)
        .member("out", rewrite.arcs_out)
        .end();
    json.key("corrections").begin_object();
    const auto& most = rewrite.max_correction;
    json.member("max_um", Vec3(most[0], most[1], most[2]) / um);
    json.key("lines").begin_array(Layout::one_line);
    for (const std::uint64_t line : rewrite.max_line) json.value(line);
    json.end();
    // 1 mm/mm = 1e6 um/m
    json.member("max_gradient_um_per_m", rewrite.max_gradient / um * metre).end();
    json.member("cycle_residual_um", rewrite.cycle_residual / um);
    json.member("expanded_holes", rewrite.expanded_holes);
    json.member("shortest_split_mm", rewrite.shortest_split);
    json.member("shortest_split_ms", rewrite.shortest_split_time * 1e3);
    json.key("held_splits").begin_object(Layout::one_line);
    json.member("count", rewrite.held_splits).member("residual_um", rewrite.held_residual / um).end();
    json.member("cutter_radius_mm", rewrite.cutter_radius);
    json.member("cutter_residual_um", rewrite.cutter_residual / um);
    if (rewrite.sensitivity) {
      json.key("sensitivity").begin_object(Layout::one_line);
      json.member("offset_um_per_mm", rewrite.sensitivity->offset / um);
      json.member("length_um_per_mm", rewrite.sensitivity->length / um).end();
    }
  }
  const Diagnostics findings = findings_of(report);
  write_findings(json, "warnings", findings, Severity::warning);
  write_findings(json, "errors", findings, Severity::error);
  json.end();
  return json.take();
}

}  // namespace abbe
