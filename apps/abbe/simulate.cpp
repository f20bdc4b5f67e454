#include "simulate.h"

#include <vector>

namespace abbe::app {

Verb simulate_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("simulate", "records of a machine that does not exist");
  command->require_subcommand(1);
  const std::vector<Verb> kinds = {
      simulate_capture_verb(*command, session), simulate_ballbar_verb(*command, session),
      simulate_measurements_verb(*command, session), simulate_drift_verb(*command, session)};
  return {command, [kinds] {
            for (const Verb& kind : kinds) {
              if (kind.command->parsed()) kind.run();
            }
          }};
}

}  // namespace abbe::app
