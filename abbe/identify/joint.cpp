#include "abbe/identify/joint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "abbe/core/units.h"
#include "abbe/identify/joint_design.h"
#include "abbe/identify/run_balance.h"
#include "abbe/identify/time_offset.h"

namespace abbe {
namespace {

using Status = Identification::Status;

constexpr double kIdentifiable = 1 - 1e-6;
constexpr double kUsualNoise = 0.1 * um;  // of a ball bar; the weight where nobody says more
constexpr double kChiDoubt = 5;           // standard deviations of chi square
constexpr double kVisible = 0.01;         // part of the usual effect that a hidden combination may have
constexpr double kOutlierDoubt = 6;       // standardised residual

double noise_of(const BallbarTest& test, const IdentifyOptions& options) {
  return options.noise.value_or(test.noise.value_or(kUsualNoise));
}

bool noise_is_known(const std::vector<BallbarTest>& tests, const IdentifyOptions& options) {
  return options.noise ||
         std::all_of(tests.begin(), tests.end(), [](const BallbarTest& t) { return t.noise; });
}

/// Calls f(test, run, sample) for every sample that counts; returns how many were too close to a reversal.
template <class F>
Eigen::Index for_each_sample(const JointDesign& design, const IdentifyOptions& options, F f) {
  Eigen::Index left_out = 0;
  for (std::size_t t = 0; t < design.tests().size(); ++t) {
    for (std::size_t r = 0; r < design.tests()[t].runs.size(); ++r) {
      const CircleMotion& motion = design.motion(t, r);
      for (std::size_t i = 0; i < motion.size(); ++i) {
        if (motion.sense_is_sure(i, options.reversal_window)) {
          f(t, r, i);
        } else {
          ++left_out;
        }
      }
    }
  }
  return left_out;
}

struct Factored {
  TriangularFactor factor;
  Eigen::Index left_out = 0;
};

/// All rows, weighted; `measured` false: values 0, for a plan that nobody has measured yet.
Factored factor_of(const JointDesign& design, const IdentifyOptions& options, bool measured) {
  Factored out{TriangularFactor(static_cast<Eigen::Index>(design.unknowns()))};
  std::vector<double> row(design.unknowns());
  out.left_out = for_each_sample(design, options, [&](std::size_t t, std::size_t r, std::size_t i) {
    const double weight = 1 / noise_of(design.tests()[t], options);
    design.row(t, r, i, 0, row);
    for (double& x : row) x *= weight;
    const double deviation =
        measured ? design.tests()[t].runs[r].deviation[i] - design.servo_part(t, r, i) : 0.0;
    out.factor.add(row, deviation * weight);
  });
  return out;
}

/// `full` knows what can be seen, `used` is the solution with its assumptions.
void take_solution(Identification& out, const JointDesign& design, const LeastSquaresSolution& full,
                   const ZeroedSolution& used) {
  using Origin = IdentifiedTerm::Origin;
  out.names = design.names();
  out.values = used.solution.x;
  out.covariance = used.solution.cofactor;
  out.null_space = full.null_space;
  out.column_length = full.column_length;
  out.singular_values = full.singular_values;
  out.rank = full.rank;
  out.rows = full.rows;
  out.unseen = unseen_combinations(full, out.names, design.terms());
  for (const std::size_t zero : used.zeros) out.assumptions.push_back(out.names[zero]);
  for (std::size_t k = 0; k < design.terms().size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    IdentifiedTerm term{design.terms()[k], used.solution.x[i], 0, full.determined[i] >= kIdentifiable,
                        Origin::measured};
    if (std::find(used.zeros.begin(), used.zeros.end(), k) != used.zeros.end()) {
      term.origin = Origin::assumed;
    } else if (used.solution.determined[i] < kIdentifiable) {
      term.origin = Origin::artefact;
    }
    out.terms.push_back(term);
  }
}

ZeroedSolution used_solution(const JointDesign& design, const TriangularFactor& factor,
                             const LeastSquaresSolution& full, const IdentifyOptions& options) {
  if (!options.assume_zero) return {full, {}};
  return solve_with_zeros(factor, {options.rank_tolerance, true}, design.names(), design.terms(),
                          design.first_bar());
}

void take_uncertainties(Identification& out) {
  for (std::size_t k = 0; k < out.terms.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    out.terms[k].value = out.values[i];
    out.terms[k].uncertainty = std::sqrt(std::max(0.0, out.covariance(i, i)));
  }
}

/// Residuals over their own standard deviation, in records per run, and what they say.
void judge_residuals(Identification& out, const JointDesign& design, const IdentifyOptions& options,
                     const RunClocks& clocks) {
  std::vector<std::vector<double>> records;
  double square = 0;
  std::vector<double> row(design.unknowns());
  const auto m = static_cast<Eigen::Index>(design.unknowns());
  const Eigen::MatrixXd cofactor = out.covariance.topLeftCorner(m, m);
  std::size_t last_test = 0, last_run = 0;
  for_each_sample(design, options, [&](std::size_t t, std::size_t r, std::size_t i) {
    if (records.empty() || t != last_test || r != last_run) records.emplace_back();
    last_test = t, last_run = r;
    const double sigma = noise_of(design.tests()[t], options);
    design.row(t, r, i, clocks.at(t, r), row);
    const auto x = Eigen::Map<const Eigen::VectorXd>(row.data(), m);
    const double deviation = design.tests()[t].runs[r].deviation[i] - design.servo_part(t, r, i);
    const double residual = (deviation - x.dot(out.values.head(m))) / sigma;
    square += residual * residual;
    // h_i = a_i (A^T A)^+ a_i^T: the part of itself that a sample explains
    const double leverage = std::clamp(x.dot(cofactor * x) / (sigma * sigma), 0.0, 1 - 1e-9);
    records.back().push_back(residual / std::sqrt(1 - leverage));
  });
  const double freedom = std::max<double>(1, static_cast<double>(out.rows - out.rank));
  out.chi_square = square / freedom;
  std::vector<std::span<const double>> views(records.begin(), records.end());
  out.residuals = summary_of_residuals(views);
  const double scale = out.noise_known ? 1 : std::sqrt(out.chi_square);
  out.largest_standardised = scale > 0 ? out.residuals.largest / scale : 0;

  const double spread = kChiDoubt * std::sqrt(2 / freedom);
  if (out.noise_known && out.chi_square > 1 + spread)
    out.doubts.push_back(
        fmt::format("the residuals are {:.2f} times the stated noise", std::sqrt(out.chi_square)));
  if (!out.residuals.white)
    out.doubts.push_back(
        fmt::format("neighbouring residuals resemble each other (lag one {:+.2f}, tau {:.1f}): something is "
                    "not in the model, or "
                    "the noise is coloured",
                    out.residuals.lag_one, out.residuals.tau));
  if (out.largest_standardised > kOutlierDoubt)
    out.doubts.push_back(fmt::format("a residual is {:.1f} standard deviations", out.largest_standardised));
  out.trusted = out.doubts.empty();
}

/// u^2 = cofactor sigma^2, more where the residuals are larger or more alike than noise.
void scale_covariance(Identification& out, const IdentifyOptions& options,
                      const std::vector<BallbarTest>& tests) {
  const double scatter = out.noise_known ? std::max(1.0, out.trusted ? 1.0 : out.chi_square) : out.chi_square;
  out.inflation = scatter * (out.residuals.white ? 1.0 : out.residuals.tau);
  out.covariance *= out.inflation;
  double sum = 0;
  for (const BallbarTest& test : tests) sum += noise_of(test, options);
  out.noise = sum / std::max<double>(1, static_cast<double>(tests.size()));
  if (!out.noise_known) {
    out.noise *= std::sqrt(out.chi_square);
    out.chi_square = 1;
  }
}

Identification failed(Status status) {
  Identification out;
  out.status = status;
  return out;
}

}  // namespace

Identification identify_jointly(const Machine& machine, const std::vector<BallbarTest>& tests,
                                const IdentifyOptions& options) {
  const std::vector<int> moving = moving_axes(machine, tests);
  if (moving.empty()) return failed(Status::no_axes);
  if (std::any_of(moving.begin(), moving.end(), [&](int k) { return machine.axis(k).errors_have_no_sign(); }))
    return failed(Status::no_sign);
  const JointDesign design(machine, tests,
                           choose_terms(machine, moving, travel_of_tests(machine, tests), options.terms));
  const Factored factored = factor_of(design, options, true);
  const LeastSquaresSolution fit = solve(factored.factor, {options.rank_tolerance, true});
  if (fit.status == LeastSquaresSolution::Status::not_finite) return failed(Status::not_finite);
  if (!fit.ok() || fit.freedom() <= 0) return failed(Status::too_few_rows);

  Identification out;
  out.left_out = factored.left_out;
  out.noise_known = noise_is_known(tests, options);
  const ZeroedSolution used = used_solution(design, factored.factor, fit, options);
  take_solution(out, design, fit, used);
  RunClocks clocks(tests);
  if (options.time_offset > 0)
    fit_time_offsets(out, clocks, design, used.solution, options,
                     [&](std::size_t t) { return noise_of(tests[t], options); });
  judge_residuals(out, design, options, clocks);
  scale_covariance(out, options, tests);
  take_uncertainties(out);
  out.runs = run_balances(out, design, clocks);
  return out;
}

Identification identifiability(const Machine& machine, const std::vector<BallbarTest>& plan,
                               const IdentifyOptions& options) {
  const std::vector<int> moving = moving_axes(machine, plan);
  if (moving.empty()) return failed(Status::no_axes);
  const JointDesign design(machine, plan,
                           choose_terms(machine, moving, travel_of_tests(machine, plan), options.terms));
  const Factored factored = factor_of(design, options, false);
  const LeastSquaresSolution fit = solve(factored.factor, {options.rank_tolerance, true});
  if (fit.status == LeastSquaresSolution::Status::not_finite) return failed(Status::not_finite);
  if (!fit.ok()) return failed(Status::too_few_rows);
  Identification out;
  out.left_out = factored.left_out;
  out.noise_known = true;
  take_solution(out, design, fit, used_solution(design, factored.factor, fit, options));
  out.noise = plan.empty() ? 0 : noise_of(plan.front(), options);
  take_uncertainties(out);
  return out;
}

TracePrediction predict_trace(const Machine& machine, const Identification& identification,
                              const BallbarTest& test, std::size_t run) {
  TracePrediction out;
  std::vector<ModelTerm> terms;
  for (const IdentifiedTerm& term : identification.terms) terms.push_back(term.term);
  const std::vector<BallbarTest> tests = {test};
  const JointDesign design(machine, tests, terms);
  const auto m = static_cast<Eigen::Index>(terms.size());
  std::vector<double> row(design.unknowns());
  const Eigen::VectorXd values = identification.values.head(m);
  const Eigen::MatrixXd covariance = identification.covariance.topLeftCorner(m, m);
  // A null vector has the length 1 over all weighted rows: were it seen, about noise / sqrt(rows) in a row.
  // What the set-up's own unknowns take up (centre, length) needs not be known.
  const double usual = kVisible * identification.noise / std::sqrt(static_cast<double>(identification.rows));
  std::vector<Eigen::VectorXd> unseen;
  for (std::size_t i = 0; i < test.runs[run].angle.size(); ++i) {
    design.row(0, run, i, 0, row);
    const auto x = Eigen::Map<const Eigen::VectorXd>(row.data(), m);
    out.deviation.push_back(x.dot(values));
    out.uncertainty.push_back(std::sqrt(std::max(0.0, x.dot(covariance * x))));
    unseen.emplace_back(identification.null_space.topRows(m).transpose() * x);
  }
  for (Eigen::Index k = 0; k < identification.null_space.cols(); ++k) {
    TriangularFactor factor(3);
    for (std::size_t i = 0; i < unseen.size(); ++i) {
      const double angle = test.runs[run].angle[i];
      factor.add(std::array{1.0, std::cos(angle), std::sin(angle)}, unseen[i][k]);
    }
    const LeastSquaresSolution rest = solve(factor, {});
    const double rms = std::sqrt(rest.sum_of_squares / std::max<double>(1, static_cast<double>(rest.rows)));
    out.determined = out.determined && rms <= usual;
  }
  return out;
}

}  // namespace abbe
