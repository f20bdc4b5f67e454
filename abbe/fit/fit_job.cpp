#include "abbe/fit/fit_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "abbe/fit/job_reader.h"
#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

/// The machine that the job names; nullopt after reporting why not.
std::optional<Machine> read_job_machine(const TomlNode& root, const std::string& folder,
                                        const FileFetcher& fetch, Findings& findings, Diagnostics& out) {
  const TomlEntry* entry = root.find("machine");
  if (entry == nullptr) {
    findings.error("E-MISSING-KEY", {}, "the key machine is missing", "errors belong to a machine",
                   "machine = \"mill.toml\"");
    return std::nullopt;
  }
  const auto name = read_text(entry->value, "machine", findings);
  if (!name) return std::nullopt;
  const std::string path = (std::filesystem::path(folder) / *name).string();
  auto bytes = fetch ? fetch(path) : std::nullopt;
  if (!bytes) {
    findings.error("E-CSV-FILE", entry->value.mark, "cannot read " + in_quotes(path),
                   "the path is relative to the folder of this file",
                   "correct the path, or put the file there");
    return std::nullopt;
  }
  Parsed<Machine> machine = read_machine({path, std::move(*bytes)}, std::nullopt, fetch);
  // Its errors are not used, so what is said about them would mislead.
  for (Diagnostic& diagnostic : machine.diagnostics)
    if (diagnostic.severity == Severity::error) out.push_back(std::move(diagnostic));
  return std::move(machine.value);
}

/// Logs that are all kept back, or none at all, would leave thermal errors out without a word.
void check_drifts(const FitJob& job, Findings& findings) {
  const bool fitted = std::any_of(job.drifts.begin(), job.drifts.end(),
                                  [](const FitDrift& drift) { return !drift.validation; });
  if (fitted || (job.drifts.empty() && job.thermal.errors.empty())) return;
  findings.error("E-JOB-EMPTY", {},
                 job.drifts.empty() ? "[thermal] asks for errors, and there is no [[drift]]"
                                    : "every [[drift]] only judges",
                 "there is no log to fit", "add a [[drift]] without use = \"validation\"");
}

template <class Read>
void read_entries(const TomlNode& root, const char* key, Findings& findings, const Read& read) {
  const TomlEntry* entry = root.find(key);
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::array, key, findings)) return;
  for (const TomlNode& item : entry->value.items)
    if (expect_kind(item, TomlNode::Kind::table, key, findings)) read(item);
}

int read_most_order(const TomlNode& root, int otherwise, Findings& findings) {
  constexpr double kMost = 12;
  const TomlEntry* entry = root.find("most_order");
  if (entry == nullptr) return otherwise;
  const auto order = abbe::read_value(entry->value, "most_order", findings);
  if (order && *order >= 1 && *order <= kMost) return static_cast<int>(*order);
  if (order)
    findings.error("E-JOB-VALUE", entry->value.mark, fmt::format("most_order is {:g}", *order),
                   "high orders swing between the targets", "write 1 to 12");
  return otherwise;
}

void read_job_entries(const TomlNode& root, JobReader& reader, Findings& findings) {
  if (const TomlNode* table = find_table(root, "reference", findings)) reader.read_reference(*table);
  if (const TomlNode* table = find_table(root, "functions", findings)) reader.read_functions(*table);
  if (const TomlEntry* entry = root.find("locations")) reader.read_locations(entry->value);
  if (const TomlNode* table = find_table(root, "thermal", findings)) reader.read_thermal(*table);
  read_entries(root, "drift", findings, [&](const TomlNode& entry) { reader.read_drift(entry); });
  read_entries(root, "square", findings, [&](const TomlNode& entry) { reader.read_square(entry); });
  read_entries(root, "run", findings, [&](const TomlNode& entry) { reader.read_run(entry); });
  read_entries(root, "diagonal", findings, [&](const TomlNode& entry) { reader.read_diagonal(entry); });
  read_entries(root, "points", findings, [&](const TomlNode& entry) { reader.read_points(entry, false); });
  read_entries(root, "ball", findings, [&](const TomlNode& entry) { reader.read_points(entry, true); });
  read_entries(root, "value", findings, [&](const TomlNode& entry) { reader.read_value(entry); });
}

}  // namespace

const FitFunction* FitJob::find_function(std::string_view name) const {
  const auto found =
      std::find_if(functions.begin(), functions.end(), [&](const FitFunction& f) { return f.name == name; });
  return found == functions.end() ? nullptr : &*found;
}

const FitSquare* FitJob::find_square(std::string_view name) const {
  const auto found =
      std::find_if(squares.begin(), squares.end(), [&](const FitSquare& s) { return s.name == name; });
  return found == squares.end() ? nullptr : &*found;
}

namespace {

Parsed<FitJob> read_job(const MachineText& text, const FileFetcher& fetch,
                        const std::optional<MeasurementPlan>& plan) {
  Parsed<FitJob> out;
  Findings findings(text.file, text.text, out.diagnostics);
  const std::optional<TomlNode> root = read_toml(text.text, findings);
  if (!root) return out;
  check_format(*root, findings);
  refuse_other_keys(*root,
                    {"format", "machine", "units", "calibration", "reference", "functions", "most_order",
                     "locations", "run", "diagonal", "points", "ball", "value", "square", "thermal", "drift"},
                    "a job", findings);
  const std::string folder = std::filesystem::path(text.file).parent_path().string();
  FitJob job;
  job.file = text.file;
  job.files = {text.file};
  std::optional<Machine> machine = read_job_machine(*root, folder, fetch, findings, out.diagnostics);
  if (!machine) return out;
  job.machine = std::move(*machine);
  job.files.insert(job.files.end(), job.machine.files.begin(), job.machine.files.end());
  job.calibration = read_calibration(*root, findings);
  job.most_order = read_most_order(*root, job.most_order, findings);
  JobReader reader(job, read_units(*root, findings), folder, fetch, plan, findings, out.diagnostics);
  read_job_entries(*root, reader, findings);
  if (!has_errors(out.diagnostics) && job.runs.empty() && job.diagonals.empty() && job.points.empty() &&
      job.values.empty() && job.drifts.empty())
    findings.error("E-JOB-EMPTY", {}, "nothing was measured", "there is nothing to fit",
                   "add [[run]], [[diagonal]], [[points]], [[ball]], [[drift]] or [[value]]");
  if (!has_errors(out.diagnostics)) check_drifts(job, findings);
  if (!has_errors(out.diagnostics)) out.value = std::move(job);
  return out;
}

}  // namespace

Parsed<FitJob> read_fit_job(const MachineText& job, const FileFetcher& fetch) {
  return read_job(job, fetch, std::nullopt);
}

Parsed<FitJob> plan_fit_job(const MachineText& job, const FileFetcher& fetch, const MeasurementPlan& plan) {
  return read_job(job, fetch, plan);
}

}  // namespace abbe
