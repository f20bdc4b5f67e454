#include "abbe/fit/function_model.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "abbe/errors/spline.h"

namespace abbe {
namespace {

constexpr double kRankOfGauge = 1e-10;

/// Legendre polynomials P_0 .. P_n of x in -1..1:  (k + 1) P_(k+1) = (2 k + 1) x P_k - k P_(k-1)
void write_legendre(int n, double x, Eigen::RowVectorXd& p) {
  p[0] = 1;
  if (n > 0) p[1] = x;
  for (int k = 1; k < n; ++k) p[k + 1] = ((2 * k + 1) * x * p[k] - k * p[k - 1]) / (k + 1);
}

/// Coefficients of sum c_k P_k as powers of x, by the same recursion.
std::vector<double> powers_of(const Eigen::VectorXd& c) {
  const auto n = static_cast<std::size_t>(c.size());
  std::vector<double> sum(n, 0.0), before(n, 0.0), now(n, 0.0);
  now[0] = 1;
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) sum[i] += c[static_cast<Eigen::Index>(k)] * now[i];
    std::vector<double> next(n, 0.0);
    const auto d = static_cast<double>(k);
    for (std::size_t i = 0; i < n; ++i)
      next[i] = ((i > 0 ? (2 * d + 1) * now[i - 1] : 0.0) - d * before[i]) / (d + 1);
    before = std::exchange(now, next);
  }
  return sum;
}

/// The piece of a table that holds v, by the index of its left node.
std::size_t piece_of(const std::vector<double>& nodes, double v) {
  const auto above = std::upper_bound(nodes.begin() + 1, nodes.end() - 1, v);
  return static_cast<std::size_t>(above - nodes.begin()) - 1;
}

/// Column j: second derivatives of the natural spline that is 1 at node j and 0 at the others.
Eigen::MatrixXd cardinal_curvatures(const std::vector<double>& nodes) {
  const auto n = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    std::vector<double> unit(nodes.size(), 0.0);
    unit[static_cast<std::size_t>(j)] = 1;
    const std::vector<double> m = natural_spline(nodes, unit);
    out.col(j) = Eigen::Map<const Eigen::VectorXd>(m.data(), n);
  }
  return out;
}

}  // namespace

std::string file_number(double value) { return fmt::format("{:.10g}", value + 0.0); }

FunctionModel::FunctionModel(FunctionForm form, FunctionGauge gauge, double lo, double hi)
    : form_(std::move(form)), lo_(lo), hi_(hi) {
  if (form_.kind == FunctionForm::Kind::cubic) second_ = cardinal_curvatures(form_.nodes);
  Eigen::RowVectorXd values;
  raw(lo, values);
  const Eigen::Index n = values.size();
  // Gauge: sum phi_j(reference) c_j = 0, and sum over the samples of t phi_j c_j = 0
  Eigen::MatrixXd gauges = Eigen::MatrixXd::Zero(n, 2);
  if (gauge.reference) {
    raw(*gauge.reference, values);
    gauges.col(0) = values.transpose();
  }
  for (int i = 0; gauge.without_trend && i < kTrendSamples; ++i) {
    const double t = -1 + 2.0 * i / (kTrendSamples - 1);
    raw(0.5 * (lo + hi) + 0.5 * t * (hi - lo), values);
    gauges.col(1) += t * values.transpose();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(gauges);
  qr.setThreshold(kRankOfGauge);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(n, n);
  free_ = q.rightCols(n - qr.rank());
}

Eigen::Index FunctionModel::main_count() const {
  return form_.kind == FunctionForm::Kind::polynomial ? form_.order + 1
                                                      : static_cast<Eigen::Index>(form_.nodes.size());
}

void FunctionModel::raw(double v, Eigen::RowVectorXd& out) const {
  v = std::clamp(v, lo_, hi_);
  out.setZero(main_count() + 2 * form_.harmonics);
  if (form_.kind == FunctionForm::Kind::polynomial) {
    write_legendre(form_.order, (2 * v - lo_ - hi_) / (hi_ - lo_), out);
  } else {
    const double u = std::clamp(v, form_.nodes.front(), form_.nodes.back());
    const std::size_t k = piece_of(form_.nodes, u);
    const auto i = static_cast<Eigen::Index>(k);
    const double h = form_.nodes[k + 1] - form_.nodes[k], b = (u - form_.nodes[k]) / h, a = 1 - b;
    out[i] += a;
    out[i + 1] += b;
    // f = a y_k + b y_(k+1) + h^2 / 6 ((a^3 - a) m_k + (b^3 - b) m_(k+1))
    if (form_.kind == FunctionForm::Kind::cubic)
      out.head(main_count()) +=
          h * h / 6 * ((a * a * a - a) * second_.row(i) + (b * b * b - b) * second_.row(i + 1));
  }
  for (int k = 1; k <= form_.harmonics; ++k) {
    const double angle = 2 * std::numbers::pi * k * v / form_.pitch;
    out[main_count() + 2 * k - 2] = std::sin(angle);
    out[main_count() + 2 * k - 1] = std::cos(angle);
  }
}

void FunctionModel::row(double v, Eigen::RowVectorXd& out, Eigen::RowVectorXd& scratch) const {
  raw(v, scratch);
  out.resize(free_.cols());
  for (Eigen::Index j = 0; j < free_.cols(); ++j) out[j] = scratch.dot(free_.col(j).transpose());
}

Eigen::RowVectorXd FunctionModel::row(double v) const {
  Eigen::RowVectorXd out, scratch;
  row(v, out, scratch);
  return out;
}

std::string FunctionModel::main_text(const Eigen::VectorXd& c) const {
  const std::string domain = fmt::format("domain = [{}, {}]", file_number(lo_), file_number(hi_));
  if (form_.kind == FunctionForm::Kind::polynomial) {
    const double middle = 0.5 * (lo_ + hi_), half = 0.5 * (hi_ - lo_);
    std::vector<double> powers = powers_of(c.head(main_count()));
    std::string text;
    double scale = 1;
    for (const double power : powers) {
      text += (text.empty() ? "" : ", ") + file_number(power / scale);
      scale *= half;
    }
    return fmt::format("{{ poly = [{}], reference = {}, {} }}", text, file_number(middle), domain);
  }
  std::string text;
  for (std::size_t i = 0; i < form_.nodes.size(); ++i)
    text += fmt::format("{}[{}, {}]", i == 0 ? "" : ", ", file_number(form_.nodes[i]),
                        file_number(c[static_cast<Eigen::Index>(i)]));
  const char* cubic = form_.kind == FunctionForm::Kind::cubic ? ", interpolation = \"cubic\"" : "";
  return fmt::format("{{ table = [{}]{} }}", text, cubic);
}

std::string FunctionModel::text(const Eigen::VectorXd& z) const {
  const Eigen::VectorXd c = free_ * z;
  std::string text = main_text(c);
  for (int k = 1; k <= form_.harmonics; ++k) {
    // s sin + c cos = A sin(w v + phi)
    const double s = c[main_count() + 2 * k - 2], cosine = c[main_count() + 2 * k - 1];
    text += fmt::format(", {{ sine = [{}, {:.17g}, {}], domain = [{}, {}] }}",
                        file_number(std::hypot(s, cosine)), 2 * std::numbers::pi * k / form_.pitch,
                        file_number(std::atan2(cosine, s)), file_number(lo_), file_number(hi_));
  }
  return text;
}

std::string FunctionModel::describe() const {
  std::string text;
  switch (form_.kind) {
    case FunctionForm::Kind::polynomial:
      text = fmt::format("polynomial of order {}", form_.order);
      break;
    case FunctionForm::Kind::table:
      text = fmt::format("table of {} values", form_.nodes.size());
      break;
    case FunctionForm::Kind::cubic:
      text = fmt::format("cubic spline of {} values", form_.nodes.size());
      break;
  }
  if (form_.harmonics > 0) text += fmt::format(", {} harmonics of {} pitch", form_.harmonics, form_.pitch);
  return text;
}

}  // namespace abbe
