#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace abbe {

/// The form in which an error function is looked for.
struct FunctionForm {
  enum class Kind {
    polynomial,  ///< of `order`
    table,       ///< linear between `nodes`
    cubic,       ///< natural cubic spline through values at `nodes`
  };
  Kind kind = Kind::polynomial;
  int order = 1;
  std::vector<double> nodes;  ///< strictly increasing, at least two
  double pitch = 0;           ///< > 0: sine and cosine of this period and of its fractions are added
  int harmonics = 0;
};

/// How an unknown function is tied down: what cannot be told from something else is fixed here, not by
/// chance.
struct FunctionGauge {
  std::optional<double> reference;  ///< f(reference) = 0
  bool without_trend =
      false;  ///< the least-squares slope over lo..hi is 0 (straightness: the slope is squareness)
};

/// An unknown function of one position v, linear in its parameters:
///
///   f(v) = sum_j c_j phi_j(v),   c = Z z
///
/// phi are Legendre polynomials of the range, hats or cardinal splines at nodes, sines and cosines; the
/// columns of Z span the coefficients that keep the gauge. Beyond lo..hi the end value is held, as the
/// machine file does.
///
/// units    positions mm or deg, values um or urad: those of the errors file that is written
/// laws     GaugeIsKept, TextReadsBackToTheSameFunction
/// cost     row: O(nodes * order)
class FunctionModel {
 public:
  FunctionModel() = default;
  /// lo < hi, both finite.
  FunctionModel(FunctionForm form, FunctionGauge gauge, double lo, double hi);

  [[nodiscard]] Eigen::Index parameters() const { return free_.cols(); }
  [[nodiscard]] double lo() const { return lo_; }
  [[nodiscard]] double hi() const { return hi_; }
  [[nodiscard]] const FunctionForm& form() const { return form_; }

  /// d f(v) / d z.
  [[nodiscard]] Eigen::RowVectorXd row(double v) const;
  /// The same into `out`, with `scratch` for what comes before the gauge: nothing is allocated once it has
  /// grown.
  void row(double v, Eigen::RowVectorXd& out, Eigen::RowVectorXd& scratch) const;

  /// The function in words of an errors file, with its domain: "{ poly = [..], .. }" or a list.
  [[nodiscard]] std::string text(const Eigen::VectorXd& z) const;

  /// "polynomial of order 3", "cubic spline through 7 values".
  [[nodiscard]] std::string describe() const;

 private:
  void raw(double v, Eigen::RowVectorXd& out) const;
  [[nodiscard]] std::string main_text(const Eigen::VectorXd& c) const;
  [[nodiscard]] Eigen::Index main_count() const;

  FunctionForm form_;
  double lo_ = 0, hi_ = 1;
  Eigen::MatrixXd second_;  ///< cubic: second derivatives at the nodes for a unit value at each node
  Eigen::MatrixXd free_;    ///< Z
};

/// Number of samples of a range that trends are taken over; the machine file's check uses the same.
inline constexpr int kTrendSamples = 101;

/// A number for an errors file: ten significant digits.
[[nodiscard]] std::string file_number(double value);

}  // namespace abbe
