#pragma once

#include <vector>

#include "abbe/machine/control_model.h"
#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// Reads [control] and [control.axis.*]. `bodies` are those of the chain, in its order.
[[nodiscard]] ControlModel read_control(const TomlNode& root, const std::vector<Body>& bodies,
                                        const FileUnits& units, Findings& findings);

/// Reports names in `corrects` that no error of the machine has.
void check_corrected_errors(const TomlNode& root, const Machine& machine, Findings& findings);

}  // namespace abbe
