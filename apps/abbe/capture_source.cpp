#include "capture_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "abbe/capture/read_map.h"
#include "abbe/core/number.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr const char* kAxisForm =
    "write X=1001:10000/mm: name, station address of the drive, counts per mm or deg";

/// X=1001:10000/mm
std::optional<ServoAxis> read_axis(const Assignment& given) {
  const std::size_t colon = given.text.find(':'), slash = given.text.find('/', colon);
  if (colon == std::string::npos || slash == std::string::npos) return std::nullopt;
  const auto station = read_number(given.text.substr(0, colon));
  const auto counts = read_number(given.text.substr(colon + 1, slash - colon - 1));
  ServoAxis axis;
  axis.name = given.name;
  axis.unit = given.text.substr(slash + 1);
  if (!station || !counts || *station < 1 || *station > 65535 || std::floor(*station) != *station ||
      *counts == 0 || !std::isfinite(1 / *counts) || (axis.unit != "mm" && axis.unit != "deg"))
    return std::nullopt;
  axis.station = static_cast<std::uint16_t>(*station);
  axis.counts_per_unit = *counts;
  return axis;
}

bool read_axes(const std::vector<std::string>& options, std::vector<ServoAxis>& axes, Session& session) {
  Diagnostics diagnostics;
  for (const Assignment& given : split_assignments("--axis", options, diagnostics)) {
    const auto axis = read_axis(given);
    if (!axis) {
      diagnostics.push_back(
          option_error("--axis", fmt::format("'{}={}' is not an axis", given.name, given.text), kAxisForm));
      continue;
    }
    const auto same =
        std::find_if(axes.begin(), axes.end(), [&](const ServoAxis& a) { return a.name == axis->name; });
    // What is typed wins over what is stored.
    if (same != axes.end()) {
      *same = *axis;
    } else {
      axes.push_back(*axis);
    }
  }
  for (std::size_t i = 0; i < axes.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (axes[i].station == axes[k].station)
        diagnostics.push_back(option_error(
            "--axis",
            fmt::format("{} and {} name the same drive {}", axes[k].name, axes[i].name, axes[i].station),
            "swapped axes would be taken for errors of the machine: give each its own drive"));
    }
  }
  session.report(diagnostics);
  return !has_errors(diagnostics);
}

Diagnostic no_map(const std::string& file, std::string message) {
  Diagnostic d;
  d.code = "E-CAPTURE-MAP";
  d.place.file = file;
  d.message = std::move(message);
  d.why = "the frames do not say which bits are which signal";
  d.fix = "give --eni FILE or a --map FILE with objects, or record from before the master starts the slaves";
  return d;
}

}  // namespace

void add_map_options(Command& verb, MapArguments& arguments) {
  verb.add_option("--map", arguments.map, "map file (TOML): axes with their drives, places of signals")
      ->type_name("FILE");
  verb.add_option("--eni", arguments.eni, "network information of the master (XML): places of signals")
      ->type_name("FILE");
  verb.add_option("--axis", arguments.axes, "an axis, its drive and its counts: X=1001:10000/mm")
      ->type_name("NAME=STATION:COUNTS/UNIT,..")
      ->allow_extra_args(false);
}

std::optional<GivenMap> load_map(const MapArguments& arguments, Session& session) {
  GivenMap given;
  if (!arguments.map.empty()) {
    const auto text = read_input(arguments.map, session);
    if (!text) return std::nullopt;
    const Parsed<MapFile> file = read_map(arguments.map == "-" ? "<stdin>" : arguments.map, *text);
    session.report(file.diagnostics);
    if (!file.value) return std::nullopt;
    given.axes = file.value->axes;
    if (!file.value->map.objects.empty()) given.layout = file.value->map;
  }
  if (!arguments.eni.empty()) {
    if (given.layout) {
      session.report(option_error("--eni", "the map file lists objects, too", "give the layout once"));
      return std::nullopt;
    }
    const auto text = read_input(arguments.eni, session);
    if (!text) return std::nullopt;
    Parsed<ProcessMap> eni = read_eni(arguments.eni == "-" ? "<stdin>" : arguments.eni, *text);
    session.report(eni.diagnostics);
    if (!eni.value) return std::nullopt;
    given.layout = std::move(eni.value);
  }
  if (!read_axes(arguments.axes, given.axes, session)) return std::nullopt;
  return given;
}

ProcessMap learned_map(const CaptureSurvey& survey, Diagnostics& findings) {
  ProcessMap learned = map_of(survey.slaves, findings);
  learned.origin = kLearned;
  return learned;
}

std::optional<ProcessMap> map_for(const GivenMap& given, const CaptureSurvey& survey, const std::string& file,
                                  Session& session) {
  if (given.layout) return named(*given.layout, given.axes);
  Diagnostics findings;
  ProcessMap learned = learned_map(survey, findings);
  for (Diagnostic& d : findings) d.place.file = file;
  session.report(findings);
  if (learned.objects.empty()) {
    session.report(no_map(file, "the start-up of the slaves is not in this capture, and no map is given"));
    return std::nullopt;
  }
  if (const auto mistake = map_mistake(learned)) {
    session.report(no_map(file, "the start-up traffic contradicts itself: " + *mistake));
    return std::nullopt;
  }
  return named(std::move(learned), given.axes);
}

}  // namespace abbe::app
