#include "abbe/compensate/correction_field.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace abbe {
namespace {

// The iteration along a path: see CorrectOptions::position_tolerance for when it ends.
constexpr double kFirstRate = 1.0 / 16;
constexpr int kMaxSteps = 6;

// Looked-at travel of an axis without a stated range, mm.
constexpr double kOpenTravel = 3000;
// More places than this along an axis are never looked at one by one.
constexpr std::size_t kMaxKnots = 20000;
// A command may leave its range by the rounding of its digits.
constexpr double kTravelSlack = 1e-6;
// Least determinant of the three axis directions.
constexpr double kIndependent = 1e-3;
std::vector<double> knots_of(const Machine& machine, int axis) {
  const double unit = machine.axis_unit(axis);
  const auto& range = machine.axis(axis).range;
  const double lo = (range ? (*range)[0] : -kOpenTravel) / unit, hi = (range ? (*range)[1] : kOpenTravel) / unit;
  std::vector<double> all;
  for (const auto& error : machine.errors) {
    for (const double v : error.function.knots(axis, std::min(lo, hi), std::max(lo, hi))) all.push_back(v * unit);
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

std::optional<ProgramAxes> program_axes(const Machine& machine, char& missing) {
  ProgramAxes axes;
  for (int k = 0; k < 3; ++k) {
    const char letter = "XYZ"[k];
    int found = -1;
    for (int i = 0; i < machine.axis_count(); ++i) {
      const Body& body = machine.axis(i);
      if (body.type == AxisType::linear && body.address.size() == 1 && body.address[0] == letter) found = i;
    }
    if (found < 0) {
      missing = letter;
      return std::nullopt;
    }
    axes.index[static_cast<std::size_t>(k)] = found;
  }
  return axes;
}

CorrectionField::CorrectionField(const Plan& plan, const ProgramAxes& axes, bool probed)
    : plan_(plan), actual_tip_(plan), axes_(axes), probed_(probed), tool_(tool_of(plan.machine())) {
  const Machine& machine = plan.machine();
  AxisSet others = 0;
  for (int i = 0; i < machine.axis_count(); ++i) others |= AxisSet{1} << i;
  for (const int i : axes.index) others &= ~(AxisSet{1} << i);
  for (unsigned withheld = 0; withheld < 8; ++withheld) {
    AxisSet locked = others;
    for (int k = 0; k < 3; ++k) {
      if (withheld & (1u << k)) locked |= AxisSet{1} << axes.index[static_cast<std::size_t>(k)];
    }
    free_[withheld] = free_axes(machine, locked).value_or(0);
  }
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    range_[i] = machine.axis(axes.index[i]).range;
    travel_[i] = range_[i].value_or(std::array<double, 2>{-infinity, infinity});
    knots_[i] = knots_of(machine, axes.index[i]);
  }
  for (const auto& error : machine.errors) directional_ = directional_ || error.function.is_directional();
  // A program is written with 0.1 um: what a further step would change stays well below its last digit.
  options_.position_tolerance = 20 * nm;
  refresh_datum();
}

Query CorrectionField::query(const Vec3& m) const {
  Query query;
  query.tool = tool_;
  for (std::size_t k = 0; k < 3; ++k) query.q[static_cast<std::size_t>(axes_.index[k])] = m[static_cast<Eigen::Index>(k)];
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

void CorrectionField::refresh_datum() {
  options_.target_shift = Vec3::Zero();
  last_offset_ = Vec3::Zero();
  // tip_nominal(m) = A m + b: three linear axes between constant bodies
  constexpr double kProbe = 1024;  // mm, a power of two: the division is exact
  nominal_offset_ = nominal_tip(plan_, query(Vec3::Zero()));
  for (Eigen::Index k = 0; k < 3; ++k)
    nominal_axes_.col(k) = (nominal_tip(plan_, query(Vec3(kProbe * Vec3::Unit(k)))) - nominal_offset_) / kProbe;
  const double volume = nominal_axes_.determinant();
  independent_ = std::abs(volume) > kIndependent;
  if (independent_) inverse_axes_ = nominal_axes_.inverse();
  path_query_ = query(Vec3::Zero());
  if (!probed_) return;
  const Query at_datum = query(datum_point_);
  // D0 = tip_actual(m0) - tip_nominal(m0)
  const Vec3 shift = actual_tip(plan_, at_datum) - nominal_tip(plan_, at_datum);
  if (shift.allFinite()) options_.target_shift = shift;
}

int CorrectionField::beyond_travel(const Vec3& m) const {
  for (std::size_t k = 0; k < 3; ++k) {
    const double v = m[static_cast<Eigen::Index>(k)];
    if (v < travel_[k][0] - kTravelSlack || v > travel_[k][1] + kTravelSlack) return static_cast<int>(k);
  }
  return -1;
}

/// The usual case along a path: all three axes free, the correction within the travels, a few steps of
///   q := q - A^-1 (tip_actual(q) - target)
/// False: let correct() say what is the matter.
bool CorrectionField::follow(const Vec3& m, const std::array<signed char, 3>& approach, Answer& answer) {
  const Vec3 target = nominal_axes_ * m + nominal_offset_ + options_.target_shift;
  Vec3 q = m + last_offset_;
  if (directional_) {
    for (std::size_t k = 0; k < 3; ++k) path_query_.approach[static_cast<std::size_t>(axes_.index[k])] = approach[k];
  }
  double before = 0;
  for (int i = 0; i < kMaxSteps; ++i) {
    bool outside = false;
    for (std::size_t k = 0; k < 3; ++k)
      path_query_.q[static_cast<std::size_t>(axes_.index[k])] = q[static_cast<Eigen::Index>(k)];
    const Vec3 step = inverse_axes_ * (target - actual_tip_(path_query_, &outside));
    q += step;
    const double size = step.norm();
    if (outside || !std::isfinite(size) || beyond_travel(q) >= 0) return false;
    const double rate = before > 0 ? std::clamp(4 * size / before, 1e-3, 1.0) : kFirstRate;
    before = size;
    if (size > options_.position_tolerance && size * rate > options_.position_tolerance) continue;
    answer.q = q;
    last_offset_ = q - m;
    return true;
  }
  return false;
}

CorrectionField::Answer CorrectionField::at(const Vec3& m, unsigned withheld, const std::array<signed char, 3>& approach) {
  Answer answer;
  answer.q = m;
  if (const int axis = beyond_travel(m); axis >= 0) {
    answer.trouble = Trouble::travel;
    answer.axis = axis;
    return answer;
  }
  if (withheld == 0 && independent_ && follow(m, approach, answer)) return answer;
  Query q = query(m);
  for (std::size_t k = 0; k < 3; ++k) q.approach[static_cast<std::size_t>(axes_.index[k])] = approach[k];
  std::array<double, kMaxAxes> start = q.q;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(withheld & (1u << k))) start[static_cast<std::size_t>(axes_.index[k])] += last_offset_[static_cast<Eigen::Index>(k)];
  }
  const Correction correction = correct(plan_, q, free_[withheld], options_, &start);
  if (correction.status == Status::failed) {
    answer.trouble = Trouble::failed;
    return answer;
  }
  // An axis that was stopped at the end of its travel is not corrected any more.
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(correction.held & (AxisSet{1} << axes_.index[k]))) continue;
    answer.trouble = Trouble::travel;
    answer.axis = static_cast<int>(k);
    return answer;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const double corrected = correction.corrected[static_cast<std::size_t>(axes_.index[k])];
    answer.q[static_cast<Eigen::Index>(k)] = corrected;
    if (!(withheld & (1u << k))) last_offset_[static_cast<Eigen::Index>(k)] = corrected - m[static_cast<Eigen::Index>(k)];
  }
  if (correction.outside) {
    answer.trouble = Trouble::outside;
    return answer;
  }
  if (const int axis = beyond_travel(answer.q); axis >= 0) {
    answer.trouble = Trouble::travel;
    answer.axis = axis;
  }
  return answer;
}

}  // namespace abbe
