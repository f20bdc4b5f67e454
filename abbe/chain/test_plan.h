#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "abbe/chain/plan.h"
#include "abbe/machine/read_machine.h"

/// Machine files of tests as plans.
namespace abbe::testing {

/// Three axes without errors.
inline const char* const kPerfect = R"(format = 1
[machine]
name = "perfect"
chain = "w b X Y Z t"
[axis.X]
[axis.Y]
[axis.Z]
)";

/// The text must be a machine file without mistakes.
inline Plan plan_of(const std::string& text) {
  auto machine =
      read_machine({"m.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  if (!machine.value) {
    for (const Diagnostic& d : machine.diagnostics) ADD_FAILURE() << to_text(d);
    std::abort();
  }
  return std::get<Plan>(make_plan(*machine.value, {}));
}

}  // namespace abbe::testing
