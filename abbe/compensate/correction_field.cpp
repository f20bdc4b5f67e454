#include "abbe/compensate/correction_field.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace abbe {
namespace {

// The iteration along a path ends when the next step is bound to be smaller than kTolerance, by the measured
// rate of contraction (kFirstRate after the first step). A program is written with 0.1 um: what a further
// step would change stays well below its last digit.
constexpr double kTolerance = 20 * nm;
constexpr double kFirstRate = 1.0 / 16;
constexpr int kMaxSteps = 12;
constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kTurnTolerance = 1e-9;  // rad, of a rotary correction: far below a last digit

// Looked-at travel of an axis without a stated range, mm.
constexpr double kOpenTravel = 3000;
// More places than this along an axis are never looked at one by one.
constexpr std::size_t kMaxKnots = 20000;
// A command may leave its range by the rounding of its digits.
constexpr double kTravelSlack = 1e-6;

std::vector<double> knots_of(const Machine& machine, int axis) {
  const double unit = machine.axis_unit(axis);
  const auto& range = machine.axis(axis).range;
  const double lo = (range ? (*range)[0] : -kOpenTravel) / unit,
               hi = (range ? (*range)[1] : kOpenTravel) / unit;
  std::vector<double> all;
  for (const auto& error : machine.errors) {
    for (const double v : error.function.knots(axis, std::min(lo, hi), std::max(lo, hi)))
      all.push_back(v * unit);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end(), [](double a, double b) { return b - a < 1e-6; }), all.end());
  if (all.size() > kMaxKnots) {
    const std::size_t step = all.size() / kMaxKnots + 1;
    std::vector<double> thinned;
    for (std::size_t i = 0; i < all.size(); i += step) thinned.push_back(all[i]);
    all = std::move(thinned);
  }
  return all;
}

}  // namespace

CorrectionField::CorrectionField(const Plan& plan, const AddressedAxes& axes, bool probed)
    : plan_(plan),
      actual_tip_(plan),
      axes_(axes),
      control_(plan.machine(), axes),
      probed_(probed),
      tool_(tool_of(plan.machine())) {
  const Machine& machine = plan.machine();
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr std::array<double, 2> open{-infinity, infinity};
  for (std::size_t k = 0; k < 3; ++k) {
    travel_[k] = machine.axis(axes.linear[k]).range.value_or(open);
    knots_[k] = knots_of(machine, axes.linear[k]);
    turn_travel_[k] = open;
    const int rotary = axes.rotary[k];
    if (rotary < 0) continue;
    turn_travel_[k] = machine.axis(rotary).range.value_or(open);
    const auto i = static_cast<std::size_t>(rotary);
    modulo_[k] = i < machine.control.axes.size() && machine.control.axes[i].turning != Turning::linear;
  }
  for (const auto& error : machine.errors) directional_ = directional_ || error.function.is_directional();
  turn_options_.position_tolerance = kTolerance;
  turn_options_.rotation_tolerance = kTurnTolerance;
  refresh_datum();
}

/// A rotary position as the model knows it: an axis that counts modulo a turn stays within one.
double CorrectionField::model_turn(std::size_t k, double turn) const {
  return modulo_[k] ? turn - kTurn * std::floor(turn / kTurn) : turn;
}

Query CorrectionField::query(const Vec3& axes, const Turns& turns) const {
  Query query;
  query.tool = tool_;
  for (std::size_t k = 0; k < 3; ++k) {
    query.q[static_cast<std::size_t>(axes_.linear[k])] = axes[static_cast<Eigen::Index>(k)];
    if (axes_.rotary[k] >= 0) query.q[static_cast<std::size_t>(axes_.rotary[k])] = model_turn(k, turns[k]);
  }
  return query;
}

void CorrectionField::set_tool(const Tool& tool) {
  tool_ = tool;
  refresh_datum();
}

void CorrectionField::set_datum_point(const Vec3& m0) {
  datum_point_ = m0;
  refresh_datum();
}

void CorrectionField::set_control_length(double length) {
  control_length_ = length;
  refresh();
}

bool CorrectionField::set_stance(const Stance& stance) {
  const bool same = stance.tcp == stance_.tcp && stance.commanded == stance_.commanded &&
                    stance.standing == stance_.standing;
  if (same) return independent_;
  stance_ = stance;
  refresh();
  return independent_;
}

void CorrectionField::refresh() {
  last_offset_ = ahead_offset_ = Vec3::Zero();
  ahead_count_ = 0;
  // tip_believed(m) = A m + b at the turns of the original
  nominal_ = control_.tip_of_axes(stance_.commanded, tool_);
  commanded_axes_ = standing_axes_ = Affine{};
  independent_ = true;
  if (stance_.tcp) {
    const auto commanded = control_.axes_of_points(stance_.commanded, control_length_);
    const auto standing = control_.axes_of_points(stance_.standing, control_length_);
    independent_ = commanded && standing;
    commanded_axes_ = commanded.value_or(Affine{});
    standing_axes_ = standing.value_or(Affine{});
    nominal_ = after(commanded_axes_, nominal_);
  }
  const auto back = inverse(nominal_);
  independent_ = independent_ && back.has_value();
  if (back) inverse_axes_ = back->A;
  path_query_ = query(Vec3::Zero(), stance_.standing);
  turn_beyond_travel_ = turn_beyond_travel(stance_.standing);
}

void CorrectionField::refresh_datum() {
  refresh();
  datum_ = Vec3::Zero();
  if (!probed_) return;
  // D0 = tip_actual(m0) - tip_believed(m0), rotary axes at zero
  const Vec3 shift =
      actual_tip(plan_, query(datum_point_, Turns{})) - control_.pose(datum_point_, Turns{}, tool_).position;
  if (shift.allFinite()) datum_ = shift;
}

int CorrectionField::beyond_travel(const Vec3& axes) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double v = axes[static_cast<Eigen::Index>(k)];
    if (v < travel_[k][0] - kTravelSlack || v > travel_[k][1] + kTravelSlack) return static_cast<int>(k);
  }
  return -1;
}

std::optional<int> CorrectionField::turn_beyond_travel(const Turns& turns) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double v = axes_.rotary[k] < 0 ? 0 : model_turn(k, turns[k]);
    if (v < turn_travel_[k][0] - kTravelSlack || v > turn_travel_[k][1] + kTravelSlack)
      return 3 + static_cast<int>(k);
  }
  return std::nullopt;
}

std::optional<Vec3> CorrectionField::commanded_point(const Vec3& axes) const {
  if (!stance_.tcp) return axes;
  const auto back = inverse(commanded_axes_);
  return back ? std::optional<Vec3>((*back)(axes)) : std::nullopt;
}

std::optional<Vec3> CorrectionField::standing_point(const Vec3& axes) const {
  if (!stance_.tcp) return axes;
  const auto back = inverse(standing_axes_);
  return back ? std::optional<Vec3>((*back)(axes)) : std::nullopt;
}

kernel::TipAt CorrectionField::tip_at(const Vec3& q) {
  const Vec3 axes = standing_axes(q);
  for (std::size_t k = 0; k < 3; ++k)
    path_query_.q[static_cast<std::size_t>(axes_.linear[k])] = axes[static_cast<Eigen::Index>(k)];
  kernel::TipAt at;
  at.tip = actual_tip_(path_query_, &at.outside);
  return at;
}

void CorrectionField::approach_by(const std::array<signed char, 3>& approach) {
  if (!directional_) return;
  for (std::size_t k = 0; k < 3; ++k)
    path_query_.approach[static_cast<std::size_t>(axes_.linear[k])] = approach[k];
}

// The correction goes on as it went since the last look.
void CorrectionField::look_ahead(std::span<const Vec3> points, const std::array<signed char, 3>& approach) {
  ahead_count_ = ahead_next_ = 0;
  const std::size_t count = std::min(points.size(), kAhead);
  if (count < 2 || stance_.tcp) return;
  const Vec3 drift = (last_offset_ - ahead_offset_) / static_cast<double>(kAhead);
  ahead_offset_ = last_offset_;
  Vec3 offset = last_offset_;
  for (std::size_t i = 0; i < count; ++i) {
    offset += drift;
    ahead_[i] = points[i];
    ahead_start_[i] = points[i] + offset;
  }
  ahead_approach_ = approach;
  approach_by(approach);
  const std::array<std::size_t, 3> linear = {static_cast<std::size_t>(axes_.linear[0]),
                                             static_cast<std::size_t>(axes_.linear[1]),
                                             static_cast<std::size_t>(axes_.linear[2])};
  if (actual_tip_.neighbours(path_query_, linear, std::span(ahead_start_).first(count), ahead_tips_))
    ahead_count_ = count;
}

/// Where the search for the point begins, and the tip there if it was looked ahead at.
const kernel::TipAt* CorrectionField::begin(const Vec3& m, unsigned withheld,
                                            const std::array<signed char, 3>& approach, Vec3& q) {
  for (std::size_t i = ahead_next_; withheld == 0 && i < ahead_count_; ++i) {
    if (ahead_[i] != m || (directional_ && approach != ahead_approach_)) continue;
    ahead_next_ = i;
    q = ahead_start_[i];
    return &ahead_tips_[i];
  }
  q = m + last_offset_;
  return nullptr;
}

/// A few steps from answer.q, where the tip is `begun` if that is known, of
///   q := q - A^-1 (tip_actual(q) - target)
/// False: not converged, outside the measured volume or a travel; `answer` says which.
bool CorrectionField::follow(const Vec3& m, const Mat3& inverse, const kernel::TipAt* begun, Answer& answer) {
  const Vec3 target = nominal_(m) + datum_;
  Vec3 q = answer.q;
  double before = 0;  // square of the step before
  answer.trouble = Trouble::failed;
  for (int i = 0; i < kMaxSteps; ++i) {
    const kernel::TipAt here = i == 0 && begun != nullptr ? *begun : tip_at(q);
    const Vec3 step = inverse * (target - here.tip);
    q += step;
    const double size = step.squaredNorm();
    if (!std::isfinite(size)) return false;
    const double rate = before > 0 ? std::clamp(16 * size / before, 1e-6, 1.0) : kFirstRate * kFirstRate;
    before = size;
    if (size > kTolerance * kTolerance && size * rate > kTolerance * kTolerance) continue;
    answer.q = q;
    const Vec3 reached = standing_axes(q);
    if (const int axis = beyond_travel(reached); axis >= 0) {
      answer.trouble = Trouble::travel;
      answer.axis = axis;
      answer.at = reached[axis];
      return false;
    }
    if (here.outside) {
      answer.trouble = Trouble::outside;
      return false;
    }
    answer.trouble = Trouble::none;
    last_offset_ = q - m;
    return true;
  }
  return false;
}

/// Least squares over the axes that may move; rows of the others are zero.
Mat3 CorrectionField::inverse_without(unsigned withheld) const {
  if (withheld == 0 && independent_) return inverse_axes_;
  Mat3 columns = nominal_.A;
  for (int k = 0; k < 3; ++k) {
    if (withheld & (1u << k)) columns.col(k).setZero();
  }
  return columns.completeOrthogonalDecomposition().pseudoInverse();
}

CorrectionField::Answer CorrectionField::at(const Vec3& m, unsigned withheld,
                                            const std::array<signed char, 3>& approach) {
  Answer answer;
  answer.q = m;
  const Vec3 commanded = commanded_axes(m);
  if (const int axis = beyond_travel(commanded); axis >= 0) {
    answer.trouble = Trouble::travel;
    answer.axis = axis;
    answer.at = commanded[axis];
    return answer;
  }
  if (turn_beyond_travel_) {
    answer.trouble = Trouble::travel;
    answer.axis = *turn_beyond_travel_;
    answer.at = stance_.standing[static_cast<std::size_t>(answer.axis - 3)];
    return answer;
  }
  approach_by(approach);
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (withheld & (1u << k)) last_offset_[k] = 0;
  }
  const kernel::TipAt* const begun = begin(m, withheld, approach, answer.q);
  if (!follow(m, withheld == 0 && independent_ ? inverse_axes_ : inverse_without(withheld), begun, answer))
    last_offset_.setZero();
  return answer;
}

CorrectionField::TurnsAnswer CorrectionField::turns_at(const Vec3& m, const Turns& commanded,
                                                       unsigned turning) {
  TurnsAnswer answer;
  answer.turns = stance_.standing;
  // The wanted pose is the original's; axes that do not turn stay where the output has them.
  Turns turns = stance_.standing;
  AxisSet free = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const AxisSet linear = AxisSet{1} << axes_.linear[k];
    if (plan_.machine().axis(axes_.linear[k]).correctable) free |= linear;
    if ((turning >> k & 1u) == 0 || axes_.rotary[k] < 0) continue;
    turns[k] = commanded[k];
    if (plan_.machine().axis(axes_.rotary[k]).correctable) free |= AxisSet{1} << axes_.rotary[k];
  }
  Vec3 axes = m;
  if (stance_.tcp) {
    const auto map = control_.axes_of_points(commanded, control_length_);
    if (!map) return answer.trouble = Trouble::failed, answer;
    axes = (*map)(m);
  }
  const TipAndAxis target = control_.pose(axes, commanded, tool_);
  turn_options_.target = &target;
  turn_options_.target_shift = datum_;
  const Correction found = correct(plan_, query(axes, turns), free, turn_options_);
  turn_options_.target = nullptr;
  if (found.status == Status::failed) return answer.trouble = Trouble::failed, answer;
  if (found.outside) return answer.trouble = Trouble::outside, answer;
  for (std::size_t k = 0; k < 3; ++k) {
    if ((turning >> k & 1u) == 0 || axes_.rotary[k] < 0) continue;
    const auto i = static_cast<std::size_t>(axes_.rotary[k]);
    // the model's turn may differ from the control's by whole turns
    answer.turns[k] = commanded[k] + (found.corrected[i] - model_turn(k, commanded[k]));
    answer.held = answer.held || (found.held & (AxisSet{1} << axes_.rotary[k])) != 0;
  }
  return answer;
}

CorrectionField::Miss CorrectionField::miss(const Vec3& m, const Vec3& q) const {
  Miss miss;
  const TipAndAxis target = control_.pose(commanded_axes(m), stance_.commanded, tool_);
  const Pose actual = actual_pose(plan_, query(standing_axes(q), stance_.standing), &miss.outside);
  miss.position = (actual.p - target.position - datum_).norm();
  const Vec3 axis = actual.R * tool_.axis;
  miss.direction = std::atan2(axis.cross(target.tool_axis).norm(), axis.dot(target.tool_axis));
  return miss;
}

}  // namespace abbe
