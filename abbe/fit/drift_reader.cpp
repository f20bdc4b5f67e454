// Entries [thermal] and [[drift]] of a job.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "abbe/fit/job_reader.h"
#include "abbe/machine/error_body.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

constexpr std::size_t kLeastTimes = 10;
constexpr double kColdest = -40, kHottest = 150;  // degC

/// A list of texts; empty after reporting that it is none.
std::vector<std::string> texts_of(const TomlNode& list, const char* key, Findings& findings) {
  std::vector<std::string> out;
  if (!expect_kind(list, TomlNode::Kind::array, key, findings)) return out;
  for (const TomlNode& item : list.items)
    if (auto text = read_text(item, key, findings)) out.push_back(std::move(*text));
  return out;
}

/// The name of a sensor as machine files accept it.
bool is_sensor_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !name.empty() && letter(name.front()) && std::all_of(name.begin(), name.end(), [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

void JobReader::read_thermal(const TomlNode& table) {
  FitThermal& thermal = job_.thermal;
  refuse_other_keys(table,
                    {"errors", "sensors", "reference", "model", "selection", "most_sensors", "correlated"},
                    "[thermal]", findings_);
  if (const TomlEntry* found = table.find("errors")) {
    thermal.errors = texts_of(found->value, "errors", findings_);
    for (std::string& text : thermal.errors) {
      const auto name = read_error_name(text);
      const bool known = name && name->error_class != ErrorClass::location &&
                         name->error_class != ErrorClass::dynamic && body_of(job_.machine, *name);
      if (!known)
        findings_.error("E-JOB-ERROR", found->value.mark,
                        in_quotes(text) + " is no error that a temperature moves",
                        "drift belongs to a body of the chain",
                        "write T, direction, body: TXS, TZZ, TAS; or E for tool and work: EXt");
      if (known) text = to_string(*name);
    }
  }
  if (const TomlEntry* found = table.find("sensors")) {
    thermal.sensors = texts_of(found->value, "sensors", findings_);
    std::vector<std::string> sorted = thermal.sensors;
    std::sort(sorted.begin(), sorted.end());
    if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
      findings_.error("E-JOB-VALUE", found->value.mark, "a sensor is named twice", "", "name each once");
  }
  if (const TomlEntry* found = table.find("reference"))
    thermal.reference = abbe::read_value(found->value, "reference", findings_).value_or(thermal.reference);
  if (const TomlEntry* found = table.find("model"))
    thermal.model = static_cast<FitThermal::Model>(
        read_choice(found->value, {"auto", "linear", "lag"}, "model", findings_).value_or(0));
  if (const TomlEntry* found = table.find("selection"))
    thermal.selection = static_cast<FitThermal::Selection>(
        read_choice(found->value, {"stepwise", "ridge", "all"}, "selection", findings_).value_or(0));
  const auto within = [&](const char* key, double lo, double hi, double otherwise) {
    const TomlEntry* found = table.find(key);
    if (found == nullptr) return otherwise;
    const auto value = abbe::read_value(found->value, key, findings_);
    if (value && *value >= lo && *value <= hi) return *value;
    if (value)
      findings_.error("E-JOB-VALUE", found->value.mark, fmt::format("{} is {:g}", key, *value), "",
                      fmt::format("write {:g} to {:g}", lo, hi));
    return otherwise;
  };
  thermal.most_sensors = static_cast<int>(within("most_sensors", 1, 8, thermal.most_sensors));
  thermal.correlated = within("correlated", 0.5, 1, thermal.correlated);
  thermal.reference = within("reference", kColdest, kHottest, thermal.reference);
}

std::optional<DriftReading> JobReader::drift_reading(const TomlEntry& entry) {
  DriftReading out;
  out.column = entry.key;
  if (!expect_kind(entry.value, TomlNode::Kind::table, entry.key, findings_)) return std::nullopt;
  refuse_other_keys(entry.value, {"direction", "optic", "measured_at", "sign"}, entry.key, findings_);
  const TomlEntry* direction = entry.value.find("direction");
  if (direction == nullptr) {
    findings_.error("E-MISSING-KEY", entry.mark, "the key direction is missing",
                    "a sensor looks along an axis, or at a tilt about one", "direction = \"X\"");
    return std::nullopt;
  }
  const auto choice = read_choice(direction->value, {"X", "Y", "Z", "A", "B", "C"}, "direction", findings_);
  if (!choice) return std::nullopt;
  out.rotation = *choice >= 3;
  const auto instrument = instrument_of(entry.value, out.rotation);
  if (!instrument) return std::nullopt;
  out.direction = Vec3::Unit(static_cast<Eigen::Index>(*choice % 3));
  out.point = instrument->point;
  out.sign = instrument->sign;
  return out;
}

bool JobReader::take_temperatures(const TomlNode& entry, const MeasuredTable& log, FitDrift& drift) {
  if (job_.thermal.sensors.empty())
    for (const MeasuredColumn& column : log.columns)
      if (column.quantity == Quantity::temperature) job_.thermal.sensors.push_back(column.name);
  bool ok = !job_.thermal.sensors.empty();
  if (!ok)
    findings_.error("E-JOB-KIND", entry.mark, in_quotes(drift.file) + " has no temperatures",
                    "drift is explained by them", "add columns such as T1 [degC]");
  for (const std::string& sensor : job_.thermal.sensors) {
    const MeasuredColumn* column = log.find(sensor);
    if (column == nullptr || column->quantity != Quantity::temperature || !is_sensor_name(sensor)) {
      findings_.error(
          "E-JOB-KIND", entry.mark,
          fmt::format("{} has no column '{}' in degC that can be a sensor", in_quotes(drift.file), sensor),
          "every log needs every sensor; its name has letters, digits and _",
          "name the columns alike, or list those wanted under [thermal] sensors");
      ok = false;
      continue;
    }
    for (std::size_t i = 0; i < column->values.size(); ++i) {
      if (column->values[i] >= kColdest && column->values[i] <= kHottest) continue;
      findings_.error(
          "E-THERMAL-TEMPERATURE", entry.mark,
          fmt::format("{}: line {}: {} is {:g} degC", drift.file, log.lines[i], sensor, column->values[i]),
          "no machine is that warm or cold: a broken sensor, or another unit",
          "remove the rows or the sensor; state degC");
      ok = false;
      break;
    }
    drift.temperatures.push_back(column->values);
  }
  return ok;
}

bool JobReader::take_log(const TomlNode& entry, const MeasuredTable& log, FitDrift& drift) {
  const MeasuredColumn* time = log.find("time");
  const bool increasing = time != nullptr && time->quantity == Quantity::time &&
                          std::adjacent_find(time->values.begin(), time->values.end(),
                                             std::greater_equal<>()) == time->values.end();
  if (!increasing) {
    findings_.error("E-DRIFT-TIME", entry.mark, in_quotes(drift.file) + " has no column of increasing time",
                    "heat needs time", "name it time [s], [min] or [h], and sort the rows");
    return false;
  }
  if (log.rows() < kLeastTimes) {
    findings_.error("E-JOB-EMPTY", entry.mark,
                    fmt::format("{} has {} rows", in_quotes(drift.file), log.rows()),
                    "a model of heat is not told from so few", fmt::format("log {} or more", kLeastTimes));
    return false;
  }
  drift.times = time->values;
  bool ok = take_temperatures(entry, log, drift);
  for (DriftReading& reading : drift.readings) {
    const MeasuredColumn* column = log.find(reading.column);
    const Quantity quantity = reading.rotation ? Quantity::angle : Quantity::length;
    if (column == nullptr || column->quantity != quantity) {
      findings_.error("E-JOB-KIND", entry.mark,
                      fmt::format("{} has no column '{}' in a unit of {}", in_quotes(drift.file),
                                  reading.column, reading.rotation ? "angle" : "length"),
                      "every reading is a column of the log", "check its name and unit");
      ok = false;
      continue;
    }
    const auto [lo, hi] = std::minmax_element(column->values.begin(), column->values.end());
    const double most = reading.rotation ? 10 * mrad : 2 * mm;
    if (*hi - *lo > most)
      findings_.warning("W-RUN-LARGE", entry.mark,
                        fmt::format("{}: {} changes by more than {}", drift.file, reading.column,
                                    reading.rotation ? "10 mrad" : "2 mm"),
                        "few machines drift that far", "look at the unit");
    reading.values = column->values;
    for (double& value : reading.values) value *= reading.sign;
  }
  return ok;
}

void JobReader::read_drift(const TomlNode& entry) {
  refuse_other_keys(entry, {"file", "at", "use", "start", "readings"}, "[[drift]]", findings_);
  FitDrift drift;
  const auto at = pose_of(entry, "at");
  if (at) drift.at = *at;
  if (const TomlEntry* found = entry.find("use"))
    drift.validation = read_choice(found->value, {"fit", "validation"}, "use", findings_).value_or(0) == 1;
  if (const TomlEntry* found = entry.find("start"))
    drift.settled = read_choice(found->value, {"unknown", "settled"}, "start", findings_).value_or(0) == 1;
  const TomlEntry* readings = entry.find("readings");
  if (readings == nullptr || !expect_kind(readings->value, TomlNode::Kind::table, "readings", findings_)) {
    if (readings == nullptr)
      findings_.error("E-MISSING-KEY", entry.mark, "the key readings is missing",
                      "what did the sensors look at?", "readings = { X1 = { direction = \"X\" } }");
    return;
  }
  for (const TomlEntry& item : readings->value.entries)
    if (auto reading = drift_reading(item)) drift.readings.push_back(std::move(*reading));
  if (job_.thermal.errors.empty())
    findings_.error("E-MISSING-KEY", entry.mark, "the key errors of [thermal] is missing",
                    "it says which errors the machine drifts by", "errors = [\"TXS\", \"TYS\", \"TZS\"]");
  drift.planned = plan_.has_value();
  if (plan_) {
    if (plan_file(entry, drift.file) && at) job_.drifts.push_back(std::move(drift));
    return;
  }
  const std::optional<std::string> bytes = fetch(entry, drift.file);
  if (!bytes) return;
  const Parsed<MeasuredTable> log = read_measured_table(drift.file, *bytes);
  out_.insert(out_.end(), log.diagnostics.begin(), log.diagnostics.end());
  if (log.value && at && take_log(entry, *log.value, drift)) job_.drifts.push_back(std::move(drift));
}

}  // namespace abbe
