#include "abbe/report/measurement_figure.h"

#include <gtest/gtest.h>

#include "abbe/evaluate/test_runs.h"
#include "abbe/report/test_svg.h"

namespace abbe {
namespace {

TEST(MeasurementFigure, WellFormedForAnyRuns) {
  RunTable table = test::slit_axis();
  const std::string both = figure_of_runs(table, "X <&> axis", {{"E", "15.99 um"}});
  EXPECT_TRUE(test::well_formed(both));
  EXPECT_EQ(test::count_of(both, "<circle"), 50U);
  table.backward.resize(5, 0);
  EXPECT_TRUE(test::well_formed(figure_of_runs(table, "one direction", {})));
  table.forward.setZero();
  EXPECT_TRUE(test::well_formed(figure_of_runs(table, "a perfect axis", {})));
  table.targets = {0, 1e-300};
  table.forward = Eigen::MatrixXd::Constant(2, 1, 1e-200);
  EXPECT_TRUE(test::well_formed(figure_of_runs(table, "tiny", {})));
}

TEST(MeasurementFigure, SameInputSameBytes) {
  const RunTable table = test::slit_axis();
  EXPECT_EQ(figure_of_runs(table, "a", {}), figure_of_runs(table, "a", {}));
}

TEST(MeasurementFigure, DriftHasAScaleForEachQuantity) {
  const auto table = read_measured_table("d.csv", "time [s], X [um], T [degC]\n0,1,20\n60,2,20.5\n");
  ASSERT_TRUE(table.value);
  const std::string figure = figure_of_drift(*table.value, "drift", {});
  EXPECT_TRUE(test::well_formed(figure));
  EXPECT_EQ(test::count_of(figure, "time (min)"), 2U);
}

}  // namespace
}  // namespace abbe
