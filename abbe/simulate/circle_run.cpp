#include "abbe/simulate/circle_run.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "abbe/chain/predict.h"

namespace abbe {
namespace {

/// Distance along a path that starts and stops with one acceleration.
class Trapezoid {
 public:
  Trapezoid(double length, double feed, double acceleration) : length_(length), a_(acceleration) {
    // A path too short for the feed turns round half-way.
    v_ = std::min(feed, std::sqrt(length * acceleration));
    ramp_ = v_ / a_;
    duration_ = length_ / v_ + ramp_;
  }
  [[nodiscard]] double duration() const { return duration_; }
  [[nodiscard]] double at(double t) const {
    t = std::clamp(t, 0.0, duration_);
    if (t < ramp_) return a_ * t * t / 2;
    if (t > duration_ - ramp_) return length_ - a_ * (duration_ - t) * (duration_ - t) / 2;
    return v_ * (t - ramp_ / 2);
  }
  /// When the distance s is reached.
  [[nodiscard]] double time_of(double s) const {
    double lo = 0, hi = duration_;
    for (int i = 0; i < 60; ++i) (at((lo + hi) / 2) < s ? lo : hi) = (lo + hi) / 2;
    return (lo + hi) / 2;
  }

 private:
  double length_, a_, v_ = 0, ramp_ = 0, duration_ = 0;
};

Trapezoid path_of(const PlannedCircle& circle) {
  return {circle.radius * (circle.to - circle.from + 2 * circle.overshoot), circle.feed, circle.acceleration};
}

/// One run of the machine: commands and what the axes do, on a grid of time fine enough for the model.
class Run {
 public:
  Run(const Plan& plan, const PlannedCircle& circle, const SimulationSettings& settings, int direction,
      double cycle)
      : plan_(plan), circle_(circle), direction_(direction), cycle_(cycle), path_(path_of(circle)) {
    follow(settings.lag);
  }

  [[nodiscard]] double angle(double t) const {
    const double s = path_.at(t) / circle_.radius;
    return direction_ > 0 ? circle_.from - circle_.overshoot + s : circle_.to + circle_.overshoot - s;
  }
  [[nodiscard]] Vec3 commanded(double t) const {
    return circle_.centre + circle_.radius * radial_direction(circle_.plane, angle(t));
  }
  [[nodiscard]] Vec3 actual(double t) const { return interpolated(actual_, t); }

  /// When the arc (without run-in and run-out) begins and ends.
  [[nodiscard]] std::array<double, 2> arc() const {
    return {path_.time_of(circle_.radius * circle_.overshoot),
            path_.time_of(circle_.radius * (circle_.to - circle_.from + circle_.overshoot))};
  }

  /// The tool ball in workpiece axes.
  [[nodiscard]] Vec3 ball(double t) const {
    const Vec3 q = actual(t), before = actual(t - cycle_), behind = actual(t + cycle_);
    return tip(q, (behind - before) / (2 * cycle_), (behind - 2 * q + before) / (cycle_ * cycle_));
  }
  [[nodiscard]] Vec3 ball_at_rest(const Vec3& q) const { return tip(q, Vec3::Zero(), Vec3::Zero()); }

  [[nodiscard]] BusRecord bus() const {
    BusRecord out;
    out.actual = actual_;
    for (std::size_t i = 0; i < actual_.size(); ++i)
      out.commanded.push_back(commanded(static_cast<double>(i) * cycle_));
    return out;
  }

 private:
  /// y' = (x - y) / lag, exact for commands that are straight within a cycle.
  void follow(const std::array<double, 3>& lag) {
    const auto count = static_cast<std::size_t>(path_.duration() / cycle_) + 3;
    Vec3 y = commanded(0), x = y;
    for (std::size_t i = 0; i < count; ++i) {
      actual_.push_back(y);
      const Vec3 next = commanded(static_cast<double>(i + 1) * cycle_);
      for (int k = 0; k < 3; ++k) {
        const double tau = lag[static_cast<std::size_t>(k)], slope = (next[k] - x[k]) / cycle_;
        // A steady slope is followed tau later; what is left decays.
        y[k] =
            tau > 0 ? next[k] - slope * tau + (y[k] - x[k] + slope * tau) * std::exp(-cycle_ / tau) : next[k];
      }
      x = next;
    }
  }

  [[nodiscard]] Vec3 interpolated(const std::vector<Vec3>& values, double t) const {
    // A parabola through three samples: velocities and accelerations of the model must be smooth.
    const double at = std::clamp(t / cycle_, 1.0, static_cast<double>(values.size()) - 2.0);
    const auto i = static_cast<std::size_t>(std::lround(at));
    const double x = t / cycle_ - static_cast<double>(i);
    const Vec3 slope = (values[i + 1] - values[i - 1]) / 2,
               bend = (values[i + 1] - 2 * values[i] + values[i - 1]) / 2;
    return std::abs(x) > 2 ? values[x > 0 ? values.size() - 1 : 0] : Vec3(values[i] + x * (slope + x * bend));
  }

  [[nodiscard]] Vec3 tip(const Vec3& q, const Vec3& v, const Vec3& a) const {
    const Machine& machine = plan_.machine();
    Query query;
    query.tool = tool_of(machine);
    std::array<double, kMaxAxes> velocity{}, acceleration{};
    for (int k = 0; k < 3; ++k) {
      const int axis = machine.find_axis(std::string(1, axis_letter(k)));
      if (axis < 0) continue;
      const auto i = static_cast<std::size_t>(axis);
      query.q[i] = q[k];
      velocity[i] = v[k];
      acceleration[i] = a[k];
      query.approach[i] = v[k] > kStill ? +1 : v[k] < -kStill ? -1 : 0;
    }
    const auto axes = static_cast<std::size_t>(machine.axis_count());
    query.velocity = {velocity.data(), axes};
    query.acceleration = {acceleration.data(), axes};
    return actual_tip(plan_, query);
  }

  static constexpr double kStill = 1e-9;  // mm/s

  const Plan& plan_;
  const PlannedCircle& circle_;
  int direction_;
  double cycle_;
  Trapezoid path_;
  std::vector<Vec3> actual_;
};

/// White noise, or noise whose neighbours resemble each other, of the same standard deviation.
class Noise {
 public:
  Noise(std::mt19937_64& random, double sigma, double colour)
      : random_(random), sigma_(sigma), colour_(colour), state_(normal_(random)) {}
  double next() {
    const double out = sigma_ * state_;
    state_ = colour_ * state_ + std::sqrt(1 - colour_ * colour_) * normal_(random_);
    return out;
  }

 private:
  std::mt19937_64& random_;
  double sigma_, colour_;
  std::normal_distribution<double> normal_;
  double state_;
};

}  // namespace

double duration_of(const PlannedCircle& circle) { return path_of(circle).duration(); }

SimulatedCircle simulate_circle(const Plan& plan, const PlannedCircle& circle,
                                const SimulationSettings& settings, double cycle) {
  SimulatedCircle out;
  BallbarTest& test = out.test;
  test.plane = circle.plane;
  test.radius = circle.radius;
  test.feed = circle.feed;
  test.centre = circle.centre;
  test.setup = circle.setup;
  test.machine = plan.machine().name;
  test.instrument = "simulated";
  if (settings.noise > 0) test.noise = settings.noise;
  std::mt19937_64 random(settings.seed);
  std::normal_distribution<double> normal;
  for (const int direction : {+1, -1}) {
    if (!(direction > 0 ? circle.counter_clockwise : circle.clockwise)) continue;
    const Run machine(plan, circle, settings, direction, cycle);
    const Vec3 centre = machine.ball_at_rest(circle.centre) + settings.mounting;
    const double clock = settings.clock_offset * normal(random);
    Noise noise(random, settings.noise, settings.colour);
    BallbarRun run;
    run.direction = direction;
    const auto [begin, end] = machine.arc();
    for (int i = 0; i < circle.samples; ++i) {
      const double t = begin + (end - begin) * (i + 0.5) / circle.samples;
      run.angle.push_back(machine.angle(t));
      run.time.push_back(t);
      run.deviation.push_back((machine.ball(t + clock) - centre).norm() - circle.radius -
                              settings.bar_length + noise.next());
      if (!settings.positions) continue;
      run.commanded.push_back(machine.commanded(t + clock));
      run.actual.push_back(machine.actual(t + clock));
    }
    test.runs.push_back(std::move(run));
    out.bus.push_back(machine.bus());
  }
  return out;
}

}  // namespace abbe
