#include "abbe/compensate/turning_packet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe {
namespace {

// Nearer to the end of a travel a place is asked for alone, mm or rad.
constexpr double kNearEnd = 1e-5;
// A last step of solve up to this is known to have converged, mm.
constexpr double kConverged = 1e-3;
// A radian of it counts as much as this, mm (Kernel::correct_poses).
constexpr double kRadian = 300;
// What is left behind a Newton step, as a part of it: five times what was found on machines with errors of
// 100 um and 100 urad. Besides, the field's own answers are left as far from the solution when they end.
constexpr double kLeft = 1e-3, kFieldTurn = 2e-10, kFieldPlace = 2e-8;

template <class Row>
std::array<Row*, kernel::kMaxFlatAxes> rows_of(auto& rows) {
  std::array<Row*, kernel::kMaxFlatAxes> to{};
  for (std::size_t k = 0; k < to.size(); ++k) to[k] = rows[k].data();
  return to;
}

[[nodiscard]] bool is_as_built(const Machine& machine) {
  const auto& axes = machine.control.axes;
  return std::none_of(axes.begin(), axes.end(),
                      [](const ControlAxis& axis) { return axis.origin || axis.direction; });
}

}  // namespace

TurningPacket::TurningPacket(const Plan& plan, const AddressedAxes& axes)
    : flat_(kernel::FlatPlan::make(plan)), kernel_(&kernel::best()), axes_(axes) {
  const Machine& machine = plan.machine();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  int rotary = 0, linear = 0;
  bool correctable = true;
  const auto take = [&](int axis, int& count) {
    if (axis < 0) return;
    ++count;
    correctable = correctable && machine.axis(axis).correctable;
    setting_.free |= std::uint32_t{1} << axis;
    const auto range = machine.axis(axis).range.value_or(std::array<double, 2>{-infinity, infinity});
    lo_[static_cast<std::size_t>(axis)] = range[0] + kNearEnd;
    hi_[static_cast<std::size_t>(axis)] = range[1] - kNearEnd;
  };
  for (std::size_t k = 0; k < 3; ++k) {
    take(axes.linear[k], linear);
    take(axes.rotary[k], rotary);
  }
  usable_ = flat_ != nullptr && linear == 3 && rotary == 2 && machine.axis_count() == 5 && correctable &&
            kernel::corrects(flat_->view(), setting_.free) && is_as_built(machine);
}

void TurningPacket::set_tool(const Tool& tool) {
  for (int k = 0; k < 3; ++k) {
    setting_.tip[k] = tool.tip[k];
    setting_.axis[k] = tool.axis[k];
  }
}

void TurningPacket::command(std::size_t i, const Vec3& m, const Turns& turns) {
  for (std::size_t k = 0; k < 3; ++k) {
    commanded_[static_cast<std::size_t>(axes_.linear[k])][i] = m[static_cast<Eigen::Index>(k)];
    if (axes_.rotary[k] >= 0) commanded_[static_cast<std::size_t>(axes_.rotary[k])][i] = turns[k];
  }
}

void TurningPacket::solve(std::size_t count, const Vec3& datum) {
  for (int k = 0; k < 3; ++k) setting_.shift[k] = datum[k];
  lanes_.fill(kernel::Lane::ordinary);
  const auto from = rows_of<const double>(commanded_);
  const auto to = rows_of<double>(found_);
  kernel_->correct_poses(flat_->view(), setting_, from.data(), count, to.data(), turn_steps_.data(),
                         lanes_.data());
}

void TurningPacket::stand(std::size_t i, const Turns& turns) {
  for (std::size_t k = 0; k < 3; ++k)
    if (axes_.rotary[k] >= 0) found_[static_cast<std::size_t>(axes_.rotary[k])][i] = turns[k];
}

void TurningPacket::settle(std::size_t count) {
  const auto from = rows_of<const double>(commanded_), start = rows_of<const double>(found_);
  const auto to = rows_of<double>(found_);
  // The first step is as long as rounding turns the tip, and would leave doubt about some digits.
  constexpr int kSteps = 2;
  for (int i = 0; i < kSteps; ++i)
    kernel_->settle_poses(flat_->view(), setting_, from.data(), start.data(), count, to.data(),
                          place_steps_.data(), lanes_.data());
}

bool TurningPacket::within_travels(std::size_t i) const {
  for (std::size_t k = 0; k < 5; ++k)
    for (const double at : {commanded_[k][i], found_[k][i]})
      if (!(at >= lo_[k] && at <= hi_[k])) return false;
  return true;
}

bool TurningPacket::ordinary(std::size_t i) const {
  return lanes_[i] == kernel::Lane::ordinary && turn_steps_[i] < kConverged && within_travels(i);
}

double TurningPacket::turn_doubt(std::size_t i) const {
  return kLeft * turn_steps_[i] / kRadian + kFieldTurn;
}

Vec3 TurningPacket::place(std::size_t i) const {
  const auto at = [&](std::size_t k) { return found_[static_cast<std::size_t>(axes_.linear[k])][i]; };
  return {at(0), at(1), at(2)};
}

double TurningPacket::place_doubt(std::size_t i) const { return kLeft * place_steps_[i] + kFieldPlace; }

}  // namespace abbe
