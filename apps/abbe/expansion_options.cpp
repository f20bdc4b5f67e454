#include "expansion_options.h"

#include <fmt/core.h>

#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "abbe/machine/expansion.h"
#include "command_line.h"
#include "common.h"

namespace abbe::app {

void add_expansion_options(Command& verb, ExpansionArguments& arguments) {
  verb.add_option("--workpiece-temperature", arguments.temperature,
                  "of the part while it is machined, degC; its lengths are stated at 20 degC")
      ->check(finite_number())
      ->type_name("DEGC");
  verb.add_option("--workpiece-ppm", arguments.ppm,
                  "expansion of its material, 1e-6 per K (steel 11.5, aluminium 23)")
      ->check(finite_number())
      ->type_name("PPM");
}

namespace {

std::nullopt_t fail(const char* option, std::string message, std::string fix, Session& session) {
  Diagnostic error = option_error(option, std::move(message), std::move(fix));
  error.code = "E-EXPANSION";
  session.report(error);
  return std::nullopt;
}

}  // namespace

std::optional<WorkpieceExpansion> expansion_or_report(const ExpansionArguments& arguments, Session& session) {
  constexpr double kMostAway = 50, kLeastPpm = 0.1, kMostPpm = 100, kPpm = 1e-6;
  if (!arguments.given()) return WorkpieceExpansion{};
  if (!arguments.temperature || !arguments.ppm)
    return fail(arguments.ppm ? "--workpiece-ppm" : "--workpiece-temperature",
                "temperature and expansion of the workpiece go together", "give both, or neither", session);
  if (std::abs(*arguments.temperature - kStandardTemperature) > kMostAway)
    return fail("--workpiece-temperature",
                fmt::format("{:g} degC is far from 20 degC", *arguments.temperature),
                "expansion is linear near 20 degC only: check the number and its unit", session);
  // 1.15e-5 in place of 11.5 would pass for a part that does not expand.
  if (*arguments.ppm != 0 && (*arguments.ppm < kLeastPpm || *arguments.ppm > kMostPpm))
    return fail("--workpiece-ppm", fmt::format("{:g} ppm per K is no metal", *arguments.ppm),
                "state it in 1e-6 per K: 11.5 for steel, 0 for what does not expand", session);
  return WorkpieceExpansion{*arguments.temperature, *arguments.ppm * kPpm};
}

void add_to_environment(const ExpansionArguments& arguments, Environment& environment) {
  if (arguments.temperature) environment["workpiece degC"] = *arguments.temperature;
  if (arguments.ppm) environment["workpiece ppm/K"] = *arguments.ppm;
}

std::optional<Machine> expanded_or_report(const ExpansionArguments& arguments, Machine machine,
                                          Session& session) {
  if (!arguments.given()) return machine;
  const auto expansion = expansion_or_report(arguments, session);
  if (!expansion) return std::nullopt;
  auto expanded = with_expansion(machine, *expansion);
  if (auto* why = std::get_if<std::string>(&expanded))
    return fail("--workpiece-temperature", "this machine cannot follow the workpiece's expansion: " + *why,
                "machine at 20 degC, or scale the program", session);
  return std::move(std::get<Machine>(expanded));
}

}  // namespace abbe::app
