#include "abbe/machine/control_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/machine/read_profile.h"

namespace abbe {

std::shared_ptr<const Profile> profile_of(const ControlSetup& setup) {
  return setup.profile ? setup.profile : embedded_profile("linuxcnc");
}

namespace {

constexpr std::array<std::string_view, kFixedWorkOffsets> kNames{"G54", "G55",   "G56",   "G57",  "G58",
                                                                 "G59", "G59.1", "G59.2", "G59.3"};
constexpr int kMostFurther = 300;
/// G500, which has no offset of its own, among the further ones.
constexpr int kNoOffsetNumber = 100;

}  // namespace

std::string work_offset_label(int index) {
  if (index < kFixedWorkOffsets) return std::string(kNames[static_cast<std::size_t>(index)]);
  return fmt::format("G54.1 P{}", index - kFixedWorkOffsets + 1);
}

std::optional<int> tool_named(const std::map<int, ToolEntry>& tools, std::string_view name) {
  const std::string said = fmt::format("name=\"{}\"", name);
  for (const auto& [number, tool] : tools) {
    if (tool.comment.find(said) != std::string::npos) return number;
  }
  return std::nullopt;
}

std::optional<int> work_offset_index(std::string_view name) {
  const auto at = std::find(kNames.begin(), kNames.end(), name);
  if (at != kNames.end()) return static_cast<int>(at - kNames.begin());
  if (name == "G500") return kFixedWorkOffsets - 1 + kNoOffsetNumber;
  if (name.size() == 4 && name.starts_with("G5") && name >= "G505") {  // G505 .. G599
    const auto number = read_number(name.substr(2));
    if (number && *number == std::floor(*number)) return kFixedWorkOffsets - 1 + static_cast<int>(*number);
  }
  for (const std::string_view start : {"G54.1P", "G54.1 P", "G154P", "G154 P"}) {
    if (!name.starts_with(start)) continue;
    const auto number = read_number(name.substr(start.size()));
    if (!number || *number < 1 || *number > kMostFurther || *number != std::floor(*number))
      return std::nullopt;
    return kFixedWorkOffsets - 1 + static_cast<int>(*number);
  }
  return std::nullopt;
}

std::optional<double> cutter_radius(const ControlSetup& setup, int number) {
  if (const auto given = setup.radii.find(number); given != setup.radii.end()) return given->second;
  const auto entry = setup.tools.find(number);
  if (entry == setup.tools.end() || entry->second.diameter == 0) return std::nullopt;
  return entry->second.diameter / 2;
}

GaugeLength gauge_length(const ControlSetup& setup, const Machine& machine, std::optional<int> tool) {
  GaugeLength gauge;
  gauge.length = machine.tool.length;
  if (!tool) return gauge;
  if (const auto given = setup.gauges.find(*tool); given != setup.gauges.end()) {
    return {given->second, GaugeLength::Source::option, false};
  }
  const auto entry = setup.tools.find(*tool);
  if (entry == setup.tools.end()) return gauge;
  if (entry->second.gauge) return {*entry->second.gauge, GaugeLength::Source::table_comment, false};
  gauge.source = GaugeLength::Source::table_offset;
  const double z = entry->second.offset[2];
  gauge.touch_off = z < 0;
  if (!gauge.touch_off) gauge.length = z;
  return gauge;
}

}  // namespace abbe
