#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

#include "abbe/fit/thermal_columns.h"

namespace abbe {

/// Looks for the inputs that explain one error's course. Zeros of the logs, and their starts as far as a lag
/// remembers them (LogFreedom), belong to the logs: what is compared is what they leave.
class ThermalSearch {
 public:
  ThermalSearch(const ThermalColumns& columns, Eigen::Index error);

  /// Sum of squares that the best slopes leave.
  double left(const std::vector<ThermalInput>& inputs);
  /// Mean square of every block predicted by slopes and zeros of the rows outside it; the starts of all rows.
  double crossed(const std::vector<ThermalInput>& inputs) {
    return crossed(inputs, columns_.freedom(inputs));
  }
  /// The same where the logs have this freedom, to compare models without and with an input: its starts alone
  /// explain something too.
  double crossed(const std::vector<ThermalInput>& inputs, const LogFreedom& freedom);

  /// The same inputs with the lags that leave least.
  std::vector<ThermalInput> with_lags(std::vector<ThermalInput> inputs);
  /// Inputs added one by one from `candidates`, as long as each takes a tenth of the cross-validated square.
  std::vector<ThermalInput> stepwise(const std::vector<std::size_t>& candidates, int most, bool lags);
  /// Of each group the member that leaves least by itself.
  std::vector<std::size_t> best_of(const std::vector<std::vector<std::size_t>>& groups, bool lags);

 private:
  const Eigen::VectorXd& column(const ThermalInput& input);
  Eigen::MatrixXd told(const std::vector<ThermalInput>& inputs, const LogFreedom& freedom);
  double left_with(std::vector<ThermalInput>& inputs, std::size_t i, double lag);
  bool move_to_best_of_grid(std::vector<ThermalInput>& inputs, std::size_t i);
  void refine(std::vector<ThermalInput>& inputs, std::size_t i);

  const ThermalColumns& columns_;
  Eigen::VectorXd y_;         ///< each log about its mean
  std::vector<double> grid_;  ///< of lags, 0 first
  std::map<std::pair<std::size_t, double>, Eigen::VectorXd> cache_;
};

/// A model is better than another one if it takes a tenth of its cross-validated square away.
inline constexpr double kWorthIt = 0.9;

}  // namespace abbe
