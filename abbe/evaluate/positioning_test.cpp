#include "abbe/evaluate/positioning.h"

#include <gtest/gtest.h>

#include "abbe/evaluate/positioning_uncertainty.h"
#include "abbe/evaluate/test_runs.h"

namespace abbe {
namespace {

constexpr double kPrinted = 0.00051;    // um: three decimals are published
constexpr double kPrinted4 = 0.000051;  // four

void expect_um(double value, double micrometres, double tolerance = kPrinted) {
  EXPECT_NEAR(value / um, micrometres, tolerance);
}

TEST(Positioning, WorkedExampleOne) {
  const PositioningFigures figures = positioning_figures(test::slit_axis());
  const double forward[] = {2.250, 0.394, 2.084, -9.020, 6.032},
               backward[] = {4.202, -4.170, -0.854, -7.884, 6.968};
  const double mean[] = {3.226, -1.888, 0.615, -8.452, 6.500},
               reversal[] = {-1.952, 4.564, 2.938, -1.136, -0.936};
  const double s_up[] = {0.6694, 0.4644, 1.8756, 0.9840, 0.5227},
               s_down[] = {0.9706, 0.3912, 0.8324, 0.5377, 0.3076};
  const double R[] = {5.2321, 6.2753, 8.3539, 4.1794, 2.5965};
  for (std::size_t i = 0; i < 5; ++i) {
    const PositioningTarget& target = figures.targets[i];
    expect_um(target.mean_forward, forward[i]);
    expect_um(target.mean_backward, backward[i]);
    expect_um(target.mean, mean[i]);
    expect_um(target.reversal, reversal[i]);
    expect_um(target.s_forward, s_up[i], kPrinted4);
    expect_um(target.s_backward, s_down[i], kPrinted4);
    expect_um(target.repeatability, R[i], kPrinted4);
  }
  expect_um(figures.B, 4.564);
  expect_um(figures.mean_reversal, 0.6956, kPrinted4);
  expect_um(figures.R.forward, 7.5024, kPrinted4);
  expect_um(figures.R.backward, 3.8825, kPrinted4);
  expect_um(figures.R.both, 8.3539, kPrinted4);
  expect_um(figures.E.forward, 15.052);
  expect_um(figures.E.backward, 14.852);
  expect_um(figures.E.both, 15.988);
  expect_um(figures.M, 14.952);
  expect_um(figures.A.forward, 18.0654, kPrinted4);
  expect_um(figures.A.backward, 16.5425, kPrinted4);
  expect_um(figures.A.both, 18.5713, kPrinted4);
}

TEST(Positioning, WorkedExampleTwo) {
  // Means and figures of the second published set of the same project, rebuilt from its means: one run each.
  RunTable table;
  table.targets = {15, 25, 35, 45, 55};
  table.forward = Eigen::VectorXd{{5.5228, -1.9870, -7.4172, -1.2670, 4.2309}} * um;
  table.backward = Eigen::VectorXd{{2.3423, -0.5598, -2.9318, -1.8378, 3.9047}} * um;
  const PositioningFigures figures = positioning_figures(table);
  const double kMeans = 0.00021;  // um: differences of means given with four decimals
  expect_um(figures.B, 4.4854, kMeans);
  expect_um(figures.mean_reversal, -0.3670, kMeans);
  expect_um(figures.E.forward, 12.940, kPrinted);
  expect_um(figures.E.both, 12.940, kPrinted);
  expect_um(figures.E.backward, 6.8365, kMeans);
  expect_um(figures.M, 9.2423, kMeans);
  EXPECT_FALSE(figures.has_spread());
}

TEST(Positioning, DirectionsSwapWithTheSignOfReversal) {
  RunTable table = test::slit_axis();
  const PositioningFigures figures = positioning_figures(table);
  std::swap(table.forward, table.backward);
  const PositioningFigures swapped = positioning_figures(table);
  EXPECT_DOUBLE_EQ(swapped.mean_reversal, -figures.mean_reversal);
  EXPECT_DOUBLE_EQ(swapped.A.forward, figures.A.backward);
  EXPECT_DOUBLE_EQ(swapped.A.both, figures.A.both);
}

TEST(Positioning, ConstantsDoNotCount) {
  RunTable table = test::slit_axis();
  const PositioningFigures figures = positioning_figures(table);
  table.forward.array() += 0.5;
  table.backward.array() += 0.5;
  const PositioningFigures moved = positioning_figures(table);
  EXPECT_NEAR(moved.A.both, figures.A.both, 1e-12);
  EXPECT_NEAR(moved.R.both, figures.R.both, 1e-12);
  EXPECT_NEAR(moved.B, figures.B, 1e-12);
}

TEST(Positioning, OneDirectionAlone) {
  RunTable table = test::slit_axis();
  table.backward.resize(5, 0);
  const PositioningFigures figures = positioning_figures(table);
  EXPECT_FALSE(figures.bidirectional());
  EXPECT_TRUE(figures.has_spread());
  expect_um(figures.E.both, 15.052);
  expect_um(figures.R.both, 7.5024, kPrinted4);
  EXPECT_EQ(figures.B, 0);
}

TEST(PositioningUncertainty, MisalignmentIsThatOfTheRuleOfThumb) {
  // 1 mm over 500 mm: 2 u = 0.28868 R^2 / L = 0.577 um.
  RunTable table;
  table.targets = {0, 500};
  table.forward = Eigen::MatrixXd::Zero(2, 1);
  PositioningSetup setup;
  setup.misalignment = 1;
  const auto budget = positioning_budget(setup, positioning_figures(table));
  const auto combined = combine(budget);
  ASSERT_TRUE(combined);
  EXPECT_NEAR(2 * combined->u / um, 0.57735, 1e-5);
}

TEST(PositioningUncertainty, AxisWentFurtherThanAMisalignedBeamShows) {
  // 1 mm over 500 mm: the beam shows up to R^2 / (2 L) = 1 um too little, on average 0.5 um.
  RunTable table;
  table.targets = {0, 500};
  table.forward = (Eigen::MatrixXd(2, 2) << 0, 0, 5e-3, 5e-3).finished();
  PositioningSetup setup;
  setup.misalignment = 1;
  const auto drawn = positioning_uncertainty(table, setup, 4000, 1);
  ASSERT_TRUE(drawn);
  EXPECT_NEAR(drawn->E.mean / um, 5.5, 0.03);
}

TEST(PositioningUncertainty, ExactSetUpLeavesTheScatterOfMeans) {
  RunTable table = test::slit_axis();
  const auto drawn = positioning_uncertainty(table, {}, 4000, 1);
  ASSERT_TRUE(drawn);
  // E spans 6.968 - (-9.020): the means of two targets, s / sqrt(5) of Student with 4 degrees of freedom
  // each.
  const double expected = std::hypot(0.9840, 0.3076) / std::sqrt(5.0) * std::sqrt(4.0 / 2.0);
  EXPECT_NEAR(drawn->E.u / um, expected, 0.12 * expected);
  EXPECT_LT(drawn->E.symmetric[0], 15.988 * um);
  EXPECT_GT(drawn->E.symmetric[1], 15.988 * um);
  PositioningSetup setup;
  setup.instrument_relative = 1e-4;  // 1.02 um between the two targets
  const double both = std::hypot(drawn->E.u, 1e-4 * (55.8 - 45.6));
  EXPECT_NEAR(positioning_uncertainty(table, setup, 4000, 1)->E.u, both, 0.1 * both);
}

}  // namespace
}  // namespace abbe
