#include "abbe/report/colour_scale.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace abbe {
namespace {

constexpr double kBar = 14;
constexpr std::string_view kFrame = "#777777";

}  // namespace

std::string colour_of(double part) {
  static constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{134, 182, 217}, {106, 134, 196}, {138, 79, 158}, {163, 36, 92}, {80, 8, 24}}};
  const double at = std::clamp(part, 0.0, 1.0) * (kStops.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  const double f = at - static_cast<double>(i);
  std::array<int, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c)
    rgb[c] = static_cast<int>(std::lround((1 - f) * kStops[i][c] + f * kStops[i + 1][c]));
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

int shade_of(double value, double most) {
  return std::clamp(static_cast<int>(value / most * kShades), 0, kShades - 1);
}

std::string colour_of_shade(int shade) { return colour_of((shade + 0.5) / kShades); }

void draw_colour_bar(SvgPage& page, double most_um, PagePoint corner, double height) {
  for (int i = 0; i < kShades; ++i) {
    const double y = corner.y + height * (kShades - 1 - i) / kShades;
    page.box({corner.x, y}, kBar, height / kShades + 0.5, colour_of_shade(i));
  }
  page.box(corner, kBar, height, "", kFrame);
  const Ticks ticks = round_ticks(0, most_um, 5);
  for (const double value : ticks.values) {
    const double y = corner.y + height * (1 - value / most_um);
    page.line({corner.x + kBar, y}, {corner.x + kBar + 4, y}, {.colour = kFrame});
    page.text({corner.x + kBar + 7, y + 4}, fmt::format("{:.{}f}", value, ticks.decimals), {.size = 11});
  }
  page.text({corner.x + kBar / 2, corner.y - 10}, "|d| (\xC2\xB5m)",
            {.size = 11, .anchor = SvgPage::Anchor::middle});
}

}  // namespace abbe
