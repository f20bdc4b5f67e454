#include "abbe/report/part_figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

constexpr double kWidth = 980, kHeight = 720, kMargin = 50, kPlot = 600;
constexpr double kBarLeft = 720, kBarTop = 110, kBarHeight = 260, kBarWidth = 22;
constexpr std::size_t kMostDots = 10000;
constexpr int kLines = 8, kPiecesOfLine = 40, kSteps = 24;
constexpr std::string_view kGrey = "#777777", kGrid = "#cccccc";
constexpr std::string_view kMicrometre = "\xC2\xB5m";

/// -1 dark blue, 0 nearly white, 1 dark red.
std::string signed_colour(double part) {
  static constexpr std::array<std::array<double, 3>, 3> kEnds{
      {{12, 60, 130}, {240, 240, 236}, {150, 20, 28}}};
  const double p = std::clamp(part, -1.0, 1.0);
  const auto& end = kEnds[p < 0 ? 0 : 2];
  std::array<int, 3> rgb{};
  for (std::size_t k = 0; k < 3; ++k)
    rgb[k] = static_cast<int>(std::lround(kEnds[1][k] + std::abs(p) * (end[k] - kEnds[1][k])));
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

/// Part axes to the page: the two axes along which the surface reaches farthest, in their order.
struct View {
  Eigen::Index right = 0, up = 1;
  Vec3 low = Vec3::Zero();
  double scale = 1;
  [[nodiscard]] PagePoint operator()(const Vec3& p) const {
    return {kMargin + scale * (p[right] - low[right]), kMargin + 40 + kPlot - scale * (p[up] - low[up])};
  }
};

using Lines = std::vector<std::vector<Vec3>>;

/// Lines of constant u and of constant v.
Lines lines_of(const NurbsSurface& surface) {
  Lines lines;
  const std::array<std::array<double, 2>, 2> range{surface.range(0), surface.range(1)};
  for (std::size_t along = 0; along < 2; ++along) {
    for (int k = 0; k <= kLines; ++k) {
      std::vector<Vec3>& line = lines.emplace_back();
      for (int i = 0; i <= kPiecesOfLine; ++i) {
        std::array<double, 2> at{};
        at[along] = range[along][0] + (range[along][1] - range[along][0]) * i / kPiecesOfLine;
        at[1 - along] = range[1 - along][0] + (range[1 - along][1] - range[1 - along][0]) * k / kLines;
        line.push_back(evaluate(surface, {at[0], at[1]}).p);
      }
    }
  }
  return lines;
}

View view_of(const Lines& lines) {
  View view;
  Vec3 low = lines[0][0], high = low;
  for (const auto& line : lines)
    for (const Vec3& p : line) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vec3 size = high - low;
  Eigen::Index flat = 2;
  if (size.x() < size[flat]) flat = 0;
  if (size.y() < size[flat]) flat = 1;
  view.right = flat == 0 ? 1 : 0;
  view.up = flat == 2 ? 1 : 2;
  view.low = low;
  view.scale = kPlot / std::max({size[view.right], size[view.up], 1e-9});
  return view;
}

void draw_scale(SvgPage& page, double most_um) {
  for (int k = 0; k < kSteps; ++k) {
    const double part = 1 - 2 * (k + 0.5) / kSteps;
    page.box({kBarLeft, kBarTop + kBarHeight * k / kSteps}, kBarWidth, kBarHeight / kSteps + 0.5,
             signed_colour(part));
  }
  for (const double part : {1.0, 0.5, 0.0, -0.5, -1.0})
    page.text({kBarLeft + kBarWidth + 8, kBarTop + kBarHeight * (1 - part) / 2 + 4},
              fmt::format("{:+.3g} {}", part * most_um, kMicrometre), {.size = 12});
  page.text({kBarLeft, kBarTop - 30}, "deviation along the normal", {.size = 12});
  page.text({kBarLeft, kBarTop - 14}, "+ material left on", {.size = 11, .colour = kGrey});
}

void draw_figures(SvgPage& page, const InspectionFigures& f) {
  const std::array<std::pair<const char*, double>, 7> rows{{{"mean", f.mean},
                                                            {"rms", f.rms},
                                                            {"least", f.least},
                                                            {"most", f.most},
                                                            {"profile (2 max |d|)", f.profile},
                                                            {"range", f.range},
                                                            {"mean linear error", f.linear}}};
  double y = kBarTop + kBarHeight + 50;
  page.text({kBarLeft, y - 20}, fmt::format("{} points", f.count), {.size = 12, .bold = true});
  for (const auto& [name, value] : rows) {
    page.text({kBarLeft, y}, name, {.size = 12});
    page.text({kBarLeft + 210, y}, fmt::format("{:.2f} {}", value / um, kMicrometre),
              {.size = 12, .anchor = SvgPage::Anchor::end});
    y += 20;
  }
}

void draw_points(SvgPage& page, const View& view, const Inspection& inspection, double most) {
  const std::size_t every = inspection.points.size() / kMostDots + 1;
  const double count = static_cast<double>(inspection.points.size()) / static_cast<double>(every);
  const double radius = std::clamp(0.35 * kPlot / std::sqrt(std::max(count, 1.0)), 1.5, 14.0);
  for (std::size_t k = 0; k < inspection.points.size(); k += every) {
    const InspectedPoint& point = inspection.points[k];
    const PagePoint at = view(point.foot.at.p);
    if (point.used) page.dot(at, radius, signed_colour(point.foot.deviation / most));
    page.ring(at, radius, {.colour = kGrey, .width = 0.4});
  }
}

}  // namespace

std::string figure_of_inspection(const NurbsSurface& surface, const Inspection& inspection) {
  SvgPage page(kWidth, kHeight);
  const Lines lines = lines_of(surface);
  const View view = view_of(lines);
  const InspectionFigures& f = inspection.figures;
  page.text({kMargin, 40}, surface.name.empty() ? "Deviations of the part" : surface.name,
            {.size = 18, .bold = true});
  std::vector<std::vector<PagePoint>> drawn;
  for (const auto& line : lines) {
    drawn.emplace_back();
    for (const Vec3& p : line) drawn.back().push_back(view(p));
  }
  page.polylines(drawn, {.colour = kGrid, .width = 0.8});
  const double most = round_up(std::max(std::abs(f.least), std::abs(f.most)) / um) * um;
  if (f.count == 0) page.text({kBarLeft, kBarTop}, "no points on the surface", {.size = 13});
  draw_points(page, view, inspection, most);
  if (f.count > 0) {
    draw_scale(page, most / um);
    draw_figures(page, f);
  }
  page.text({kMargin, kHeight - 12}, fmt::format("{} to the right, {} up", "XYZ"[view.right], "XYZ"[view.up]),
            {.size = 11, .colour = kGrey});
  return page.finish("Deviations of the part",
                     fmt::format("colour map of the deviations at {} points", f.count));
}

}  // namespace abbe
