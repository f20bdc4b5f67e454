#include "abbe/symbols/grouping.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace abbe {
namespace {

constexpr double kSame = 1e-12;  // relative: rounding of levers that are meant to be equal

bool same(double a, double b) { return std::abs(a - b) <= kSame * std::max(std::abs(a), std::abs(b)); }

using Coefficient = std::pair<Monomial, double>;
using Polynomial = std::vector<Coefficient>;  // of positions, in the order of print, a constant last

/// Errors that share a lever up to its sign: the sum of +-errors times lever.
struct Lever {
  Polynomial polynomial;                            // first coefficient positive
  std::vector<std::pair<bool, Monomial>> products;  // negative?, errors
};

struct Split {
  Monomial trigonometric, positions, errors;
};

Split split(const Monomial& monomial) {
  Split parts;
  for (const Symbol& symbol : monomial) {
    if (symbol.is_trigonometric()) {
      parts.trigonometric.push_back(symbol);
    } else if (symbol.kind == Symbol::Kind::position) {
      parts.positions.push_back(symbol);
    } else {
      parts.errors.push_back(symbol);
    }
  }
  return parts;
}

bool is_same_lever(const Polynomial& a, const Polynomial& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& x, const auto& y) {
           return x.first == y.first && same(x.second, y.second);
         });
}

/// Positions in their order, the constant last.
void sort_for_print(Polynomial& polynomial) {
  std::sort(polynomial.begin(), polynomial.end(), [](const Coefficient& a, const Coefficient& b) {
    return std::pair(a.first.empty(), a.first) < std::pair(b.first.empty(), b.first);
  });
}

/// Errors alone, then levers by their first position, then plain numbers.
auto rank(const Lever& lever) {
  const auto& [monomial, coefficient] = lever.polynomial.front();
  const bool is_number = monomial.empty();
  const bool is_unit = is_number && same(coefficient, 1);
  return std::tuple(is_unit     ? 0
                    : is_number ? 2
                                : 1,
                    is_number ? Monomial{} : monomial, lever.products.front().second);
}

std::vector<GroupedFactor> as_factors(const Monomial& monomial) {
  std::vector<GroupedFactor> factors;
  for (const Symbol& symbol : monomial) factors.push_back({symbol, nullptr});
  return factors;
}

/// The sum as a factor of `term`: its sign goes outside, a single term is multiplied in.
void multiply(GroupedTerm& term, GroupedSum sum) {
  if (sum.terms.front().negative) {
    term.negative = !term.negative;
    for (GroupedTerm& inner : sum.terms) inner.negative = !inner.negative;
  }
  if (sum.terms.size() == 1) {
    term.number *= sum.terms.front().number;
    for (GroupedFactor& factor : sum.terms.front().factors) term.factors.push_back(std::move(factor));
    return;
  }
  term.factors.push_back({{}, std::make_shared<const GroupedSum>(std::move(sum))});
}

GroupedSum polynomial_sum(const Polynomial& polynomial) {
  GroupedSum sum;
  for (const auto& [monomial, coefficient] : polynomial)
    sum.terms.push_back({coefficient < 0, std::abs(coefficient), as_factors(monomial)});
  return sum;
}

/// lever * (errors), with a number that all coefficients of the lever share in front.
GroupedTerm lever_term(const Lever& lever) {
  GroupedTerm term;
  Polynomial polynomial = lever.polynomial;
  const double first = polynomial.front().second;
  if (std::all_of(polynomial.begin(), polynomial.end(),
                  [&](const Coefficient& c) { return same(std::abs(c.second), first); })) {
    term.number = same(first, 1) ? 1 : first;
    for (Coefficient& c : polynomial) c.second = c.second < 0 ? -1 : 1;
  }
  multiply(term, polynomial_sum(polynomial));
  GroupedSum errors;
  for (const auto& [negative, product] : lever.products)
    errors.terms.push_back({negative, 1, as_factors(product)});
  multiply(term, std::move(errors));
  return term;
}

GroupedSum sum_of_levers(std::vector<Lever> levers) {
  std::stable_sort(levers.begin(), levers.end(),
                   [](const Lever& a, const Lever& b) { return rank(a) < rank(b); });
  GroupedSum sum;
  for (const Lever& lever : levers) {
    const bool no_error = lever.products.front().second.empty();
    const bool alone = lever.polynomial.front().first.empty() && same(lever.polynomial.front().second, 1);
    if (no_error || alone) {
      // Nothing to put in brackets: every term stands for itself.
      for (const auto& [negative, product] : lever.products) {
        for (GroupedTerm& term : polynomial_sum(lever.polynomial).terms) {
          term.negative = term.negative != negative;
          for (const Symbol& symbol : product) term.factors.push_back({symbol, nullptr});
          sum.terms.push_back(std::move(term));
        }
      }
      continue;
    }
    sum.terms.push_back(lever_term(lever));
  }
  return sum;
}

}  // namespace

GroupedSum group_terms(const Expression& expression) {
  std::map<Monomial, std::map<Monomial, Polynomial>> groups;
  for (const auto& [monomial, coefficient] : expression.terms()) {
    Split parts = split(monomial);
    groups[std::move(parts.trigonometric)][std::move(parts.errors)].emplace_back(std::move(parts.positions),
                                                                                 coefficient);
  }
  GroupedSum sum;
  for (auto& [trigonometric, by_errors] : groups) {
    std::vector<Lever> levers;
    for (auto& [errors, coefficients] : by_errors) {
      Polynomial& polynomial = coefficients;  // clang 14 captures no structured bindings
      sort_for_print(polynomial);
      const bool negative = polynomial.front().second < 0;
      if (negative) {
        for (Coefficient& c : polynomial) c.second = -c.second;
      }
      const auto known = std::find_if(levers.begin(), levers.end(), [&](const Lever& lever) {
        return is_same_lever(lever.polynomial, polynomial);
      });
      if (known == levers.end()) {
        levers.push_back({polynomial, {{negative, errors}}});
      } else {
        known->products.emplace_back(negative, errors);
      }
    }
    GroupedSum inner = sum_of_levers(std::move(levers));
    if (trigonometric.empty()) {
      for (GroupedTerm& term : inner.terms) sum.terms.push_back(std::move(term));
      continue;
    }
    GroupedTerm term;
    term.factors = as_factors(trigonometric);
    multiply(term, std::move(inner));
    sum.terms.push_back(std::move(term));
  }
  return sum;
}

}  // namespace abbe
