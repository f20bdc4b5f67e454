#include "abbe/compensate/turn_word.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kAmbiguous = 0.01 * deg;
// A correction never turns an axis farther than this: more is another turn, or the other way.
constexpr double kSameWay = 1 * deg;

/// [0, 2 pi); what rounding of double arithmetic leaves below a full turn is no turn.
double within_turn(double angle) {
  const double within = angle - kTurn * std::floor(angle / kTurn);
  return kTurn - within < 1e-9 ? 0 : within;
}

double digit(int decimals) {
  constexpr std::array<double, 10> kDigits = {1, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
  return kDigits[static_cast<std::size_t>(std::clamp(decimals, 0, 9))];
}

double rounded(double number, int decimals) {
  const double scale = std::nearbyint(1 / digit(decimals));
  return std::nearbyint(number * scale) / scale;
}

/// The number for `wanted`, as the original spells its target.
double spelled(Turning turning, double written, double target, double wanted, int decimals) {
  double number = (turning == Turning::sign ? std::abs(written) : written) + (wanted - target) / deg;
  const bool principal = std::abs(written) < 360;
  const bool within = turning == Turning::sign || (turning == Turning::shortest && principal && written >= 0);
  if (within) number -= 360 * std::floor(number / 360);
  if (turning != Turning::sign) return rounded(number, decimals);
  // below a full turn, and not zero where the sign must be seen
  const double last = 360 - digit(decimals);
  const bool negative = std::signbit(written);
  const double magnitude = std::clamp(rounded(number, decimals), negative ? digit(decimals) : 0.0, last);
  return negative ? -magnitude : magnitude;
}

}  // namespace

TurnTarget turn_target(Turning turning, double written, double from, double offset) {
  const double w = written * deg + offset;
  if (turning == Turning::linear) return {w, false};
  if (turning == Turning::shortest) {
    const double way = std::remainder(w - from, kTurn);
    return {from + way, std::abs(std::abs(way) - kTurn / 2) < kAmbiguous};
  }
  const double place = std::abs(written) * deg;
  const double way = std::signbit(written) ? -within_turn(from - place) : within_turn(place - from);
  return {from + way, false};
}

TurnWord turn_word(Turning turning, double written, double target, double from, double wanted, double offset,
                   int decimals) {
  // The original's word is right to half its last digit: it stays.
  if (std::abs(wanted - target) <= 0.5 * digit(decimals) * deg * (1 + 1e-6)) {
    const double position = turn_target(turning, written, from, offset).position;
    if (std::abs(position - wanted) < kSameWay) return {written, position, false};
  }
  TurnWord word;
  word.number = spelled(turning, written, target, wanted, decimals);
  word.position = turn_target(turning, word.number, from, offset).position;
  const double off = std::abs(word.position - wanted);
  word.clamped = off > digit(decimals) * deg;
  if (off < kSameWay) return word;
  // The other way round, or once more around: the end as it was, or the axis stays where it is.
  word.clamped = true;
  word.number = written;
  word.position = turn_target(turning, written, from, offset).position;
  if (std::abs(word.position - target) < kSameWay && std::abs(wanted - target) < kSameWay) return word;
  word.number = spelled(turning, written, target, from, decimals);
  word.position = turn_target(turning, word.number, from, offset).position;
  return word;
}

}  // namespace abbe
