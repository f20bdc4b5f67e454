#include "abbe/simulate/drift.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/evaluate/monte_carlo.h"
#include "abbe/signal/lag.h"

namespace abbe {
namespace {

constexpr double kMinute = 60, kDay = 24 * 3600;

/// How a place of the machine answers to work.
struct Warmth {
  double constant = 0;  ///< s
  double rise = 0;      ///< K at full load, in the end
};

std::vector<Warmth> draw_places(std::size_t count, RandomStream& random) {
  std::vector<Warmth> places;
  for (std::size_t i = 0; i < count; ++i) {
    const double constant = 5 * kMinute * std::pow(18.0, random.uniform());
    places.push_back({constant, 3 + 13 * random.uniform()});
  }
  return places;
}

/// Loads from 0 to 1 that hold for a quarter of an hour to an hour and a half; the first moment is at rest.
std::vector<double> draw_load(const std::vector<double>& times, RandomStream& random) {
  std::vector<double> load;
  double level = 0, until = times.front();
  for (const double time : times) {
    load.push_back(level);
    if (time < until) continue;
    until = time + 15 * kMinute + 75 * kMinute * random.uniform();
    level = random.uniform();
  }
  return load;
}

/// One log: true temperatures, then what the hidden machine does at them.
class Watch {
 public:
  Watch(const FitJob& job, const Machine& hidden, const DriftScenario& scenario)
      : job_(job), hidden_(hidden), scenario_(scenario) {}

  std::optional<std::string> log(const FitDrift& drift, const std::vector<Warmth>& places,
                                 RandomStream& random) {
    set_temperatures(places, random);
    std::string text = "time [s]";
    for (const std::string& sensor : job_.thermal.sensors) text += fmt::format(",{} [degC]", sensor);
    for (const DriftReading& reading : drift.readings)
      text += fmt::format(",{} [{}]", reading.column, reading.rotation ? "urad" : "um");
    text += '\n';
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const auto plan = make_plan(hidden_, environment(i));
      if (!std::holds_alternative<Plan>(plan)) return std::nullopt;
      text += fmt::format("{:g}", times_[i]);
      for (const auto& course : temperatures_)
        text += fmt::format(",{:.4f}", course[i] + scenario_.temperature * random.normal());
      for (const DriftReading& reading : drift.readings)
        text += fmt::format(",{:.4f}", seen(std::get<Plan>(plan), drift, reading, random));
      text += '\n';
    }
    return text;
  }

 private:
  void set_temperatures(const std::vector<Warmth>& places, RandomStream& random) {
    times_.clear();
    temperatures_.clear();
    for (double time = 0; time <= scenario_.duration; time += scenario_.step) times_.push_back(time);
    const std::vector<double> load = draw_load(times_, random);
    for (const Warmth& place : places) {
      std::vector<double> course = first_order_lag(times_, load, place.constant);
      for (std::size_t i = 0; i < course.size(); ++i)
        course[i] = scenario_.start + place.rise * course[i] +
                    0.5 * std::sin(2 * std::numbers::pi * times_[i] / kDay);
      temperatures_.push_back(std::move(course));
    }
    lagged_.clear();
    for (const LaggedSensor& sensor : hidden_.lagged_sensors)
      for (std::size_t s = 0; s < job_.thermal.sensors.size(); ++s)
        if (job_.thermal.sensors[s] == sensor.of)
          lagged_.emplace_back(sensor.name, first_order_lag(times_, temperatures_[s], sensor.lag));
  }

  [[nodiscard]] Environment environment(std::size_t i) const {
    Environment out;
    for (std::size_t s = 0; s < temperatures_.size(); ++s) out[job_.thermal.sensors[s]] = temperatures_[s][i];
    for (const auto& [name, course] : lagged_) out[name] = course[i];
    return out;
  }

  /// um or urad, with an instrument's zero of 3 and its sign.
  double seen(const Plan& plan, const FitDrift& drift, const DriftReading& reading,
              RandomStream& random) const {
    constexpr double kZero = 3;
    Query query;
    query.q = drift.at;
    query.tool = {reading.point, job_.machine.tool.axis};
    const Eigen::AngleAxisd turn(Mat3(actual_pose(plan, query).R * nominal_pose(plan, query).R.transpose()));
    const double value = reading.rotation
                             ? reading.direction.dot(turn.angle() * turn.axis()) / urad
                             : reading.direction.dot(actual_tip(plan, query) - nominal_tip(plan, query)) / um;
    const double noise = reading.rotation ? scenario_.angle / urad : scenario_.length / um;
    return reading.sign * value + kZero + noise * random.normal();
  }

  const FitJob& job_;
  const Machine& hidden_;
  DriftScenario scenario_;
  std::vector<double> times_;
  std::vector<std::vector<double>> temperatures_;
  std::vector<std::pair<std::string, std::vector<double>>> lagged_;
};

}  // namespace

std::vector<SimulatedFile> simulate_drift(const FitJob& job, const Machine& hidden,
                                          const DriftScenario& scenario, std::uint64_t seed) {
  RandomStream random(seed);
  const std::vector<Warmth> places = draw_places(job.thermal.sensors.size(), random);
  Watch watch(job, hidden, scenario);
  std::vector<SimulatedFile> files;
  for (const FitDrift& drift : job.drifts) {
    std::optional<std::string> text = watch.log(drift, places, random);
    if (!text) return {};
    files.push_back({drift.file, std::move(*text)});
  }
  return files;
}

}  // namespace abbe
