#include "abbe/machine/read_machine.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "abbe/core/file.h"
#include "abbe/machine/axis_section.h"
#include "abbe/machine/chain_text.h"
#include "abbe/machine/control_section.h"
#include "abbe/machine/csv_tables.h"
#include "abbe/machine/error_section.h"
#include "abbe/machine/function_reader.h"
#include "abbe/machine/machine_sections.h"
#include "abbe/machine/sensor_section.h"
#include "abbe/machine/toml_document.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

// Larger tables belong into CSV files. A syntax tree takes some 50 times the size of its text.
constexpr std::size_t kLargestMachineFile = std::size_t{1} << 24;
constexpr std::size_t kLargestCsvFile = std::size_t{1} << 26;

const std::vector<std::string> kMachineTables{"format", "machine",     "units",       "axis",
                                              "tool",   "workpiece",   "calibration", "control",
                                              "errors", "uncertainty", "sensors",     "uncertainty_mode"};
const std::vector<std::string> kErrorTables{"format",      "units",   "calibration",     "errors",
                                            "uncertainty", "sensors", "uncertainty_mode"};

std::optional<TomlNode> read_document(const MachineText& text, Findings& findings) {
  if (text.text.size() > kLargestMachineFile) {
    findings.error("E-FILE", {}, fmt::format("{} bytes are too many for this kind of file", text.text.size()),
                   "", "move the tables into CSV files: { csv = \"table.csv\" }");
    return std::nullopt;
  }
  return read_toml(text.text, findings);
}

std::optional<std::vector<ChainElement>> read_identity(const TomlNode& root, Machine& machine,
                                                       Findings& findings) {
  const TomlNode* table = find_table(root, "machine", findings);
  if (table == nullptr) {
    if (root.find("machine") == nullptr) {
      findings.error("E-MISSING-KEY", Mark{1, 1, 1}, "no [machine]", "it holds the chain of axes",
                     "add [machine] with chain = \"w X b Y Z t\"");
    }
    return std::nullopt;
  }
  refuse_other_keys(*table, {"name", "chain"}, "[machine]", findings);
  if (const auto* name = table->find("name")) {
    machine.name = read_text(name->value, "machine.name", findings).value_or("");
  }
  const TomlEntry* chain = table->find("chain");
  if (chain == nullptr) {
    findings.error("E-MISSING-KEY", table->mark, "no chain in [machine]",
                   "it says which axes carry the workpiece and which the tool",
                   "add chain = \"w X b Y Z t\"");
    return std::nullopt;
  }
  if (chain->value.kind == TomlNode::Kind::text) machine.chain = chain->value.text;
  return read_chain(chain->value, findings);
}

/// In the order of the files and their lines.
void sort_by_place(Diagnostics& diagnostics, const std::vector<std::string>& files) {
  const auto key = [&](const Diagnostic& finding) {
    const auto file = std::find(files.begin(), files.end(), finding.place.file) - files.begin();
    return std::tuple(file, finding.place.line, finding.place.column);
  };
  std::stable_sort(diagnostics.begin(), diagnostics.end(),
                   [&](const Diagnostic& a, const Diagnostic& b) { return key(a) < key(b); });
}

/// The errors of another machine would be applied with full confidence.
void compare_machine_ids(const Calibration& machine, const Calibration& errors, const TomlNode& errors_root,
                         Findings& findings) {
  if (machine.machine_id.empty() || errors.machine_id.empty() || machine.machine_id == errors.machine_id)
    return;
  const TomlEntry* calibration = errors_root.find("calibration");
  const TomlEntry* id = calibration == nullptr ? nullptr : calibration->value.find("machine_id");
  findings.warning("W-MACHINE-ID", id == nullptr ? Mark{} : id->value.mark,
                   fmt::format("these errors are of machine {}, the machine file describes {}",
                               in_quotes(errors.machine_id), in_quotes(machine.machine_id)),
                   "errors of one machine make another one worse", "use the errors file of this machine");
}

Parsed<Machine> unreadable(const std::string& path, const FileError& error) {
  Diagnostics diagnostics;
  Findings(path, {}, diagnostics)
      .error("E-FILE", {}, error.message, "", error.missing ? "check the path" : "name a readable file");
  return {std::nullopt, std::move(diagnostics)};
}

}  // namespace

Parsed<Machine> read_machine(const MachineText& machine_text, const std::optional<MachineText>& errors_text,
                             const FileFetcher& fetch) {
  Parsed<Machine> out;
  Machine machine;
  // Everything the errors are read from: machine file, errors file, then CSV tables as they are named.
  Sha256 sha;
  sha.add(machine_text.text);
  if (errors_text) sha.add(errors_text->text);
  const FileFetcher hashed_fetch = [&](const std::string& path) {
    auto bytes = fetch ? fetch(path) : std::nullopt;
    if (bytes) sha.add(*bytes);
    return bytes;
  };
  machine.files.push_back(machine_text.file);
  if (errors_text) machine.files.push_back(errors_text->file);

  Findings findings(machine_text.file, machine_text.text, out.diagnostics);
  std::optional<Findings> separate;
  if (errors_text) separate.emplace(errors_text->file, errors_text->text, out.diagnostics);
  Findings& error_findings = separate ? *separate : findings;

  const auto root = read_document(machine_text, findings);
  const auto errors_file = errors_text ? read_document(*errors_text, error_findings) : std::nullopt;
  const bool readable = root && (!errors_text || errors_file);

  if (root) {
    check_format(*root, findings);
    refuse_other_keys(*root, kMachineTables, "a machine file", findings);
    machine.units = read_units(*root, findings);
    machine.calibration = read_calibration(*root, findings);
  }
  FileUnits error_units = machine.units;
  if (errors_file) {
    check_format(*errors_file, error_findings);
    refuse_other_keys(*errors_file, kErrorTables, "an errors file", error_findings);
    error_units = read_units(*errors_file, error_findings);
    // The machine file's calibration speaks of the errors that are replaced.
    const Calibration calibration = read_calibration(*errors_file, error_findings);
    compare_machine_ids(machine.calibration, calibration, *errors_file, error_findings);
    machine.calibration = calibration;
  }

  const auto chain = root ? read_identity(*root, machine, findings) : std::nullopt;
  if (root) machine.workpiece_origin = read_workpiece_origin(*root, machine.units, findings);
  AxisSection axes;
  if (root && chain) {
    axes = read_axes(*root, *chain, machine.units, findings);
    machine.bodies = axes.bodies;
    for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
      if (machine.bodies[i].axis >= 0) machine.axes.push_back(static_cast<int>(i));
    }
  }
  if (root && chain) machine.control = read_control(*root, machine.bodies, machine.units, findings);
  if (root) machine.tool = read_tool(*root, machine.units, machine.bodies, findings);

  if (readable && chain) {
    VariableTable variables(
        machine.bodies, {error_units.length / machine.units.length, error_units.angle / machine.units.angle});
    CsvTables tables(error_findings.file(), hashed_fetch, out.diagnostics);
    FunctionReader functions(variables, tables, error_units.angle, error_findings);
    ErrorSection errors = read_errors(errors_file ? *errors_file : *root, machine.bodies, error_units,
                                      functions, error_findings);
    machine.errors = std::move(errors.terms);
    machine.variables = variables.take();
    machine.lagged_sensors =
        read_lagged_sensors(errors_file ? *errors_file : *root, machine.bodies, error_findings);
    machine.files.insert(machine.files.end(), tables.files().begin(), tables.files().end());
    check_errors(machine, axes.notes, errors.notes, findings, error_findings);
    check_corrected_errors(*root, machine, findings);
  }

  sort_by_place(out.diagnostics, machine.files);
  if (has_errors(out.diagnostics)) return out;
  machine.sha256 = sha.hex();
  out.value = std::move(machine);
  return out;
}

Parsed<Machine> read_machine_file(const std::string& machine_path,
                                  const std::optional<std::string>& errors_path) {
  auto machine = read_file(machine_path, kLargestMachineFile);
  if (const auto* error = std::get_if<FileError>(&machine)) return unreadable(machine_path, *error);
  std::optional<MachineText> errors;
  if (errors_path) {
    auto text = read_file(*errors_path, kLargestMachineFile);
    if (const auto* error = std::get_if<FileError>(&text)) return unreadable(*errors_path, *error);
    errors = MachineText{*errors_path, std::move(std::get<std::string>(text))};
  }
  const auto fetch = [](const std::string& path) -> std::optional<std::string> {
    auto bytes = read_file(path, kLargestCsvFile);
    if (auto* text = std::get_if<std::string>(&bytes)) return std::move(*text);
    return std::nullopt;
  };
  return read_machine({machine_path, std::move(std::get<std::string>(machine))}, errors, fetch);
}

}  // namespace abbe
