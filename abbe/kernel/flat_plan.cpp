#include "abbe/kernel/flat_plan.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "abbe/chain/plan_impl.h"

namespace abbe::kernel {
namespace {

/// Doubles on 64-byte boundaries.
struct alignas(64) Row {
  double value[kRow] = {};
};

[[nodiscard]] FlatOp::About about(const Vec3& u) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(u[k]) == 1 && u[(k + 1) % 3] == 0 && u[(k + 2) % 3] == 0) return static_cast<FlatOp::About>(k);
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

static_assert(static_cast<int>(FlatOp::Kind::twist) == static_cast<int>(Op::Kind::twist));
static_assert(static_cast<int>(FlatOp::Kind::rigid) == static_cast<int>(Op::Kind::rigid));
static_assert(static_cast<int>(Part::along) == 1 && static_cast<int>(Part::across) == 2);

}  // namespace

struct FlatPlan::Data {
  std::vector<FlatOp> nominal, actual, first_order;
  std::vector<FlatGroup> groups;
  std::vector<AxisTable> tables;
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
  flatten(impl.nominal, data.nominal);
  flatten(impl.actual, data.actual);
  flatten(impl.first_order, data.first_order);
  for (const Group& group : impl.groups) {
    FlatGroup& flat_group = data.groups.emplace_back();
    std::copy(group.constant.begin(), group.constant.end(), flat_group.constant);
    for (int k = 0; k < 3; ++k) flat_group.lever[k] = group.lever[k];
    flat_group.has_lever = group.has_lever;
    flat_group.is_rotary = group.is_rotary;
    flat_group.rotates = group.rotates;
    flat_group.first_table = group.first_table;
    flat_group.table_count = group.table_count;
  }
  data.tables = impl.tables;
  data.waves = impl.waves;
  data.knots = impl.knots;
  data.buckets = impl.buckets;
  // Six coefficients become rows of eight.
  data.rows.resize(impl.coefficients.size() / kComponents);
  for (std::size_t i = 0; i < data.rows.size(); ++i)
    std::copy_n(impl.coefficients.data() + i * kComponents, kComponents, data.rows[i].value);
  for (AxisTable& table : data.tables) table.data /= kComponents;

  FlatView& view = out->view_;
  view.nominal = data.nominal.data();
  view.actual = data.actual.data();
  view.first_order = data.first_order.data();
  view.nominal_count = static_cast<std::uint32_t>(data.nominal.size());
  view.actual_count = static_cast<std::uint32_t>(data.actual.size());
  view.first_order_count = static_cast<std::uint32_t>(data.first_order.size());
  view.groups = data.groups.data();
  view.tables = data.tables.data();
  view.waves = data.waves.data();
  view.knots = data.knots.data();
  view.rows = data.rows.empty() ? nullptr : data.rows.front().value;
  view.buckets = data.buckets.data();
  view.axis_count = impl.axis_count;
  view.rotary = impl.rotary;
  return out;
}

}  // namespace abbe::kernel
