#include "abbe/errors/error_function.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "abbe/errors/spline.h"

namespace abbe {
namespace {

using error_function_detail::kCubicRecord;
using error_function_detail::kLinearRecord;
using error_function_detail::kMaxGridVariables;

constexpr double kUniform = 1e-9;  // of a step: positions closer than this to a comb count as equally spaced
constexpr double kSamePosition = 1e-8;  // of a period: a span this close to one period is one

bool all_finite(const std::vector<double>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
}

bool strictly_increasing(const std::vector<double>& numbers) {
  return std::adjacent_find(numbers.begin(), numbers.end(), std::greater_equal<>()) == numbers.end();
}

bool valid(const ErrorFunction::Domain& domain) { return domain.lo <= domain.hi; }  // false for NaN

bool unbounded(const ErrorFunction::Domain& domain) { return std::isinf(domain.lo) && std::isinf(domain.hi); }

bool equally_spaced(const std::vector<double>& x) {
  const double step = (x.back() - x.front()) / static_cast<double>(x.size() - 1);
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::abs(x[i] - (x.front() + static_cast<double>(i) * step)) > kUniform * step) return false;
  }
  return true;
}

std::vector<double> linear_records(const std::vector<double>& x, const std::vector<double>& e) {
  std::vector<double> records;
  records.reserve(x.size() * kLinearRecord);
  double slope = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i + 1 < x.size()) slope = (e[i + 1] - e[i]) / (x[i + 1] - x[i]);
    records.insert(records.end(), {x[i], e[i], slope});  // the end keeps the slope that leads to it
  }
  return records;
}

std::vector<double> cubic_records(const std::vector<double>& x, const std::vector<double>& e, bool periodic) {
  const std::vector<double> second = periodic ? periodic_spline(x, e) : natural_spline(x, e);
  std::vector<double> records;
  records.reserve(x.size() * kCubicRecord);
  double slope = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    // e(t) = e_i + b t + M_i/2 t^2 + (M_{i+1} - M_i)/(6 h) t^3,  b = s_i - h (2 M_i + M_{i+1})/6 (6)
    const double h = x[i + 1] - x[i];
    const double chord = (e[i + 1] - e[i]) / h;
    records.insert(records.end(), {x[i], e[i], chord - h * (2 * second[i] + second[i + 1]) / 6, second[i] / 2,
                                   (second[i + 1] - second[i]) / (6 * h)});
    slope = chord + h * (second[i] + 2 * second[i + 1]) / 6;
  }
  records.insert(records.end(), {x.back(), e.back(), slope, second.back() / 2, 0.0});
  return records;
}

// Numbers from lo to hi (of the variable) with this spacing, one of them at `start`.
void add_comb(std::vector<double>& knots, double start, double spacing, double lo, double hi) {
  if (!(spacing > 0) || !(lo <= hi) || !std::isfinite(hi - lo) || !std::isfinite(start)) return;
  const double wanted = (hi - lo) / spacing;
  if (wanted > ErrorFunction::kMaxKnots) spacing *= std::ceil(wanted / ErrorFunction::kMaxKnots);
  const double first = std::ceil((lo - start) / spacing);
  for (int i = 0; i <= ErrorFunction::kMaxKnots; ++i) {
    const double knot = start + (first + i) * spacing;
    if (!(knot <= hi)) return;
    if (knot >= lo) knots.push_back(knot);
  }
}

}  // namespace

ErrorFunction ErrorFunction::leaf(Node node, std::vector<double> data) {
  ErrorFunction function;
  function.data_ = std::move(data);
  function.nodes_.push_back(node);
  return function;
}

// The trees one after the other, then the node above them.
ErrorFunction ErrorFunction::inner(Node node, std::vector<ErrorFunction> parts) {
  ErrorFunction function;
  std::vector<std::uint32_t> roots;
  for (ErrorFunction& part : parts) {
    if (part.nodes_.empty()) part = constant(0);
    const auto first_node = static_cast<std::uint32_t>(function.nodes_.size());
    const auto first_data = static_cast<std::uint32_t>(function.data_.size());
    const auto first_child = static_cast<std::uint32_t>(function.children_.size());
    for (Node moved : part.nodes_) {
      moved.data += first_data;
      moved.first_child += first_child;
      function.nodes_.push_back(moved);
    }
    for (const std::uint32_t child : part.children_) function.children_.push_back(child + first_node);
    function.data_.insert(function.data_.end(), part.data_.begin(), part.data_.end());
    roots.push_back(static_cast<std::uint32_t>(function.nodes_.size()) - 1);
  }
  node.count = static_cast<std::uint32_t>(roots.size());
  node.first_child = static_cast<std::uint32_t>(function.children_.size());
  function.children_.insert(function.children_.end(), roots.begin(), roots.end());
  function.nodes_.push_back(node);
  return function;
}

ErrorFunction ErrorFunction::constant(double c) {
  Node node;
  node.count = 1;
  return leaf(node, {c});
}

std::optional<ErrorFunction> ErrorFunction::polynomial(int variable, std::vector<double> coefficients,
                                                       double reference, Domain domain) {
  if (variable < 0 || coefficients.empty() || !all_finite(coefficients) || !std::isfinite(reference) ||
      !valid(domain)) {
    return std::nullopt;
  }
  if (coefficients.size() == 1 && unbounded(domain)) return constant(coefficients[0]);
  Node node;
  node.form = Form::polynomial;
  node.variable = variable;
  node.reference = reference;
  node.lo = domain.lo;
  node.hi = domain.hi;
  node.count = static_cast<std::uint32_t>(coefficients.size());
  return leaf(node, std::move(coefficients));
}

std::optional<ErrorFunction> ErrorFunction::table(int variable, std::vector<double> positions,
                                                  std::vector<double> values, Interpolation interpolation,
                                                  double reference, double period, Domain domain) {
  const bool periodic = period != 0;
  if (variable < 0 || positions.empty() || positions.size() != values.size() || !all_finite(positions) ||
      !all_finite(values) || !strictly_increasing(positions) || !std::isfinite(reference) || !valid(domain) ||
      !std::isfinite(positions.back() - positions.front()) || !std::isfinite(period) || period < 0) {
    return std::nullopt;
  }
  if (periodic) {
    const double closing = positions.front() + period;
    const double missing = closing - positions.back();
    if (!(closing > positions.front()) || missing < -kSamePosition * period) return std::nullopt;
    if (missing <= kSamePosition * period) {
      if (values.back() != values.front()) return std::nullopt;
      positions.back() = closing;
    } else if (positions.size() > 1) {
      positions.push_back(closing);
      values.push_back(values.front());
    }
  }
  if (positions.size() == 1 || (periodic && positions.size() == 2))
    return polynomial(variable, {values[0]}, reference, domain);

  Node node;
  node.periodic = periodic;
  node.period = period;
  node.variable = variable;
  node.reference = reference;
  node.lo = periodic ? domain.lo : std::max(domain.lo, positions.front());
  node.hi = periodic ? domain.hi : std::min(domain.hi, positions.back());
  if (node.lo > node.hi) return std::nullopt;
  node.form = interpolation == Interpolation::cubic && positions.size() > 2 ? Form::cubic : Form::linear;
  node.uniform = equally_spaced(positions);
  node.inverse_step =
      node.uniform ? static_cast<double>(positions.size() - 1) / (positions.back() - positions.front()) : 0;
  node.count = static_cast<std::uint32_t>(positions.size());
  std::vector<double> records = node.form == Form::cubic ? cubic_records(positions, values, periodic)
                                                         : linear_records(positions, values);
  if (!all_finite(records) || !std::isfinite(node.inverse_step))
    return std::nullopt;  // steps or values too extreme
  return leaf(node, std::move(records));
}

std::optional<ErrorFunction> ErrorFunction::sine(int variable, double amplitude, double frequency,
                                                 double phase, double reference, Domain domain) {
  if (variable < 0 || !all_finite({amplitude, frequency, phase, reference}) || !valid(domain))
    return std::nullopt;
  Node node;
  node.form = Form::sine;
  node.variable = variable;
  node.reference = reference;
  node.lo = domain.lo;
  node.hi = domain.hi;
  node.count = 3;
  return leaf(node, {amplitude, frequency, phase});
}

std::optional<ErrorFunction> ErrorFunction::grid(std::vector<int> variables,
                                                 std::vector<std::vector<double>> positions,
                                                 std::vector<double> values, double reference) {
  const std::size_t d = variables.size();
  if (d == 0 || d > kMaxGridVariables || positions.size() != d || !all_finite(values) ||
      !std::isfinite(reference)) {
    return std::nullopt;
  }
  std::size_t expected = 1;
  for (std::size_t k = 0; k < d; ++k) {
    const auto& x = positions[k];
    if (variables[k] < 0 || std::count(variables.begin(), variables.end(), variables[k]) != 1)
      return std::nullopt;
    if (x.empty() || x.size() > values.size() || !all_finite(x) || !strictly_increasing(x))
      return std::nullopt;
    if (!std::isfinite(x.back() - x.front()) || values.size() / expected < x.size()) return std::nullopt;
    expected *= x.size();
  }
  if (expected != values.size()) return std::nullopt;

  std::vector<double> data;
  for (const auto& x : positions) data.push_back(static_cast<double>(x.size()));
  for (const int variable : variables) data.push_back(variable);
  for (const auto& x : positions) data.insert(data.end(), x.begin(), x.end());
  data.insert(data.end(), values.begin(), values.end());
  Node node;
  node.form = Form::grid;
  node.reference = reference;
  node.count = static_cast<std::uint32_t>(d);
  return leaf(node, std::move(data));
}

ErrorFunction ErrorFunction::sum(std::vector<ErrorFunction> terms) {
  if (terms.empty()) return {};
  if (terms.size() == 1) return std::move(terms.front());
  Node node;
  node.form = Form::sum;
  return inner(node, std::move(terms));
}

ErrorFunction ErrorFunction::product(std::vector<ErrorFunction> factors) {
  if (factors.empty()) return constant(1);
  if (factors.size() == 1) return std::move(factors.front());
  Node node;
  node.form = Form::product;
  return inner(node, std::move(factors));
}

ErrorFunction ErrorFunction::directional(int variable, ErrorFunction forward, ErrorFunction backward) {
  Node node;
  node.form = Form::directional;
  node.variable = variable;
  std::vector<ErrorFunction> choices;
  choices.push_back(std::move(forward));
  choices.push_back(std::move(backward));
  return inner(node, std::move(choices));
}

bool ErrorFunction::is_constant() const { return variables().empty(); }

bool ErrorFunction::is_directional() const {
  return std::any_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.form == Form::directional; });
}

std::vector<int> ErrorFunction::variables() const {
  std::vector<int> used;
  for (const Node& node : nodes_) {
    if (node.form == Form::grid) {
      for (std::size_t k = 0; k < node.count; ++k)
        used.push_back(static_cast<int>(data_[node.data + node.count + k]));
    } else if (node.variable >= 0 && node.form != Form::directional) {
      used.push_back(node.variable);
    }
  }
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  return used;
}

std::vector<double> ErrorFunction::knots(int variable, double lo, double hi) const {
  std::vector<double> found;
  for (const Node& node : nodes_) {
    const double* const data = data_.data() + node.data;
    // The domain in the variable's own numbers, as far as it is asked for.
    const double first = std::max(lo, node.lo + node.reference),
                 last = std::min(hi, node.hi + node.reference);
    const bool own = node.variable == variable;
    if (own && (node.form == Form::polynomial || node.form == Form::linear || node.form == Form::cubic ||
                node.form == Form::sine)) {
      found.push_back(node.lo + node.reference);
      found.push_back(node.hi + node.reference);
    }
    switch (node.form) {
      case Form::linear:
      case Form::cubic: {
        if (!own) break;
        const std::size_t stride = node.form == Form::linear ? kLinearRecord : kCubicRecord;
        for (std::size_t i = 0; i < node.count; ++i) {
          const double knot = data[i * stride] + node.reference;
          if (node.periodic) {
            // thinned so that all the combs of this leaf together keep the limit
            const double spacing =
                node.period * std::ceil(std::max(1.0, (last - first) / node.period * node.count / kMaxKnots));
            add_comb(found, knot, spacing, first, last);
          } else if (knot >= first && knot <= last) {
            found.push_back(knot);
          }
        }
        break;
      }
      case Form::sine:
        // w v + phi = k pi / 8
        if (own && data[1] != 0) {
          add_comb(found, node.reference - data[2] / data[1], std::numbers::pi / 8 / std::abs(data[1]), first,
                   last);
        }
        break;
      case Form::grid: {
        const double* positions = data + 2 * std::size_t{node.count};
        for (std::size_t k = 0; k < node.count; ++k) {
          const auto size = static_cast<std::size_t>(data[k]);
          if (static_cast<int>(data[node.count + k]) == variable) {
            for (std::size_t i = 0; i < size; ++i) found.push_back(positions[i] + node.reference);
          }
          positions += size;
        }
        break;
      }
      case Form::constant:
      case Form::polynomial:
      case Form::sum:
      case Form::product:
      case Form::directional:
        break;
    }
  }
  std::erase_if(found, [&](double knot) { return !(knot >= lo && knot <= hi) || !std::isfinite(knot); });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace abbe
