#include "abbe/machine/machine_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

struct UnitName {
  std::string name;
  double factor;
};

void read_unit(const TomlNode& table, const std::string& key, const std::vector<UnitName>& names,
               double& factor, Findings& findings) {
  const TomlEntry* entry = table.find(key);
  if (entry == nullptr) return;
  std::vector<std::string> words;
  for (const UnitName& name : names) words.push_back(name.name);
  if (const auto choice = read_choice(entry->value, words, "units." + key, findings)) {
    factor = names[*choice].factor;
  }
}

/// YYYY-MM-DD and a day of the calendar.
bool is_date(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto number = [&](std::size_t begin, std::size_t count) {
    int value = 0;
    for (std::size_t i = begin; i < begin + count; ++i) {
      if (text[i] < '0' || text[i] > '9') return -1;
      value = 10 * value + (text[i] - '0');
    }
    return value;
  };
  const int year = number(0, 4);
  const int month = number(5, 2);
  const int day = number(8, 2);
  if (year < 0 || month < 1 || month > 12 || day < 1) return false;
  constexpr std::array kDays{31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  return day <= kDays[static_cast<std::size_t>(month - 1)] + (month == 2 && leap ? 1 : 0);
}

std::string read_date(const TomlEntry& entry, Findings& findings) {
  const TomlNode& node = entry.value;
  if ((node.kind == TomlNode::Kind::date || node.kind == TomlNode::Kind::text) && is_date(node.text)) {
    return node.text;
  }
  findings.error("E-DATE", node.mark, fmt::format("calibration.{} is not a date", entry.key), "",
                 "write a day of the calendar as YYYY-MM-DD, such as 2026-03-02");
  return {};
}

std::string read_identity(const TomlNode& node, Findings& findings) {
  if (node.kind == TomlNode::Kind::number && node.is_integer) return std::to_string(node.integer);
  if (node.kind == TomlNode::Kind::number) {
    const auto number = read_value(node, "calibration.machine_id", findings);
    return number ? to_shortest(*number) : std::string();
  }
  return read_text(node, "calibration.machine_id", findings).value_or("");
}

}  // namespace

void check_format(const TomlNode& root, Findings& findings) {
  const TomlEntry* format = root.find("format");
  if (format == nullptr) {
    findings.error("E-FORMAT", Mark{1, 1, 1}, "the file does not say its format",
                   "the meaning of a file must not change with the program that reads it",
                   "begin the file with: format = 1");
  } else if (!format->value.is_integer || format->value.integer != 1) {
    findings.error("E-FORMAT", format->value.mark, "this program reads format 1 only",
                   "a later format may give the same keys another meaning", "write: format = 1");
  }
}

const TomlNode* find_table(const TomlNode& root, std::string_view name, Findings& findings) {
  const TomlEntry* entry = root.find(name);
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, name, findings)) return nullptr;
  return &entry->value;
}

FileUnits read_units(const TomlNode& root, Findings& findings) {
  FileUnits units;
  const TomlNode* table = find_table(root, "units", findings);
  if (table == nullptr) return units;
  refuse_other_keys(*table, {"length", "angle", "error_length", "error_angle"}, "[units]", findings);
  read_unit(*table, "length", {{"mm", mm}, {"m", metre}, {"in", inch}}, units.length, findings);
  read_unit(*table, "angle", {{"deg", deg}, {"rad", rad}}, units.angle, findings);
  read_unit(*table, "error_length", {{"um", um}, {"mm", mm}, {"nm", nm}, {"in", inch}}, units.error_length,
            findings);
  read_unit(*table, "error_angle",
            {{"urad", urad}, {"mrad", mrad}, {"rad", rad}, {"arcsec", arcsec}, {"deg", deg}},
            units.error_angle, findings);
  return units;
}

ToolMount read_tool(const TomlNode& root, const FileUnits& units, const std::vector<Body>& bodies,
                    Findings& findings) {
  ToolMount tool;
  const auto last = std::find_if(bodies.rbegin(), bodies.rend(),
                                 [](const Body& body) { return body.branch == Branch::tool; });
  if (last != bodies.rend()) tool.origin = last->origin;
  const TomlNode* table = find_table(root, "tool", findings);
  if (table == nullptr) return tool;
  refuse_other_keys(*table, {"origin", "axis", "length"}, "[tool]", findings);
  if (const auto* entry = table->find("origin")) {
    tool.origin = read_vector(entry->value, units.length, "tool.origin", findings).value_or(tool.origin);
  }
  if (const auto* entry = table->find("axis")) {
    tool.axis = read_direction(entry->value, "tool.axis", findings).value_or(tool.axis);
  }
  if (const auto* entry = table->find("length")) {
    tool.length = read_quantity(entry->value, units.length, "tool.length", findings).value_or(tool.length);
  }
  return tool;
}

Vec3 read_workpiece_origin(const TomlNode& root, const FileUnits& units, Findings& findings) {
  const TomlNode* table = find_table(root, "workpiece", findings);
  if (table == nullptr) return Vec3::Zero();
  refuse_other_keys(*table, {"origin"}, "[workpiece]", findings);
  const TomlEntry* origin = table->find("origin");
  if (origin == nullptr) return Vec3::Zero();
  return read_vector(origin->value, units.length, "workpiece.origin", findings).value_or(Vec3::Zero());
}

Calibration read_calibration(const TomlNode& root, Findings& findings) {
  Calibration calibration;
  const TomlNode* table = find_table(root, "calibration", findings);
  if (table == nullptr) return calibration;
  refuse_other_keys(*table, {"date", "machine_id", "temperature", "control_compensation", "valid_to"},
                    "[calibration]", findings);
  if (const auto* entry = table->find("date")) calibration.date = read_date(*entry, findings);
  if (const auto* entry = table->find("valid_to")) {
    calibration.valid_to = read_date(*entry, findings);
    if (!calibration.date.empty() && !calibration.valid_to.empty() &&
        calibration.valid_to < calibration.date) {
      findings.warning("W-VALID-TO", entry->value.mark, "the calibration ends before it was made",
                       "valid_to is earlier than date", "check both dates");
    }
  }
  if (const auto* entry = table->find("machine_id")) {
    calibration.machine_id = read_identity(entry->value, findings);
  }
  if (const auto* entry = table->find("temperature")) {
    calibration.temperature = read_value(entry->value, "calibration.temperature", findings);
  }
  if (const auto* entry = table->find("control_compensation")) {
    calibration.control_compensation =
        read_text(entry->value, "calibration.control_compensation", findings).value_or("");
  }
  return calibration;
}

}  // namespace abbe
