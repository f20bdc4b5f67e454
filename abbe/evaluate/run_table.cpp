#include "abbe/evaluate/run_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/evaluate/text_findings.h"

namespace abbe {
namespace {

constexpr double kSameTarget = 1e-6;  // of the span
constexpr double kLargeLength = 1.0, kLargeAngle = 0.01;
constexpr double kOutlier = 8.0;            // pooled standard deviations
constexpr double kLeastScatter = 0.2 * um;  // what instruments resolve: closer readings are no outliers
constexpr double kLeastScatterAngle = 1 * urad;

double shown(double value, Quantity quantity) { return quantity == Quantity::angle ? value / deg : value; }
double shown_error(double value, Quantity quantity) {
  return quantity == Quantity::angle ? value / urad : value / um;
}
std::string_view error_unit(Quantity quantity) { return quantity == Quantity::angle ? "urad" : "um"; }

/// The targets of all readings, each once, increasing.
std::vector<double> targets_of(const std::vector<RunReading>& readings) {
  std::vector<double> all;
  for (const RunReading& reading : readings) all.push_back(reading.target);
  std::sort(all.begin(), all.end());
  const double same = all.empty() ? 0 : kSameTarget * (all.back() - all.front());
  std::vector<double> targets;
  for (const double target : all)
    if (targets.empty() || target - targets.back() > same) targets.push_back(target);
  return targets;
}

/// Index of the target nearest to `value`; `targets` is not empty.
Eigen::Index index_of(const std::vector<double>& targets, double value) {
  const auto above = std::lower_bound(targets.begin(), targets.end(), value);
  if (above == targets.begin()) return 0;
  if (above == targets.end() || value - *(above - 1) < *above - value) return above - targets.begin() - 1;
  return above - targets.begin();
}

/// One direction of approach: numbers of runs as they first appear, and the readings of each by target. Until
/// nothing is missing only what was read takes memory, whatever the columns of a file say.
struct Direction {
  std::vector<int> runs;
  std::vector<std::map<std::size_t, const RunReading*>> columns;
  std::map<int, std::size_t> index;  ///< of a run

  std::map<std::size_t, const RunReading*>& column(int run) {
    const auto [known, fresh] = index.try_emplace(run, runs.size());
    if (!fresh) return columns[known->second];
    runs.push_back(run);
    return columns.emplace_back();
  }
};

void report_missing(const RunTable& table, const Direction& direction, const char* sign,
                    TextFindings& findings) {
  for (std::size_t j = 0; j < direction.columns.size(); ++j)
    for (std::size_t i = 0; i < table.targets.size() && !findings.full(); ++i)
      if (direction.columns[j].count(i) == 0)
        findings.error("E-RUN-MISSING", 0,
                       fmt::format("run {} in direction {} has no reading at {:.6g}", direction.runs[j], sign,
                                   shown(table.targets[i], table.target_quantity)),
                       "means and standard deviations need every target in every run",
                       "measure it, or remove the run or the target");
}

Eigen::MatrixXd matrix_of(const Direction& direction, std::size_t targets) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(targets),
                         static_cast<Eigen::Index>(direction.columns.size()));
  for (std::size_t j = 0; j < direction.columns.size(); ++j)
    for (std::size_t i = 0; i < targets; ++i)
      values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          direction.columns[j].at(i)->deviation;
  return values;
}

void judge_size(const RunTable& table, const std::vector<RunReading>& readings, TextFindings& findings) {
  double interval = table.targets.back() - table.targets.front();
  for (std::size_t i = 1; i < table.targets.size(); ++i)
    interval = std::min(interval, table.targets[i] - table.targets[i - 1]);
  const auto worst = std::max_element(
      readings.begin(), readings.end(),
      [](const RunReading& a, const RunReading& b) { return std::abs(a.deviation) < std::abs(b.deviation); });
  const double size = std::abs(worst->deviation);
  const std::string what = fmt::format(
      "a deviation of {:.6g} {}", shown_error(worst->deviation, table.quantity), error_unit(table.quantity));
  if (table.quantity == table.target_quantity && size > interval / 2) {
    findings.error("E-RUN-LARGE", worst->line, what + ": more than half the distance of two targets",
                   "targets are swapped, or the unit is wrong", "check the columns and their units");
  } else if (size > (table.quantity == Quantity::angle ? kLargeAngle : kLargeLength)) {
    findings.warning("W-RUN-LARGE", worst->line, what, "machine tools are rarely that wrong",
                     "check the unit of the column: um or mm, urad or arcsec");
  }
}

/// Median of a row of values without its entry j.
double median_of_others(const Eigen::MatrixXd& values, Eigen::Index row, Eigen::Index j) {
  std::vector<double> others;
  for (Eigen::Index k = 0; k < values.cols(); ++k)
    if (k != j) others.push_back(values(row, k));
  const auto middle = others.begin() + static_cast<std::ptrdiff_t>(others.size() / 2);
  std::nth_element(others.begin(), middle, others.end());
  return *middle;
}

void judge_outliers(const RunTable& table, const Eigen::MatrixXd& values, const Direction& direction,
                    TextFindings& findings) {
  constexpr Eigen::Index kFewestRuns = 4;  // three others, so that one bad reading does not make their median
  if (values.cols() < kFewestRuns) return;
  const double least = table.quantity == Quantity::angle ? kLeastScatterAngle : kLeastScatter;
  const double all = (values.colwise() - values.rowwise().mean()).squaredNorm();
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    // Without this target, or a reading would hide behind the scatter that it makes.
    const double own = (values.row(i).array() - values.row(i).mean()).square().sum();
    const double rest = std::max(all - own, 0.0);
    const double scatter =
        std::max(std::sqrt(rest / static_cast<double>((values.rows() - 1) * (values.cols() - 1))), least);
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
      const double apart = values(i, j) - median_of_others(values, i, j);
      if (std::abs(apart) < kOutlier * scatter) continue;
      const RunReading& reading =
          *direction.columns[static_cast<std::size_t>(j)].at(static_cast<std::size_t>(i));
      findings.warning("W-RUN-OUTLIER", reading.line,
                       fmt::format("the reading differs by {:.3g} {} from the other runs at {:.6g}",
                                   shown_error(apart, table.quantity), error_unit(table.quantity),
                                   shown(reading.target, table.target_quantity)),
                       "it was not left out: that is for whoever measured to decide",
                       "look for swapped targets, a bumped optic, a lost count");
    }
  }
}

struct RunColumns {
  const MeasuredColumn *target = nullptr, *run = nullptr, *direction = nullptr, *value = nullptr;
};

const MeasuredColumn* column_or_complain(const MeasuredTable& table, std::string_view name,
                                         TextFindings& findings) {
  const MeasuredColumn* column = table.find(name);
  if (column == nullptr)
    findings.error("E-RUN-COLUMN", 0, fmt::format("there is no column '{}'", name),
                   "a run needs target, run, direction and a column of deviations",
                   "name it in the header: target [mm], run, direction, deviation [um]");
  return column;
}

/// The column of deviations: the one asked for, or the only one that is left.
const MeasuredColumn* value_column(const MeasuredTable& table, std::string_view name,
                                   TextFindings& findings) {
  if (!name.empty()) return column_or_complain(table, name, findings);
  const MeasuredColumn* found = nullptr;
  for (const MeasuredColumn& column : table.columns) {
    if (column.name == "target" || column.name == "run" || column.name == "direction") continue;
    if (found != nullptr) {
      findings.error(
          "E-RUN-COLUMN", 0,
          fmt::format("columns '{}' and '{}': which holds the deviations?", found->name, column.name),
          "nothing is guessed", "name the column that is meant");
      return nullptr;
    }
    found = &column;
  }
  return found != nullptr ? found : column_or_complain(table, "deviation", findings);
}

void expect_unit(const MeasuredColumn* column, TextFindings& findings) {
  if (column == nullptr || column->quantity == Quantity::length || column->quantity == Quantity::angle)
    return;
  findings.error("E-RUN-COLUMN", 0,
                 fmt::format("the column '{}' states no unit of length or angle", column->name),
                 "a wrong unit makes an error a thousand times too large",
                 fmt::format("write {} [um] or another of [{}]", column->name, measured_unit_names()));
}

std::optional<RunColumns> run_columns(const MeasuredTable& table, std::string_view name,
                                      TextFindings& findings) {
  RunColumns columns;
  columns.target = column_or_complain(table, "target", findings);
  columns.run = column_or_complain(table, "run", findings);
  columns.direction = column_or_complain(table, "direction", findings);
  columns.value = value_column(table, name, findings);
  expect_unit(columns.target, findings);
  expect_unit(columns.value, findings);
  if (findings.failed()) return std::nullopt;
  return columns;
}

}  // namespace

double reading_scatter(const RunTable& table) {
  double sum = 0, freedom = 0;
  for (const Eigen::MatrixXd* values : {&table.forward, &table.backward}) {
    if (values->cols() < 2) continue;
    // s^2 = sum (x_ij - x_i)^2 / (targets (runs - 1)), over both directions
    sum += (values->colwise() - values->rowwise().mean()).squaredNorm();
    freedom += static_cast<double>(values->rows() * (values->cols() - 1));
  }
  return freedom > 0 ? std::sqrt(sum / freedom) : 0;
}

Parsed<RunTable> sort_runs(const std::string& file, const std::vector<RunReading>& readings,
                           Quantity target_quantity, Quantity quantity) {
  Parsed<RunTable> out;
  TextFindings findings(file);
  RunTable table{file, targets_of(readings), {}, {}, target_quantity, quantity};
  if (table.targets.size() < 2) {
    findings.error("E-RUN-FEW", 0, fmt::format("{} target positions", table.targets.size()),
                   "a course along the axis needs at least two", "measure at more targets");
    return {std::nullopt, findings.take()};
  }
  std::array<Direction, 2> directions;
  for (const RunReading& reading : readings) {
    const auto i = static_cast<std::size_t>(index_of(table.targets, reading.target));
    auto& column = directions[reading.increasing ? 0 : 1].column(reading.run);
    if (column.count(i) != 0)
      findings.error("E-RUN-TWICE", reading.line,
                     fmt::format("run {} was already at {:.6g} in this direction (line {})", reading.run,
                                 shown(reading.target, target_quantity), column[i]->line),
                     "which of the readings counts cannot be told", "give each run its own number");
    column[i] = &reading;
  }
  report_missing(table, directions[0], "+", findings);
  report_missing(table, directions[1], "-", findings);
  if (!findings.failed()) {
    table.forward = matrix_of(directions[0], table.targets.size());
    table.backward = matrix_of(directions[1], table.targets.size());
    judge_size(table, readings, findings);
    judge_outliers(table, table.forward, directions[0], findings);
    judge_outliers(table, table.backward, directions[1], findings);
  }
  if (!findings.failed()) out.value = std::move(table);
  out.diagnostics = findings.take();
  return out;
}

Parsed<RunTable> runs_of(const MeasuredTable& table, std::string_view column) {
  TextFindings findings(table.file);
  const std::optional<RunColumns> columns = run_columns(table, column, findings);
  if (!columns) return {std::nullopt, findings.take()};
  const bool absolute = columns->value->name == "measured";
  std::vector<RunReading> readings;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double run = columns->run->values[i];
    if (run < 1 || run > 1e6 || run != std::floor(run)) {
      findings.error("E-RUN-COLUMN", table.lines[i], fmt::format("{:g} is not the number of a run", run), "",
                     "count runs 1, 2, 3 ..");
      continue;
    }
    const double target = columns->target->values[i], value = columns->value->values[i];
    readings.push_back({target, absolute ? value - target : value, static_cast<int>(run),
                        columns->direction->values[i] > 0, table.lines[i]});
  }
  if (absolute && columns->value->quantity != columns->target->quantity)
    findings.error("E-RUN-COLUMN", 0, "target and measured are different quantities",
                   "the deviation is their difference", "state both in mm, or both in deg");
  if (findings.failed()) return {std::nullopt, findings.take()};
  return sort_runs(table.file, readings, columns->target->quantity, columns->value->quantity);
}

Parsed<RunTable> read_runs(const std::string& file, std::string_view text, std::string_view column,
                           const MeasuredUnit* unit) {
  const std::string_view head = text.substr(0, 4096);
  if (head.find("HEADER::") != std::string_view::npos || head.find("TARGET DATA::") != std::string_view::npos)
    return read_rtl(file, text, unit);
  Parsed<MeasuredTable> table = read_measured_table(file, text);
  if (!table.value) return {std::nullopt, std::move(table.diagnostics)};
  return runs_of(*table.value, column);
}

std::string write_runs(const RunTable& table) {
  const bool rotary = table.target_quantity == Quantity::angle, angle = table.quantity == Quantity::angle;
  std::string text =
      fmt::format("target [{}],run,direction,deviation [{}]\n", rotary ? "deg" : "mm", angle ? "urad" : "um");
  const auto add = [&](const Eigen::MatrixXd& values, char sign) {
    for (Eigen::Index j = 0; j < values.cols(); ++j)
      for (Eigen::Index i = 0; i < values.rows(); ++i)
        text +=
            fmt::format("{},{},{},{}\n",
                        to_shortest(shown(table.targets[static_cast<std::size_t>(i)], table.target_quantity)),
                        j + 1, sign, to_shortest(shown_error(values(i, j), table.quantity)));
  };
  add(table.forward, '+');
  add(table.backward, '-');
  return text;
}

}  // namespace abbe
