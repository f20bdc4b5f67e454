#include "abbe/compensate/turning_packet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe {
namespace {

// Nearer to the end of a travel a place is asked for alone, mm or rad.
constexpr double kNearEnd = 1e-5;
template <class Number>
std::array<Number*, kernel::kMaxFlatAxes> pointers(auto& rows) {
  std::array<Number*, kernel::kMaxFlatAxes> to{};
  for (std::size_t k = 0; k < rows.size(); ++k) to[k] = rows[k].data();
  return to;
}

[[nodiscard]] bool is_as_built(const Machine& machine) {
  const auto& axes = machine.control.axes;
  return std::none_of(axes.begin(), axes.end(),
                      [](const ControlAxis& axis) { return axis.origin || axis.direction; });
}

}  // namespace

TurningPacket::TurningPacket(const Plan& plan, const AddressedAxes& axes)
    : flat_(kernel::FlatPlan::make(plan)), kernel_(&kernel::best()) {
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
  if (!usable_) return;
  for (std::size_t k = 0, j = 0; k < 3; ++k) {
    way_axis_[k] = static_cast<std::size_t>(axes.linear[k]);
    if (axes.rotary[k] < 0) continue;
    const auto& controls = machine.control.axes;
    const auto axis = static_cast<std::size_t>(axes.rotary[k]);
    as_written_[k] = axis >= controls.size() || controls[axis].turning == Turning::linear;
    rotary_[j] = k;
    turn_axis_[j++] = static_cast<std::size_t>(axes.rotary[k]);
  }
  slot_ = turn_axis_[0] < turn_axis_[1] ? std::array<std::size_t, 2>{0, 1} : std::array<std::size_t, 2>{1, 0};
}

void TurningPacket::set_tool(const Tool& tool) {
  for (int k = 0; k < 3; ++k) {
    setting_.tip[k] = tool.tip[k];
    setting_.axis[k] = tool.axis[k];
  }
}

void TurningPacket::command(std::size_t i, const Vec3& m, const Turns& turns) {
  for (std::size_t k = 0; k < 3; ++k) commanded_[way_axis_[k]][i] = m[static_cast<Eigen::Index>(k)];
  for (std::size_t j = 0; j < 2; ++j) commanded_[turn_axis_[j]][i] = turns[rotary_[j]];
}

void TurningPacket::estimate(std::size_t count, const Vec3& datum) {
  for (int k = 0; k < 3; ++k) setting_.shift[k] = datum[k];
  lanes_.fill(kernel::Lane::ordinary);
  // The kernels know only full packets.
  for (std::size_t k = 0; count < kMost && k < 5; ++k)
    std::fill(commanded_[k].begin() + static_cast<std::ptrdiff_t>(count), commanded_[k].end(),
              commanded_[k][count - 1]);
  const auto from = pointers<const double>(commanded_);
  const auto to = pointers<double>(estimate_);
  kernel_->estimate_poses(flat_->view(), setting_, from.data(), to.data(), work_, lanes_.data());
  for (std::size_t j = 0; j < 2; ++j) stand_[slot_[j]] = estimate_[turn_axis_[j]];
}

void TurningPacket::settle() {
  const auto near = pointers<const double>(estimate_), stand = pointers<const double>(stand_);
  const auto to = pointers<double>(found_);
  kernel_->refine_poses(flat_->view(), setting_, work_, near.data(), stand.data(), to.data(),
                        turn_left_.data(), way_left_.data(), lanes_.data());
  all_within_ = true;
  for (std::size_t k = 0; k < 5; ++k)
    for (const Row* row : {&commanded_[k], &found_[k]}) {
      const Eigen::Map<const Eigen::Array<double, kMost, 1>> all(row->data());
      all_within_ = all_within_ && all.minCoeff<Eigen::PropagateNaN>() >= lo_[k] &&
                    all.maxCoeff<Eigen::PropagateNaN>() <= hi_[k];
    }
}

bool TurningPacket::within_travels(std::size_t i) const {
  for (std::size_t k = 0; k < 5; ++k)
    for (const double at : {commanded_[k][i], found_[k][i]})
      if (!(at >= lo_[k] && at <= hi_[k])) return false;
  return true;
}

}  // namespace abbe
