#pragma once

// A machine that is measured by instruments that do not know it: files of runs, diagonals, points and balls
// as an instrument would deliver them, from the rigid model of the hidden errors.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"
#include "abbe/evaluate/monte_carlo.h"
#include "abbe/evaluate/run_table.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/machine/read_machine.h"

namespace abbe::test {

/// X carries the workpiece, Y and Z the tool; 21 errors, none of them zero at the origin by construction
/// only.
inline std::string three_axis_machine(const char* seen = "tool") {
  return fmt::format(R"(format = 1
[machine]
name = "hidden"
chain = "w X b Y Z t"
[axis.X]
range = [-200, 300]
origin = [10, -20, 50]
errors_seen = "{}"
[axis.Y]
range = [-200, 200]
origin = [0, 30, 400]
[axis.Z]
range = [-150, 150]
[tool]
origin = [0, 0, 300]
length = 120
)",
                     seen);
}

inline constexpr const char* kHiddenErrors = R"(
[errors]
EXX = { poly = [0, 0.03, -4e-5, 1e-7] }
EYX = { poly = [0, 0.012, 3e-5, 1e-7] }
EZX = { poly = [0, -0.02, -2e-5] }
EAX = { poly = [0, 0.03, 5e-5] }
EBX = { poly = [0, -0.04, 3e-5] }
ECX = { poly = [0, 0.05, -7e-5] }
EXY = { poly = [0, 0.01, -4e-5] }
EYY = { poly = [0, -0.02, 3e-5] }
EZY = { poly = [0, 0.005, 2e-5] }
EAY = { poly = [0, 0.03, 4e-5] }
EBY = { poly = [0, 0.02, -4e-5] }
ECY = { poly = [0, -0.03, 6e-5] }
EXZ = { poly = [0, 0.02, 5e-5] }
EYZ = { poly = [0, -0.01, 4e-5] }
EZZ = { poly = [0, 0.025, -5e-5] }
EAZ = { poly = [0, -0.03, 5e-5] }
EBZ = { poly = [0, 0.03, 4e-5] }
ECZ = { poly = [0, 0.02, 3e-5] }
EC0Y = 24
EB0Z = -18
EA0Z = 11
)";

struct HiddenMachine {
  std::string text;
  Machine machine;
  Plan ideal, actual;

  explicit HiddenMachine(std::string machine_text, const std::string& errors)
      : text(std::move(machine_text)),
        machine(read(text + errors)),
        ideal(plan(read(text))),
        actual(plan(machine)) {}

  static Machine read(const std::string& toml) {
    Parsed<Machine> parsed = read_machine({"hidden.toml", toml}, std::nullopt, {});
    if (!parsed.value) throw std::runtime_error(to_text(parsed.diagnostics.front()));
    return *parsed.value;
  }
  static Plan plan(const Machine& machine) { return std::get<Plan>(make_plan(machine, {})); }

  [[nodiscard]] Query query(const std::array<double, kMaxAxes>& q, const Vec3& optic = Vec3::Zero(),
                            int axis = -1, int way = 0) const {
    Query query;
    query.q = q;
    query.tool = tool_of(machine);
    query.tool.tip += optic;
    if (axis >= 0) query.approach[static_cast<std::size_t>(axis)] = static_cast<signed char>(way);
    return query;
  }
  [[nodiscard]] Vec3 displacement(const Query& q) const {
    return actual_tip(actual, q) - nominal_tip(ideal, q);
  }
  [[nodiscard]] Vec3 rotation(const Query& q) const {
    const Eigen::AngleAxisd turn(Mat3(actual_pose(actual, q).R * nominal_pose(ideal, q).R.transpose()));
    return turn.angle() * turn.axis();
  }
};

/// How an instrument reads.
struct Instrument {
  double noise = 0;  ///< um or urad
  int runs = 1;
  bool bidirectional = false;
  std::uint64_t seed = 1;
  double slope = 0;  ///< rad, of the reference of a straightness run
};

/// The file of one run: `axis` moves over its targets, the others stand at `at`; `direction` 0..5 is what is
/// read.
inline std::string run_file(const HiddenMachine& hidden, int axis, int direction,
                            const std::vector<double>& targets, std::array<double, kMaxAxes> at,
                            const Vec3& optic, const Instrument& instrument) {
  RandomStream random(instrument.seed);
  const double unit = direction < 3 ? um : urad;
  const double zero = 3.7 * unit;  // instruments begin anywhere
  RunTable table;
  table.targets = targets;
  table.quantity = direction < 3 ? Quantity::length : Quantity::angle;
  const auto m = static_cast<Eigen::Index>(targets.size());
  table.forward.resize(m, instrument.runs);
  table.backward.resize(m, instrument.bidirectional ? instrument.runs : 0);
  for (const int way : {1, -1}) {
    Eigen::MatrixXd& values = way > 0 ? table.forward : table.backward;
    for (Eigen::Index i = 0; i < m; ++i) {
      at[static_cast<std::size_t>(axis)] = targets[static_cast<std::size_t>(i)];
      const Query q = hidden.query(at, optic, axis, instrument.bidirectional ? way : 0);
      const double value =
          direction < 3 ? hidden.displacement(q)[direction] : hidden.rotation(q)[direction - 3];
      const double reference = instrument.slope * (targets[static_cast<std::size_t>(i)] - targets.front());
      for (Eigen::Index j = 0; j < values.cols(); ++j)
        values(i, j) = value + zero + reference + instrument.noise * unit * random.normal();
    }
  }
  return write_runs(table);
}

inline std::vector<double> spaced_targets(double lo, double hi, int count) {
  std::vector<double> targets;
  for (int i = 0; i < count; ++i) targets.push_back(lo + (hi - lo) * i / (count - 1));
  return targets;
}

using Files = std::map<std::string, std::string>;

/// Reads a job whose files are in memory.
inline Parsed<FitJob> read_job(const std::string& job, const Files& files) {
  return read_fit_job({"job.toml", job}, [&](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  });
}

inline std::string codes(const Diagnostics& diagnostics) {
  std::string text;
  for (const Diagnostic& diagnostic : diagnostics) text += to_text(diagnostic);
  return text;
}

/// Largest distance between what two plans say of the deviation over a grid of the first three axes, after
/// the rigid motion of the workpiece that fits best: the datum is nobody's error. mm
inline double largest_difference(const HiddenMachine& hidden, const Plan& found,
                                 const std::vector<std::array<double, kMaxAxes>>& poses) {
  const auto n = static_cast<Eigen::Index>(poses.size());
  Eigen::Matrix3Xd truth(3, n), fitted(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Query q = hidden.query(poses[static_cast<std::size_t>(i)]);
    truth.col(i) = actual_tip(hidden.actual, q);
    fitted.col(i) = actual_tip(found, q);
  }
  const Eigen::Matrix4d motion = Eigen::umeyama(fitted, truth, false);
  fitted = (motion.topLeftCorner<3, 3>() * fitted).colwise() + motion.topRightCorner<3, 1>();
  return (fitted - truth).colwise().norm().maxCoeff();
}

inline std::vector<std::array<double, kMaxAxes>> volume_grid() {
  std::vector<std::array<double, kMaxAxes>> poses;
  for (const double x : {-200.0, -60.0, 110.0, 300.0})
    for (const double y : {-200.0, 70.0, 200.0})
      for (const double z : {-150.0, 20.0, 150.0}) poses.push_back({x, y, z});
  return poses;
}

}  // namespace abbe::test
