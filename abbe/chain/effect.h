#pragma once

#include <string>
#include <vector>

#include "abbe/machine/machine.h"

namespace abbe {

/// Names of the machine's errors that change neither the tip nor the tool axis of the machine's own
/// tool anywhere, whatever their values: for example the rotation of a spindle about its own axis, or
/// a class that an explicit order leaves out. In file order, each once.
///
/// Numeric: the first-order effect of one unit of the component at fixed random poses within the
/// travels (unknown travels: 500 mm, half a turn), judged relative to the size of the machine.
[[nodiscard]] std::vector<std::string> errors_without_effect(const Machine& machine);

}  // namespace abbe
