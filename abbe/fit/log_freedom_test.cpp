#include "abbe/fit/log_freedom.h"

#include <gtest/gtest.h>

#include <cmath>

namespace abbe {
namespace {

constexpr double kRounding = 1e-12;

DriftCourse course_of(int rows, double step, bool settled) {
  DriftCourse course;
  course.settled = settled;
  for (int i = 0; i < rows; ++i) course.times.push_back(1000 + step * i);
  return course;
}

/// Two logs below each other: zero, then start exp(-(t - t_0) / lag).
Eigen::VectorXd course(const DriftCourse& a, const DriftCourse& b, const Eigen::Vector4d& zero_and_start,
                       double lag) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(a.times.size() + b.times.size()));
  Eigen::Index row = 0;
  for (const double t : a.times)
    out[row++] = zero_and_start[0] + zero_and_start[1] * std::exp(-(t - 1000) / lag);
  for (const double t : b.times)
    out[row++] = zero_and_start[2] + zero_and_start[3] * std::exp(-(t - 1000) / lag);
  return out;
}

TEST(LogFreedom, StartsAreTakenOff) {
  const DriftCourse a = course_of(40, 60, false), b = course_of(30, 30, false);
  const LogFreedom freedom({&a, &b}, {600, 0, 600, 2400});
  EXPECT_EQ(freedom.lags(), (std::vector<double>{600, 2400}));
  EXPECT_EQ(freedom.rank(), 6);
  const Eigen::VectorXd column = course(a, b, {7, -3, 2, 5}, 600);
  EXPECT_LT(freedom.taken_off(column).norm(), kRounding * column.norm());
  EXPECT_TRUE(freedom.told(column).isZero(0));
  const Eigen::MatrixXd found = freedom.coefficients(1, column);
  EXPECT_NEAR(found(0, 0), 2, 1e-6);
  EXPECT_NEAR(found(1, 0), 5, 1e-6);
  EXPECT_NEAR(found(2, 0), 0, 1e-6);
  // What another lag leaves is there.
  EXPECT_GT(freedom.told(course(a, b, {0, 1, 0, 1}, 100)).norm(), 0.01);
}

TEST(LogFreedom, SettledLogsKeepTheirStart) {
  const DriftCourse a = course_of(40, 60, true), b = course_of(30, 30, false);
  const LogFreedom freedom({&a, &b}, {600});
  EXPECT_FALSE(freedom.is_free(0));
  EXPECT_TRUE(freedom.is_free(1));
  EXPECT_EQ(freedom.rank(), 3);
  const Eigen::VectorXd rest = freedom.taken_off(course(a, b, {7, -3, 2, 5}, 600));
  EXPECT_GT(rest.head(40).norm(), 1);
  EXPECT_LT(rest.tail(30).norm(), kRounding * 100);
  EXPECT_NEAR(rest.head(40).sum(), 0, 1e-10);
}

TEST(LogFreedom, LagsThatSayTheSameCountOnce) {
  const DriftCourse a = course_of(40, 60, false);
  EXPECT_EQ(LogFreedom({&a}, {600, 600 + 1e-6}).rank(), 2);
}

}  // namespace
}  // namespace abbe
