#include "common.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <variant>

#include "abbe/chain/method_fit.h"
#include "abbe/core/file.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/machine/read_machine.h"
#include "csv.h"
#include "environment_log.h"
#include "number_check.h"

namespace abbe::app {
namespace {

constexpr double kTravelSlack = 1e-9;  ///< mm or rad: rounding of decimal degrees is not outside

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

/// Puts one value of --set or of the environment file where it belongs.
void set_value(const Machine& machine, std::string_view option, const std::string& name, double value,
               Environment& environment, Diagnostics& diagnostics) {
  const NameMeaning meaning = meaning_of(machine, name);
  switch (meaning.kind) {
    case NameMeaning::Kind::position:
      diagnostics.push_back(option_error(option, fmt::format("'{}' is an axis, not a sensor", name),
                                         fmt::format("give axis positions with --at {}=...", name)));
      return;
    case NameMeaning::Kind::approach:
      diagnostics.push_back(option_error(option,
                                         fmt::format("'{}' is a direction of approach, not a sensor", name),
                                         "give it with --approach"));
      return;
    case NameMeaning::Kind::unknown:
      if (name == "t") return;  // time is always known; a machine without it does not care
      if (name.starts_with("v.") || name.starts_with("a.")) {
        diagnostics.push_back(option_error(option,
                                           fmt::format("'{}': this chain has no such moving axis", name),
                                           suggestion(machine, name)));
        return;
      }
      diagnostics.push_back(option_warning(
          option, fmt::format("no error of this machine depends on '{}'", name), suggestion(machine, name)));
      return;
    default:
      environment.insert_or_assign(name, value);
  }
}

void read_environment_file(const Machine& machine, const std::string& path, Session& session,
                           Environment& environment, Diagnostics& diagnostics) {
  auto opened = CsvReader::open(path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, path);
    return;
  }
  auto& reader = std::get<CsvReader>(opened);
  if (is_log_header(reader.header())) {
    for (const auto& [name, value] : last_of_log(machine, path, session, diagnostics))
      set_value(machine, path, name, value, environment, diagnostics);
    return;
  }
  const bool has_row = reader.next();
  std::vector<double> values;
  for (std::size_t column = 0; has_row && column < reader.header().size(); ++column) {
    const std::optional<double> value = reader.number(column);
    if (!value) break;
    values.push_back(*value);
  }
  if (!reader.failed() && !has_row) {
    diagnostics.push_back(reader.error_at_line("E-CSV", "no row of values below the header"));
  }
  if (!reader.failed() && has_row && reader.next()) {
    Diagnostic several = reader.error_at_line("E-CSV", "more than one row of values");
    several.fix = "keep the one row that holds for this run; values that change belong into --points";
    diagnostics.push_back(std::move(several));
  }
  if (reader.failed()) {
    diagnostics.push_back(*reader.failure());
    return;
  }
  for (std::size_t column = 0; column < values.size(); ++column) {
    set_value(machine, path, reader.header()[column], values[column], environment, diagnostics);
  }
}

/// Tables named on the command line or in a machine file from standard input.
std::optional<std::string> fetch_file(const std::string& path) {
  FileResult<std::string> file = read_file(path);
  if (auto* text = std::get_if<std::string>(&file)) return std::move(*text);
  return std::nullopt;
}

/// The machine of --skew, --scale and --pitch.
Parsed<Machine> load_quick_machine(const CommonArguments& arguments) {
  Parsed<Machine> parsed;
  if (!arguments.machine.empty() || !arguments.errors.empty()) {
    parsed.diagnostics.push_back(option_error(
        "--skew, --scale, --pitch",
        arguments.machine.empty() ? std::string("--errors belongs to a machine file")
                                  : fmt::format("a machine file is given too ('{}')", arguments.machine),
        "give one or the other: two descriptions of one machine would count its errors twice"));
    return parsed;
  }
  const auto text = machine_text_of(arguments.quick, parsed.diagnostics);
  if (!text) return parsed;
  return read_machine({"--skew, --scale, --pitch", *text}, std::nullopt, fetch_file);
}

Parsed<Machine> load_machine(const CommonArguments& arguments, Session& session) {
  const std::optional<std::string> errors =
      arguments.errors.empty() ? std::nullopt : std::optional(arguments.errors);
  Parsed<Machine> parsed;
  if (arguments.machine == "-" || (errors && *errors == "-")) {
    const std::optional<std::string> machine_text = read_input(arguments.machine, session);
    std::optional<std::string> errors_text;
    if (errors) errors_text = read_input(*errors, session);
    if (!machine_text || (errors && !errors_text)) return parsed;
    const auto name_of = [](const std::string& path) { return path == "-" ? std::string("<stdin>") : path; };
    std::optional<MachineText> errors_source;
    if (errors) errors_source = MachineText{name_of(*errors), *errors_text};
    parsed = read_machine({name_of(arguments.machine), *machine_text}, errors_source, fetch_file);
  } else if (arguments.quick.given()) {
    parsed = load_quick_machine(arguments);
  } else if (arguments.machine.empty()) {
    parsed.diagnostics.push_back(option_error("MACHINE", "no machine file is given",
                                              "name one, or describe three axes: --skew, --scale, --pitch"));
  } else {
    parsed = read_machine_file(arguments.machine, errors);
  }
  session.report(parsed.diagnostics);
  return parsed;
}

}  // namespace

OptionCheck finite_number() {
  return {[](const std::string& text) {
            const auto value = read_number(text);
            return value ? std::string() : text + " is not a finite number";
          },
          "FINITE"};
}

void add_machine_options(Command& verb, CommonArguments& arguments, Session& session) {
  verb.add_option("MACHINE", arguments.machine, "machine file (TOML); - is standard input")->required();
  verb.add_option("--errors", arguments.errors, "errors file in place of the [errors] of the machine file")
      ->type_name("FILE");
  verb.add_flag("--strict", session.strict, "warnings and failed limits end with exit code 4");
  verb.add_flag("--json", arguments.json,
                "JSON on standard output: mm, degrees for axis positions, rad for rotations");
}

void allow_quick_machine(Command& verb, CommonArguments& arguments) {
  verb.get_option("MACHINE")->required(false);
  add_quick_machine_options(verb, arguments.quick);
}

void add_common_options(Command& verb, CommonArguments& arguments, Session& session) {
  add_machine_options(verb, arguments, session);
  verb.add_option("--set", arguments.set, "values of sensors and of t: T1=23.4,t=0")
      ->type_name("NAME=VALUE,..")
      ->allow_extra_args(false);
  verb.add_option("--environment", arguments.environment,
                  "values of sensors: CSV with a header and one row, or a log with time [s]")
      ->type_name("FILE");
  verb.add_option("--approach", arguments.approach, "direction of the last motion of axes: X=+,Y=-")
      ->type_name("AXIS=+|-|0,..")
      ->allow_extra_args(false);
  verb.add_option("--model", arguments.model, "how error matrices enter the chain (rigid)")
      ->check(one_of({"rigid", "linear", "first-order"}));
  verb.add_option("--limit-um", arguments.limit_um, "accepted distance: reports pass or fail")
      ->check(not_negative())
      ->type_name("UM");
  verb.add_option("--limit-angle-deg", arguments.limit_angle_deg,
                  "accepted tilt of the tool axis: reports pass or fail")
      ->check(not_negative())
      ->type_name("DEG");
}

std::vector<std::string> split_list(std::string_view text) {
  std::vector<std::string> pieces;
  while (true) {
    const std::size_t comma = text.find(',');
    pieces.emplace_back(trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) return pieces;
    text.remove_prefix(comma + 1);
  }
}

std::vector<Assignment> split_assignments(std::string_view option, const std::vector<std::string>& arguments,
                                          Diagnostics& diagnostics) {
  std::vector<Assignment> assignments;
  for (const std::string& argument : arguments) {
    for (const std::string& piece : split_list(argument)) {
      const std::size_t equals = piece.find('=');
      if (equals == std::string::npos || equals == 0) {
        diagnostics.push_back(option_error(option, fmt::format("'{}' is not of the form NAME=VALUE", piece)));
        continue;
      }
      Assignment assignment{std::string(trimmed(std::string_view(piece).substr(0, equals))),
                            std::string(trimmed(std::string_view(piece).substr(equals + 1)))};
      const bool known = std::any_of(assignments.begin(), assignments.end(),
                                     [&](const Assignment& other) { return other.name == assignment.name; });
      if (known) {
        diagnostics.push_back(option_error(option, fmt::format("'{}' is given twice", assignment.name)));
      } else {
        assignments.push_back(std::move(assignment));
      }
    }
  }
  return assignments;
}

std::optional<double> option_number(std::string_view option, const std::string& name, const std::string& text,
                                    Diagnostics& diagnostics) {
  const std::optional<double> number = read_number(text);
  if (!number) {
    diagnostics.push_back(
        option_error(option, fmt::format("the value of '{}' is not a number: '{}'", name, text)));
  }
  return number;
}

NameMeaning meaning_of(const Machine& machine, std::string_view name) {
  using Kind = NameMeaning::Kind;
  if (const int axis = machine.find_axis(name); axis >= 0) return {Kind::position, axis};
  if (name.ends_with(".dir")) {
    const int axis = machine.find_axis(name.substr(0, name.size() - 4));
    return {axis >= 0 ? Kind::approach : Kind::unknown, axis};
  }
  if (name.starts_with("v.") || name.starts_with("a.")) {
    const int axis = machine.find_axis(name.substr(2));
    if (axis >= 0) return {name.front() == 'v' ? Kind::velocity : Kind::acceleration, axis};
    return {};
  }
  for (const Variable& variable : machine.variables) {
    if (variable.kind == Variable::Kind::sensor && variable.name == name) return {Kind::sensor, -1};
  }
  return {};
}

std::string suggestion(const Machine& machine, std::string_view name) {
  std::vector<std::string> known;
  for (const Variable& variable : machine.variables) known.push_back(variable.name);
  for (int i = 0; i < machine.axis_count(); ++i) known.push_back(machine.axis(i).name + ".dir");
  const std::optional<std::string> like = closest(name, known);
  return like ? fmt::format("did you mean '{}'?", *like) : std::string();
}

std::optional<signed char> read_approach(std::string_view text) {
  text = trimmed(text);
  if (text == "+" || text == "+1" || text == "1") return static_cast<signed char>(1);
  if (text == "-" || text == "-1") return static_cast<signed char>(-1);
  if (text == "0") return static_cast<signed char>(0);
  return std::nullopt;
}

std::optional<std::string> read_input(const std::string& path, Session& session) {
  std::optional<SpooledInput> spooled;
  if (path == "-") {
    FileResult<SpooledInput> input = SpooledInput::from_standard_input();
    if (const auto* error = std::get_if<FileError>(&input)) {
      session.report(*error, "<stdin>");
      return std::nullopt;
    }
    spooled.emplace(std::move(std::get<SpooledInput>(input)));
  }
  FileResult<std::string> file = read_file(spooled ? spooled->path() : path);
  if (auto* text = std::get_if<std::string>(&file)) return std::move(*text);
  session.report(std::get<FileError>(file), path == "-" ? "<stdin>" : path);
  return std::nullopt;
}

std::optional<Setting> load_setting(const CommonArguments& arguments, Session& session) {
  if (arguments.machine == "-" && arguments.errors == "-") {
    session.report(option_error("--errors", "standard input cannot be the machine file and the errors file"));
    return std::nullopt;
  }
  Parsed<Machine> parsed = load_machine(arguments, session);
  if (!parsed.value) {
    if (!session.has(Exit::internal)) session.note(Exit::invalid);
    return std::nullopt;
  }
  Setting setting{std::move(*parsed.value), {}, ErrorModel::rigid, {}, {}, std::move(parsed.diagnostics)};
  if (arguments.model == "linear") setting.model = ErrorModel::linear;
  if (arguments.model == "first-order") setting.model = ErrorModel::first_order;
  if (arguments.limit_um) setting.limits.position = *arguments.limit_um * um;
  if (arguments.limit_angle_deg) setting.limits.angle = *arguments.limit_angle_deg * deg;

  Diagnostics diagnostics;
  if (!arguments.environment.empty()) {
    read_environment_file(setting.machine, arguments.environment, session, setting.environment, diagnostics);
  }
  // --set comes after the file: what is typed wins over what is stored.
  for (const Assignment& given : split_assignments("--set", arguments.set, diagnostics)) {
    const std::optional<double> value = option_number("--set", given.name, given.text, diagnostics);
    if (value) set_value(setting.machine, "--set", given.name, *value, setting.environment, diagnostics);
  }
  for (const Assignment& given : split_assignments("--approach", arguments.approach, diagnostics)) {
    const int axis = setting.machine.find_axis(given.name);
    const std::optional<signed char> direction = read_approach(given.text);
    if (axis < 0) {
      diagnostics.push_back(option_error("--approach",
                                         fmt::format("this chain has no moving axis '{}'", given.name),
                                         suggestion(setting.machine, given.name)));
    } else if (!direction) {
      diagnostics.push_back(option_error("--approach",
                                         fmt::format("{}={} is not a direction", given.name, given.text),
                                         "write + for increasing, - for decreasing, 0 for unknown"));
    } else {
      setting.approach[static_cast<std::size_t>(axis)] = *direction;
    }
  }
  session.report(diagnostics);
  if (session.has(Exit::invalid) || session.has(Exit::internal)) return std::nullopt;
  return setting;
}

std::optional<Setting> load_controlled_setting(const CommonArguments& arguments, Session& session) {
  auto setting = load_setting(arguments, session);
  if (!setting) return std::nullopt;
  setting->machine = as_controlled(setting->machine);
  if (const auto refusal = refusal_of_one_test(setting->machine)) {
    session.report(*refusal, Exit::refused);
    return std::nullopt;
  }
  return setting;
}

std::optional<Plan> plan_or_report(const Setting& setting, const Environment& environment, Session& session) {
  std::variant<Plan, MissingSensors> made = make_plan(setting.machine, environment, setting.model);
  if (auto* plan = std::get_if<Plan>(&made)) return std::move(*plan);
  for (const std::string& sensor : std::get<MissingSensors>(made).names) {
    std::string needed_by;
    for (const ErrorTerm& term : setting.machine.errors) {
      for (const int variable : term.function.variables()) {
        if (setting.machine.variables[static_cast<std::size_t>(variable)].name != sensor) continue;
        if (!needed_by.empty()) needed_by += ", ";
        needed_by += abbe::to_string(term.name);
        break;
      }
    }
    Diagnostic missing;
    missing.code = "E-SENSOR";
    missing.place.file = setting.machine.files.empty() ? "machine" : setting.machine.files.front();
    missing.message = fmt::format("the value of '{}' is not given; needed by {}", sensor, needed_by);
    missing.why = "without it the error is unknown, and an assumed value would be a wrong correction";
    missing.fix =
        fmt::format("--set {}=VALUE, a column '{}' of --points or of --environment", sensor, sensor);
    for (const LaggedSensor& lagged : setting.machine.lagged_sensors)
      if (lagged.name == sensor)
        missing.fix = fmt::format(
            "--environment LOG.csv with columns time [s] and {} [degC]: it is {} through a lag of {:g} s",
            lagged.of, lagged.of, lagged.lag);
    session.report(missing);
  }
  return std::nullopt;
}

AxisSet read_lock(const Machine& machine, const std::vector<std::string>& lock, Diagnostics& diagnostics) {
  AxisSet locked = 0;
  for (const std::string& list : lock) {
    for (const std::string& name : split_list(list)) {
      const int axis = machine.find_axis(name);
      if (axis < 0) {
        diagnostics.push_back(option_error("--lock", fmt::format("this chain has no moving axis '{}'", name),
                                           suggestion(machine, name)));
      } else {
        locked |= AxisSet{1} << axis;
      }
    }
  }
  return locked;
}

std::optional<AxisSet> free_axes_or_report(const Machine& machine, AxisSet locked, Session& session) {
  const std::optional<AxisSet> free = free_axes(machine, locked);
  if (!free) {
    Diagnostic ambiguous;
    ambiguous.code = "E-LOCK";
    ambiguous.place.file = machine.files.empty() ? "machine" : machine.files.front();
    ambiguous.message = "more than three linear or two rotary axes could be moved to correct";
    ambiguous.why = "many corrections would be right, and the machine can have only one";
    ambiguous.fix =
        "name the axes that shall stay with --lock, or set correctable = false in the machine file";
    session.report(ambiguous);
  }
  return free;
}

Method method_of(std::string_view text) {
  for (const Method method : {Method::one_step, Method::closed_form, Method::printed}) {
    if (abbe::to_string(method) == text) return method;
  }
  return Method::newton;
}

void add_method_option(Command& verb, std::string& method) {
  verb.add_option(
          "--method", method,
          "newton iterates (default), one-step is the differential step, closed-form the exact one for "
          "up to two rotary axes, printed that of the patent for the gear grinder")
      ->check(one_of({"newton", "one-step", "closed-form", "printed"}));
}

bool method_fits_or_report(const Setting& setting, Method method, AxisSet free, Session& session) {
  const Machine& machine = setting.machine;
  const std::optional<std::string> obstacle =
      method_obstacle(method, machine, setting.model, tool_of(machine), free);
  if (!obstacle) return true;
  Diagnostic misfit;
  misfit.code = "E-METHOD";
  misfit.place.file = machine.files.empty() ? "machine" : machine.files.front();
  misfit.message = fmt::format("the method {} does not fit: {}", abbe::to_string(method), *obstacle);
  misfit.why = "it would have no answer, or the answer of another machine";
  misfit.fix = "--method newton serves every chain and model";
  session.report(misfit);
  return false;
}

std::vector<std::string> outside_travel(const Machine& machine, const std::array<double, kMaxAxes>& q) {
  std::vector<std::string> names;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    const double position = q[static_cast<std::size_t>(i)];
    if (axis.range &&
        (position < (*axis.range)[0] - kTravelSlack || position > (*axis.range)[1] + kTravelSlack)) {
      names.push_back(axis.name);
    }
  }
  return names;
}

std::string_view to_string(ErrorModel model) {
  switch (model) {
    case ErrorModel::linear:
      return "linear";
    case ErrorModel::first_order:
      return "first-order";
    case ErrorModel::rigid:
      break;
  }
  return "rigid";
}

}  // namespace abbe::app
