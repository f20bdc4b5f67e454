#include "abbe/volume/statistics.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

/// Relative extent across a line below which points count as lying on it.
constexpr double kOnALine = 1e-9;

template <class Accept>
std::size_t first(const std::vector<double>& values, Accept accept) {
  return static_cast<std::size_t>(std::find_if(values.begin(), values.end(), accept) - values.begin());
}

}  // namespace

double percentile(std::vector<double> values, double part) {
  if (values.empty()) return 0;
  const double n = static_cast<double>(values.size());
  // The slack keeps 0.95 * 20 at 19: 0.95 is no double.
  const auto rank = static_cast<std::size_t>(std::clamp(std::ceil(part * n * (1 - 1e-12)), 1.0, n));
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

Amount amount_of(const std::vector<double>& values) {
  const Spread spread = spread_of(values);
  return {spread.max, spread.rms, spread.mean, spread.percentile95, spread.at_max};
}

Spread spread_of(const std::vector<double>& values) {
  Spread spread;
  if (values.empty()) return spread;
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  spread.min = *least;
  spread.max = *most;
  spread.at_min = first(values, [&](double v) { return v <= spread.min + kSameValue; });
  spread.at_max = first(values, [&](double v) { return v >= spread.max - kSameValue; });
  std::vector<double> magnitudes(values.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += values[i];
    squares += values[i] * values[i];
    magnitudes[i] = std::abs(values[i]);
  }
  const double n = static_cast<double>(values.size());
  spread.mean = sum / n;
  spread.rms = std::sqrt(squares / n);
  spread.percentile95 = percentile(std::move(magnitudes), kPercentile);
  return spread;
}

Alignment best_fit(const DeviationField& field) {
  Alignment fit;
  if (field.nominal.empty()) return fit;
  const double n = static_cast<double>(field.nominal.size());
  for (std::size_t i = 0; i < field.nominal.size(); ++i) {
    fit.centre += field.nominal[i] / n;
    fit.t += field.deviation[i] / n;
  }
  // sum (|r|^2 I - r r^T) w = sum r x d,  r = p - centre
  Mat3 inertia = Mat3::Zero();
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = 0; i < field.nominal.size(); ++i) {
    const Vec3 r = field.nominal[i] - fit.centre;
    inertia += r.squaredNorm() * Mat3::Identity() - r * r.transpose();
    moment += r.cross(field.deviation[i] - fit.t);
  }
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  const double largest = solver.eigenvalues().maxCoeff();
  for (int k = 0; k < 3; ++k) {
    const double value = solver.eigenvalues()[k];
    if (!(value > kOnALine * largest)) continue;
    const Vec3 axis = solver.eigenvectors().col(k);
    fit.w += axis * (axis.dot(moment) / value);
  }
  return fit;
}

VolumetricAccuracy volumetric_accuracy(const DeviationField& field, const Alignment& alignment) {
  VolumetricAccuracy v;
  if (field.deviation.empty()) return v;
  Vec3 d_lo = field.deviation[0] - alignment.at(field.nominal[0]), d_hi = d_lo;
  Vec3 e_lo = field.rotation[0], e_hi = e_lo;
  for (std::size_t i = 1; i < field.deviation.size(); ++i) {
    const Vec3 d = field.deviation[i] - alignment.at(field.nominal[i]);
    d_lo = d_lo.cwiseMin(d);
    d_hi = d_hi.cwiseMax(d);
    e_lo = e_lo.cwiseMin(field.rotation[i]);
    e_hi = e_hi.cwiseMax(field.rotation[i]);
  }
  v.position = d_hi - d_lo;
  v.orientation = e_hi - e_lo;
  return v;
}

FieldFigures figures_of(const DeviationField& field, const Alignment& alignment) {
  FieldFigures figures;
  std::vector<double> values(field.deviation.size());
  for (int c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = (field.deviation[i] - alignment.at(field.nominal[i]))[c];
    figures.component[static_cast<std::size_t>(c)] = spread_of(values);
  }
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = (field.deviation[i] - alignment.at(field.nominal[i])).norm();
  figures.length = amount_of(values);
  return figures;
}

}  // namespace abbe
