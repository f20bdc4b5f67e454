#include "abbe/part/inspection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/core/least_squares.h"

namespace abbe {
namespace {

constexpr std::uint64_t kReport = 256;  // points between two calls of progress
constexpr double kStands = 1e-10;       // mm, and mm at the farthest point for rotations
constexpr double kTold = 1e-6;          // singular values below this times the largest say nothing

/// A rigid motion of the points: q' = R (q - c) + c + d.
struct Motion {
  Mat3 R = Mat3::Identity();
  Vec3 d = Vec3::Zero();
};

class Fitter {
 public:
  Fitter(const NearestPoint& nominal, const std::vector<TouchedPoint>& touched, double beside,
         std::uint64_t total, const Progress& progress)
      : nominal_(nominal), touched_(touched), beside_(beside), total_(total), progress_(progress) {
    for (const TouchedPoint& point : touched) centre_ += point.measured / static_cast<double>(touched.size());
    for (const TouchedPoint& point : touched) reach_ = std::max(reach_, (point.measured - centre_).norm());
  }

  /// False: `progress` stops it.
  [[nodiscard]] bool judge(Inspection& out) {
    const bool first = out.points.empty();
    out.points.resize(touched_.size());
    for (std::size_t k = 0; k < touched_.size(); ++k) {
      InspectedPoint& point = out.points[k];
      const TouchedPoint& touched = touched_[k];
      point.measured = motion_.R * (touched.measured - centre_) + centre_ + motion_.d;
      const bool known = touched.target.has_value() || !first;
      const SurfacePlace near = first ? touched.target.value_or(SurfacePlace{}) : point.foot.place;
      point.foot = known ? nominal_.from(near, point.measured) : nominal_(point.measured);
      point.linear = point.foot.distance;
      if (touched.target && first)
        point.linear = (point.measured - evaluate(nominal_.surface(), *touched.target).p).norm();
      const double d = point.foot.deviation;
      const double off = std::sqrt(std::max(0.0, point.foot.distance * point.foot.distance - d * d));
      point.used = point.foot.at.is_regular() && (!point.foot.on_rim || off <= beside_);
      ++done_;
      out.stopped = progress_ && done_ % kReport == 0 && !progress_(done_, total_);
      if (out.stopped) return false;
    }
    return true;
  }

  /// One step of the fit; false when it stands.
  bool step(Inspection& out, BestFit fit) {
    const Eigen::Index unknowns = fit == BestFit::rigid ? 6 : 3;
    TriangularFactor factor(unknowns);
    for (const InspectedPoint& point : out.points) {
      if (!point.used) continue;
      // n.d + (q - c)/r x n . (r e) = -d_i: rotations in mm at the farthest point
      // Beside a crease the distance grows away from the foot.
      const SurfaceFoot& foot = point.foot;
      const bool creased = !foot.is_normal && !foot.on_rim;
      const Vec3 n = creased ? Vec3((point.measured - foot.at.p) / foot.deviation) : foot.at.normal;
      const Vec3 lever = (point.measured - centre_ - motion_.d).cross(n) / std::max(reach_, 1e-9);
      const std::array<double, 6> row{n.x(), n.y(), n.z(), lever.x(), lever.y(), lever.z()};
      factor.add(std::span(row).first(static_cast<std::size_t>(unknowns)), -foot.deviation);
    }
    const LeastSquaresSolution solution = solve(factor, {kTold, false});
    if (!solution.ok()) return false;
    out.rank = static_cast<int>(solution.rank);
    motion_.d += Vec3(solution.x.head<3>());
    const Vec3 turn = unknowns == 6 ? Vec3(solution.x.tail<3>() / std::max(reach_, 1e-9)) : Vec3::Zero();
    const double angle = turn.norm();
    if (angle > 0) motion_.R = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * motion_.R;
    return solution.x.norm() > kStands;
  }

  void finish(Inspection& out) const {
    const Eigen::AngleAxisd turn(motion_.R);
    out.shift = motion_.d;
    out.turn = turn.angle() * turn.axis();
  }

 private:
  const NearestPoint& nominal_;
  const std::vector<TouchedPoint>& touched_;
  double beside_;
  Vec3 centre_ = Vec3::Zero();
  double reach_ = 0;
  Motion motion_;
  std::uint64_t done_ = 0, total_ = 0;
  const Progress& progress_;
};

}  // namespace

InspectionFigures figures_of(const std::vector<InspectedPoint>& points) {
  InspectionFigures out;
  double sum = 0, squares = 0, linear = 0;
  for (const InspectedPoint& point : points) {
    if (!point.used) {
      ++out.beside;
      continue;
    }
    const double d = point.foot.deviation;
    if (!point.foot.is_normal && !point.foot.on_rim) ++out.creased;
    out.least = out.count == 0 ? d : std::min(out.least, d);
    out.most = out.count == 0 ? d : std::max(out.most, d);
    out.linear_most = std::max(out.linear_most, point.linear);
    sum += d;
    squares += d * d;
    linear += point.linear;
    ++out.count;
  }
  if (out.count == 0) return out;
  const auto n = static_cast<double>(out.count);
  out.mean = sum / n;
  out.rms = std::sqrt(squares / n);
  out.linear = linear / n;
  out.profile = 2 * std::max(std::abs(out.least), std::abs(out.most));
  out.range = out.most - out.least;
  return out;
}

Inspection inspect_points(const NearestPoint& nominal, const std::vector<TouchedPoint>& points, BestFit fit,
                          double beside, const Progress& progress) {
  Inspection out;
  Fitter fitter(nominal, points, beside, fit == BestFit::none ? points.size() : 0, progress);
  if (!fitter.judge(out)) return out;
  if (fit != BestFit::none && !points.empty()) {
    out.settled = false;
    for (int k = 0; k < kMostFits && !out.settled; ++k) {
      out.settled = !fitter.step(out, fit);
      if (!fitter.judge(out)) return out;
    }
    fitter.finish(out);
  }
  out.figures = figures_of(out.points);
  return out;
}

}  // namespace abbe
