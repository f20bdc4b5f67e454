#include "abbe/report/gear_figure.h"

#include <gtest/gtest.h>

#include "abbe/report/test_svg.h"

namespace abbe {
namespace {

GearJob job_of() {
  const std::string text =
      "format = 1\n[gear]\nname = \"a < b & c\"\nmodule = 3\nteeth = 20\nface_width = 30\nprofile_shift = "
      "0.2\n"
      "[wheel]\ndiameter = 100\n[evaluation]\nclass = 6\n";
  return *read_gear({"gear.toml", text}).value;
}

GearChart chart_of(const GearJob& job, std::size_t teeth, double size) {
  const WheelInGap wheel = std::get<WheelInGap>(fit_wheel(job.gear, job.wheel, {}));
  WheelDeviations deviations(-20, 20, 5, job.gear.spec.teeth);
  for (std::size_t i = 0; i < deviations.values.size(); ++i)
    deviations.values[i].d = size * Vec3(static_cast<double>(i % 7), static_cast<double>(i % 3), 0);
  const GearInspection inspection = *GearInspection::make(job.gear, wheel, job.evaluation);
  GearChart chart;
  chart.title = job.gear.spec.name;
  chart.remark = "of a test";
  chart.figures = inspection.figures(deviations);
  for (std::size_t k = 0; k < teeth; ++k)
    chart.teeth.push_back({static_cast<int>(3 * k + 1),
                           {inspection.traces(deviations, static_cast<int>(3 * k), Flank::right),
                            inspection.traces(deviations, static_cast<int>(3 * k), Flank::left)}});
  return chart;
}

TEST(GearFigure, WellFormed) {
  const GearJob job = job_of();
  for (const std::size_t teeth : {0U, 1U, 4U, 6U})
    for (const double size : {0.0, 1 * um, 3.0})
      EXPECT_TRUE(test::well_formed(figure_of_gear(job, chart_of(job, teeth, size)))) << teeth << ' ' << size;
}

TEST(GearFigure, SameInputSameBytes) {
  const GearJob job = job_of();
  EXPECT_EQ(figure_of_gear(job, chart_of(job, 4, 1 * um)), figure_of_gear(job, chart_of(job, 4, 1 * um)));
}

TEST(GearFigure, ShowsTracesPitchAndRunout) {
  const GearJob job = job_of();
  const std::string figure = figure_of_gear(job, chart_of(job, 4, 1 * um));
  for (const char* text :
       {"Profile, left flanks", "Helix, right flanks", "Pitch, left flanks", "Runout", "class 6"})
    EXPECT_EQ(test::count_of(figure, text) > 0, true) << text;
}

}  // namespace
}  // namespace abbe
