#include "abbe/gear/flank_tolerances.h"

#include <cmath>

namespace abbe {
namespace {

constexpr int kBestClass = 1, kWorstClass = 11;

bool within(double value, double low, double high) { return value >= low && value <= high; }

}  // namespace

std::optional<FlankTolerances> flank_tolerances(const Gear& gear, int tolerance_class) {
  const double d = 2 * gear.reference_radius, m = gear.spec.module, b = gear.spec.face_width;
  const bool covered = within(tolerance_class, kBestClass, kWorstClass) && within(gear.spec.teeth, 5, 1000) &&
                       within(d, 5, 15000) && within(m, 0.5, 70) && within(b, 4, 1200) &&
                       within(gear.spec.helix_angle, 0, 45 * deg);
  if (!covered) return std::nullopt;
  const double g = std::pow(2.0, 0.5 * (tolerance_class - 5)) * um;
  FlankTolerances t;
  t.f_p = (0.001 * d + 0.4 * m + 5) * g;
  t.F_p = (0.002 * d + 0.55 * std::sqrt(d) + 0.7 * m + 12) * g;
  t.f_H_alpha = (0.4 * m + 0.001 * d + 4) * g;
  t.f_f_alpha = (0.55 * m + 5) * g;
  t.F_alpha = std::hypot(t.f_H_alpha, t.f_f_alpha);
  t.f_H_beta = (0.05 * std::sqrt(d) + 0.35 * std::sqrt(b) + 4) * g;
  t.f_f_beta = (0.07 * std::sqrt(d) + 0.45 * std::sqrt(b) + 4) * g;
  t.F_beta = std::hypot(t.f_H_beta, t.f_f_beta);
  t.F_r = 0.9 * t.F_p;
  return t;
}

double rounded_tolerance(double tolerance) {
  const double value = tolerance / um;
  const double step = value > 10 ? 1.0 : value >= 5 ? 0.5 : 0.1;
  return std::round(value / step) * step * um;
}

std::optional<int> class_of(const Gear& gear, double FlankTolerances::*which, double deviation) {
  for (int a = kBestClass; a <= kWorstClass; ++a) {
    const std::optional<FlankTolerances> tolerances = flank_tolerances(gear, a);
    if (!tolerances) return std::nullopt;
    // A picometre for the rounding of the product above.
    if (std::abs(deviation) <= rounded_tolerance((*tolerances).*which) + 1e-9) return a;
  }
  return std::nullopt;
}

}  // namespace abbe
