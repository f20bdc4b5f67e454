#include "abbe/ballbar/trace.h"

#include <cmath>

namespace abbe {

std::optional<TestPlane> read_plane(std::string_view text) {
  const auto axis = [](char c) {
    return c >= 'x' && c <= 'z' ? c - 'x' : c >= 'X' && c <= 'Z' ? c - 'X' : -1;
  };
  if (text.size() != 2) return std::nullopt;
  const TestPlane plane{axis(text[0]), axis(text[1])};
  if (plane.first < 0 || plane.second < 0 || plane.first == plane.second) return std::nullopt;
  return plane;
}

char axis_letter(int axis) { return static_cast<char>('X' + axis); }

std::string to_string(TestPlane plane) { return {axis_letter(plane.first), axis_letter(plane.second)}; }

Vec3 radial_direction(TestPlane plane, double angle) {
  Vec3 u = Vec3::Zero();
  u[plane.first] = std::cos(angle);
  u[plane.second] = std::sin(angle);
  return u;
}

std::size_t BallbarTest::samples() const {
  std::size_t count = 0;
  for (const BallbarRun& run : runs) count += run.angle.size();
  return count;
}

Vec3 position_of(const BallbarTest& test, const BallbarRun& run, std::size_t i) {
  if (!run.actual.empty()) return run.actual[i];
  // q = centre + radius u(theta)
  return test.centre + test.radius * radial_direction(test.plane, run.angle[i]);
}

double travel_of(const BallbarRun& run) {
  return run.angle.empty() ? 0.0 : std::abs(run.angle.back() - run.angle.front());
}

}  // namespace abbe
