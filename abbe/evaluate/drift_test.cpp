#include "abbe/evaluate/drift.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "abbe/core/units.h"
#include "abbe/evaluate/diagonal_figures.h"

namespace abbe {
namespace {

MeasuredTable table_of(const char* text) {
  Parsed<MeasuredTable> parsed = read_measured_table("drift.csv", text);
  EXPECT_TRUE(parsed.value) << (parsed.diagnostics.empty() ? "" : parsed.diagnostics[0].message);
  return parsed.value.value_or(MeasuredTable{});
}

constexpr const char* kLog =
    "time [min], Y1 [um], Y2 [um], T1 [degC]\n"
    "0, 0, 0, 20\n30, 3, 1, 21\n60, 5, 2, 22\n90, 10, 3, 23\n120, 11, 3, 24\n";

TEST(Drift, RangesOfARamp) {
  const auto figures = drift_figures(table_of(kLog));
  ASSERT_TRUE(figures.value);
  EXPECT_EQ(figures.value->duration, 7200);
  ASSERT_EQ(figures.value->sensors.size(), 3U);
  const SensorDrift& y1 = figures.value->sensors[0];
  EXPECT_NEAR(y1.range / um, 11, 1e-12);
  EXPECT_NEAR(y1.range_first_hour / um, 5, 1e-12);
  EXPECT_NEAR(y1.most_in_an_hour / um, 7, 1e-12);  // 30 to 90 min
  EXPECT_NEAR(y1.change / um, 11, 1e-12);
  EXPECT_NEAR(figures.value->sensors[2].range, 4, 1e-12);  // degC
}

TEST(Drift, TiltOfParallelSensors) {
  const auto figures = drift_figures(table_of(kLog), 100);
  ASSERT_TRUE(figures.value);
  ASSERT_EQ(figures.value->sensors.size(), 4U);
  const SensorDrift& tilt = figures.value->sensors[3];
  EXPECT_EQ(tilt.name, "A");
  EXPECT_NEAR(tilt.change / urad, 80, 1e-9);  // (11 - 3) um / 100 mm
}

TEST(Drift, RefusesLogsWithoutTime) {
  EXPECT_FALSE(drift_figures(table_of("X [um], T1 [degC]\n1, 2\n")).value);
  EXPECT_EQ(drift_figures(table_of("time [s], X [um]\n1, 2\n1, 3\n")).diagnostics[0].code, "E-DRIFT-TIME");
  EXPECT_EQ(drift_figures(table_of("time [s], run\n1, 2\n2, 3\n")).diagnostics[0].code, "E-DRIFT-SENSOR");
}

// 500 x 400 mm, 20 urad: -+6.24695 um (first order).
TEST(Diagonals, SquarenessOfAFace) {
  EXPECT_NEAR(squareness_of_face(500, 400, -6.24695 * um, 6.24695 * um) / urad, 20, 1e-4);
  EXPECT_NEAR(squareness_of_face(500, 400, 3 * um, 3 * um), 0, 1e-15);
}

// The end of a diagonal along s moves by E x (s's part along the turned axis); the diagonal becomes longer by
// what of it is along s.
TEST(Diagonals, FacesHaveTheSignsOfTheLocationErrors) {
  const double angle = 20 * urad;
  const auto face = [&](const Vec3& turn, const Vec3& turned, const Vec3& other) {
    const auto longer = [&](const Vec3& s) { return turn.cross(s.dot(turned) * turned).dot(s.normalized()); };
    const Vec3 a = 500 * other, b = 400 * turned;
    return squareness_of_face(500, 400, longer(a + b), longer(b - a));
  };
  const Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(), z = Vec3::UnitZ();
  EXPECT_NEAR(face(angle * z, y, x), angle, 1e-15);   // EC0Y of XY
  EXPECT_NEAR(face(angle * x, z, y), angle, 1e-15);   // EA0Z of YZ
  EXPECT_NEAR(face(angle * y, z, x), -angle, 1e-15);  // EB0Z of ZX
}

// 500 x 400 x 300 mm with C0Y 20, B0Z -15, A0Z 10 urad.
TEST(Diagonals, SquarenessOfABox) {
  const BodyDiagonals found =
      squareness_of_box({500, 400, 300}, {-10.5359 * um, 7.1418 * um, 4.1719 * um, -0.7778 * um});
  EXPECT_NEAR(found.C0Y / urad, 20, 1e-3);
  EXPECT_NEAR(found.B0Z / urad, -15, 1e-3);
  EXPECT_NEAR(found.A0Z / urad, 10, 1e-3);
  EXPECT_NEAR(found.mean_longer / um, 0, 1e-3);
}

}  // namespace
}  // namespace abbe
