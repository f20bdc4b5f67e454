#include "circle_plan.h"

#include <fmt/core.h>

#include <numbers>
#include <utility>

#include "abbe/core/units.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr const char* kKeys =
    "plane radius feed directions from to overshoot acceleration samples noise setup";

/// One --test as it is read key by key.
class Reader {
 public:
  Reader(const std::string& text, Diagnostics& findings) : text_(text), findings_(findings) {
    plan_.circle.to = 2 * std::numbers::pi;
    plan_.circle.overshoot = 45 * deg;
    plan_.noise = 0.1 * um;
  }

  CirclePlan read() {
    for (const Assignment& given : split_assignments("--test", {text_}, findings_)) take(given);
    const PlannedCircle& c = plan_.circle;
    if (!plane_ || c.radius <= 0 || c.feed <= 0)
      findings_.push_back(option_error("--test", fmt::format("'{}' lacks plane, radius or feed", text_),
                                       "--test plane=XY,radius=100,feed=2000"));
    if (!(c.to > c.from)) findings_.push_back(option_error("--test", "'to' is not above 'from'"));
    return plan_;
  }

 private:
  void take(const Assignment& given) {
    PlannedCircle& c = plan_.circle;
    double samples = c.samples;
    if (given.name == "plane") {
      plane_ = read_plane(given.text);
      if (plane_) c.plane = *plane_;
    } else if (given.name == "directions") {
      take_directions(given.text);
    } else if (given.name == "setup") {
      c.setup = given.text;
    } else if (given.name == "radius") {
      number(given, c.radius, mm, 1e-3, 1e5);
    } else if (given.name == "feed") {
      number(given, c.feed, 1.0 / 60, 1e-3, 1e6);
    } else if (given.name == "acceleration") {
      number(given, c.acceleration, 1, 1e-3, 1e6);
    } else if (given.name == "from") {
      number(given, c.from, deg, -3600, 3600);
    } else if (given.name == "to") {
      number(given, c.to, deg, -3600, 3600);
    } else if (given.name == "overshoot") {
      number(given, c.overshoot, deg, 0, 3600);
    } else if (given.name == "noise") {
      number(given, plan_.noise, um, 0, 1e6);
    } else if (given.name == "samples") {
      number(given, samples, 1, 12, 1e6);
    } else {
      findings_.push_back(option_error("--test", fmt::format("unknown key '{}'", given.name), kKeys));
    }
    c.samples = static_cast<int>(samples);
  }

  void take_directions(const std::string& text) {
    if (text != "both" && text != "CCW" && text != "CW")
      findings_.push_back(option_error("--test", fmt::format("directions={}", text), "both, CCW or CW"));
    plan_.circle.counter_clockwise = text != "CW";
    plan_.circle.clockwise = text != "CCW";
  }

  void number(const Assignment& given, double& out, double unit, double least, double most) {
    const auto value = option_number("--test", given.name, given.text, findings_);
    if (!value) return;
    if (*value < least || *value > most)
      findings_.push_back(option_error("--test", fmt::format("{}={} is out of range", given.name, given.text),
                                       fmt::format("{} to {}", least, most)));
    out = *value * unit;
  }

  const std::string& text_;
  Diagnostics& findings_;
  CirclePlan plan_;
  std::optional<TestPlane> plane_;
};

}  // namespace

void add_plan_option(Command& verb, std::vector<std::string>& plan) {
  verb.add_option("--test", plan, fmt::format("one circular test; keys: {}", kKeys))
      ->required()
      ->type_name("KEY=VALUE,..")
      ->allow_extra_args(false);
}

std::optional<std::vector<CirclePlan>> read_plan(const std::vector<std::string>& plan, Session& session) {
  Diagnostics findings;
  std::vector<CirclePlan> out;
  for (const std::string& text : plan) out.push_back(Reader(text, findings).read());
  session.report(findings);
  if (has_errors(findings)) return std::nullopt;
  return out;
}

BallbarTest unmeasured(const CirclePlan& plan) {
  const PlannedCircle& c = plan.circle;
  BallbarTest test;
  test.file = name_of(c);
  test.plane = c.plane;
  test.radius = c.radius;
  test.feed = c.feed;
  test.centre = c.centre;
  test.setup = c.setup;
  if (plan.noise > 0) test.noise = plan.noise;
  for (const int s : {+1, -1}) {
    if (!(s > 0 ? c.counter_clockwise : c.clockwise)) continue;
    BallbarRun run;
    run.direction = s;
    for (int i = 0; i < c.samples; ++i) {
      const double part = (i + 0.5) / c.samples;
      run.angle.push_back(c.from + (s > 0 ? part : 1 - part) * (c.to - c.from));
      run.deviation.push_back(0);
    }
    test.runs.push_back(std::move(run));
  }
  return test;
}

std::string name_of(const PlannedCircle& circle) {
  return fmt::format("{} R{:g} mm, {:g} mm/min", to_string(circle.plane), circle.radius, circle.feed * 60);
}

}  // namespace abbe::app
