#include "abbe/report/gear_figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

using Anchor = SvgPage::Anchor;

constexpr double kWidth = 1000, kHeight = 1290, kLeft = 60;
constexpr double kBlockWidth = 420, kBlockGap = 40;  // left flanks, right flanks
constexpr double kTraceTop = 120, kTraceHeight = 230, kBlockHeight = 340;
constexpr double kPitchHeight = 110, kPitchGap = 66;
constexpr double kDivision = 20;  // px: one division of the scale
constexpr std::string_view kGrid = "#e4e4e4", kGrey = "#777777", kTrace = "#1d6fa5", kLimit = "#a3245c",
                           kBar = "#9db8cc";
constexpr std::string_view kMicrometre = "\xC2\xB5m";
constexpr std::size_t kMostPoints = 120;  // of a trace

std::string um_text(double length, int decimals) {
  std::string text;
  append_fixed(text, std::clamp(length / um, -1e11, 1e11), decimals);
  return text;
}

/// One trace of a flank: positions along it, deviations, the part that is evaluated.
struct Trace {
  const std::vector<double>& along;
  const std::vector<double>& deviation;
  double from, to;  ///< evaluation range
  TraceFigures figures;
};

double largest_deviation(const GearChart& chart) {
  double most = 0;
  for (const GearChart::Tooth& tooth : chart.teeth)
    for (const FlankTraces& traces : tooth.traces)
      for (const auto* values : {&traces.profile, &traces.helix})
        for (std::size_t i = 0; i < values->size(); ++i) {
          const auto& all = *values;
          const double mean = all[all.size() / 2];  // pitch is shown apart
          most = std::max(most, std::abs(all[i] - mean));
        }
  return most;
}

/// Draws traces into slots: deviations are shown about the trace's value in the middle, whose position is
/// pitch.
class TraceDrawer {
 public:
  TraceDrawer(SvgPage& page, double um_per_division)
      : page_(page), scale_(kDivision / (um_per_division * um)) {}

  void draw(const Trace& trace, double x, double top, double outwards, int tooth) {
    if (trace.along.size() < 2) return;
    const double lo = trace.along.front(), hi = trace.along.back();
    const auto y_of = [&](double along) { return top + kTraceHeight * (hi - along) / (hi - lo); };
    const double middle = trace.deviation[trace.deviation.size() / 2];
    const auto x_of = [&](double deviation) { return x + outwards * scale_ * (deviation - middle); };
    page_.line({x, top}, {x, top + kTraceHeight}, {.colour = kGrey, .width = 0.6});
    for (const double end : {trace.from, trace.to})
      page_.line({x - kDivision, y_of(end)}, {x + kDivision, y_of(end)}, {.colour = kGrey, .dashes = "3 3"});
    draw_mean_line(trace, x_of, y_of);
    std::vector<PagePoint> points;
    const std::size_t step = 1 + trace.along.size() / kMostPoints;
    for (std::size_t i = 0; i < trace.along.size(); i += step)
      points.push_back({x_of(trace.deviation[i]), y_of(trace.along[i])});
    page_.polyline(points, {.colour = kTrace, .width = 1.6});
    page_.text({x, top - 8}, fmt::format("{}", tooth), {.size = 12, .anchor = Anchor::middle, .bold = true});
    const std::array values = {trace.figures.total, trace.figures.slope, trace.figures.form};
    for (std::size_t i = 0; i < values.size(); ++i)
      page_.text({x, top + kTraceHeight + 20 + 14 * static_cast<double>(i)}, um_text(values[i], 1),
                 {.size = 11, .anchor = Anchor::middle});
  }

 private:
  template <class X, class Y>
  void draw_mean_line(const Trace& trace, const X& x_of, const Y& y_of) {
    std::vector<double> along, deviation;
    double mean_along = 0, mean_deviation = 0;
    for (std::size_t i = 0; i < trace.along.size(); ++i) {
      if (trace.along[i] < trace.from - 1e-9 || trace.along[i] > trace.to + 1e-9) continue;
      mean_along += trace.along[i];
      mean_deviation += trace.deviation[i];
      along.push_back(trace.along[i]);
    }
    if (along.empty() || !(trace.to > trace.from)) return;
    mean_along /= static_cast<double>(along.size());
    mean_deviation /= static_cast<double>(along.size());
    const double slope = trace.figures.slope / (trace.to - trace.from);
    const auto at = [&](double a) {
      return PagePoint{x_of(mean_deviation + slope * (a - mean_along)), y_of(a)};
    };
    page_.line(at(trace.from), at(trace.to), {.colour = kLimit, .width = 1, .dashes = "5 3"});
  }

  SvgPage& page_;
  double scale_;  ///< px per mm
};

double evaluated_end(const GearJob& job) {
  const Gear& gear = job.gear;
  return gear.base_radius * (gear.form_roll + job.evaluation.profile_part * (gear.tip_roll - gear.form_roll));
}

double helix_end(const GearJob& job) {
  const double b = job.gear.spec.face_width;
  return b / 2 -
         std::min(job.evaluation.helix_end_part * b, job.evaluation.helix_end_modules * job.gear.spec.module);
}

/// Tolerances of one kind of trace, beside the figures.
std::string limits_text(const GearJob& job, std::array<double FlankTolerances::*, 3> which) {
  const auto tolerances =
      job.tolerance_class ? flank_tolerances(job.gear, *job.tolerance_class) : std::nullopt;
  if (!tolerances) return {};
  std::string text = fmt::format("class {}:", *job.tolerance_class);
  for (const auto member : which) text += " " + um_text(rounded_tolerance((*tolerances).*member), 1);
  return text;
}

/// Profiles or helices of all shown teeth: left flanks, then right flanks.
void draw_traces(SvgPage& page, const GearJob& job, const GearChart& chart, bool helix, double top,
                 double um_per_division) {
  TraceDrawer drawer(page, um_per_division);
  const std::array<const char*, 3> names = helix ? std::array{"F\xCE\xB2", "fH\xCE\xB2", "ff\xCE\xB2"}
                                                 : std::array{"F\xCE\xB1", "fH\xCE\xB1", "ff\xCE\xB1"};
  const std::size_t shown = std::min(chart.teeth.size(), kMostChartTeeth);
  for (const std::size_t side : {std::size_t{1}, std::size_t{0}}) {
    const double left = side == 1 ? kLeft : kLeft + kBlockWidth + kBlockGap;
    page.box({left, top}, kBlockWidth, kTraceHeight, "none", kGrid);
    page.text({left + kBlockWidth / 2, top - 26},
              fmt::format("{}, {} flanks", helix ? "Helix" : "Profile", side == 1 ? "left" : "right"),
              {.size = 13, .anchor = Anchor::middle, .bold = true});
    for (std::size_t k = 0; k < shown; ++k) {
      // Mirrored, as the flanks of a tooth: the last left flank stands beside the first right one.
      const std::size_t at = side == 1 ? shown - 1 - k : k;
      const double x = left + kBlockWidth * (static_cast<double>(at) + 0.5) / static_cast<double>(shown);
      const GearChart::Tooth& tooth = chart.teeth[k];
      const FlankFigures& figures = chart.figures.teeth[static_cast<std::size_t>(tooth.number - 1)][side];
      const FlankTraces& traces = tooth.traces[side];
      const Trace trace =
          helix ? Trace{traces.z, traces.helix, -helix_end(job), helix_end(job), figures.helix}
                : Trace{traces.roll_length, traces.profile, job.gear.base_radius * job.gear.form_roll,
                        evaluated_end(job), figures.profile};
      drawer.draw(trace, x, top, side == 1 ? -1 : 1, tooth.number);
    }
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    page.text({kLeft - 8, top + kTraceHeight + 20 + 14 * static_cast<double>(i)}, names[i],
              {.size = 11, .anchor = Anchor::end, .colour = kGrey});
  page.text({kLeft - 34, top + 12}, helix ? "+z" : "tip", {.size = 11, .colour = kGrey});
  page.text({kLeft - 34, top + kTraceHeight}, helix ? "-z" : "form", {.size = 11, .colour = kGrey});
  page.text({kWidth - 60, top + kTraceHeight + 62},
            limits_text(job, helix ? std::array{&FlankTolerances::F_beta, &FlankTolerances::f_H_beta,
                                                &FlankTolerances::f_f_beta}
                                   : std::array{&FlankTolerances::F_alpha, &FlankTolerances::f_H_alpha,
                                                &FlankTolerances::f_f_alpha}),
            {.size = 11, .anchor = Anchor::end, .colour = kGrey});
}

/// A curve over all teeth or gaps, and bars.
void draw_round(SvgPage& page, double top, const std::string& title, const std::vector<double>& curve,
                const std::vector<double>& bars) {
  constexpr double kAcross = 2 * kBlockWidth + kBlockGap;
  double most = 1 * nm;
  for (const auto* values : {&curve, &bars})
    for (const double value : *values) most = std::max(most, std::abs(value));
  const double top_um = round_up(most / um);
  const auto y_of = [&](double value) { return top + kPitchHeight / 2 * (1 - value / um / top_um); };
  const auto x_of = [&](std::size_t i) {
    return kLeft + kAcross * (static_cast<double>(i) + 0.5) / static_cast<double>(curve.size());
  };
  page.box({kLeft, top}, kAcross, kPitchHeight, "none", kGrid);
  page.line({kLeft, y_of(0)}, {kLeft + kAcross, y_of(0)}, {.colour = kGrey, .width = 0.6});
  page.text({kLeft, top - 8}, title, {.size = 12, .bold = true});
  for (const double end : {top_um, -top_um})
    page.text({kLeft - 8, y_of(end * um) + 4}, fmt::format("{:g}", end), {.size = 11, .anchor = Anchor::end});
  const double width = 0.7 * kAcross / static_cast<double>(std::max<std::size_t>(curve.size(), 1));
  for (std::size_t i = 0; i < bars.size(); ++i) {
    const double a = y_of(bars[i]), zero = y_of(0);
    page.box({x_of(i) - width / 2, std::min(a, zero)}, width, std::abs(a - zero), kBar);
  }
  std::vector<PagePoint> points;
  for (std::size_t i = 0; i < curve.size(); ++i) points.push_back({x_of(i), y_of(curve[i])});
  page.polyline(points, {.colour = kTrace, .width = 1.4});
  page.text({x_of(0), top + kPitchHeight + 14}, "1", {.size = 10, .anchor = Anchor::middle});
  page.text({x_of(curve.size() - 1), top + kPitchHeight + 14}, fmt::format("{}", curve.size()),
            {.size = 10, .anchor = Anchor::middle});
}

std::vector<double> about_mean(const std::vector<double>& values) {
  double mean = 0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  std::vector<double> out = values;
  for (double& value : out) value -= mean;
  return out;
}

void draw_pitch(SvgPage& page, const GearJob& job, const GearChart& chart, double top) {
  const auto tolerances =
      job.tolerance_class ? flank_tolerances(job.gear, *job.tolerance_class) : std::nullopt;
  const auto limit = [&](double FlankTolerances::*which) {
    return tolerances ? fmt::format(" (class {}: {})", *job.tolerance_class,
                                    um_text(rounded_tolerance((*tolerances).*which), 1))
                      : std::string();
  };
  for (const std::size_t side : {std::size_t{1}, std::size_t{0}}) {
    const PitchFigures& pitch = chart.figures.pitch[side];
    const std::string title =
        fmt::format("Pitch, {} flanks: cumulative (curve) Fp {}{}, single (bars) fp {}{} {}",
                    side == 1 ? "left" : "right", um_text(pitch.F_p, 1), limit(&FlankTolerances::F_p),
                    um_text(pitch.f_p, 1), limit(&FlankTolerances::f_p), kMicrometre);
    draw_round(page, top, title, about_mean(pitch.index), pitch.single);
    top += kPitchHeight + kPitchGap - 20;
  }
  draw_round(page, top,
             fmt::format("Runout of a ball in the gaps Fr {}{} {}", um_text(chart.figures.F_r, 1),
                         limit(&FlankTolerances::F_r), kMicrometre),
             about_mean(chart.figures.ball), {});
}

}  // namespace

std::string figure_of_gear(const GearJob& job, const GearChart& chart) {
  SvgPage page(kWidth, kHeight);
  page.text({kLeft, 34}, chart.title, {.size = 18, .bold = true});
  page.text({kLeft, 54}, chart.remark, {.size = 11, .colour = kGrey});
  const std::size_t shown = std::max<std::size_t>(1, std::min(chart.teeth.size(), kMostChartTeeth));
  // The largest deviation takes 0.4 of a slot.
  const double room = 0.4 * kBlockWidth / static_cast<double>(shown) / kDivision;
  const double um_per_division = round_up(std::max(largest_deviation(chart) / um, 0.1) / room);
  page.text({kWidth - 60, 54}, fmt::format("{:g} {}", um_per_division, kMicrometre),
            {.size = 11, .anchor = Anchor::end});
  page.line({kWidth - 60 - kDivision, 62}, {kWidth - 60, 62}, {.width = 2});
  draw_traces(page, job, chart, false, kTraceTop, um_per_division);
  draw_traces(page, job, chart, true, kTraceTop + kBlockHeight, um_per_division);
  if (!chart.figures.teeth.empty()) draw_pitch(page, job, chart, kTraceTop + 2 * kBlockHeight);
  page.text({kLeft, kHeight - 16},
            "traces: excess material goes outwards, dashed: evaluation range and mean line; deviations in "
            "the transverse "
            "plane along the base tangent",
            {.size = 11, .colour = kGrey});
  return page.finish(chart.title, chart.remark);
}

}  // namespace abbe
