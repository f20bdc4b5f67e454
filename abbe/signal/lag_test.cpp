#include "abbe/signal/lag.h"

#include <gtest/gtest.h>

#include <cmath>

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;

TEST(Lag, StepAnswerIsExponential) {
  // A rise within a microsecond at t = 0, then uneven steps.
  const double tau = 1800;
  std::vector<double> times = {-1, 0}, values = {0, 0};
  for (const double t : {1e-6, 60.0, 100.0, 900.0, 3600.0}) {
    times.push_back(t);
    values.push_back(20);
  }
  const std::vector<double> lagged = first_order_lag(times, values, tau);
  for (std::size_t i = 3; i < times.size(); ++i)
    EXPECT_NEAR(lagged[i], 20 * (1 - std::exp(-times[i] / tau)), 1e-8) << times[i];
  // 20 um, 30 min, after 60 min
  EXPECT_NEAR(lagged.back(), 17.2932943353, 1e-7);
}

TEST(Lag, RampLagsBehindByTau) {
  std::vector<double> times, values;
  for (int i = 0; i < 400; ++i) {
    times.push_back(i * 10.0);
    values.push_back(0.01 * times.back());
  }
  const std::vector<double> lagged = first_order_lag(times, values, 200);
  EXPECT_NEAR(lagged.back(), 0.01 * (times.back() - 200), 1e-6);
}

TEST(Lag, ZeroLagChangesNothing) {
  const std::vector<double> values = {1, 5, -2};
  EXPECT_EQ(first_order_lag({0, 1, 3}, values, 0), values);
  EXPECT_NEAR(first_order_lag({0, 1, 3}, values, 1e-9)[2], -2, 1e-8);
  EXPECT_TRUE(first_order_lag({}, {}, 5).empty());
}

TEST(Lag, StepsMayBeSplit) {
  // Straight between its samples: a sample more on the line changes nothing.
  const double whole = first_order_lag({0, 10}, {3, 9}, 7)[1];
  EXPECT_NEAR(first_order_lag({0, 4, 10}, {3, 5.4, 9}, 7)[2], whole, kRounding);
}

}  // namespace
}  // namespace abbe
