#include "gear.h"

#include <variant>
#include <vector>

#include "common.h"

namespace abbe::app {
namespace {

constexpr int kRolls = 41;  // at which the wheel's contacts are kept

}  // namespace

std::optional<LoadedGear> load_gear(const std::string& path, Session& session) {
  const std::optional<std::string> text = read_input(path, session);
  if (!text) return std::nullopt;
  Parsed<GearJob> job = read_gear({path, *text});
  session.report(job.diagnostics);
  if (!job.value) return std::nullopt;
  auto wheel = fit_wheel(job.value->gear, job.value->wheel, even_rolls(job.value->gear, kRolls));
  // The reader has fitted it before.
  if (!std::holds_alternative<WheelInGap>(wheel)) return std::nullopt;
  return LoadedGear{std::move(*job.value), std::get<WheelInGap>(std::move(wheel))};
}

Verb gear_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand("gear", "gears: their flanks, how a machine cuts them, and back");
  command->require_subcommand(1);
  const std::vector<Verb> kinds = {gear_make_verb(*command, session), gear_cut_verb(*command, session),
                                   gear_sensitivity_verb(*command, session),
                                   gear_correct_verb(*command, session)};
  return {command, [kinds] {
            for (const Verb& kind : kinds) {
              if (kind.command->parsed()) kind.run();
            }
          }};
}

}  // namespace abbe::app
