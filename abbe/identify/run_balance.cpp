#include "abbe/identify/run_balance.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>

namespace abbe {
namespace {

constexpr std::size_t kMostSamplesOfShare = 720;  // evenly thinned: a share needs no more

double rms(const std::vector<double>& values) {
  double square = 0;
  for (const double v : values) square += v * v;
  return values.empty() ? 0.0 : std::sqrt(square / static_cast<double>(values.size()));
}

/// Columns: draws of the first m unknowns around their values, with the symmetric root of their correlation:
/// it is one whatever order and signs eigenvectors come in.
Eigen::MatrixXd draws(const Identification& identification, Eigen::Index m) {
  const Eigen::MatrixXd covariance = identification.covariance.topLeftCorner(m, m);
  const Eigen::VectorXd deviation = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd unit = deviation.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(unit.asDiagonal() * covariance *
                                                             unit.asDiagonal());
  const Eigen::MatrixXd& v = eigen.eigenvectors();
  const Eigen::MatrixXd root =
      deviation.asDiagonal() * v * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() * v.transpose();
  std::mt19937_64 random(20260302);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd out(m, kDraws);
  for (int k = 0; k < kDraws; ++k) {
    Eigen::VectorXd z(m);
    for (Eigen::Index i = 0; i < m; ++i) z[i] = normal(random);
    out.col(k) = identification.values.head(m) + root * z;
  }
  return out;
}

/// 2.5 % and 97.5 % of one member of the shares.
template <class Member>
void interval(std::vector<DynamicShare>& shares, Member member, double& low, double& high) {
  std::sort(shares.begin(), shares.end(),
            [&](const DynamicShare& a, const DynamicShare& b) { return a.*member < b.*member; });
  const auto at = [&](double part) { return shares[static_cast<std::size_t>(part * (kDraws - 1))].*member; };
  low = at(0.025);
  high = at(0.975);
}

class Balancer {
 public:
  Balancer(const Identification& identification, const JointDesign& design, const RunClocks& clocks)
      : identification_(identification),
        design_(design),
        clocks_(clocks),
        m_(static_cast<Eigen::Index>(design.terms().size())),
        draws_(draws(identification, m_)) {}

  RunBalance of(std::size_t test, std::size_t run) const {
    RunBalance out;
    out.test = test;
    out.run = run;
    const BallbarRun& record = design_.tests()[test].runs[run];
    std::vector<double> row(design_.unknowns()), servo, statics, dynamics, measured, residual;
    const std::size_t thin = record.angle.size() / kMostSamplesOfShare + 1;
    std::vector<Eigen::VectorXd> rows;
    std::vector<double> servo_of_rows;
    for (std::size_t i = 0; i < record.angle.size(); ++i) {
      design_.row(test, run, i, clocks_.at(test, run), row);
      const auto x = Eigen::Map<const Eigen::VectorXd>(row.data(), static_cast<Eigen::Index>(row.size()));
      const auto [s, d] = split(x.head(m_), identification_.values.head(m_));
      const double set_up = x.tail(x.size() - m_).dot(identification_.values.segment(m_, x.size() - m_));
      servo.push_back(design_.servo_part(test, run, i));
      statics.push_back(s);
      dynamics.push_back(d);
      measured.push_back(record.deviation[i] - set_up);
      residual.push_back(measured.back() - servo.back() - s - d);
      if (i % thin != 0) continue;
      rows.emplace_back(x.head(m_));
      servo_of_rows.push_back(servo.back());
    }
    out.measured = rms(measured);
    out.servo = rms(servo);
    out.statics = rms(statics);
    out.dynamics = rms(dynamics);
    out.residual = rms(residual);
    fill_shares(out, rows, servo_of_rows);
    out.time_offset = clocks_.at(test, run);
    const auto clock = static_cast<Eigen::Index>(design_.unknowns() + clocks_.index(test, run));
    if (clock < identification_.covariance.rows())
      out.time_uncertainty = std::sqrt(std::max(0.0, identification_.covariance(clock, clock)));
    return out;
  }

 private:
  /// Static and dynamic part of a row.
  [[nodiscard]] std::pair<double, double> split(const Eigen::VectorXd& row,
                                                const Eigen::VectorXd& values) const {
    double parts[2] = {0, 0};
    for (Eigen::Index k = 0; k < m_; ++k)
      parts[design_.terms()[static_cast<std::size_t>(k)].is_dynamic() ? 1 : 0] += row[k] * values[k];
    return {parts[0], parts[1]};
  }

  [[nodiscard]] DynamicShare share(const std::vector<Eigen::VectorXd>& rows, const std::vector<double>& servo,
                                   const Eigen::VectorXd& values) const {
    std::vector<double> statics, dynamics;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto [s, d] = split(rows[i], values);
      statics.push_back(s);
      dynamics.push_back(d + servo[i]);
    }
    return dynamic_share(statics, dynamics);
  }

  void fill_shares(RunBalance& out, const std::vector<Eigen::VectorXd>& rows,
                   const std::vector<double>& servo) const {
    out.share = share(rows, servo, identification_.values.head(m_));
    std::vector<DynamicShare> shares;
    for (Eigen::Index k = 0; k < draws_.cols(); ++k) shares.push_back(share(rows, servo, draws_.col(k)));
    interval(shares, &DynamicShare::l1, out.low.l1, out.high.l1);
    interval(shares, &DynamicShare::rms, out.low.rms, out.high.rms);
    interval(shares, &DynamicShare::energy, out.low.energy, out.high.energy);
  }

  const Identification& identification_;
  const JointDesign& design_;
  const RunClocks& clocks_;
  Eigen::Index m_;
  Eigen::MatrixXd draws_;
};

}  // namespace

std::vector<RunBalance> run_balances(const Identification& identification, const JointDesign& design,
                                     const RunClocks& clocks) {
  const Balancer balancer(identification, design, clocks);
  std::vector<RunBalance> out;
  for (std::size_t t = 0; t < design.tests().size(); ++t)
    for (std::size_t r = 0; r < design.tests()[t].runs.size(); ++r) out.push_back(balancer.of(t, r));
  return out;
}

}  // namespace abbe
