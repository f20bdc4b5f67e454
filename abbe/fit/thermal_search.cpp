#include "abbe/fit/thermal_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr int kGridLags = 24;

/// x of the normal equations; columns are few, centred and of one kind, so that squaring them costs no digits
/// that matter beside the noise of temperatures.
Eigen::VectorXd normal_solution(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right) {
  return gram.ldlt().solve(right);
}

}  // namespace

ThermalSearch::ThermalSearch(const ThermalColumns& columns, Eigen::Index error)
    : columns_(columns), y_(columns.centred(columns.error(error))), grid_{0} {
  const auto [shortest, longest] = columns.lag_range();
  for (int i = 0; i < kGridLags; ++i)
    grid_.push_back(shortest * std::pow(longest / shortest, static_cast<double>(i) / (kGridLags - 1)));
}

const Eigen::VectorXd& ThermalSearch::column(const ThermalInput& input) {
  const auto key = std::pair(input.sensor, input.lag);
  const auto found = cache_.find(key);
  if (found != cache_.end()) return found->second;
  return cache_.emplace(key, columns_.centred(columns_.temperature(input))).first->second;
}

double ThermalSearch::left(const std::vector<ThermalInput>& inputs) {
  const LogFreedom freedom = columns_.freedom(inputs);
  const Eigen::VectorXd y = freedom.taken_off(y_);
  const Eigen::MatrixXd A = told(inputs, freedom);
  const Eigen::VectorXd right = A.transpose() * y;
  return inputs.empty() ? y.squaredNorm()
                        : y.squaredNorm() - right.dot(normal_solution(A.transpose() * A, right));
}

Eigen::MatrixXd ThermalSearch::told(const std::vector<ThermalInput>& inputs, const LogFreedom& freedom) {
  Eigen::MatrixXd A(columns_.rows(), static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i)
    A.col(static_cast<Eigen::Index>(i)) = freedom.told(column(inputs[i]));
  return A;
}

double ThermalSearch::crossed(const std::vector<ThermalInput>& inputs, const LogFreedom& freedom) {
  // Columns: inputs, then one zero per log; every log has two blocks or more, so that all stay determined.
  const auto blocks = columns_.blocks();
  const auto n = static_cast<Eigen::Index>(inputs.size()), logs = static_cast<Eigen::Index>(columns_.logs());
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(columns_.rows(), n + logs);
  X.leftCols(n) = told(inputs, freedom);
  const Eigen::VectorXd y = freedom.taken_off(y_);
  for (Eigen::Index c = 0; c < logs; ++c) X.col(n + c) = columns_.indicator(static_cast<std::size_t>(c));
  const Eigen::MatrixXd gram = X.transpose() * X;
  const Eigen::VectorXd right = X.transpose() * y;
  double sum = 0;
  for (const auto& [begin, end] : blocks) {
    const auto part = X.middleRows(begin, end - begin);
    const auto values = y.segment(begin, end - begin);
    const Eigen::VectorXd x =
        normal_solution(gram - part.transpose() * part, right - part.transpose() * values);
    sum += (values - part * x).squaredNorm();
  }
  return sum / static_cast<double>(columns_.rows());
}

double ThermalSearch::left_with(std::vector<ThermalInput>& inputs, std::size_t i, double lag) {
  inputs[i].lag = lag;
  return left(inputs);
}

bool ThermalSearch::move_to_best_of_grid(std::vector<ThermalInput>& inputs, std::size_t i) {
  const double before = inputs[i].lag;
  double best = before, least = left(inputs);
  for (const double lag : grid_)
    if (const double value = left_with(inputs, i, lag); value < least) {
      least = value;
      best = lag;
    }
  inputs[i].lag = best;
  return best != before;
}

/// Golden section on the logarithm between the neighbours on the grid; lags are whole seconds in the end.
void ThermalSearch::refine(std::vector<ThermalInput>& inputs, std::size_t i) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSteps = 20;
  if (!(inputs[i].lag > 0)) return;
  const double step = std::log(grid_[2] / grid_[1]), middle = std::log(inputs[i].lag);
  double lo = middle - step, hi = middle + step;
  double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo);
  double at_a = left_with(inputs, i, std::exp(a)), at_b = left_with(inputs, i, std::exp(b));
  for (int k = 0; k < kSteps; ++k) {
    if (at_a < at_b) {
      hi = b;
      b = a;
      at_b = at_a;
      at_a = left_with(inputs, i, std::exp(a = hi - kGolden * (hi - lo)));
    } else {
      lo = a;
      a = b;
      at_a = at_b;
      at_b = left_with(inputs, i, std::exp(b = lo + kGolden * (hi - lo)));
    }
  }
  inputs[i].lag = std::max(1.0, std::round(std::exp((lo + hi) / 2)));
}

std::vector<ThermalInput> ThermalSearch::with_lags(std::vector<ThermalInput> inputs) {
  constexpr int kPasses = 4;
  bool moved = true;
  for (int pass = 0; pass < kPasses && moved; ++pass) {
    moved = false;
    for (std::size_t i = 0; i < inputs.size(); ++i) moved = move_to_best_of_grid(inputs, i) || moved;
  }
  for (int pass = 0; pass < 2; ++pass)
    for (std::size_t i = 0; i < inputs.size(); ++i) refine(inputs, i);
  // What refinement tried will not be asked again.
  std::erase_if(cache_, [&](const auto& entry) {
    return std::find(grid_.begin(), grid_.end(), entry.first.second) == grid_.end();
  });
  return inputs;
}

std::vector<ThermalInput> ThermalSearch::stepwise(const std::vector<std::size_t>& candidates, int most,
                                                  bool lags) {
  std::vector<ThermalInput> chosen;
  double least = crossed(chosen);
  while (static_cast<int>(chosen.size()) < most) {
    std::vector<ThermalInput> best;
    double best_value = kWorthIt * least;
    for (const std::size_t candidate : candidates) {
      const bool known = std::any_of(chosen.begin(), chosen.end(),
                                     [&](const ThermalInput& input) { return input.sensor == candidate; });
      if (known) continue;
      std::vector<ThermalInput> tried = chosen;
      tried.push_back({candidate, 0});
      if (lags) tried = with_lags(std::move(tried));
      const LogFreedom freedom = columns_.freedom(tried);
      const double value = crossed(tried, freedom);
      if (!(value < best_value)) continue;
      const std::vector<ThermalInput> without(tried.begin(), tried.end() - 1);
      if (!(value < kWorthIt * crossed(without, freedom))) continue;
      best_value = value;
      best = std::move(tried);
    }
    if (best.empty()) break;
    chosen = std::move(best);
    least = best_value;
  }
  return chosen;
}

std::vector<std::size_t> ThermalSearch::best_of(const std::vector<std::vector<std::size_t>>& groups,
                                                bool lags) {
  std::vector<std::size_t> out;
  for (const std::vector<std::size_t>& group : groups) {
    std::size_t best = group.front();
    double least = y_.squaredNorm();
    for (const std::size_t sensor : group) {
      std::vector<ThermalInput> alone = {{sensor, 0}};
      if (lags)
        alone = with_lags(std::move(alone));  // between the lags of the grid another one may seem best
      const double value = left(alone);
      if (!(value < least)) continue;
      least = value;
      best = sensor;
    }
    out.push_back(best);
  }
  return out;
}

}  // namespace abbe
