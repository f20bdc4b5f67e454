#pragma once

#include <optional>

#include "abbe/chain/plan.h"
#include "abbe/machine/expansion.h"
#include "abbe/machine/machine.h"
#include "session.h"

namespace abbe::app {

class Command;

/// --workpiece-temperature and --workpiece-ppm: both, or neither.
struct ExpansionArguments {
  std::optional<double> temperature, ppm;
  [[nodiscard]] bool given() const { return temperature || ppm; }
};

void add_expansion_options(Command& verb, ExpansionArguments& arguments);

/// The expansion asked for (none without the options: strain 0); nullopt after reporting why not.
[[nodiscard]] std::optional<WorkpieceExpansion> expansion_or_report(const ExpansionArguments& arguments,
                                                                    Session& session);

/// States what was given in the head of a program.
void add_to_environment(const ExpansionArguments& arguments, Environment& environment);

/// The machine with the workpiece's expansion as errors, or as it was without the options; nullopt after
/// reporting why not.
[[nodiscard]] std::optional<Machine> expanded_or_report(const ExpansionArguments& arguments, Machine machine,
                                                        Session& session);

}  // namespace abbe::app
