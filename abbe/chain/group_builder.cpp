#include "abbe/chain/group_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

namespace abbe {
namespace {

/// A polynomial or table of one axis position found inside a function, in the units of the file.
struct PiecewiseLeaf {
  const ErrorFunction* function = nullptr;
  const ErrorFunction::Node* node = nullptr;
  double factor = 1;
};

/// What a function is as a sum: a constant and leaves.
struct PiecewiseSum {
  double constant = 0;
  std::vector<PiecewiseLeaf> leaves;
};

class FunctionSorter {
 public:
  FunctionSorter(const Machine& machine, const std::vector<double>& variables)
      : machine_(machine), variables_(variables) {}

  /// No variable of the query in it, whatever the query is.
  [[nodiscard]] bool is_frozen(const ErrorFunction& f) const {
    if (f.is_directional()) return false;
    const std::vector<int> used = f.variables();
    return std::all_of(used.begin(), used.end(), [&](int v) { return is_sensor(v); });
  }

  /// nullopt if the function is more than a sum of polynomials and tables of positions.
  [[nodiscard]] std::optional<PiecewiseSum> as_sum(const ErrorFunction& f, bool& outside) const {
    PiecewiseSum sum;
    if (f.nodes().empty()) return sum;
    if (!add(f, static_cast<std::uint32_t>(f.nodes().size() - 1), 1.0, sum, outside)) return std::nullopt;
    return sum;
  }

 private:
  using Form = ErrorFunction::Form;

  [[nodiscard]] bool is_sensor(int variable) const {
    return machine_.variables[static_cast<std::size_t>(variable)].kind == Variable::Kind::sensor;
  }

  [[nodiscard]] bool add(const ErrorFunction& f, std::uint32_t index, double factor, PiecewiseSum& sum,
                         bool& outside) const {
    const ErrorFunction::Node& node = f.nodes()[index];
    switch (node.form) {
      case Form::constant:
      case Form::polynomial:
      case Form::linear:
      case Form::cubic: {
        if (const std::optional<double> value = frozen_value(f, index, outside)) {
          sum.constant += factor * *value;
          return true;
        }
        if (machine_.variables[static_cast<std::size_t>(node.variable)].kind != Variable::Kind::position)
          return false;
        sum.leaves.push_back({&f, &node, factor});
        return true;
      }
      case Form::sum:
        for (std::uint32_t i = 0; i < node.count; ++i) {
          if (!add(f, f.children()[node.first_child + i], factor, sum, outside)) return false;
        }
        return true;
      case Form::product: {
        std::optional<std::uint32_t> varying;
        for (std::uint32_t i = 0; i < node.count; ++i) {
          const std::uint32_t child = f.children()[node.first_child + i];
          if (const std::optional<double> value = frozen_value(f, child, outside)) {
            factor *= *value;
          } else if (varying.has_value()) {
            return false;
          } else {
            varying = child;
          }
        }
        if (varying.has_value()) return add(f, *varying, factor, sum, outside);
        sum.constant += factor;
        return true;
      }
      default:
        return false;
    }
  }

  /// The value of a constant, or of a polynomial of a sensor.
  [[nodiscard]] std::optional<double> frozen_value(const ErrorFunction& f, std::uint32_t index,
                                                   bool& outside) const {
    const ErrorFunction::Node& node = f.nodes()[index];
    if (node.form == Form::constant) return f.data()[node.data];
    if (node.form != Form::polynomial || !is_sensor(node.variable)) return std::nullopt;
    double x = variables_[static_cast<std::size_t>(node.variable)] - node.reference;
    if (x < node.lo || x > node.hi) outside = true;
    x = std::clamp(x, node.lo, node.hi);
    double value = 0;
    for (std::uint32_t k = node.count; k-- > 0;) value = value * x + f.data()[node.data + k];
    return value;
  }

  const Machine& machine_;
  const std::vector<double>& variables_;
};

/// Leaves of the same axis, reference, domain and knots share a block.
using BlockKey = std::tuple<int, double, double, double, double, std::vector<double>>;
struct BlockDraft {
  double inverse_step = 0;
  std::size_t powers = 1;                                              // degree + 1
  std::vector<std::vector<std::array<double, kComponents>>> segments;  // rows of each, lowest power first
};

/// A leaf in internal units: c_k (v - r)^k with v = q / unit becomes (c_k / unit^k) (q - r unit)^k.
struct Piecewise {
  std::vector<double> knots;
  std::vector<std::vector<double>> coefficients;  // per knot, lowest power first
};

[[nodiscard]] Piecewise in_internal_units(const PiecewiseLeaf& leaf, double unit) {
  using Form = ErrorFunction::Form;
  namespace detail = error_function_detail;
  const ErrorFunction::Node& node = *leaf.node;
  const double* data = leaf.function->data().data() + node.data;
  Piecewise out;
  const bool table = node.form != Form::polynomial;
  const std::size_t record = !table                      ? node.count
                             : node.form == Form::linear ? detail::kLinearRecord
                                                         : detail::kCubicRecord;
  for (std::size_t i = 0; i < (table ? node.count : 1); ++i, data += record) {
    out.knots.push_back(table ? data[0] * unit : 0.0);
    std::vector<double>& row = out.coefficients.emplace_back();
    double power = 1;
    for (std::size_t k = table ? 1 : 0; k < record; ++k, power *= unit)
      row.push_back(leaf.factor * data[k] / power);
  }
  return out;
}

class GroupBuilder {
 public:
  GroupBuilder(Plan::Impl& plan, int only) : plan_(plan), sorter_(*plan.machine, plan.variables) {
    const Machine& machine = *plan.machine;
    for (std::size_t i = 0; i < machine.errors.size(); ++i) {
      if (only >= 0 && i != static_cast<std::size_t>(only)) continue;
      add(machine.errors[i]);
    }
    for (auto& [key, draft] : drafts_) finish(key, draft);
  }

  [[nodiscard]] GroupIndex index() { return std::move(index_); }

 private:
  struct Draft {
    Group group;
    std::map<BlockKey, BlockDraft> blocks;
    std::vector<GeneralTerm> terms;
  };

  void add(const ErrorTerm& error) {
    Draft& draft = drafts_[{error.body, error.name.error_class}];
    const auto component = static_cast<std::size_t>(error.name.direction);
    if (error.name.is_rotation()) draft.group.rotates = true;
    plan_.error_free = false;
    if (sorter_.is_frozen(error.function)) {
      const double value =
          error.function.value<double>(plan_.variables.data(), kNoApproach.data(), &plan_.constant_outside);
      draft.group.constant[component] += error.scale * value;
      return;
    }
    bool outside = false;
    const std::optional<PiecewiseSum> sum = sorter_.as_sum(error.function, outside);
    if (!sum.has_value()) {
      draft.terms.push_back({&error.function, error.scale, error.name.direction});
      plan_.needs_variables = true;
      plan_.directional = plan_.directional || error.function.is_directional();
      return;
    }
    plan_.constant_outside = plan_.constant_outside || outside;
    draft.group.constant[component] += error.scale * sum->constant;
    for (const PiecewiseLeaf& leaf : sum->leaves) add_leaf(draft, leaf, error.scale, component);
  }

  void add_leaf(Draft& draft, const PiecewiseLeaf& leaf, double scale, std::size_t component) {
    const ErrorFunction::Node& node = *leaf.node;
    const double unit = plan_.unit[static_cast<std::size_t>(node.variable)];
    // The ends are widened by rounding, so that 30 deg through radians is not beyond 30 deg.
    const auto end = [&](double v, double outward) {
      return (v + outward * 4 * std::numeric_limits<double>::epsilon() *
                      (std::abs(v) + std::abs(node.reference))) *
             unit;
    };
    const Piecewise piecewise = in_internal_units(leaf, unit);
    const double period = node.periodic ? node.period * unit : 0.0;
    BlockDraft& block = draft.blocks[{node.variable, node.reference * unit, end(node.lo, -1),
                                      end(node.hi, +1), period, piecewise.knots}];
    block.inverse_step = node.uniform ? node.inverse_step / unit : 0.0;
    block.segments.resize(piecewise.knots.size());
    for (std::size_t i = 0; i < piecewise.knots.size(); ++i) {
      const std::vector<double>& row = piecewise.coefficients[i];
      block.powers = std::max(block.powers, row.size());
      auto& rows = block.segments[i];
      if (rows.size() < row.size()) rows.resize(row.size(), {});
      for (std::size_t k = 0; k < row.size(); ++k) rows[k][component] += scale * row[k];
    }
  }

  void finish(const GroupKey& key, Draft& draft) {
    Group& group = draft.group;
    const Machine& machine = *plan_.machine;
    if (key.first >= 0) {
      const Body& body = machine.bodies[static_cast<std::size_t>(key.first)];
      group.is_rotary = body.type == AxisType::rotary;
      if (key.second == ErrorClass::component && body.measured_at.has_value() && group.rotates) {
        group.has_lever = true;
        group.lever = *body.measured_at - body.origin;
      }
    }
    group.first_block = static_cast<std::uint32_t>(plan_.blocks.size());
    for (const auto& [block_key, block] : draft.blocks) {
      const bool first = plan_.blocks.size() == group.first_block;
      plan_.blocks.push_back(
          make_block(block_key, block, first ? group.constant : std::array<double, kComponents>{}));
    }
    group.block_count = static_cast<std::uint32_t>(plan_.blocks.size()) - group.first_block;
    group.first_term = static_cast<std::uint32_t>(plan_.terms.size());
    plan_.terms.insert(plan_.terms.end(), draft.terms.begin(), draft.terms.end());
    group.term_count = static_cast<std::uint32_t>(draft.terms.size());
    group.varies = group.block_count + group.term_count > 0;
    index_[key] = static_cast<int>(plan_.groups.size());
    plan_.groups.push_back(group);
  }

  /// `constant` is added to every segment: the group's constants cost nothing at run time.
  [[nodiscard]] Block make_block(const BlockKey& key, const BlockDraft& draft,
                                 const std::array<double, kComponents>& constant) {
    Block out;
    std::vector<double> knots;
    std::tie(out.axis, out.reference, out.lo, out.hi, out.period, knots) = key;
    out.bounded = std::isfinite(out.lo) || std::isfinite(out.hi);
    out.degree = static_cast<int>(draft.powers) - 1;
    out.inverse_step = draft.inverse_step;
    out.segments = static_cast<std::uint32_t>(knots.size());
    out.knots = static_cast<std::uint32_t>(plan_.knots.size());
    out.data = static_cast<std::uint32_t>(plan_.coefficients.size());
    plan_.knots.insert(plan_.knots.end(), knots.begin(), knots.end());
    for (auto rows : draft.segments) {
      rows.resize(draft.powers, {});
      for (std::size_t k = 0; k < kComponents; ++k) rows[0][k] += constant[k];
      for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
        plan_.coefficients.insert(plan_.coefficients.end(), row->begin(), row->end());
      }
    }
    return out;
  }

  static constexpr std::array<signed char, kMaxAxes> kNoApproach{};
  Plan::Impl& plan_;
  FunctionSorter sorter_;
  std::map<GroupKey, Draft> drafts_;
  GroupIndex index_;
};

}  // namespace

GroupIndex build_groups(Plan::Impl& plan, int only) { return GroupBuilder(plan, only).index(); }

}  // namespace abbe
