#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

// Typed access to values of a file: each returns nullopt after it has reported what was found and
// what was expected. `what` names the value in messages ("tool.length").

[[nodiscard]] bool expect_kind(const TomlNode& node, TomlNode::Kind kind, std::string_view what,
                               Findings& findings);

/// A finite number.
[[nodiscard]] std::optional<double> read_value(const TomlNode& node, std::string_view what,
                                               Findings& findings);

/// A finite number times `unit`; refused if the product overflows.
[[nodiscard]] std::optional<double> read_quantity(const TomlNode& node, double unit, std::string_view what,
                                                  Findings& findings);

/// A list of finite numbers, `count` of them unless 0.
[[nodiscard]] std::optional<std::vector<double>> read_values(const TomlNode& node, std::size_t count,
                                                             std::string_view what, Findings& findings);

/// [x, y, z] times `unit`.
[[nodiscard]] std::optional<Vec3> read_vector(const TomlNode& node, double unit, std::string_view what,
                                              Findings& findings);

/// [x, y, z] as a vector of length 1; the zero vector is refused.
[[nodiscard]] std::optional<Vec3> read_direction(const TomlNode& node, std::string_view what,
                                                 Findings& findings);

/// [lo, hi] with lo < hi, times `unit` > 0.
[[nodiscard]] std::optional<std::array<double, 2>> read_interval(const TomlNode& node, double unit,
                                                                 std::string_view what, Findings& findings);

[[nodiscard]] std::optional<std::string> read_text(const TomlNode& node, std::string_view what,
                                                   Findings& findings);

[[nodiscard]] std::optional<bool> read_flag(const TomlNode& node, std::string_view what, Findings& findings);

/// One of the words; its index.
[[nodiscard]] std::optional<std::size_t> read_choice(const TomlNode& node,
                                                     const std::vector<std::string>& words,
                                                     std::string_view what, Findings& findings);

/// Reports every key of the table that is not one of `keys`.
void refuse_other_keys(const TomlNode& table, const std::vector<std::string>& keys, std::string_view what,
                       Findings& findings);

}  // namespace abbe
