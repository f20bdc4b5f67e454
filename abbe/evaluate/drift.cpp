#include "abbe/evaluate/drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "abbe/evaluate/text_findings.h"

namespace abbe {
namespace {

constexpr double kHour = 3600;

double range_of(const std::vector<double>& values, std::size_t count) {
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(count);
  const auto [lo, hi] = std::minmax_element(values.begin(), end);
  return *hi - *lo;
}

/// Largest range within a window of one hour. The deques hold the indices that can still become the smallest
/// and the largest: each index enters and leaves once.
double most_in_an_hour(const std::vector<double>& time, const std::vector<double>& values) {
  std::deque<std::size_t> low, high;
  double most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    while (!low.empty() && values[low.back()] >= values[i]) low.pop_back();
    while (!high.empty() && values[high.back()] <= values[i]) high.pop_back();
    low.push_back(i);
    high.push_back(i);
    while (time[i] - time[low.front()] > kHour) low.pop_front();
    while (time[i] - time[high.front()] > kHour) high.pop_front();
    most = std::max(most, values[high.front()] - values[low.front()]);
  }
  return most;
}

SensorDrift drift_of(const std::vector<double>& time, const MeasuredColumn& sensor) {
  const auto hour = static_cast<std::size_t>(
      std::upper_bound(time.begin(), time.end(), time.front() + kHour) - time.begin());
  return {sensor.name,
          sensor.quantity,
          range_of(sensor.values, sensor.values.size()),
          range_of(sensor.values, hour),
          most_in_an_hour(time, sensor.values),
          sensor.values.back() - sensor.values.front()};
}

/// (a - b) / distance as a sensor of its own, if both sensors are there.
std::optional<MeasuredColumn> tilt_of(const MeasuredTable& table, const char* name, const char* a,
                                      const char* b, double distance) {
  const MeasuredColumn *first = table.find(a), *second = table.find(b);
  if (first == nullptr || second == nullptr) return std::nullopt;
  MeasuredColumn tilt{name, Quantity::angle, 1, {}};
  for (std::size_t i = 0; i < table.rows(); ++i)
    tilt.values.push_back((first->values[i] - second->values[i]) / distance);
  return tilt;
}

}  // namespace

Parsed<DriftFigures> drift_figures(const MeasuredTable& table, std::optional<double> sensor_distance) {
  Parsed<DriftFigures> out;
  TextFindings findings(table.file);
  const MeasuredColumn* time = table.find("time");
  if (time == nullptr || time->quantity != Quantity::time) {
    findings.error("E-DRIFT-TIME", 0, "there is no column of time", "drift is a change in time",
                   "name a column: time [min] (or s, h)");
    return {std::nullopt, findings.take()};
  }
  for (std::size_t i = 1; i < table.rows(); ++i) {
    if (time->values[i] > time->values[i - 1]) continue;
    findings.error("E-DRIFT-TIME", table.lines[i], "time does not increase", "the log would run backwards",
                   "sort the rows, keep each time once");
    return {std::nullopt, findings.take()};
  }
  DriftFigures figures;
  figures.duration = time->values.back() - time->values.front();
  for (const MeasuredColumn& column : table.columns)
    if (&column != time && column.quantity != Quantity::number)
      figures.sensors.push_back(drift_of(time->values, column));
  if (sensor_distance) {
    for (const auto& tilt : {tilt_of(table, "A", "Y1", "Y2", *sensor_distance),
                             tilt_of(table, "B", "X2", "X1", *sensor_distance)})
      if (tilt) figures.sensors.push_back(drift_of(time->values, *tilt));
  }
  if (figures.sensors.empty())
    findings.error("E-DRIFT-SENSOR", 0, "there is no column with a unit besides time",
                   "nothing is left to judge", "name sensors with their unit: Y1 [um], T1 [degC]");
  if (!findings.failed()) out.value = std::move(figures);
  out.diagnostics = findings.take();
  return out;
}

}  // namespace abbe
