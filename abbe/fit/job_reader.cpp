#include "abbe/fit/job_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "abbe/fit/choose_form.h"
#include "abbe/fit/observations.h"
#include "abbe/machine/expansion.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

constexpr double kPpm = 1e-6;

/// Directions of bed axes by letter; 3..5 are rotations about them.
Vec3 unit_of(int direction) { return Vec3::Unit(direction % 3); }

}  // namespace

std::vector<std::string> JobReader::instrument_keys_and(std::initializer_list<const char*> more) {
  std::vector<std::string> keys = {"file",     "column", "unit",  "optic",      "measured_at",
                                   "point_on", "sign",   "noise", "scale_u_ppm"};
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

std::optional<std::string> JobReader::text_of(const TomlNode& entry, const char* key, bool needed) {
  const TomlEntry* found = entry.find(key);
  if (found != nullptr) return abbe::read_text(found->value, key, findings_);
  if (needed)
    findings_.error("E-MISSING-KEY", entry.mark, fmt::format("the key {} is missing", key), "",
                    fmt::format("{} = \"..\"", key));
  return std::nullopt;
}

std::optional<ErrorName> JobReader::error_of(const TomlNode& entry, const char* key) {
  const auto text = text_of(entry, key, true);
  if (!text) return std::nullopt;
  const std::optional<ErrorName> name = read_error_name(*text);
  const std::vector<std::string> known = error_inventory(job_.machine);
  if (name && std::find(known.begin(), known.end(), to_string(*name)) != known.end()) return name;
  findings_.error("E-JOB-ERROR", entry.find(key)->value.mark,
                  fmt::format("{} is no error of a moving axis of this machine", in_quotes(*text)),
                  "a measurement belongs to an axis and a direction",
                  suggestion(*text, known, "write E, direction, axis: EXX, EYX, EAX, EC0Y"));
  return std::nullopt;
}

std::optional<JobReader::Pose> JobReader::pose_of(const TomlNode& entry, const char* key) {
  Pose pose{};
  const TomlEntry* found = entry.find(key);
  if (found == nullptr) return pose;
  if (!expect_kind(found->value, TomlNode::Kind::table, key, findings_)) return std::nullopt;
  bool ok = true;
  for (const TomlEntry& item : found->value.entries) {
    const int axis = job_.machine.find_axis(item.key);
    if (axis < 0) {
      findings_.error("E-JOB-AXIS", item.mark,
                      fmt::format("the machine has no moving axis {}", in_quotes(item.key)), "",
                      "name an axis of the chain: " + job_.machine.chain);
      ok = false;
      continue;
    }
    const bool rotary = job_.machine.axis(axis).type == AxisType::rotary;
    const auto value = read_quantity(item.value, rotary ? units_.angle : units_.length, item.key, findings_);
    if (value) pose[static_cast<std::size_t>(axis)] = *value;
    ok = ok && value;
  }
  return ok ? std::optional(pose) : std::nullopt;
}

std::optional<FitInstrument> JobReader::instrument_of(const TomlNode& entry, bool rotation) {
  FitInstrument out;
  const std::size_t before = findings_.error_count();
  out.point = job_.machine.tool.origin - job_.machine.tool.length * job_.machine.tool.axis;
  const TomlEntry *optic = entry.find("optic"), *measured_at = entry.find("measured_at");
  if (optic != nullptr && measured_at != nullptr)
    findings_.error("E-JOB-VALUE", optic->mark, "both optic and measured_at",
                    "each says where the measuring point is", "keep one of them");
  if (optic != nullptr)
    out.point += read_vector(optic->value, units_.length, "optic", findings_).value_or(Vec3::Zero());
  if (measured_at != nullptr)
    out.point =
        read_vector(measured_at->value, units_.length, "measured_at", findings_).value_or(Vec3::Zero());
  if (const TomlEntry* found = entry.find("point_on"))
    out.on_work = read_choice(found->value, {"tool", "work"}, "point_on", findings_).value_or(0) == 1;
  if (const TomlEntry* found = entry.find("sign"))
    out.sign = read_choice(found->value, {"normal", "reversed"}, "sign", findings_).value_or(0) == 1 ? -1 : 1;
  const auto positive = [&](const char* key, double unit) -> std::optional<double> {
    const TomlEntry* found = entry.find(key);
    if (found == nullptr) return std::nullopt;
    const auto value = read_quantity(found->value, unit, key, findings_);
    if (value && *value > 0) return value;
    if (value)
      findings_.error("E-JOB-VALUE", found->value.mark, fmt::format("{} is not above 0", key),
                      "a perfect instrument would outweigh all others", "write its standard uncertainty");
    return std::nullopt;
  };
  out.noise = positive("noise", error_unit(rotation));
  out.scale_u = positive("scale_u_ppm", kPpm).value_or(0);
  return findings_.error_count() == before ? std::optional(out) : std::nullopt;
}

std::optional<std::string> JobReader::fetch(const TomlNode& entry, std::string& path) {
  const auto name = text_of(entry, "file", true);
  if (!name) return std::nullopt;
  path = (std::filesystem::path(folder_) / *name).string();
  std::optional<std::string> bytes = fetch_ ? fetch_(path) : std::nullopt;
  if (!bytes) {
    findings_.error("E-CSV-FILE", entry.find("file")->value.mark, "cannot read " + in_quotes(path),
                    "the path is relative to the folder of this file",
                    "correct the path, or put the file there");
    return std::nullopt;
  }
  // One file may hold several columns; the same column twice would count a measurement double.
  const std::string column = text_of(entry, "column", false).value_or("");
  if (!contents_.insert(column + '\n' + *bytes).second)
    findings_.error("E-JOB-TWICE", entry.find("file")->value.mark,
                    fmt::format("{} was read before, or is a copy", in_quotes(path)),
                    "the same readings would count twice", "remove the entry");
  job_.files.push_back(path);
  return bytes;
}

bool JobReader::plan_file(const TomlNode& entry, std::string& path) {
  const auto name = text_of(entry, "file", true);
  if (!name) return false;
  path = (std::filesystem::path(folder_) / *name).string();
  if (!contents_.insert(path).second)
    findings_.error("E-JOB-TWICE", entry.find("file")->value.mark, in_quotes(path) + " is named twice",
                    "one file cannot be written twice", "name each file once");
  return true;
}

JobReader::Course JobReader::course_of(const ErrorName& error) const {
  Course course;
  const int axis = job_.machine.find_axis(error.axis);
  course.readings = error.is_rotation() ? Quantity::angle : Quantity::length;
  if (axis < 0) return course;
  course.ends = job_.machine.axis(axis).range;
  if (job_.machine.axis(axis).type == AxisType::rotary) course.targets = Quantity::angle;
  return course;
}

std::optional<RunTable> JobReader::planned_runs(const TomlNode& entry, std::string& path,
                                                const Course& course) {
  if (!plan_file(entry, path)) return std::nullopt;
  if (!course.ends) {
    findings_.error("E-JOB-RANGE", entry.mark, "the travel of the axis is not known",
                    "targets are spaced over it", "state range in the machine file");
    return std::nullopt;
  }
  RunTable table;
  table.file = path;
  table.targets = even_nodes((*course.ends)[0], (*course.ends)[1], static_cast<std::size_t>(plan_->targets));
  table.target_quantity = course.targets;
  table.quantity = course.readings;
  table.forward = Eigen::MatrixXd::Zero(plan_->targets, plan_->runs);
  table.backward = Eigen::MatrixXd::Zero(plan_->targets, plan_->bidirectional ? plan_->runs : 0);
  return table;
}

std::optional<RunTable> JobReader::runs_of_entry(const TomlNode& entry, std::string& path,
                                                 const Course& course) {
  if (plan_) return planned_runs(entry, path, course);
  const std::optional<std::string> bytes = fetch(entry, path);
  if (!bytes) return std::nullopt;
  const MeasuredUnit* unit = nullptr;
  if (const auto name = text_of(entry, "unit", false)) {
    unit = find_measured_unit(*name);
    if (unit == nullptr || (unit->quantity != Quantity::length && unit->quantity != Quantity::angle)) {
      findings_.error("E-JOB-VALUE", entry.find("unit")->value.mark,
                      in_quotes(*name) + " is not a unit of deviations", "",
                      "one of " + measured_unit_names());
      return std::nullopt;
    }
  }
  Parsed<RunTable> runs = read_runs(path, *bytes, text_of(entry, "column", false).value_or(""), unit);
  out_.insert(out_.end(), runs.diagnostics.begin(), runs.diagnostics.end());
  return std::move(runs.value);
}

double JobReader::thermal_of(const TomlNode& entry) {
  const TomlEntry *temperature = entry.find("temperature"), *expansion = entry.find("expansion_ppm");
  if (temperature == nullptr && expansion == nullptr) return 0;
  if (temperature == nullptr || expansion == nullptr) {
    findings_.error("E-JOB-VALUE", (temperature != nullptr ? temperature : expansion)->mark,
                    "temperature and expansion_ppm go together", "one without the other corrects nothing",
                    "state both, or neither if the instrument corrected to 20 degC itself");
    return 0;
  }
  const auto T = abbe::read_value(temperature->value, "temperature", findings_);
  const auto alpha = read_quantity(expansion->value, kPpm, "expansion_ppm", findings_);
  constexpr double kMostAway = 30, kMostExpansion = 100 * kPpm;
  if (T && std::abs(*T - kStandardTemperature) > kMostAway)
    findings_.error("E-JOB-VALUE", temperature->value.mark, fmt::format("the material was at {:g} degC", *T),
                    "expansion is linear near 20 degC only", "check the number and its unit");
  if (alpha && std::abs(*alpha) > kMostExpansion)
    findings_.error("E-JOB-VALUE", expansion->value.mark, "an expansion above 100 ppm per K",
                    "steel has 11.5, glass 8", "state it in ppm per K");
  return T && alpha ? *alpha * (*T - kStandardTemperature) : 0;
}

bool JobReader::kind_fits(const TomlNode& entry, const FitRun& run) {
  const Body& axis = job_.machine.axis(run.axis);
  const bool rotary = axis.type == AxisType::rotary;
  const bool fits = run.runs.quantity == (run.error.is_rotation() ? Quantity::angle : Quantity::length) &&
                    run.runs.target_quantity == (rotary ? Quantity::angle : Quantity::length);
  if (!fits)
    findings_.error("E-JOB-KIND", entry.mark,
                    fmt::format("{} does not hold {} at positions in {}", in_quotes(run.file),
                                run.error.is_rotation() ? "angles" : "lengths", rotary ? "deg" : "mm"),
                    "that is what " + run.name + " is", "check column and units");
  // About other directions than its own, errors of a rotary axis turn with it: a run of one number does not
  // tell them.
  const bool own =
      !rotary || (run.error.is_rotation() &&
                  std::abs(std::abs(axis.direction.dot(unit_of(run.error.direction))) - 1) < 1e-9);
  if (!own)
    findings_.error("E-JOB-KIND", entry.mark, fmt::format("{} is not angular positioning", run.name),
                    "of a rotary axis, runs of its angle are read", "measure the rest with [[ball]]");
  return fits && own;
}

void JobReader::warn_outside(const TomlNode& entry, const FitRun& run) {
  const auto& range = job_.machine.axis(run.axis).range;
  if (!range) return;
  const double slack = 1e-6 * ((*range)[1] - (*range)[0]);
  if (run.runs.targets.front() >= (*range)[0] - slack && run.runs.targets.back() <= (*range)[1] + slack)
    return;
  findings_.error(
      "E-JOB-RANGE", entry.mark, fmt::format("targets of {} are beyond the travel", in_quotes(run.file)),
      "positions of another axis, or another zero", "check axis and unit, or the range in the machine file");
}

void JobReader::read_run(const TomlNode& entry) {
  refuse_other_keys(
      entry, instrument_keys_and({"error", "at", "square", "reversed", "temperature", "expansion_ppm"}),
      "[[run]]", findings_);
  FitRun run;
  const auto error = error_of(entry, "error");
  const auto at = pose_of(entry, "at");
  const auto instrument = instrument_of(entry, error && error->is_rotation());
  const auto runs = runs_of_entry(entry, run.file, error ? course_of(*error) : Course{});
  run.thermal = thermal_of(entry);
  run.square = text_of(entry, "square", false).value_or("");
  if (const TomlEntry* found = entry.find("reversed"))
    run.reversed = read_flag(found->value, "reversed", findings_).value_or(false);
  if (!error || !at || !instrument || !runs) return;
  run.error = *error;
  run.name = to_string(*error);
  run.axis = job_.machine.find_axis(error->axis);
  if (error->error_class != ErrorClass::component || run.axis < 0) {
    findings_.error("E-JOB-ERROR", entry.mark, run.name + " is not a component error",
                    "a run is a course along an axis", "a single number is stated with [[value]]");
    return;
  }
  run.at = *at;
  run.instrument = *instrument;
  run.runs = *runs;
  if (!kind_fits(entry, run)) return;
  if (!run.square.empty() && job_.find_square(run.square) == nullptr)
    findings_.error("E-JOB-SQUARE", entry.mark,
                    fmt::format("there is no [[square]] {}", in_quotes(run.square)),
                    "its angle and uncertainty count", "declare it");
  warn_outside(entry, run);
  job_.runs.push_back(std::move(run));
}

void JobReader::read_diagonal(const TomlNode& entry) {
  refuse_other_keys(entry, instrument_keys_and({"from", "to"}), "[[diagonal]]", findings_);
  FitDiagonal diagonal;
  const auto from = pose_of(entry, "from"), to = pose_of(entry, "to");
  const auto instrument = instrument_of(entry, false);
  if (!from || !to || !instrument) return;
  Vec3 way = Vec3::Zero();
  for (int i = 0; i < job_.machine.axis_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    way += ((*to)[k] - (*from)[k]) * relative_direction(job_.machine.axis(i));
  }
  const auto runs = runs_of_entry(entry, diagonal.file, {std::array{0.0, way.norm()}});
  if (!runs) return;
  diagonal.from = *from;
  diagonal.to = *to;
  diagonal.instrument = *instrument;
  diagonal.runs = *runs;
  bool moves = false, turns = false;
  for (int i = 0; i < job_.machine.axis_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool differs = diagonal.from[k] != diagonal.to[k];
    moves = moves || differs;
    turns = turns || (differs && job_.machine.axis(i).type == AxisType::rotary);
  }
  if (!moves || turns || runs->quantity != Quantity::length || runs->target_quantity != Quantity::length) {
    findings_.error("E-JOB-KIND", entry.mark, "not a straight line of linear axes with deviations in length",
                    "a diagonal is measured along itself", "check from, to and the units of the file");
    return;
  }
  job_.diagonals.push_back(std::move(diagonal));
}

void JobReader::read_value(const TomlNode& entry) {
  refuse_other_keys(entry, {"error", "value", "u"}, "[[value]]", findings_);
  const auto error = error_of(entry, "error");
  const TomlEntry *value = entry.find("value"), *u = entry.find("u");
  if (value == nullptr || u == nullptr) {
    findings_.error("E-MISSING-KEY", entry.mark, "value and u are needed",
                    "an uncertainty decides its weight", "value = 12.0 and u = 1.5");
    return;
  }
  if (!error) return;
  if (error->error_class != ErrorClass::location) {
    findings_.error("E-JOB-ERROR", entry.mark, to_string(*error) + " is not a location error",
                    "one number does not make a function", "give a [[run]]");
    return;
  }
  const auto number = read_quantity(value->value, error_unit(error->is_rotation()), "value", findings_);
  const auto uncertainty = read_quantity(u->value, error_unit(error->is_rotation()), "u", findings_);
  if (!number || !uncertainty) return;
  if (!(*uncertainty > 0)) {
    findings_.error("E-JOB-VALUE", u->value.mark, "u is not above 0", "it would outweigh every measurement",
                    "write the standard uncertainty");
    return;
  }
  job_.values.push_back({to_string(*error), *number, *uncertainty});
}

void JobReader::read_square(const TomlNode& entry) {
  refuse_other_keys(entry, {"name", "deviation", "u"}, "[[square]]", findings_);
  FitSquare square;
  square.name = text_of(entry, "name", true).value_or("");
  if (const TomlEntry* found = entry.find("deviation"))
    square.deviation = read_quantity(found->value, units_.error_angle, "deviation", findings_).value_or(0);
  if (const TomlEntry* found = entry.find("u")) {
    square.u = read_quantity(found->value, units_.error_angle, "u", findings_);
    if (square.u && *square.u < 0)
      findings_.error("E-JOB-VALUE", found->value.mark, "u is negative", "",
                      "write the standard uncertainty");
  }
  if (job_.find_square(square.name) != nullptr)
    findings_.error("E-JOB-SQUARE", entry.mark, fmt::format("[[square]] {} twice", in_quotes(square.name)),
                    "", "give each its own name");
  job_.squares.push_back(std::move(square));
}

void JobReader::read_function(const TomlEntry& entry) {
  FitFunction function;
  const auto name = read_error_name(entry.key);
  if (!name || name->error_class != ErrorClass::component || job_.machine.find_axis(name->axis) < 0) {
    findings_.error("E-JOB-ERROR", entry.mark,
                    in_quotes(entry.key) + " is no component error of a moving axis", "",
                    "write E, direction, axis: EXX");
    return;
  }
  if (!expect_kind(entry.value, TomlNode::Kind::table, entry.key, findings_)) return;
  function.name = to_string(*name);
  const TomlNode& table = entry.value;
  refuse_other_keys(table, {"form", "order", "count", "pitch", "harmonics", "reversal"}, entry.key,
                    findings_);
  if (const TomlEntry* found = table.find("form"))
    function.form = static_cast<FitFunction::Form>(
        read_choice(found->value, {"auto", "polynomial", "table", "cubic"}, "form", findings_).value_or(0));
  if (const TomlEntry* found = table.find("reversal"))
    function.reversal = static_cast<FitFunction::Reversal>(
        read_choice(found->value, {"constant", "table", "none"}, "reversal", findings_).value_or(0));
  const auto count = [&](const char* key, int& value, double most) {
    const TomlEntry* found = table.find(key);
    if (found == nullptr) return;
    const auto number = abbe::read_value(found->value, key, findings_);
    if (number && *number >= 1 && *number <= most && *number == std::floor(*number)) {
      value = static_cast<int>(*number);
    } else if (number) {
      findings_.error("E-JOB-VALUE", found->value.mark,
                      fmt::format("{} is not a whole number from 1 to {:g}", key, most), "", "correct it");
    }
  };
  count("order", function.order, 12);
  count("count", function.count, 1000);
  count("harmonics", function.harmonics, 20);
  if (const TomlEntry* found = table.find("pitch")) {
    function.pitch = abbe::read_value(found->value, "pitch", findings_).value_or(0);
    if (!(function.pitch > 0))
      findings_.error("E-JOB-VALUE", found->value.mark, "pitch is not above 0", "",
                      "the period in mm or deg");
  }
  if (function.form == FitFunction::Form::polynomial && function.order == 0)
    findings_.error("E-MISSING-KEY", entry.mark, "a polynomial without order", "",
                    "order = 3, or form = \"auto\"");
  job_.functions.push_back(std::move(function));
}

void JobReader::read_functions(const TomlNode& table) {
  for (const TomlEntry& entry : table.entries) read_function(entry);
}

void JobReader::read_reference(const TomlNode& table) {
  TomlNode holder;
  holder.entries.push_back({"reference", table.mark, table});
  if (const auto pose = pose_of(holder, "reference")) job_.reference = *pose;
}

void JobReader::read_locations(const TomlNode& list) {
  if (!expect_kind(list, TomlNode::Kind::array, "locations", findings_)) return;
  const std::vector<std::string> known = error_inventory(job_.machine);
  for (const TomlNode& item : list.items) {
    const auto text = abbe::read_text(item, "locations", findings_);
    if (!text) continue;
    const auto name = read_error_name(*text);
    if (name && name->error_class == ErrorClass::location &&
        std::find(known.begin(), known.end(), to_string(*name)) != known.end()) {
      job_.locations.push_back(to_string(*name));
    } else {
      findings_.error("E-JOB-ERROR", item.mark, in_quotes(*text) + " is no location error of this machine",
                      "", suggestion(*text, known, "write EC0Y, EX0C, .."));
    }
  }
}

}  // namespace abbe
