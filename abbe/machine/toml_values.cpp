#include "abbe/machine/toml_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace abbe {

bool expect_kind(const TomlNode& node, TomlNode::Kind kind, std::string_view what, Findings& findings) {
  if (node.kind == kind) return true;
  findings.error("E-TYPE", node.mark,
                 fmt::format("{} is {}, expected {}", what, kind_name(node.kind), kind_name(kind)), "",
                 node.kind == TomlNode::Kind::text && kind == TomlNode::Kind::number ? "remove the quotes"
                 : kind == TomlNode::Kind::text ? "write the value in quotes"
                                                : fmt::format("write {}", kind_name(kind)));
  return false;
}

std::optional<double> read_value(const TomlNode& node, std::string_view what, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::number, what, findings)) return std::nullopt;
  if (!std::isfinite(node.number)) {
    findings.error("E-NOT-FINITE", node.mark, fmt::format("{} is not a finite number", what),
                   "nan and inf would spread to every position", "write the measured number");
    return std::nullopt;
  }
  return node.number;
}

namespace {

bool fits(double number, const TomlNode& node, std::string_view what, Findings& findings) {
  if (std::isfinite(number)) return true;
  findings.error("E-NOT-FINITE", node.mark, fmt::format("{} is too large for its unit", what), "",
                 "check the number and [units]");
  return false;
}

}  // namespace

std::optional<double> read_quantity(const TomlNode& node, double unit, std::string_view what,
                                    Findings& findings) {
  const auto number = read_value(node, what, findings);
  if (!number || !fits(*number * unit, node, what, findings)) return std::nullopt;
  return *number * unit;
}

std::optional<std::vector<double>> read_values(const TomlNode& node, std::size_t count, std::string_view what,
                                               Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::array, what, findings)) return std::nullopt;
  if (count != 0 && node.items.size() != count) {
    findings.error("E-COUNT", node.mark,
                   fmt::format("{} has {} numbers, expected {}", what, node.items.size(), count), "",
                   fmt::format("write exactly {} numbers in brackets", count));
    return std::nullopt;
  }
  std::vector<double> out;
  out.reserve(node.items.size());
  for (const TomlNode& item : node.items) {
    if (const auto number = read_value(item, what, findings)) out.push_back(*number);
  }
  if (out.size() != node.items.size()) return std::nullopt;
  return out;
}

std::optional<Vec3> read_vector(const TomlNode& node, double unit, std::string_view what,
                                Findings& findings) {
  const auto numbers = read_values(node, 3, what, findings);
  if (!numbers) return std::nullopt;
  const Vec3 vector = Vec3((*numbers)[0], (*numbers)[1], (*numbers)[2]) * unit;
  for (int i = 0; i < 3; ++i) {
    if (!fits(vector[i], node.items[static_cast<std::size_t>(i)], what, findings)) return std::nullopt;
  }
  return vector;
}

std::optional<Vec3> read_direction(const TomlNode& node, std::string_view what, Findings& findings) {
  const auto vector = read_vector(node, 1.0, what, findings);
  if (!vector) return std::nullopt;
  // Scaled by the largest component first, so that neither tiny nor huge numbers lose digits.
  const double largest = vector->cwiseAbs().maxCoeff();
  if (largest < 1e-300) {
    findings.error("E-ZERO-VECTOR", node.mark, fmt::format("{} has no length", what),
                   "only its direction counts, and the zero vector has none",
                   "write the direction in bed axes, such as [1, 0, 0]");
    return std::nullopt;
  }
  const Vec3 scaled = *vector / largest;
  return Vec3(scaled / scaled.norm());
}

std::optional<std::array<double, 2>> read_interval(const TomlNode& node, double unit, std::string_view what,
                                                   Findings& findings) {
  const auto numbers = read_values(node, 2, what, findings);
  if (!numbers) return std::nullopt;
  const double lo = (*numbers)[0] * unit;
  const double hi = (*numbers)[1] * unit;
  if (!fits(lo, node, what, findings) || !fits(hi, node, what, findings)) return std::nullopt;
  if (!(lo < hi)) {
    findings.error("E-INTERVAL", node.mark, fmt::format("{} does not increase", what),
                   "the lower end comes first and the ends must differ", "write [lower, upper]");
    return std::nullopt;
  }
  return std::array{lo, hi};
}

std::optional<std::string> read_text(const TomlNode& node, std::string_view what, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::text, what, findings)) return std::nullopt;
  return node.text;
}

std::optional<bool> read_flag(const TomlNode& node, std::string_view what, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::boolean, what, findings)) return std::nullopt;
  return node.boolean;
}

std::optional<std::size_t> read_choice(const TomlNode& node, const std::vector<std::string>& words,
                                       std::string_view what, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::text, what, findings)) return std::nullopt;
  const auto at = std::find(words.begin(), words.end(), node.text);
  if (at != words.end()) return static_cast<std::size_t>(at - words.begin());
  findings.error("E-VALUE", node.mark,
                 fmt::format("{} is {}, expected {}", what, in_quotes(node.text), listed(words)), "",
                 suggestion(node.text, words, "use one of these words"));
  return std::nullopt;
}

void refuse_other_keys(const TomlNode& table, const std::vector<std::string>& keys, std::string_view what,
                       Findings& findings) {
  for (const TomlEntry& entry : table.entries) {
    if (findings.full()) return;
    if (std::find(keys.begin(), keys.end(), entry.key) != keys.end()) continue;
    findings.error("E-UNKNOWN-KEY", entry.mark,
                   fmt::format("unknown key {} in {}", in_quotes(entry.key), what),
                   "a key that is not understood would be ignored in silence",
                   suggestion(entry.key, keys, "known here: " + listed(keys, "and")));
  }
}

}  // namespace abbe
