#include "abbe/report/volume_figure.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/report/colour_scale.h"
#include "abbe/report/test_svg.h"
#include "abbe/volume/test_volume.h"

namespace abbe {
namespace {

using test::column_machine;
using test::count_of;
using test::plan_of;
using test::question_of;
using test::well_formed;

std::string figure(const Machine& machine, const VolumeQuestion& question) {
  return figure_of_volume(machine, question, map_volume(plan_of(machine), question));
}

TEST(VolumeFigure, WellFormedForAnyGrid) {
  Machine machine = column_machine("EC0Y = 20\nEXX = { poly = [0, 0.01] }\nEAZ = 3");
  machine.name = "<\"mill\" & \x01 co>";
  using Counts = std::array<std::size_t, 3>;
  for (const Counts& counts : {Counts{1, 1, 1}, Counts{3, 1, 1}, Counts{1, 2, 5}, Counts{1, 1, 200},
                               Counts{4, 3, 2}, Counts{2, 100, 2}}) {
    VolumeQuestion question = question_of(machine, 2);
    for (std::size_t i = 0; i < 3; ++i) question.grid.positions[i] = *spaced(0, 300, counts[i]);
    question.datum = default_datum(question.grid);
    const std::string text = figure(machine, question);
    EXPECT_TRUE(well_formed(text)) << counts[0] << ' ' << counts[1] << ' ' << counts[2];
    EXPECT_EQ(text, figure(machine, question));
  }
  const Machine perfect = column_machine("EXX = 0");
  EXPECT_TRUE(well_formed(figure(perfect, question_of(perfect, 3))));
}

TEST(VolumeFigure, SlicesGoThroughTheWorstPoint) {
  const Machine machine = column_machine("EXX = { poly = [0, 0.01] }\nEYY = { poly = [4, -0.01] }");
  const std::string text = figure(machine, question_of(machine, 5));
  // Largest at X 500 (5 um), Y 0 (4 um), any Z: the first.
  EXPECT_NE(text.find(">XY, at Z 0<"), std::string::npos);
  EXPECT_NE(text.find(">XZ, at Y 0<"), std::string::npos);
  EXPECT_NE(text.find(">YZ, at X 500<"), std::string::npos);
  EXPECT_EQ(count_of(text, "<circle cx=\"360\" cy=\"368\" r=\"7\""), 2U);  // XY: right, below
}

TEST(VolumeFigure, ShadesFollowTheDeviation) {
  // Along X only: in the XY slice every column has one colour, darker to the right.
  const Machine machine = column_machine("EXX = { poly = [0, 0.01] }");
  VolumeQuestion question = question_of(machine, 2);
  question.grid.positions[0] = {0, 250, 500};
  const std::string text = figure(machine, question);
  EXPECT_NE(
      text.find("<rect x=\"84\" y=\"118\" width=\"69.4\" height=\"125.4\" fill=\"" + colour_of_shade(0)),
      std::string::npos);
  EXPECT_NE(text.find("<rect x=\"291\" y=\"118\" width=\"69\" height=\"125.4\" fill=\"" +
                      colour_of_shade(kShades - 1)),
            std::string::npos);
  // Strokes go to +x, never up or down.
  EXPECT_NE(text.find("M84,368L84,368"), std::string::npos);
}

TEST(ColourScale, GrowsDarker) {
  const auto light = [](const std::string& colour) {
    int sum = 0;
    for (const std::size_t at : {1U, 3U, 5U}) sum += std::stoi(colour.substr(at, 2), nullptr, 16);
    return sum;
  };
  for (int shade = 1; shade < kShades; ++shade)
    EXPECT_LT(light(colour_of_shade(shade)), light(colour_of_shade(shade - 1))) << shade;
  EXPECT_EQ(shade_of(0, 8), 0);
  EXPECT_EQ(shade_of(4, 8), kShades / 2);
  EXPECT_EQ(shade_of(8, 8), kShades - 1);
  EXPECT_EQ(colour_of(-1), colour_of(0));
}

}  // namespace
}  // namespace abbe
