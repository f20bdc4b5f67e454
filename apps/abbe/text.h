#pragma once

#include <array>
#include <string>
#include <string_view>

#include "abbe/chain/solve_path.h"
#include "abbe/core/diagnostic.h"
#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"
#include "abbe/report/json_writer.h"

namespace abbe::app {

/// Axis positions for people: "X 100.0000 mm  A 30.00000 deg".
[[nodiscard]] std::string positions_text(const Machine& machine, const std::array<double, kMaxAxes>& q);

/// One row of three numbers under the heading of vector_heading(): signed or not, with its unit.
[[nodiscard]] std::string vector_heading();
[[nodiscard]] std::string vector_row(std::string_view name, const Vec3& v, int decimals,
                                     std::string_view unit, bool sign, std::string_view remark = {});

/// The member `name`: axis positions in mm and degrees, by axis name.
void write_positions(JsonWriter& json, std::string_view name, const Machine& machine,
                     const std::array<double, kMaxAxes>& q);

/// The member `path`: the largest step of each axis between neighbours, the point that ends it (from 1),
/// and how often the branch changed.
void write_path(JsonWriter& json, const Machine& machine, const PathReport& report);
/// The same for people, one line; empty for fewer than two points.
[[nodiscard]] std::string path_text(const Machine& machine, const PathReport& report);

/// Position of an axis for JSON: mm, or degrees.
[[nodiscard]] double json_position(const Body& axis, double position);

/// The members that every JSON answer of the program starts with: format, verb, machine.
void write_preamble(JsonWriter& json, std::string_view verb, const Machine& machine);

/// The member `name`: findings with code, place and message.
void write_findings(JsonWriter& json, std::string_view name, const Diagnostics& findings);

}  // namespace abbe::app
