#include <fmt/format.h>

#include <set>
#include <utility>

#include "abbe/machine/function_reader.h"
#include "abbe/machine/toml_values.h"

// The grid form of FunctionReader: { grid = [[..]], at = [[..], [..]], of = ["Y", "T1"] }.

namespace abbe {

FunctionReader::Function FunctionReader::read_grid(const TomlNode& table, const Inherited& inherited) {
  const TomlNode& grid = table.find("grid")->value;
  const TomlEntry* at_entry = table.find("at");
  if (at_entry == nullptr) {
    findings_.error("E-GRID", grid.mark, fmt::format("the grid of {} has no at", name_),
                    "at lists the positions of every variable", "add at = [[..], [..]]");
    return std::nullopt;
  }
  const std::string what = "at of " + name_;
  if (!expect_kind(at_entry->value, TomlNode::Kind::array, what, findings_)) return std::nullopt;
  const std::vector<TomlNode>& at_lists = at_entry->value.items;
  constexpr std::size_t kMostVariables = 4;
  if (at_lists.empty() || at_lists.size() > kMostVariables) {
    findings_.error(
        "E-GRID", at_entry->value.mark, fmt::format("{} has {} lists", what, at_lists.size()),
        fmt::format("a grid has 1 to {} variables, each with its list of positions", kMostVariables),
        "write one list per variable: at = [[0, 500], [18, 20, 24]]");
    return std::nullopt;
  }
  std::vector<std::vector<double>> at;
  for (const TomlNode& list : at_lists) {
    auto positions = read_values(list, 0, "a list in " + what, findings_);
    if (!positions) return std::nullopt;
    if (positions->empty()) {
      findings_.error("E-GRID", list.mark, fmt::format("an empty list in {}", what), "",
                      "write the positions of the variable");
      return std::nullopt;
    }
    std::vector<Mark> marks;
    for (const TomlNode& item : list.items) marks.push_back(item.mark);
    if (!increasing(*positions, marks)) return std::nullopt;
    at.push_back(std::move(*positions));
  }
  std::vector<double> values;
  if (!flatten_grid(grid, at, 0, values)) return std::nullopt;

  const TomlEntry* of = table.find("of");
  if (at.size() == 1 && (of == nullptr || of->value.kind == TomlNode::Kind::text)) {
    // A grid of one variable is a table.
    const auto leaf = read_leaf(table, inherited);
    if (!leaf) return std::nullopt;
    return sampled(table, *leaf, {std::move(at.front()), std::move(values), {}, grid.mark});
  }
  if (of == nullptr || of->value.kind != TomlNode::Kind::array || of->value.items.size() != at.size()) {
    findings_.error("E-GRID", of == nullptr ? table.mark : of->value.mark,
                    fmt::format("the grid of {} needs the names of {} variables", name_, at.size()),
                    "of names one variable for each list of at", "add of = [\"Y\", \"T1\"]");
    return std::nullopt;
  }
  for (const char* key : {"reference", "domain"}) {
    if (const TomlEntry* entry = table.find(key)) {
      findings_.error("E-FORM-KEY", entry->mark, fmt::format("'{}' of a grid", key),
                      "it would have to say which of the variables it means",
                      "shift the positions in at, or leave out those beyond the ends");
      return std::nullopt;
    }
  }
  std::vector<int> variables;
  for (std::size_t k = 0; k < at.size(); ++k) {
    const auto variable = variables_.index_of(of->value.items[k], findings_);
    if (!variable) return std::nullopt;
    const double ratio = variables_.ratio(*variable);
    for (double& position : at[k]) position *= ratio;
    widen_extent(*variable, at[k].front(), at[k].back());
    variables.push_back(*variable);
  }
  if (std::set<int>(variables.begin(), variables.end()).size() != variables.size()) {
    findings_.error("E-GRID", of->value.mark, fmt::format("the grid of {} names a variable twice", name_), "",
                    "name different variables");
    return std::nullopt;
  }
  return accepted(ErrorFunction::grid(std::move(variables), std::move(at), std::move(values)), grid.mark);
}

/// The values row by row, the last variable fastest; every list has as many items as `at` has positions.
bool FunctionReader::flatten_grid(const TomlNode& node, const std::vector<std::vector<double>>& at,
                                  std::size_t depth, std::vector<double>& out) {
  const std::string what = "grid of " + name_;
  if (depth == at.size()) {
    const auto value = read_value(node, "a value in the " + what, findings_);
    if (value) out.push_back(*value);
    return value.has_value();
  }
  if (!expect_kind(node, TomlNode::Kind::array, "a row of the " + what, findings_)) return false;
  if (node.items.size() != at[depth].size()) {
    findings_.error(
        "E-GRID", node.mark,
        fmt::format("a row of the {} has {} items, expected {}", what, node.items.size(), at[depth].size()),
        fmt::format("list {} of at has {} positions", depth + 1, at[depth].size()),
        "the first list of at counts the rows, the last one the values in a row");
    return false;
  }
  for (const TomlNode& item : node.items) {
    if (!flatten_grid(item, at, depth + 1, out)) return false;
  }
  return true;
}

}  // namespace abbe
