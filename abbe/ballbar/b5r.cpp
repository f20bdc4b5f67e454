#include "abbe/ballbar/b5r.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <pugixml.hpp>
#include <utility>

#include "abbe/core/number.h"

namespace abbe {
namespace {

std::string unit_of(std::string_view type) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kUnits = {{
      {"UT_LENGTH_MM", "mm"},
      {"UT_LENGTH_UM", "um"},
      {"UT_FEEDRATE", "mm/min"},
      {"UT_SQUARENESS", "um/m"},
      {"UT_SERVO_MISMATCH", "ms"},
      {"UT_ANGLE", "deg"},
      {"UT_PERCENT", "%"},
      {"UT_SCALE_ERROR", "ppm"},
  }};
  for (const auto& [name, unit] : kUnits)
    if (type == name) return std::string(unit);
  return {};
}

struct ByName final : pugi::xml_tree_walker {
  bool for_each(pugi::xml_node& node) override {
    const std::string_view name = node.name();
    const std::string text = node.text().get();
    if (name == "TEST_SPEC") report.test = node.attribute("NAME").value();
    if (name == "OPERATOR") report.operator_name = text;
    if (name == "DATE_STARTED") report.date = text;
    if (name == "MACHINE_TESTED") report.machine = node.attribute("NAME").value();
    if (name == "SERIAL_NUMBER") report.serial_number = text;
    if (name == "LAST_CALIBRATED") report.last_calibrated = text;
    if (name == "PLANE") report.plane = read_plane(node.attribute("TEST_PLANE").value());
    if (name == "FEATURE") take_feature(node, text);
    return true;
  }

  void take_feature(const pugi::xml_node& node, const std::string& text) {
    B5rFeature feature{node.attribute("NAME").value(), node.attribute("DT").value(), {}, 0};
    const std::optional<double> value = read_number(text);
    if (!value) {
      bad.push_back(feature.name);
      return;
    }
    feature.unit = unit_of(feature.type);
    feature.value = *value;
    report.features.push_back(std::move(feature));
  }

  B5rReport report;
  std::vector<std::string> bad;  ///< features without a number
};

Diagnostic finding(const std::string& file, std::string message, std::string fix) {
  Diagnostic out;
  out.code = "E-B5R";
  out.place.file = file;
  out.message = std::move(message);
  out.fix = std::move(fix);
  return out;
}

}  // namespace

Parsed<B5rReport> read_b5r(const std::string& file, std::string_view text) {
  Parsed<B5rReport> out;
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(text.data(), text.size());
  if (!result) {
    out.diagnostics.push_back(
        finding(file, fmt::format("not XML: {} at byte {}", result.description(), result.offset),
                "export the test from Ballbar 20 again"));
    return out;
  }
  ByName walker;
  document.traverse(walker);
  for (const std::string& name : walker.bad)
    out.diagnostics.push_back(finding(file, fmt::format("the feature '{}' has no number", name.substr(0, 60)),
                                      "analyse the test again"));
  if (walker.report.features.empty() && walker.bad.empty())
    out.diagnostics.push_back(finding(file, "no FEATURE in the file", "only analysed tests have features"));
  if (out.diagnostics.empty()) out.value = std::move(walker.report);
  return out;
}

}  // namespace abbe
