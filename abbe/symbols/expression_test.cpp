#include "abbe/symbols/expression.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "abbe/symbols/grouping.h"

namespace abbe {
namespace {

constexpr double kRounding = 1e-11;  // of sums of a hundred products of numbers up to ten

using Kind = Symbol::Kind;
const Symbol kCosine{Kind::cosine, 0}, kSine{Kind::sine, 0}, kX{Kind::position, 1}, kError{Kind::error, 0};

/// Small random polynomials in two angles, two positions and three errors.
class RandomExpressions {
 public:
  explicit RandomExpressions(unsigned seed) : random_(seed) {}

  [[nodiscard]] int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  [[nodiscard]] double number() { return static_cast<double>(below(1999) - 999) / 100; }

  [[nodiscard]] Symbol symbol() {
    const auto kind = static_cast<Kind>(below(4));
    return {kind, below(kind == Kind::error ? 3 : 2)};
  }

  [[nodiscard]] Expression expression() {
    Expression e;
    for (int terms = below(5); terms > 0; --terms) {
      Monomial product;
      for (int factors = below(4); factors > 0; --factors) product.push_back(symbol());
      e.add(product, number());
    }
    return e;
  }

  /// Values of all symbols: sines and cosines of real angles.
  [[nodiscard]] std::function<double(Symbol)> point() {
    std::vector<double> values;
    for (int i = 0; i < 7; ++i) values.push_back(number());
    return [values](Symbol s) {
      const auto index = static_cast<std::size_t>(s.index);
      switch (s.kind) {
        case Kind::cosine:
          return std::cos(values[index]);
        case Kind::sine:
          return std::sin(values[index]);
        case Kind::position:
          return values[2 + index];
        case Kind::error:
          break;
      }
      return values[4 + index];
    };
  }

 private:
  std::mt19937 random_;
};

/// Equal but for rounding: all that is left of the difference is dust.
bool is_dust(const Expression& difference) {
  for (const auto& [monomial, coefficient] : difference.terms()) {
    if (std::abs(coefficient) > kRounding * 1000) return false;
  }
  return true;
}

TEST(Expression, ZeroIsEmptyAndNumbersThatAreNotFiniteNeverEnter) {
  EXPECT_TRUE(Expression(0.0).is_zero());
  EXPECT_TRUE((Expression(kX) - Expression(kX)).is_zero());
  EXPECT_TRUE(Expression(std::nan("")).is_zero());
  Expression e(kX);
  e += e;
  EXPECT_EQ(e, Expression(2) * Expression(kX));
  const Expression& alias = e;
  e -= alias;
  EXPECT_TRUE(e.is_zero());
}

TEST(Expression, WhatRoundingLeavesOfALeverIsNoLever) {
  EXPECT_TRUE((Expression(0.3) - Expression(0.1) - Expression(0.2)).is_zero());
  EXPECT_TRUE((Expression(1000.1) - Expression(1000) - Expression(1000.1 - 1000)).is_zero());
  EXPECT_FALSE((Expression(1000.000001) - Expression(1000)).is_zero());
}

TEST(Expression, SquaredSineAndCosineAreOne) {
  const Expression s(kSine), c(kCosine);
  EXPECT_EQ(s * s + c * c, Expression(1));
  EXPECT_EQ(s * s * s * s, Expression(1) - Expression(2) * c * c + c * c * c * c);
  // Of different axes they do not mix.
  const Expression other(Symbol{Kind::cosine, 1});
  EXPECT_NE(s * s + other * other, Expression(1));
  EXPECT_EQ((s * kX + c) * (s * kX + c) + (c * kX - s) * (c * kX - s),
            Expression(1) + Expression(kX) * Expression(kX));
}

TEST(Expression, SumsAndProductsCommute) {
  RandomExpressions random(1);
  for (int i = 0; i < 200; ++i) {
    const Expression a = random.expression(), b = random.expression(), c = random.expression();
    EXPECT_TRUE(is_dust((a + b) - (b + a)));
    EXPECT_TRUE(is_dust(a * b - b * a));
    EXPECT_TRUE(is_dust((a * b) * c - a * (b * c)));
  }
}

TEST(Expression, ProductsDistributeOverSums) {
  RandomExpressions random(2);
  for (int i = 0; i < 200; ++i) {
    const Expression a = random.expression(), b = random.expression(), c = random.expression();
    EXPECT_TRUE(is_dust(a * (b - c) - (a * b - a * c)));
  }
}

TEST(Expression, ValueOfASumIsTheSumOfValues) {
  RandomExpressions random(3);
  for (int i = 0; i < 200; ++i) {
    const Expression a = random.expression(), b = random.expression();
    const auto at = random.point();
    const double x = a.value(at), y = b.value(at);
    const double size = 1 + std::abs(x) + std::abs(y) + std::abs(x * y);
    EXPECT_NEAR((a + b).value(at), x + y, kRounding * size);
    EXPECT_NEAR((a - b).value(at), x - y, kRounding * size);
    EXPECT_NEAR((a * b).value(at), x * y, 1e4 * kRounding * size);
    EXPECT_NEAR((-a).value(at), -x, kRounding * size);
  }
}

TEST(Expression, DerivativeOfAProductFollowsLeibniz) {
  RandomExpressions random(4);
  for (int i = 0; i < 200; ++i) {
    const Expression a = random.expression(), b = random.expression();
    const Symbol by{Kind::error, 1};
    EXPECT_TRUE(is_dust((a * b).derivative(by) - (a.derivative(by) * b + a * b.derivative(by))));
  }
  EXPECT_EQ((Expression(kError) * kError * kX).derivative(kError),
            Expression(2) * Expression(kError) * Expression(kX));
}

double value(const GroupedSum& sum, const std::function<double(Symbol)>& at) {
  double total = 0;
  for (const GroupedTerm& term : sum.terms) {
    double product = term.negative ? -term.number : term.number;
    for (const GroupedFactor& factor : term.factors)
      product *= factor.bracket ? value(*factor.bracket, at) : at(factor.symbol);
    total += product;
  }
  return total;
}

TEST(GroupTerms, GroupingKeepsTheValue) {
  RandomExpressions random(5);
  for (int i = 0; i < 400; ++i) {
    // Products make levers with several terms, and levers that several errors share.
    const Expression e = random.expression() * random.expression() + random.expression();
    const auto at = random.point();
    double size = 1;
    for (const auto& [monomial, coefficient] : e.terms()) {
      Expression term;
      term.add(monomial, coefficient);
      size += std::abs(term.value(at));
    }
    EXPECT_NEAR(value(group_terms(e), at), e.value(at), kRounding * size);
  }
}

}  // namespace
}  // namespace abbe
