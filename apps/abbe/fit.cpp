#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "abbe/chain/predict.h"
#include "abbe/core/file.h"
#include "abbe/core/units.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/fit/state_grids.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "fit_thermal.h"
#include "output_file.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

struct FitArguments {
  std::vector<std::string> jobs;
  std::string output, states;
  bool json = false, covariance = false;
};

/// A fit with everything it worked on.
struct FitAnswer {
  FitJob job;
  Observations observations;
  FitResult result;
  ThermalFit thermal;
  std::string errors;  ///< the errors file
  double second_order =
      0;  ///< mm: most that the rigid model differs from the first-order one at a pose measured
};

Diagnostic about_job(const FitJob& job, Severity severity, const char* code, std::string message,
                     std::string why, std::string fix) {
  return {severity, code, {job.file, 0, 0, 1, {}}, std::move(message), std::move(why), std::move(fix)};
}

std::string listed_names(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 4;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? text + fmt::format(" and {} more", names.size() - kMost) : text;
}

/// The measurement that shows an unknown by itself. Only a location error can be stated as a [[value]].
std::string what_would_tell(const std::string& text) {
  const std::optional<ErrorName> name = read_error_name(text);
  if (!name) return "measure with another set-up (optic, height, square turned over), or leave it out";
  if (name->error_class != ErrorClass::location)
    return fmt::format("add a [[run]] of {}, or points at other places, or leave it out", text);
  return (name->is_rotation()
              ? "add straightness of both axes on one [[square]], diagonals, or balls at another height"
              : "add balls at another place or height, touched at other angles") +
         std::string(", state it with [[value]], or leave it out");
}

Diagnostic lack(const FitJob& job, const NotDetermined& missing) {
  return about_job(job, Severity::warning, "W-FIT-RANK", missing.name + " is not determined",
                   missing.like.empty()
                       ? "no measurement shows it"
                       : fmt::format("only a combination with {} is known: at the poses measured, with the "
                                     "noise stated, they do the same, and {} is taken as 0",
                                     listed_names(missing.like), missing.name),
                   what_would_tell(missing.name));
}

Diagnostic lack_of_shape(const FitJob& job, const NotDetermined& missing) {
  const std::string alike =
      missing.like.empty() ? "" : ", as " + listed_names(missing.like) + " would do the same";
  return about_job(
      job, Severity::warning, "W-FIT-RANK",
      fmt::format("{} of the {} parameters of {} are not determined", missing.missing, missing.parameters,
                  missing.name),
      fmt::format("they are taken as 0{}: between the positions measured its course is not known, and its "
                  "uncertainty does not say so",
                  alike),
      "measure at more positions (not at multiples of the pitch only), or ask for a simpler form");
}

/// What the numbers say against themselves.
void report_doubts(const FitJob& job, const FitResult& result, Session& session) {
  constexpr double kMisfit = 3;
  for (const NotDetermined& missing : result.not_determined) {
    if (!missing.asked) continue;
    session.report(missing.in_part() ? lack_of_shape(job, missing) : lack(job, missing));
  }
  for (const SetResidual& set : result.sets) {
    if (set.noise_assumed || set.ratio < kMisfit) continue;
    session.report(
        about_job(job, Severity::warning, "W-FIT-MISFIT",
                  fmt::format("{}: what is left is {:.1f} times the noise (rms {:.3g} {})", set.name,
                              set.ratio, set.rms / (set.angle ? urad : um), set.angle ? "urad" : "um"),
                  "the form of a function, the measuring point, an error that was not measured, or a sign "
                  "that contradicts other "
                  "files",
                  "look at the residuals; another form, pitch, or the missing runs"));
  }
  if (result.rows > 0 && result.rows <= result.rank)
    session.report(
        about_job(job, Severity::warning, "W-FIT-FREEDOM", "there are no more equations than unknowns",
                  "nothing is left to judge the fit by; uncertainties are those of the instruments",
                  "measure more targets, or fit fewer unknowns"));
}

/// The errors file read back as every verb will read it; nothing after reporting that it does not.
std::optional<Machine> read_back(const FitAnswer& answer, Session& session) {
  const std::string& path = answer.job.machine.files.front();
  const FileResult<std::string> bytes = read_file(path);
  if (const auto* error = std::get_if<FileError>(&bytes)) {
    session.report(*error, path);
    return std::nullopt;
  }
  Parsed<Machine> machine = read_machine({path, std::get<std::string>(bytes)},
                                         MachineText{answer.job.file + " (errors found)", answer.errors}, {});
  session.report(machine.diagnostics);
  return std::move(machine.value);
}

/// Most that products of errors move the tip at the poses measured.
double second_order(const Machine& machine, const Observations& observations) {
  const auto rigid = make_plan(machine, {}, ErrorModel::rigid),
             first = make_plan(machine, {}, ErrorModel::first_order);
  if (!std::holds_alternative<Plan>(rigid) || !std::holds_alternative<Plan>(first)) return 0;
  double most = 0;
  for (const Query& query : observations.poses)
    most = std::max(
        most, (actual_tip(std::get<Plan>(rigid), query) - actual_tip(std::get<Plan>(first), query)).norm());
  return most;
}

std::optional<FitAnswer> answer_of(const std::string& path, const FitArguments& arguments, Session& session) {
  const std::optional<std::string> text = read_input(path, session);
  if (!text) return std::nullopt;
  Parsed<FitJob> job = read_fit_job({path, *text}, fetch_file);
  session.report(job.diagnostics);
  if (!job.value) return std::nullopt;
  Parsed<Observations> observations = observations_of(*job.value);
  session.report(observations.diagnostics);
  if (!observations.value) return std::nullopt;
  const Parsed<Unknowns> unknowns = unknowns_of(*job.value, *observations.value);
  session.report(unknowns.diagnostics);
  if (!unknowns.value) return std::nullopt;
  const std::optional<ThermalFit> thermal = thermal_or_report(*job.value, session);
  if (!thermal) return std::nullopt;
  FitAnswer answer{std::move(*job.value), std::move(*observations.value), {}, *thermal, {}, 0};
  answer.result = fit_jointly(answer.job, answer.observations, *unknowns.value);
  if (answer.result.status != FitResult::Status::ok) {
    session.report(about_job(answer.job, Severity::error, "E-RANGE",
                             "the numbers are too large to calculate with", "", "check units and positions"));
    return std::nullopt;
  }
  answer.errors = write_errors_file(answer.job, answer.result, answer.thermal);
  if (arguments.covariance)
    answer.errors += write_uncertainty_modes(answer.job, answer.result, answer.thermal);
  const std::optional<Machine> machine = read_back(answer, session);
  if (!machine) return std::nullopt;
  answer.second_order = second_order(*machine, answer.observations);
  return answer;
}

std::string set_line(const SetResidual& set) {
  const double unit = set.angle ? urad : um;
  return fmt::format(
      "  {:<34} {:>6} equations   left: rms {:8.3f}, most {:8.3f} {}{}\n", set.name, set.rows, set.rms / unit,
      set.max / unit, set.angle ? "urad" : "um",
      set.noise_assumed ? "   (noise not known)" : fmt::format("   {:.2f} of the noise", set.ratio));
}

std::string text_of(const FitAnswer& answer) {
  const FitResult& result = answer.result;
  std::string text =
      fmt::format("errors of {} from {}: {} equations, {} unknowns, {} determined\n\n",
                  answer.job.machine.name, answer.job.file, result.rows, result.unknowns, result.rank);
  for (const SetResidual& set : result.sets) text += set_line(set);
  text += fmt::format(
      "  variance ratio {:.3f}; second order at most {:.4f} um\n\nfunctions (zero at the reference "
      "position; straightness without trend: it is squareness)\n",
      result.variance_ratio, answer.second_order / um);
  for (const FoundFunction& found : result.functions) {
    const char* unit = found.unknown.rotation ? "urad" : "um";
    text += fmt::format("  {:<6} {:<30} {:10.2f} to {:10.2f}   u {:7.3f} {}", found.unknown.name,
                        found.unknown.mean.describe(), found.unknown.mean.lo(), found.unknown.mean.hi(),
                        found.u, unit);
    if (found.reversal.size() == 1) text += fmt::format("   reversal {:+.3f} {}", found.reversal[0], unit);
    if (found.reversal.size() > 1) text += "   reversal as a table";
    text += '\n';
  }
  text += "\nlocation errors\n";
  for (const FoundValue& value : result.locations)
    text += fmt::format("  {:<6} {:+10.3f}   u {:7.3f} {}\n", value.name, value.value, value.u,
                        read_error_name(value.name)->is_rotation() ? "urad" : "um");
  if (result.locations.empty()) text += "  none\n";
  for (const NotDetermined& missing : result.not_determined)
    if (!missing.like.empty() || missing.asked)
      text += fmt::format("  {:<6} not determined{}: {}\n", missing.name,
                          missing.in_part()
                              ? fmt::format(" in {} of {} parameters", missing.missing, missing.parameters)
                              : "",
                          missing.like.empty() ? "nothing shows it" : "like " + listed_names(missing.like));
  return text + thermal_text(answer.job, answer.thermal);
}

void write_found(JsonWriter& json, const FitResult& result) {
  json.key("functions").begin_array();
  for (const FoundFunction& found : result.functions) {
    const UnknownFunction& f = found.unknown;
    json.begin_object(Layout::one_line).member("name", f.name).member("form", f.mean.describe());
    json.member("unit", f.rotation ? "urad" : "um").member("from", f.mean.lo()).member("to", f.mean.hi());
    json.member("u", found.u);
    if (found.reversal.size() == 1) json.member("reversal", found.reversal[0]);
    json.end();
  }
  json.end().key("locations").begin_array();
  for (const FoundValue& value : result.locations) {
    json.begin_object(Layout::one_line).member("name", value.name);
    json.member("unit", read_error_name(value.name)->is_rotation() ? "urad" : "um");
    json.member("value", value.value).member("u", value.u).end();
  }
  json.end().key("not_determined").begin_array();
  for (const NotDetermined& missing : result.not_determined)
    json.begin_object(Layout::one_line)
        .member("name", missing.name)
        .member("like", missing.like)
        .member("missing", static_cast<std::uint64_t>(missing.missing))
        .member("parameters", static_cast<std::uint64_t>(missing.parameters))
        .end();
  json.end();
}

std::string json_of(const FitAnswer& answer) {
  const FitResult& result = answer.result;
  JsonWriter json;
  json.begin_object().member("format", 1).member("verb", "fit").member("job", answer.job.file);
  json.member("files", answer.job.files);
  json.member("equations", static_cast<std::uint64_t>(result.rows));
  json.member("unknowns", static_cast<std::uint64_t>(result.unknowns));
  json.member("rank", static_cast<std::uint64_t>(result.rank))
      .member("variance_ratio", result.variance_ratio);
  json.member("second_order_um", answer.second_order / um);
  json.key("sets").begin_array();
  for (const SetResidual& set : result.sets) {
    json.begin_object(Layout::one_line).member("name", set.name).member("unit", set.angle ? "rad" : "mm");
    json.member("equations", static_cast<std::uint64_t>(set.rows))
        .member("rms", set.rms)
        .member("max", set.max);
    json.member("noise_known", !set.noise_assumed).member("ratio", set.ratio).end();
  }
  json.end();
  write_found(json, result);
  json.key("instruments").begin_array();
  for (const FoundValue& value : result.nuisances)
    json.begin_object(Layout::one_line)
        .member("name", value.name)
        .member("value", value.value)
        .member("u", value.u)
        .end();
  json.end();
  if (!answer.thermal.models.empty()) write_thermal(json, answer.job, answer.thermal);
  json.end();
  return json.take();
}

/// "T1=18.2/23.9": the sensor and its temperature in every job, increasing.
std::optional<std::pair<std::string, std::vector<double>>> read_states(const FitArguments& arguments,
                                                                       Session& session) {
  Diagnostics wrong;
  std::vector<double> temperatures;
  const auto given = split_assignments("--states", {arguments.states}, wrong);
  if (given.size() == 1) {
    std::string text = given[0].text;
    std::replace(text.begin(), text.end(), '/', ',');
    for (const std::string& piece : split_list(text))
      if (const auto value = option_number("--states", given[0].name, piece, wrong))
        temperatures.push_back(*value);
  }
  const bool increase = std::adjacent_find(temperatures.begin(), temperatures.end(),
                                           std::greater_equal<>()) == temperatures.end();
  if (wrong.empty() && (temperatures.size() != arguments.jobs.size() || temperatures.size() < 2 || !increase))
    wrong.push_back(option_error("--states", "not one increasing temperature for each job",
                                 "abbe fit cold.toml warm.toml --states T1=18.2/23.9"));
  session.report(wrong);
  if (!wrong.empty()) return std::nullopt;
  return std::pair(given[0].name, temperatures);
}

bool publish(const FitArguments& arguments, const std::vector<std::string>& inputs, const std::string& errors,
             Session& session) {
  return arguments.output.empty() || (is_apart("-o", arguments.output, inputs, session) &&
                                      publish_text(arguments.output, errors, session));
}

/// Why a job cannot stand beside the first one of several thermal states; empty if it can.
std::string unlike_first(const FitJob& first, const FitJob& job) {
  if (job.machine.sha256 != first.machine.sha256) return "it is of another machine file than " + first.file;
  if (job.reference != first.reference)
    return "its functions are zero at another [reference] than those of " + first.file;
  return job.drifts.empty() ? ""
                            : "it has [[drift]]: its log sees the grids too, so that one file of both would "
                              "count them twice";
}

/// True if the errors read back, and what they depend on is a sensor: an axis would be read as its position.
bool read_back_with(const std::string& sensor, const FitAnswer& answer, Session& session) {
  const std::optional<Machine> machine = read_back(answer, session);
  if (!machine) return false;
  if (meaning_of(*machine, sensor).kind == NameMeaning::Kind::sensor) return true;
  session.report(option_error("--states", sensor + " is no sensor: it means something else here",
                              "name the temperature otherwise, such as T1"));
  return false;
}

/// One machine measured in several thermal states: each job by itself, then all of them as grids.
void run_states(const FitArguments& arguments, Session& session) {
  const auto asked = read_states(arguments, session);
  if (!asked) return;
  const auto refuse = [&](const FitJob& job, std::string message, const char* why, const char* fix) {
    session.report(about_job(job, Severity::error, "E-FIT-STATES", std::move(message), why, fix));
  };
  if (arguments.covariance) {
    session.report(option_error("--covariance",
                                "what the states share (scales, squares) is not known, so there are no modes",
                                "leave it out: [uncertainty] is written"));
    return;
  }
  std::vector<FitAnswer> answers;
  std::vector<ThermalState> states;
  std::vector<std::string> inputs;
  for (std::size_t i = 0; i < arguments.jobs.size(); ++i) {
    auto answer = answer_of(arguments.jobs[i], arguments, session);
    if (!answer) return;
    if (auto unlike = unlike_first(i == 0 ? answer->job : answers.front().job, answer->job); !unlike.empty())
      return refuse(answer->job, std::move(unlike), "states are compared position by position",
                    "the same machine and reference in all jobs, without [[drift]]");
    report_doubts(answer->job, answer->result, session);
    states.push_back({asked->second[i], answer->result});
    inputs.insert(inputs.end(), answer->job.files.begin(), answer->job.files.end());
    answers.push_back(std::move(*answer));
  }
  const StateGrids grids = write_state_grids(answers.front().job, asked->first, states);
  if (!grids.obstacle.empty())
    return refuse(answers.front().job, grids.obstacle, "a grid needs every error in every state",
                  "measure and name the same in all jobs");
  answers.front().errors = grids.text;
  if (!read_back_with(asked->first, answers.front(), session) ||
      !publish(arguments, inputs, grids.text, session))
    return;
  for (std::size_t i = 0; i < answers.size() && !arguments.json; ++i)
    session.out.write(fmt::format("{}{} = {:g} degC\n{}", i == 0 ? "" : "\n", asked->first,
                                  states[i].temperature, text_of(answers[i])));
  if (!arguments.json) return;
  for (const FitAnswer& answer : answers) session.out.write(json_of(answer) + "\n");
}

void run_fit(const FitArguments& arguments, Session& session) {
  if (arguments.jobs.size() > 1 || !arguments.states.empty()) return run_states(arguments, session);
  const std::optional<FitAnswer> answer = answer_of(arguments.jobs.front(), arguments, session);
  if (!answer) return;
  report_doubts(answer->job, answer->result, session);
  report_thermal_doubts(answer->job, answer->thermal, session);
  if (!publish(arguments, answer->job.files, answer->errors, session)) return;
  session.out.write(arguments.json ? json_of(*answer) : text_of(*answer));
}

}  // namespace

Verb fit_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand(
      "fit", "the machine's errors from measurements: an errors file with uncertainties");
  auto arguments = std::make_shared<FitArguments>();
  command->add_option("job", arguments->jobs, "what was measured where (TOML); several with --states")
      ->required()
      ->type_name("JOB");
  command
      ->add_option("--states", arguments->states,
                   "temperature of each job: errors as grids of position and temperature")
      ->type_name("SENSOR=T/T/..");
  command->add_option("-o,--output", arguments->output, "errors file for --errors")->type_name("FILE");
  command->add_flag("--covariance", arguments->covariance,
                    "writes how the errors are uncertain together, for map --uncertainty");
  command->add_flag("--json", arguments->json, "JSON on standard output");
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [arguments, &session] { run_fit(*arguments, session); }};
}

}  // namespace abbe::app
