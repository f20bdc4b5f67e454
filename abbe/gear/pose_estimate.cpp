#include "abbe/gear/pose_estimate.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "abbe/core/least_squares.h"

namespace abbe {
namespace {

constexpr double kInvisible = 1e-7;     // singular value, of the largest
constexpr double kHardlyTold = 5 * um;  // standard uncertainty of a combination that is left at zero
constexpr double kBeyond = 0.01;  // of a flank's length and width: so far beyond its ends a point counts
using Row = Eigen::Matrix<double, 1, kPoseUnknowns>;

/// A point as an equation: row . unknowns = value. Rotations count as displacements at the reference radius.
struct Equation {
  Row row = Row::Zero();
  double value = 0;
  int trace = -1;
};

/// What each unknown does at a place, in the axes of the gap.
Eigen::Matrix<double, 6, kPoseUnknowns> effects_at(const GearJob& job, const WheelInGap& wheel,
                                                   std::size_t gap, double height) {
  Eigen::Matrix<double, 6, kPoseUnknowns> out;
  const Mat3 back = gap_axes(job, gap, height).transpose();
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    PoseValues unit{};
    unit[i] = pose_unknown(i).direction >= 3 ? 1 / job.gear.reference_radius : 1.0;
    const RelativeDeviation relative = relative_deviation_at(job, wheel, unit, gap, height);
    out.col(static_cast<Eigen::Index>(i)) << back * relative.position, back * relative.rotation;
  }
  return out;
}

std::optional<Equation> equation_of(const GearJob& job, const WheelInGap& wheel,
                                    const WheelDeviations& nothing, const MeasuredFlankPoint& point) {
  const Gear& gear = job.gear;
  const double beyond = kBeyond * (gear.tip_roll - gear.form_roll);
  const bool exists = point.tooth >= 1 && point.tooth <= gear.spec.teeth && std::isfinite(point.deviation) &&
                      std::abs(point.z) <= (0.5 + kBeyond) * gear.spec.face_width &&
                      point.roll >= gear.form_roll - beyond && point.roll <= gear.tip_roll + beyond;
  if (!exists) return std::nullopt;
  const std::optional<WheelContact> contact = wheel_contact(job.gear, wheel, point.flank, point.roll);
  if (!contact) return std::nullopt;
  const std::size_t gap = gap_of(job.gear, point.tooth - 1, point.flank);
  Equation equation;
  equation.row = contact->influence.transpose() * effects_at(job, wheel, gap, point.z - contact->z);
  // Without deviations the process leaves its own.
  equation.value = point.deviation - flank_deviation(job.gear, wheel, nothing, gap, *contact, point.z);
  equation.trace = point.trace;
  return equation;
}

/// Takes the mean of every trace off its equations: what is left does not know the trace's offset. Returns
/// the number of traces.
std::size_t remove_offsets(std::vector<Equation>& equations) {
  struct Mean {
    Row row = Row::Zero();
    double value = 0, count = 0;
  };
  std::map<int, Mean> means;
  for (const Equation& equation : equations) {
    if (equation.trace < 0) continue;
    Mean& mean = means[equation.trace];
    mean.row += equation.row;
    mean.value += equation.value;
    mean.count += 1;
  }
  for (Equation& equation : equations) {
    if (equation.trace < 0) continue;
    const Mean& mean = means[equation.trace];
    equation.row -= mean.row / mean.count;
    equation.value -= mean.value / mean.count;
  }
  return means.size();
}

/// Of an equation; nullopt: neither stated nor told by what is left over.
std::optional<double> variance_of(const LeastSquaresSolution& all, double sigma, std::size_t offsets) {
  if (sigma > 0) return sigma * sigma;
  const Eigen::Index freedom = all.freedom() - static_cast<Eigen::Index>(offsets);
  if (freedom <= 0) return std::nullopt;
  return all.sum_of_squares / static_cast<double>(freedom);
}

/// Of singular values: a combination's uncertainty is the root of the variance over its singular value.
double tolerance_for(const LeastSquaresSolution& all, double variance) {
  const double largest = all.singular_values[0];
  return largest > 0 ? std::max(kInvisible, std::sqrt(variance) / (kHardlyTold * largest)) : kInvisible;
}

double unit_of(const GearJob& job, std::size_t unknown) {
  return pose_unknown(unknown).direction >= 3 ? 1 / job.gear.reference_radius : 1.0;
}

void fill(const GearJob& job, const LeastSquaresSolution& solution, double variance, PoseEstimate& out) {
  out.rank = static_cast<int>(solution.rank);
  for (std::size_t i = 0; i < kPoseUnknowns; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    out.value[i] = solution.x[k] * unit_of(job, i);
    out.uncertainty[i] = std::sqrt(std::max(0.0, solution.cofactor(k, k) * variance)) * unit_of(job, i);
    out.determined[i] = solution.determined[k];
  }
}

}  // namespace

PoseEstimate estimate_pose(const GearJob& job, const WheelInGap& wheel,
                           const std::vector<MeasuredFlankPoint>& points, double sigma) {
  PoseEstimate out;
  const Stroke stroke = stroke_of(job, wheel);
  const WheelDeviations nothing(stroke.low, stroke.high, 4, job.gear.spec.teeth);
  std::vector<Equation> equations;
  for (const MeasuredFlankPoint& point : points)
    if (const auto equation = equation_of(job, wheel, nothing, point)) equations.push_back(*equation);
  out.points = equations.size();
  if (equations.empty()) {
    out.status = PoseEstimate::Status::no_points;
    return out;
  }
  const std::size_t offsets = remove_offsets(equations);
  TriangularFactor factor(kPoseUnknowns);
  for (const Equation& equation : equations) {
    const Eigen::Matrix<double, kPoseUnknowns, 1> row = equation.row;
    factor.add(std::span<const double>(row.data(), kPoseUnknowns), equation.value);
  }
  const LeastSquaresSolution all = solve(factor, {kInvisible, false});
  if (!all.ok()) {
    out.status = PoseEstimate::Status::failed;
    return out;
  }
  const std::optional<double> variance = variance_of(all, sigma, offsets);
  if (!variance) {
    out.status = PoseEstimate::Status::few_points;
    return out;
  }
  const LeastSquaresSolution solution = solve(factor, {tolerance_for(all, *variance), false});
  fill(job, solution, *variance, out);
  for (const Equation& equation : equations) {
    const double rest = equation.value - (equation.row * solution.x)(0);
    out.rms_before += equation.value * equation.value;
    out.rms_after += rest * rest;
    out.largest_after = std::max(out.largest_after, std::abs(rest));
  }
  out.rms_before = std::sqrt(out.rms_before / static_cast<double>(equations.size()));
  out.rms_after = std::sqrt(out.rms_after / static_cast<double>(equations.size()));
  return out;
}

TipAndAxis pose_corrected_for(const GearJob& job, const WheelInGap& wheel, const PoseValues& values,
                              std::size_t gap, double height, const TipAndAxis& nominal) {
  return corrected_pose(nominal, {relative_deviation_at(job, wheel, values, gap, height)});
}

}  // namespace abbe
