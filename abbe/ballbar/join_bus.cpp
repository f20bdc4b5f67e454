#include "abbe/ballbar/join_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include "abbe/signal/align.h"
#include "abbe/signal/resample.h"

namespace abbe {
namespace {

// A control commands the circle itself: a point farther off belongs to the way there.
constexpr double kOffCircle = 1e-3;       // of the radius
constexpr double kLeastOffCircle = 0.02;  // mm
constexpr double kHalt = 1e-9;            // rad between two samples

/// Samples [begin, end) on the circle that go one way.
struct Stretch {
  std::size_t begin = 0, end = 0;
  int direction = 0;
};

/// Commanded angle about the centre, without jumps within a stretch.
struct CommandedCircle {
  std::vector<double> angle;
  std::vector<Stretch> stretches;
};

CommandedCircle commanded_circle(const BallbarTest& test, const BusRecord& record) {
  CommandedCircle out;
  const double cx = test.centre[test.plane.first], cy = test.centre[test.plane.second];
  const double off = std::max(kLeastOffCircle, kOffCircle * test.radius);
  Stretch now;
  const auto close = [&](std::size_t end) {
    now.end = end;
    if (now.direction != 0 && now.end - now.begin > 1) out.stretches.push_back(now);
    now = {end, end, 0};
  };
  for (std::size_t i = 0; i < record.time.size(); ++i) {
    const double x = record.commanded[0][i] - cx, y = record.commanded[1][i] - cy;
    double angle = std::atan2(y, x);
    const bool on_circle = std::abs(std::hypot(x, y) - test.radius) <= off;
    if (i > now.begin) {
      // the nearest of all angles that are whole turns apart
      angle = out.angle.back() + std::remainder(angle - out.angle.back(), 2 * M_PI);
      const double step = angle - out.angle.back();
      const int sense = step > kHalt ? +1 : step < -kHalt ? -1 : 0;
      if (!on_circle) {
        close(i);
      } else if (sense == 0 || (now.direction != 0 && sense != now.direction)) {
        close(i);
        now.begin = sense == 0 ? i : i - 1;  // it turns round at the sample before
        now.direction = sense;
      } else {
        now.direction = sense;
      }
    }
    out.angle.push_back(angle);
    if (!on_circle) now = {i + 1, i + 1, 0};
  }
  close(record.time.size());
  return out;
}

std::string in_words(int direction) { return direction > 0 ? "counter-clockwise" : "clockwise"; }

/// The signal at sample numbers (with fractions) of the stretch.
Samples at(std::span<const double> signal, const Samples& index) {
  Samples number(signal.size());
  for (std::size_t i = 0; i < number.size(); ++i) number[i] = static_cast<double>(i);
  auto found = interpolate(number, signal, index, Interpolation::cubic);
  return std::holds_alternative<Samples>(found) ? std::get<Samples>(std::move(found)) : Samples();
}

/// True if the stretch covers the run; fills its positions.
bool join_run(const BallbarTest& test, const BusRecord& record, const CommandedCircle& circle,
              const Stretch& stretch, BallbarRun& run) {
  const std::size_t count = stretch.end - stretch.begin;
  const auto aligned = align_by_angle(std::span(circle.angle).subspan(stretch.begin, count), run.angle);
  const auto* found = std::get_if<AngleAlignment>(&aligned);
  if (found == nullptr) return false;
  std::vector<Vec3>* const to[2] = {&run.commanded, &run.actual};
  const std::vector<double>* const from[2] = {record.commanded, record.actual};
  for (int kind = 0; kind < 2; ++kind) {
    std::vector<Vec3> positions(run.angle.size(), test.centre);
    for (int k = 0; k < 2; ++k) {
      const Samples values = at(std::span(from[kind][k]).subspan(stretch.begin, count), found->index);
      if (values.size() != positions.size()) return false;
      const int axis = k == 0 ? test.plane.first : test.plane.second;
      for (std::size_t i = 0; i < values.size(); ++i) positions[i][axis] = values[i];
    }
    *to[kind] = std::move(positions);
  }
  return true;
}

bool increases(const std::vector<double>& time) {
  return std::adjacent_find(time.begin(), time.end(), std::greater_equal<>()) == time.end();
}

/// Where the samples begin that have another command than the one before.
std::vector<std::size_t> new_commands(const BusRecord& record) {
  std::vector<std::size_t> begins = {0};
  for (std::size_t i = 1; i < record.time.size(); ++i)
    if (record.commanded[0][i] != record.commanded[0][i - 1] ||
        record.commanded[1][i] != record.commanded[1][i - 1])
      begins.push_back(i);
  return begins;
}

/// A control may command less often than the bus reports. Of equal commands in a row the first is kept; the
/// last as well if they are so many that the control stood still.
BusRecord one_for_each_command(const BusRecord& record) {
  const std::vector<std::size_t> begins = new_commands(record);
  const auto end_of = [&](std::size_t g) {
    return g + 1 < begins.size() ? begins[g + 1] : record.time.size();
  };
  std::vector<std::size_t> lengths;
  for (std::size_t g = 0; g < begins.size(); ++g) lengths.push_back(end_of(g) - begins[g]);
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2),
                   lengths.end());
  const std::size_t usual = lengths[lengths.size() / 2];
  if (usual == 1) return record;
  BusRecord kept;
  const auto keep = [&](std::size_t i) {
    kept.time.push_back(record.time[i]);
    for (int k = 0; k < 2; ++k) {
      kept.commanded[k].push_back(record.commanded[k][i]);
      kept.actual[k].push_back(record.actual[k][i]);
    }
  };
  for (std::size_t g = 0; g < begins.size(); ++g) {
    keep(begins[g]);
    if (end_of(g) - begins[g] > 2 * usual) keep(end_of(g) - 1);
  }
  return kept;
}

bool is_usable(const BusRecord& record) {
  const std::size_t n = record.time.size();
  bool usable = n > 1 && all_finite(record.time) && increases(record.time);
  for (int k = 0; k < 2; ++k)
    usable = usable && record.commanded[k].size() == n && record.actual[k].size() == n &&
             all_finite(record.commanded[k]) && all_finite(record.actual[k]);
  return usable;
}

}  // namespace

std::variant<BallbarTest, JoinTrouble> join_bus(const BallbarTest& test, const BusRecord& whole) {
  if (!is_usable(whole))
    return JoinTrouble{
        "the record has less than two samples, columns of different lengths, values that are no numbers or "
        "times that do not increase",
        "nothing can be looked up in it", "write it with `abbe capture --columns`"};
  const BusRecord record = one_for_each_command(whole);
  const CommandedCircle circle = commanded_circle(test, record);
  BallbarTest joined = test;
  std::size_t next = 0;
  for (std::size_t i = 0; i < joined.runs.size(); ++i) {
    BallbarRun& run = joined.runs[i];
    bool found = false;
    for (; next < circle.stretches.size() && !found; ++next)
      found = circle.stretches[next].direction == run.direction &&
              join_run(test, record, circle, circle.stretches[next], run);
    if (found) continue;
    return JoinTrouble{
        fmt::format(
            "the commanded positions do not go {} along run {} of {} (radius {:g} mm about {:g}, {:g} mm)",
            in_words(run.direction), i + 1, test.file, test.radius, test.centre[test.plane.first],
            test.centre[test.plane.second]),
        circle.stretches.empty()
            ? "they are never on that circle: another plane, centre or radius, or swapped axes"
            : "the runs are looked for in their order, each without a halt and all its angles",
        "name the record of this test, and the axes of its plane"};
  }
  return joined;
}

}  // namespace abbe
