#pragma once

#include <vector>

#include "abbe/machine/findings.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// Reads [sensors]: spindle_slow = { of = "spindle", lag = 1830 } (lag in s). `of` is a sensor that is read,
/// not a lagged one, and the entry is no axis of the chain.
/// errors   E-SENSOR-LAG, besides those of every table
[[nodiscard]] std::vector<LaggedSensor> read_lagged_sensors(const TomlNode& root,
                                                            const std::vector<Body>& bodies,
                                                            Findings& findings);

}  // namespace abbe
