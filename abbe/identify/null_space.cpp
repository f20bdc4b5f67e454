#include "abbe/identify/null_space.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace abbe {
namespace {

constexpr double kWorthNaming = 0.02;  // of the largest effect within a combination
constexpr double kTie = 1e-9;          // of the largest effect: rounding must not choose

/// Why static and dynamic terms are one, if they are in one combination.
std::string reason(const UnseenCombination& c, const std::vector<ModelTerm>& terms) {
  bool statics = false, velocity = false, acceleration = false;
  for (const UnseenCombination::Part& part : c.parts) {
    if (part.unknown >= terms.size()) {
      statics = true;  // centre and length of the bar
      continue;
    }
    const ModelTerm& term = terms[part.unknown];
    velocity = velocity || term.form == ModelTerm::Form::velocity;
    acceleration = acceleration || term.form == ModelTerm::Form::acceleration;
    statics = statics || !term.is_dynamic();
  }
  if (statics && acceleration)
    return "; on a circle of one feed v the acceleration of an axis is -(v/R)^2 times its position: another "
           "feed tells "
           "them apart";
  if (statics && velocity)
    return "; in one direction the velocity of an axis is proportional to the position of the other: the "
           "other direction "
           "tells them apart";
  if (velocity && c.parts.size() > 1)
    return "; equal lags move the tool along the circle, which a ball bar does not see: only differences "
           "count";
  return {};
}

std::string words_of(const UnseenCombination& c, const std::vector<std::string>& names,
                     const std::vector<ModelTerm>& terms) {
  const std::string& first = names[c.parts[0].unknown];
  if (c.parts.size() == 1) return fmt::format("{} is not seen at all", first);
  if (c.parts.size() == 2) {
    // n = (1, amount) is invisible, so the sum with factors (1, -1 / amount) is what is seen.
    const double factor = -1 / c.parts[1].amount;
    const std::string& second = names[c.parts[1].unknown];
    return fmt::format("{} and {} only as {} {} {:.6g} {}{}", first, second, first, factor < 0 ? '-' : '+',
                       std::abs(factor), second, reason(c, terms));
  }
  std::string list;
  for (std::size_t k = 0; k < c.parts.size(); ++k) {
    const auto& part = c.parts[k];
    list += k == 0 ? names[part.unknown]
                   : fmt::format(" {} {:.6g} {}", part.amount < 0 ? '-' : '+', std::abs(part.amount),
                                 names[part.unknown]);
  }
  return fmt::format("any amount of ({}) changes no measured value{}", list, reason(c, terms));
}

}  // namespace

std::vector<UnseenCombination> unseen_combinations(const LeastSquaresSolution& solution,
                                                   const std::vector<std::string>& names,
                                                   const std::vector<ModelTerm>& terms) {
  // Effects: amounts times the lengths of their columns. These columns are orthonormal.
  Eigen::MatrixXd effect = solution.column_length.asDiagonal() * solution.null_space;
  std::vector<UnseenCombination> out;
  std::vector<Eigen::Index> pivots;
  for (Eigen::Index k = 0; k < effect.cols(); ++k) {
    const auto rest = effect.rightCols(effect.cols() - k).cwiseAbs();
    const Eigen::VectorXd largest = rest.rowwise().maxCoeff();
    const double tie = (1 - kTie) * largest.maxCoeff();
    Eigen::Index row = 0, column = 0;
    while (largest[row] < tie) ++row;
    rest.row(row).maxCoeff(&column);
    effect.col(k).swap(effect.col(k + column));
    if (!(std::abs(effect(row, k)) > 0)) break;
    effect.col(k) /= effect(row, k);
    for (Eigen::Index other = 0; other < effect.cols(); ++other)
      if (other != k) effect.col(other) -= effect(row, other) * effect.col(k);
    pivots.push_back(row);
  }
  for (std::size_t k = 0; k < pivots.size(); ++k) {
    const Eigen::VectorXd column = effect.col(static_cast<Eigen::Index>(k));
    const double most = column.cwiseAbs().maxCoeff();
    UnseenCombination c;
    for (Eigen::Index i = 0; i < column.size(); ++i)
      if (std::abs(column[i]) > kWorthNaming * most)
        c.parts.push_back({static_cast<std::size_t>(i), column[i] / solution.column_length[i]});
    std::stable_sort(c.parts.begin(), c.parts.end(), [&](const auto& a, const auto& b) {
      return std::abs(column[static_cast<Eigen::Index>(a.unknown)]) >
             std::abs(column[static_cast<Eigen::Index>(b.unknown)]) + kTie;
    });
    const double unit = c.parts.front().amount;
    for (auto& part : c.parts) part.amount /= unit;
    c.words = words_of(c, names, terms);
    out.push_back(std::move(c));
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a.parts[0].unknown < b.parts[0].unknown; });
  return out;
}

namespace {

/// How readily an unknown is taken for zero: the rarer its cause, or the less it matters, the readier.
int readiness(std::size_t unknown, const std::vector<ModelTerm>& terms, std::size_t first_bar) {
  if (unknown >= first_bar) return 60;
  if (unknown >= terms.size()) return -1;
  const ModelTerm& term = terms[unknown];
  const bool along = term.name.direction < 3 && term.form == ModelTerm::Form::power && term.power == 1;
  switch (term.form) {
    case ModelTerm::Form::constant:
      return 0;
    case ModelTerm::Form::lost_motion:
      return 10;
    case ModelTerm::Form::acceleration:
      return 50;
    case ModelTerm::Form::velocity:
      return 70;
    case ModelTerm::Form::spline:
      return 40;
    case ModelTerm::Form::power:
      return term.name.is_rotation() ? 90 + term.power : along ? 20 : 30 + term.power;
  }
  return 0;
}

/// The same rows without some columns.
TriangularFactor without(const TriangularFactor& factor, const std::vector<std::size_t>& zeros) {
  Eigen::MatrixXd rc = factor.factor();
  for (const std::size_t k : zeros) rc.col(static_cast<Eigen::Index>(k)).setZero();
  TriangularFactor out(factor.unknowns());
  out.add(rc.leftCols(factor.unknowns()), rc.col(factor.unknowns()));
  return out;
}

}  // namespace

ZeroedSolution solve_with_zeros(const TriangularFactor& factor, const LeastSquaresOptions& options,
                                const std::vector<std::string>& names, const std::vector<ModelTerm>& terms,
                                std::size_t first_bar) {
  ZeroedSolution out{solve(factor, options), {}};
  for (std::size_t round = 0; round < names.size(); ++round) {
    std::size_t zero = names.size();
    for (const UnseenCombination& c : unseen_combinations(out.solution, names, terms)) {
      if (std::find(out.zeros.begin(), out.zeros.end(), c.parts[0].unknown) != out.zeros.end()) continue;
      for (const UnseenCombination::Part& part : c.parts) {
        const int ready = readiness(part.unknown, terms, first_bar);
        if (ready >= 0 && (zero == names.size() || ready > readiness(zero, terms, first_bar)))
          zero = part.unknown;
      }
    }
    if (zero == names.size()) break;
    out.zeros.push_back(zero);
    const Eigen::Index rows = factor.rows();
    out.solution = solve(without(factor, out.zeros), options);
    out.solution.rows = rows;
  }
  return out;
}

}  // namespace abbe
