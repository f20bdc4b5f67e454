#include <fmt/core.h>

#include <memory>
#include <string>
#include <vector>

#include "abbe/ballbar/ballbar_file.h"
#include "abbe/capture/write_capture.h"
#include "abbe/core/units.h"
#include "circle_plan.h"
#include "common.h"
#include "number_check.h"
#include "output_file.h"
#include "simulate.h"

namespace abbe::app {
namespace {

constexpr double kCountsPerMm = 1e5;  // of the simulated encoders: 10 nm
constexpr int kLargestCount = 21000;  // mm that 32 bits of counts reach
constexpr double kMostCycles = 1e7;   // of one run: 0.5 GB of positions

struct SimulateArguments {
  CommonArguments common;
  std::vector<std::string> plan, lag;
  double clock_ms = 0, colour = 0, cycle_us = 1000;
  bool positions = false, bus = false;
  unsigned seed = 1;
  std::string prefix;
};

/// --lag X=0.8,Y=1.1 in ms.
bool read_lag(const SimulateArguments& arguments, SimulationSettings& settings, Session& session) {
  Diagnostics findings;
  for (const Assignment& given : split_assignments("--lag", arguments.lag, findings)) {
    const auto value = option_number("--lag", given.name, given.text, findings);
    const int axis = given.name.size() == 1 ? given.name[0] - 'X' : -1;
    if (!value) continue;
    if (axis < 0 || axis > 2 || *value < 0 || *value > 1000)
      findings.push_back(
          option_error("--lag", fmt::format("{}={}", given.name, given.text), "--lag X=0.8,Y=1.1 (ms)"));
    else
      settings.lag[static_cast<std::size_t>(axis)] = *value * 1e-3;
  }
  session.report(findings);
  return !has_errors(findings);
}

/// The axes of the test as drives on a bus, their positions as columns of a capture.
class BusColumns {
 public:
  BusColumns(const PlannedCircle& circle, const std::vector<BusRecord>& records) {
    for (const int axis : {circle.plane.first, circle.plane.second}) {
      ServoAxis servo;
      servo.name = std::string(1, axis_letter(axis));
      servo.station = static_cast<std::uint16_t>(1001 + axis);
      servo.counts_per_unit = kCountsPerMm;
      axes_.push_back(servo);
      add(servo.name + ".target_position", records, axis, &BusRecord::commanded);
      add(servo.name + ".position_actual", records, axis, &BusRecord::actual);
    }
    map_ = servo_map(axes_);
    for (std::size_t k = 0; k < names_.size(); ++k) columns_.push_back({names_[k], values_[k]});
  }

  [[nodiscard]] const ProcessMap& map() const { return map_; }
  [[nodiscard]] const std::vector<CaptureColumn>& columns() const { return columns_; }

 private:
  void add(const std::string& name, const std::vector<BusRecord>& records, int axis,
           std::vector<Vec3> BusRecord::*member) {
    std::vector<double> values;
    for (const BusRecord& record : records)
      for (const Vec3& q : record.*member) values.push_back(q[axis]);
    names_.push_back(name);
    values_.push_back(std::move(values));
  }

  std::vector<ServoAxis> axes_;
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;
  std::vector<CaptureColumn> columns_;
  ProcessMap map_;
};

bool write_bus(const std::string& path, const PlannedCircle& circle, const SimulatedCircle& made,
               double cycle, Session& session) {
  FileResult<SpoolFile> created = SpoolFile::create(path);
  if (const auto* error = std::get_if<FileError>(&created)) {
    session.report(*error, path);
    return false;
  }
  auto& file = std::get<SpoolFile>(created);
  const BusColumns bus(circle, made.bus);
  CaptureSettings settings;
  settings.cycle = cycle;
  if (const auto problem = write_capture(bus.map(), bus.columns(), settings, file)) {
    session.report(*problem);
    return false;
  }
  if (file.publish()) return true;
  session.report(file.error().value_or(FileError{"cannot be written"}), path);
  return false;
}

/// The axis whose travel ends before the circle with run-in and run-out does; empty if there is none.
std::string leaving(const Machine& machine, const PlannedCircle& c) {
  constexpr int kSteps = 720;
  for (int i = 0; i <= kSteps; ++i) {
    const double first = c.from - c.overshoot, last = c.to + c.overshoot;
    const Vec3 q = c.centre + c.radius * radial_direction(c.plane, first + (last - first) * i / kSteps);
    for (const int k : {c.plane.first, c.plane.second}) {
      const Body& axis = machine.axis(machine.find_axis(std::string(1, axis_letter(k))));
      if (axis.range && (q[k] < (*axis.range)[0] || q[k] > (*axis.range)[1])) return axis.name;
    }
  }
  return {};
}

/// False after telling which test this machine cannot perform, or this program not hold.
bool tests_can_be_done(const Machine& machine, const std::vector<CirclePlan>& plan, double cycle,
                       Session& session) {
  for (const CirclePlan& planned : plan) {
    if (const std::string axis = leaving(machine, planned.circle); !axis.empty())
      session.report(option_error("--test",
                                  fmt::format("{} leaves the travel of {}", name_of(planned.circle), axis),
                                  "a smaller radius or arc"));
    if (const double cycles = duration_of(planned.circle) / cycle; cycles > kMostCycles)
      session.report(option_error(
          "--test", fmt::format("{} takes {:.3g} cycles of the bus", name_of(planned.circle), cycles),
          fmt::format("{:g} at most: a higher feed, or a longer --cycle-us", kMostCycles)));
  }
  return !session.has(Exit::invalid);
}

bool axes_are_there(const Machine& machine, const std::vector<CirclePlan>& plan, Session& session) {
  for (const CirclePlan& planned : plan) {
    for (const int k : {planned.circle.plane.first, planned.circle.plane.second}) {
      const int axis = machine.find_axis(std::string(1, axis_letter(k)));
      if (axis >= 0 && machine.axis(axis).type == AxisType::linear) continue;
      session.report(
          option_error("--test", fmt::format("this machine has no linear axis {}", axis_letter(k))));
      return false;
    }
    if (planned.circle.radius < kLargestCount) continue;
    session.report(option_error("--test", "the radius is too large for the counts of the drives"));
    return false;
  }
  return true;
}

void run_simulation(const SimulateArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_setting(arguments.common, session);
  const auto plan = read_plan(arguments.plan, session);
  SimulationSettings settings;
  if (!setting || !plan || !read_lag(arguments, settings, session)) return;
  const double cycle = arguments.cycle_us * 1e-6;
  if (!axes_are_there(setting->machine, *plan, session) ||
      !tests_can_be_done(setting->machine, *plan, cycle, session))
    return;
  const std::optional<Plan> model = plan_or_report(*setting, setting->environment, session);
  if (!model) return;
  settings.clock_offset = arguments.clock_ms * 1e-3;
  settings.colour = arguments.colour;
  settings.positions = arguments.positions;
  std::vector<OutputFile> files;
  for (std::size_t i = 0; i < plan->size() && !interrupted(); ++i) {
    const PlannedCircle& circle = (*plan)[i].circle;
    settings.noise = (*plan)[i].noise;
    settings.seed = arguments.seed * 1000ULL + i;
    const SimulatedCircle made = simulate_circle(*model, circle, settings, cycle);
    const std::string path = fmt::format("{}{}", arguments.prefix, i + 1);
    files.push_back({"--out", path + ".csv", write_ballbar(made.test)});
    if (arguments.bus && !write_bus(path + ".pcap", circle, made, cycle, session)) return;
    session.out.write(fmt::format("{}.csv{}: {}, {} samples\n", path, arguments.bus ? " and .pcap" : "",
                                  name_of(circle), made.test.samples()));
  }
  if (!write_outputs(files, setting->machine.files, session)) session.note(Exit::internal);
}

}  // namespace

Verb simulate_ballbar_verb(Command& simulate, Session& session) {
  Command* command = simulate.add_subcommand("ballbar", "circular tests of a machine with all its errors");
  auto a = std::make_shared<SimulateArguments>();
  add_common_options(*command, a->common, session);
  add_plan_option(*command, a->plan);
  command->add_option("--lag", a->lag, "time constants of the position loops, ms: X=0.8,Y=1.1")
      ->allow_extra_args(false);
  command->add_option("--clock-ms", a->clock_ms, "standard deviation of the clock of a run")
      ->check(not_negative());
  command->add_option("--colour", a->colour, "correlation of neighbouring noise, 0 (white) to below 1")
      ->check(number_in(0.0, 0.999));
  command->add_option("--cycle-us", a->cycle_us, "cycle of the bus (1000)")->check(number_in(50.0, 1e5));
  command->add_option("--seed", a->seed, "of the noise (1)");
  command->add_flag("--positions", a->positions, "commanded and actual positions as columns of the traces");
  command->add_flag("--bus", a->bus, "an EtherCAT capture beside each trace");
  command->add_option("-o,--out", a->prefix, "traces are PREFIX1.csv, PREFIX2.csv, ..")
      ->required()
      ->type_name("PREFIX");
  return {command, [a, &session] { run_simulation(*a, session); }};
}

}  // namespace abbe::app
