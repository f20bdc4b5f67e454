#include "abbe/fit/joint_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "abbe/core/least_squares.h"
#include "abbe/fit/independent_columns.h"
#include "abbe/fit/unit_effects.h"

namespace abbe {
namespace {

// Of a column. Columns that differ only because the tip is micrometres from its nominal place, a part in 10^5
// or so, are the same: what tells them apart would be noise, enlarged as many times.
constexpr double kTolerance = 1e-3;

/// Where the unknowns are among the columns: nuisances, functions, reversals, locations.
struct Layout {
  std::size_t nuisances = 0;
  std::vector<Eigen::Index> mean, reversal;  ///< first column of each function; reversal -1: none
  Eigen::Index locations = 0, columns = 0;
  std::vector<std::string> owner;  ///< name of each column, for people

  Layout(const Observations& observations, const Unknowns& unknowns)
      : nuisances(observations.nuisances.size()) {
    for (const Nuisance& nuisance : observations.nuisances) owner.push_back(nuisance.name);
    for (const UnknownFunction& function : unknowns.functions) {
      mean.push_back(add(function.name, function.mean.parameters()));
      reversal.push_back(
          function.reversal ? add("reversal of " + function.name, function.reversal->parameters()) : -1);
    }
    locations = static_cast<Eigen::Index>(owner.size());
    for (const std::string& name : unknowns.locations) owner.push_back(name);
    columns = static_cast<Eigen::Index>(owner.size());
  }

 private:
  Eigen::Index add(const std::string& name, Eigen::Index count) {
    const auto first = static_cast<Eigen::Index>(owner.size());
    owner.insert(owner.end(), static_cast<std::size_t>(count), name);
    return first;
  }
};

/// Rows of the joint problem, one observation after the other.
class Rows {
 public:
  Rows(const Observations& observations, const Unknowns& unknowns, const Layout& layout, UnitEffects effects)
      : observations_(observations),
        unknowns_(unknowns),
        layout_(layout),
        effects_(std::move(effects)),
        shapes_(unknowns.functions.size()) {
    for (const std::string& name : unknowns.locations) location_units_.push_back(location_unit(name));
  }

  /// row = d value / d unknowns; false if something is not finite.
  void write(const Observation& observation, Eigen::VectorXd& row) {
    row.setZero();
    for (const Observation::Term& term : observation.terms)
      row[static_cast<Eigen::Index>(term.nuisance)] += term.coefficient;
    look_at(observation.pose);
    const Query& query = observations_.poses[observation.pose];
    const std::size_t functions = unknowns_.functions.size();
    for (std::size_t f = 0; f < functions; ++f) {
      const UnknownFunction& function = unknowns_.functions[f];
      const double effect = part(twists_[f], observation) * function.error_unit;
      if (effect == 0) continue;
      const auto axis = static_cast<std::size_t>(function.axis);
      const Shapes& shapes = shapes_at(f, query.q[axis] / function.position_unit);
      row.segment(layout_.mean[f], shapes.mean.size()) += effect * shapes.mean.transpose();
      if (function.reversal && query.approach[axis] != 0)
        row.segment(layout_.reversal[f], shapes.reversal.size()) +=
            0.5 * query.approach[axis] * effect * shapes.reversal.transpose();
    }
    for (std::size_t k = 0; k < unknowns_.locations.size(); ++k)
      row[layout_.locations + static_cast<Eigen::Index>(k)] +=
          part(twists_[functions + k], observation) * location_units_[k];
  }

  [[nodiscard]] static double location_unit(const std::string& name) {
    return read_error_name(name)->is_rotation() ? urad : um;
  }

 private:
  /// A function's shapes at the last position it was asked for.
  struct Shapes {
    double v = std::numeric_limits<double>::quiet_NaN();
    Eigen::RowVectorXd mean, reversal;
  };

  const Shapes& shapes_at(std::size_t f, double v) {
    Shapes& shapes = shapes_[f];
    if (shapes.v == v) return shapes;
    const UnknownFunction& function = unknowns_.functions[f];
    function.mean.row(v, shapes.mean, scratch_);
    if (function.reversal) function.reversal->row(v, shapes.reversal, scratch_);
    shapes.v = v;
    return shapes;
  }

  static double part(const Twist& twist, const Observation& observation) {
    return observation.direction.dot(observation.rotation ? twist.e : twist.d);
  }

  /// The effects at a pose; rows of one pose follow each other.
  void look_at(std::size_t pose) {
    if (pose == pose_ && !twists_.empty()) return;
    pose_ = pose;
    twists_.resize(effects_.count());
    for (std::size_t i = 0; i < effects_.count(); ++i) twists_[i] = effects_.at(i, observations_.poses[pose]);
  }

  const Observations& observations_;
  const Unknowns& unknowns_;
  const Layout& layout_;
  UnitEffects effects_;
  std::vector<double> location_units_;
  std::vector<Shapes> shapes_;
  Eigen::RowVectorXd scratch_;
  std::size_t pose_ = 0;
  std::vector<Twist> twists_;
};

void add_row(TriangularFactor& factor, const Eigen::VectorXd& row, double value) {
  factor.add({row.data(), static_cast<std::size_t>(row.size())}, value);
}

/// The measured rows, weighted, some at a time.
void add_measured(const Observations& observations, Rows& rows, TriangularFactor& factor) {
  Eigen::MatrixXd block(TriangularFactor::kBlock, factor.unknowns());
  Eigen::VectorXd values(TriangularFactor::kBlock), row(factor.unknowns());
  Eigen::Index used = 0;
  const auto hand_over = [&] {
    factor.add(block.topRows(used), values.head(used));
    used = 0;
  };
  for (const Observation& observation : observations.rows) {
    rows.write(observation, row);
    block.row(used) = row.transpose() / observation.sigma;
    values[used++] = observation.value / observation.sigma;
    if (used == block.rows()) hand_over();
  }
  hand_over();
}

/// What is known of unknowns beforehand, as rows; returns their number.
std::size_t add_known(const FitJob& job, const Observations& observations, const Unknowns& unknowns,
                      const Layout& layout, TriangularFactor& factor) {
  std::size_t count = 0;
  Eigen::VectorXd row = Eigen::VectorXd::Zero(layout.columns);
  const auto add = [&](Eigen::Index column, double scale, double value, double u) {
    row[column] = scale / u;
    add_row(factor, row, value / u);
    row[column] = 0;
    ++count;
  };
  for (std::size_t i = 0; i < observations.nuisances.size(); ++i)
    if (const Nuisance& nuisance = observations.nuisances[i]; nuisance.u)
      add(static_cast<Eigen::Index>(i), 1, nuisance.value, *nuisance.u);
  for (const FitValue& value : job.values) {
    const auto found = std::find(unknowns.locations.begin(), unknowns.locations.end(), value.name);
    add(layout.locations + (found - unknowns.locations.begin()), Rows::location_unit(value.name), value.value,
        value.u);
  }
  return count;
}

/// The unknowns with their covariance, those left out at zero.
struct Solution {
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  double sum_of_squares = 0;
  bool ok = false;
};

Solution solve_kept(const Eigen::MatrixXd& factor, const IndependentColumns& columns) {
  const auto kept = static_cast<Eigen::Index>(columns.kept.size()), all = factor.cols() - 1;
  Eigen::MatrixXd reduced(factor.rows(), kept);
  for (Eigen::Index k = 0; k < kept; ++k)
    reduced.col(k) = factor.col(columns.kept[static_cast<std::size_t>(k)]);
  TriangularFactor small(kept);
  small.add(reduced, factor.col(all));
  LeastSquaresOptions options;
  options.tolerance = 0;  // dependent columns are gone
  const LeastSquaresSolution found = solve(small, options);
  Solution out{Eigen::VectorXd::Zero(all), Eigen::MatrixXd::Zero(all, all), found.sum_of_squares, found.ok()};
  if (!out.ok) return out;
  for (Eigen::Index i = 0; i < kept; ++i) {
    out.x[columns.kept[static_cast<std::size_t>(i)]] = found.x[i];
    for (Eigen::Index j = 0; j < kept; ++j)
      out.covariance(columns.kept[static_cast<std::size_t>(i)], columns.kept[static_cast<std::size_t>(j)]) =
          found.cofactor(i, j);
  }
  return out;
}

FoundFunction found_function(const UnknownFunction& unknown, Eigen::Index mean, Eigen::Index reversal,
                             const Solution& solution) {
  FoundFunction out;
  out.unknown = unknown;
  const Eigen::Index n = unknown.mean.parameters();
  out.mean = solution.x.segment(mean, n);
  if (unknown.reversal) out.reversal = solution.x.segment(reversal, unknown.reversal->parameters());
  // u^2(v) = row C row^T
  const Eigen::MatrixXd covariance = solution.covariance.block(mean, mean, n, n);
  for (int i = 0; i < kTrendSamples; ++i) {
    const double t = static_cast<double>(i) / (kTrendSamples - 1);
    const Eigen::RowVectorXd row =
        unknown.mean.row(unknown.mean.lo() + t * (unknown.mean.hi() - unknown.mean.lo()));
    out.u = std::max(out.u, std::sqrt(std::max(0.0, (row * covariance * row.transpose()).value())));
  }
  return out;
}

/// Of a function several parameters may be missing: it is named once.
std::vector<NotDetermined> name_dependent(const IndependentColumns& columns, const Layout& layout,
                                          bool asked) {
  std::vector<NotDetermined> out;
  for (const DependentColumn& dependent : columns.dependent) {
    const auto column = static_cast<std::size_t>(dependent.column);
    const std::string& name = layout.owner[column];
    const bool location = dependent.column >= layout.locations;
    if (out.empty() || out.back().name != name) {
      const auto parameters = std::count(layout.owner.begin(), layout.owner.end(), name);
      out.push_back(
          {name, {}, location ? asked : column >= layout.nuisances, 0, static_cast<std::size_t>(parameters)});
    }
    ++out.back().missing;
    std::set<std::string> like(out.back().like.begin(), out.back().like.end());
    for (const auto& [other, share] : dependent.like)
      if (layout.owner[static_cast<std::size_t>(other)] != name)
        like.insert(layout.owner[static_cast<std::size_t>(other)]);
    out.back().like.assign(like.begin(), like.end());
  }
  return out;
}

/// Without instruments, and without locations that are not determined.
Eigen::MatrixXd covariance_of_found(const Layout& layout, const IndependentColumns& columns,
                                    const Eigen::MatrixXd& all) {
  std::vector<Eigen::Index> found;
  for (auto column = static_cast<Eigen::Index>(layout.nuisances); column < layout.columns; ++column)
    if (column < layout.locations ||
        std::find(columns.kept.begin(), columns.kept.end(), column) != columns.kept.end())
      found.push_back(column);
  return all(found, found);
}

std::vector<SetResidual> residuals(const Observations& observations, Rows& rows, const Eigen::VectorXd& x) {
  std::vector<SetResidual> out;
  Eigen::VectorXd row(x.size());
  for (const ObservationSet& set : observations.sets) {
    SetResidual r{set.name, set.angle, set.noise_assumed, set.end - set.begin, 0, 0, 0};
    const auto count = static_cast<double>(std::max<std::size_t>(r.rows, 1));
    for (std::size_t i = set.begin; i < set.end; ++i) {
      rows.write(observations.rows[i], row);
      const double residual = observations.rows[i].value - row.dot(x);
      r.max = std::max(r.max, std::abs(residual));
      r.rms += residual * residual / count;
      r.ratio += std::pow(residual / observations.rows[i].sigma, 2) / count;
    }
    r.rms = std::sqrt(r.rms);
    r.ratio = std::sqrt(r.ratio);
    out.push_back(std::move(r));
  }
  return out;
}

bool all_assumed(const Observations& observations) {
  return std::all_of(observations.sets.begin(), observations.sets.end(),
                     [](const ObservationSet& set) { return set.noise_assumed; });
}

}  // namespace

FitResult fit_jointly(const FitJob& job, const Observations& observations, const Unknowns& unknowns) {
  FitResult out;
  out.status = FitResult::Status::not_finite;
  const Layout layout(observations, unknowns);
  std::vector<std::string> names;
  for (const UnknownFunction& function : unknowns.functions) names.push_back(function.name);
  names.insert(names.end(), unknowns.locations.begin(), unknowns.locations.end());
  std::optional<UnitEffects> effects = UnitEffects::make(job.machine, names);
  if (!effects) return out;
  Rows rows(observations, unknowns, layout, std::move(*effects));
  TriangularFactor factor(layout.columns);
  add_measured(observations, rows, factor);
  out.rows = observations.rows.size() + add_known(job, observations, unknowns, layout, factor);
  if (!factor.is_finite()) return out;

  const Eigen::MatrixXd triangle = factor.factor();
  const IndependentColumns columns = independent_columns(triangle.leftCols(layout.columns), kTolerance);
  Solution solution = solve_kept(triangle, columns);
  if (!solution.ok) return out;
  out.status = FitResult::Status::ok;
  out.unknowns = static_cast<std::size_t>(layout.columns);
  out.rank = columns.kept.size();
  if (out.rows > out.rank)
    out.variance_ratio = solution.sum_of_squares / static_cast<double>(out.rows - out.rank);
  solution.covariance *= all_assumed(observations) ? out.variance_ratio : std::max(1.0, out.variance_ratio);

  for (std::size_t f = 0; f < unknowns.functions.size(); ++f)
    out.functions.push_back(
        found_function(unknowns.functions[f], layout.mean[f], layout.reversal[f], solution));
  const auto value_at = [&](const std::string& name, Eigen::Index column) {
    return FoundValue{name, solution.x[column],
                      std::sqrt(std::max(0.0, solution.covariance(column, column)))};
  };
  out.not_determined = name_dependent(columns, layout, unknowns.locations_asked);
  for (std::size_t k = 0; k < unknowns.locations.size(); ++k) {
    const Eigen::Index column = layout.locations + static_cast<Eigen::Index>(k);
    if (std::find(columns.kept.begin(), columns.kept.end(), column) != columns.kept.end())
      out.locations.push_back(value_at(unknowns.locations[k], column));
  }
  out.covariance = covariance_of_found(layout, columns, solution.covariance);
  for (std::size_t k = 0; k < layout.nuisances; ++k)
    out.nuisances.push_back(value_at(observations.nuisances[k].name, static_cast<Eigen::Index>(k)));
  out.sets = residuals(observations, rows, solution.x);
  return out;
}

}  // namespace abbe
