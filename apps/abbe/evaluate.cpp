#include <fmt/core.h>

#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/evaluate/diagonal_figures.h"
#include "abbe/evaluate/drift.h"
#include "abbe/evaluate/run_table.h"
#include "abbe/report/measurement_figure.h"
#include "common.h"
#include "evaluate_report.h"
#include "number_check.h"
#include "output_file.h"
#include "verbs.h"

namespace abbe::app {
namespace {

struct EvaluateArguments {
  std::vector<std::string> files;
  std::string as, column, unit, svg;
  std::vector<double> sides;
  std::optional<double> sensor_distance;
  SetupArguments setup;
  bool json = false;
};

std::optional<RunTable> load_runs(const EvaluateArguments& arguments, const std::string& file,
                                  Session& session) {
  const MeasuredUnit* unit = nullptr;
  if (!arguments.unit.empty()) {
    unit = find_measured_unit(arguments.unit);
    if (unit == nullptr || (unit->quantity != Quantity::length && unit->quantity != Quantity::angle)) {
      session.report(option_error("--unit", fmt::format("'{}' is not a unit of deviations", arguments.unit),
                                  fmt::format("one of {}", measured_unit_names())));
      return std::nullopt;
    }
  }
  const std::optional<std::string> text = read_input(file, session);
  if (!text) return std::nullopt;
  Parsed<RunTable> runs = read_runs(file, *text, arguments.column, unit);
  session.report(runs.diagnostics);
  return std::move(runs.value);
}

/// Straightness and angles have the quantity that their name says.
bool quantity_fits(const std::string& as, const RunTable& table, Session& session) {
  const bool angle = table.quantity == Quantity::angle, rotary = table.target_quantity == Quantity::angle;
  const bool fits = as == "angle" ? angle : as == "positioning" ? angle == rotary : !angle;
  if (!fits)
    session.report(option_error(
        "--as",
        fmt::format("the deviations are {}, which {} does not take", angle ? "angles" : "lengths", as),
        "check the unit of the column, or the kind of test"));
  return fits;
}

void finish(const EvaluateArguments& arguments, const std::string& figure, const std::string& text,
            const std::string& json, Session& session) {
  if (!arguments.svg.empty() && !publish_text(arguments.svg, figure, session)) return;
  session.out.write(arguments.json ? json : text);
}

void evaluate_runs(const EvaluateArguments& arguments, Session& session) {
  const std::optional<RunTable> table = load_runs(arguments, arguments.files.front(), session);
  if (!table || !quantity_fits(arguments.as, *table, session)) return;
  const std::optional<RunAnswer> answer = answer_of_runs(arguments.as, *table, arguments.setup, session);
  if (!answer) return;
  const std::string title = fmt::format("{}: {}", arguments.files.front(), arguments.as);
  finish(arguments, arguments.svg.empty() ? "" : figure_of_runs(*table, title, facts_of(*answer)),
         text_of(*answer), json_of(*answer), session);
}

void evaluate_drift(const EvaluateArguments& arguments, Session& session) {
  const std::string& file = arguments.files.front();
  const std::optional<std::string> text = read_input(file, session);
  if (!text) return;
  const Parsed<MeasuredTable> table = read_measured_table(file, *text);
  session.report(table.diagnostics);
  if (!table.value) return;
  const Parsed<DriftFigures> figures = drift_figures(*table.value, arguments.sensor_distance);
  session.report(figures.diagnostics);
  if (!figures.value) return;
  finish(
      arguments,
      arguments.svg.empty() ? "" : figure_of_drift(*table.value, file + ": drift", facts_of(*figures.value)),
      text_of(file, *figures.value), json_of(file, *figures.value), session);
}

/// Two sides for two face diagonals, three for four body diagonals.
bool sides_count(const EvaluateArguments& arguments, Session& session) {
  const std::size_t count = arguments.files.size(), sides = arguments.sides.size();
  if (sides == 0 || (count == 2 && sides == 2) || (count == 4 && sides == 3)) return true;
  session.report(option_error("--sides", fmt::format("{} sides for {} diagonals", sides, count),
                              "two sides for two face diagonals (++, -+), three for four body diagonals "
                              "(+++, -++, +-+, ++-)"));
  return false;
}

/// Sides in another unit, or of another box, would scale the squareness: |sides| is the length of a diagonal.
bool sides_fit(const EvaluateArguments& arguments, const RunTable& table, Session& session) {
  constexpr double kSlack = 0.01;  // a squareness needs its sides no better
  if (arguments.sides.empty()) return true;
  double squares = 0;
  for (const double side : arguments.sides) squares += side * side;
  const double length = table.targets.back() - table.targets.front(), box = std::sqrt(squares);
  if (std::abs(length - box) <= kSlack * box) return true;
  session.report(option_error(
      "--sides",
      fmt::format("{} is {:.6g} mm long, the diagonal of the sides {:.6g} mm", table.file, length, box),
      "lengths in mm along the axes that the diagonals span"));
  return false;
}

/// The diagonals in the order given. The same readings twice are one diagonal under two names: their
/// difference, of which the squareness is made, would be 0.
std::optional<std::vector<RunTable>> load_diagonals(const EvaluateArguments& arguments, Session& session) {
  std::vector<RunTable> tables;
  std::set<std::string> readings;
  for (const std::string& file : arguments.files) {
    std::optional<RunTable> table = load_runs(arguments, file, session);
    if (!table || !quantity_fits("diagonals", *table, session) || !sides_fit(arguments, *table, session))
      return std::nullopt;
    if (!readings.insert(write_runs(*table)).second) {
      session.report(option_error("FILE", fmt::format("{} has the readings of a file before it", file),
                                  "each diagonal is a measurement of its own"));
      return std::nullopt;
    }
    tables.push_back(std::move(*table));
  }
  return tables;
}

void evaluate_diagonals(const EvaluateArguments& arguments, Session& session) {
  if (!arguments.svg.empty() && arguments.files.size() != 1) {
    session.report(option_error("--svg", "a figure shows one diagonal", "evaluate each by itself"));
    return;
  }
  if (!sides_count(arguments, session)) return;
  const auto tables = load_diagonals(arguments, session);
  if (!tables) return;
  const DiagonalAnswer answer = answer_of_diagonals(arguments.files, *tables, arguments.sides);
  finish(arguments, arguments.svg.empty() ? "" : figure_of_runs(tables->front(), arguments.files.front(), {}),
         text_of(answer), json_of(answer), session);
}

void run_evaluate(const EvaluateArguments& arguments, Session& session) {
  if (!arguments.svg.empty() && !is_apart("--svg", arguments.svg, arguments.files, session)) return;
  if (arguments.as != "diagonals" && arguments.files.size() > 1) {
    session.report(option_error("FILE", "several files", "only --as diagonals compares files"));
    return;
  }
  for (const double side : arguments.sides)
    if (!(side > 0)) {
      session.report(option_error("--sides", "a side is not above 0", "lengths in mm"));
      return;
    }
  if (arguments.as == "drift") return evaluate_drift(arguments, session);
  if (arguments.as == "diagonals") return evaluate_diagonals(arguments, session);
  evaluate_runs(arguments, session);
}

void add_setup_options(Command& command, SetupArguments& setup) {
  const auto number = [&](const char* name, double& value, const char* text, const char* type) {
    command.add_option(name, value, text)->check(finite_number())->type_name(type);
  };
  number("--instrument-ppm", setup.instrument_ppm, "standard uncertainty of the instrument's scale", "PPM");
  number("--misalignment-mm", setup.misalignment_mm, "most that beam and axis are apart over the length",
         "MM");
  number("--temperature-range", setup.temperature_range, "width of what the material's temperature may be",
         "K");
  number("--expansion-ppm", setup.expansion_ppm, "expansion of the material per K", "PPM");
  number("--expansion-range-ppm", setup.expansion_range_ppm, "width of what it may be", "PPM");
  number("--temperature-difference", setup.temperature_difference, "of the material from 20 degC", "K");
  number("--environment-um", setup.environment_um, "drift of the set-up over the test", "UM");
  command.add_option("--trials", setup.trials, "draws of the Monte Carlo method, 0 = none (0)")
      ->check(whole_in(0, 10'000'000))
      ->type_name("N");
  command.add_option("--seed", setup.seed, "of its random numbers (1)")->type_name("N");
}

}  // namespace

Verb evaluate_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand(
      "evaluate", "figures of a measurement: positioning, straightness, angle, diagonals, drift");
  auto arguments = std::make_shared<EvaluateArguments>();
  command->add_option("file", arguments->files, "runs or log: CSV with units, or .rtl")
      ->required()
      ->type_name("FILE");
  command->add_option("--as", arguments->as, "positioning, straightness, angle, diagonals, drift")
      ->required()
      ->check(one_of({"positioning", "straightness", "angle", "diagonals", "drift"}))
      ->type_name("KIND");
  command->add_option("--column", arguments->column, "column of the deviations, if there are several")
      ->type_name("NAME");
  command->add_option("--unit", arguments->unit, "unit of the deviations of an .rtl file")->type_name("UNIT");
  command->add_option("--sides", arguments->sides, "lengths along the axes that the diagonals span (mm)")
      ->delimiter(',')
      ->check(finite_number())
      ->type_name("A,B[,C]");
  command
      ->add_option("--sensor-distance", arguments->sensor_distance,
                   "between parallel sensors of a drift test")
      ->check(above_zero())
      ->type_name("MM");
  add_setup_options(*command, arguments->setup);
  command->add_option("--svg", arguments->svg, "picture (SVG)")->type_name("FILE");
  command->add_flag("--json", arguments->json, "JSON on standard output");
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [arguments, &session] { run_evaluate(*arguments, session); }};
}

}  // namespace abbe::app
