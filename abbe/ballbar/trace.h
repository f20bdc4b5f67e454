#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/linear_algebra.h"

namespace abbe {

/// The plane of a circular test as two of the axes X Y Z (0 1 2). Angles count from the positive first
/// axis towards the positive second one: XY and YX are the same plane seen from its two sides.
struct TestPlane {
  int first = 0, second = 1;
  friend bool operator==(const TestPlane&, const TestPlane&) = default;
};

/// "XY", "zx": two different letters of X Y Z; nullopt otherwise.
[[nodiscard]] std::optional<TestPlane> read_plane(std::string_view text);
[[nodiscard]] std::string to_string(TestPlane plane);
[[nodiscard]] char axis_letter(int axis);

/// u(theta) = cos theta e_first + sin theta e_second: from the centre of the circle to the tool ball.
[[nodiscard]] Vec3 radial_direction(TestPlane plane, double angle);

/// One arc in one direction of contouring. All vectors are empty or as long as `angle`.
struct BallbarRun {
  int direction = +1;             ///< +1 counter-clockwise (the angle grows), -1 clockwise
  std::vector<double> angle;      ///< rad, without jumps along the run
  std::vector<double> deviation;  ///< mm: measured distance of the balls - nominal radius, + outwards
  std::vector<double> time;       ///< s; empty if the file does not say
  std::vector<Vec3> actual;       ///< X Y Z of the control (CiA 402: 6064), mm; empty if not recorded
  std::vector<Vec3> commanded;    ///< the same of the interpolator (607A)
};

/// A circular test with a ball bar: one plane, radius and feed, any number of runs in one set-up.
struct BallbarTest {
  std::string file;  ///< name for messages
  TestPlane plane;
  double radius = 0;            ///< nominal length of the bar, mm
  double feed = 0;              ///< along the path, mm/s
  Vec3 centre = Vec3::Zero();   ///< axis positions X Y Z where the tool ball meets the workpiece ball, mm
  std::optional<double> noise;  ///< standard deviation of one deviation, mm
  std::string setup;            ///< tests between which the balls were not moved; empty: its own
  std::string machine, instrument, date;
  std::vector<BallbarRun> runs;

  [[nodiscard]] std::size_t samples() const;
};

/// Axis positions X Y Z of sample i: those recorded, else on the nominal circle.
///     q = centre + radius u(theta)
[[nodiscard]] Vec3 position_of(const BallbarTest& test, const BallbarRun& run, std::size_t i);

/// Angle covered by a run, rad >= 0.
[[nodiscard]] double travel_of(const BallbarRun& run);

}  // namespace abbe
