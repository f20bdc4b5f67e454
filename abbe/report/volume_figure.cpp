#include "abbe/report/volume_figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/report/colour_scale.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

using Anchor = SvgPage::Anchor;

constexpr double kWidth = 1160, kHeight = 904, kMargin = 40;
constexpr double kPanelTop = 118, kPanelWidth = 276, kPanelHeight = 250;
constexpr std::array<double, 3> kPanelLeft = {84, 432, 780};
constexpr double kBarLeft = 1086;
constexpr double kLowerTop = 468, kRightLeft = 596, kRightEnd = 1120;
constexpr std::size_t kMostCells = 64, kMostOfProfile = 1000, kMostStrokes = 9, kMostErrors = 14;

constexpr std::string_view kMicrometre = "\xC2\xB5m", kDegree = "\xC2\xB0";
constexpr std::string_view kGrey = "#777777", kLightGrey = "#bbbbbb", kGrid = "#e4e4e4", kInk = "#222222";
constexpr std::string_view kPale = "#b9cfe3", kStrong = "#3d6d9e";
constexpr std::array<std::string_view, 3> kComponentColour = {"#a3245c", "#1d6fa5", "#222222"};
constexpr std::array<std::string_view, 3> kComponentDashes = {"", "", "5 3"};
constexpr std::array<std::string_view, 3> kComponentName = {"x", "y", "z"};

/// Digits that tell a deviation: um with one decimal, small ones with more.
std::string micrometres(double value, bool sign = false) {
  const double v = value / um;
  if (std::abs(v) < 5e-4) return "0";
  const int decimals = std::abs(v) >= 9.995 ? 1 : std::abs(v) >= 0.0995 ? 2 : 3;
  return sign ? fmt::format("{:+.{}f}", v, decimals) : fmt::format("{:.{}f}", v, decimals);
}

double shown(const Body& axis, double position) {
  return axis.type == AxisType::rotary ? position / deg : position;
}

std::string with_unit(const Body& axis) {
  return fmt::format("{} ({})", axis.name, axis.type == AxisType::rotary ? "deg" : "mm");
}

/// Axes with more than one position: those of the diagonals first, then the others along the chain.
std::vector<int> varying_axes(const Machine& machine, const VolumeGrid& grid) {
  std::vector<int> axes = diagonal_axes(machine, grid);
  for (int i = 0; i < machine.axis_count(); ++i)
    if (grid.varies(i) && std::find(axes.begin(), axes.end(), i) == axes.end()) axes.push_back(i);
  return axes;
}

/// Indices of at most `most` of `count` positions, ends included; `keep` is among them.
std::vector<std::size_t> thinned(std::size_t count, std::size_t most, std::size_t keep) {
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < std::min(count, most); ++k)
    chosen.push_back(count <= most ? k : k * (count - 1) / (most - 1));
  const auto nearest = std::min_element(chosen.begin(), chosen.end(), [&](std::size_t a, std::size_t b) {
    return (a > keep ? a - keep : keep - a) < (b > keep ? b - keep : keep - b);
  });
  if (nearest != chosen.end()) *nearest = keep;
  return chosen;
}

/// Evenly spaced indices below `count`, at most `most` of them, as far from the first as from the last.
std::vector<std::size_t> evenly(std::size_t count, std::size_t most) {
  const std::size_t step = (count + most - 1) / most;
  std::vector<std::size_t> chosen;
  for (std::size_t k = (count - 1) % step / 2; k < count; k += step) chosen.push_back(k);
  return chosen;
}

/// The grid as a figure reads it: index of a point from the indices of its positions.
struct Lattice {
  const VolumeGrid& grid;
  std::vector<std::size_t> worst;  ///< of the point of the largest deviation

  Lattice(const VolumeGrid& g, std::size_t point) : grid(g), worst(g.positions.size()) {
    for (std::size_t i = worst.size(); i-- > 0;) {
      worst[i] = point % grid.positions[i].size();
      point /= grid.positions[i].size();
    }
  }
  [[nodiscard]] std::size_t point(const std::vector<std::size_t>& at) const {
    std::size_t index = 0;
    for (std::size_t i = 0; i < at.size(); ++i) index = index * grid.positions[i].size() + at[i];
    return index;
  }
};

/// A stretch of the page that shows positions of an axis, in order of their size.
struct Scale {
  std::vector<std::size_t> index;           ///< of the positions shown, by increasing position
  std::vector<double> value;                ///< of them, mm or deg
  double lo = 0, hi = 1, from = 0, to = 1;  ///< `from` belongs to lo

  Scale(const Body& axis, const std::vector<double>& positions, std::size_t keep, double page_from,
        double page_to, std::size_t most = kMostCells)
      : index(thinned(positions.size(), most, keep)), from(page_from), to(page_to) {
    std::sort(index.begin(), index.end(),
              [&](std::size_t a, std::size_t b) { return positions[a] < positions[b]; });
    for (const std::size_t i : index) value.push_back(shown(axis, positions[i]));
    lo = value.front();
    hi = value.back() > lo ? value.back() : lo + 1;
  }
  [[nodiscard]] double at(double v) const { return from + (to - from) * (v - lo) / (hi - lo); }
  /// Border between cell k - 1 and cell k, half way; the outer ones end where the axis does.
  [[nodiscard]] double border(std::size_t k) const {
    if (k == 0) return from;
    if (k == value.size()) return to;
    return at((value[k - 1] + value[k]) / 2);
  }
};

void draw_ticks(SvgPage& page, const Scale& across, const Scale& up) {
  const Ticks a = round_ticks(across.lo, across.hi, 5), b = round_ticks(up.lo, up.hi, 5);
  for (const double value : a.values) {
    page.line({across.at(value), up.from}, {across.at(value), up.from + 4}, {.colour = kGrey});
    page.text({across.at(value), up.from + 20}, fmt::format("{:.{}f}", value, a.decimals),
              {.size = 11, .anchor = Anchor::middle});
  }
  for (const double value : b.values) {
    page.line({across.from - 4, up.at(value)}, {across.from, up.at(value)}, {.colour = kGrey});
    page.text({across.from - 10, up.at(value) + 4}, fmt::format("{:.{}f}", value, b.decimals),
              {.size = 11, .anchor = Anchor::end});
  }
}

/// Direction of the nominal tip on the page when an axis moves by its step: workpiece axes, unit length or
/// zero.
Vec3 direction_of(const VolumeMap& map, const Lattice& lattice, std::size_t axis) {
  std::vector<std::size_t> a = lattice.worst, b = lattice.worst;
  const std::vector<double>& positions = lattice.grid.positions[axis];
  a[axis] =
      static_cast<std::size_t>(std::min_element(positions.begin(), positions.end()) - positions.begin());
  b[axis] =
      static_cast<std::size_t>(std::max_element(positions.begin(), positions.end()) - positions.begin());
  const Vec3 way = map.field.nominal[lattice.point(b)] - map.field.nominal[lattice.point(a)];
  return way.norm() > 0 ? Vec3(way.normalized()) : Vec3(Vec3::Zero());
}

void draw_slice(SvgPage& page, const Machine& machine, const VolumeMap& map, const Lattice& lattice,
                int across_axis, int up_axis, double left, double most_um) {
  const auto i = static_cast<std::size_t>(across_axis), j = static_cast<std::size_t>(up_axis);
  const Body &a = machine.axis(across_axis), &b = machine.axis(up_axis);
  const double bottom = kPanelTop + kPanelHeight;
  const Scale across(a, lattice.grid.positions[i], lattice.worst[i], left, left + kPanelWidth);
  const Scale up(b, lattice.grid.positions[j], lattice.worst[j], bottom, kPanelTop);
  const auto deviation = [&](std::size_t k, std::size_t m) -> const Vec3& {
    std::vector<std::size_t> at = lattice.worst;
    at[i] = across.index[k];
    at[j] = up.index[m];
    return map.field.deviation[lattice.point(at)];
  };
  for (std::size_t m = 0; m < up.value.size(); ++m) {
    // Neighbours of one shade are one box; a little overlap, so that no seam shows.
    for (std::size_t k = 0; k < across.value.size();) {
      const int shade = shade_of(deviation(k, m).norm() / um, most_um);
      std::size_t next = k + 1;
      while (next < across.value.size() && shade_of(deviation(next, m).norm() / um, most_um) == shade) ++next;
      const double x = across.border(k), y = up.border(m + 1);
      const double right = std::min(across.border(next) + 0.4, left + kPanelWidth);
      page.box({x, y}, right - x, std::min(up.border(m) + 0.4, bottom) - y, colour_of_shade(shade));
      k = next;
    }
  }
  // Strokes: from the point to where it goes, one of the full scale nearly reaches the next point.
  if (a.type == AxisType::linear && b.type == AxisType::linear) {
    const Vec3 u = direction_of(map, lattice, i), v = direction_of(map, lattice, j);
    const double length = 0.8 * kPanelWidth / static_cast<double>(kMostStrokes);
    std::vector<std::vector<PagePoint>> strokes;
    for (const std::size_t m : evenly(up.value.size(), kMostStrokes)) {
      for (const std::size_t k : evenly(across.value.size(), kMostStrokes)) {
        const Vec3 d = deviation(k, m) / um / most_um * length;
        const PagePoint p{across.at(across.value[k]), up.at(up.value[m])};
        strokes.push_back({p, {p.x + u.dot(d), p.y - v.dot(d)}});
        page.dot(p, 1.2, "#ffffff");
      }
    }
    page.polylines(strokes, {.colour = "#ffffff", .width = 1.2});
  }
  page.box({left, kPanelTop}, kPanelWidth, kPanelHeight, "", kLightGrey);
  const PagePoint worst{across.at(shown(a, lattice.grid.positions[i][lattice.worst[i]])),
                        up.at(shown(b, lattice.grid.positions[j][lattice.worst[j]]))};
  page.ring(worst, 7, {.colour = "#ffffff", .width = 3});
  page.ring(worst, 7, {.colour = kInk, .width = 1.4});
  draw_ticks(page, across, up);
  page.text({left + kPanelWidth / 2, bottom + 38}, with_unit(a), {.anchor = Anchor::middle});
  page.text({left - 46, kPanelTop + kPanelHeight / 2}, with_unit(b),
            {.anchor = Anchor::middle, .turned = 90});
  // Which slice: where the axes stand that this panel does not show.
  std::string at;
  for (int k = 0; k < machine.axis_count(); ++k) {
    if (k == across_axis || k == up_axis || !lattice.grid.varies(k)) continue;
    const auto axis = static_cast<std::size_t>(k);
    at += fmt::format("{}{} {:.6g}", at.empty() ? ", at " : ", ", machine.axis(k).name,
                      shown(machine.axis(k), lattice.grid.positions[axis][lattice.worst[axis]]));
  }
  page.text({left, kPanelTop - 13}, fmt::format("{}{}{}", a.name, b.name, at), {.size = 13, .bold = true});
}

/// One varying axis: the components along it.
void draw_profile(SvgPage& page, const Machine& machine, const VolumeMap& map, const Lattice& lattice,
                  int axis) {
  const auto i = static_cast<std::size_t>(axis);
  const double left = kPanelLeft[0], right = kPanelLeft[2] + kPanelWidth, bottom = kPanelTop + kPanelHeight;
  double lo = 0, hi = 0;
  for (const Vec3& d : map.field.deviation) {
    lo = std::min(lo, d.minCoeff() / um);
    hi = std::max(hi, d.maxCoeff() / um);
  }
  if (!(hi > lo)) lo = -1, hi = 1;
  const double y0 = bottom + kPanelHeight * lo / (hi - lo), scale = kPanelHeight / (hi - lo);
  const Scale across(machine.axis(axis), lattice.grid.positions[i], lattice.worst[i], left, right,
                     kMostOfProfile);
  const Ticks ticks = round_ticks(lo, hi, 6);
  for (const double value : ticks.values) {
    const double y = y0 - scale * value;
    page.line({left, y}, {right, y}, {.colour = value == 0 ? kGrey : kGrid});
    page.text({left - 6, y + 4}, fmt::format("{:.{}f}", value, ticks.decimals),
              {.size = 11, .anchor = Anchor::end});
  }
  const Ticks along = round_ticks(across.lo, across.hi, 10);
  for (const double value : along.values)
    page.text({across.at(value), bottom + 17}, fmt::format("{:.{}f}", value, along.decimals),
              {.size = 11, .anchor = Anchor::middle});
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<PagePoint> line;
    for (std::size_t k = 0; k < across.value.size(); ++k) {
      std::vector<std::size_t> at = lattice.worst;
      at[i] = across.index[k];
      line.push_back({across.at(across.value[k]),
                      y0 - scale * map.field.deviation[lattice.point(at)][static_cast<int>(c)] / um});
    }
    page.polyline(line, {.colour = kComponentColour[c], .width = 1.4, .dashes = kComponentDashes[c]});
    const double x = right - 150 + 52 * static_cast<double>(c);
    page.line({x, kPanelTop - 11}, {x + 24, kPanelTop - 11},
              {.colour = kComponentColour[c], .width = 2, .dashes = kComponentDashes[c]});
    page.text({x + 28, kPanelTop - 7}, kComponentName[c], {.size = 12});
  }
  page.box({left, kPanelTop}, right - left, kPanelHeight, "", kLightGrey);
  page.text({(left + right) / 2, bottom + 34}, with_unit(machine.axis(axis)), {.anchor = Anchor::middle});
  page.text({left - 42, kPanelTop + kPanelHeight / 2}, fmt::format("d ({})", kMicrometre),
            {.anchor = Anchor::middle, .turned = 90});
}

void draw_budget(SvgPage& page, const Machine& machine, const VolumeMap& map) {
  constexpr double kNames = 100, kBars = 300, kRow = 24;
  page.text({kMargin, kLowerTop}, fmt::format("Error budget: each error alone ({})", kMicrometre),
            {.size = 14, .bold = true});
  const double end = kNames + kBars;
  page.box({end + 22, kLowerTop + 13}, 10, 8, kStrong);
  page.text({end + 36, kLowerTop + 21}, "rms", {.size = 11});
  page.box({end + 92, kLowerTop + 13}, 10, 8, kPale);
  page.text({end + 106, kLowerTop + 21}, "max", {.size = 11});
  double most = 0;
  for (const ErrorShare& share : map.budget) most = std::max(most, share.max);
  if (!(most > 0)) most = 1;
  double y = kLowerTop + 28;
  const std::size_t count = std::min(map.budget.size(), kMostErrors);
  for (std::size_t k = 0; k < count; ++k, y += kRow) {
    const ErrorShare& share = map.budget[k];
    page.text({kNames - 8, y + 13}, to_string(machine.errors[share.error].name), {.anchor = Anchor::end});
    page.box({kNames, y + 2}, kBars * share.max / most, kRow - 8, kPale);
    page.box({kNames, y + 5}, kBars * share.rms / most, kRow - 14, kStrong);
    page.text({end + 58, y + 13}, micrometres(share.rms), {.size = 11, .anchor = Anchor::end});
    page.text({end + 128, y + 13}, micrometres(share.max), {.size = 11, .anchor = Anchor::end});
  }
  page.line({kNames, kLowerTop + 26}, {kNames, y}, {.colour = kGrey});
  if (map.budget.empty()) page.text({kNames + 8, y + 13}, "the machine file has no errors", {});
  if (map.budget.size() > count)
    page.text({kNames, y + 14}, fmt::format("and {} smaller ones", map.budget.size() - count),
              {.size = 11, .colour = kGrey});
  page.text({kMargin, kHeight - 24},
            "Shares are vectors that can cancel: they do not add up to the deviation of the tip.",
            {.size = 11, .colour = kGrey});
}

/// A row of numbers under headings; returns the y of the next row.
double row(SvgPage& page, double y, std::string_view name, const std::vector<std::string>& cells,
           bool heading = false) {
  page.text({kRightLeft, y}, name, {.size = 12, .bold = false, .colour = heading ? kGrey : kInk});
  const double step = 72;
  for (std::size_t k = 0; k < cells.size(); ++k)
    page.text({kRightEnd - step * static_cast<double>(cells.size() - 1 - k), y}, cells[k],
              {.size = 12, .anchor = Anchor::end, .colour = heading ? kGrey : kInk});
  return y + 18;
}

double draw_figures(SvgPage& page, const VolumeMap& map) {
  page.text({kRightLeft, kLowerTop}, fmt::format("Deviation of the tip ({})", kMicrometre),
            {.size = 14, .bold = true});
  double y = row(page, kLowerTop + 21, "", {"max", "95 %", "rms", "range", "fitted"}, true);
  for (std::size_t c = 0; c < 3; ++c) {
    const Spread& s = map.figures.component[c];
    y = row(page, y, kComponentName[c],
            {micrometres(std::max(std::abs(s.min), std::abs(s.max))), micrometres(s.percentile95),
             micrometres(s.rms), micrometres(s.range()),
             micrometres(map.fitted_accuracy.position[static_cast<int>(c)])});
  }
  const auto length = [&](std::string_view name, const Amount& a) {
    y = row(page, y, name, {micrometres(a.max), micrometres(a.percentile95), micrometres(a.rms), "", ""});
  };
  length("distance |d|", map.figures.length);
  length("|d| from the datum", map.from_datum.length);
  length("|d| after best fit", map.fitted.length);
  const Amount& tilt = map.tilt;
  const auto microradians = [](double angle) { return fmt::format("{:.1f}", angle / urad); };
  y = row(page, y, "tilt of the tool (\xC2\xB5rad)",
          {microradians(tilt.max), microradians(tilt.percentile95), microradians(tilt.rms), "", ""});
  return y;
}

void draw_diagonals(SvgPage& page, const Machine& machine, const VolumeMap& map, double top) {
  if (map.diagonals.empty()) return;
  page.text({kRightLeft, top}, fmt::format("Diagonals ({})", kMicrometre), {.size = 14, .bold = true});
  double y = row(page, top + 21, "", {"too long by", "range E", "lost B"}, true);
  constexpr double kZero = 790, kHalf = 100;
  double most = 0;
  for (const Diagonal& d : map.diagonals) most = std::max(most, std::abs(d.change));
  if (!(most > 0)) most = 1;
  const double from = y - 13;
  for (const Diagonal& d : map.diagonals) {
    const double length = kHalf * std::abs(d.change) / most;
    page.box({d.change < 0 ? kZero - length : kZero, y - 10}, length, 12, d.change < 0 ? kPale : kStrong);
    y = row(page, y, name_of(d, machine),
            {micrometres(d.change, true), micrometres(d.range), micrometres(d.reversal)});
  }
  page.line({kZero, from}, {kZero, y - 14}, {.colour = kGrey});
}

}  // namespace

std::string figure_of_volume(const Machine& machine, const VolumeQuestion& question, const VolumeMap& map) {
  const VolumeGrid& grid = question.grid;
  SvgPage page(kWidth, kHeight);
  const std::string title = fmt::format("{}: deviation over the volume",
                                        machine.name.empty() ? std::string("machine") : machine.name);
  page.text({kMargin, 34}, title, {.size = 18, .bold = true});
  std::string source = machine.chain;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const std::vector<double>& positions = grid.positions[static_cast<std::size_t>(i)];
    const auto [lo, hi] = std::minmax_element(positions.begin(), positions.end());
    const Body& axis = machine.axis(i);
    const std::string_view unit = axis.type == AxisType::rotary ? kDegree : std::string_view(" mm");
    source += positions.size() > 1 ? fmt::format("; {} {:.6g} to {:.6g}{} in {}", axis.name, shown(axis, *lo),
                                                 shown(axis, *hi), unit, positions.size())
                                   : fmt::format("; {} {:.6g}{}", axis.name, shown(axis, *lo), unit);
  }
  source += fmt::format("; {} points", map.field.deviation.size());
  page.text({kMargin, 53}, source, {.size = 11, .colour = kGrey});
  const std::vector<int> axes = varying_axes(machine, grid);
  page.text(
      {kMargin, 67},
      fmt::format(
          "d = actual - nominal tip in workpiece axes{}; machine file sha256 {}",
          axes.size() > 1 ? "; slices through the largest |d| (ring); strokes show d within the slice" : "",
          machine.sha256.substr(0, 12)),
      {.size = 11, .colour = kGrey});

  const Lattice lattice(grid, map.figures.length.at);
  const double most_um = round_up(map.figures.length.max / um);
  if (axes.empty()) {
    page.text({kWidth / 2, kPanelTop + kPanelHeight / 2}, "a single point: nothing varies",
              {.size = 16, .anchor = Anchor::middle});
  } else if (axes.size() == 1) {
    draw_profile(page, machine, map, lattice, axes[0]);
  } else {
    draw_slice(page, machine, map, lattice, axes[0], axes[1], kPanelLeft[0], most_um);
    if (axes.size() > 2) {
      draw_slice(page, machine, map, lattice, axes[0], axes[2], kPanelLeft[1], most_um);
      draw_slice(page, machine, map, lattice, axes[1], axes[2], kPanelLeft[2], most_um);
    }
    draw_colour_bar(page, most_um, {kBarLeft, kPanelTop}, kPanelHeight);
  }
  draw_budget(page, machine, map);
  draw_diagonals(page, machine, map, draw_figures(page, map) + 22);
  return page.finish(title, source);
}

}  // namespace abbe
