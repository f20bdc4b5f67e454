#include "abbe/report/figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/report/colour_scale.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

constexpr double kWidth = 1120, kHeight = 860;
constexpr double kMargin = 40;
constexpr double kPathTop = 104, kPathHeight = 400, kPathWidth = 430;
constexpr double kStripLeft = 96, kStripRight = 1080, kStripHeight = 112;
constexpr double kBeforeTop = 562, kAfterTop = 704;
constexpr std::size_t kMostSegments = 4000;  ///< drawn per picture
constexpr int kStripColumns = 700;           ///< of which the least and the largest value are drawn
constexpr double kFlat = 0.35;               ///< thinner than this part of the second extent: seen from above

constexpr std::string_view kMicrometre = "\xC2\xB5m";
constexpr std::string_view kGrey = "#777777", kLightGrey = "#bbbbbb", kGrid = "#e4e4e4";
constexpr std::array<std::string_view, 3> kComponentColour = {"#a3245c", "#1d6fa5", "#222222"};
constexpr std::array<std::string_view, 3> kComponentDashes = {"", "", "5 3"};
constexpr std::array<std::string_view, 3> kComponentName = {"x", "y", "z"};

/// Two samples are farther apart than the path between them is long: a rapid went between.
bool is_gap(const PathSample& a, const PathSample& b) {
  constexpr double kSlack = 1e-3 * mm;
  return (b.position - a.position).norm() > 1.001 * (b.travelled - a.travelled) + kSlack;
}

/// How space is laid on the page: across and up are vectors in workpiece axes.
struct View {
  Vec3 across = Vec3::UnitX(), up = Vec3::UnitY();
  std::string across_name = "X (mm)", up_name = "Y (mm)";
  bool isometric = false;
};

struct Box {
  Vec3 lo = Vec3::Zero(), hi = Vec3::Zero();
};

View choose_view(const Box& box) {
  const Vec3 extent = box.hi - box.lo;
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
  View view;
  if (extent[order[2]] > kFlat * extent[order[1]]) {
    view.isometric = true;
    const double c = std::sqrt(0.5), s = std::sqrt(1.0 / 6);
    view.across = Vec3(c, c, 0);
    view.up = Vec3(-s, s, 2 * s);
    return view;
  }
  // The plane without the thinnest direction; where nothing is extended, from above.
  const int thin = extent[order[1]] > 0 ? order[2] : (extent.z() > 0 ? 1 : 2);
  const int a = thin == 0 ? 1 : 0;
  const int b = thin == 2 ? 1 : 2;
  view.across = Vec3::Unit(a);
  view.up = Vec3::Unit(b);
  view.across_name = fmt::format("{} (mm)", "XYZ"[a]);
  view.up_name = fmt::format("{} (mm)", "XYZ"[b]);
  return view;
}

bool is_finite(const PathSample& s) {
  return s.position.allFinite() && s.before.allFinite() && s.after.allFinite() && std::isfinite(s.travelled);
}

/// The samples shown: finite ones, thinned evenly to a number that a page can hold.
std::vector<PathSample> samples_to_draw(const std::vector<PathSample>& all) {
  std::vector<PathSample> finite;
  for (const PathSample& s : all) {
    if (is_finite(s)) finite.push_back(s);
  }
  if (finite.size() <= kMostSegments) return finite;
  std::vector<PathSample> thin;
  for (std::size_t i = 0; i < kMostSegments; ++i)
    thin.push_back(finite[i * (finite.size() - 1) / (kMostSegments - 1)]);
  return thin;
}

/// Maps the view onto a panel with the same scale both ways.
struct Projection {
  View view;
  double scale = 1, left = 0, bottom = 0, a0 = 0, b0 = 0;
  [[nodiscard]] PagePoint operator()(const Vec3& p) const {
    return {left + scale * (view.across.dot(p) - a0), bottom - scale * (view.up.dot(p) - b0)};
  }
};

struct Range {
  double lo = 0, hi = 0;
  void add(double v, bool first) {
    lo = first ? v : std::min(lo, v);
    hi = first ? v : std::max(hi, v);
  }
};

Projection fit(const View& view, const std::vector<PathSample>& samples, double left, double top,
               double width, double height) {
  Range a, b;
  bool first = true;
  for (const PathSample& s : samples) {
    if (s.rapid) continue;
    a.add(view.across.dot(s.position), first);
    b.add(view.up.dot(s.position), first);
    first = false;
  }
  // A path without extent gets a millimetre around it.
  const double span_a = std::max(a.hi - a.lo, 1e-9), span_b = std::max(b.hi - b.lo, 1e-9);
  double scale = std::min(width / span_a, height / span_b);
  if (std::max(span_a, span_b) < 1e-6) scale = std::min(width, height);
  Projection projection{view, scale, 0, 0, a.lo, b.lo};
  projection.left = left + (width - scale * (a.hi - a.lo)) / 2;
  projection.bottom = top + (height + scale * (b.hi - b.lo)) / 2;
  return projection;
}

enum class Side { before, after };

double deviation_um(const PathSample& s, Side side) {
  return (side == Side::before ? s.before : s.after).norm() / um;
}

void draw_plan_axes(SvgPage& page, const Projection& to_page, double left, double top) {
  const double right = left + kPathWidth, bottom = top + kPathHeight;
  const auto a_at = [&](double x) { return to_page.a0 + (x - to_page.left) / to_page.scale; };
  const auto b_at = [&](double y) { return to_page.b0 + (to_page.bottom - y) / to_page.scale; };
  const Ticks a = round_ticks(a_at(left), a_at(right), 6);
  const Ticks b = round_ticks(b_at(bottom), b_at(top), 6);
  for (const double value : a.values) {
    const double x = to_page.left + to_page.scale * (value - to_page.a0);
    page.line({x, top}, {x, bottom}, {.colour = kGrid});
    page.text({x, bottom + 15}, fmt::format("{:.{}f}", value, a.decimals),
              {.size = 11, .anchor = SvgPage::Anchor::middle});
  }
  for (const double value : b.values) {
    const double y = to_page.bottom - to_page.scale * (value - to_page.b0);
    page.line({left, y}, {right, y}, {.colour = kGrid});
    page.text({left - 6, y + 4}, fmt::format("{:.{}f}", value, b.decimals),
              {.size = 11, .anchor = SvgPage::Anchor::end});
  }
  page.box({left, top}, kPathWidth, kPathHeight, "", kLightGrey);
  page.text({left + kPathWidth / 2, bottom + 32}, to_page.view.across_name,
            {.size = 12, .anchor = SvgPage::Anchor::middle});
  page.text({left - 38, top + kPathHeight / 2}, to_page.view.up_name,
            {.size = 12, .anchor = SvgPage::Anchor::middle, .turned = 90});
}

/// Three arrows with the names of the axes, and a bar that tells the scale.
void draw_isometric_axes(SvgPage& page, const Projection& to_page, double left, double top) {
  page.box({left, top}, kPathWidth, kPathHeight, "", kLightGrey);
  const PagePoint corner{left + 46, top + kPathHeight - 36};
  for (int i = 0; i < 3; ++i) {
    const Vec3 unit = Vec3::Unit(i);
    const double dx = 34 * to_page.view.across.dot(unit), dy = -34 * to_page.view.up.dot(unit);
    page.line(corner, {corner.x + dx, corner.y + dy}, {.width = 1.5});
    page.text({corner.x + 1.3 * dx, corner.y + 1.3 * dy + 4}, kComponentName[static_cast<std::size_t>(i)],
              {.size = 12, .anchor = SvgPage::Anchor::middle});
  }
  const Ticks lengths = round_ticks(0, 0.3 * kPathWidth / to_page.scale, 4);
  if (lengths.values.empty()) return;
  const double length = lengths.values.back();
  const double right = left + kPathWidth - 16, y = top + kPathHeight - 20;
  page.line({right - length * to_page.scale * std::sqrt(0.5), y}, {right, y}, {.width = 2});
  page.text({right, y - 7}, fmt::format("{:.{}f} mm along x or y", length, lengths.decimals),
            {.size = 11, .anchor = SvgPage::Anchor::end});
}

void draw_path(SvgPage& page, const Projection& to_page, const std::vector<PathSample>& samples, Side side,
               double most_um, double left, double top) {
  if (to_page.view.isometric) {
    draw_isometric_axes(page, to_page, left, top);
  } else {
    draw_plan_axes(page, to_page, left, top);
  }
  const auto inside = [&](PagePoint p) {
    return p.x >= left && p.x <= left + kPathWidth && p.y >= top && p.y <= top + kPathHeight;
  };
  const auto band = [&](const PathSample& s) { return shade_of(deviation_um(s, side), most_um); };
  // Rapids first, below the cut; only what lies within the panel.
  std::vector<std::vector<PagePoint>> rapids;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (!samples[i].rapid && !is_gap(samples[i - 1], samples[i])) continue;
    const PagePoint a = to_page(samples[i - 1].position), b = to_page(samples[i].position);
    if (inside(a) && inside(b)) rapids.push_back({a, b});
  }
  page.polylines(rapids, {.colour = kLightGrey, .width = 0.6, .dashes = "3 2"});
  // Stretches of one colour are one line; the darkest are drawn last, so that the worst is seen.
  std::array<std::vector<std::vector<PagePoint>>, kShades> stretches;
  std::vector<PagePoint> stretch;
  int colour_of_stretch = -1;
  std::size_t cut = 0;
  const auto finish = [&] {
    if (colour_of_stretch >= 0) stretches[static_cast<std::size_t>(colour_of_stretch)].push_back(stretch);
    stretch.clear();
    colour_of_stretch = -1;
  };
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!samples[i].rapid) ++cut;
    if (i == 0) continue;
    if (samples[i].rapid || is_gap(samples[i - 1], samples[i])) {
      finish();
      continue;
    }
    const int wanted = std::max(band(samples[i]), samples[i - 1].rapid ? 0 : band(samples[i - 1]));
    if (wanted != colour_of_stretch) {
      finish();
      colour_of_stretch = wanted;
      stretch.push_back(to_page(samples[i - 1].position));
    }
    stretch.push_back(to_page(samples[i].position));
  }
  finish();
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    page.polylines(stretches[i], {.colour = colour_of_shade(static_cast<int>(i)), .width = 1.4});
  }
  const auto worst =
      std::max_element(samples.begin(), samples.end(), [&](const PathSample& a, const PathSample& b) {
        return (a.rapid ? -1 : deviation_um(a, side)) < (b.rapid ? -1 : deviation_um(b, side));
      });
  page.ring(to_page(worst->position), 7, {.width = 1.2});
  if (cut == 1) {
    for (const PathSample& s : samples) {
      if (!s.rapid) page.dot(to_page(s.position), 5, colour_of_shade(band(s)));
    }
  }
}

/// Numbers of a strip: the cut points only, path length in mm, components in um.
struct StripData {
  std::vector<double> travelled;
  std::array<std::vector<double>, 3> component;
};

StripData strip_data(const std::vector<PathSample>& all, Side side) {
  StripData data;
  for (const PathSample& s : all) {
    if (!is_finite(s) || s.rapid) continue;
    data.travelled.push_back(s.travelled);
    const Vec3 d = (side == Side::before ? s.before : s.after) / um;
    for (std::size_t c = 0; c < 3; ++c) data.component[c].push_back(d[static_cast<Eigen::Index>(c)]);
  }
  return data;
}

/// Of every column of the page the least and the largest value, in the order they occur: no peak is lost.
std::vector<PagePoint> strip_line(const std::vector<double>& s, const std::vector<double>& v, double from,
                                  double to, double y0, double scale) {
  std::vector<PagePoint> points;
  const double width = kStripRight - kStripLeft;
  std::size_t i = 0;
  while (i < s.size()) {
    const auto column_of = [&](std::size_t k) {
      return to > from ? static_cast<std::int64_t>((s[k] - from) / (to - from) * kStripColumns)
                       : std::int64_t{0};
    };
    const std::int64_t column = column_of(i);
    std::size_t least = i, most = i, next = i;
    for (; next < s.size() && column_of(next) == column; ++next) {
      if (v[next] < v[least]) least = next;
      if (v[next] > v[most]) most = next;
    }
    for (const std::size_t k : {std::min(least, most), std::max(least, most)}) {
      const double x = to > from ? kStripLeft + width * (s[k] - from) / (to - from) : kStripLeft + width / 2;
      points.push_back({x, y0 - scale * v[k]});
      if (least == most) break;
    }
    i = next;
  }
  return points;
}

void draw_strip(SvgPage& page, const StripData& data, double top, std::string_view name,
                std::optional<double> allowed_um, bool bottom_axis) {
  const double bottom = top + kStripHeight, width = kStripRight - kStripLeft;
  double lo = -allowed_um.value_or(0), hi = allowed_um.value_or(0);
  for (const std::vector<double>& values : data.component) {
    for (const double v : values) lo = std::min(lo, v), hi = std::max(hi, v);
  }
  if (!(hi > lo)) lo = -1, hi = 1;
  const double space = 0.06 * (hi - lo);
  lo -= space, hi += space;
  const double scale = kStripHeight / (hi - lo), y0 = bottom + scale * lo;
  const Ticks ticks = round_ticks(lo, hi, 6);
  for (const double value : ticks.values) {
    const double y = y0 - scale * value;
    page.line({kStripLeft, y}, {kStripRight, y}, {.colour = value == 0 ? kGrey : kGrid});
    page.text({kStripLeft - 6, y + 4}, value == 0 ? "0" : fmt::format("{:+.{}f}", value, ticks.decimals),
              {.size = 11, .anchor = SvgPage::Anchor::end});
  }
  if (allowed_um) {
    for (const double sign : {-1.0, 1.0}) {
      const double y = y0 - sign * scale * *allowed_um;
      page.line({kStripLeft, y}, {kStripRight, y}, {.colour = "#b06000", .dashes = "8 4"});
    }
    // Under the line if there is no room above it.
    const double y = y0 - scale * *allowed_um;
    page.text({kStripRight - 4, y < top + 16 ? y + 12 : y - 4},
              fmt::format("allowed {:.2f} {}", *allowed_um, kMicrometre),
              {.size = 10, .anchor = SvgPage::Anchor::end, .colour = "#b06000"});
  }
  const double from = 0;
  const double to = data.travelled.empty() ? 0 : data.travelled.back();
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<PagePoint> points = strip_line(data.travelled, data.component[c], from, to, y0, scale);
    if (points.size() == 1) page.dot(points.front(), 3, kComponentColour[c]);
    page.polyline(points, {.colour = kComponentColour[c], .width = 1.1, .dashes = kComponentDashes[c]});
  }
  page.box({kStripLeft, top}, width, kStripHeight, "", kLightGrey);
  page.text({kStripLeft - 56, top + kStripHeight / 2}, fmt::format("d ({})", kMicrometre),
            {.size = 12, .anchor = SvgPage::Anchor::middle, .turned = 90});
  page.text({kStripLeft, top - 7}, name, {.size = 12, .bold = true});
  // Legend to the right of the name, on one line.
  double x = kStripRight - 150;
  for (std::size_t c = 0; c < 3; ++c, x += 52) {
    page.line({x, top - 11}, {x + 24, top - 11},
              {.colour = kComponentColour[c], .width = 2, .dashes = kComponentDashes[c]});
    page.text({x + 28, top - 7}, kComponentName[c], {.size = 12});
  }
  if (!bottom_axis) return;
  if (to > from) {
    const Ticks lengths = round_ticks(from, to, 8);
    for (const double value : lengths.values) {
      const double at = kStripLeft + width * (value - from) / (to - from);
      page.line({at, bottom}, {at, bottom + 4}, {.colour = kGrey});
      page.text({at, bottom + 17}, fmt::format("{:.{}f}", value, lengths.decimals),
                {.size = 11, .anchor = SvgPage::Anchor::middle});
    }
  }
  page.text({(kStripLeft + kStripRight) / 2, bottom + 34}, "length of the feed path (mm)",
            {.size = 12, .anchor = SvgPage::Anchor::middle});
}

std::string name_of_file(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

std::string numbers(const DeviationSummary& summary) {
  const int decimals = summary.max >= 10 * um ? 1 : 3;
  return fmt::format("max {:.{}f} {}, rms {:.{}f} {}", summary.max / um, decimals, kMicrometre,
                     summary.rms / um, decimals, kMicrometre);
}

}  // namespace

std::string figure_before_after(const ProgramReport& report) {
  static const VerifyReport kNothing;
  const VerifyReport& verify = report.verify != nullptr ? *report.verify : kNothing;
  SvgPage page(kWidth, kHeight);
  const std::string title = fmt::format("{}: deviation of the tool tip before and after correction",
                                        name_of_file(report.input_name));
  page.text({kMargin, 34}, title, {.size = 18, .bold = true});
  std::string source = fmt::format("machine {}", report.machine->name);
  if (!report.machine->calibration.date.empty()) source += ", calibrated " + report.machine->calibration.date;
  source += fmt::format("; machine file sha256 {}; program sha256 {}", report.machine->sha256.substr(0, 12),
                        verify.original.sha256.substr(0, 12));
  page.text({kMargin, 53}, source, {.size = 11, .colour = kGrey});
  page.text({kMargin, 67},
            fmt::format("positions and d in workpiece axes of the machine file; d = actual - nominal tip{}",
                        report.datum == DatumRule::probed ? ", less what it is at the probed datum" : ""),
            {.size = 11, .colour = kGrey});

  const std::vector<PathSample> samples = samples_to_draw(verify.samples);
  const bool has_cut =
      std::any_of(samples.begin(), samples.end(), [](const PathSample& s) { return !s.rapid; });
  if (!has_cut) {
    page.text({kWidth / 2, kHeight / 2}, "no feed motion to show",
              {.size = 16, .anchor = SvgPage::Anchor::middle});
    return page.finish(title, source);
  }
  Box box;
  bool first = true;
  double most = 0;
  for (const PathSample& s : samples) {
    if (s.rapid) continue;
    box.lo = first ? s.position : Vec3(box.lo.cwiseMin(s.position));
    box.hi = first ? s.position : Vec3(box.hi.cwiseMax(s.position));
    first = false;
    most = std::max({most, deviation_um(s, Side::before), deviation_um(s, Side::after)});
  }
  const double scale_um = round_up(most);
  const View view = choose_view(box);
  constexpr double kInset = 14;
  const std::array<double, 2> left = {86, 572};
  for (const Side side : {Side::before, Side::after}) {
    const double x = left[side == Side::before ? 0 : 1];
    // Isometric pictures leave room for the arrows of the axes.
    const double low = view.isometric ? 70 : kInset;
    const Projection to_page = fit(view, samples, x + kInset, kPathTop + kInset, kPathWidth - 2 * kInset,
                                   kPathHeight - kInset - low);
    draw_path(page, to_page, samples, side, scale_um, x, kPathTop);
    page.text({x, kPathTop - 9},
              fmt::format("{}: {} (ring: worst place)", side == Side::before ? "Before" : "After",
                          numbers(side == Side::before ? verify.before : verify.after)),
              {.size = 14, .bold = true});
  }
  draw_colour_bar(page, scale_um, {1032, kPathTop + 30}, kPathHeight - 60);
  draw_strip(page, strip_data(verify.samples, Side::before), kBeforeTop, "Before, along the path",
             std::nullopt, false);
  draw_strip(page, strip_data(verify.samples, Side::after), kAfterTop, "After, along the path (own scale)",
             verify.allowed / um, true);
  return page.finish(title, source);
}

}  // namespace abbe
