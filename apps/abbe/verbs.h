#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "session.h"

namespace abbe::app {

/// A verb of the program: its part of the command line, and what it does once that is read.
struct Verb {
  CLI::App* command = nullptr;
  std::function<void()> run;
};

[[nodiscard]] Verb describe_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb predict_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb map_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb ballbar_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb identify_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb identifiability_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb correct_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb inverse_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb derive_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb cl_correct_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb signcheck_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb capture_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb filter_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb simulate_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb compensate_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb check_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb verify_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb machine_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb inspect_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb toolpath_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb diff_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb explain_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb profiles_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb evaluate_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb fit_verb(CLI::App& program, Session& session);
[[nodiscard]] Verb gear_verb(CLI::App& program, Session& session);

}  // namespace abbe::app
