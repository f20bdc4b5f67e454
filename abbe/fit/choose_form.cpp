#include "abbe/fit/choose_form.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Rows of the unknowns: the function, an offset, and for straightness a slope.
Eigen::MatrixXd design(const FunctionModel& model, const FunctionGauge& gauge,
                       const std::vector<CoursePoint>& course) {
  const Eigen::Index n = model.parameters(), extra = gauge.without_trend ? 2 : 1;
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(course.size()), n + extra);
  for (std::size_t i = 0; i < course.size(); ++i) {
    const auto r = static_cast<Eigen::Index>(i);
    const double v = course[i].position;
    rows.row(r).head(n) = model.row(v);
    rows(r, n) = 1;
    if (gauge.without_trend) rows(r, n + 1) = (v - model.lo()) / (model.hi() - model.lo());
  }
  return rows;
}

}  // namespace

std::vector<double> even_nodes(double lo, double hi, std::size_t count) {
  std::vector<double> nodes;
  for (std::size_t i = 0; i < count; ++i)
    nodes.push_back(lo + (hi - lo) * static_cast<double>(i) / static_cast<double>(count - 1));
  nodes.back() = hi;
  return nodes;
}

LeftOut left_out(const FunctionForm& form, const FunctionGauge& gauge,
                 const std::vector<CoursePoint>& course) {
  const FunctionModel model(form, gauge, course.front().position, course.back().position);
  const Eigen::MatrixXd rows = design(model, gauge, course);
  if (rows.cols() >= rows.rows()) return {kInfinity, 0};
  Eigen::VectorXd values(rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i) values[i] = course[static_cast<std::size_t>(i)].value;
  // Left out one by one without fitting again:  e_i = r_i / (1 - h_ii),  h = diagonal of Q Q^T
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(rows.rows(), qr.rank());
  const Eigen::VectorXd residual = values - q * (q.transpose() * values);
  const Eigen::ArrayXd free = 1 - q.rowwise().squaredNorm().array();
  if (!(free > 1e-9).all()) return {kInfinity, 0};
  const Eigen::ArrayXd squares = (residual.array() / free).square();
  const auto n = static_cast<double>(squares.size());
  return {squares.mean(), std::sqrt((squares - squares.mean()).square().sum() / (n * (n - 1)))};
}

FunctionForm choose_form(const FunctionGauge& gauge, const std::vector<CoursePoint>& course, int most_order) {
  std::vector<FunctionForm> candidates;
  for (int order = gauge.without_trend ? 2 : 1; order <= most_order; ++order)
    candidates.push_back({FunctionForm::Kind::polynomial, order, {}, 0, 0});
  for (std::size_t count = 4; count + 2 <= course.size(); count += 2)
    candidates.push_back({FunctionForm::Kind::cubic, 0,
                          even_nodes(course.front().position, course.back().position, count), 0, 0});
  std::vector<LeftOut> judged;
  LeftOut best{kInfinity, 0};
  for (const FunctionForm& form : candidates) {
    judged.push_back(left_out(form, gauge, course));
    if (judged.back().mean_square < best.mean_square) best = judged.back();
  }
  // A course without scatter is met by every higher order: rounding is no reason for one.
  constexpr double kRounding = 1e-16;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (judged[i].mean_square <= best.mean_square + best.u + kRounding) return candidates[i];
  return {FunctionForm::Kind::polynomial, gauge.without_trend ? 2 : 1, {}, 0, 0};
}

}  // namespace abbe
