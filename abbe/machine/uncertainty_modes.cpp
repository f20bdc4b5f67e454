#include "abbe/machine/uncertainty_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "abbe/machine/csv_tables.h"
#include "abbe/machine/error_section.h"
#include "abbe/machine/function_reader.h"
#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

/// A table of variables in which those of the machine have their places.
VariableTable known_variables(const Machine& machine, const FileUnits& units, Findings& findings) {
  VariableTable table(machine.bodies,
                      {units.length / machine.units.length, units.angle / machine.units.angle});
  for (const Variable& variable : machine.variables) {
    TomlNode name;
    name.kind = TomlNode::Kind::text;
    name.text = variable.name;
    (void)table.index_of(name, findings);
  }
  return table;
}

TomlNode as_errors(const TomlNode& mode) {
  TomlNode root;
  root.kind = TomlNode::Kind::table;
  root.entries.push_back({"errors", mode.mark, mode});
  return root;
}

bool has_value(const Machine& machine, const ErrorName& name) {
  return std::any_of(machine.errors.begin(), machine.errors.end(),
                     [&](const ErrorTerm& term) { return term.name == name; });
}

void add_own_modes(const Machine& machine, const std::set<std::string>& named, UncertaintyModes& out) {
  for (const ErrorTerm& term : machine.errors) {
    if (!term.uncertainty || named.count(to_string(term.name)) > 0) continue;
    ErrorTerm own = term;
    own.function = *term.uncertainty;
    own.uncertainty.reset();
    out.modes.push_back({std::move(own)});
  }
}

}  // namespace

Parsed<UncertaintyModes> read_uncertainty_modes(const Machine& machine, const MachineText& text,
                                                const FileFetcher& fetch) {
  Parsed<UncertaintyModes> out;
  Findings findings(text.file, text.text, out.diagnostics);
  const std::optional<TomlNode> root = read_toml(text.text, findings);
  if (!root) return out;
  const FileUnits units = read_units(*root, findings);
  VariableTable variables = known_variables(machine, units, findings);
  CsvTables tables(text.file, fetch, out.diagnostics);
  FunctionReader functions(variables, tables, units.angle, findings);
  UncertaintyModes modes;
  std::set<std::string> named;
  const TomlEntry* list = root->find("uncertainty_mode");
  if (list != nullptr && expect_kind(list->value, TomlNode::Kind::array, "uncertainty_mode", findings)) {
    for (const TomlNode& mode : list->value.items) {
      if (findings.full() || !expect_kind(mode, TomlNode::Kind::table, "uncertainty_mode", findings)) break;
      modes.modes.push_back(read_errors(as_errors(mode), machine.bodies, units, functions, findings).terms);
      for (const ErrorTerm& term : modes.modes.back()) {
        named.insert(to_string(term.name));
        if (!has_value(machine, term.name))
          findings.error("E-UNCERTAINTY", mode.mark,
                         fmt::format("uncertainty of {}, which has no value", to_string(term.name)),
                         "an uncertainty belongs to a stated error", "remove it, or state the error");
      }
    }
  }
  add_own_modes(machine, named, modes);
  modes.variables = variables.take();
  if (!has_errors(out.diagnostics)) out.value = std::move(modes);
  return out;
}

}  // namespace abbe
