#include "abbe/verify/tip_model.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace abbe::verifying {
namespace {

constexpr double kIndependent = 1e-3;  // least determinant of the axis directions
constexpr double kTravelSlack = 1e-6;  // mm

Diagnostic axis_fault(char letter, const char* what) {
  return {Severity::error,
          "E-AXIS",
          {},
          fmt::format("axis {} {}", letter, what),
          "programs move X, Y and Z, and each must move the tool in its own direction",
          "set `address` of the axes in the machine file"};
}

}  // namespace

std::variant<TipModel, Diagnostic> TipModel::make(const Plan& plan, const ControlSetup& setup) {
  TipModel model(plan, setup);
  const Machine& machine = plan.machine();
  for (std::size_t k = 0; k < 3; ++k) {
    const char letter = static_cast<char>('X' + k);
    int found = -1;
    for (int i = 0; i < machine.axis_count() && found < 0; ++i) {
      const Body& body = machine.axis(i);
      const std::string& address = body.address.empty() ? body.name : body.address;
      if (address.size() == 1 && address[0] == letter) found = i;
    }
    if (found < 0) return axis_fault(letter, "is not part of this machine");
    if (machine.axis(found).type != AxisType::linear) return axis_fault(letter, "is not a linear axis");
    model.axes_[k] = static_cast<std::size_t>(found);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    model.travel_[k] = machine.axis(found).range.value_or(std::array<double, 2>{-infinity, infinity});
    const int turning = model.rotary_.axes().rotary[k];
    model.turn_travel_[k] = {-infinity, infinity};
    if (turning >= 0) model.turn_travel_[k] = machine.axis(turning).range.value_or(model.turn_travel_[k]);
  }
  model.directional_ = std::any_of(machine.errors.begin(), machine.errors.end(),
                                   [](const ErrorTerm& term) { return term.function.is_directional(); });
  if (auto fault = model.use_tool(setup.loaded_tool)) return std::move(*fault);
  if (!(std::abs(model.matrix_.determinant()) > kIndependent))
    return axis_fault('Z', "does not move the tool independently of X and Y");
  return model;
}

std::optional<Diagnostic> TipModel::use_tool(std::optional<int> tool) {
  const GaugeLength gauge = gauge_length(setup_, plan_.machine(), tool);
  if (gauge.touch_off && plan_.machine().has_angular_errors())
    return Diagnostic{Severity::error,
                      "E-TOOL",
                      {},
                      fmt::format("the length of tool {} in the tool table is negative", tool.value_or(-1)),
                      "angular errors act with the tool's length, and a negative offset is a touch-off value",
                      fmt::format("give its gauge length: --gauge T{}=..", tool.value_or(-1))};
  ahead_count_ = 0;
  query_.tool = tool_of(plan_.machine(), gauge.length);
  query_.approach.fill(0);
  refresh();
  return std::nullopt;
}

bool TipModel::stand(const Stance& stance) {
  if (stance == stance_) return true;
  stance_ = stance;
  refresh();
  return inverse_ != Mat3::Zero();
}

/// Rotary positions as the model takes them: of axes that count modulo a turn within one.
void TipModel::turn(Query& query, const Turns& turns) const {
  constexpr double whole = 2 * std::numbers::pi;
  for (int k = 0; k < 3; ++k) {
    if (!rotary_.has(k)) continue;
    const auto i = static_cast<std::size_t>(k);
    const bool modulo = rotary_.turning(k) != Turning::linear;
    const double angle = modulo ? turns[i] - whole * std::floor(turns[i] / whole) : turns[i];
    query.q[static_cast<std::size_t>(rotary_.axes().rotary[i])] = angle;
  }
}

void TipModel::refresh() {
  ahead_count_ = 0;
  const ControlKinematics& control = rotary_.kinematics();
  query_.q.fill(0);
  turn(query_, stance_.output);
  Affine tip = control.tip_of_axes(stance_.original, query_.tool);
  bool reaches = true;
  if (stance_.tcp) {
    const auto original = control.axes_of_points(stance_.original, stance_.control_length);
    const auto output = control.axes_of_points(stance_.output, stance_.control_length);
    reaches = original && output;
    original_axes_ = original.value_or(Affine{});
    output_axes_ = output.value_or(Affine{});
    tip = after(original_axes_, tip);
  }
  matrix_ = tip.A;
  offset_ = tip.b;
  inverse_ = matrix_.inverse();
  if (!reaches || !inverse_.allFinite()) inverse_.setZero();  // refused by make() and by who asks to stand
}

TipAndAxis TipModel::nominal_pose(const Vec3& m) const {
  return rotary_.kinematics().pose(original_axes_of(m), stance_.original, query_.tool);
}

TipAndAxis TipModel::actual_pose(const Vec3& m, bool* outside) const {
  const Vec3 axes = axes_of(m);
  for (std::size_t k = 0; k < 3; ++k) query_.q[axes_[k]] = axes[static_cast<Eigen::Index>(k)];
  const Pose pose = abbe::actual_pose(plan_, query_, outside);
  return {pose.p, (pose.R * query_.tool.axis).normalized()};
}

void TipModel::place(const Approach& approach) const {
  // Only then: a byte written here makes the kernel wait for it.
  if (!directional_) return;
  for (std::size_t k = 0; k < 3; ++k) query_.approach[axes_[k]] = approach[k];
}

void TipModel::look_ahead(std::span<const Vec3> commands, const Approach& approach) {
  ahead_count_ = ahead_next_ = 0;
  const std::size_t count = std::min(commands.size(), kAhead);
  if (count < 2 || stance_.tcp) return;
  std::copy_n(commands.begin(), count, ahead_.begin());
  ahead_approach_ = approach;
  place(approach);
  if (actual_tip_.neighbours(query_, axes_, std::span(ahead_).first(count), std::span(ahead_tips_)))
    ahead_count_ = count;
}

Vec3 TipModel::actual(const Vec3& m, const Approach& approach, bool* outside) const {
  for (std::size_t i = ahead_next_; i < ahead_count_; ++i) {
    if (ahead_[i] != m || (directional_ && approach != ahead_approach_)) continue;
    ahead_next_ = i;
    if (ahead_tips_[i].outside && outside != nullptr) *outside = true;
    return ahead_tips_[i].tip;
  }
  const Vec3 axes = axes_of(m);
  for (std::size_t k = 0; k < 3; ++k) query_.q[axes_[k]] = axes[static_cast<Eigen::Index>(k)];
  place(approach);
  return actual_tip_(query_, outside);
}

void TipModel::find(const kernel::FlatPlan& plan, std::span<const PlainMotion> motions, Poses& poses) const {
  assert(motions.size() <= Poses::kMost);
  kernel::Setting setting;
  for (int k = 0; k < 3; ++k) {
    setting.tip[k] = query_.tool.tip[k];
    setting.axis[k] = query_.tool.axis[k];
  }
  std::array<std::array<double, Poses::kMost>, kernel::kMaxFlatAxes> rows;  // only what is read is set
  const auto axis_count = static_cast<std::size_t>(plan.view().axis_count);
  for (std::size_t k = 0; k < axis_count; ++k) rows[k].fill(0);
  for (std::size_t i = 0; i < motions.size(); ++i) place(motions[i].m, motions[i].turns, rows, i);
  std::array<const double*, kernel::kMaxFlatAxes> q{};
  for (std::size_t k = 0; k < axis_count; ++k) q[k] = rows[k].data();
  std::array<double*, 6> to{};
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = poses.number[k].data();
  poses.lanes.fill(kernel::Lane::ordinary);
  kernel::best().poses(plan.view(), setting, q.data(), motions.size(), to.data(), poses.lanes.data());
}

void TipModel::nominal_poses(std::span<const PlainMotion> motions, Poses& poses) const {
  find(*believed_, motions, poses);
}

void TipModel::actual_poses(std::span<const PlainMotion> motions, Poses& poses) const {
  find(*flat_, motions, poses);
}

bool TipModel::beyond_travel(const PlainMotion& motion) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double linear = motion.m[static_cast<Eigen::Index>(k)], turn = motion.turns[k];
    const bool within =
        linear >= travel_[k][0] && linear <= travel_[k][1] &&
        (!rotary_.has(static_cast<int>(k)) || (turn >= turn_travel_[k][0] && turn <= turn_travel_[k][1]));
    if (!within) return true;
  }
  return false;
}

int TipModel::beyond_travel(const Vec3& m, double* at) const {
  const Vec3 axes = axes_of(m);
  const auto leaves = [&](double where, const std::array<double, 2>& travel) {
    if (!(where < travel[0] - kTravelSlack || where > travel[1] + kTravelSlack)) return false;
    if (at != nullptr) *at = where;
    return true;
  };
  for (std::size_t k = 0; k < 3; ++k)
    if (leaves(axes[static_cast<Eigen::Index>(k)], travel_[k])) return static_cast<int>(k);
  for (int k = 0; rotary_.any() && k < 3; ++k) {
    if (!rotary_.has(k)) continue;
    const auto i = static_cast<std::size_t>(k);
    if (leaves(query_.q[static_cast<std::size_t>(rotary_.axes().rotary[i])], turn_travel_[i])) return 3 + k;
  }
  return -1;
}

}  // namespace abbe::verifying
