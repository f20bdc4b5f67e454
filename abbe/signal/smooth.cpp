#include "abbe/signal/smooth.h"

#include <Eigen/Dense>
#include <cmath>

namespace abbe {
namespace {

constexpr int kMostPasses = 10000;
constexpr int kMostWindow = 1001;
constexpr int kMostOrder = 10;

void smooth_once(const Samples& y, Samples& out) {
  const std::size_t n = y.size();
  const auto end = [n](std::size_t i) { return n - 1 - i; };
  // The last two are the first two of the record read backwards.
  const auto ends = [&](auto&& y_at, auto&& place) {
    out[place(0)] = (69 * y_at(0) + 4 * y_at(1) - 6 * y_at(2) + 4 * y_at(3) - y_at(4)) / 70;
    out[place(1)] = (2 * y_at(0) + 27 * y_at(1) + 12 * y_at(2) - 8 * y_at(3) + 2 * y_at(4)) / 35;
  };
  ends([&](std::size_t i) { return y[i]; }, [](std::size_t i) { return i; });
  ends([&](std::size_t i) { return y[end(i)]; }, end);
  for (std::size_t i = 2; i + 2 < n; ++i) {
    out[i] = (-3 * (y[i - 2] + y[i + 2]) + 12 * (y[i - 1] + y[i + 1]) + 17 * y[i]) / 35;
  }
}

/// Row `at` of the returned matrix weighs the samples of a window so that the fitted polynomial's derivative
/// at sample `at` of the window comes out: with u = (i - h) / h in [-1, 1] and V_ij = u_i^j,
///   weights = D (V^T V)^-1 V^T,   D_aj = d^k/du^k u_a^j,   from the QR of V.
Eigen::MatrixXd window_weights(int window, int order, int derivative, double spacing) {
  const int h = window / 2;
  const double scale = h > 0 ? h : 1;
  Eigen::MatrixXd v(window, order + 1), d(window, order + 1);
  for (int i = 0; i < window; ++i) {
    const double u = (i - h) / scale;
    for (int j = 0; j <= order; ++j) {
      v(i, j) = std::pow(u, j);
      double factor = 1;
      for (int k = 0; k < derivative; ++k) factor *= j - k;
      d(i, j) = j < derivative ? 0 : factor * std::pow(u, j - derivative);
    }
  }
  const Eigen::MatrixXd fit = v.householderQr().solve(Eigen::MatrixXd::Identity(window, window));
  return d * fit / std::pow(scale * spacing, derivative);
}

}  // namespace

SignalResult<Samples> five_point_smooth(std::span<const double> y, int passes) {
  if (passes < 0 || passes > kMostPasses) return SignalProblem::bad_option;
  if (y.size() < 5) return SignalProblem::too_short;
  if (!all_finite(y)) return SignalProblem::not_finite;
  Samples from(y.begin(), y.end()), to(y.size());
  for (int pass = 0; pass < passes; ++pass) {
    smooth_once(from, to);
    from.swap(to);
  }
  return from;
}

SignalResult<Samples> savitzky_golay(std::span<const double> y, const SavitzkyGolay& options) {
  const int window = options.window;
  if (window < 1 || window > kMostWindow || window % 2 == 0 || options.order < 0 ||
      options.order > kMostOrder || options.order >= window || options.derivative < 0 ||
      options.derivative > options.order || !(options.spacing > 0) || !std::isfinite(options.spacing)) {
    return SignalProblem::bad_option;
  }
  if (y.size() < static_cast<std::size_t>(window)) return SignalProblem::too_short;
  if (!all_finite(y)) return SignalProblem::not_finite;

  const Eigen::MatrixXd weights = window_weights(window, options.order, options.derivative, options.spacing);
  const Eigen::Map<const Eigen::VectorXd> record(y.data(), static_cast<Eigen::Index>(y.size()));
  const Eigen::Index n = record.size(), h = window / 2;
  const Eigen::VectorXd middle = weights.row(h);
  Samples out(y.size());
  Eigen::Map<Eigen::VectorXd> result(out.data(), n);
  result.head(h) = weights.topRows(h) * record.head(window);
  result.tail(h) = weights.bottomRows(h) * record.tail(window);
  for (Eigen::Index i = h; i + h < n; ++i) result[i] = middle.dot(record.segment(i - h, window));
  if (!all_finite(out)) return SignalProblem::bad_option;  // a spacing so small that the derivative overflows
  return out;
}

}  // namespace abbe
