#include "abbe/machine/control_setup.h"

#include <algorithm>
#include <string_view>

#include "abbe/machine/read_profile.h"

namespace abbe {

std::shared_ptr<const Profile> profile_of(const ControlSetup& setup) {
  return setup.profile ? setup.profile : embedded_profile("linuxcnc");
}

std::optional<int> work_offset_index(std::string_view name) {
  constexpr std::array<std::string_view, 9> kNames{"G54", "G55",   "G56",   "G57",  "G58",
                                                   "G59", "G59.1", "G59.2", "G59.3"};
  const auto at = std::find(kNames.begin(), kNames.end(), name);
  if (at == kNames.end()) return std::nullopt;
  return static_cast<int>(at - kNames.begin());
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
