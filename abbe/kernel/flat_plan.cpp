#include "abbe/kernel/flat_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/walk.h"
#include "abbe/kernel/single_steps.h"

namespace abbe::kernel {
namespace {

/// Doubles on 64-byte boundaries.
struct alignas(64) Row {
  double value[kRow] = {};
};

[[nodiscard]] FlatOp::About about(const Vec3& u) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(u[k]) == 1 && u[(k + 1) % 3] == 0 && u[(k + 2) % 3] == 0)
      return static_cast<FlatOp::About>(k);
  return FlatOp::About::other;
}

[[nodiscard]] FlatOp flat(const Plan::Impl& plan, const Op& op) {
  FlatOp out;
  out.kind = static_cast<FlatOp::Kind>(op.kind);
  out.about = about(op.u);
  out.inverse = op.inverse;
  out.part = static_cast<std::uint8_t>(op.part);
  out.axis = op.axis;
  if (op.kind == Op::Kind::affine) {
    const Mat3& a = plan.matrices[static_cast<std::size_t>(op.index)];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) out.a[3 * i + k] = a(i, k);
  } else {
    out.group = static_cast<std::int16_t>(op.index);
  }
  for (int k = 0; k < 3; ++k) {
    out.u[k] = op.u[k];
    out.t[k] = op.t[k];
  }
  out.moves_on = op.t != Vec3::Zero();
  return out;
}

/// Constant twists as numbers, neighbours in one: what stands before a translation t acts behind it as
///   d' = d - e x t, e' = e
class TwistFolder {
 public:
  explicit TwistFolder(const Plan::Impl& plan) : plan_(plan) {}

  [[nodiscard]] std::vector<FlatOp> fold(const std::vector<Op>& ops) {
    std::vector<FlatOp> out;
    for (const Op& op : ops) {
      if (op.kind != Op::Kind::twist || plan_.groups[static_cast<std::size_t>(op.index)].varies) {
        out.push_back(flat(plan_, op));
        continue;
      }
      FlatOp twist = fixed(op);
      if (out.size() > 1 && out.back().kind == FlatOp::Kind::fixed_twist) {
        const FlatOp& before = out.back();
        const Vec3 d(before.u), e(before.a), t(before.t);
        const Vec3 moved = d - e.cross(t);
        for (int k = 0; k < 3; ++k) {
          twist.u[k] += moved[k];
          twist.a[k] += e[k];
        }
        // The translation now comes first: the step before the two takes it.
        if (before.moves_on) {
          out.pop_back();
          move(out, t);
        } else {
          out.pop_back();
        }
      }
      out.push_back(twist);
    }
    return out;
  }

 private:
  static void move(std::vector<FlatOp>& ops, const Vec3& t) {
    FlatOp& last = ops.back();
    for (int k = 0; k < 3; ++k) last.t[k] += t[k];
    last.moves_on = true;
  }

  [[nodiscard]] FlatOp fixed(const Op& op) const {
    const Group& group = plan_.groups[static_cast<std::size_t>(op.index)];
    Vec3 d, e;
    bool outside = false;
    evaluate<double>(plan_, group, Inputs<double>{}, d, e, &outside);
    take_part<double>(op.part, group.is_rotary, op.u, d, e);
    if (op.inverse) {
      d = -d;
      e = -e;
    }
    FlatOp out;
    out.kind = FlatOp::Kind::fixed_twist;
    for (int k = 0; k < 3; ++k) {
      out.u[k] = d[k];
      out.a[k] = e[k];
      out.t[k] = op.t[k];
    }
    out.moves_on = op.t != Vec3::Zero();
    return out;
  }

  const Plan::Impl& plan_;
};

static_assert(static_cast<int>(FlatOp::Kind::twist) == static_cast<int>(Op::Kind::twist));
static_assert(static_cast<int>(FlatOp::Kind::rigid) == static_cast<int>(Op::Kind::rigid));
static_assert(static_cast<int>(Part::along) == 1 && static_cast<int>(Part::across) == 2);

}  // namespace

struct FlatPlan::Data {
  std::vector<FlatOp> actual, first_order;
  SingleSteps single;
  std::vector<FlatGroup> groups;
  std::vector<FlatTable> tables;
  std::vector<Wave> waves;
  std::vector<double> knots;
  std::vector<Row> rows;
  std::vector<std::uint32_t> buckets;
};

FlatPlan::FlatPlan() : data_(std::make_unique<Data>()) {}
FlatPlan::~FlatPlan() = default;

std::shared_ptr<const FlatPlan> FlatPlan::make(const Plan& plan) {
  const Plan::Impl& impl = plan.impl();
  if (!impl.terms.empty() || impl.constant_outside || impl.axis_count > kMaxFlatAxes ||
      impl.model == ErrorModel::first_order || impl.groups.size() > 32767) {
    return nullptr;
  }
  std::shared_ptr<FlatPlan> out(new FlatPlan);
  Data& data = *out->data_;
  const auto flatten = [&](const std::vector<Op>& from, std::vector<FlatOp>& to) {
    for (const Op& op : from) to.push_back(flat(impl, op));
  };
  flatten(impl.actual, data.actual);
  data.first_order = TwistFolder(impl).fold(impl.first_order);
  data.waves = impl.waves;
  data.knots = impl.knots;
  data.buckets = impl.buckets;
  // Six coefficients become rows of eight.
  data.rows.resize(impl.coefficients.size() / kComponents);
  for (std::size_t i = 0; i < data.rows.size(); ++i)
    std::copy_n(impl.coefficients.data() + i * kComponents, kComponents, data.rows[i].value);
  for (const AxisTable& table : impl.tables) {
    FlatTable& to = data.tables.emplace_back();
    to.knots = data.knots.data() + table.knots;
    to.rows = data.rows[table.data / kComponents].value;
    to.buckets = data.buckets.data() + table.first_bucket;
    to.waves = data.waves.data() + table.first_wave;
    to.bucket_lo = table.bucket_lo;
    to.buckets_per_unit = table.buckets_per_unit;
    to.most_bucket = static_cast<double>(table.bucket_count - 1);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    to.lo = table.bounded ? table.lo : -infinity;
    to.hi = table.bounded ? table.hi : infinity;
    to.waves_lo = table.wave_count > 0 ? table.waves_lo : -infinity;
    to.waves_hi = table.wave_count > 0 ? table.waves_hi : infinity;
    to.period = table.period;
    to.period_lo = table.period_lo;
    to.row_count = table.rows;
    to.segments = table.segments;
    to.wave_count = table.wave_count;
    to.axis = table.axis;
    to.direction = table.direction;
    to.direction_axis = table.direction_axis;
  }
  for (const Group& group : impl.groups) {
    FlatGroup& to = data.groups.emplace_back();
    std::copy(group.constant.begin(), group.constant.end(), to.constant);
    for (int k = 0; k < 3; ++k) to.lever[k] = group.lever[k];
    to.has_lever = group.has_lever;
    to.is_rotary = group.is_rotary;
    to.rotates = group.rotates;
    to.tables = data.tables.data() + group.first_table;
    to.table_count = group.table_count;
  }

  for (auto* ops : {&data.actual, &data.first_order}) {
    for (FlatOp& op : *ops) {
      if (op.group < 0 || op.part != 0) continue;
      const FlatGroup& group = data.groups[static_cast<std::size_t>(op.group)];
      if (group.table_count == 1 && !group.has_lever) op.table = group.tables;
    }
  }

  data.single = single_steps(data.first_order);
  for (const FlatOp& op : data.first_order) {
    if (op.group < 0 || op.table != nullptr) continue;
    const FlatGroup& group = data.groups[static_cast<std::size_t>(op.group)];
    const auto first = static_cast<std::size_t>(group.tables - data.tables.data());
    for (FlatTable& table : std::span(data.tables).subspan(first, group.table_count))
      if (table.windows == nullptr) give_windows(table, data.single.windows);
  }

  FlatView& view = out->view_;
  view.actual = data.actual.data();
  view.first_order = data.first_order.data();
  view.single = data.single.steps.data();
  view.single_count = static_cast<std::uint32_t>(data.single.steps.size());
  view.actual_count = static_cast<std::uint32_t>(data.actual.size());
  view.first_order_count = static_cast<std::uint32_t>(data.first_order.size());
  view.groups = data.groups.data();
  view.axis_count = impl.axis_count;
  view.rotary = impl.rotary;
  return out;
}

}  // namespace abbe::kernel
