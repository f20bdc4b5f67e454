#pragma once

#include <functional>

#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// A verb of the program: its part of the command line, and what it does once that is read.
struct Verb {
  Command* command = nullptr;
  std::function<void()> run;
};

[[nodiscard]] Verb describe_verb(Command& program, Session& session);
[[nodiscard]] Verb predict_verb(Command& program, Session& session);
[[nodiscard]] Verb map_verb(Command& program, Session& session);
[[nodiscard]] Verb ballbar_verb(Command& program, Session& session);
[[nodiscard]] Verb identify_verb(Command& program, Session& session);
[[nodiscard]] Verb identifiability_verb(Command& program, Session& session);
[[nodiscard]] Verb correct_verb(Command& program, Session& session);
[[nodiscard]] Verb inverse_verb(Command& program, Session& session);
[[nodiscard]] Verb derive_verb(Command& program, Session& session);
[[nodiscard]] Verb cl_correct_verb(Command& program, Session& session);
[[nodiscard]] Verb signcheck_verb(Command& program, Session& session);
[[nodiscard]] Verb capture_verb(Command& program, Session& session);
[[nodiscard]] Verb filter_verb(Command& program, Session& session);
[[nodiscard]] Verb simulate_verb(Command& program, Session& session);
[[nodiscard]] Verb compensate_verb(Command& program, Session& session);
[[nodiscard]] Verb check_verb(Command& program, Session& session);
[[nodiscard]] Verb verify_verb(Command& program, Session& session);
[[nodiscard]] Verb machine_verb(Command& program, Session& session);
[[nodiscard]] Verb inspect_verb(Command& program, Session& session);
[[nodiscard]] Verb toolpath_verb(Command& program, Session& session);
[[nodiscard]] Verb diff_verb(Command& program, Session& session);
[[nodiscard]] Verb explain_verb(Command& program, Session& session);
[[nodiscard]] Verb profiles_verb(Command& program, Session& session);
[[nodiscard]] Verb evaluate_verb(Command& program, Session& session);
[[nodiscard]] Verb fit_verb(Command& program, Session& session);
[[nodiscard]] Verb gear_verb(Command& program, Session& session);

}  // namespace abbe::app
