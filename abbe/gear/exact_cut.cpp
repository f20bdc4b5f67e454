#include "abbe/gear/exact_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kFarthest = 1;       // mm along the line
constexpr double kOnSurface = 1e-11;  // mm
constexpr double kBracket = 1e-3;     // of the wheel's reach and radius: first step of the search over t
constexpr int kMostSteps = 60;

/// The wheel's radius at an axial place, from the flank it was made for: xi with w(xi) = w by secants.
class WheelSurface {
 public:
  WheelSurface(const Gear& gear, const WheelInGap& wheel, Flank flank, double roll)
      : gear_(gear), wheel_(wheel), flank_(flank), roll_(roll) {}

  [[nodiscard]] std::optional<double> radius(double axial) {
    const double step = 1e-4;
    double a = roll_, b = roll_ + step;
    std::optional<WheelContact> at_a = wheel_contact(gear_, wheel_, flank_, a);
    std::optional<WheelContact> at_b = wheel_contact(gear_, wheel_, flank_, b);
    for (int i = 0; i < kMostSteps && at_a && at_b; ++i) {
      const double difference = at_b->axial - at_a->axial;
      if (std::abs(at_b->axial - axial) < kOnSurface || difference == 0) {
        roll_ = b;
        return at_b->radius;
      }
      const double next = b - (at_b->axial - axial) * (b - a) / difference;
      a = b;
      at_a = at_b;
      b = next;
      if (!(b > 0)) return std::nullopt;
      at_b = wheel_contact(gear_, wheel_, flank_, b);
    }
    return std::nullopt;
  }

 private:
  const Gear& gear_;
  const WheelInGap& wheel_;
  Flank flank_;
  double roll_;
};

/// Where the line through the design point leaves the wheel at height t.
class Line {
 public:
  Line(const Gear& gear, const WheelInGap& wheel, const WheelDeviations& deviations, std::size_t gap,
       Flank flank, double roll, double z)
      : gear_(gear),
        wheel_(wheel),
        deviations_(deviations),
        gap_(gap),
        point_(flank_point(gear, flank, roll, z, Modified::all)),
        surface_(gear, wheel, flank, roll) {}

  [[nodiscard]] std::optional<double> meets(double t) {
    const NodeWeights w = node_weights(deviations_, t);
    Twist twist;
    for (std::size_t k = 0; k < w.weight.size(); ++k) {
      twist.d += w.weight[k] * deviations_.of(gap_, w.first + k).d;
      twist.e += w.weight[k] * deviations_.of(gap_, w.first + k).e;
    }
    twist.d.x() += crowning_infeed(gear_, wheel_, t);
    const double angle = twist.e.norm();
    const Eigen::Quaterniond turned(angle > 0 ? Eigen::AngleAxisd(angle, Vec3(twist.e / angle))
                                              : Eigen::AngleAxisd::Identity());
    const Eigen::AngleAxisd to_gap(-gear_.turn_per_mm * t, Vec3::UnitZ());
    // From the gear to the wheel: turn back by the helix, go down, undo the displacement, look from the
    // centre.
    const Vec3 centre = Vec3(wheel_.centre_distance, 0, 0) + twist.d;
    const Vec3 from = turned.conjugate() * (to_gap * Vec3(point_.position - Vec3(0, 0, t)) - centre);
    const Vec3 along = turned.conjugate() * (to_gap * point_.tangent);
    return root(from, along);
  }

 private:
  /// F(s) = rho(from + s along) - profile radius, by secants.
  [[nodiscard]] std::optional<double> root(const Vec3& from, const Vec3& along) {
    const auto excess = [&](double s) -> std::optional<double> {
      const Vec3 p = from + s * along;
      const double axial = wheel_.axis.dot(p);
      const std::optional<double> radius = surface_.radius(axial);
      if (!radius) return std::nullopt;
      return (p - axial * wheel_.axis).norm() - *radius;
    };
    double a = 0, b = 1e-3;
    std::optional<double> at_a = excess(a), at_b = excess(b);
    for (int i = 0; i < kMostSteps && at_a && at_b; ++i) {
      if (std::abs(*at_b) < kOnSurface || *at_a == *at_b) return b;
      const double next = b - *at_b * (b - a) / (*at_b - *at_a);
      a = b;
      at_a = at_b;
      b = next;
      if (!(std::abs(b) < kFarthest)) return std::nullopt;
      at_b = excess(b);
    }
    return std::nullopt;
  }

  const Gear& gear_;
  const WheelInGap& wheel_;
  const WheelDeviations& deviations_;
  std::size_t gap_;
  FlankPoint point_;
  WheelSurface surface_;
};

}  // namespace

std::optional<double> cut_exactly(const Gear& gear, const WheelInGap& wheel,
                                  const WheelDeviations& deviations, std::size_t gap, Flank flank,
                                  double roll, double z) {
  const std::optional<WheelContact> contact = wheel_contact(gear, wheel, flank, roll);
  if (!contact) return std::nullopt;
  Line line(gear, wheel, deviations, gap, flank, roll, z);
  // s(t) is a parabola about its minimum, near the nominal contact: three points, again and again.
  double middle = z - contact->z, step = kBracket * wheel.centre_distance;
  std::optional<double> least;
  for (int pass = 0; pass < 8; ++pass, step *= 0.5) {
    const std::optional<double> a = line.meets(middle - step), b = line.meets(middle),
                                c = line.meets(middle + step);
    if (!a || !b || !c) return std::nullopt;
    least = least ? std::min(*least, *b) : *b;
    const double bend = *a - 2 * *b + *c;
    if (!(bend > 0)) return std::nullopt;
    middle += std::clamp(0.5 * step * (*a - *c) / bend, -step, step);
  }
  const std::optional<double> last = line.meets(middle);
  if (!last) return std::nullopt;
  return std::min(*least, *last);
}

std::optional<double> second_order(const Gear& gear, const WheelInGap& wheel,
                                   const WheelDeviations& deviations) {
  constexpr std::size_t kGaps = 3;
  const auto teeth = static_cast<std::size_t>(gear.spec.teeth);
  const double near_tip = gear.form_roll + 0.95 * (gear.tip_roll - gear.form_roll);
  double most = 0;
  for (std::size_t k = 0; k < kGaps; ++k)
    for (const Flank flank : {Flank::right, Flank::left})
      for (const double roll : {gear.form_roll, gear.reference_roll, near_tip})
        for (const double part : {-0.45, 0.0, 0.45}) {
          const std::size_t gap = k * teeth / kGaps;
          const double z = part * gear.spec.face_width;
          const std::optional<WheelContact> contact = wheel_contact(gear, wheel, flank, roll);
          const std::optional<double> exact = cut_exactly(gear, wheel, deviations, gap, flank, roll, z);
          if (!contact || !exact) return std::nullopt;
          most =
              std::max(most, std::abs(*exact - flank_deviation(gear, wheel, deviations, gap, *contact, z)));
        }
  return most;
}

}  // namespace abbe
