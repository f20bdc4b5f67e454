#include "abbe/chain/group_builder.h"

#include <algorithm>
#include <optional>

#include "abbe/chain/axis_table_builder.h"

namespace abbe {
namespace {

/// What a function is as a sum: a constant and leaves.
struct PiecewiseSum {
  double constant = 0;
  std::vector<AxisLeaf> leaves;
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

  /// nullopt if the function is more than a sum of polynomials, tables and sines of positions, each perhaps
  /// for one direction of approach.
  [[nodiscard]] std::optional<PiecewiseSum> as_sum(const ErrorFunction& f, bool& outside) const {
    PiecewiseSum sum;
    if (f.nodes().empty()) return sum;
    if (!add(f, static_cast<std::uint32_t>(f.nodes().size() - 1), 1.0, {}, sum, outside)) return std::nullopt;
    return sum;
  }

 private:
  using Form = ErrorFunction::Form;

  [[nodiscard]] bool is_sensor(int variable) const {
    return machine_.variables[static_cast<std::size_t>(variable)].kind == Variable::Kind::sensor;
  }

  [[nodiscard]] bool is_position(int variable) const {
    return machine_.variables[static_cast<std::size_t>(variable)].kind == Variable::Kind::position;
  }

  static void add_constant(double value, ApproachKey approach, PiecewiseSum& sum) {
    if (approach.direction == 0) {
      sum.constant += value;
    } else {
      sum.leaves.push_back({nullptr, nullptr, value, 0, approach});
    }
  }

  [[nodiscard]] bool add(const ErrorFunction& f, std::uint32_t index, double factor, ApproachKey approach,
                         PiecewiseSum& sum, bool& outside) const {
    const ErrorFunction::Node& node = f.nodes()[index];
    switch (node.form) {
      case Form::constant:
      case Form::polynomial:
      case Form::linear:
      case Form::cubic:
      case Form::sine: {
        if (const std::optional<double> value = frozen_value(f, index, outside)) {
          add_constant(factor * *value, approach, sum);
          return true;
        }
        if (!is_position(node.variable)) return false;
        sum.leaves.push_back({&f, &node, factor, 0, approach});
        return true;
      }
      case Form::sum:
        for (std::uint32_t i = 0; i < node.count; ++i) {
          if (!add(f, f.children()[node.first_child + i], factor, approach, sum, outside)) return false;
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
        if (varying.has_value()) return add(f, *varying, factor, approach, sum, outside);
        add_constant(factor, approach, sum);
        return true;
      }
      case Form::directional: {
        // A choice inside a choice stays a function.
        if (approach.direction != 0 || !is_position(node.variable)) return false;
        return add(f, f.children()[node.first_child], factor, {+1, node.variable}, sum, outside) &&
               add(f, f.children()[node.first_child + 1], factor, {-1, node.variable}, sum, outside);
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
    std::map<std::pair<ApproachKey, int>, std::vector<AxisLeaf>> leaves;  // by direction of approach and axis
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
    for (const AxisLeaf& leaf : sum->leaves) {
      const int axis = leaf.node != nullptr ? leaf.node->variable : leaf.approach.axis;
      draft.leaves[{leaf.approach, axis}].push_back(
          {leaf.function, leaf.node, leaf.factor * error.scale, error.name.direction, leaf.approach});
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
    group.first_table = static_cast<std::uint32_t>(plan_.tables.size());
    // The first table always counts and has the constants.
    const auto plain = std::find_if(draft.leaves.begin(), draft.leaves.end(),
                                    [](const auto& entry) { return entry.first.first.direction == 0; });
    if (plain != draft.leaves.end()) {
      append_tables(plan_, plain->first.second, plain->second, group.constant);
    } else if (!draft.leaves.empty()) {
      append_tables(plan_, draft.leaves.begin()->first.second, {}, group.constant);
    }
    for (auto entry = draft.leaves.begin(); entry != draft.leaves.end(); ++entry) {
      if (entry != plain) append_tables(plan_, entry->first.second, entry->second, {});
    }
    group.table_count = static_cast<std::uint32_t>(plan_.tables.size()) - group.first_table;
    group.first_term = static_cast<std::uint32_t>(plan_.terms.size());
    plan_.terms.insert(plan_.terms.end(), draft.terms.begin(), draft.terms.end());
    group.term_count = static_cast<std::uint32_t>(draft.terms.size());
    group.varies = group.table_count + group.term_count > 0;
    index_[key] = static_cast<int>(plan_.groups.size());
    plan_.groups.push_back(group);
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
