#pragma once

#include <numbers>

namespace abbe {

/// Inside the library every length is in mm, every angle in rad, time in s, temperature in degC.
/// Multiply by a unit on the way in, divide by it on the way out: `2.5 * um`, `error / um`.
inline constexpr double mm = 1.0;
inline constexpr double um = 1e-3;
inline constexpr double nm = 1e-6;
inline constexpr double metre = 1e3;
inline constexpr double inch = 25.4;
inline constexpr double rad = 1.0;
inline constexpr double mrad = 1e-3;
inline constexpr double urad = 1e-6;
inline constexpr double deg = std::numbers::pi / 180.0;
inline constexpr double arcsec = deg / 3600.0;

}  // namespace abbe
