#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

// ---- Error functions: folded to constants, gathered into polynomial blocks, or kept as they are.

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

using ErrorKey = std::pair<int, ErrorClass>;

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

  [[nodiscard]] int find(int body, ErrorClass error_class) const {
    const auto found = index_.find({body, error_class});
    return found == index_.end() ? -1 : found->second;
  }

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

  void finish(const ErrorKey& key, Draft& draft) {
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
  std::map<ErrorKey, Draft> drafts_;
  std::map<ErrorKey, int> index_;
};

// ---- The chain as a list of steps, in the order in which a tool point meets them.

struct Step {
  enum class Kind { tip, translate, motion, error } kind = Kind::translate;
  Vec3 vector = Vec3::Zero();  // translate: by; motion and error: the axis direction
  const Body* body = nullptr;  // motion
  int group = -1;              // error
  Part part = Part::all;
  bool inverse = false;  // motion, error: the inverse matrix acts on the point
};

/// T_wt = T_bw^-1 T_bt read from the right: tool mounting, tool branch from the tool to the bed, then
/// the inverses of the workpiece branch from the bed to the workpiece.
class ChainBuilder {
 public:
  ChainBuilder(const Machine& machine, const GroupBuilder& groups, bool with_errors)
      : machine_(machine), groups_(groups), with_errors_(with_errors) {}

  [[nodiscard]] std::vector<Step> build() {
    add_error(kToolBody, ErrorClass::component, Part::all, false, Vec3::UnitZ());
    steps_.push_back({Step::Kind::tip, Vec3::Zero(), nullptr, -1, Part::all, false});
    translate(-last_origin(Branch::tool));
    const int count = static_cast<int>(machine_.bodies.size());
    for (int i = count - 1; i >= 0; --i) {
      const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
      if (body.branch != Branch::tool) continue;
      for (auto factor = body.order.rbegin(); factor != body.order.rend(); ++factor)
        add_factor(i, *factor, false);
      translate(body.origin - lower_origin(i));
    }
    for (int i = count - 1; i >= 0; --i) {
      const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
      if (body.branch != Branch::workpiece) continue;
      translate(-(body.origin - lower_origin(i)));
      for (const Factor& factor : body.order) add_factor(i, factor, true);
    }
    translate(-(machine_.workpiece_origin - last_origin(Branch::workpiece)));
    add_error(kWorkpieceBody, ErrorClass::component, Part::all, true, Vec3::UnitZ());
    return std::move(steps_);
  }

 private:
  /// Bodies are in chain order w .. b .. t: the outermost one of a branch is the first or the last.
  [[nodiscard]] Vec3 last_origin(Branch branch) const {
    if (branch == Branch::workpiece) {
      return !machine_.bodies.empty() && machine_.bodies.front().branch == branch
                 ? machine_.bodies.front().origin
                 : Vec3(Vec3::Zero());
    }
    return !machine_.bodies.empty() && machine_.bodies.back().branch == branch ? machine_.bodies.back().origin
                                                                               : Vec3(Vec3::Zero());
  }

  [[nodiscard]] Vec3 lower_origin(int i) const {
    const Branch branch = machine_.bodies[static_cast<std::size_t>(i)].branch;
    const int lower = branch == Branch::tool ? i - 1 : i + 1;
    if (lower < 0 || lower >= static_cast<int>(machine_.bodies.size())) return Vec3::Zero();
    const Body& body = machine_.bodies[static_cast<std::size_t>(lower)];
    return body.branch == branch ? body.origin : Vec3(Vec3::Zero());
  }

  void translate(const Vec3& by) {
    if (by != Vec3::Zero()) steps_.push_back({Step::Kind::translate, by, nullptr, -1, Part::all, false});
  }

  /// `undo`: the body is on the workpiece branch, its matrices act inverted.
  void add_factor(int i, const Factor& factor, bool undo) {
    const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
    const bool inverse = factor.inverse != undo;
    const bool seen_inverse = inverse != body.errors_seen_at_tool;
    switch (factor.kind) {
      case FactorKind::motion:
        if (body.type != AxisType::fixed) {
          steps_.push_back({Step::Kind::motion, body.direction, &body, -1, Part::all, inverse});
        }
        break;
      case FactorKind::location:
        add_error(i, ErrorClass::location, Part::all, inverse, body.direction);
        break;
      case FactorKind::along:
        add_error(i, ErrorClass::location, Part::along, inverse, body.direction);
        break;
      case FactorKind::across:
        add_error(i, ErrorClass::location, Part::across, inverse, body.direction);
        break;
      case FactorKind::thermal:
        add_error(i, ErrorClass::thermal, Part::all, seen_inverse, body.direction);
        break;
      case FactorKind::component:
        add_error(i, ErrorClass::component, Part::all, seen_inverse, body.direction);
        break;
      case FactorKind::dynamic:
        add_error(i, ErrorClass::dynamic, Part::all, seen_inverse, body.direction);
        break;
    }
  }

  void add_error(int body, ErrorClass error_class, Part part, bool inverse, const Vec3& direction) {
    const int group = with_errors_ ? groups_.find(body, error_class) : -1;
    if (group >= 0) steps_.push_back({Step::Kind::error, direction, nullptr, group, part, inverse});
  }

  const Machine& machine_;
  const GroupBuilder& groups_;
  bool with_errors_;
  std::vector<Step> steps_;
};

// ---- Steps to operations: constant factors folded, translations merged.

struct Affine {
  Mat3 a = Mat3::Identity();
  Vec3 t = Vec3::Zero();
};

class OpBuilder {
 public:
  OpBuilder(Plan::Impl& plan, bool first_order) : plan_(plan), first_order_(first_order) {}

  [[nodiscard]] std::vector<Op> build(const std::vector<Step>& steps) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (add_conjugated_motion(steps, i)) {
        i += 2;
        continue;
      }
      add(steps[i]);
    }
    return std::move(ops_);
  }

 private:
  void add(const Step& step) {
    switch (step.kind) {
      case Step::Kind::tip:
        ops_.emplace_back();
        break;
      case Step::Kind::translate:
        translate(step.vector);
        break;
      case Step::Kind::motion:
        add_motion(step, step.vector);
        break;
      case Step::Kind::error:
        add_error(step);
        break;
    }
  }

  void translate(const Vec3& by) {
    if (by == Vec3::Zero()) return;
    if (ops_.empty())
      add_affine({Mat3::Identity(), by});
    else
      ops_.back().t += by;
  }

  void add_motion(const Step& step, const Vec3& direction) {
    Op op;
    op.kind = step.body->type == AxisType::linear ? Op::Kind::slide : Op::Kind::turn;
    op.axis = static_cast<std::int8_t>(step.body->axis);
    op.u = step.inverse ? Vec3(-direction) : direction;
    ops_.push_back(op);
  }

  void add_error(const Step& step) {
    const Group& group = plan_.groups[static_cast<std::size_t>(step.group)];
    if (!group.varies && !first_order_) {
      add_affine(constant_matrix(step));
      return;
    }
    Op op;
    op.kind = first_order_                        ? Op::Kind::twist
              : !group.rotates                    ? Op::Kind::shift
              : plan_.model == ErrorModel::linear ? Op::Kind::linear
                                                  : Op::Kind::rigid;
    op.inverse = step.inverse;
    op.part = step.part;
    op.index = step.group;
    op.u = step.vector;
    ops_.push_back(op);
  }

  void add_affine(const Affine& m) {
    if (m.a == Mat3::Identity() && !ops_.empty()) {
      translate(m.t);
      return;
    }
    if (!ops_.empty() && ops_.back().kind == Op::Kind::affine) {
      Mat3& a = plan_.matrices[static_cast<std::size_t>(ops_.back().index)];
      a = (m.a * a).eval();
      ops_.back().t = m.a * ops_.back().t + m.t;
      return;
    }
    Op op;
    op.kind = Op::Kind::affine;
    op.index = static_cast<std::int32_t>(plan_.matrices.size());
    op.t = m.t;
    plan_.matrices.push_back(m.a);
    ops_.push_back(op);
  }

  /// The matrix of a constant error factor: the same equations as in the walk.
  [[nodiscard]] Affine constant_matrix(const Step& step) const {
    const Group& group = plan_.groups[static_cast<std::size_t>(step.group)];
    Vec3 d, e;
    bool outside = false;
    evaluate<double>(plan_, group, Inputs<double>{}, d, e, &outside);
    take_part<double>(step.part, group.is_rotary, step.vector, d, e);
    if (e == Vec3::Zero()) return {Mat3::Identity(), step.inverse ? Vec3(-d) : d};
    Affine m;
    if (plan_.model == ErrorModel::linear) {
      m.a << 1, -e.z(), e.y(), e.z(), 1, -e.x(), -e.y(), e.x(), 1;
      if (step.inverse) m.a = m.a.inverse().eval();
    } else {
      if (step.inverse) e = -e;
      double s = 0, k = 0;
      rotation_coefficients(e.squaredNorm(), s, k);
      for (int i = 0; i < 3; ++i) m.a.col(i) = rotated<double>(e, s, k, Vec3::Unit(i));
    }
    m.t = step.inverse ? Vec3(-(m.a * d)) : d;
    return m;
  }

  /// G motion G^-1 with a constant G = [A, d] is the motion along the line A u (rotary, A a rotation:
  /// about A u through d). Saves the two matrices of every squareness.
  [[nodiscard]] bool add_conjugated_motion(const std::vector<Step>& steps, std::size_t i) {
    if (first_order_ || i + 2 >= steps.size()) return false;
    const Step &inner = steps[i], &motion = steps[i + 1], &outer = steps[i + 2];
    if (inner.kind != Step::Kind::error || motion.kind != Step::Kind::motion ||
        outer.kind != Step::Kind::error || inner.group != outer.group || inner.part != outer.part ||
        inner.inverse == outer.inverse || plan_.groups[static_cast<std::size_t>(outer.group)].varies) {
      return false;
    }
    const bool is_linear = motion.body->type == AxisType::linear;
    if (!is_linear && plan_.model == ErrorModel::linear) return false;
    const Affine g = constant_matrix(outer);
    if (!is_linear) translate(-g.t);
    add_motion(motion, g.a * motion.vector);
    if (!is_linear) translate(g.t);
    return true;
  }

  Plan::Impl& plan_;
  bool first_order_;
  std::vector<Op> ops_;
};

}  // namespace

Plan compile_plan(std::shared_ptr<const Machine> machine, std::vector<double> variables, ErrorModel model,
                  int only) {
  auto plan = std::make_shared<Plan::Impl>();
  plan->machine = std::move(machine);
  plan->model = model;
  plan->variables = std::move(variables);
  plan->axis_count = std::min(plan->machine->axis_count(), kMaxAxes);
  for (int i = 0; i < plan->axis_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Body& body = plan->machine->axis(i);
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    plan->unit[k] = plan->machine->axis_unit(i);
    if (body.type == AxisType::rotary) plan->rotary |= std::uint32_t{1} << i;
    plan->lo[k] = body.range.has_value() ? (*body.range)[0] : -kInfinity;
    plan->hi[k] = body.range.has_value() ? (*body.range)[1] : kInfinity;
  }

  const GroupBuilder groups(*plan, only);
  plan->nominal = OpBuilder(*plan, false).build(ChainBuilder(*plan->machine, groups, false).build());
  const std::vector<Step> steps = ChainBuilder(*plan->machine, groups, true).build();
  plan->first_order = OpBuilder(*plan, true).build(steps);
  if (model != ErrorModel::first_order) plan->actual = OpBuilder(*plan, false).build(steps);
  return Plan(std::move(plan));
}

}  // namespace abbe
