// The verbs identify and identifiability.

#include <fmt/core.h>

#include <memory>
#include <string>

#include "abbe/core/units.h"
#include "abbe/identify/errors_file.h"
#include "abbe/identify/joint.h"
#include "abbe/identify/joint_design.h"
#include "ballbar_source.h"
#include "circle_plan.h"
#include "common.h"
#include "identify_answer.h"
#include "number_check.h"
#include "output_file.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

struct IdentifyArguments {
  CommonArguments common;
  BallbarArguments source;
  std::string method = "joint", output;
  TermChoice terms;
  bool no_lost_motion = false, no_velocity = false, no_acceleration = false, least_norm = false;
  std::optional<double> noise_um;
  double rank_tolerance = 1e-3, clock_ms = 0, reversal_ms = 20;
  std::vector<std::string> plan;  ///< of identifiability
};

void add_model_options(Command& verb, IdentifyArguments& a) {
  const auto order = whole_in(0, 6);
  verb.add_option("--positioning", a.terms.positioning, "powers of positioning errors, 0 = none (3)")
      ->check(order);
  verb.add_option("--straightness", a.terms.straightness, "powers of straightness errors, 0 = none (3)")
      ->check(order);
  verb.add_option("--rotation", a.terms.rotation, "powers of rotations, 0 = none (1)")->check(order);
  verb.add_option("--splines", a.terms.splines,
                  "positioning and straightness as splines with so many nodes over the tested travel")
      ->check(whole_in(4, 40));
  verb.add_flag("--lateral-play", a.terms.lateral_play, "lost motion across the axes as well");
  verb.add_flag("--cross", a.terms.cross, "velocity and acceleration act across the axes as well");
  verb.add_flag("--no-lost-motion", a.no_lost_motion, "no lost motion");
  verb.add_flag("--no-velocity", a.no_velocity, "no terms of velocity");
  verb.add_flag("--no-acceleration", a.no_acceleration, "no terms of acceleration");
  verb.add_flag("--least-norm", a.least_norm, "unseen combinations: least norm in place of zeros");
  verb.add_option("--noise-um", a.noise_um, "standard deviation of a deviation, in place of what files say")
      ->check(above_zero());
  verb.add_option("--rank-tolerance", a.rank_tolerance,
                  "singular values below it times the largest are zero (1e-3)")
      ->check(number_in(1e-12, 0.5));
  verb.add_option("--reversal-ms", a.reversal_ms, "samples closer to a reversal are left out (20)")
      ->check(not_negative());
}

IdentifyOptions options_of(const IdentifyArguments& a) {
  IdentifyOptions options;
  options.terms = a.terms;
  options.terms.lost_motion = !a.no_lost_motion;
  options.terms.velocity = !a.no_velocity;
  options.terms.acceleration = !a.no_acceleration;
  options.assume_zero = !a.least_norm;
  if (a.noise_um) options.noise = *a.noise_um * um;
  options.rank_tolerance = a.rank_tolerance;
  options.time_offset = a.clock_ms * 1e-3;
  options.reversal_window = a.reversal_ms * 1e-3;
  return options;
}

/// False after telling why there is no answer.
bool solved_or_report(const Identification& found, Session& session) {
  using Status = Identification::Status;
  Diagnostic why;
  why.code = "E-IDENTIFY";
  why.place.file = "identify";
  switch (found.status) {
    case Status::ok:
      return true;
    case Status::no_axes:
      why.message = "an axis of a test is no linear axis of the machine";
      why.fix = "the axes X, Y, Z of the tests must be axes of the chain with these names";
      break;
    case Status::no_sign:
      why.code = "E-ERRORS-SEEN";
      why.message = "an axis of a test carries the workpiece, and the machine file has no errors_seen for it";
      why.why =
          "an error of the table itself and the error of the tool seen from the work have opposite signs";
      why.fix =
          "add errors_seen = \"body\" or \"tool\" to that axis before identifying; the errors are written as "
          "it says";
      break;
    case Status::too_few_rows:
      why.message = "fewer samples than unknowns (those near reversals do not count: --reversal-ms)";
      why.fix = "measure more, or ask for fewer terms (--rotation 0, --straightness 2)";
      break;
    case Status::not_finite:
      why.message = "the numbers are too large to calculate with";
      break;
  }
  session.report(why);
  return false;
}

ErrorsFileHead head_of(const Machine& machine, const std::vector<BallbarTest>& tests,
                       const std::string& method) {
  ErrorsFileHead head;
  head.calibration = machine.calibration;
  head.calibration.date.clear();  // that of the machine file is not of these tests
  head.remarks.push_back(
      fmt::format("identified by abbe {} from circular tests, method {}", ABBE_VERSION, method));
  for (const BallbarTest& test : tests)
    head.remarks.push_back(fmt::format("  {}: {} R{:g} mm, {:g} mm/min", test.file, to_string(test.plane),
                                       test.radius, test.feed * 60));
  return head;
}

void run_joint(const IdentifyArguments& a, const Machine& machine, const std::vector<BallbarTest>& tests,
               Session& session) {
  const Identification found = identify_jointly(machine, tests, options_of(a));
  if (!solved_or_report(found, session)) return;
  const OutputFile file{"-o", a.output,
                        errors_file_of(machine, found, tests, head_of(machine, tests, "joint"))};
  std::vector<std::string> inputs = a.source.files;
  inputs.push_back(a.common.machine);
  if (!write_outputs({file}, inputs, session)) return;
  if (!found.trusted) {
    Diagnostic doubt;
    doubt.severity = Severity::warning;
    doubt.code = "W-RESIDUALS";
    doubt.place.file = tests.front().file;
    doubt.message = "the residuals do not look like the stated noise: " + found.doubts.front();
    doubt.why =
        "the uncertainties were enlarged, but what is missing in the model is not in the errors either";
    doubt.fix = "more terms, or `abbe ballbar` for cyclic errors and spikes";
    session.report(doubt);
  }
  if (!a.common.json) {
    session.out.write(identification_text(machine, found, tests, false) + balance_text(found, tests));
    return;
  }
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "identify", machine);
  json.member("method", "joint");
  write_identification(json, machine, found, tests, false);
  json.end();
  session.out.write(json.take());
}

/// The published errors are those of the tool seen from the work. False after telling that the machine file
/// states those of a table of the tests itself, or does not say: they have the opposite sign.
bool errors_are_of_the_tool(const Machine& machine, const std::vector<BallbarTest>& tests, Session& session) {
  for (const int i : moving_axes(machine, tests)) {
    const Body& axis = machine.axis(i);
    if (axis.branch == Branch::tool || axis.errors_seen_at_tool) continue;
    Diagnostic why;
    why.code = "E-ERRORS-SEEN";
    why.place.file = "identify";
    why.message = fmt::format("axis {} carries the workpiece, without errors_seen = \"tool\"", axis.name);
    why.why =
        "the published method finds errors of the tool seen from the work; those of the table itself have "
        "the opposite sign";
    why.fix = fmt::format("write errors_seen = \"tool\" into [axis.{}], or use --method joint", axis.name);
    session.report(why);
    return false;
  }
  return true;
}

void run_paper(const IdentifyArguments& a, const Machine& machine, const std::vector<BallbarTest>& tests,
               Session& session) {
  if (!errors_are_of_the_tool(machine, tests, session)) return;
  std::vector<PaperTest> paper;
  std::vector<BallbarTest> circles;
  for (const BallbarTest& test : tests) {
    const bool known =
        test.plane == TestPlane{0, 1} || test.plane == TestPlane{0, 2} || test.plane == TestPlane{1, 2};
    bool again = false;
    for (const PaperTest& other : paper) again = again || other.plane == test.plane;
    if (!known || again) {
      Diagnostic why;
      why.code = "E-IDENTIFY";
      why.place.file = test.file;
      why.message =
          fmt::format("the published method knows one test each of the planes XY, XZ, YZ, not {} {}",
                      again ? "a second one of" : "of", to_string(test.plane));
      why.fix = "one file per plane, or --method joint";
      session.report(why);
      return;
    }
    paper.push_back(paper_test(test, test.runs.front()));
    circles.push_back(test);
  }
  const PaperResult result = identify_paper(paper);
  ErrorsFileHead head = head_of(machine, tests, "paper");
  head.remarks.push_back(
      "displacements count from the start points; sines are of the tests and are never compensated");
  std::vector<std::string> inputs = a.source.files;
  inputs.push_back(a.common.machine);
  if (!write_outputs({{"-o", a.output, errors_file_of(result, paper, circles, head)}}, inputs, session))
    return;
  if (!a.common.json) {
    session.out.write(paper_text(result));
    return;
  }
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "identify", machine);
  json.member("method", "paper");
  write_paper(json, result);
  json.end();
  session.out.write(json.take());
}

void run_identify(const IdentifyArguments& a, Session& session) {
  const std::optional<Setting> setting = load_setting(a.common, session);
  const auto tests = load_ballbars(a.source, session);
  if (!setting || !tests) return;
  if (a.method == "paper") {
    run_paper(a, setting->machine, *tests, session);
  } else {
    run_joint(a, setting->machine, *tests, session);
  }
}

void run_identifiability(const IdentifyArguments& a, Session& session) {
  const std::optional<Setting> setting = load_setting(a.common, session);
  if (!setting) return;
  const auto circles = read_plan(a.plan, session);
  if (!circles) return;
  std::vector<BallbarTest> plan;
  for (const CirclePlan& circle : *circles) plan.push_back(unmeasured(circle));
  const Identification found = identifiability(setting->machine, plan, options_of(a));
  if (!solved_or_report(found, session)) return;
  if (!a.common.json) {
    session.out.write(identification_text(setting->machine, found, plan, true));
    return;
  }
  JsonWriter json;
  json.begin_object();
  write_preamble(json, "identifiability", setting->machine);
  write_identification(json, setting->machine, found, plan, true);
  json.end();
  session.out.write(json.take());
}

}  // namespace

Verb identify_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("identify", "errors of a machine from circular tests, with uncertainties");
  auto a = std::make_shared<IdentifyArguments>();
  add_machine_options(*command, a->common, session);
  command->add_option("TEST", a->source.files, "ball-bar traces (CSV)")->required();
  add_ballbar_options(*command, a->source);
  command->add_option("--method", a->method, "joint least squares, or as published (joint)")
      ->check(one_of({"joint", "paper"}));
  command->add_option("-o,--out", a->output, "errors file, for predict and compensate --errors")
      ->type_name("FILE");
  command->add_option("--clock-ms", a->clock_ms, "standard uncertainty of the clock of a run; 0: not sought")
      ->check(not_negative());
  add_model_options(*command, *a);
  return {command, [a, &session] { run_identify(*a, session); }};
}

Verb identifiability_verb(Command& program, Session& session) {
  Command* command = program.add_subcommand(
      "identifiability", "what a plan of circular tests would tell, before it is measured");
  auto a = std::make_shared<IdentifyArguments>();
  add_machine_options(*command, a->common, session);
  add_plan_option(*command, a->plan);
  add_model_options(*command, *a);
  return {command, [a, &session] { run_identifiability(*a, session); }};
}

}  // namespace abbe::app
