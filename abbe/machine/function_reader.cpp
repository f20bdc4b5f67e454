#include "abbe/machine/function_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "abbe/core/number.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

struct FormKeys {
  std::string_view form;
  std::vector<std::string> keys;  ///< all that may stand beside it
};

const std::vector<FormKeys> kForms{
    {"poly", {"poly", "of", "reference", "domain", "times", "scope"}},
    {"table", {"table", "interpolation", "periodic", "of", "reference", "domain", "times", "scope"}},
    {"csv", {"csv", "column", "interpolation", "periodic", "of", "reference", "domain", "times", "scope"}},
    {"sine", {"sine", "of", "reference", "domain", "times", "scope"}},
    {"grid", {"grid", "at", "of", "reference", "domain", "times", "scope"}},
    {"forward", {"forward", "backward", "of", "domain", "times", "scope"}},
};

const std::vector<std::string> kAllKeys{
    "poly",     "table", "csv",       "sine",   "grid",  "forward", "backward", "interpolation",
    "periodic", "of",    "reference", "domain", "times", "column",  "at",       "scope"};

constexpr std::string_view kFormList = "a form is one of poly, table, csv, sine, grid, forward and backward";

}  // namespace

std::optional<ReadFunction> FunctionReader::read(const TomlNode& node, const std::string& name,
                                                 int own_variable) {
  name_ = name;
  own_variable_ = own_variable;
  extent_.reset();
  of_one_test_ = false;
  auto function = read_any(node, {});
  if (!function) return std::nullopt;
  return ReadFunction{std::move(*function), extent_, of_one_test_};
}

std::optional<ErrorFunction> FunctionReader::read_uncertainty(const TomlNode& node, const std::string& name,
                                                              int own_variable) {
  name_ = name;
  own_variable_ = own_variable;
  if (node.kind == TomlNode::Kind::number) {
    const auto number = read_value(node, "the uncertainty of " + name, findings_);
    if (!number) return std::nullopt;
    if (*number < 0) {
      findings_.error("E-UNCERTAINTY", node.mark, fmt::format("the uncertainty of {} is negative", name),
                      "a standard uncertainty is a standard deviation", "write it without the minus");
      return std::nullopt;
    }
    return ErrorFunction::constant(*number);
  }
  if (node.kind != TomlNode::Kind::table || node.find("csv") == nullptr) {
    findings_.error("E-UNCERTAINTY", node.mark,
                    fmt::format("the uncertainty of {} is {}, expected a number or {{ csv = .. }}", name,
                                kind_name(node.kind)),
                    "", "write one number, or { csv = \"file.csv\", column = \"name\" }");
    return std::nullopt;
  }
  const std::size_t errors_before = findings_.error_count();
  refuse_other_keys(node, {"csv", "column", "of"}, "the uncertainty of " + name, findings_);
  const auto leaf = read_leaf(node, {});
  auto samples = leaf ? csv_samples(node, *leaf) : std::nullopt;
  if (!samples || findings_.error_count() != errors_before) return std::nullopt;
  const auto negative =
      std::find_if(samples->values.begin(), samples->values.end(), [](double u) { return u < 0; });
  if (negative != samples->values.end()) {
    const auto row = static_cast<std::size_t>(negative - samples->values.begin());
    findings_.error("E-UNCERTAINTY", node.mark, fmt::format("the uncertainty of {} is negative", name),
                    fmt::format("at position {}", to_shortest(samples->positions[row])),
                    "correct the CSV file");
    return std::nullopt;
  }
  return sampled(node, *leaf, std::move(*samples));
}

FunctionReader::Function FunctionReader::read_any(const TomlNode& node, const Inherited& inherited) {
  switch (node.kind) {
    case TomlNode::Kind::number:
      if (const auto number = read_value(node, name_, findings_)) return ErrorFunction::constant(*number);
      return std::nullopt;
    case TomlNode::Kind::array:
      return read_sum(node, inherited);
    case TomlNode::Kind::table:
      return read_table_form(node, inherited);
    default:
      findings_.error(
          "E-TYPE", node.mark,
          fmt::format("{} is {}, expected a number, a form in braces or a list", name_, kind_name(node.kind)),
          "",
          node.kind == TomlNode::Kind::text ? "numbers stand without quotes"
                                            : "write a number, or { poly = [..] }");
      return std::nullopt;
  }
}

FunctionReader::Function FunctionReader::read_sum(const TomlNode& list, const Inherited& inherited) {
  if (list.items.empty()) {
    findings_.error("E-FORM", list.mark, fmt::format("{} is an empty list", name_),
                    "a list is the sum of its items", "write 0 for an error that was measured as zero");
    return std::nullopt;
  }
  std::vector<ErrorFunction> terms;
  for (const TomlNode& item : list.items) {
    if (item.kind == TomlNode::Kind::array) {
      findings_.error("E-FORM", item.mark, fmt::format("a list inside the list of {}", name_),
                      "a list is the sum of its items, so samples written like this would be added up",
                      "write samples as { table = [[0, 0], [100, 2.1]] }");
      return std::nullopt;
    }
    if (auto term = read_any(item, inherited)) terms.push_back(std::move(*term));
  }
  if (terms.size() != list.items.size()) return std::nullopt;
  return ErrorFunction::sum(std::move(terms));
}

std::optional<std::string_view> FunctionReader::form_of(const TomlNode& table) {
  const std::size_t errors_before = findings_.error_count();
  refuse_other_keys(table, kAllKeys, name_, findings_);
  if (findings_.error_count() != errors_before) return std::nullopt;
  const FormKeys* form = nullptr;
  for (const FormKeys& candidate : kForms) {
    const bool there = table.find(candidate.form) != nullptr ||
                       (candidate.form == "forward" && table.find("backward") != nullptr);
    if (!there) continue;
    if (form != nullptr) {
      findings_.error("E-FORM", table.mark,
                      fmt::format("{} has two forms, {} and {}", name_, form->form, candidate.form),
                      std::string(kFormList), "write a list to add two forms: [ { .. }, { .. } ]");
      return std::nullopt;
    }
    form = &candidate;
  }
  if (form == nullptr) {
    findings_.error("E-FORM", table.mark, fmt::format("{} has no form", name_), std::string(kFormList),
                    "add one, such as poly = [0, 0.05]");
    return std::nullopt;
  }
  for (const TomlEntry& entry : table.entries) {
    if (std::find(form->keys.begin(), form->keys.end(), entry.key) != form->keys.end()) continue;
    findings_.error("E-FORM-KEY", entry.mark,
                    fmt::format("{} does not go with {}", in_quotes(entry.key), form->form),
                    "beside it may stand " + listed({form->keys.begin() + 1, form->keys.end()}, "and"),
                    form->form == "forward" ? "put it into the forms of forward and backward" : "remove it");
  }
  if (findings_.error_count() != errors_before) return std::nullopt;
  return form->form;
}

FunctionReader::Function FunctionReader::read_table_form(const TomlNode& table, const Inherited& inherited) {
  const auto form = form_of(table);
  if (!form || !read_scope(table)) return std::nullopt;
  auto function = read_form(*form, table, inherited);
  const TomlEntry* times = table.find("times");
  if (times == nullptr) return function;
  auto factor = read_any(times->value, {});
  if (!function || !factor) return std::nullopt;
  std::vector<ErrorFunction> factors;
  factors.push_back(std::move(*function));
  factors.push_back(std::move(*factor));
  return ErrorFunction::product(std::move(factors));
}

/// scope = "test": true only of the test it was identified from (sines of its time, say), not of the machine.
bool FunctionReader::read_scope(const TomlNode& table) {
  const TomlEntry* entry = table.find("scope");
  if (entry == nullptr) return true;
  const auto choice = read_choice(entry->value, {"machine", "test"}, "scope of " + name_, findings_);
  if (!choice) return false;
  of_one_test_ = of_one_test_ || *choice == 1;
  return true;
}

FunctionReader::Function FunctionReader::read_form(std::string_view form, const TomlNode& table,
                                                   const Inherited& inherited) {
  if (form == "poly") return read_polynomial(table, inherited);
  if (form == "table") return read_samples(table, inherited);
  if (form == "csv") return read_csv(table, inherited);
  if (form == "sine") return read_sine(table, inherited);
  if (form == "grid") return read_grid(table, inherited);
  return read_directional(table, inherited);
}

std::optional<int> FunctionReader::read_variable(const TomlNode& table) {
  if (const TomlEntry* of = table.find("of")) return variables_.index_of(of->value, findings_);
  if (own_variable_ >= 0) return own_variable_;
  findings_.error("E-NO-VARIABLE", table.mark, fmt::format("{} has no variable of its own", name_),
                  "errors of fixed bodies, the tool and the workpiece depend on no position of their own",
                  "write a constant, or name the variable: of = \"T1\"");
  return std::nullopt;
}

std::optional<FunctionReader::Leaf> FunctionReader::read_leaf(const TomlNode& table,
                                                              const Inherited& inherited, bool constant) {
  Leaf leaf;
  const TomlEntry* domain = table.find("domain");
  if (constant && domain == nullptr && own_variable_ < 0 && table.find("of") == nullptr) return leaf;
  const auto variable = read_variable(table);
  if (!variable) return std::nullopt;
  leaf.variable = *variable;
  leaf.ratio = variables_.ratio(leaf.variable);
  bool ok = true;
  if (const TomlEntry* entry = table.find("reference")) {
    const auto reference = read_quantity(entry->value, leaf.ratio, "reference of " + name_, findings_);
    ok = reference.has_value();
    leaf.reference = reference.value_or(0);
  }
  if (domain == nullptr && inherited.domain != nullptr && inherited.variable == leaf.variable) {
    domain = inherited.domain;
  }
  if (domain != nullptr) {
    const auto ends = read_interval(domain->value, leaf.ratio, "domain of " + name_, findings_);
    if (!ends) return std::nullopt;
    leaf.domain = {(*ends)[0] - leaf.reference, (*ends)[1] - leaf.reference};
    widen_extent(leaf.variable, (*ends)[0], (*ends)[1]);
  }
  if (!ok) return std::nullopt;
  return leaf;
}

FunctionReader::Function FunctionReader::read_polynomial(const TomlNode& table, const Inherited& inherited) {
  const TomlNode& node = table.find("poly")->value;
  auto coefficients = read_values(node, 0, "poly of " + name_, findings_);
  const auto leaf = read_leaf(table, inherited, coefficients && coefficients->size() == 1);
  if (!coefficients || !leaf) return std::nullopt;
  if (coefficients->empty()) {
    findings_.error("E-COUNT", node.mark, fmt::format("poly of {} has no coefficients", name_), "",
                    "write [c0, c1, ..] for c0 + c1 v + ..");
    return std::nullopt;
  }
  if (leaf->variable < 0) return ErrorFunction::constant(coefficients->front());
  // c_i v_file^i = (c_i / ratio^i) v^i,  v = ratio v_file
  double scale = 1;
  for (double& c : *coefficients) {
    c /= scale;
    scale *= leaf->ratio;
  }
  return accepted(
      ErrorFunction::polynomial(leaf->variable, std::move(*coefficients), leaf->reference, leaf->domain),
      node.mark);
}

FunctionReader::Function FunctionReader::read_sine(const TomlNode& table, const Inherited& inherited) {
  const TomlNode& node = table.find("sine")->value;
  const auto numbers = read_values(node, 3, "sine of " + name_, findings_);
  const auto leaf = read_leaf(table, inherited);
  if (!numbers || !leaf) return std::nullopt;
  return accepted(ErrorFunction::sine(leaf->variable, (*numbers)[0], (*numbers)[1] / leaf->ratio,
                                      (*numbers)[2], leaf->reference, leaf->domain),
                  node.mark);
}

FunctionReader::Function FunctionReader::read_samples(const TomlNode& table, const Inherited& inherited) {
  const TomlNode& node = table.find("table")->value;
  const std::string what = "table of " + name_;
  const auto leaf = read_leaf(table, inherited, node.items.size() == 1);
  if (!expect_kind(node, TomlNode::Kind::array, what, findings_)) return std::nullopt;
  if (node.items.empty()) {
    findings_.error("E-COUNT", node.mark, what + " has no samples", "", "write [[position, error], ..]");
    return std::nullopt;
  }
  Samples samples;
  samples.mark = node.mark;
  for (const TomlNode& row : node.items) {
    if (findings_.full()) return std::nullopt;
    const auto pair = read_values(row, 2, "a sample in the " + what, findings_);
    if (!pair) continue;
    samples.positions.push_back((*pair)[0]);
    samples.values.push_back((*pair)[1]);
    samples.marks.push_back(row.items[0].mark);
  }
  if (samples.positions.size() != node.items.size() || !leaf) return std::nullopt;
  return sampled(table, *leaf, std::move(samples));
}

FunctionReader::Function FunctionReader::read_csv(const TomlNode& table, const Inherited& inherited) {
  const auto leaf = read_leaf(table, inherited);
  auto samples = leaf ? csv_samples(table, *leaf) : std::nullopt;
  if (!samples) return std::nullopt;
  return sampled(table, *leaf, std::move(*samples));
}

std::optional<FunctionReader::Samples> FunctionReader::csv_samples(const TomlNode& table, const Leaf& leaf) {
  const TomlEntry& csv = *table.find("csv");
  const TomlEntry* column_entry = table.find("column");
  const auto path = read_text(csv.value, "csv of " + name_, findings_);
  const auto column = column_entry == nullptr
                          ? std::optional<std::string>(name_)
                          : read_text(column_entry->value, "column of " + name_, findings_);
  if (!path || !column) return std::nullopt;
  auto columns = tables_.read(*path, csv.value.mark, variables_.at(leaf.variable).name, *column,
                              column_entry == nullptr ? csv.value.mark : column_entry->value.mark, findings_);
  if (!columns) return std::nullopt;
  return Samples{std::move(columns->positions), std::move(columns->values), {}, csv.value.mark};
}

FunctionReader::Function FunctionReader::sampled(const TomlNode& table, const Leaf& leaf, Samples samples) {
  auto interpolation = ErrorFunction::Interpolation::linear;
  if (const TomlEntry* entry = table.find("interpolation")) {
    const auto choice =
        read_choice(entry->value, {"linear", "cubic"}, "interpolation of " + name_, findings_);
    if (!choice) return std::nullopt;
    if (*choice == 1) interpolation = ErrorFunction::Interpolation::cubic;
  }
  if (!samples.marks.empty() && !increasing(samples.positions, samples.marks)) return std::nullopt;
  const auto period = read_period(table, leaf, samples);
  if (!period) return std::nullopt;
  if (leaf.variable < 0) return ErrorFunction::constant(samples.values.front());
  if (*period == 0) {
    // The file's positions are of v - reference; the extent is told in v.
    widen_extent(leaf.variable, samples.positions.front() * leaf.ratio + leaf.reference,
                 samples.positions.back() * leaf.ratio + leaf.reference);
  }
  for (double& position : samples.positions) position *= leaf.ratio;
  return accepted(ErrorFunction::table(leaf.variable, std::move(samples.positions), std::move(samples.values),
                                       interpolation, leaf.reference, *period * leaf.ratio, leaf.domain),
                  samples.mark);
}

/// The period in numbers of this file, 0 if the table is not periodic; nullopt after a mistake.
std::optional<double> FunctionReader::read_period(const TomlNode& table, const Leaf& leaf, Samples& samples) {
  const TomlEntry* entry = table.find("periodic");
  if (entry == nullptr) return 0.0;
  const auto periodic = read_flag(entry->value, "periodic of " + name_, findings_);
  if (!periodic) return std::nullopt;
  if (!*periodic) return 0.0;
  const Body* axis = leaf.variable < 0 ? nullptr : variables_.position_of(leaf.variable);
  if (axis == nullptr || axis->type != AxisType::rotary) {
    findings_.error("E-PERIODIC", entry->mark,
                    leaf.variable < 0
                        ? fmt::format("{} has no variable that could repeat", name_)
                        : fmt::format("{} is not a rotary axis", variables_.at(leaf.variable).name),
                    "only the position of a rotary axis repeats after a turn", "remove periodic");
    return std::nullopt;
  }
  if (table.find("domain") != nullptr) {
    findings_.error("E-PERIODIC", table.find("domain")->mark,
                    fmt::format("domain of the periodic table of {}", name_), "a periodic table has no ends",
                    "remove domain or periodic");
    return std::nullopt;
  }
  // A turn written with few digits (6.2831853) is still a turn.
  constexpr double kSameTurn = 1e-7;
  const double span = samples.positions.back() - samples.positions.front();
  if (std::abs(span - turn_) <= kSameTurn * turn_) {
    samples.positions.back() = samples.positions.front() + turn_;
    if (samples.values.back() != samples.values.front()) {
      findings_.error(
          "E-PERIODIC", samples.mark,
          fmt::format("the ends of the periodic table of {} are one turn apart and differ", name_),
          fmt::format("the same position would have two errors, {} and {}",
                      to_shortest(samples.values.front()), to_shortest(samples.values.back())),
          "give both the same value, or remove the last sample");
      return std::nullopt;
    }
  } else if (span > turn_) {
    findings_.error("E-PERIODIC", samples.mark,
                    fmt::format("the periodic table of {} spans more than one turn", name_),
                    fmt::format("{} is more than {}", to_shortest(span), to_shortest(turn_)),
                    "keep the samples of one turn");
    return std::nullopt;
  }
  return turn_;
}

FunctionReader::Function FunctionReader::read_directional(const TomlNode& table, const Inherited& outer) {
  const TomlEntry* forward = table.find("forward");
  const TomlEntry* backward = table.find("backward");
  if (forward == nullptr || backward == nullptr) {
    findings_.error("E-FORM", (forward == nullptr ? backward : forward)->mark,
                    fmt::format("{} has no {}", name_, forward == nullptr ? "forward" : "backward"),
                    "an error that depends on the direction of approach has both",
                    "add it; 0 if there is no error that way");
    return std::nullopt;
  }
  const auto variable = read_variable(table);
  if (!variable) return std::nullopt;
  if (variables_.position_of(*variable) == nullptr) {
    findings_.error("E-VARIABLE", table.find("of")->value.mark,
                    fmt::format("{} has no direction of approach", in_quotes(variables_.at(*variable).name)),
                    "only positions of axes are approached from a side", "name an axis");
    return std::nullopt;
  }
  Inherited inherited = outer;
  if (const TomlEntry* domain = table.find("domain")) inherited = {*variable, domain};
  auto up = read_any(forward->value, inherited);
  auto down = read_any(backward->value, inherited);
  if (!up || !down) return std::nullopt;
  return ErrorFunction::directional(*variable, std::move(*up), std::move(*down));
}

bool FunctionReader::increasing(const std::vector<double>& positions, const std::vector<Mark>& marks) {
  for (std::size_t i = 1; i < positions.size(); ++i) {
    if (positions[i] > positions[i - 1]) continue;
    findings_.error("E-POSITIONS", marks[i],
                    fmt::format("position {} of {} does not increase", to_shortest(positions[i]), name_),
                    "positions are strictly increasing", "sort the samples and merge equal positions");
    return false;
  }
  return true;
}

void FunctionReader::widen_extent(int variable, double lo, double hi) {
  if (variable != own_variable_) return;
  extent_ =
      extent_ ? std::array{std::min((*extent_)[0], lo), std::max((*extent_)[1], hi)} : std::array{lo, hi};
}

FunctionReader::Function FunctionReader::accepted(Function function, Mark mark) {
  if (!function) {
    findings_.error(
        "E-FUNCTION", mark, fmt::format("the numbers of {} give no usable function", name_),
        "some are too large or too close together to calculate with, or the domain holds no part of a table",
        "check the numbers and [units]");
  }
  return function;
}

}  // namespace abbe
