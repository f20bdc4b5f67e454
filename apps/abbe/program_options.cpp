#include "program_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string_view>
#include <utility>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "number_check.h"

namespace abbe::app {
namespace {

int axis_letter(std::string_view name) {
  return name.size() == 1 && name[0] >= 'X' && name[0] <= 'Z' ? name[0] - 'X' : -1;
}
int turn_letter(std::string_view name) {
  return name.size() == 1 && name[0] >= 'A' && name[0] <= 'C' ? name[0] - 'A' : -1;
}

/// "X1,Y2.5,Z-3,A90" as letters and values; R too where asked.
struct Lettered {
  std::array<std::optional<double>, 3> axes;
  std::array<double, 3> turns{};  ///< rad
  std::optional<double> rotation;
};
std::optional<Lettered> read_lettered(std::string_view option, std::string_view text, bool rotation,
                                      Diagnostics& findings) {
  Lettered values;
  bool good = true;
  for (const std::string& piece : split_list(text)) {
    const std::string letter = piece.substr(0, 1);
    std::string number = piece.substr(std::min<std::size_t>(1, piece.size()));
    if (!number.empty() && number[0] == '=') number.erase(0, 1);
    const int axis = axis_letter(letter), turn = turn_letter(letter);
    const auto value = read_number(number);
    if (!value || (axis < 0 && turn < 0 && !(rotation && letter == "R"))) {
      findings.push_back(option_error(
          option, fmt::format("'{}' is not a letter X Y Z A B C{} and a number", piece, rotation ? " R" : ""),
          rotation ? "write G54=X-120.5,Y40,Z-210" : "write X0,Y0,Z0"));
      good = false;
      continue;
    }
    if (axis >= 0)
      values.axes[static_cast<std::size_t>(axis)] = *value;
    else if (turn >= 0)
      values.turns[static_cast<std::size_t>(turn)] = *value * deg;
    else
      values.rotation = *value;
  }
  return good ? std::optional(values) : std::nullopt;
}

/// --offset G54=X-120.5,Y40,Z-210: lengths in the machine file's unit, R in degrees.
void read_offsets(const std::vector<std::string>& arguments, double unit, ControlSetup& setup,
                  Diagnostics& findings) {
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    const auto index = work_offset_index(std::string_view(argument).substr(0, equals));
    if (equals == std::string::npos || !index) {
      findings.push_back(option_error("--offset",
                                      fmt::format("'{}' does not begin with a work offset", argument),
                                      "write G54=X-120.5,Y40,Z-210 (G54 to G59.3, G54.1P3, G154P3)"));
      continue;
    }
    const auto values =
        read_lettered("--offset", std::string_view(argument).substr(equals + 1), true, findings);
    if (!values) continue;
    WorkOffset offset;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!values->axes[k]) {
        findings.push_back(option_error(
            "--offset", fmt::format("'{}' does not give {}", argument, "XYZ"[k]),
            "give X, Y and Z: an offset that is guessed puts the correction in the wrong place"));
        continue;
      }
      offset.origin[k] = *values->axes[k] * unit;
    }
    offset.rotation = values->rotation.value_or(0) * deg;
    offset.turns = values->turns;
    if (*index < kFixedWorkOffsets)
      setup.work_offsets[static_cast<std::size_t>(*index)] = offset;
    else
      setup.further_offsets[*index - kFixedWorkOffsets + 1] = offset;
  }
}

/// What an option gives tools by their numbers, or offsets by theirs.
struct ToolOption {
  const char *name, *letters, *example, *measure, *meaning;
  bool zero = false;  ///< 0 is a value
};
constexpr ToolOption kGauge{
    "--gauge", "Tt", "write T3=112.4", "gauge length", "it is the distance from the spindle nose to the tip",
    false};
constexpr ToolOption kRadius{
    "--radius",
    "DdTt",
    "write D3=5.0",
    "cutter radius",
    "it is what the control offsets the path by; 0 where the program states the path of "
    "the cutter's centre",
    true};

/// --gauge T3=112.4, --radius D3=5.0: lengths in the machine file's unit.
void read_tool_option(const ToolOption& option, const std::vector<std::string>& arguments, double unit,
                      std::map<int, double>& values, Diagnostics& findings) {
  for (const Assignment& given : split_assignments(option.name, arguments, findings)) {
    const auto value = option_number(option.name, given.name, given.text, findings);
    const bool lettered = given.name.size() > 1 &&
                          std::string_view(option.letters).find(given.name[0]) != std::string_view::npos;
    const auto number = lettered ? read_number(std::string_view(given.name).substr(1)) : std::nullopt;
    if (!number || *number < 0 || *number > 1e6 || *number != std::floor(*number)) {
      findings.push_back(option_error(
          option.name,
          fmt::format("'{}' is not {} number", given.name, option.zero ? "an offset or tool" : "a tool"),
          option.example));
    } else if (value && !(*value > 0) && !(option.zero && *value == 0)) {
      findings.push_back(option_error(option.name,
                                      fmt::format("the {} of {} is {}", option.measure, given.name,
                                                  option.zero ? "negative" : "not positive"),
                                      option.meaning));
    } else if (value) {
      values[static_cast<int>(*number)] = *value * unit;
    }
  }
}

template <class T>
bool take(Parsed<T> parsed, T& value, Session& session) {
  session.report(parsed.diagnostics);
  if (!parsed.value) return false;
  value = std::move(*parsed.value);
  return true;
}

std::optional<std::string> text_of(const std::string& path, Session& session) {
  auto text = read_file(path);
  if (const auto* error = std::get_if<FileError>(&text)) {
    session.report(*error, path);
    return std::nullopt;
  }
  return std::get<std::string>(std::move(text));
}

/// The day, for valid_to: SOURCE_DATE_EPOCH if set, so that a run can be repeated.
std::string today() {
  std::time_t now = std::time(nullptr);
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) {
    if (const auto seconds = read_number(epoch); seconds && std::abs(*seconds) < 1e12)
      now = static_cast<std::time_t>(*seconds);
  }
  std::tm broken{};
  if (!gmtime_r(&now, &broken)) return {};
  return fmt::format("{:04}-{:02}-{:02}", broken.tm_year + 1900, broken.tm_mon + 1, broken.tm_mday);
}

}  // namespace

void add_program_options(Command& verb, ProgramArguments& a, Session& session) {
  add_common_options(verb, a.common, session);
  add_profile_options(verb, a.profile);
  allow_quick_machine(verb, a.common);
  verb.add_option(
      "--offset", a.offsets,
      "work offset in machine coordinates, e.g. G54=X-120.5,Y40,Z-210[,A0,C90][,R10] (repeatable)");
  verb.add_option("--var", a.parameters, "LinuxCNC parameter file: work offsets, in mm");
  verb.add_option("--tools", a.tools,
                  "LinuxCNC tool table, in mm (gauge= in a comment gives the gauge length)");
  verb.add_option("--gauge", a.gauges, "gauge length of a tool, e.g. T3=112.4 (repeatable)");
  verb.add_option("--radius", a.radii,
                  "cutter radius of G41 G42 D, e.g. D3=5.0 (repeatable; else from the tool table)");
  verb.add_option("--tool", a.tool, "number of the tool in the spindle at the start");
  verb.add_option(
          "--start", a.start,
          "machine position before the program, e.g. X0,Y0,Z0,C90; rotary axes stand at 0 where not given")
      ->delimiter(';');
  verb.add_option("--block-delete", a.block_delete, "blocks with '/': on = skipped, off = executed")
      ->check(one_of({"on", "off"}));
  verb.add_option("--tool-change", a.tool_change,
                  "moves: after M6 the axes may stand elsewhere; keeps: they stand where they were")
      ->check(one_of({"moves", "keeps"}))
      ->capture_default_str();
  add_expansion_options(verb, a.expansion);
  verb.add_option("--datum", a.datum,
                  "probed: the work offset was touched off on this machine; ideal: it is true")
      ->check(one_of({"probed", "ideal"}))
      ->capture_default_str();
  verb.add_option("--tolerance-um", a.tolerance_um, "what interpolation may leave")
      ->check(number_in(0.01, 1000.0))
      ->capture_default_str();
  verb.add_option("--max-correction-um", a.max_correction_um, "larger corrections are refused")
      ->check(number_in(1.0, 1e5))
      ->capture_default_str();
  verb.add_flag("--reversal", a.reversal,
                "correct lost motion where an axis turns round, instead of its mean");
  verb.add_flag("--expand-drill", a.expand_drill,
                "G81 and G82 whose correction changes inside the hole become G0, G1 and G4");
  verb.add_option("--min-block-time", a.min_block_time_ms,
                  "no split makes a feed block that lasts shorter, ms (0: any; the profile's otherwise)")
      ->check(number_in(0.0, 1e4))
      ->type_name("MS");
  add_cl_options(verb, a.cl);
  verb.add_option("--report", a.report, "write the report as JSON");
  verb.add_option("--figure", a.figure, "draw the deviation before and after (SVG)");
}

bool settle_files(CommonArguments& arguments, const std::vector<std::string*>& files, Session& session) {
  if (arguments.quick.given() && files.back()->empty()) {
    for (std::size_t i = files.size(); i-- > 1;) *files[i] = std::move(*files[i - 1]);
    *files.front() = std::move(arguments.machine);
    arguments.machine.clear();
  }
  if (!files.back()->empty()) return true;
  Diagnostic missing = option_error(
      "abbe", arguments.machine.empty() ? "no machine and no program is given" : "a program is missing",
      "abbe VERB MACHINE PROGRAM; with --skew, --scale or --pitch no MACHINE");
  missing.code = "E-USAGE";
  session.report(missing);
  return false;
}

namespace {

/// Adds the workpiece's expansion; false after reporting why that would be a guess.
bool expand_workpiece(const ProgramArguments& a, const std::string& program, Setting& setting,
                      Session& session) {
  if (!a.expansion.given()) return true;
  const Machine& machine = setting.machine;
  const bool turns = std::any_of(machine.bodies.begin(), machine.bodies.end(),
                                 [](const Body& body) { return body.type == AxisType::rotary; });
  const char* why = a.datum != "probed" ? "with --datum ideal nothing says which point of the part stays"
                    : is_cl_data(a.profile.dialect, program) ? "CL data do not say where the part is held"
                    : turns ? "with rotary axes it depends on the length of each tool"
                            : nullptr;
  if (why != nullptr) {
    Diagnostic error =
        option_error("--workpiece-temperature", std::string("the expansion has no centre: ") + why,
                     "programs of linear axes with --datum probed expand about their work offset");
    error.code = "E-EXPANSION";
    session.report(error);
    return false;
  }
  auto expanded = expanded_or_report(a.expansion, std::move(setting.machine), session);
  if (expanded) setting.machine = std::move(*expanded);
  return expanded.has_value();
}

}  // namespace

std::optional<ProgramSetting> load_program_setting(const ProgramArguments& a, const std::string& program,
                                                   Session& session) {
  auto setting = load_controlled_setting(a.common, session);
  if (!setting || !expand_workpiece(a, program, *setting, session)) return std::nullopt;
  const double unit = setting->machine.units.length;
  Diagnostics findings;
  ControlSetup setup;
  bool good = true;
  const bool is_cl = is_cl_data(a.profile.dialect, program);
  if (!is_cl) {
    setup.profile = load_profile(a.profile, session);
    if (setup.profile == nullptr) return std::nullopt;
  }
  if (!a.parameters.empty()) {
    const auto text = text_of(a.parameters, session);
    good = text && take(read_parameter_file(a.parameters, *text), setup, session) && good;
  }
  if (!a.tools.empty()) {
    const auto text = text_of(a.tools, session);
    good = text && take(read_tool_table(a.tools, *text), setup.tools, session) && good;
  }
  read_offsets(a.offsets, unit, setup, findings);
  read_tool_option(kGauge, a.gauges, unit, setup.gauges, findings);
  read_tool_option(kRadius, a.radii, unit, setup.radii, findings);
  for (const std::string& start : a.start) {
    if (const auto values = read_lettered("--start", start, false, findings)) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (values->axes[k]) setup.start[k] = *values->axes[k] * unit;
        setup.start_turns[k] = values->turns[k];
      }
    }
  }
  setup.loaded_tool = a.tool;
  setup.tool_change_keeps_place = a.tool_change == "keeps";
  using BlockDelete = ControlSetup::BlockDelete;
  if (!a.block_delete.empty())
    setup.block_delete = a.block_delete == "on" ? BlockDelete::on : BlockDelete::off;
  if (!a.common.approach.empty())
    findings.push_back(option_error("--approach", "a program states its own directions",
                                    "leave it out; --reversal uses them"));
  if (a.common.limit_angle_deg)
    findings.push_back(option_error(
        "--limit-angle-deg",
        "the direction of the tool is reported (tool_axis), not judged: three linear axes cannot correct it",
        "leave it out, or ask `abbe predict`"));
  std::optional<ClSetting> cl;
  if (is_cl) cl = read_cl_setting(a.cl, a.profile.units, setting->machine, setup, findings);
  if (cl && a.reversal)
    findings.push_back(option_error("--reversal",
                                    "CL data do not say from which side the machine's axes come",
                                    "leave it out: the mean of both directions is corrected"));
  if (cl && a.expand_drill)
    findings.push_back(option_error("--expand-drill",
                                    "the cycles of CL data become motions in the postprocessor",
                                    "leave it out, or compensate the posted program"));
  if (cl && a.min_block_time_ms)
    findings.push_back(option_error("--min-block-time",
                                    "how fast the control reads CL data depends on the post",
                                    "leave it out, or compensate the posted program"));
  session.report(findings);
  if (!findings.empty() || !good) return std::nullopt;
  auto plan = plan_or_report(*setting, setting->environment, session);
  if (!plan) return std::nullopt;

  ProgramJob job;
  job.model = setting->model;
  job.environment = setting->environment;
  // Header and report say what part the program was made for. Names of sensors hold no blanks.
  add_to_environment(a.expansion, job.environment);
  if (setup.profile != nullptr) job.block_time = setup.profile->block_time;
  if (a.min_block_time_ms) job.block_time = *a.min_block_time_ms / 1e3;
  job.setup = std::move(setup);
  job.datum = a.datum == "probed" ? DatumRule::probed : DatumRule::ideal;
  job.reversal = a.reversal;
  job.tolerance = a.tolerance_um * um;
  job.max_correction = a.max_correction_um * um;
  job.expand_drill = a.expand_drill;
  job.limit = setting->limits.position;
  job.header = a.header == "inline"    ? HeaderForm::inline_comments
               : a.header == "sidecar" ? HeaderForm::sidecar
                                       : HeaderForm::none;
  job.report = a.report;
  job.figure = a.figure;
  job.version = ABBE_VERSION;
  job.today = today();
  job.cl = std::move(cl);
  return ProgramSetting{std::move(*setting), std::move(*plan), std::move(job)};
}

}  // namespace abbe::app
