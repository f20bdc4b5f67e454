#pragma once

#include <optional>

#include "abbe/machine/machine.h"
#include "session.h"

namespace CLI {
class App;
}

namespace abbe::app {

/// --workpiece-temperature and --workpiece-ppm: both, or neither.
struct ExpansionArguments {
  std::optional<double> temperature, ppm;
};

void add_expansion_options(CLI::App& verb, ExpansionArguments& arguments);

/// The machine with the workpiece's expansion as errors, or as it was without the options; nullopt after
/// reporting why not.
[[nodiscard]] std::optional<Machine> expanded_or_report(const ExpansionArguments& arguments, Machine machine,
                                                        Session& session);

}  // namespace abbe::app
