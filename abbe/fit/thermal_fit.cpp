#include "abbe/fit/thermal_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "abbe/fit/ridge.h"
#include "abbe/fit/sensor_groups.h"
#include "abbe/fit/thermal_search.h"

namespace abbe {
namespace {

constexpr double kMisfit = 1.5;        ///< times the noise
constexpr double kMisfitShare = 0.05;  ///< of the drift
constexpr double kPenalties[] = {0, 1e-3, 1e-2, 0.1, 1, 10, 100, 1000};

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(std::max<Eigen::Index>(values.size(), 1)));
}

ThermalColumns columns_of(const std::vector<DriftCourse>& courses, bool validation) {
  std::vector<const DriftCourse*> kind;
  for (const DriftCourse& course : courses)
    if (course.validation == validation) kind.push_back(&course);
  return ThermalColumns(std::move(kind));
}

/// Slopes with their covariance, that of the lags included.
struct Slopes {
  Eigen::VectorXd slope;
  Eigen::MatrixXd covariance;   ///< of slopes, then of the lags above 0
  Eigen::MatrixXd sensitivity;  ///< of the readings to the same, beside zeros and starts
  Eigen::MatrixXd gain;         ///< slopes, then lags, from the readings
  Eigen::VectorXd residual;     ///< of the readings
  double freedom = 1;
  double variance = 0;  ///< of a reading
};

/// A model and where its slopes come from.
struct Modelled {
  ThermalModel model;
  Slopes slopes;
};

/// d (slope T_lagged) / d lag for every lag above 0, by differences of a hundredth of the lag.
Eigen::MatrixXd lag_columns(const ThermalColumns& columns, const std::vector<ThermalInput>& inputs,
                            const Eigen::VectorXd& slope) {
  constexpr double kStep = 0.01;
  Eigen::MatrixXd out(columns.rows(), 0);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const double lag = inputs[i].lag, h = kStep * lag;
    if (!(lag > 0)) continue;
    out.conservativeResize(Eigen::NoChange, out.cols() + 1);
    out.rightCols(1) =
        slope[static_cast<Eigen::Index>(i)] / (2 * h) *
        (columns.temperature({inputs[i].sensor, lag + h}) - columns.temperature({inputs[i].sensor, lag - h}));
  }
  return out;
}

/// Adds what the starts do when a lag moves: d (start exp(-t / lag)) / d lag = start t / lag^2 exp(-t / lag).
void add_starts_to_lag_columns(const LogFreedom& freedom, const std::vector<ThermalInput>& inputs,
                               const ThermalColumns& columns, const Eigen::VectorXd& unexplained,
                               Eigen::MatrixXd& lag_derivatives) {
  for (std::size_t log = 0; log < freedom.logs(); ++log) {
    if (!freedom.is_free(log)) continue;
    const Eigen::VectorXd start = freedom.coefficients(log, unexplained);
    const Eigen::MatrixXd& shape = freedom.shape(log);
    const Eigen::VectorXd time = columns.since_start(log);
    for (Eigen::Index k = 1; k < shape.cols(); ++k) {
      const double lag = freedom.lags()[static_cast<std::size_t>(k - 1)];
      // Inputs of one lag share a start; the first of them moves it.
      Eigen::Index column = 0;
      for (const ThermalInput& input : inputs) {
        if (input.lag == lag) break;
        if (input.lag > 0) ++column;
      }
      lag_derivatives.col(column).segment(freedom.first(log), shape.rows()) +=
          start[k] / (lag * lag) * time.cwiseProduct(shape.col(k));
    }
  }
}

/// Every column without what zeros and starts can explain.
Eigen::MatrixXd taken_off(const LogFreedom& freedom, Eigen::MatrixXd columns) {
  for (Eigen::Index i = 0; i < columns.cols(); ++i) columns.col(i) = freedom.taken_off(columns.col(i));
  return columns;
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd out(a.rows(), a.cols() + b.cols());
  out.leftCols(a.cols()) = a;
  out.rightCols(b.cols()) = b;
  return out;
}

/// j C j^T of every row.
Eigen::VectorXd variances(const Eigen::MatrixXd& J, const Eigen::MatrixXd& C) {
  return (J * C).cwiseProduct(J).rowwise().sum();
}

/// One error's model from its logs.
class Modeller {
 public:
  Modeller(const FitThermal& thermal, const ThermalColumns& fitted, const ThermalColumns& judging,
           const std::vector<std::vector<std::size_t>>& groups, Eigen::Index error)
      : thermal_(thermal),
        fitted_(fitted),
        judging_(judging),
        groups_(groups),
        error_(error),
        search_(fitted, error) {}

  Modelled model() {
    ThermalModel out;
    const std::vector<ThermalInput> inputs = told(choose(), out);
    const LogFreedom freedom = fitted_.freedom(inputs);
    const Eigen::MatrixXd A = taken_off(freedom, fitted_.temperatures(inputs));
    const Eigen::VectorXd y = freedom.taken_off(fitted_.error(error_));
    out.name = thermal_.errors[static_cast<std::size_t>(error_)];
    out.rotation = read_error_name(out.name)->is_rotation();
    out.before = rms(fitted_.centred(fitted_.error(error_)));
    out.noise = fitted_.noise(error_);
    Slopes slopes = solve(inputs, freedom, A, y);
    out.left = rms(slopes.residual);
    out.crossed = std::sqrt(search_.crossed(inputs));
    judge(inputs, slopes, out);
    add_terms(inputs, slopes, out);
    add_starts(freedom, inputs, slopes, out);
    add_uncertainty(inputs, slopes, out);
    out.misfit = out.left > kMisfit * out.noise && out.left > kMisfitShare * out.before;
    return {std::move(out), std::move(slopes)};
  }

 private:
  std::vector<ThermalInput> choose() {
    if (thermal_.model != FitThermal::Model::automatic)
      return choose_with(thermal_.model == FitThermal::Model::lag);
    const std::vector<ThermalInput> linear = choose_with(false), lagged = choose_with(true);
    const LogFreedom freedom = fitted_.freedom(lagged);
    return search_.crossed(lagged, freedom) < kWorthIt * search_.crossed(linear, freedom) ? lagged : linear;
  }

  /// The inputs whose part can be told from the starts of the logs; the others are named.
  std::vector<ThermalInput> told(std::vector<ThermalInput> inputs, ThermalModel& out) const {
    const LogFreedom freedom = fitted_.freedom(inputs);
    const auto hidden = [&](const ThermalInput& input) {
      return freedom.told(fitted_.temperature(input)).isZero(0);
    };
    for (const ThermalInput& input : inputs)
      if (hidden(input)) out.undetermined.push_back(thermal_.sensors[input.sensor]);
    inputs.erase(std::remove_if(inputs.begin(), inputs.end(), hidden), inputs.end());
    return inputs;
  }

  std::vector<ThermalInput> choose_with(bool lags) {
    if (thermal_.selection == FitThermal::Selection::stepwise)
      return search_.stepwise(search_.best_of(groups_, lags), thermal_.most_sensors, lags);
    std::vector<ThermalInput> inputs;
    if (thermal_.selection == FitThermal::Selection::ridge) {
      for (const std::size_t sensor : search_.best_of(groups_, lags)) inputs.push_back({sensor, 0});
    } else {
      for (const auto& group : groups_)
        for (const std::size_t sensor : group) inputs.push_back({sensor, 0});
    }
    return lags ? search_.with_lags(std::move(inputs)) : inputs;
  }

  /// C = s^2 G G^T,   G = (J^T J)^-1 J^T with J = [temperatures, derivatives by the lags] beside zeros and
  /// starts, or that of ridge.
  Slopes solve(const std::vector<ThermalInput>& inputs, const LogFreedom& logs, const Eigen::MatrixXd& A,
               const Eigen::VectorXd& y) {
    Slopes out;
    const Ridge fit = fit_ridge(A, y, penalty(A, y));
    out.slope = fit.slope;
    const Eigen::MatrixXd temperatures = fitted_.temperatures(inputs);
    Eigen::MatrixXd lags = lag_columns(fitted_, inputs, out.slope);
    add_starts_to_lag_columns(logs, inputs, fitted_, fitted_.error(error_) - temperatures * out.slope, lags);
    out.sensitivity = beside(temperatures, lags);
    const Eigen::Index unknowns = A.cols() + lags.cols();
    out.freedom = static_cast<double>(std::max<Eigen::Index>(1, A.rows() - unknowns - logs.rank()));
    out.residual = y - A * out.slope;
    out.variance = out.residual.squaredNorm() / out.freedom;
    if (lags.cols() == 0) {
      out.gain = fit.gain;
    } else {
      const Eigen::MatrixXd J = beside(A, taken_off(logs, lags));
      out.gain = (J.transpose() * J).ldlt().solve(J.transpose());
    }
    out.covariance = out.variance * out.gain * out.gain.transpose();
    return out;
  }

  /// The penalty that predicts blocks left out best; 0 unless ridge is asked for.
  double penalty(const Eigen::MatrixXd& A, const Eigen::VectorXd& y) {
    if (thermal_.selection != FitThermal::Selection::ridge) return 0;
    double best = 0, least = std::numeric_limits<double>::infinity();
    for (const double lambda : kPenalties) {
      double sum = 0;
      for (const auto& [begin, end] : fitted_.blocks()) {
        const Eigen::Index head = begin, tail = A.rows() - end;
        Eigen::MatrixXd rest(head + tail, A.cols());
        Eigen::VectorXd values(head + tail);
        rest << A.topRows(head), A.bottomRows(tail);
        values << y.head(head), y.tail(tail);
        const Ridge fit = fit_ridge(rest, values, lambda);
        sum += ((y - A * fit.slope).segment(begin, end - begin).array() - fit.intercept).square().sum();
      }
      if (!(sum < least)) continue;
      least = sum;
      best = lambda;
    }
    return best;
  }

  void judge(const std::vector<ThermalInput>& inputs, const Slopes& slopes, ThermalModel& out) const {
    if (judging_.rows() == 0) return;
    const Eigen::VectorXd y = judging_.error(error_);
    out.validated_before = rms(judging_.centred(y));
    out.validated = rms(judging_.freedom(inputs).taken_off(y - judging_.temperatures(inputs) * slopes.slope));
  }

  void add_terms(const std::vector<ThermalInput>& inputs, const Slopes& slopes, ThermalModel& out) const {
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const Eigen::VectorXd T = fitted_.temperature(inputs[i]);
      out.terms.push_back({thermal_.sensors[inputs[i].sensor], inputs[i].lag, slopes.slope[k],
                           std::sqrt(std::max(0.0, slopes.covariance(k, k))), T.minCoeff(), T.maxCoeff()});
    }
  }

  /// start = N^+ (y - J b),   its covariance s^2 (N^T N)^-1 + N^+ J C (N^+ J)^T
  void add_starts(const LogFreedom& freedom, const std::vector<ThermalInput>& inputs, const Slopes& slopes,
                  ThermalModel& out) const {
    const Eigen::VectorXd unexplained = fitted_.error(error_) - fitted_.temperatures(inputs) * slopes.slope;
    for (std::size_t log = 0; log < freedom.logs(); ++log) {
      if (!freedom.is_free(log)) continue;
      const Eigen::VectorXd start = freedom.coefficients(log, unexplained);
      const Eigen::MatrixXd P = freedom.coefficients(log, slopes.sensitivity);
      const Eigen::MatrixXd C =
          slopes.variance * freedom.covariance(log) + P * slopes.covariance * P.transpose();
      for (Eigen::Index k = 1; k < start.size(); ++k)
        out.starts.push_back({log, freedom.lags()[static_cast<std::size_t>(k - 1)], start[k],
                              std::sqrt(std::max(0.0, C(k, k)))});
    }
  }

  /// u^2 = max over the logs of j C j^T, j = [T - reference, d / d lag], + what unseen logs show beyond the
  /// noise
  void add_uncertainty(const std::vector<ThermalInput>& inputs, const Slopes& slopes,
                       ThermalModel& out) const {
    const Eigen::MatrixXd T = (fitted_.temperatures(inputs).array() - thermal_.reference).matrix();
    const Eigen::MatrixXd J = beside(T, lag_columns(fitted_, inputs, slopes.slope));
    const Eigen::VectorXd all = variances(J, slopes.covariance),
                          alone = variances(T, slopes.covariance.topLeftCorner(T.cols(), T.cols()));
    const double unseen = out.validated.value_or(out.crossed);
    const double beyond = std::max(0.0, unseen * unseen - out.noise * out.noise);
    out.u = std::sqrt(std::max(0.0, all.maxCoeff()) + beyond);
    out.beyond_slopes = std::sqrt(std::max(0.0, (all - alone).maxCoeff()) + beyond);
  }

  const FitThermal& thermal_;
  const ThermalColumns &fitted_, &judging_;
  const std::vector<std::vector<std::size_t>>& groups_;
  Eigen::Index error_;
  ThermalSearch search_;
};

/// C_kl = s_kl G_k G_l^T over the slopes of all models.
Eigen::MatrixXd joint_covariance(const std::vector<Slopes>& models) {
  Eigen::Index size = 0;
  for (const Slopes& slopes : models) size += slopes.slope.size();
  Eigen::MatrixXd C(size, size);
  Eigen::Index row = 0;
  for (const Slopes& k : models) {
    Eigen::Index column = 0;
    for (const Slopes& l : models) {
      const double s_kl = k.residual.dot(l.residual) / std::sqrt(k.freedom * l.freedom);
      C.block(row, column, k.slope.size(), l.slope.size()) =
          s_kl * k.gain.topRows(k.slope.size()) * l.gain.topRows(l.slope.size()).transpose();
      column += l.slope.size();
    }
    row += k.slope.size();
  }
  return C;
}

bool is_finite(const ThermalModel& model) {
  return std::isfinite(model.u + model.left + model.before) &&
         std::all_of(model.terms.begin(), model.terms.end(),
                     [](const ThermalTerm& term) { return std::isfinite(term.slope + term.u); });
}

/// Sensors whose temperatures in the judging logs leave those of the logs fitted.
std::vector<std::string> outside(const FitThermal& thermal, const ThermalColumns& fitted,
                                 const ThermalColumns& judging) {
  std::vector<std::string> names;
  if (judging.rows() == 0) return names;
  for (std::size_t s = 0; s < thermal.sensors.size(); ++s) {
    const Eigen::VectorXd known = fitted.temperature({s, 0}), asked = judging.temperature({s, 0});
    if (asked.minCoeff() < known.minCoeff() || asked.maxCoeff() > known.maxCoeff())
      names.push_back(thermal.sensors[s]);
  }
  return names;
}

}  // namespace

ThermalFit fit_thermal(const FitThermal& thermal, const std::vector<DriftCourse>& courses) {
  ThermalFit out;
  const ThermalColumns fitted = columns_of(courses, false), judging = columns_of(courses, true);
  if (fitted.rows() == 0) return out;
  std::vector<ThermalInput> all;
  for (std::size_t s = 0; s < thermal.sensors.size(); ++s) all.push_back({s, 0});
  const Eigen::MatrixXd temperatures = fitted.centred(all);
  const auto groups = sensor_groups(temperatures, thermal.correlated);
  for (const auto& group : groups) {
    out.groups.emplace_back();
    for (const std::size_t sensor : group) out.groups.back().push_back(thermal.sensors[sensor]);
  }
  for (std::size_t s = 0; s < thermal.sensors.size(); ++s)
    if (!(temperatures.col(static_cast<Eigen::Index>(s)).norm() > 0)) out.still.push_back(thermal.sensors[s]);
  out.outside = outside(thermal, fitted, judging);
  std::vector<Slopes> slopes;
  for (std::size_t k = 0; k < thermal.errors.size(); ++k) {
    Modelled found = Modeller(thermal, fitted, judging, groups, static_cast<Eigen::Index>(k)).model();
    out.finite = out.finite && is_finite(found.model);
    out.models.push_back(std::move(found.model));
    slopes.push_back(std::move(found.slopes));
  }
  out.covariance = joint_covariance(slopes);
  if (!out.finite) out.models.clear();
  return out;
}

std::string variable_of(const ThermalTerm& term) {
  return term.lag > 0 ? fmt::format("{}_lag{:.0f}", term.sensor, term.lag) : term.sensor;
}

}  // namespace abbe
