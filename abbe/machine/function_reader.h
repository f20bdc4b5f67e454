#pragma once

#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/errors/error_function.h"
#include "abbe/machine/csv_tables.h"
#include "abbe/machine/toml_document.h"
#include "abbe/machine/variable_table.h"

namespace abbe {

/// A function and the positions of the error's own axis that it was measured at, if it says so.
struct ReadFunction {
  ErrorFunction function;
  std::optional<std::array<double, 2>> extent;  ///< numbers of the machine file, before the reference
  bool of_one_test = false;                     ///< some part of it says scope = "test"
};

/// Reads the functions of [errors] in every form of docs/machine-file.md: a number, a table of one
/// form, a list (their sum). Positions are converted to numbers of the machine file, errors stay in
/// the numbers of the file that states them.
class FunctionReader {
 public:
  /// `angle` is the unit of rotary positions in the file being read, rad per number.
  FunctionReader(VariableTable& variables, CsvTables& tables, double angle, Findings& findings)
      : variables_(variables),
        tables_(tables),
        turn_(angle == deg ? 360.0 : 2 * std::numbers::pi / angle),
        findings_(findings) {}

  /// `name` as the file spells it; `own_variable` -1 if the error has none.
  [[nodiscard]] std::optional<ReadFunction> read(const TomlNode& node, const std::string& name,
                                                 int own_variable);

  /// A standard uncertainty: a number or { csv, column, of }, nowhere negative.
  [[nodiscard]] std::optional<ErrorFunction> read_uncertainty(const TomlNode& node, const std::string& name,
                                                              int own_variable);

 private:
  using Function = std::optional<ErrorFunction>;

  /// The part of a leaf that all forms share.
  struct Leaf {
    int variable = -1;
    double ratio = 1;      ///< numbers of the machine file per number of this file
    double reference = 0;  ///< numbers of the machine file
    ErrorFunction::Domain domain;
  };
  /// The domain of an enclosing forward/backward form.
  struct Inherited {
    int variable = -1;
    const TomlEntry* domain = nullptr;
  };
  struct Samples {
    std::vector<double> positions, values;
    std::vector<Mark> marks;  ///< of the positions; empty if they were checked already
    Mark mark;
  };

  Function read_any(const TomlNode& node, const Inherited& inherited);
  Function read_sum(const TomlNode& list, const Inherited& inherited);
  Function read_table_form(const TomlNode& table, const Inherited& inherited);
  Function read_form(std::string_view form, const TomlNode& table, const Inherited& inherited);
  Function read_polynomial(const TomlNode& table, const Inherited& inherited);
  Function read_sine(const TomlNode& table, const Inherited& inherited);
  Function read_samples(const TomlNode& table, const Inherited& inherited);
  Function read_csv(const TomlNode& table, const Inherited& inherited);
  Function read_grid(const TomlNode& table, const Inherited& inherited);
  Function read_directional(const TomlNode& table, const Inherited& inherited);

  std::optional<std::string_view> form_of(const TomlNode& table);
  bool read_scope(const TomlNode& table);
  std::optional<int> read_variable(const TomlNode& table);
  std::optional<Leaf> read_leaf(const TomlNode& table, const Inherited& inherited, bool constant = false);
  std::optional<Samples> csv_samples(const TomlNode& table, const Leaf& leaf);
  Function sampled(const TomlNode& table, const Leaf& leaf, Samples samples);
  std::optional<double> read_period(const TomlNode& table, const Leaf& leaf, Samples& samples);
  bool increasing(const std::vector<double>& positions, const std::vector<Mark>& marks);
  bool flatten_grid(const TomlNode& node, const std::vector<std::vector<double>>& at, std::size_t depth,
                    std::vector<double>& out);
  void widen_extent(int variable, double lo, double hi);
  Function accepted(Function function, Mark mark);

  VariableTable& variables_;
  CsvTables& tables_;
  double turn_;
  Findings& findings_;

  std::string name_;
  int own_variable_ = -1;
  std::optional<std::array<double, 2>> extent_;
  bool of_one_test_ = false;
};

}  // namespace abbe
