#pragma once

#include "verbs.h"

namespace abbe::app {

/// The subcommands of `simulate`, one per file.
[[nodiscard]] Verb simulate_capture_verb(Command& simulate, Session& session);
[[nodiscard]] Verb simulate_ballbar_verb(Command& simulate, Session& session);
[[nodiscard]] Verb simulate_measurements_verb(Command& simulate, Session& session);
[[nodiscard]] Verb simulate_drift_verb(Command& simulate, Session& session);

}  // namespace abbe::app
