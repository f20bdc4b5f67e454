#include "ballbar_source.h"

#include <utility>

#include "common.h"
#include "number_check.h"

namespace abbe::app {
namespace {

/// A run of `a` is one of `b` to the last digit: measured once, given twice.
bool share_a_run(const BallbarTest& a, const BallbarTest& b) {
  if (!(a.plane == b.plane) || a.radius != b.radius || a.feed != b.feed) return false;
  for (const BallbarRun& run : a.runs)
    for (const BallbarRun& other : b.runs)
      if (run.direction == other.direction && run.angle == other.angle && run.deviation == other.deviation)
        return true;
  return false;
}

/// False after telling which files hold the same readings.
bool are_different(const std::vector<BallbarTest>& tests, Session& session) {
  for (std::size_t i = 0; i < tests.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (!share_a_run(tests[i], tests[k])) continue;
      Diagnostic twice;
      twice.code = "E-BALLBAR";
      twice.place.file = tests[i].file;
      twice.message = "the readings of " + tests[k].file + " again";
      twice.why = "counted twice they would make every uncertainty smaller than it is";
      twice.fix = "name each measurement once";
      session.report(twice);
      return false;
    }
  }
  return true;
}

}  // namespace

void add_ballbar_options(Command& verb, BallbarArguments& arguments) {
  verb.add_option("--plane", arguments.plane,
                  "plane, where the file does not say it: angles from the first axis")
      ->type_name("XY");
  verb.add_option("--radius", arguments.radius, "nominal radius, where the file does not say it")
      ->check(above_zero())
      ->type_name("MM");
  verb.add_option("--feed", arguments.feed, "feed along the path, where the file does not say it")
      ->check(above_zero())
      ->type_name("MM/MIN");
  verb.add_option("--direction", arguments.direction, "direction, where the file does not say it")
      ->check(one_of({"CCW", "CW"}));
}

std::optional<BallbarDefaults> ballbar_defaults(const BallbarArguments& arguments, Session& session) {
  BallbarDefaults defaults;
  defaults.radius = arguments.radius;
  if (arguments.feed) defaults.feed = *arguments.feed / 60;
  if (!arguments.direction.empty()) defaults.direction = arguments.direction == "CCW" ? +1 : -1;
  if (arguments.plane.empty()) return defaults;
  defaults.plane = read_plane(arguments.plane);
  if (defaults.plane) return defaults;
  session.report(option_error("--plane", "expected two different letters of X Y Z", "--plane XY"));
  return std::nullopt;
}

std::optional<BallbarTest> load_ballbar(const std::string& file, const BallbarDefaults& defaults,
                                        Session& session) {
  const std::optional<std::string> text = read_input(file, session);
  if (!text) return std::nullopt;
  Parsed<BallbarTest> read = read_ballbar(file == "-" ? "<stdin>" : file, *text, defaults);
  session.report(read.diagnostics);
  return std::move(read.value);
}

std::optional<std::vector<BallbarTest>> load_ballbars(const BallbarArguments& arguments, Session& session) {
  const std::optional<BallbarDefaults> defaults = ballbar_defaults(arguments, session);
  if (!defaults) return std::nullopt;
  std::vector<BallbarTest> tests;
  for (const std::string& file : arguments.files)
    if (auto test = load_ballbar(file, *defaults, session)) tests.push_back(std::move(*test));
  if (tests.size() != arguments.files.size() || !are_different(tests, session)) return std::nullopt;
  return tests;
}

}  // namespace abbe::app
