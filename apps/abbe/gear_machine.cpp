#include "gear_machine.h"

#include <fmt/core.h>

#include <variant>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/evaluate/measured_table.h"
#include "pose_source.h"

namespace abbe::app {
namespace {

constexpr double kOnTheEnd = 1e-9;  // mm or rad
constexpr double kMuchSecondOrder = 1 * um;

Diagnostic course_error(const std::string& file, std::string message, std::string fix) {
  Diagnostic error;
  error.code = "E-GEAR-COURSE";
  error.place.file = file;
  error.message = std::move(message);
  error.why = "temperatures are those of the moment at which a tooth is cut";
  error.fix = std::move(fix);
  return error;
}

/// Times and sensors of a CSV file with units; nullopt after reporting why not.
std::optional<SensorCourse> read_course(const std::string& path, Session& session) {
  if (path.empty()) return SensorCourse{};
  const std::optional<std::string> text = read_input(path, session);
  if (!text) return std::nullopt;
  const Parsed<MeasuredTable> table = read_measured_table(path, *text);
  session.report(table.diagnostics);
  if (!table.value) return std::nullopt;
  const MeasuredColumn* time = table.value->find("time");
  if (time == nullptr || time->quantity != Quantity::time || time->values.empty()) {
    session.report(course_error(path, "there is no column of times", "a column `time [s]`, and rows"));
    return std::nullopt;
  }
  SensorCourse course;
  course.time = time->values;
  for (std::size_t i = 1; i < course.time.size(); ++i)
    if (!(course.time[i] > course.time[i - 1])) {
      session.report(
          course_error(path, fmt::format("the times do not increase at row {}", i + 1), "sort the rows"));
      return std::nullopt;
    }
  for (const MeasuredColumn& column : table.value->columns) {
    if (&column == time) continue;
    std::vector<double>& values = course.values[column.name];
    for (const double value : column.values) values.push_back(value / column.unit);
  }
  return course;
}

std::optional<CuttingMotion> plan_or_report_cutting(const Machine& machine, const LoadedGear& gear,
                                                    const GearMachineArguments& arguments, Session& session) {
  Diagnostics findings;
  const AxisCommands start = read_near(machine, arguments.near, findings);
  session.report(findings);
  if (has_errors(findings)) return std::nullopt;
  auto planned =
      plan_cutting(machine, gear.job, gear.wheel, static_cast<std::size_t>(arguments.nodes), start);
  if (auto* motion = std::get_if<CuttingMotion>(&planned)) return std::move(*motion);
  report_cutting(std::get<CuttingProblem>(planned), arguments, session);
  return std::nullopt;
}

void warn_of_course(const GearOnMachine& loaded, const std::string& file, Session& session) {
  const std::vector<double>& time = loaded.course.time;
  const double begin = loaded.motion.time(loaded.gear.job.cutting, 0, 0),
               end = loaded.motion.time(loaded.gear.job.cutting, loaded.motion.gaps() - 1,
                                        loaded.motion.nodes - 1);
  if (time.empty() || (time.front() <= begin && time.back() >= end)) return;
  Diagnostic warning;
  warning.severity = Severity::warning;
  warning.code = "W-GEAR-COURSE";
  warning.place.file = file;
  warning.message =
      fmt::format("the course goes from {:.0f} to {:.0f} s, the wheel cuts from {:.0f} to {:.0f} s",
                  time.front(), time.back(), begin, end);
  warning.why = "its first and last values are held: what drifts there is not seen";
  warning.fix = "record the sensors over the whole cut, or check feed and index_time of the gear file";
  session.report(warning);
}

}  // namespace

void report_cutting(const CuttingProblem& problem, const GearMachineArguments& arguments, Session& session) {
  const bool axes = problem.trouble == CuttingProblem::Trouble::axes;
  Diagnostic error;
  error.code = axes ? "E-GEAR-AXES" : "E-TRAVEL";
  error.place.file = arguments.gear;
  error.message = problem.message;
  error.why = axes ? "the wheel would not fill the gap" : "";
  error.fix = axes ? "a machine that turns the gear and, for helical gears, swivels the wheel"
                   : "another wheel, [cutting] middle, or --near";
  session.report(error, axes ? Exit::invalid : Exit::outside);
}

CutCorrection correction_of(std::string_view text) {
  return text == "pose" ? CutCorrection::pose : text == "flank" ? CutCorrection::flank : CutCorrection::none;
}

void report_outside(const std::string& file, Session& session) {
  Diagnostic error;
  error.code = "E-VOL";
  error.place.file = file;
  error.message = "the cut leaves the volume, or the temperatures, in which the errors are known";
  error.why = "an error was held at the end of its table, where nobody has measured";
  error.fix = "another place of the gear, or measure a larger volume";
  session.report(error, Exit::outside);
}

bool within_travels(const GearOnMachine& loaded, const std::vector<AxisCommands>& commands,
                    Session& session) {
  const Machine& machine = loaded.setting.machine;
  for (std::size_t k = 0; k < commands.size(); ++k)
    for (int i = 0; i < machine.axis_count(); ++i) {
      const auto& range = machine.axis(i).range;
      const double q = commands[k][static_cast<std::size_t>(i)];
      if (!range || (q >= (*range)[0] - kOnTheEnd && q <= (*range)[1] + kOnTheEnd)) continue;
      Diagnostic error;
      error.code = "E-TRAVEL";
      error.place.file = machine.files.front();
      error.message = fmt::format(
          "gap {}, {:.3f} mm above the middle of the face: the corrected command {:.6f} "
          "is outside the travel of {}",
          k / loaded.motion.nodes + 1, loaded.motion.height(k % loaded.motion.nodes),
          q / machine.axis_unit(i), machine.axis(i).name);
      error.why = "the nominal command is within, its correction is not";
      error.fix = "another place of the gear, or --lock that axis";
      session.report(error, Exit::outside);
      return false;
    }
  return true;
}

void report_second_order(const std::optional<double>& neglected, const std::string& file, Session& session) {
  if (neglected && *neglected <= kMuchSecondOrder) return;
  Diagnostic warning;
  warning.severity = Severity::warning;
  warning.code = "W-GEAR-LARGE";
  warning.place.file = file;
  warning.message = "the errors are so large that their products matter";
  warning.fix = "figures are of first order in the errors; check the units of the errors";
  session.report(warning);
}

void add_gear_machine_options(Command& command, GearMachineArguments& arguments, Session& session) {
  add_common_options(command, arguments.common, session);
  command.add_option("gear", arguments.gear, "gear file (TOML)")->required()->type_name("GEAR");
  command
      .add_option("--course", arguments.course,
                  "sensors over the time of the cut: CSV with `time [s]`, `T1 [degC]` ..")
      ->type_name("FILE");
  command.add_option("--near", arguments.near, "where the machine stands: A=90; decides the branch")
      ->type_name("AXIS=VALUE,..")
      ->allow_extra_args(false);
  command.add_option("--nodes", arguments.nodes, "places per stroke at which the machine is asked (33)")
      ->check(whole_in(4, 2001))
      ->type_name("N");
}

std::optional<GearOnMachine> load_gear_on_machine(const GearMachineArguments& arguments, Session& session) {
  std::optional<Setting> setting = load_controlled_setting(arguments.common, session);
  std::optional<LoadedGear> gear = load_gear(arguments.gear, session);
  std::optional<SensorCourse> course = read_course(arguments.course, session);
  if (!setting || !gear || !course) return std::nullopt;
  if (!plan_or_report(*setting, course->at(0, setting->environment), session)) return std::nullopt;
  std::optional<CuttingMotion> motion = plan_or_report_cutting(setting->machine, *gear, arguments, session);
  if (!motion) return std::nullopt;
  std::vector<std::string> inputs = setting->machine.files;
  for (const std::string& path : {arguments.gear, arguments.course, arguments.common.environment})
    if (!path.empty()) inputs.push_back(path);
  GearOnMachine loaded{std::move(*setting), std::move(*gear), std::move(*motion), std::move(*course),
                       std::move(inputs)};
  warn_of_course(loaded, arguments.course, session);
  return loaded;
}

std::string motions_csv(const GearOnMachine& loaded, const std::vector<AxisCommands>& commands) {
  const Machine& machine = loaded.setting.machine;
  const CuttingMotion& motion = loaded.motion;
  std::string csv = "gap,height_mm,time_s";
  for (int i = 0; i < machine.axis_count(); ++i) csv += "," + machine.axis(i).name;
  csv += '\n';
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const std::size_t gap = k / motion.nodes, node = k % motion.nodes;
    csv += fmt::format("{},{:.6f},{:.3f}", gap + 1, motion.height(node),
                       motion.time(loaded.gear.job.cutting, gap, node));
    for (int i = 0; i < machine.axis_count(); ++i) {
      csv += ',';
      append_fixed(csv, commands[k][static_cast<std::size_t>(i)] / machine.axis_unit(i), 7);
    }
    csv += '\n';
  }
  return csv;
}

CutOptions cut_options(const GearOnMachine& loaded) {
  CutOptions options;
  options.model = loaded.setting.model;
  options.environment = loaded.setting.environment;
  options.course = loaded.course;
  return options;
}

}  // namespace abbe::app
