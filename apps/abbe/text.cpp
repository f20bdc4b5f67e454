#include "text.h"

#include <fmt/core.h>

#include "abbe/core/units.h"

namespace abbe::app {

std::string positions_text(const Machine& machine, const std::array<double, kMaxAxes>& q) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const double position = json_position(axis, q[static_cast<std::size_t>(i)]);
    if (i > 0) text += "   ";
    text += axis.type == AxisType::rotary ? fmt::format("{} {:.6f} deg", axis.name, position)
                                          : fmt::format("{} {:.6f} mm", axis.name, position);
  }
  return text;
}

std::string vector_heading() { return fmt::format("{:<16}{:>15}{:>15}{:>15}\n", "", "x", "y", "z"); }

std::string vector_row(std::string_view name, const Vec3& v, int decimals, std::string_view unit, bool sign,
                       std::string_view remark) {
  const auto number = [&](double value) {
    return sign ? fmt::format("{:+.{}f}", value, decimals) : fmt::format("{:.{}f}", value, decimals);
  };
  std::string row =
      fmt::format("{:<16}{:>15}{:>15}{:>15}  {}", name, number(v.x()), number(v.y()), number(v.z()), unit);
  if (!remark.empty()) row += fmt::format("   {}", remark);
  while (row.ends_with(' ')) row.pop_back();
  return row + '\n';
}

void write_path(JsonWriter& json, const Machine& machine, const PathReport& report) {
  json.key("path").begin_object(JsonWriter::Layout::one_line);
  json.member("points", report.points);
  write_positions(json, "largest_step", machine, report.largest_step);
  json.key("largest_step_at").begin_object();
  for (int i = 0; i < machine.axis_count(); ++i)
    json.member(machine.axis(i).name, report.largest_at[static_cast<std::size_t>(i)]);
  json.end();
  json.member("branch_changes", report.branch_changes).end();
}

std::string path_text(const Machine& machine, const PathReport& report) {
  if (report.points < 2) return {};
  std::string text = "largest step between neighbours:";
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const auto k = static_cast<std::size_t>(i);
    text += fmt::format("  {} {:.6f} {} (point {})", axis.name, json_position(axis, report.largest_step[k]),
                        axis.type == AxisType::rotary ? "deg" : "mm", report.largest_at[k]);
  }
  return text + fmt::format("\nbranch changes: {}\n", report.branch_changes);
}

double json_position(const Body& axis, double position) {
  return axis.type == AxisType::rotary ? position / deg : position / mm;
}

void write_positions(JsonWriter& json, std::string_view name, const Machine& machine,
                     const std::array<double, kMaxAxes>& q) {
  json.key(name).begin_object(JsonWriter::Layout::one_line);
  for (int i = 0; i < machine.axis_count(); ++i) {
    json.member(machine.axis(i).name, json_position(machine.axis(i), q[static_cast<std::size_t>(i)]));
  }
  json.end();
}

void write_preamble(JsonWriter& json, std::string_view verb, const Machine& machine) {
  json.member("format", 1).member("verb", verb);
  json.key("machine").begin_object();
  json.member("name", machine.name).member("chain", machine.chain).member("sha256", machine.sha256);
  json.end();
}

void write_findings(JsonWriter& json, std::string_view name, const Diagnostics& findings) {
  json.key(name).begin_array();
  for (const Diagnostic& finding : findings) {
    json.begin_object(JsonWriter::Layout::one_line);
    json.member("code", finding.code).member("file", finding.place.file);
    json.member("line", static_cast<std::uint64_t>(finding.place.line))
        .member("message", finding.message)
        .end();
  }
  json.end();
}

}  // namespace abbe::app
