#include "abbe/fit/thermal_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/evaluate/monte_carlo.h"
#include "abbe/fit/ridge.h"
#include "abbe/fit/sensor_groups.h"
#include "abbe/signal/lag.h"

namespace abbe {
namespace {

constexpr double kMinute = 60;

/// Temperatures of a machine that works and rests: sensor s warms up towards its load with its own time
/// constant.
struct Log {
  DriftCourse course;
  Log(std::uint64_t seed, int rows, double minutes, const std::vector<double>& constants,
      bool validation = false) {
    RandomStream random(seed);
    course.validation = validation;
    std::vector<double> load(static_cast<std::size_t>(rows));
    double level = 0;
    for (int i = 0; i < rows; ++i) {
      if (i % std::max(1, rows / 8) == 0) level = 2 + 14 * random.uniform();
      course.times.push_back(i * minutes * kMinute / (rows - 1));
      load[static_cast<std::size_t>(i)] = i == 0 ? 0 : level;
    }
    for (const double constant : constants) {
      std::vector<double> T = first_order_lag(course.times, load, constant * kMinute);
      for (double& value : T) value += 20;
      course.temperatures.push_back(std::move(T));
    }
  }
  [[nodiscard]] Eigen::VectorXd lagged(std::size_t sensor, double lag) const {
    const std::vector<double> T = first_order_lag(course.times, course.temperatures[sensor], lag);
    return Eigen::Map<const Eigen::VectorXd>(T.data(), static_cast<Eigen::Index>(T.size())).array() - 20;
  }
  /// The same log begun later, when the machine is warm.
  [[nodiscard]] DriftCourse from_row(std::size_t row) const {
    const auto skip = static_cast<std::ptrdiff_t>(row);
    DriftCourse late = course;
    late.times.erase(late.times.begin(), late.times.begin() + skip);
    for (std::vector<double>& T : late.temperatures) T.erase(T.begin(), T.begin() + skip);
    late.errors = course.errors.bottomRows(course.errors.rows() - skip);
    return late;
  }
  void set_error(const Eigen::VectorXd& truth, double noise, std::uint64_t seed) {
    RandomStream random(seed);
    course.errors = truth;
    for (double& value : course.errors.reshaped()) value += 7 + noise * random.normal();
  }
};

FitThermal asked(std::size_t sensors, FitThermal::Selection selection = FitThermal::Selection::stepwise,
                 FitThermal::Model model = FitThermal::Model::automatic) {
  FitThermal thermal;
  thermal.errors = {"TZS"};
  for (std::size_t s = 0; s < sensors; ++s) thermal.sensors.push_back("T" + std::to_string(s + 1));
  thermal.selection = selection;
  thermal.model = model;
  return thermal;
}

TEST(ThermalFit, FindsSlopesAndLags) {
  Log log(3, 361, 360, {8, 9, 60});
  log.set_error(2.5 * log.lagged(0, 1500) - 1.2 * log.lagged(2, 0), 0.1, 4);
  const ThermalFit fit = fit_thermal(asked(3), {log.course});
  ASSERT_EQ(fit.models.size(), 1U);
  const ThermalModel& model = fit.models.front();
  EXPECT_FALSE(model.misfit) << model.left << " " << model.noise;
  EXPECT_NEAR(model.noise, 0.1, 0.02);
  EXPECT_NEAR(model.left, 0.1, 0.02);
  // Whatever sensors of a group were taken: the drift is met where it was not fitted.
  Log other(99, 301, 400, {8, 9, 60}, true);
  other.set_error(2.5 * other.lagged(0, 1500) - 1.2 * other.lagged(2, 0), 0.1, 5);
  const ThermalFit judged = fit_thermal(asked(3), {log.course, other.course});
  ASSERT_TRUE(judged.models.front().validated);
  EXPECT_LT(*judged.models.front().validated, 0.15);
  EXPECT_GT(*judged.models.front().validated_before, 2);
}

TEST(ThermalFit, LagOfOneSensorIsFound) {
  Log log(7, 241, 240, {5});
  log.set_error(3 * log.lagged(0, 1800), 0.05, 8);
  const ThermalModel model = fit_thermal(asked(1), {log.course}).models.front();
  ASSERT_EQ(model.terms.size(), 1U);
  EXPECT_NEAR(model.terms[0].lag, 1800, 30);
  EXPECT_NEAR(model.terms[0].slope, 3, 0.05);
  EXPECT_EQ(variable_of(model.terms[0]), "T1_lag" + std::to_string(static_cast<int>(model.terms[0].lag)));
  EXPECT_LT(model.terms[0].lo, 21);
  EXPECT_GT(model.terms[0].hi, 22);
}

TEST(ThermalFit, MisspecifiedModelIsFlagged) {
  Log log(7, 241, 240, {5});
  log.set_error(3 * log.lagged(0, 1800), 0.05, 8);
  const auto linear = asked(1, FitThermal::Selection::all, FitThermal::Model::linear);
  const ThermalModel wrong = fit_thermal(linear, {log.course}).models.front();
  EXPECT_TRUE(wrong.misfit);
  EXPECT_GT(wrong.u, 0.5);  // and not believed
  // A drift that no sensor knows of.
  log.set_error(log.lagged(0, 1800), 0.05, 8);
  for (Eigen::Index i = 0; i < log.course.errors.rows(); ++i)
    log.course.errors(i, 0) = 5 * std::sin(0.15 * static_cast<double>(i));
  EXPECT_TRUE(fit_thermal(asked(1), {log.course}).models.front().misfit);
}

TEST(ThermalFit, NeverUsesValidationLogs) {
  Log log(1, 121, 240, {5, 50}), other(2, 121, 240, {5, 50}, true);
  log.set_error(2 * log.lagged(0, 0), 0.05, 3);
  other.set_error(-9 * other.lagged(1, 0), 0.05, 4);
  const ThermalModel alone = fit_thermal(asked(2), {log.course}).models.front();
  const ThermalModel judged = fit_thermal(asked(2), {log.course, other.course}).models.front();
  ASSERT_EQ(alone.terms.size(), judged.terms.size());
  EXPECT_EQ(alone.terms[0].slope, judged.terms[0].slope);
  EXPECT_GT(*judged.validated, 5);
  EXPECT_GT(judged.u, alone.u + 5);
}

TEST(ThermalFit, IntervalsCoverTheTruth) {
  int covered = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    Log log(seed % 10 + 1, 60, 240, {5, 45});
    log.set_error(2 * log.lagged(0, 0) - 3 * log.lagged(1, 0), 0.3, seed);
    const ThermalModel model =
        fit_thermal(asked(2, FitThermal::Selection::all, FitThermal::Model::linear), {log.course})
            .models.front();
    const double truth[] = {2, -3};
    for (std::size_t i = 0; i < 2; ++i, ++all)
      covered += std::abs(model.terms[i].slope - truth[i]) < 2.002 * model.terms[i].u;  // Student, 57 degrees
  }
  const double share = static_cast<double>(covered) / all;
  EXPECT_GT(share, 0.94);
  EXPECT_LT(share, 0.96);
}

TEST(ThermalFit, IntervalsOfLagsCoverTheTruth) {
  int covered = 0;
  constexpr int kTrials = 60;
  for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
    Log log(seed % 5 + 1, 121, 240, {5});
    log.set_error(3 * log.lagged(0, 1200), 0.3, seed);
    const ThermalModel model =
        fit_thermal(asked(1, FitThermal::Selection::all, FitThermal::Model::lag), {log.course})
            .models.front();
    covered += std::abs(model.terms[0].slope - 3) < 1.98 * model.terms[0].u;
  }
  EXPECT_GE(covered, 52);  // 57 expected, 3 standard deviations
}

/// What a log tells of 3 um/K at 30 min, begun cold or an hour later.
struct WarmStart {
  Log log;
  std::size_t row = 60;
  FitThermal wanted = asked(1, FitThermal::Selection::all, FitThermal::Model::lag);
  explicit WarmStart(std::uint64_t seed) : log(seed % 5 + 1, 361, 360, {5}) {
    log.set_error(3 * log.lagged(0, 1800), 0.3, seed);
  }
  [[nodiscard]] ThermalModel warm(bool settled) const {
    DriftCourse course = log.from_row(row);
    course.settled = settled;
    return fit_thermal(wanted, {course}).models.front();
  }
};

TEST(ThermalFit, WarmStartsGiveTheSlopesOfColdOnes) {
  const WarmStart machine(2);
  const ThermalTerm cold = fit_thermal(machine.wanted, {machine.log.course}).models.front().terms.front();
  const ThermalModel warm = machine.warm(false);
  EXPECT_FALSE(warm.misfit);
  ASSERT_EQ(warm.terms.size(), 1U);
  EXPECT_LT(std::abs(warm.terms[0].slope - cold.slope), 3 * std::hypot(warm.terms[0].u, cold.u));
  EXPECT_LT(warm.terms[0].u, 0.15);
  // Taken for settled, the same log tells another slope.
  const ThermalModel believed = machine.warm(true);
  EXPECT_GT(std::abs(believed.terms[0].slope - cold.slope), 3 * std::hypot(believed.terms[0].u, cold.u));
  EXPECT_TRUE(believed.starts.empty());
}

TEST(ThermalFit, StartsOfLogsAreFound) {
  const WarmStart machine(2);
  const ThermalModel warm = machine.warm(false);
  ASSERT_EQ(warm.starts.size(), 1U);
  const auto first = static_cast<Eigen::Index>(machine.row);
  const double remembered =
      3 * (machine.log.lagged(0, 1800)[first] - machine.log.lagged(0, 0)[first]);  // beside equilibrium
  EXPECT_GT(std::abs(remembered), 3);
  EXPECT_NEAR(warm.starts[0].value, remembered, 3 * warm.starts[0].u);
  EXPECT_LT(warm.starts[0].u, 1);
  EXPECT_EQ(warm.starts[0].lag, warm.terms[0].lag);
}

TEST(ThermalFit, IntervalsOfWarmLogsCoverTheTruth) {
  int slopes = 0, starts = 0;
  constexpr int kTrials = 60;
  for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
    const WarmStart machine(seed);
    const ThermalModel warm = machine.warm(false);
    const auto first = static_cast<Eigen::Index>(machine.row);
    const double remembered = 3 * (machine.log.lagged(0, 1800)[first] - machine.log.lagged(0, 0)[first]);
    slopes += std::abs(warm.terms[0].slope - 3) < 1.98 * warm.terms[0].u;
    starts += std::abs(warm.starts[0].value - remembered) < 1.98 * warm.starts[0].u;
  }
  EXPECT_GE(slopes, 52);  // 57 expected, 3 standard deviations
  EXPECT_GE(starts, 52);
}

TEST(ThermalFit, JudgingLogsMayBeginWarm) {
  const WarmStart machine(2), other(3);
  DriftCourse judge = other.log.from_row(60);
  judge.validation = true;
  const auto validated = [&] {
    return fit_thermal(machine.wanted, {machine.log.course, judge}).models.front().validated.value_or(99);
  };
  EXPECT_LT(validated(), 0.4);
  judge.settled = true;
  EXPECT_GT(validated(), 0.6);
}

TEST(ThermalFit, SlopesOfSharedReadingsAreUncertainTogether) {
  Log log(3, 121, 240, {5, 45});
  log.set_error(2 * log.lagged(0, 0) - 3 * log.lagged(1, 0), 0.3, 9);
  FitThermal thermal = asked(2, FitThermal::Selection::all, FitThermal::Model::linear);
  thermal.errors = {"TZS", "TAS"};
  // What disturbs one reading disturbs both errors: the tilt by half of it, the other way.
  const Eigen::VectorXd noise = log.course.errors.col(0) - (2 * log.lagged(0, 0) - 3 * log.lagged(1, 0));
  log.course.errors.conservativeResize(Eigen::NoChange, 2);
  log.course.errors.col(1) = log.lagged(1, 0) - noise / 2;
  const ThermalFit fit = fit_thermal(thermal, {log.course});
  ASSERT_EQ(fit.covariance.rows(), 4);
  const Eigen::Matrix2d own = fit.covariance.topLeftCorner<2, 2>();
  EXPECT_TRUE(fit.covariance.topRightCorner(2, 2).isApprox(-own / 2, 1e-9));
  EXPECT_TRUE(fit.covariance.bottomRightCorner(2, 2).isApprox(own / 4, 1e-9));
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(fit.models[0].terms[i].u,
                std::sqrt(own(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))), 1e-12);
  EXPECT_LT(fit.models[0].beyond_slopes, fit.models[0].u);
}

TEST(ThermalFit, StepsThatStartsExplainAreNamed) {
  // The temperature steps between the first rows and stays: lagged, it is a constant and a start.
  constexpr int kRows = 2000;
  constexpr double kStep = 10, kLag = 3000;
  DriftCourse course;
  course.temperatures.emplace_back(kRows, 30.0);
  course.temperatures[0][0] = 20;
  course.errors.resize(kRows, 1);
  for (int i = 0; i < kRows; ++i) {
    course.times.push_back(kStep * i);
    course.errors(i, 0) = 25 * std::exp(-kStep * i / kLag);
  }
  const FitThermal wanted = asked(1, FitThermal::Selection::all, FitThermal::Model::lag);
  const ThermalModel model = fit_thermal(wanted, {course}).models.front();
  EXPECT_TRUE(model.terms.empty());
  EXPECT_EQ(model.undetermined, std::vector<std::string>{"T1"});
  // If it began in equilibrium, the same readings tell -2.5 um/K.
  course.settled = true;
  const ThermalModel settled = fit_thermal(wanted, {course}).models.front();
  ASSERT_EQ(settled.terms.size(), 1U);
  EXPECT_NEAR(settled.terms[0].slope, -2.5, 0.01);
  EXPECT_NEAR(settled.terms[0].lag, kLag, 0.01 * kLag);
}

TEST(ThermalFit, RidgeMeetsCollinearSensors) {
  Log log(5, 121, 240, {10, 10.5, 11}), other(6, 121, 240, {10, 10.5, 11}, true);
  log.set_error(2 * log.lagged(1, 0), 0.3, 1);
  other.set_error(2 * other.lagged(1, 0), 0.3, 2);
  FitThermal thermal = asked(3, FitThermal::Selection::ridge, FitThermal::Model::linear);
  thermal.correlated = 1;  // all of them
  const ThermalFit fit = fit_thermal(thermal, {log.course, other.course});
  EXPECT_EQ(fit.models.front().terms.size(), 3U);
  EXPECT_LT(*fit.models.front().validated, 0.35);
}

TEST(ThermalFit, StillSensorsAndRangesAreNamed) {
  Log log(5, 121, 240, {10, 30}), other(6, 121, 240, {10, 30}, true);
  std::fill(log.course.temperatures[1].begin(), log.course.temperatures[1].end(), 21.0);
  for (double& T : other.course.temperatures[0]) T += 30;
  log.set_error(2 * log.lagged(0, 0), 0.1, 1);
  other.set_error(2 * other.lagged(0, 0), 0.1, 2);
  const ThermalFit fit = fit_thermal(asked(2), {log.course, other.course});
  EXPECT_EQ(fit.still, std::vector<std::string>{"T2"});
  EXPECT_FALSE(fit.outside.empty());
  EXPECT_EQ(fit.groups.size(), 1U);
}

TEST(SensorGroups, GroupsAreTheConnectedOnes) {
  // a ~ b ~ c by angles of 10 degrees, d across: a and c are joined by b.
  Eigen::MatrixXd columns(3, 5);
  const auto at = [](double degrees) {
    return Eigen::Vector3d(std::cos(degrees / 57.29578), std::sin(degrees / 57.29578), 0);
  };
  columns << at(0), at(10), at(20), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d::Zero();
  const auto groups = sensor_groups(columns, 0.98);
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0], (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_EQ(groups[1], (std::vector<std::size_t>{3}));
}

}  // namespace
}  // namespace abbe
