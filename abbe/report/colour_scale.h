#pragma once

#include <string>

#include "abbe/report/svg.h"

namespace abbe {

/// Shades of the colour scale of figures.
inline constexpr int kShades = 24;

/// From light blue (0) over purple to dark red (1), ever darker, so that it reads in grey too. Clamped.
[[nodiscard]] std::string colour_of(double part);

/// The shade of `value` on a scale from 0 to `most` > 0: 0 to kShades - 1.
[[nodiscard]] int shade_of(double value, double most);
[[nodiscard]] std::string colour_of_shade(int shade);

/// The scale itself, 0 at the bottom and `most` um at the top: the distance |d| of the tip.
void draw_colour_bar(SvgPage& page, double most_um, PagePoint corner, double height);

}  // namespace abbe
