#pragma once

#include <Eigen/Core>
#include <compare>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

namespace abbe {

/// An unknown of an expression. The indices are the owner's: of moving axes in chain order, of errors
/// in the order in which they are to be printed.
struct Symbol {
  enum class Kind : std::uint8_t {
    cosine,    ///< of the position of rotary axis `index`
    sine,      ///< the same
    position,  ///< of linear axis `index`, mm
    error,     ///< value of an error, mm or rad
  };
  Kind kind = Kind::error;
  int index = 0;

  [[nodiscard]] bool is_trigonometric() const { return kind == Kind::cosine || kind == Kind::sine; }
  friend bool operator==(const Symbol&, const Symbol&) = default;
  /// Cosines and sines by axis, then positions, then errors: the order in which a product is written.
  friend std::strong_ordering operator<=>(const Symbol& a, const Symbol& b);
};

/// A product of symbols, sorted; a power is a repetition. Empty: 1.
using Monomial = std::vector<Symbol>;

/// A polynomial in symbols with numbers in front: the scalar of the symbolic walk.
///
/// Always in the normal form in which sin(A)^2 does not occur (it is 1 - cos(A)^2), so that expressions
/// which are equal for every position and every value of the errors are equal term by term.
///
/// Coefficients are doubles. A sum that cancels to less than 1e-13 of what was added is zero: what
/// rounding leaves of a lever is not a lever.
///
/// laws     SumsAndProductsCommute, ProductsDistributeOverSums, SquaredSineAndCosineAreOne,
///          ValueOfASumIsTheSumOfValues
/// cost     of a product: terms times terms
class Expression {
 public:
  Expression() = default;
  Expression(double constant) { add({}, constant); }  // NOLINT: constants mix freely with symbols
  Expression(Symbol symbol) { add({symbol}, 1); }     // NOLINT

  /// Never a zero coefficient; in the order of monomials.
  [[nodiscard]] const std::map<Monomial, double>& terms() const { return terms_; }
  [[nodiscard]] bool is_zero() const { return terms_.empty(); }

  /// Adds coefficient * product of `symbols` (any order).
  void add(Monomial symbols, double coefficient);

  Expression& operator+=(const Expression& b);
  Expression& operator-=(const Expression& b);
  Expression& operator*=(const Expression& b) { return *this = *this * b; }
  friend Expression operator+(Expression a, const Expression& b) { return a += b; }
  friend Expression operator-(Expression a, const Expression& b) { return a -= b; }
  friend Expression operator-(const Expression& a);
  friend Expression operator*(const Expression& a, const Expression& b);
  friend bool operator==(const Expression&, const Expression&) = default;

  /// The derivative by a symbol that is a variable of its own (an error, a linear position).
  [[nodiscard]] Expression derivative(Symbol by) const;

  [[nodiscard]] double value(const std::function<double(Symbol)>& value_of) const;

 private:
  std::map<Monomial, double> terms_;
};

}  // namespace abbe

template <>
struct Eigen::NumTraits<abbe::Expression> : Eigen::GenericNumTraits<double> {
  using Real = abbe::Expression;
  using NonInteger = abbe::Expression;
  using Nested = abbe::Expression;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 100,
    AddCost = 100,
    MulCost = 1000
  };
};
