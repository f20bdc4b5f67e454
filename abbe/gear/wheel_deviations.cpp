#include "abbe/gear/wheel_deviations.h"

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

double product(const Vec6& influence, const Twist& twist) {
  return influence.head<3>().dot(twist.d) + influence.tail<3>().dot(twist.e);
}

/// What the crowned face of the design has that the wheel's infeed does not make, at one point.
double crowning_rest(const Gear& gear, const WheelInGap& wheel, const WheelContact& contact, double z) {
  if (!(gear.spec.helix_crowning > 0)) return 0;
  return contact.influence[0] * crowning_infeed(gear, wheel, z - contact.z) - helix_modification(gear, z);
}

/// One flank of one gap: rolls by heights.
void fill_flank(const Gear& gear, const WheelInGap& wheel, const WheelDeviations& deviations, std::size_t gap,
                Flank flank, const std::vector<double>& z, std::vector<double>& at_nodes, double* out) {
  for (const WheelContact& contact : wheel.of(flank)) {
    for (std::size_t k = 0; k < deviations.nodes; ++k)
      at_nodes[k] = product(contact.influence, deviations.of(gap, k));
    for (const double height : z) {
      const NodeWeights w = node_weights(deviations, height - contact.z);
      const double* v = at_nodes.data() + w.first;
      *out++ = w.weight[0] * v[0] + w.weight[1] * v[1] + w.weight[2] * v[2] + w.weight[3] * v[3] +
               crowning_rest(gear, wheel, contact, height);
    }
  }
}

}  // namespace

NodeWeights node_weights(const WheelDeviations& deviations, double height) {
  const auto last = static_cast<double>(deviations.nodes - 1);
  const double at =
      std::clamp((height - deviations.low) / (deviations.high - deviations.low) * last, 0.0, last);
  NodeWeights out;
  out.first = static_cast<std::size_t>(std::clamp(std::floor(at) - 1, 0.0, last - 3));
  // Lagrange on 0, 1, 2, 3
  const double u = at - static_cast<double>(out.first), a = u - 1, b = u - 2, c = u - 3;
  out.weight = {-a * b * c / 6, u * b * c / 2, -u * a * c / 2, u * a * b / 6};
  return out;
}

double crowning_infeed(const Gear& gear, const WheelInGap& wheel, double height) {
  if (!(gear.spec.helix_crowning > 0)) return 0;
  const double beyond = gear.spec.face_width / 2 + wheel.reach;
  // c(t) = m(t) / sin phi at the reference cylinder
  const double phi = gear.reference_roll + gear.half_gap - involute_of_roll(gear.reference_roll);
  return helix_modification(gear, std::clamp(height, -beyond, beyond)) / std::sin(phi);
}

double flank_deviation(const Gear& gear, const WheelInGap& wheel, const WheelDeviations& deviations,
                       std::size_t gap, const WheelContact& contact, double z) {
  const NodeWeights w = node_weights(deviations, z - contact.z);
  double f = crowning_rest(gear, wheel, contact, z);
  for (std::size_t k = 0; k < w.weight.size(); ++k)
    f += w.weight[k] * product(contact.influence, deviations.of(gap, w.first + k));
  return f;
}

std::vector<double> flank_field(const Gear& gear, const WheelInGap& wheel, const WheelDeviations& deviations,
                                const std::vector<double>& z, const Progress& progress) {
  const auto gaps = static_cast<std::size_t>(gear.spec.teeth);
  const std::size_t points = wheel.contacts[0].size() * z.size();
  std::vector<double> field(gaps * 2 * points), at_nodes(deviations.nodes);
  for (std::size_t gap = 0; gap < gaps; ++gap) {
    double* const out = field.data() + gap * 2 * points;
    fill_flank(gear, wheel, deviations, gap, Flank::right, z, at_nodes, out);
    fill_flank(gear, wheel, deviations, gap, Flank::left, z, at_nodes, out + points);
    if (progress && !progress(gap + 1, gaps)) return {};
  }
  return field;
}

std::vector<double> even_heights(const Gear& gear, int count) {
  std::vector<double> heights;
  for (int i = 0; i < count; ++i)
    heights.push_back(gear.spec.face_width * (static_cast<double>(i) / std::max(1, count - 1) - 0.5));
  return heights;
}

}  // namespace abbe
