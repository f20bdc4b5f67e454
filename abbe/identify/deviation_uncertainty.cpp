#include "abbe/identify/deviation_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "abbe/identify/covered.h"
#include "abbe/identify/error_effects.h"

namespace abbe {
namespace {

constexpr int kPlaces = 9;  // per axis of the grid

/// The box of the tests as a grid; an axis that they do not move has one place.
class Grid {
 public:
  explicit Grid(const std::vector<Covered>& covered) : covered_(covered) {
    for (const Covered& axis : covered) {
      places_.push_back(axis.hi > axis.lo ? kPlaces : 1);
      size_ *= places_.back();
    }
  }
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] AxisState at(int index) const {
    AxisState state;
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const double part = places_[k] == 1 ? 0.0 : double(index % places_[k]) / (places_[k] - 1);
      state.q[k] = covered_[k].lo + part * (covered_[k].hi - covered_[k].lo);
      index /= places_[k];
    }
    return state;
  }

 private:
  const std::vector<Covered>& covered_;
  std::vector<int> places_;
  int size_ = 1;
};

}  // namespace

DeviationUncertainty uncertainty_of_deviation(const Machine& machine, const Identification& found,
                                              const std::vector<BallbarTest>& tests) {
  std::vector<ModelTerm> terms;
  for (const IdentifiedTerm& term : found.terms) terms.push_back(term.term);
  const auto m = static_cast<Eigen::Index>(terms.size());
  const Eigen::MatrixXd covariance = found.covariance.topLeftCorner(m, m);
  const ErrorEffects effects(machine, terms);
  const std::vector<Covered> covered = covered_by(machine, tests);
  const Grid grid(covered);
  DeviationUncertainty out;
  double squares = 0;
  Eigen::Matrix<double, 3, Eigen::Dynamic> jacobian(3, m);
  for (int i = 0; i < grid.size(); ++i) {
    const AxisState state = grid.at(i);
    for (Eigen::Index k = 0; k < m; ++k) {
      const auto term = static_cast<std::size_t>(k);
      jacobian.col(k) = effects.of(term, state) * basis(terms[term], state);
    }
    // u^2 = diag(J C J^T)
    const Vec3 square = (jacobian * covariance).cwiseProduct(jacobian).rowwise().sum().cwiseMax(0.0);
    squares += square.sum();
    if (i > 0 && std::sqrt(square.sum()) <= out.worst) continue;
    out.worst = std::sqrt(square.sum());
    out.u = square.cwiseSqrt();
    out.at.assign(state.q.begin(), state.q.begin() + static_cast<std::ptrdiff_t>(covered.size()));
  }
  out.rms = std::sqrt(squares / grid.size());
  for (const Covered& axis : covered) {
    out.least.push_back(axis.lo);
    out.most.push_back(axis.hi);
  }
  return out;
}

}  // namespace abbe
