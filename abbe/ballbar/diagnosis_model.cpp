#include "abbe/ballbar/diagnosis_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

namespace abbe {
namespace {

using Kind = DiagnosisTerm::Kind;

constexpr double kSeparable = 1e-6;  // relative singular value below which columns are one
constexpr double kDetermined = 1 - 1e-6;
constexpr double kAtRest = 1e-9;  // of sin and cos: the axis is at its reversal
constexpr double kPi = std::numbers::pi;

int sign_of(double x) { return x > kAtRest ? 1 : x < -kAtRest ? -1 : 0; }

}  // namespace

DiagnosisModel::DiagnosisModel(const BallbarTest& test) : test_(&test) {
  columns_ = {{Kind::centre, 0},       {Kind::centre, 1},       {Kind::radius},
              {Kind::scale_mismatch},  {Kind::squareness},      {Kind::servo_mismatch},
              {Kind::backlash, 0},     {Kind::backlash, 1},     {Kind::lateral_play, 0},
              {Kind::lateral_play, 1}, {Kind::straightness, 0}, {Kind::straightness, 1}};
}

void DiagnosisModel::set_cyclic(int axis, double pitch) {
  columns_.push_back({Kind::cyclic_cosine, axis, 0, pitch});
  columns_.push_back({Kind::cyclic_sine, axis, 0, pitch});
}

void DiagnosisModel::set_spikes(double time) {
  if (!spike_time_)
    for (const int axis : {0, 1})
      for (const int end : {+1, -1}) columns_.push_back({Kind::spike, axis, end});
  spike_time_ = time;
}

DiagnosisModel::Sample DiagnosisModel::sample_of(const BallbarRun& run, std::size_t i) {
  Sample sample;
  sample.angle = run.angle[i];
  sample.direction = run.direction;
  sample.u = {std::cos(sample.angle), std::sin(sample.angle)};
  // a' = -s R w sin t,  b' = s R w cos t
  sample.sense = {-run.direction * sign_of(sample.u[1]), run.direction * sign_of(sample.u[0])};
  return sample;
}

double DiagnosisModel::value_of(const Column& column, const Sample& sample) const {
  const double R = test_->radius, v = test_->feed;
  const double c = sample.u[0], s = sample.u[1];
  const auto axis = static_cast<std::size_t>(std::max(column.axis, 0));
  const double along = sample.u[axis], across = sample.u[1 - axis];
  switch (column.kind) {
    case Kind::centre:
      return along;
    case Kind::radius:
      return 1;
    case Kind::scale_mismatch:
      return R / 2 * (c * c - s * s);
    case Kind::squareness:
      return -R * s * c;
    case Kind::servo_mismatch:
      return sample.direction * v * s * c;
    case Kind::backlash:
      return -0.5 * sample.sense[axis] * along;
    case Kind::lateral_play:
      return 0.5 * sample.sense[axis] * across;
    case Kind::straightness:
      return R * R * along * along * across;
    case Kind::cyclic_cosine:
      return std::cos(2 * kPi * R * along / column.pitch) * along;
    case Kind::cyclic_sine:
      return std::sin(2 * kPi * R * along / column.pitch) * along;
    case Kind::spike: {
      const double reversal = column.axis * kPi / 2 + (column.end > 0 ? 0 : kPi);
      double since = std::fmod(sample.direction * (sample.angle - reversal), 2 * kPi);
      if (since < 0) since += 2 * kPi;
      return std::exp(-since * R / (v * *spike_time_));
    }
  }
  return 0;
}

DiagnosisFit DiagnosisModel::fit() const {
  TriangularFactor factor(static_cast<Eigen::Index>(columns_.size()));
  std::vector<double> row(columns_.size());
  // False where an axis reverses: on which side of the step such a sample is, nobody knows.
  const auto fill = [&](const BallbarRun& run, std::size_t i) {
    const Sample sample = sample_of(run, i);
    for (std::size_t k = 0; k < columns_.size(); ++k) row[k] = value_of(columns_[k], sample);
    return sample.sense[0] != 0 && sample.sense[1] != 0;
  };
  for (const BallbarRun& run : test_->runs)
    for (std::size_t i = 0; i < run.angle.size(); ++i)
      if (fill(run, i)) factor.add(row, run.deviation[i]);
  DiagnosisFit out;
  out.solution = solve(factor, {kSeparable, true});
  if (!out.ok()) return out;
  std::vector<std::span<const double>> records;
  out.residual.reserve(test_->runs.size());
  for (const BallbarRun& run : test_->runs) {
    std::vector<double>& residual = out.residual.emplace_back();
    for (std::size_t i = 0; i < run.angle.size(); ++i) {
      const bool sure = fill(run, i);
      const double fitted =
          Eigen::Map<const Eigen::VectorXd>(row.data(), out.solution.x.size()).dot(out.solution.x);
      residual.push_back(sure ? run.deviation[i] - fitted : 0.0);
    }
    records.emplace_back(residual);
  }
  out.summary = summary_of_residuals(records);
  return out;
}

std::string DiagnosisModel::axis_name(const Column& column) const {
  if (column.axis < 0) return {};
  std::string name(1, axis_letter(column.axis == 0 ? test_->plane.first : test_->plane.second));
  if (column.end != 0) name += column.end > 0 ? '+' : '-';
  return name;
}

std::vector<DiagnosisTerm> DiagnosisModel::terms(const DiagnosisFit& fit) const {
  std::vector<DiagnosisTerm> out;
  // u^2 = cofactor sigma^2 tau
  const double variance = fit.variance() * fit.summary.tau;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    DiagnosisTerm term;
    term.kind = columns_[k].kind;
    term.axis = axis_name(columns_[k]);
    term.separable = fit.solution.determined[i] >= kDetermined;
    term.value = fit.solution.x[i];
    if (term.separable) term.uncertainty = std::sqrt(std::max(0.0, fit.solution.cofactor(i, i) * variance));
    for (const BallbarRun& run : test_->runs)
      for (std::size_t j = 0; j < run.angle.size(); ++j)
        term.effect = std::max(term.effect, std::abs(term.value * value_of(columns_[k], sample_of(run, j))));
    out.push_back(std::move(term));
  }
  return out;
}

double DiagnosisModel::harmonic_only_servo() const {
  double product = 0, square = 0;
  for (const BallbarRun& run : test_->runs) {
    for (std::size_t i = 0; i < run.angle.size(); ++i) {
      const double column = value_of({Kind::servo_mismatch}, sample_of(run, i));
      product += column * run.deviation[i];
      square += column * column;
    }
  }
  return square > 0 ? product / square : 0.0;
}

}  // namespace abbe
