#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace abbe {

/// Where a leaf of an ErrorFunction is known: lo <= v <= hi.
struct VariableDomain {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
};

/// One error as a function of the machine's variables (axis positions, velocities, sensors), in
/// the numbers of its file: variables in the file's units in, error in the file's units out.
///
/// A function is a small tree: leaves are one-dimensional forms of one variable v (or a grid of
/// several), inner nodes are sums, products and the choice by direction of approach.
///
///   constant    c
///   polynomial  c0 + c1 v + c2 v^2 ...
///   table       linear between samples, or the natural cubic spline; held beyond the ends
///   periodic    the same repeated after `period` (cubic: the periodic spline)
///   sine        A sin(w v + phi)
///   grid        multilinear over 1 to 4 variables; held beyond the ends
///   directional forward if approach > 0, backward if approach < 0, their mean if 0
///
/// Every leaf subtracts `reference` from its variable first. A leaf may have a domain [lo, hi] (of
/// v after the reference): outside, its end value is held and `outside` is reported.
///
/// shapes   variables: one number per variable of the machine; approach: the same length, -1 0 +1
/// errors   the factories return nullopt for samples that break the rules above or are not finite
/// laws     InterpolatesItsSamples, SplineHasContinuousSecondDerivative, HeldBeyondItsEnds,
///          DerivativeEqualsDifference, NeverNaN
/// cost     constant and polynomial O(degree), tables O(1) on uniform and O(log n) on other
///          positions; no allocation in value()
/// source   docs/theory/error-functions.md
class ErrorFunction {
 public:
  using Domain = VariableDomain;

  ErrorFunction() = default;  ///< the constant 0
  [[nodiscard]] static ErrorFunction constant(double c);
  [[nodiscard]] static std::optional<ErrorFunction> polynomial(int variable, std::vector<double> coefficients,
                                                               double reference = 0, Domain domain = {});
  enum class Interpolation { linear, cubic };
  /// `period` 0: not periodic. Otherwise positions must span at most one period; a span of exactly
  /// one period needs equal end values.
  [[nodiscard]] static std::optional<ErrorFunction> table(int variable, std::vector<double> positions,
                                                          std::vector<double> values,
                                                          Interpolation interpolation, double reference = 0,
                                                          double period = 0, Domain domain = {});
  [[nodiscard]] static std::optional<ErrorFunction> sine(int variable, double amplitude, double frequency,
                                                         double phase, double reference = 0,
                                                         Domain domain = {});
  /// values: row-major, the last variable fastest.
  [[nodiscard]] static std::optional<ErrorFunction> grid(std::vector<int> variables,
                                                         std::vector<std::vector<double>> positions,
                                                         std::vector<double> values, double reference = 0);
  [[nodiscard]] static ErrorFunction sum(std::vector<ErrorFunction> terms);
  [[nodiscard]] static ErrorFunction product(std::vector<ErrorFunction> factors);
  /// chosen by approach[variable]
  [[nodiscard]] static ErrorFunction directional(int variable, ErrorFunction forward, ErrorFunction backward);

  /// T: double, or a derivative type whose value part is `.a` (Ceres' Jet) or `.value()` (Eigen's
  /// AutoDiffScalar). `outside` (may be null) is set to true when a leaf was held beyond its ends; it
  /// is never cleared. A null `approach` means that no direction is known. At a table node the slope is
  /// that of the segment behind it; where a leaf is held the slope is 0.
  template <class T>
  [[nodiscard]] T value(const T* variables, const signed char* approach, bool* outside) const;

  [[nodiscard]] bool is_constant() const;            ///< no leaf depends on a variable
  [[nodiscard]] bool is_directional() const;         ///< some node depends on the approach
  [[nodiscard]] std::vector<int> variables() const;  ///< of the leaves (not of approach), increasing

  /// Positions of `variable` between which the function is close to quadratic: table nodes, grid
  /// lines, domain ends, sixteenths of sine periods; increasing, each once, lo <= knot <= hi, in the
  /// variable's own numbers (reference added back). Where a path must be looked at. At most kMaxKnots
  /// per leaf: a finer comb is thinned out. lo and hi are finite. Both directions of a choice count.
  static constexpr int kMaxKnots = 100'000;
  [[nodiscard]] std::vector<double> knots(int variable, double lo, double hi) const;

  // The tree, for evaluation in other forms (symbols, packets). Children precede their parent; the
  // last node is the root; an empty vector is the constant 0. From data()[node.data] there are:
  //   constant     c
  //   polynomial   c0 c1 .. (count)
  //   linear       count records x_i e_i s_i: e = e_i + s_i t with t = v - x_i, up to the next x
  //   cubic        count records x_i a_i b_i c_i d_i: e = a_i + b_i t + c_i t^2 + d_i t^3
  //   sine         A w phi
  //   grid         n_1 .. n_d, the d variables, the positions of each variable, the values (d = count)
  // The last record of a table is its end (t = 0); of a periodic one it is the first
  // sample again, one period on, where v never gets.
  enum class Form : std::uint8_t {
    constant,
    polynomial,
    linear,
    cubic,
    sine,
    grid,
    sum,
    product,
    directional
  };
  struct Node {
    Form form = Form::constant;
    bool periodic = false;
    bool uniform = false;  ///< table positions equally spaced
    int variable = -1;     ///< -1: none, or several (grid)
    double reference = 0;
    double lo = -std::numeric_limits<double>::infinity(),
           hi = std::numeric_limits<double>::infinity();  ///< held beyond
    double period = 0;
    double inverse_step = 0;        ///< of uniform positions
    std::uint32_t data = 0;         ///< first number in data()
    std::uint32_t count = 0;        ///< coefficients, records, children or grid dimensions
    std::uint32_t first_child = 0;  ///< in children()
  };
  [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }
  [[nodiscard]] std::span<const double> data() const { return data_; }
  [[nodiscard]] std::span<const std::uint32_t> children() const { return children_; }

 private:
  template <class T>
  [[nodiscard]] T node_value(const Node& node, const T* variables, const signed char* approach,
                             bool* outside) const;
  [[nodiscard]] static ErrorFunction leaf(Node node, std::vector<double> data);
  [[nodiscard]] static ErrorFunction inner(Node node, std::vector<ErrorFunction> children);

  std::vector<Node> nodes_;
  std::vector<double> data_;
  std::vector<std::uint32_t> children_;
};

}  // namespace abbe

#include "abbe/errors/error_function_value.h"
