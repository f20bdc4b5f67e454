#include "abbe/verify/rotary.h"

#include <cmath>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe::verifying {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kSamePlace = 1e-9;  // rad: no way at all, not a full turn

}  // namespace

Turning Rotary::turning(int letter) const {
  const int axis = axes_.rotary[static_cast<std::size_t>(letter)];
  const auto i = static_cast<std::size_t>(axis);
  return axis >= 0 && i < control_.axes.size() ? control_.axes[i].turning : Turning::linear;
}

double Rotary::resolution(int letter) const {
  const int axis = axes_.rotary[static_cast<std::size_t>(letter)];
  const auto i = static_cast<std::size_t>(axis);
  return axis >= 0 && i < control_.axes.size() ? control_.axes[i].resolution.value_or(0) : 0;
}

double Rotary::target(int letter, double word, double from, double offset) const {
  const double place = (turning(letter) == Turning::sign ? std::abs(word) : word) * deg + offset;
  switch (turning(letter)) {
    case Turning::linear:
      return place;
    case Turning::shortest:  // the place nearest to `from`
      return place + kTurn * std::round((from - place) / kTurn);
    case Turning::sign:
      break;
  }
  // the first such place at or behind `from`, in the direction of the sign
  if (std::signbit(word)) return place + kTurn * std::floor((from + kSamePlace - place) / kTurn);
  return place + kTurn * std::ceil((from - kSamePlace - place) / kTurn);
}

}  // namespace abbe::verifying
