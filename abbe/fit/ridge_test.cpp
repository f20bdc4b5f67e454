#include "abbe/fit/ridge.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

namespace abbe {
namespace {

/// J. W. Longley, JASA 62 (1967): deflator, product, unemployed, armed forces, population, year; employed.
struct Longley {
  Eigen::MatrixXd columns = Eigen::MatrixXd(16, 6);
  Eigen::VectorXd employed = Eigen::VectorXd(16);
  Longley() {
    columns << 83, 234289, 2356, 1590, 107608, 1947, 88.5, 259426, 2325, 1456, 108632, 1948, 88.2, 258054,
        3682, 1616, 109773, 1949, 89.5, 284599, 3351, 1650, 110929, 1950, 96.2, 328975, 2099, 3099, 112075,
        1951, 98.1, 346999, 1932, 3594, 113270, 1952, 99, 365385, 1870, 3547, 115094, 1953, 100, 363112, 3578,
        3350, 116219, 1954, 101.2, 397469, 2904, 3048, 117388, 1955, 104.6, 419180, 2822, 2857, 118734, 1956,
        108.4, 442769, 2936, 2798, 120445, 1957, 110.8, 444546, 4681, 2637, 121950, 1958, 112.6, 482704, 3813,
        2552, 123366, 1959, 114.2, 502601, 3931, 2514, 125368, 1960, 115.7, 518173, 4806, 2572, 127852, 1961,
        116.9, 554894, 4007, 2827, 130081, 1962;
    employed << 60323, 61122, 60171, 61187, 63221, 63639, 64989, 63761, 66019, 67857, 68169, 66513, 68655,
        69564, 69331, 70551;
  }
};

TEST(Ridge, LongleyAtPublishedPenalties) {
  const Longley data;
  // Computed apart, with the normal equations in extended precision.
  const double weak[] = {-2.499935556, -0.001868237, -1.504266508, -0.872842222, -0.148943651, 1227.02083201};
  const double strong[] = {85.746858444, 0.011281152, -0.821936946, -0.291795575, 0.117218872, 230.438924839};
  const Ridge a = fit_ridge(data.columns, data.employed, 0.01), b = fit_ridge(data.columns, data.employed, 1);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_NEAR(a.slope[i], weak[i], 1e-7);
    EXPECT_NEAR(b.slope[i], strong[i], 1e-7);
  }
  EXPECT_NEAR(a.intercept, -2307348.3279, 1e-3);
  EXPECT_NEAR(b.intercept, -408547.3987, 1e-3);
}

TEST(Ridge, NoPenaltyIsLeastSquares) {
  const Longley data;
  Eigen::MatrixXd with_one(16, 7);
  with_one << data.columns, Eigen::VectorXd::Ones(16);
  const Eigen::VectorXd expected = with_one.colPivHouseholderQr().solve(data.employed);
  const Ridge found = fit_ridge(data.columns, data.employed, 0);
  for (Eigen::Index i = 0; i < 6; ++i) EXPECT_NEAR(found.slope[i] / expected[i], 1, 1e-6);
}

TEST(Ridge, ColumnThatDoesNotChangeGetsNothing) {
  Eigen::MatrixXd columns(4, 2);
  columns << 1, 5, 2, 5, 3, 5, 4, 5;
  const Ridge found = fit_ridge(columns, Eigen::Vector4d(2, 4, 6, 8), 0);
  EXPECT_NEAR(found.slope[0], 2, 1e-12);
  EXPECT_EQ(found.slope[1], 0);
  EXPECT_NEAR(fit_ridge(Eigen::MatrixXd(4, 0), Eigen::Vector4d(2, 4, 6, 8), 0).intercept, 5, 1e-12);
}

}  // namespace
}  // namespace abbe
