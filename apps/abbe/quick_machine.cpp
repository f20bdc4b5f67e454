#include "quick_machine.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr double kMostScale = 0.01;  // farther from 1, it is a wrong number
constexpr double kMostSkew = 2 * deg;

struct Unit {
  std::string_view name;
  double value;
};
constexpr std::array<Unit, 5> kUnits = {
    {{"deg", deg}, {"mrad", mrad}, {"urad", urad}, {"arcsec", arcsec}, {"rad", rad}}};

/// "0.02deg"
std::optional<double> read_angle(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const auto value = read_number(text.substr(0, text.size() - unit.name.size()));
    return value ? std::optional(*value * unit.value) : std::nullopt;
  }
  return std::nullopt;
}

bool is_axis(std::string_view name) { return name.size() == 1 && name[0] >= 'X' && name[0] <= 'Z'; }

std::string toml_string(std::string_view path) {
  std::string text = "\"";
  for (const char c : path) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

/// Squareness as ISO 230-1 names it: Z leans away from +X by a turn about -Y.
void read_skews(const QuickMachine& quick, std::string& errors, Diagnostics& findings) {
  static const std::map<std::string, std::pair<const char*, int>, std::less<>> kErrors = {
      {"XY", {"EC0Y", 1}}, {"XZ", {"EB0Z", -1}}, {"YZ", {"EA0Z", 1}}};
  std::map<std::string, bool> seen;
  for (const Assignment& given : split_assignments("--skew", quick.skew, findings)) {
    const auto pair = kErrors.find(given.name);
    const auto angle = read_angle(given.text);
    if (pair == kErrors.end() || !angle || std::abs(*angle) > kMostSkew || seen[given.name]) {
      findings.push_back(option_error(
          "--skew", fmt::format("'{}={}' is not the skew of a pair of axes", given.name, given.text),
          "write XY=0.02deg,XZ=-0.01deg,YZ=50urad, each pair once: positive = obtuse angle between the "
          "positive directions"));
      continue;
    }
    seen[given.name] = true;
    errors += fmt::format("{} = {:.17g}\n", pair->second.first, pair->second.second * *angle);
  }
}

/// What each axis does to its own position: "{ poly = .. }", "{ csv = .. }".
std::map<char, std::vector<std::string>> read_positions(const QuickMachine& quick, Diagnostics& findings) {
  std::map<char, std::vector<std::string>> forms;
  for (const Assignment& given : split_assignments("--scale", quick.scale, findings)) {
    const auto factor = read_number(given.text);
    if (!is_axis(given.name) || !factor || std::abs(*factor - 1) > kMostScale) {
      findings.push_back(
          option_error("--scale", fmt::format("'{}={}' is not the scale of an axis", given.name, given.text),
                       "write X=1.0001: the axis moves 100.01 mm where 100 mm are commanded"));
      continue;
    }
    // um per mm
    forms[given.name[0]].push_back(fmt::format("{{ poly = [0, {:.17g}] }}", (*factor - 1) / um));
  }
  for (const Assignment& given : split_assignments("--pitch", quick.pitch, findings)) {
    if (!is_axis(given.name) || given.text.empty()) {
      findings.push_back(
          option_error("--pitch", fmt::format("'{}={}' is not an axis and a file", given.name, given.text),
                       "write X=table.csv, a file with the columns X (mm) and EXX (um)"));
      continue;
    }
    forms[given.name[0]].push_back(
        fmt::format("{{ csv = {}, column = \"E{}{}\" }}", toml_string(given.text), given.name, given.name));
  }
  return forms;
}

}  // namespace

void add_quick_machine_options(Command& verb, QuickMachine& quick) {
  const auto add = [&verb](const char* name, std::vector<std::string>& list, const char* type,
                           const char* help) {
    verb.add_option(name, list, help)
        ->type_name(type)
        ->allow_extra_args(false)
        ->group("Three axes without a machine file");
  };
  add("--skew", quick.skew, "XY=0.02deg,..",
      "squareness of XY, XZ, YZ; positive: the angle between the positive directions is obtuse");
  add("--scale", quick.scale, "X=1.0001,..", "way moved per way commanded");
  add("--pitch", quick.pitch, "X=FILE,..",
      "CSV with the position of the axis (mm) and its error (um): columns X and EXX");
}

std::optional<std::string> machine_text_of(const QuickMachine& quick, Diagnostics& findings) {
  const std::size_t before = findings.size();
  std::string errors;
  read_skews(quick, errors, findings);
  for (const auto& [axis, forms] : read_positions(quick, findings)) {
    errors += fmt::format("E{0}{0} = [", axis);
    for (const std::string& form : forms) errors += form + ", ";
    errors += "]\n";
  }
  if (findings.size() > before) return std::nullopt;
  return "format = 1\n[machine]\nname = \"three axes\"\nchain = \"w b X Y Z t\"\n[units]\nerror_angle = "
         "\"rad\"\n[errors]\n" +
         errors;
}

}  // namespace abbe::app
