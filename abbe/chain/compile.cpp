#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <utility>

#include "abbe/chain/chain_steps.h"
#include "abbe/chain/group_builder.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

struct Affine {
  Mat3 a = Mat3::Identity();
  Vec3 t = Vec3::Zero();
};

/// Steps to operations: constant error factors folded into matrices, translations merged.
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

  const GroupIndex groups = build_groups(*plan, only);
  plan->nominal = OpBuilder(*plan, false).build(chain_steps(*plan->machine, {}));
  const std::vector<Step> steps = chain_steps(*plan->machine, groups);
  plan->first_order = OpBuilder(*plan, true).build(steps);
  if (model != ErrorModel::first_order) plan->actual = OpBuilder(*plan, false).build(steps);
  return Plan(std::move(plan));
}

}  // namespace abbe
