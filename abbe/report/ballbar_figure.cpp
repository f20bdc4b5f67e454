#include "abbe/report/ballbar_figure.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/report/svg.h"

namespace abbe {
namespace {

using Anchor = SvgPage::Anchor;
using Kind = DiagnosisTerm::Kind;

constexpr double kWidth = 1160, kHeight = 752, kMargin = 40;
constexpr PagePoint kCentre = {330, 412};
constexpr double kNominal = 180, kReach = 100;  // radius of the nominal circle; of the largest deviation
constexpr double kTableLeft = 690, kTableTop = 150, kRow = 24, kBarWidth = 110;
constexpr std::size_t kMostPoints = 3600, kMostTerms = 20;
constexpr std::string_view kMicrometre = "\xC2\xB5m";
constexpr std::string_view kGrey = "#777777", kGrid = "#dddddd", kInk = "#222222";
constexpr std::string_view kCounterClockwise = "#a3245c", kClockwise = "#1d6fa5", kBar = "#b9cfe3";

/// From radial deviations (mm) to the page; the second axis points up.
struct Polar {
  double scale = 1;  ///< page units per mm
  [[nodiscard]] PagePoint operator()(double angle, double deviation) const {
    const double r = std::max(4.0, kNominal + scale * deviation);
    return {kCentre.x + r * std::cos(angle), kCentre.y - r * std::sin(angle)};
  }
};

double largest_deviation(const BallbarTest& test) {
  double largest = 0;
  for (const BallbarRun& run : test.runs)
    for (const double d : run.deviation) largest = std::max(largest, std::abs(d));
  return largest;
}

void draw_rings(SvgPage& page, const Polar& polar, double ring, TestPlane plane) {
  for (int k = -2; k <= 2; ++k) {
    const double radius = kNominal + polar.scale * k * ring / 2;
    page.ring(kCentre, radius, {.colour = k == 0 ? kInk : kGrid, .width = k == 0 ? 1.2 : 0.8});
    const double height = -radius * std::sin(std::numbers::pi / 4);
    page.text({kCentre.x - height + 4, kCentre.y + height - 2},
              k == 0 ? std::string("nominal") : fmt::format("{:+.3g} {}", k * ring / 2 / um, kMicrometre),
              {.size = 10, .colour = kGrey});
  }
  const double end = kNominal + kReach + 24;
  page.line({kCentre.x - end, kCentre.y}, {kCentre.x + end, kCentre.y}, {.colour = kGrid});
  page.line({kCentre.x, kCentre.y - end}, {kCentre.x, kCentre.y + end}, {.colour = kGrid});
  page.text({kCentre.x + end + 6, kCentre.y + 4}, fmt::format("+{}", axis_letter(plane.first)), {.size = 13});
  page.text({kCentre.x, kCentre.y - end - 6}, fmt::format("+{}", axis_letter(plane.second)),
            {.size = 13, .anchor = Anchor::middle});
}

void draw_traces(SvgPage& page, const Polar& polar, const BallbarTest& test, const Diagnosis& diagnosis) {
  for (std::size_t k = 0; k < test.runs.size(); ++k) {
    const BallbarRun& run = test.runs[k];
    const std::size_t step = (run.angle.size() + kMostPoints - 1) / kMostPoints;
    std::vector<PagePoint> trace, fit;
    for (std::size_t i = 0; i < run.angle.size(); i += step) {
      trace.push_back(polar(run.angle[i], run.deviation[i]));
      if (diagnosis.solved) fit.push_back(polar(run.angle[i], run.deviation[i] - diagnosis.residual[k][i]));
    }
    page.polyline(fit, {.colour = kGrey, .width = 0.6});
    page.polyline(trace, {.colour = run.direction > 0 ? kCounterClockwise : kClockwise,
                          .width = 1.3,
                          .dashes = run.direction > 0 ? std::string_view{} : std::string_view{"6 3"}});
  }
}

std::string name_of(const DiagnosisTerm& term) {
  return term.axis.empty() ? std::string(to_string(term.kind))
                           : fmt::format("{} {}", to_string(term.kind), term.axis);
}

void draw_terms(SvgPage& page, const Diagnosis& diagnosis) {
  std::vector<const DiagnosisTerm*> terms;
  for (const DiagnosisTerm& term : diagnosis.terms) terms.push_back(&term);
  std::stable_sort(terms.begin(), terms.end(),
                   [](const DiagnosisTerm* a, const DiagnosisTerm* b) { return a->effect > b->effect; });
  terms.resize(std::min(terms.size(), kMostTerms));
  const double most = terms.empty() ? 0 : terms.front()->effect;
  page.text({kTableLeft, kTableTop - 14}, "Causes, by their largest effect on the radius",
            {.size = 14, .bold = true});
  double y = kTableTop + 10;
  for (const DiagnosisTerm* term : terms) {
    const TermText text = text_of(*term);
    const double width = most > 0 ? kBarWidth * term->effect / most : 0;
    page.box({kTableLeft + 310, y - 12}, width, 15, kBar);
    page.text({kTableLeft + 314, y}, fmt::format("{:.2f} {}", term->effect / um, kMicrometre), {.size = 11});
    page.text({kTableLeft, y}, name_of(*term), {.size = 12});
    page.text({kTableLeft + 300, y},
              term->separable ? fmt::format("{} \xC2\xB1 {} {}", text.value, text.uncertainty, text.unit)
                              : std::string("not separable"),
              {.size = 12, .anchor = Anchor::end});
    y += kRow;
  }
}

std::string figures_line(const TestFigures& figures) {
  std::string text;
  for (const CircularFigures& f : figures.directions)
    text += fmt::format("{} G {:.2f} (least squares) {:.2f} (minimum zone); ", f.direction > 0 ? "CCW" : "CW",
                        f.least_squares.width() / um, f.minimum_zone.width() / um);
  if (figures.both)
    text +=
        fmt::format("G(b) {:.2f}, {:.2f}; D {:+.2f} {}", figures.least_squares_both.width() / um,
                    figures.minimum_zone_both.width() / um, figures.mean_radial_deviation / um, kMicrometre);
  return text;
}

}  // namespace

TermText text_of(const DiagnosisTerm& term) {
  const auto scaled = [&](double unit, const char* name, int decimals) {
    TermText text{{}, {}, name};
    append_fixed(text.value, std::clamp(term.value / unit, -1e11, 1e11), decimals);
    append_fixed(text.uncertainty, std::clamp(term.uncertainty / unit, 0.0, 1e11), decimals + 1);
    return text;
  };
  switch (term.kind) {
    case Kind::scale_mismatch:
      return scaled(1e-6, "um/m", 2);
    case Kind::squareness:
      return scaled(urad, "urad", 2);
    case Kind::servo_mismatch:
      return scaled(1e-3, "ms", 3);
    case Kind::straightness:
      return scaled(1e-9, "1e-9/mm", 2);
    default:
      return scaled(um, "um", 2);
  }
}

std::string figure_of_ballbar(const BallbarTest& test, const TestFigures& figures,
                              const Diagnosis& diagnosis) {
  SvgPage page(kWidth, kHeight);
  const std::string title = fmt::format("Circular test {}, R {:g} mm, {:g} mm/min", to_string(test.plane),
                                        test.radius, test.feed * 60);
  page.text({kMargin, 34}, title, {.size = 18, .bold = true});
  std::string source = test.file;
  for (const std::string& more : {test.machine, test.instrument, test.date})
    if (!more.empty()) source += "; " + more;
  page.text({kMargin, 53}, source, {.size = 11, .colour = kGrey});
  page.text({kMargin, 69}, figures_line(figures), {.size = 11, .colour = kGrey});
  const double ring = round_up(largest_deviation(test) / um) * um;
  const Polar polar{kReach / ring};
  draw_rings(page, polar, ring, test.plane);
  draw_traces(page, polar, test, diagnosis);
  page.text(
      {kMargin, kHeight - 22},
      fmt::format(
          "counter-clockwise solid, clockwise dashed, fit grey; radial deviation magnified {:.0f} times",
          ring > 0 ? kReach / ring * test.radius / kNominal : 0.0),
      {.size = 11, .colour = kGrey});
  draw_terms(page, diagnosis);
  return page.finish(title, source);
}

}  // namespace abbe
