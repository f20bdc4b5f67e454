#include "abbe/gear/gear_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

/// A table of the file whose numbers are read one by one.
class Table {
 public:
  Table(const TomlNode& root, const char* name, const std::vector<std::string>& keys, Findings& findings)
      : name_(name), findings_(findings), table_(find_table(root, name, findings)) {
    if (table_ != nullptr) refuse_other_keys(*table_, keys, fmt::format("[{}]", name), findings);
  }

  /// value = unit * number of the file, if the key is there.
  template <class Number>
  void number(const char* key, double unit, Number& value) const {
    const TomlEntry* entry = find(key);
    const auto read =
        entry != nullptr ? read_quantity(entry->value, unit, what(key), findings_) : std::nullopt;
    if (read) value = *read;
  }

  /// The same, between two limits in the units of the file.
  template <class Number>
  void number(const char* key, double unit, double low, double high, Number& value) const {
    const TomlEntry* entry = find(key);
    const auto read = entry != nullptr ? read_value(entry->value, what(key), findings_) : std::nullopt;
    if (!read) return;
    if (*read >= low && *read <= high) {
      value = *read * unit;
    } else {
      complain("E-GEAR-VALUE", key,
               fmt::format("{} is {:g}, not between {:g} and {:g}", what(key), *read, low, high));
    }
  }

  void needed(const char* key, double unit, double& value) const {
    if (find(key) == nullptr) {
      missing(key, "= .. (a number)");
    } else {
      number(key, unit, value);
    }
  }

  void whole(const char* key, int low, int high, int& value, bool is_needed = false) const {
    const TomlEntry* entry = find(key);
    if (entry == nullptr) {
      if (is_needed) missing(key, "= .. (a whole number)");
      return;
    }
    if (const auto read = whole_number(entry->value, what(key), low, high)) value = *read;
  }

  [[nodiscard]] std::optional<int> whole_number(const TomlNode& node, const std::string& name, int low,
                                                int high) const {
    if (!expect_kind(node, TomlNode::Kind::number, name, findings_)) return std::nullopt;
    if (node.is_integer && node.integer >= low && node.integer <= high) return static_cast<int>(node.integer);
    findings_.error("E-GEAR-VALUE", node.mark,
                    fmt::format("{} is not a whole number from {} to {}", name, low, high), "",
                    "correct the number");
    return std::nullopt;
  }

  void complain(const char* code, const char* key, std::string message, const char* why = "",
                const char* fix = "correct the number") const {
    const TomlEntry* entry = find(key);
    const Mark mark = entry != nullptr ? entry->value.mark : table_ != nullptr ? table_->mark : Mark{};
    findings_.error(code, mark, std::move(message), why, fix);
  }

  void missing(const char* key, const char* fix) const {
    findings_.error("E-MISSING-KEY", table_ != nullptr ? table_->mark : Mark{},
                    fmt::format("[{}] does not say {}", name_, key), "", fmt::format("{} {}", key, fix));
  }

  [[nodiscard]] const TomlEntry* find(const char* key) const {
    return table_ != nullptr ? table_->find(key) : nullptr;
  }
  [[nodiscard]] std::string what(const char* key) const { return fmt::format("{}.{}", name_, key); }
  [[nodiscard]] Findings& findings() const { return findings_; }

 private:
  std::string name_;
  Findings& findings_;
  const TomlNode* table_;
};

GearSpec read_spec(const Table& gear, const Table& modifications) {
  GearSpec spec;
  if (const TomlEntry* entry = gear.find("name"))
    spec.name = read_text(entry->value, "gear.name", gear.findings()).value_or("");
  gear.needed("module", mm, spec.module);
  gear.whole("teeth", 5, 2000, spec.teeth, true);
  gear.number("pressure_angle", deg, spec.pressure_angle);
  gear.number("helix_angle", deg, spec.helix_angle);
  if (const TomlEntry* entry = gear.find("hand")) {
    const auto hand = read_choice(entry->value, {"right", "left"}, "gear.hand", gear.findings());
    spec.hand = hand == std::size_t{1} ? -1 : 1;
  } else if (spec.helix_angle > 0) {
    gear.missing("hand", "= \"right\" or \"left\"");
  }
  gear.number("profile_shift", 1, spec.profile_shift);
  gear.needed("face_width", mm, spec.face_width);
  gear.number("addendum", 1, spec.addendum);
  gear.number("dedendum", 1, spec.dedendum);
  gear.number("tip_diameter", mm, spec.tip_diameter);
  gear.number("root_diameter", mm, spec.root_diameter);
  gear.number("form_diameter", mm, spec.form_diameter);
  modifications.number("tip_relief", um, spec.tip_relief);
  modifications.number("tip_relief_length", mm, spec.tip_relief_length);
  modifications.number("profile_crowning", um, spec.profile_crowning);
  modifications.number("helix_crowning", um, spec.helix_crowning);
  return spec;
}

void read_cutting(const Table& table, CuttingSpec& cutting) {
  constexpr double kPerMinute = 1.0 / 60;
  table.number("middle", mm, -1e5, 1e5, cutting.middle);
  table.number("first_gap", deg, -360, 360, cutting.first_gap);
  table.number("overrun", mm, 0, 1e3, cutting.overrun);
  table.number("clearance", mm, 0.1, 1e3, cutting.clearance);
  table.number("feed", kPerMinute, 0.1, 1e5, cutting.feed);
  table.number("index_time", 1, 0, 1e4, cutting.index_time);
}

void read_evaluation(const Table& table, int teeth, GearJob& job) {
  EvaluationSpec& evaluation = job.evaluation;
  table.number("profile_part", 1, 0.1, 1, evaluation.profile_part);
  table.number("helix_end_part", 1, 0, 0.45, evaluation.helix_end_part);
  table.number("helix_end_modules", 1, 0, 100, evaluation.helix_end_modules);
  int tolerance_class = 0;
  table.whole("class", 1, 11, tolerance_class);
  if (tolerance_class > 0) job.tolerance_class = tolerance_class;
  const TomlEntry* list = table.find("teeth");
  if (list == nullptr ||
      !expect_kind(list->value, TomlNode::Kind::array, "evaluation.teeth", table.findings()))
    return;
  for (const TomlNode& item : list->value.items)
    if (const auto tooth = table.whole_number(item, "evaluation.teeth", 1, teeth))
      job.teeth.push_back(*tooth);
}

/// An impossible gear, at the key that makes it so.
void complain(const GearProblem& problem, const Table& gear, const Table& modifications) {
  const Table& table = modifications.find(problem.key.c_str()) != nullptr ? modifications : gear;
  const char* const key = problem.key.c_str();
  switch (problem.trouble) {
    case GearTrouble::value:
      return table.complain("E-GEAR-VALUE", key, problem.message);
    case GearTrouble::undercut:
      return table.complain("E-GEAR-UNDERCUT", key, problem.message,
                            "below the base circle there is no involute",
                            "more teeth or profile shift, or state form_diameter where the flank begins");
    case GearTrouble::pointed:
      return table.complain("E-GEAR-POINTED", key, problem.message, "the tooth would have no tip",
                            "a smaller tip_diameter, or less profile_shift");
    case GearTrouble::no_gap:
      return table.complain("E-GEAR-GAP", key, problem.message, "no wheel fits between the flanks",
                            "less profile_shift, or a larger form_diameter");
    case GearTrouble::order:
      return table.complain("E-GEAR-ORDER", key, problem.message,
                            "root, form, reference and tip follow each other outwards",
                            "correct the diameters");
  }
}

void complain(const WheelProblem& problem, const Table& wheel) {
  const char* const key = problem.key.c_str();
  switch (problem.trouble) {
    case WheelTrouble::value:
      return wheel.complain("E-GEAR-VALUE", key, problem.message);
    case WheelTrouble::larger:
      return wheel.complain("E-GEAR-WHEEL", key, problem.message,
                            "it would cut both flanks away, or miss their ends", "another wheel");
    case WheelTrouble::mesh:
      return wheel.complain("E-GEAR-MESH", key, problem.message,
                            "such a flank cannot be made with this wheel",
                            "another diameter or swivel, or a larger form_diameter");
  }
}

}  // namespace

Parsed<GearJob> read_gear(const MachineText& file) {
  Parsed<GearJob> out;
  Findings findings(file.file, file.text, out.diagnostics);
  const std::optional<TomlNode> root = read_toml(file.text, findings);
  if (!root) return out;
  check_format(*root, findings);
  refuse_other_keys(*root, {"format", "gear", "modifications", "wheel", "cutting", "evaluation"},
                    "a gear file", findings);
  const Table gear(*root, "gear",
                   {"name", "module", "teeth", "pressure_angle", "helix_angle", "hand", "profile_shift",
                    "face_width", "addendum", "dedendum", "tip_diameter", "root_diameter", "form_diameter"},
                   findings);
  const Table modifications(*root, "modifications",
                            {"tip_relief", "tip_relief_length", "profile_crowning", "helix_crowning"},
                            findings);
  const Table wheel(*root, "wheel", {"diameter", "tip_width", "width", "swivel"}, findings);
  const Table cutting(*root, "cutting", {"middle", "first_gap", "overrun", "clearance", "feed", "index_time"},
                      findings);
  const Table evaluation(*root, "evaluation",
                         {"class", "teeth", "profile_part", "helix_end_part", "helix_end_modules"}, findings);
  GearJob job;
  job.file = file.file;
  const GearSpec spec = read_spec(gear, modifications);
  wheel.needed("diameter", mm, job.wheel.diameter);
  wheel.number("tip_width", mm, job.wheel.tip_width);
  wheel.number("width", mm, job.wheel.width);
  wheel.number("swivel", deg, job.wheel.swivel);
  read_cutting(cutting, job.cutting);
  read_evaluation(evaluation, spec.teeth, job);
  if (has_errors(out.diagnostics)) return out;

  const auto made = make_gear(spec);
  if (const auto* problem = std::get_if<GearProblem>(&made)) {
    complain(*problem, gear, modifications);
    return out;
  }
  job.gear = std::get<Gear>(made);
  const auto fitted = fit_wheel(job.gear, job.wheel, {});
  if (const auto* problem = std::get_if<WheelProblem>(&fitted)) {
    complain(*problem, wheel);
    return out;
  }
  out.value = std::move(job);
  return out;
}

}  // namespace abbe
