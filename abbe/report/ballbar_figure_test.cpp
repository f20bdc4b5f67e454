#include "abbe/report/ballbar_figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "abbe/core/units.h"
#include "abbe/report/test_svg.h"

namespace abbe {
namespace {

BallbarTest some_test() {
  BallbarTest test;
  test.file = "mill <7>.csv";
  test.radius = 100;
  test.feed = 20;
  for (const int s : {+1, -1}) {
    BallbarRun run;
    run.direction = s;
    for (int i = 0; i <= 180; ++i) {
      run.angle.push_back(s * 2 * i * deg);
      run.deviation.push_back(5 * um * std::cos(4 * i * deg));
    }
    test.runs.push_back(run);
  }
  return test;
}

TEST(BallbarFigure, WellFormed) {
  const BallbarTest test = some_test();
  const std::string svg = figure_of_ballbar(test, circular_figures(test), diagnose(test));
  EXPECT_TRUE(test::well_formed(svg));
  EXPECT_THAT(svg, ::testing::HasSubstr("Circular test XY, R 100 mm, 1200 mm/min"));
  EXPECT_THAT(svg, ::testing::HasSubstr("scale mismatch"));
  EXPECT_EQ(svg, figure_of_ballbar(test, circular_figures(test), diagnose(test)));
}

TEST(BallbarFigure, NothingToShowIsShown) {
  BallbarTest test = some_test();
  test.runs.clear();
  EXPECT_TRUE(test::well_formed(figure_of_ballbar(test, {}, {})));
}

TEST(BallbarFigure, TermsForPeople) {
  DiagnosisTerm term{DiagnosisTerm::Kind::squareness, "", -20.1234e-6, 0.05e-6, 0, true};
  EXPECT_EQ(text_of(term).value, "-20.12");
  EXPECT_EQ(text_of(term).uncertainty, "0.050");
  EXPECT_EQ(text_of(term).unit, "urad");
}

}  // namespace
}  // namespace abbe
