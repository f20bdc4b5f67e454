#include "abbe/report/part_figure.h"

#include <gtest/gtest.h>

#include <string>

#include "abbe/report/test_svg.h"
#include "abbe/surface/test_surfaces.h"

namespace abbe {
namespace {

Inspection inspected(const NurbsSurface& surface, double first) {
  const NearestPoint nominal(surface);
  std::vector<TouchedPoint> points;
  for (const SurfacePlace& place : cell_places(surface, 10, 10))
    points.push_back({evaluate(surface, place).p, place});
  points[0].measured += first * evaluate(surface, *points[0].target).normal;
  return inspect_points(nominal, points, BestFit::none);
}

TEST(PartFigure, SameInputSameBytes) {
  const NurbsSurface surface = wavy_patch(1);
  EXPECT_EQ(figure_of_inspection(surface, inspected(surface, 0.01)),
            figure_of_inspection(surface, inspected(surface, 0.01)));
}

TEST(PartFigure, SignShowsInColour) {
  const NurbsSurface surface = wavy_patch(1);
  const std::string on = figure_of_inspection(surface, inspected(surface, 0.01));
  const std::string off = figure_of_inspection(surface, inspected(surface, -0.01));
  // The dot of the first point alone: the scale has both colours, in boxes.
  const auto has_dot = [](const std::string& svg, const char* colour) {
    for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1))
      if (svg.substr(at, svg.find('>', at) - at).find(colour) != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(has_dot(on, "#96141c"));
  EXPECT_FALSE(has_dot(on, "#0c3c82"));
  EXPECT_TRUE(has_dot(off, "#0c3c82"));
}

TEST(PartFigure, WellFormedForAnyPoints) {
  NurbsSurface surface = plane_patch(80, 60);
  surface.name = "<&\">";
  EXPECT_TRUE(test::well_formed(figure_of_inspection(surface, inspected(surface, 0))));
  EXPECT_TRUE(test::well_formed(figure_of_inspection(surface, {})));
}

}  // namespace
}  // namespace abbe
