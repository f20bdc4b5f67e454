#include "abbe/machine/sensor_section.h"

#include <fmt/format.h>

#include <algorithm>

#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {

std::vector<LaggedSensor> read_lagged_sensors(const TomlNode& root, const std::vector<Body>& bodies,
                                              Findings& findings) {
  std::vector<LaggedSensor> out;
  const TomlNode* table = find_table(root, "sensors", findings);
  if (table == nullptr) return out;
  for (const TomlEntry& entry : table->entries) {
    if (findings.full()) break;
    if (!expect_kind(entry.value, TomlNode::Kind::table, entry.key, findings)) continue;
    const bool is_axis = std::any_of(bodies.begin(), bodies.end(), [&](const Body& body) {
      return body.axis >= 0 && body.name == entry.key;
    });
    if (is_axis)
      findings.error("E-SENSOR-LAG", entry.mark, in_quotes(entry.key) + " is an axis of the chain",
                     "errors of that name depend on its position, never on a temperature",
                     "name the sensor otherwise, such as T_" + entry.key);
    refuse_other_keys(entry.value, {"of", "lag"}, entry.key, findings);
    const TomlEntry *of = entry.value.find("of"), *lag = entry.value.find("lag");
    if (of == nullptr || lag == nullptr) {
      findings.error("E-SENSOR-LAG", entry.mark, fmt::format("{} needs of and lag", in_quotes(entry.key)),
                     "it is another sensor, later", "{ of = \"T1\", lag = 1800 } with the lag in s");
      continue;
    }
    const auto source = read_text(of->value, "of", findings);
    const auto seconds = read_value(lag->value, "lag", findings);
    if (!source || !seconds) continue;
    if (!(*seconds > 0))
      findings.error("E-SENSOR-LAG", lag->value.mark, fmt::format("the lag of {} is not above 0", entry.key),
                     "heat does not arrive before it left", "state the time constant in s");
    if (*source == entry.key || table->find(*source) != nullptr)
      findings.error("E-SENSOR-LAG", of->value.mark,
                     fmt::format("{} is a lagged sensor itself", in_quotes(*source)),
                     "lags of lags are not followed", "name a sensor that is read");
    out.push_back({entry.key, *source, *seconds});
  }
  return out;
}

}  // namespace abbe
