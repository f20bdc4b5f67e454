#include "abbe/machine/read_machine.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "abbe/machine/uncertainty_modes.h"

// A machine file, then after a zero byte an errors file, then after another one the bytes of every CSV
// file. Whatever they are: a value or an error, never both, and no number that is none.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void check(const abbe::Machine& machine) {
  require(machine.axis_count() <= abbe::kMaxAxes);
  require(machine.variables.size() >= static_cast<std::size_t>(machine.axis_count()));
  for (const abbe::Body& body : machine.bodies) {
    require(std::abs(body.direction.norm() - 1) < 1e-12 && body.origin.allFinite());
    require(!body.range || (*body.range)[0] < (*body.range)[1]);
  }
  require(machine.tool.origin.allFinite() && std::isfinite(machine.tool.length));
  require(std::abs(machine.tool.axis.norm() - 1) < 1e-12);
  const auto numbers = abbe::body_numbers(machine);
  require(numbers.size() == machine.bodies.size() + 3);
  const auto rows = abbe::lower_body_array(numbers);
  for (const int lower : rows.back()) require(lower == 0);
  require(abbe::error_inventory(machine).size() >= 6 * machine.axes.size());
  for (const double position : {-1e3, 0.0, 17.25, 1e6}) {
    const std::vector<double> variables(machine.variables.size(), position);
    const std::vector<signed char> approach(machine.variables.size(), 0);
    for (const abbe::ErrorTerm& term : machine.errors) {
      const double error = term.function.value<double>(variables.data(), approach.data(), nullptr);
      require(!std::isnan(error));
      if (term.uncertainty)
        require(!(term.uncertainty->value<double>(variables.data(), approach.data(), nullptr) < 0));
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::array<std::string, 3> parts;
  std::size_t part = 0;
  for (std::size_t i = 0; i < size; ++i) {
    if (data[i] == 0 && part + 1 < parts.size()) {
      ++part;
    } else {
      parts[part] += static_cast<char>(data[i]);
    }
  }
  std::optional<abbe::MachineText> errors;
  if (part >= 1 && !parts[1].empty()) errors = abbe::MachineText{"errors.toml", parts[1]};
  const auto fetch = [&](const std::string&) { return part == 2 ? std::optional(parts[2]) : std::nullopt; };

  const auto parsed = abbe::read_machine({"machine.toml", parts[0]}, errors, fetch);
  require(parsed.value.has_value() != abbe::has_errors(parsed.diagnostics));
  for (const abbe::Diagnostic& diagnostic : parsed.diagnostics) {
    require(!diagnostic.code.empty() && !diagnostic.place.file.empty() && !abbe::to_text(diagnostic).empty());
  }
  if (!parsed.value) return 0;
  check(*parsed.value);
  const abbe::MachineText text = errors ? *errors : abbe::MachineText{"machine.toml", parts[0]};
  const auto modes = abbe::read_uncertainty_modes(*parsed.value, text, fetch);
  require(modes.value.has_value() != abbe::has_errors(modes.diagnostics));
  return 0;
}
