#include "abbe/signal/sine_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace abbe {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kMostIterations = 200;
constexpr double kSettled = 1e-13;  // relative change of the parameters
constexpr double kSameSpacing = 1e-6;

/// The record in the form that is fitted: times from their middle, values scaled to about 1.
struct Record {
  Eigen::VectorXd t, y;
  double middle = 0, scale = 1;
  bool with_offset = true;
  [[nodiscard]] double span() const { return t[t.size() - 1] - t[0]; }
};

/// y = p sin(omega t) + q cos(omega t) + c.
struct Linear {
  double p = 0, q = 0, c = 0, sse = 0;
};

Eigen::MatrixXd columns(const Record& record, double omega) {
  Eigen::MatrixXd a(record.t.size(), record.with_offset ? 3 : 2);
  a.col(0) = (omega * record.t.array()).sin();
  a.col(1) = (omega * record.t.array()).cos();
  if (record.with_offset) a.col(2).setOnes();
  return a;
}

Linear fit_at(const Record& record, double omega) {
  const Eigen::MatrixXd a = columns(record, omega);
  // A column that says what others say (omega near 0) gets the smallest part, not a huge one.
  const Eigen::VectorXd x = a.completeOrthogonalDecomposition().solve(record.y);
  return {x[0], x[1], record.with_offset ? x[2] : 0, (record.y - a * x).squaredNorm()};
}

bool equally_spaced(const Record& record) {
  const double spacing = record.span() / static_cast<double>(record.t.size() - 1);
  for (Eigen::Index i = 1; i < record.t.size(); ++i) {
    if (std::abs(record.t[i] - record.t[i - 1] - spacing) > kSameSpacing * spacing) return false;
  }
  return true;
}

/// Where the periodogram is largest, at multiples of 2 pi / (4 T), by an FFT of the record with zeros behind.
double largest_of_spectrum(const Record& record, double omega_max) {
  const auto n = static_cast<std::size_t>(record.t.size());
  std::size_t length = 1;
  while (length < 4 * n) length *= 2;
  std::vector<double> padded(length);
  const double mean = record.with_offset ? record.y.mean() : 0;
  for (std::size_t i = 0; i < n; ++i) padded[i] = record.y[static_cast<Eigen::Index>(i)] - mean;
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, padded);
  const double spacing = record.span() / static_cast<double>(n - 1);
  const double unit = 2 * kPi / (static_cast<double>(length) * spacing);
  std::size_t best = 1;
  for (std::size_t k = 1; k <= length / 2 && static_cast<double>(k) * unit <= omega_max; ++k) {
    if (std::norm(spectrum[k]) > std::norm(spectrum[best])) best = k;
  }
  return static_cast<double>(best) * unit;
}

/// The best of `count` frequencies between two.
double best_of_grid(const Record& record, double from, double to, int count) {
  double best = from, least = -1;
  for (int i = 0; i < count; ++i) {
    const double omega = from + (to - from) * i / (count - 1);
    const double sse = fit_at(record, omega).sse;
    if (least < 0 || sse < least) {
      least = sse;
      best = omega;
    }
  }
  return best;
}

double start_omega(const Record& record, double omega_max) {
  constexpr int kFine = 65, kCoarsePerUnit = 4;
  const double unit = 2 * kPi / record.span();  // one period in the record
  double coarse = 0;
  if (equally_spaced(record)) {
    coarse = largest_of_spectrum(record, omega_max);
  } else {
    const double steps = std::clamp(kCoarsePerUnit * omega_max / unit, 8.0, 4e5);
    coarse = best_of_grid(record, unit / kCoarsePerUnit, omega_max, static_cast<int>(steps));
  }
  return best_of_grid(record, std::max(unit / 8, coarse - unit), coarse + unit, kFine);
}

/// Gauss-Newton on (p, q, c, omega); a step that does not help is halved.
struct Iterated {
  Linear linear;
  double omega = 0;
  int iterations = 0;
  bool settled = false;
  Eigen::MatrixXd jacobian;
};

Iterated iterate(const Record& record, double omega) {
  Iterated state;
  state.omega = omega;
  state.linear = fit_at(record, omega);
  const Eigen::Index linear_columns = record.with_offset ? 3 : 2;
  for (; state.iterations < kMostIterations && !state.settled; ++state.iterations) {
    const Linear& at = state.linear;
    state.jacobian.resize(record.t.size(), linear_columns + 1);
    state.jacobian.leftCols(linear_columns) = columns(record, state.omega);
    // d y / d omega = t (p cos(omega t) - q sin(omega t))
    state.jacobian.col(linear_columns) =
        record.t.array() * (at.p * state.jacobian.col(1).array() - at.q * state.jacobian.col(0).array());
    const Eigen::VectorXd f = at.p * state.jacobian.col(0) + at.q * state.jacobian.col(1) +
                              Eigen::VectorXd::Constant(record.t.size(), at.c);
    const Eigen::VectorXd step = state.jacobian.colPivHouseholderQr().solve(record.y - f);
    double change = step[linear_columns];
    if (!std::isfinite(change)) break;
    change = std::clamp(change, -0.5 * state.omega, 0.5 * state.omega);
    state.settled = std::abs(change) <= kSettled * state.omega;
    // Given omega the rest is linear: only omega has to be searched.
    for (int halving = 0; halving < 40; ++halving, change /= 2) {
      const Linear next = fit_at(record, state.omega + change);
      if (next.sse <= state.linear.sse) {
        state.linear = next;
        state.omega += change;
        break;
      }
      // No step helps any more: at the bottom but for rounding.
      if (std::abs(change) <= 1e-9 * state.omega) {
        state.settled = true;
        break;
      }
    }
  }
  return state;
}

/// Covariance of (p, q, c, omega) = s^2 (J^T J)^-1 carried to (A, phi): A = hypot(p, q), phi = atan2(q, p).
/// The phase counts from t = 0, the fit from the middle of the record, so omega enters phi.
Sine uncertainty_of(const Record& record, const Iterated& state) {
  const Eigen::Index m = state.jacobian.cols(), n = record.t.size();
  Sine u;
  if (n <= m) return u;
  const double variance = state.linear.sse / static_cast<double>(n - m);
  const Eigen::MatrixXd gram = state.jacobian.transpose() * state.jacobian;
  const Eigen::LDLT<Eigen::MatrixXd> factor(gram);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return u;
  const Eigen::MatrixXd covariance = variance * factor.solve(Eigen::MatrixXd::Identity(m, m));
  const double p = state.linear.p, q = state.linear.q, squares = p * p + q * q,
               amplitude = std::sqrt(squares);
  const auto spread = [&](const Eigen::VectorXd& gradient) {
    return std::sqrt(std::max(0.0, gradient.dot(covariance * gradient)));
  };
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(m);
  gradient.head(2) << p / amplitude, q / amplitude;
  u.amplitude = spread(gradient) * record.scale;
  gradient.head(2) << -q / squares, p / squares;
  gradient[m - 1] = -record.middle;
  u.phase = spread(gradient);
  u.omega = spread(Eigen::VectorXd::Unit(m, m - 1));
  if (record.with_offset) u.offset = spread(Eigen::VectorXd::Unit(m, 2)) * record.scale;
  return u;
}

/// Into (-pi, pi].
double wrapped(double angle) {
  const double w = std::remainder(angle, 2 * kPi);
  return w <= -kPi ? w + 2 * kPi : w;
}

SignalResult<Record> make_record(std::span<const double> t, std::span<const double> y, bool with_offset) {
  if (t.size() != y.size()) return SignalProblem::sizes_differ;
  if (t.size() < 5) return SignalProblem::too_short;
  if (!all_finite(t) || !all_finite(y)) return SignalProblem::not_finite;
  const auto falls = [](double a, double b) { return !(a < b); };
  if (std::adjacent_find(t.begin(), t.end(), falls) != t.end()) return SignalProblem::not_increasing;
  Record record;
  const auto n = static_cast<Eigen::Index>(t.size());
  record.with_offset = with_offset;
  record.t = Eigen::Map<const Eigen::VectorXd>(t.data(), n);
  record.y = Eigen::Map<const Eigen::VectorXd>(y.data(), n);
  const auto [low, high] = std::minmax_element(y.begin(), y.end());
  if (*low == *high) return SignalProblem::constant;
  record.scale = record.y.cwiseAbs().maxCoeff();
  record.y /= record.scale;
  record.middle = (t.front() + t.back()) / 2;
  record.t.array() -= record.middle;
  return record;
}

}  // namespace

double Sine::at(double t) const { return amplitude * std::sin(omega * t + phase) + offset; }

SignalResult<SineFit> fit_sine(std::span<const double> t, std::span<const double> y,
                               const SineOptions& options) {
  const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
  if ((options.omega_start && !positive(*options.omega_start)) || options.omega_max < 0 ||
      !std::isfinite(options.omega_max)) {
    return SignalProblem::bad_option;
  }
  SignalResult<Record> made = make_record(t, y, options.with_offset);
  if (const auto* problem = std::get_if<SignalProblem>(&made)) return *problem;
  const Record& record = std::get<Record>(made);
  const double half_rate = kPi * static_cast<double>(record.t.size() - 1) / record.span();
  const double omega_max = options.omega_max > 0 ? options.omega_max : half_rate;
  const Iterated state =
      iterate(record, options.omega_start ? *options.omega_start : start_omega(record, omega_max));
  const Linear& fit = state.linear;
  if (!state.settled || !(state.omega > 0) || !std::isfinite(fit.sse)) return SignalProblem::not_converged;
  if (fit.p == 0 && fit.q == 0) return SignalProblem::constant;

  SineFit result;
  // p sin(w t') + q cos(w t') = A sin(w t' + psi) with t' = t - middle
  result.sine.amplitude = std::hypot(fit.p, fit.q) * record.scale;
  result.sine.omega = state.omega;
  result.sine.phase = wrapped(std::atan2(fit.q, fit.p) - state.omega * record.middle);
  result.sine.offset = fit.c * record.scale;
  result.uncertainty = uncertainty_of(record, state);
  result.sse = fit.sse * record.scale * record.scale;
  result.iterations = state.iterations;
  const double numbers[] = {result.sine.amplitude, result.sine.omega, result.sine.phase, result.sine.offset,
                            result.sse};
  if (!all_finite(numbers)) return SignalProblem::not_finite;
  return result;
}

}  // namespace abbe
