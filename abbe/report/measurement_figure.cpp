#include "abbe/report/measurement_figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/core/units.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

using Anchor = SvgPage::Anchor;

constexpr double kWidth = 960, kChartLeft = 90, kChartWidth = 600, kChartTop = 84, kChartHeight = 300;
constexpr double kFactsLeft = 730, kFactHeight = 20, kBetweenCharts = 76;
constexpr std::size_t kMostDots = 5000, kMostPoints = 2000;
constexpr std::string_view kForward = "#1d6fa5", kBackward = "#a3245c", kGrey = "#777777", kGrid = "#e4e4e4";
constexpr std::array<std::string_view, 6> kColours = {"#1d6fa5", "#a3245c", "#222222",
                                                      "#2f8f5b", "#b07818", "#6a51a3"};
constexpr std::array<std::string_view, 3> kDashes = {"", "6 3", "2 3"};

/// How numbers of a quantity are shown.
struct Shown {
  double factor;
  std::string_view unit;
};
Shown error_scale(Quantity quantity) {
  switch (quantity) {
    case Quantity::length:
      return {um, "\xC2\xB5m"};
    case Quantity::angle:
      return {urad, "\xC2\xB5rad"};
    case Quantity::temperature:
      return {1,
              "\xC2\xB0"
              "C"};
    default:
      return {1, ""};
  }
}
Shown position_scale(Quantity quantity) {
  return quantity == Quantity::angle ? Shown{deg, "deg"} : Shown{mm, "mm"};
}

/// A stretch of numbers, never empty.
struct Extent {
  double lo = 0, hi = 0;
  bool any = false;
  void add(double value) {
    lo = any ? std::min(lo, value) : value;
    hi = any ? std::max(hi, value) : value;
    any = true;
  }
  void widen(double share) {
    const double by = hi > lo ? share * (hi - lo) : std::max(1e-9, std::abs(lo) * share);
    lo -= by;
    hi += by;
  }
};

/// A chart on the page: its box, and where numbers are in it.
struct Chart {
  double top;
  Extent across, up;
  [[nodiscard]] PagePoint at(double x, double y) const {
    return {kChartLeft + kChartWidth * (x - across.lo) / (across.hi - across.lo),
            top + kChartHeight * (up.hi - y) / (up.hi - up.lo)};
  }
};

void draw_axes(SvgPage& page, const Chart& chart, std::string_view across, std::string_view up) {
  const double bottom = chart.top + kChartHeight;
  const Ticks x = round_ticks(chart.across.lo, chart.across.hi, 7),
              y = round_ticks(chart.up.lo, chart.up.hi, 6);
  for (const double value : y.values) {
    const PagePoint p = chart.at(chart.across.lo, value);
    page.line(p, {kChartLeft + kChartWidth, p.y}, {.colour = kGrid});
    page.text({p.x - 8, p.y + 4}, fmt::format("{:.{}f}", value, y.decimals),
              {.size = 11, .anchor = Anchor::end});
  }
  for (const double value : x.values) {
    const PagePoint p = chart.at(value, chart.up.lo);
    page.line(p, {p.x, p.y + 4}, {.colour = kGrey});
    page.text({p.x, p.y + 18}, fmt::format("{:.{}f}", value, x.decimals),
              {.size = 11, .anchor = Anchor::middle});
  }
  page.box({kChartLeft, chart.top}, kChartWidth, kChartHeight, "none", kGrey);
  page.text({kChartLeft + kChartWidth / 2, bottom + 38}, across, {.anchor = Anchor::middle});
  page.text({kChartLeft - 58, chart.top + kChartHeight / 2}, up, {.anchor = Anchor::middle, .turned = 90});
}

void draw_facts(SvgPage& page, const std::vector<FigureFact>& facts) {
  double y = kChartTop + 12;
  for (const FigureFact& fact : facts) {
    page.text({kFactsLeft, y}, fact.name, {.size = 12});
    page.text({kWidth - 30, y}, fact.value, {.size = 12, .anchor = Anchor::end, .bold = true});
    y += kFactHeight;
  }
}

double page_height(std::size_t charts, std::size_t facts) {
  const double by_charts = kChartTop + static_cast<double>(charts) * (kChartHeight + kBetweenCharts);
  return std::max(by_charts, kChartTop + kFactHeight * static_cast<double>(facts + 1));
}

void draw_direction(SvgPage& page, const Chart& chart, const RunTable& table, const Eigen::MatrixXd& values,
                    std::string_view colour, std::string_view dashes) {
  if (values.cols() == 0) return;
  const Shown x = position_scale(table.target_quantity), y = error_scale(table.quantity);
  const Eigen::Index step = 1 + values.size() / static_cast<Eigen::Index>(kMostDots / 2);
  std::vector<PagePoint> means;
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    const double position = table.targets[static_cast<std::size_t>(i)] / x.factor;
    means.push_back(chart.at(position, values.row(i).mean() / y.factor));
    for (Eigen::Index j = 0; j < values.cols(); ++j)
      if ((i * values.cols() + j) % step == 0)
        page.dot(chart.at(position, values(i, j) / y.factor), 2, colour);
  }
  page.polyline(means, {.colour = colour, .width = 1.6, .dashes = dashes});
}

std::vector<const MeasuredColumn*> sensors_of(const MeasuredTable& table, Quantity quantity) {
  std::vector<const MeasuredColumn*> sensors;
  for (const MeasuredColumn& column : table.columns)
    if (column.quantity == quantity) sensors.push_back(&column);
  return sensors;
}

void draw_sensors(SvgPage& page, double top, const std::vector<double>& time,
                  const std::vector<const MeasuredColumn*>& sensors) {
  constexpr double kMinute = 60;
  const Shown scale = error_scale(sensors.front()->quantity);
  Chart chart{top, {}, {}};
  for (const double t : time) chart.across.add(t / kMinute);
  for (const MeasuredColumn* sensor : sensors)
    for (const double value : sensor->values) chart.up.add(value / scale.factor);
  chart.across.widen(0);
  chart.up.widen(0.06);
  draw_axes(page, chart, "time (min)", scale.unit);
  const std::size_t step = 1 + time.size() / kMostPoints;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    std::vector<PagePoint> course;
    for (std::size_t i = 0; i < time.size(); i += step)
      course.push_back(chart.at(time[i] / kMinute, sensors[s]->values[i] / scale.factor));
    const std::string_view colour = kColours[s % kColours.size()];
    page.polyline(course,
                  {.colour = colour, .width = 1.4, .dashes = kDashes[s / kColours.size() % kDashes.size()]});
    page.text({kChartLeft + 8 + 80 * static_cast<double>(s % 7), top - 8 - 14 * static_cast<double>(s / 7)},
              sensors[s]->name, {.size = 11, .bold = true, .colour = colour});
  }
}

}  // namespace

std::string figure_of_runs(const RunTable& table, std::string_view title,
                           const std::vector<FigureFact>& facts) {
  SvgPage page(kWidth, page_height(1, facts.size()));
  page.text({30, 36}, title, {.size = 17, .bold = true});
  const Shown x = position_scale(table.target_quantity), y = error_scale(table.quantity);
  Chart chart{kChartTop, {}, {}};
  for (const double target : table.targets) chart.across.add(target / x.factor);
  for (const Eigen::MatrixXd* values : {&table.forward, &table.backward})
    for (Eigen::Index k = 0; k < values->size(); ++k) chart.up.add(values->data()[k] / y.factor);
  chart.across.widen(0.02);
  chart.up.widen(0.06);
  draw_axes(page, chart, fmt::format("position ({})", x.unit), fmt::format("deviation ({})", y.unit));
  draw_direction(page, chart, table, table.forward, kForward, "");
  draw_direction(page, chart, table, table.backward, kBackward, "6 3");
  page.text({kChartLeft, kChartTop - 10}, fmt::format("forward ({} runs), solid", table.forward.cols()),
            {.size = 11, .colour = kForward});
  page.text({kChartLeft + 190, kChartTop - 10},
            fmt::format("backward ({} runs), dashed", table.backward.cols()),
            {.size = 11, .colour = kBackward});
  draw_facts(page, facts);
  return page.finish(title, "Deviations at the targets of repeated runs, with their means.");
}

std::string figure_of_drift(const MeasuredTable& table, std::string_view title,
                            const std::vector<FigureFact>& facts) {
  std::vector<std::vector<const MeasuredColumn*>> groups;
  for (const Quantity quantity : {Quantity::length, Quantity::angle, Quantity::temperature}) {
    std::vector<const MeasuredColumn*> sensors = sensors_of(table, quantity);
    if (!sensors.empty()) groups.push_back(std::move(sensors));
  }
  SvgPage page(kWidth, page_height(groups.size(), facts.size()));
  page.text({30, 36}, title, {.size = 17, .bold = true});
  double top = kChartTop;
  if (const MeasuredColumn* time = table.find("time")) {
    for (const auto& sensors : groups) {
      draw_sensors(page, top, time->values, sensors);
      top += kChartHeight + kBetweenCharts;
    }
  }
  draw_facts(page, facts);
  return page.finish(title, "Readings of the sensors over time.");
}

}  // namespace abbe
