#include "abbe/gear/machine_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <optional>

#include "abbe/core/least_squares.h"

namespace abbe {
namespace {

constexpr int kFlankSteps = 2;  // of a contraction by the size of the errors, 1e-4
constexpr double kInvisible =
    1e-6;  // of the largest effect on a flank: motions along the gap, about the wheel axis
constexpr std::size_t kFlankRolls = 9;  // per flank, at which its deviation is made small

/// The machine at one moment, or at all if nothing depends on time.
class PlanOverTime {
 public:
  PlanOverTime(const Machine& machine, const CutOptions& options) : machine_(machine), options_(options) {
    changes_ = !options.course.values.empty();
    for (const Variable& variable : machine.variables) changes_ = changes_ || variable.name == "t";
  }

  /// False: sensors are missing.
  [[nodiscard]] bool go_to(double time) {
    if (plan_ && (!changes_ || time == time_)) return true;
    time_ = time;
    auto made = make_plan(machine_, options_.course.at(time, options_.environment), options_.model);
    if (auto* missing = std::get_if<MissingSensors>(&made)) {
      missing_ = *missing;
      return false;
    }
    plan_ = std::get<Plan>(made);
    return true;
  }
  [[nodiscard]] const Plan& plan() const { return *plan_; }
  [[nodiscard]] const MissingSensors& missing() const { return missing_; }

 private:
  const Machine& machine_;
  const CutOptions& options_;
  bool changes_ = false;
  double time_ = 0;
  std::optional<Plan> plan_;
  MissingSensors missing_;
};

/// One place of the wheel: where it should be, and where commands bring it.
class WheelPlace {
 public:
  WheelPlace(const Plan& plan, const Query& nominal, const Mat3& gap)
      : plan_(plan), nominal_(nominal), gap_(gap), wanted_(nominal_pose(plan, nominal)) {}

  /// The deviation of the wheel at these commands, in the axes of the gap.
  [[nodiscard]] Twist deviation(const AxisCommands& q, bool& outside) const {
    Query query = nominal_;
    query.q = q;
    const Pose actual = actual_pose(plan_, query, &outside);
    const Mat3 turn = actual.R * wanted_.R.transpose();
    const Vec3 e = 0.5 * Vec3(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
    return {gap_.transpose() * (actual.p - wanted_.p), gap_.transpose() * e};
  }

  /// Effect of each free axis on the wheel, six rows in the axes of the gap.
  [[nodiscard]] Eigen::MatrixXd effects(AxisSet free) const {
    const Jacobian jacobian = abbe::jacobian(plan_, nominal_);
    const Vec3 axis = wanted_.R * nominal_.tool.axis;
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(6, jacobian.position.cols());
    for (Eigen::Index i = 0; i < out.cols(); ++i) {
      if ((free >> i & 1U) == 0) continue;
      out.block<3, 1>(0, i) = gap_.transpose() * jacobian.position.col(i);
      // e = u x du; the turn about u itself changes nothing.
      out.block<3, 1>(3, i) = gap_.transpose() * axis.cross(Vec3(jacobian.tool_axis.col(i)));
    }
    return out;
  }

 private:
  const Plan& plan_;
  const Query& nominal_;
  const Mat3& gap_;
  Pose wanted_;
};

/// Influences of a few contacts of both flanks, one row each.
Eigen::MatrixXd influence_rows(const WheelInGap& wheel) {
  std::vector<const WheelContact*> chosen;
  for (const auto& contacts : wheel.contacts)
    for (std::size_t k = 0; k < kFlankRolls && !contacts.empty(); ++k)
      chosen.push_back(&contacts[k * (contacts.size() - 1) / (kFlankRolls - 1)]);
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(chosen.size()), 6);
  for (std::size_t i = 0; i < chosen.size(); ++i)
    rows.row(static_cast<Eigen::Index>(i)) = chosen[i]->influence.transpose();
  return rows;
}

class Cutter {
 public:
  Cutter(const WheelInGap& wheel, const CutOptions& options)
      : options_(options), influences_(influence_rows(wheel)) {}

  /// AxisCommands to send at this place.
  /// known   deviation beyond what the machine says
  [[nodiscard]] AxisCommands commands(const Plan& plan, const Query& nominal, const WheelPlace& place,
                                      const Twist& known, MachineCut& cut) {
    switch (options_.correction) {
      case CutCorrection::none:
        return nominal.q;
      case CutCorrection::pose:
        return for_the_pose(plan, nominal, cut);
      case CutCorrection::flank:
        return for_the_flanks(nominal, place, known, cut);
    }
    return nominal.q;
  }

 private:
  [[nodiscard]] AxisCommands for_the_pose(const Plan& plan, const Query& nominal, MachineCut& cut) const {
    const Correction found = correct(plan, nominal, options_.free, options_.solver);
    if (found.status == Status::partial || found.status == Status::degraded) ++cut.partial;
    if (found.status == Status::failed) ++cut.failed;
    return found.corrected;
  }

  [[nodiscard]] AxisCommands for_the_flanks(const Query& nominal, const WheelPlace& place, const Twist& known,
                                            MachineCut& cut) const {
    const Eigen::MatrixXd effects = influences_ * place.effects(options_.free);
    AxisCommands q = nominal.q;
    for (int step = 0; step < kFlankSteps; ++step) {
      const Twist twist = place.deviation(q, cut.outside);
      Vec6 both;
      both << twist.d + known.d, twist.e + known.e;
      TriangularFactor factor(effects.cols());
      factor.add(effects, -influences_ * both);
      const LeastSquaresSolution solution = solve(factor, {kInvisible, false});
      if (!solution.ok()) {
        ++cut.failed;
        return nominal.q;
      }
      for (Eigen::Index i = 0; i < solution.x.size(); ++i) q[static_cast<std::size_t>(i)] += solution.x[i];
    }
    return q;
  }

  const CutOptions& options_;
  Eigen::MatrixXd influences_;
};

}  // namespace

Environment SensorCourse::at(double time_s, const Environment& fixed) const {
  Environment out = fixed;
  out["t"] = time_s;
  if (time.empty()) return out;
  const auto after = std::upper_bound(time.begin(), time.end(), time_s);
  const auto b = static_cast<std::size_t>(std::min(after, time.end() - 1) - time.begin());
  const std::size_t a = after == time.begin() ? b : static_cast<std::size_t>(after - time.begin()) - 1;
  const double part = a == b ? 0.0 : (time_s - time[a]) / (time[b] - time[a]);
  for (const auto& [name, values_of] : values)
    if (b < values_of.size()) out[name] = values_of[a] + part * (values_of[b] - values_of[a]);
  return out;
}

std::variant<MachineCut, MissingSensors> cut_on_machine(const Machine& machine, const GearJob& job,
                                                        const WheelInGap& wheel, const CuttingMotion& motion,
                                                        const CutOptions& options, const Progress& progress) {
  MachineCut cut;
  cut.deviations =
      WheelDeviations(motion.stroke.low, motion.stroke.high, motion.nodes, static_cast<int>(motion.gaps()));
  cut.commands.reserve(motion.commands.size());
  PlanOverTime plans(machine, options);
  Cutter cutter(wheel, options);
  Query nominal;
  nominal.tool = tool_of(machine);
  for (std::size_t gap = 0; gap < motion.gaps(); ++gap) {
    for (std::size_t node = 0; node < motion.nodes; ++node) {
      if (!plans.go_to(motion.time(job.cutting, gap, node))) return plans.missing();
      nominal.q = motion.commands[gap * motion.nodes + node];
      const Mat3 axes = gap_axes(job, gap, motion.height(node));
      const WheelPlace place(plans.plan(), nominal, axes);
      Query sent = nominal;
      if (options.sent != nullptr) sent.q = (*options.sent)[gap * motion.nodes + node];
      const Twist known = options.known != nullptr ? options.known->of(gap, node) : Twist{};
      const AxisCommands q = cutter.commands(plans.plan(), sent, place, known, cut);
      cut.deviations.of(gap, node) = place.deviation(q, cut.outside);
      cut.commands.push_back(q);
    }
    if (progress && !progress(gap + 1, motion.gaps())) {
      MachineCut stopped;
      stopped.stopped = true;
      return stopped;
    }
  }
  return cut;
}

}  // namespace abbe
