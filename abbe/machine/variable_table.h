#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/machine/machine.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// The variables that error functions use: positions of the moving axes first, then whatever else a
/// function names.
class VariableTable {
 public:
  /// `unit_ratio`: numbers of the machine file per number of the errors file, for lengths and angles
  /// (1 when both files have the same units).
  struct UnitRatio {
    double length = 1, angle = 1;
  };
  VariableTable(const std::vector<Body>& bodies, UnitRatio ratio);

  /// The index of the variable of that name, added if it is new; nullopt after a reported mistake.
  [[nodiscard]] std::optional<int> index_of(const TomlNode& name, Findings& findings);

  /// Numbers of the machine file per number of the errors file, for this variable.
  [[nodiscard]] double ratio(int variable) const;

  [[nodiscard]] const Variable& at(int variable) const {
    return variables_[static_cast<std::size_t>(variable)];
  }
  /// The body whose position this variable is, or nullptr.
  [[nodiscard]] const Body* position_of(int variable) const;
  [[nodiscard]] std::vector<Variable> take() { return std::move(variables_); }

 private:
  std::optional<int> axis_named(std::string_view name) const;
  std::optional<Variable> derivative(const TomlNode& name, Findings& findings) const;
  bool acceptable_sensor(const TomlNode& name, Findings& findings) const;

  std::vector<Body> axes_;          ///< moving ones, by axis index
  std::vector<std::string> names_;  ///< of all chain elements
  UnitRatio ratio_;
  std::vector<Variable> variables_;
};

}  // namespace abbe
