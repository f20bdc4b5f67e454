#include "abbe/fit/thermal_columns.h"

#include <algorithm>
#include <cmath>

#include "abbe/signal/lag.h"

namespace abbe {

ThermalColumns::ThermalColumns(std::vector<const DriftCourse*> courses) : courses_(std::move(courses)) {
  for (const DriftCourse* course : courses_) {
    first_.push_back(rows_);
    rows_ += static_cast<Eigen::Index>(course->times.size());
  }
  first_.push_back(rows_);
}

std::pair<double, double> ThermalColumns::lag_range() const {
  double shortest = 0, longest = 0;
  for (const DriftCourse* course : courses_) {
    const double duration = course->times.back() - course->times.front();
    shortest = std::max(shortest, 2 * duration / static_cast<double>(course->times.size() - 1));
    longest = std::max(longest, duration);
  }
  return {shortest, longest};
}

template <class PerLog>
Eigen::VectorXd ThermalColumns::stacked(const PerLog& per_log) const {
  Eigen::VectorXd out(rows_);
  for (std::size_t c = 0; c < courses_.size(); ++c)
    out.segment(first_[c], first_[c + 1] - first_[c]) = per_log(*courses_[c]);
  return out;
}

Eigen::VectorXd ThermalColumns::temperature(const ThermalInput& input) const {
  return stacked([&](const DriftCourse& course) -> Eigen::VectorXd {
    const std::vector<double> lagged =
        first_order_lag(course.times, course.temperatures[input.sensor], input.lag);
    return Eigen::Map<const Eigen::VectorXd>(lagged.data(), static_cast<Eigen::Index>(lagged.size()));
  });
}

Eigen::VectorXd ThermalColumns::error(Eigen::Index k) const {
  return stacked([&](const DriftCourse& course) -> Eigen::VectorXd { return course.errors.col(k); });
}

Eigen::VectorXd ThermalColumns::centred(Eigen::VectorXd column) const {
  for (std::size_t c = 0; c + 1 < first_.size(); ++c) {
    auto log = column.segment(first_[c], first_[c + 1] - first_[c]);
    log.array() -= log.mean();
  }
  return column;
}

Eigen::MatrixXd ThermalColumns::centred(const std::vector<ThermalInput>& inputs) const {
  Eigen::MatrixXd out = temperatures(inputs);
  for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = centred(out.col(i));
  return out;
}

LogFreedom ThermalColumns::freedom(const std::vector<ThermalInput>& inputs) const {
  std::vector<double> lags;
  for (const ThermalInput& input : inputs) lags.push_back(input.lag);
  return {courses_, lags};
}

Eigen::MatrixXd ThermalColumns::temperatures(const std::vector<ThermalInput>& inputs) const {
  Eigen::MatrixXd out(rows_, static_cast<Eigen::Index>(inputs.size()));
  for (std::size_t i = 0; i < inputs.size(); ++i)
    out.col(static_cast<Eigen::Index>(i)) = temperature(inputs[i]);
  return out;
}

Eigen::VectorXd ThermalColumns::since_start(std::size_t log) const {
  const std::vector<double>& times = courses_[log]->times;
  const Eigen::Map<const Eigen::ArrayXd> t(times.data(), static_cast<Eigen::Index>(times.size()));
  return (t - times.front()).matrix();
}

Eigen::VectorXd ThermalColumns::indicator(std::size_t log) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(rows_);
  out.segment(first_[log], first_[log + 1] - first_[log]).setOnes();
  return out;
}

double ThermalColumns::noise(Eigen::Index k) const {
  double sum = 0, count = 0;
  for (const DriftCourse* course : courses_) {
    const auto y = course->errors.col(k);
    const Eigen::Index inner = y.size() - 2;
    sum += (y.head(inner) - 2 * y.segment(1, inner) + y.tail(inner)).squaredNorm();
    count += static_cast<double>(inner);
  }
  return std::sqrt(sum / (6 * count));
}

std::vector<std::pair<Eigen::Index, Eigen::Index>> ThermalColumns::blocks() const {
  constexpr Eigen::Index kBlocks = 8;
  std::vector<std::pair<Eigen::Index, Eigen::Index>> out;
  for (std::size_t c = 0; c + 1 < first_.size(); ++c) {
    const Eigen::Index length = first_[c + 1] - first_[c];
    // As many as the log's share of all rows, two at least: one alone would leave its zero out with it.
    const Eigen::Index count = std::max<Eigen::Index>(2, kBlocks * length / rows_);
    for (Eigen::Index b = 0; b < count; ++b)
      out.emplace_back(first_[c] + b * length / count, first_[c] + (b + 1) * length / count);
  }
  return out;
}

}  // namespace abbe
