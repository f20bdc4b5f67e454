#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace abbe {

/// One contribution to an uncertainty: |sensitivity| * u, with the degrees of freedom of u.
struct UncertaintyInput {
  std::string name;
  double u = 0;            ///< standard uncertainty of the input
  double sensitivity = 1;  ///< d result / d input
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
};

struct CombinedUncertainty {
  double u = 0;                                                         ///< combined standard uncertainty
  double degrees_of_freedom = std::numeric_limits<double>::infinity();  ///< effective
  /// Student's quantile for 95 % times u.
  [[nodiscard]] double expanded_95() const;
};

/// The law of propagation of uncertainty:
///
///   u_c^2 = sum (c_i u_i)^2 + 2 sum_(i<j) c_i c_j u_i u_j r_ij,   nu_eff = u_c^4 / sum (c_i u_i)^4 / nu_i
///
/// `correlation`: square, as many rows as inputs; empty = none. The degrees of freedom are for inputs that do
/// not depend on each other; with correlations they are those of the contributions alone.
///
/// errors   nullopt: a number that is not finite or negative, a correlation matrix of the wrong size or
///          beyond +-1, a negative u_c^2
/// laws     GumH1, GumH2
/// source   JCGM 100:2008, 5.1.2, 5.2.2 and G.4.1
[[nodiscard]] std::optional<CombinedUncertainty> combine(const std::vector<UncertaintyInput>& inputs,
                                                         const Eigen::MatrixXd& correlation = {});

/// t with P(|T| <= t) = probability for Student's distribution; infinite degrees of freedom: the normal one.
/// probability in (0, 1), degrees of freedom >= 1 (else they are taken as 1).
/// laws     StudentQuantilesOfTheTable
[[nodiscard]] double student_factor(double probability, double degrees_of_freedom);

/// Standard uncertainty of a quantity that lies anywhere within a range of this width: width / sqrt(12).
[[nodiscard]] double uncertainty_of_range(double width);

}  // namespace abbe
