#include "abbe/chain/correct.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "abbe/chain/correction_step.h"
#include "abbe/chain/frozen_chain.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/chain/printed_form.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

constexpr double kOkPosition = 1e-6;       // mm: what status ok may leave
constexpr double kOkDirection = 1e-11;     // rad: a direction that counts as restored
constexpr double kFirstRate = 1.0 / 16;    // contraction assumed before one was measured
constexpr double kLeastRate = 1e-3;        // and never less, however lucky two steps were
constexpr double kSlow = 0.1;              // contraction beyond which the Jacobian is renewed
constexpr double kLeastTolerance = 1e-15;  // mm or rad: a tolerance of zero means this
constexpr double kStalled = 1e3;           // times the tolerance: rounding of far positions, kinks of tables

using Commands = std::array<double, kMaxAxes>;

[[nodiscard]] bool all_finite(const Commands& q, int axes) {
  return std::all_of(q.begin(), q.begin() + axes, [](double x) { return std::isfinite(x); });
}

[[nodiscard]] AxisSet bit(int axis) { return AxisSet{1} << axis; }

/// The tip and the tool axis of the model's machine.
struct Actual {
  Vec3 p, a;
};

class Corrector {
 public:
  Corrector(const Plan& plan, const Query& query, AxisSet free, const CorrectOptions& options)
      : whole_plan_(plan),
        plan_(plan.impl()),
        query_(query),
        options_(options),
        free_(free & ~options.locked),
        inputs_(plan_, query) {}

  [[nodiscard]] Correction run(const Commands* start) {
    if (!all_finite(query_.q, plan_.axis_count)) {
      for (std::size_t k = 0; k < axes(); ++k) {
        result_.corrected[k] = std::isfinite(query_.q[k]) ? query_.q[k] : 0.0;
      }
      return result_;
    }
    Inputs<double> nominal;
    nominal.q = query_.q.data();
    nominal.tip = query_.tool.tip;
    columns_.v[0] = query_.tool.axis;
    walk_columns(plan_, nominal, columns_);
    const TipAndAxis* wanted = options_.target;
    target_axis_ = wanted != nullptr ? wanted->tool_axis : columns_.v[0];
    target_ = (wanted != nullptr ? wanted->position : columns_.p) + options_.target_shift;
    prepare(columns_);
    set_limits();

    q_ = command();
    finish(solve(start));
    return result_;
  }

 private:
  [[nodiscard]] bool solve(const Commands* start) {
    switch (options_.method) {
      case Method::newton:
        return newton(start);
      case Method::one_step:
        return one_step();
      case Method::closed_form:
        return closed_form(start);
      case Method::printed:
        break;
    }
    return printed();
  }

  [[nodiscard]] std::size_t axes() const { return static_cast<std::size_t>(plan_.axis_count); }

  /// The commands of the axes that exist, zero elsewhere.
  [[nodiscard]] Commands command() const {
    Commands q{};
    std::copy_n(query_.q.begin(), axes(), q.begin());
    return q;
  }

  /// A command outside the travels is the caller's affair: it may stay, not go farther.
  void set_limits() {
    for (std::size_t k = 0; k < axes(); ++k) {
      lo_[k] = std::min(plan_.lo[k], query_.q[k]);
      hi_[k] = std::max(plan_.hi[k], query_.q[k]);
    }
  }

  void prepare(const CarriedColumns& columns) {
    step_.prepare(plan_, columns, target_axis_, free_ & ~result_.held & ~idle_, options_.weights);
    if (step_.singular_axis() == CorrectionStep::kNone) return;
    // Two axes that turn the tool about one line: one of them rests. Whether that costs anything is
    // seen at the end.
    idle_ |= bit(step_.singular_axis());
    step_.prepare(plan_, columns, target_axis_, free_ & ~result_.held & ~idle_, options_.weights);
  }

  [[nodiscard]] Actual actual() {
    inputs_.move_to(q_);
    bool outside = plan_.constant_outside;
    Actual at;
    if (plan_.model == ErrorModel::first_order) {
      CarriedTwist<double, 1> c;
      c.v[0] = query_.tool.axis;
      walk_first_order<double, 1>(plan_, inputs_.inputs(), c, &outside);
      at = {c.p + c.dp, c.v[0] + c.e.cross(c.v[0])};
    } else {
      Carried<double, 1> c;
      c.v[0] = query_.tool.axis;
      walk<double, 1>(plan_, plan_.actual, inputs_.inputs(), c, &outside);
      at = {c.p, c.v[0]};
    }
    result_.outside = outside;
    ++result_.iterations;
    return at;
  }

  [[nodiscard]] Residual residual_of(const Actual& at) const {
    return {at.p - target_, step_.across(at.a - target_axis_)};
  }

  void measure(const Residual& r, double cosine, double allowance_mm) {
    result_.residual_position = r.position.norm() + allowance_mm;
    // angle = atan(sine / cosine), two terms where they are exact
    const double sine = r.direction.norm();
    const double x = sine / cosine;
    result_.residual_direction = cosine > 0 && x < 1e-3 ? x * (1 - x * x / 3) : std::atan2(sine, cosine);
  }

  /// An axis that the step would take out of its travel, or a rotary axis that it would turn too far;
  /// -1 if none. The worst one: the others may do without such steps once it is held.
  [[nodiscard]] int excessive(const Commands& dq) const {
    int worst = -1;
    double most = options_.max_rotary_correction;
    for (int i = 0; i < step_.rotary_count(); ++i) {
      const int axis = step_.rotary(i);
      const auto k = static_cast<std::size_t>(axis);
      const double by = std::abs(q_[k] + dq[k] - query_.q[k]);
      if (!(by <= most)) {
        most = by;
        worst = axis;
      }
    }
    return worst;
  }

  [[nodiscard]] int beyond_travel(const Commands& dq) const {
    constexpr double kSlack = 1e-9;
    for (int i = 0; i < plan_.axis_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double next = q_[k] + dq[k];
      if (dq[k] != 0 && (next < lo_[k] - kSlack || next > hi_[k] + kSlack)) return i;
    }
    return -1;
  }

  void hold(int axis, double at) {
    result_.held |= bit(axis);
    q_[static_cast<std::size_t>(axis)] = at;
    prepare(columns_);
  }

  /// True if the step had to be given up because an axis is now held.
  [[nodiscard]] bool held_instead(const Commands& dq) {
    if (const int axis = excessive(dq); axis >= 0) {
      q_ = held_start();
      hold(axis, query_.q[static_cast<std::size_t>(axis)]);
      return true;
    }
    if (const int axis = beyond_travel(dq); axis >= 0) {
      const auto k = static_cast<std::size_t>(axis);
      hold(axis, std::clamp(q_[k] + dq[k], lo_[k], hi_[k]));
      return true;
    }
    return false;
  }

  /// The command, with axes that already rest at an end of their travel left there.
  [[nodiscard]] Commands held_start() const {
    Commands q = command();
    for (int i = 0; i < plan_.axis_count; ++i) {
      if ((result_.held & bit(i)) != 0) q[static_cast<std::size_t>(i)] = q_[static_cast<std::size_t>(i)];
    }
    return q;
  }

  void move(const Commands& dq) {
    for (std::size_t k = 0; k < axes(); ++k) q_[k] += dq[k];
  }

  /// The larger of both steps in units of its tolerance.
  [[nodiscard]] double size_of(const Commands& dq, double& linear_mm) const {
    double linear = 0, rotary = 0;
    for (int i = 0; i < plan_.axis_count; ++i) {
      const double x = dq[static_cast<std::size_t>(i)];
      ((plan_.rotary & bit(i)) != 0 ? rotary : linear) += x * x;
    }
    linear_mm = std::sqrt(linear);
    return std::max(linear_mm / std::max(options_.position_tolerance, kLeastTolerance),
                    std::sqrt(rotary) / std::max(options_.rotation_tolerance, kLeastTolerance));
  }

  /// What the next step is at most, as a part of this one; `before` is the size of the one before, 0 = none.
  [[nodiscard]] static double safe_rate(double size, double before) {
    return before > 0 ? std::clamp(4 * size / before, kLeastRate, 1.0) : kFirstRate;
  }
  /// The step, or the one that would follow it, is below the tolerance.
  [[nodiscard]] bool settled(double size, double before, int iteration) const {
    const bool last = iteration + 1 == options_.max_iterations;
    return size <= 1 || size * safe_rate(size, before) <= 1 || (last && size <= kStalled);
  }

  [[nodiscard]] bool newton(const Commands* start) {
    if (start != nullptr && all_finite(*start, plan_.axis_count) && !step_.redundant() && !step_.dependent())
      begin_at(*start);
    double before = 0;  // size of the step before, 0 = none since the last hold
    for (int i = 0; i < options_.max_iterations; ++i) {
      const Actual at = actual();
      const Residual r = residual_of(at);
      const double cosine = at.a.dot(target_axis_);
      Residual left;
      const Commands dq = step_.solve(r, left);
      if (!all_finite(dq, plan_.axis_count) || !(cosine > 0)) return false;
      if (held_instead(dq)) {
        before = 0;
        continue;
      }
      double linear_mm = 0;
      const double size = size_of(dq, linear_mm);
      move(dq);
      if (settled(size, before, i)) {
        measure(left, cosine, safe_rate(size, before) * linear_mm);
        return true;
      }
      // A least-squares answer depends on the Jacobian it was found with: there it stays the command's.
      if (before > 0 && size / before > kSlow && step_.square()) renew_jacobian();
      before = size;
    }
    return false;
  }

  /// q <- closed form with the errors frozen at q. What changes the errors from one pass to the next is
  /// the correction itself: 1e-4 of it.
  [[nodiscard]] bool closed_form(const Commands* start) {
    // Anything but rotations cannot be undone by turning (method_fit.h).
    if (plan_.model != ErrorModel::rigid || std::popcount(free_ & ~plan_.rotary) != 3 ||
        std::popcount(free_ & plan_.rotary) > 2) {
      return false;
    }
    if (start != nullptr && all_finite(*start, plan_.axis_count)) begin_at(*start);
    double before = 0;
    for (int i = 0; i < options_.max_iterations; ++i) {
      Commands next = q_;
      bool outside = plan_.constant_outside;
      inputs_.move_to(q_);
      FrozenChain chain;
      chain.freeze(plan_, plan_.actual, inputs_.inputs(), free_ & ~result_.held & ~idle_, &outside);
      result_.outside = outside;
      ++result_.iterations;
      const FrozenChain::Turns turns = chain.aim(q_, query_.tool.axis, target_axis_);
      if (turns.kind == FrozenChain::Turns::Kind::out_of_reach) {
        rest(turns.resting);
        before = 0;
        continue;
      }
      for (int r = 0; r < chain.rotary_count() && turns.count > 0; ++r)
        next[static_cast<std::size_t>(chain.rotary(r))] += turns.change[0][static_cast<std::size_t>(r)];
      chain.reach(next, target_);
      Commands dq{};
      for (std::size_t k = 0; k < axes(); ++k) dq[k] = next[k] - q_[k];
      if (!all_finite(dq, plan_.axis_count)) return false;
      if (held_instead(dq)) {
        before = 0;
        continue;
      }
      double linear_mm = 0;
      const double size = size_of(dq, linear_mm);
      move(dq);
      if (settled(size, before, i)) {
        const Actual at = actual();
        measure(residual_of(at), at.a.dot(target_axis_), 0);
        return at.a.dot(target_axis_) > 0;
      }
      before = size;
    }
    return false;
  }

  /// Two rotary axes that cannot reach the direction: one of them keeps its command.
  void rest(int axis) {
    q_ = held_start();
    idle_ |= bit(axis);
    prepare(columns_);
  }

  [[nodiscard]] bool printed() {
    if (printed_form_obstacle(*plan_.machine, query_.tool, free_).has_value()) return false;
    // Rotary axes that the singularity holds, then those at an end of their travel.
    for (int i = 0; i <= plan_.axis_count; ++i) {
      bool outside = plan_.constant_outside;
      const PrintedForm form =
          printed_form(whole_plan_, query_, target_, target_axis_, result_.held, &outside);
      result_.outside = outside;
      Commands dq{};
      for (std::size_t k = 0; k < axes(); ++k) dq[k] = form.q[k] - query_.q[k];
      if (!all_finite(dq, plan_.axis_count)) return false;
      if (form.singular) idle_ |= free_ & plan_.rotary;
      const int axis = excessive(dq);
      if (axis >= 0 && (result_.held & bit(axis)) == 0) {
        result_.held |= bit(axis);
        continue;
      }
      for (std::size_t k = 0; k < axes(); ++k) {
        q_[k] = std::clamp(form.q[k], lo_[k], hi_[k]);
        if (q_[k] != form.q[k]) result_.held |= bit(static_cast<int>(k));
      }
      const Actual at = actual();
      result_.outside = result_.outside || outside;
      measure(residual_of(at), at.a.dot(target_axis_), 0);
      return at.a.dot(target_axis_) > 0;
    }
    return false;
  }

  void begin_at(const Commands& start) {
    for (int i = 0; i < plan_.axis_count; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if ((free_ & ~idle_ & bit(i)) == 0) continue;
      const bool too_far =
          (plan_.rotary & bit(i)) != 0 && std::abs(start[k] - query_.q[k]) > options_.max_rotary_correction;
      if (!too_far) q_[k] = std::clamp(start[k], lo_[k], hi_[k]);
    }
  }

  void renew_jacobian() {
    Inputs<double> in;
    in.q = q_.data();
    in.tip = query_.tool.tip;
    CarriedColumns columns;
    columns.v[0] = query_.tool.axis;
    walk_columns(plan_, in, columns);
    columns_ = columns;
    prepare(columns_);
  }

  /// dq = -J^+ D_tool at the command: position rows dp, direction rows across(e x a).
  [[nodiscard]] bool one_step() {
    CarriedTwist<double, 1> c;
    c.v[0] = query_.tool.axis;
    bool outside = plan_.constant_outside;
    walk_first_order<double, 1>(plan_, inputs_.inputs(), c, &outside);
    const Residual r = {c.dp - options_.target_shift, step_.across(c.e.cross(target_axis_))};
    Residual left;
    Commands dq = step_.solve(r, left);
    for (int i = 0; i <= plan_.axis_count; ++i) {
      if (!all_finite(dq, plan_.axis_count)) return false;
      if (const int axis = excessive(dq); axis >= 0) {
        hold(axis, query_.q[static_cast<std::size_t>(axis)]);
      } else if (const int end = beyond_travel(dq); end >= 0) {
        hold_at_end(end, dq);
      } else {
        break;
      }
      dq = step_.solve(moved(r), left);
    }
    move(dq);
    rest_ = left;
    const Actual at = actual();
    result_.outside = result_.outside || outside;
    measure(residual_of(at), at.a.dot(target_axis_), 0);
    return true;
  }

  void hold_at_end(int axis, const Commands& dq) {
    const auto k = static_cast<std::size_t>(axis);
    const double end = std::clamp(q_[k] + dq[k], lo_[k], hi_[k]);
    shift_.position += columns_.position.col(axis) * (end - q_[k]);
    shift_.direction += step_.across(columns_.tool_axis.col(axis)) * (end - q_[k]);
    hold(axis, end);
  }

  /// The residual after what held axes already did.
  [[nodiscard]] Residual moved(const Residual& r) const {
    return {r.position + shift_.position, r.direction + shift_.direction};
  }

  void finish(bool done) {
    const bool finite = std::isfinite(result_.residual_position) &&
                        std::isfinite(result_.residual_direction) && all_finite(q_, plan_.axis_count);
    if (!done || !finite) {
      fail();
      return;
    }
    // A resting axis matters if the direction is not what it could be.
    if (idle_ != 0 && result_.residual_direction > kOkDirection) result_.held |= idle_;
    result_.corrected = q_;
    const double allowed = std::max(kOkPosition, options_.position_tolerance);
    const bool first_order = options_.method == Method::one_step || options_.method == Method::printed;
    const double missing = first_order ? rest_.position.norm() : result_.residual_position;
    if (result_.held != 0)
      result_.status = Status::degraded;
    else if (missing <= allowed)
      result_.status = Status::ok;
    else if (step_.position_rank() < 3)
      result_.status = Status::partial;
    else
      fail();
    if (result_.status == Status::degraded && is_worse_than_nothing()) fail();
  }

  /// A correction that stopped at a limit may have carried the tip farther away than it was.
  [[nodiscard]] bool is_worse_than_nothing() {
    const Commands corrected = q_;
    const Correction result = result_;
    q_ = command();
    const Residual before = residual_of(actual());
    q_ = corrected;
    result_ = result;
    return result_.residual_position > before.position.norm() + kOkPosition;
  }

  /// The command goes back untouched, with what it leaves on this machine.
  void fail() {
    const int iterations = result_.iterations;
    const bool outside = result_.outside;
    result_ = Correction{};
    result_.corrected = q_ = command();
    const Actual at = actual();
    measure(residual_of(at), at.a.dot(target_axis_), 0);
    if (!std::isfinite(result_.residual_position) || !std::isfinite(result_.residual_direction)) {
      result_.residual_position = result_.residual_direction = 0;
    }
    result_.outside = result_.outside || outside;
    result_.iterations = iterations;
    result_.status = Status::failed;
  }

  const Plan& whole_plan_;
  const Plan::Impl& plan_;
  const Query& query_;
  const CorrectOptions& options_;
  AxisSet free_;
  AxisSet idle_ = 0;  ///< free axes that rest because another one turns the tool about the same line
  QueryInputs inputs_;
  CarriedColumns columns_;
  CorrectionStep step_;
  Vec3 target_ = Vec3::Zero(), target_axis_ = Vec3::UnitZ();
  Commands q_, lo_, hi_;
  Residual rest_, shift_;  ///< of one_step
  Correction result_;
};

}  // namespace

std::string_view to_string(Status status) {
  switch (status) {
    case Status::ok:
      return "ok";
    case Status::partial:
      return "partial";
    case Status::degraded:
      return "degraded";
    case Status::failed:
      break;
  }
  return "failed";
}

std::string_view to_string(Method method) {
  switch (method) {
    case Method::newton:
      return "newton";
    case Method::one_step:
      return "one-step";
    case Method::closed_form:
      return "closed-form";
    case Method::printed:
      break;
  }
  return "printed";
}

Correction correct(const Plan& plan, const Query& query, AxisSet free, const CorrectOptions& options,
                   const std::array<double, kMaxAxes>* start) {
  return Corrector(plan, query, free, options).run(start);
}

}  // namespace abbe
