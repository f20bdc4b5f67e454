#include "abbe/symbols/expression.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace abbe {
namespace {

constexpr double kDust = 1e-13;  // of the larger of two numbers that cancel

/// sin(A) sin(A) at the front of the range, or its end.
Monomial::iterator squared_sine(Monomial& m) {
  return std::adjacent_find(m.begin(), m.end(), [](const Symbol& a, const Symbol& b) {
    return a == b && a.kind == Symbol::Kind::sine;
  });
}

}  // namespace

std::strong_ordering operator<=>(const Symbol& a, const Symbol& b) {
  const auto key = [](const Symbol& s) {
    return std::tuple(s.is_trigonometric() ? 0 : static_cast<int>(s.kind), s.index, static_cast<int>(s.kind));
  };
  return key(a) <=> key(b);
}

void Expression::add(Monomial symbols, double coefficient) {
  if (coefficient == 0 || !std::isfinite(coefficient)) return;
  std::sort(symbols.begin(), symbols.end());
  const auto square = squared_sine(symbols);
  if (square != symbols.end()) {
    // sin^2 = 1 - cos^2
    const Symbol cosine{Symbol::Kind::cosine, square->index};
    symbols.erase(square, square + 2);
    add(symbols, coefficient);
    symbols.insert(symbols.end(), 2, cosine);
    add(std::move(symbols), -coefficient);
    return;
  }
  const auto [at, is_new] = terms_.try_emplace(std::move(symbols), coefficient);
  if (is_new) return;
  const double larger = std::max(std::abs(at->second), std::abs(coefficient));
  at->second += coefficient;
  if (std::abs(at->second) <= kDust * larger) terms_.erase(at);
}

Expression& Expression::operator+=(const Expression& b) {
  if (&b == this) return *this += Expression(b);
  for (const auto& [monomial, coefficient] : b.terms_) add(monomial, coefficient);
  return *this;
}

Expression& Expression::operator-=(const Expression& b) {
  if (&b == this) return *this = Expression();
  for (const auto& [monomial, coefficient] : b.terms_) add(monomial, -coefficient);
  return *this;
}

Expression operator-(const Expression& a) {
  Expression negative = a;
  for (auto& [monomial, coefficient] : negative.terms_) coefficient = -coefficient;
  return negative;
}

Expression operator*(const Expression& a, const Expression& b) {
  Expression product;
  for (const auto& [left, x] : a.terms_) {
    for (const auto& [right, y] : b.terms_) {
      Monomial symbols = left;
      symbols.insert(symbols.end(), right.begin(), right.end());
      product.add(std::move(symbols), x * y);
    }
  }
  return product;
}

Expression Expression::derivative(Symbol by) const {
  Expression result;
  for (const auto& [monomial, coefficient] : terms_) {
    const auto power = std::count(monomial.begin(), monomial.end(), by);
    if (power == 0) continue;
    Monomial lower = monomial;
    lower.erase(std::find(lower.begin(), lower.end(), by));
    result.add(std::move(lower), coefficient * static_cast<double>(power));
  }
  return result;
}

double Expression::value(const std::function<double(Symbol)>& value_of) const {
  double sum = 0;
  for (const auto& [monomial, coefficient] : terms_) {
    double product = coefficient;
    for (const Symbol& symbol : monomial) product *= value_of(symbol);
    sum += product;
  }
  return sum;
}

}  // namespace abbe
