#include "abbe/fit/observations.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/evaluate/text_findings.h"

namespace abbe {
namespace {

constexpr double kAligned = 1e-9;
constexpr double kAssumedLength = 1 * um, kAssumedAngle = 1 * urad;

Plan ideal_plan(const Machine& machine) {
  Machine ideal = machine;
  ideal.errors.clear();
  return std::get<Plan>(make_plan(ideal, {}, ErrorModel::first_order));
}

/// Writes the equations of one job.
class Equations {
 public:
  explicit Equations(const FitJob& job) : job_(job), plan_(ideal_plan(job.machine)), findings_(job.file) {}

  Parsed<Observations> write() {
    for (const FitRun& run : job_.runs) add_run(run);
    for (const FitDiagonal& diagonal : job_.diagonals) add_diagonal(diagonal);
    for (const FitPoints& points : job_.points) points.ball.empty() ? add_points(points) : add_balls(points);
    Parsed<Observations> out;
    if (!findings_.failed()) out.value = std::move(all_);
    out.diagnostics = findings_.take();
    return out;
  }

 private:
  std::size_t nuisance(std::string name, double value = 0, std::optional<double> u = std::nullopt) {
    all_.nuisances.push_back({std::move(name), value, u});
    return all_.nuisances.size() - 1;
  }

  /// A pose at which the measuring point is the tip of the tool.
  std::size_t pose_at(const std::array<double, kMaxAxes>& q,
                      const std::array<signed char, kMaxAxes>& approach, const FitInstrument& instrument) {
    Query query;
    query.q = q;
    query.approach = approach;
    query.tool = {instrument.point, job_.machine.tool.axis};
    if (instrument.on_work) {
      // The point stays on the work: in the tool's frame it goes back by what the axes moved.
      Query home = query;
      home.q.fill(0);
      query.tool.tip -= nominal_tip(plan_, query) - nominal_tip(plan_, home);
    }
    all_.poses.push_back(query);
    return all_.poses.size() - 1;
  }

  bool turns_with_point_on_work(const FitInstrument& instrument, const std::array<double, kMaxAxes>& q,
                                const std::string& file) {
    if (!instrument.on_work) return false;
    for (int i = 0; i < job_.machine.axis_count(); ++i) {
      if (job_.machine.axis(i).type != AxisType::rotary || q[static_cast<std::size_t>(i)] == 0) continue;
      findings_.error("E-JOB-AXIS", 0,
                      fmt::format("{}: a point on the work while rotary axes are turned", file),
                      "its way is followed along linear axes only", "measure with rotary axes at zero");
      return true;
    }
    return false;
  }

  double reading_noise(const RunTable& runs, const FitInstrument& instrument, ObservationSet& set) {
    const double noise = std::max(reading_scatter(runs), instrument.noise.value_or(0));
    set.noise_assumed = !(noise > 0);
    return noise > 0 ? noise : set.angle ? kAssumedAngle : kAssumedLength;
  }

  /// Means of the runs of one direction; `equation` completes pose, direction and terms for a target.
  template <class Equation>
  void add_means(const RunTable& runs, double noise, double sign, const Equation& equation) {
    for (const auto& [values, way] : {std::pair(&runs.forward, 1), std::pair(&runs.backward, -1)}) {
      if (values->cols() == 0) continue;
      for (Eigen::Index i = 0; i < values->rows(); ++i) {
        const double target = runs.targets[static_cast<std::size_t>(i)];
        Observation row = equation(target, runs.bidirectional() ? way : 0);
        row.value += sign * values->row(i).mean();
        row.sigma = noise / std::sqrt(static_cast<double>(values->cols()));
        all_.rows.push_back(std::move(row));
      }
    }
  }

  void add_run(const FitRun& run);
  void add_alignment(const FitRun& run, const Vec3& along, const Vec3& across, double travel, double length,
                     std::size_t slope, Observation& row);
  std::size_t alignment_of(const FitRun& run, const Vec3& along, const Vec3& across);
  void add_diagonal(const FitDiagonal& diagonal);
  void add_points(const FitPoints& points);
  void add_balls(const FitPoints& points);
  void finish_set(ObservationSet set) {
    set.end = all_.rows.size();
    all_.sets.push_back(std::move(set));
  }

  const FitJob& job_;
  Plan plan_;
  TextFindings findings_;
  Observations all_;
  std::map<std::pair<std::string, bool>, std::pair<std::size_t, Vec3>>
      rotations_;                              ///< of squares, with normals
  std::map<std::string, std::size_t> angles_;  ///< of squares not exact
};

/// The nuisance that says how the reference of a straightness run lay: the rotation of its square, which
/// other runs share, or a slope of its own.
std::size_t Equations::alignment_of(const FitRun& run, const Vec3& along, const Vec3& across) {
  if (run.square.empty()) return nuisance("alignment of " + run.file);
  const FitSquare& square = *job_.find_square(run.square);
  if (!square.u || *square.u > 0)
    if (angles_.find(run.square) == angles_.end())
      angles_[run.square] = nuisance("angle of square " + run.square, square.deviation, square.u);
  const Vec3 normal = along.cross(across).cwiseAbs();
  const auto key = std::pair(run.square, run.reversed);
  const auto known = rotations_.find(key);
  if (known == rotations_.end()) {
    const std::size_t rotation =
        nuisance(fmt::format("position of square {}{}", run.square, run.reversed ? ", reversed" : ""));
    rotations_[key] = {rotation, normal};
    return rotation;
  }
  if ((known->second.second - normal).norm() > kAligned)
    findings_.error("E-JOB-SQUARE", 0,
                    fmt::format("{}: not in the plane of the other runs on square {}", run.file, run.square),
                    "one position of a square shows the angle of two axes",
                    "declare another square for this plane");
  return known->second.first;
}

/// The reference line of a straightness run, rotated by g about n: reading = deviation - across . (g n x
/// travel). On the second arm of a square whose angle exceeds 90 degrees by a, g + a.
void Equations::add_alignment(const FitRun& run, const Vec3& along, const Vec3& across, double travel,
                              double length, std::size_t slope, Observation& row) {
  if (run.square.empty()) {
    row.terms.push_back({slope, travel / length});
    return;
  }
  const Vec3 normal = along.cross(across).cwiseAbs();
  const double lever = -across.dot(normal.cross(along * travel));
  row.terms.push_back({slope, lever});
  // The plane's arms in the order i, j of i x j = n: the run is on the second one if across x along = n.
  const bool second = along.cwiseAbs().cross(across.cwiseAbs()).dot(normal) < 0;
  if (!second) return;
  const double turned = run.reversed ? -1 : 1;
  const auto angle = angles_.find(run.square);
  if (angle != angles_.end()) {
    row.terms.push_back({angle->second, turned * lever});
  } else {
    row.value -= turned * lever * job_.find_square(run.square)->deviation;
  }
}

void Equations::add_run(const FitRun& run) {
  if (turns_with_point_on_work(run.instrument, run.at, run.file)) return;
  const Body& axis = job_.machine.axis(run.axis);
  const Vec3 along = relative_direction(axis), named = Vec3::Unit(run.error.direction % 3);
  const bool rotary = axis.type == AxisType::rotary;
  const bool positioning =
      rotary == run.error.is_rotation() && std::abs(std::abs(along.dot(named)) - 1) < kAligned;
  const bool straightness = !rotary && !run.error.is_rotation() && !positioning;
  const Vec3 direction = positioning ? along : named;
  ObservationSet set{run.file + " (" + run.name + ")", run.error.is_rotation(), false, all_.rows.size(), 0};
  const double noise = reading_noise(run.runs, run.instrument, set);
  const double first = run.runs.targets.front(), length = run.runs.targets.back() - first;
  const std::size_t offset = nuisance("zero of " + run.file + " (" + run.name + ")");
  const std::size_t slope = straightness ? alignment_of(run, along, named) : 0;
  const bool scaled = positioning && !rotary && run.instrument.scale_u > 0;
  const std::size_t scale = scaled ? nuisance("scale of " + run.file, 0, run.instrument.scale_u) : 0;
  add_means(run.runs, noise, run.instrument.sign, [&](double target, int way) {
    Observation row;
    auto q = run.at;
    std::array<signed char, kMaxAxes> approach{};
    q[static_cast<std::size_t>(run.axis)] = target;
    approach[static_cast<std::size_t>(run.axis)] = static_cast<signed char>(way);
    row.pose = pose_at(q, approach, run.instrument);
    row.direction = direction;
    row.rotation = run.error.is_rotation();
    row.terms = {{offset, 1}};
    // A warm scale moves alpha (T - 20) too far per length.
    if (positioning && !rotary) row.value -= run.thermal * (target - first);
    if (scaled) row.terms.push_back({scale, target - first});
    if (straightness) add_alignment(run, along, named, target - first, length, slope, row);
    return row;
  });
  finish_set(std::move(set));
}

void Equations::add_diagonal(const FitDiagonal& diagonal) {
  if (turns_with_point_on_work(diagonal.instrument, diagonal.from, diagonal.file)) return;
  Query from, to;
  from.tool = to.tool = {diagonal.instrument.point, job_.machine.tool.axis};
  from.q = diagonal.from;
  to.q = diagonal.to;
  const Vec3 way = nominal_tip(plan_, to) - nominal_tip(plan_, from);
  const double length = way.norm(), slack = 1e-3 * mm;
  if (!(length > 0) || diagonal.runs.targets.front() < -slack ||
      diagonal.runs.targets.back() > length + slack) {
    findings_.error("E-JOB-RANGE", 0,
                    fmt::format("{}: targets from {:.6g} to {:.6g} on a diagonal of {:.6g} mm", diagonal.file,
                                diagonal.runs.targets.front(), diagonal.runs.targets.back(), length),
                    "targets are distances from its start", "check from, to and the column target");
    return;
  }
  ObservationSet set{diagonal.file, false, false, all_.rows.size(), 0};
  const double noise = reading_noise(diagonal.runs, diagonal.instrument, set);
  const std::size_t offset = nuisance("zero of " + diagonal.file);
  const bool scaled = diagonal.instrument.scale_u > 0;
  const std::size_t scale =
      scaled ? nuisance("scale of " + diagonal.file, 0, diagonal.instrument.scale_u) : 0;
  add_means(diagonal.runs, noise, diagonal.instrument.sign, [&](double target, int sense) {
    Observation row;
    auto q = diagonal.from;
    std::array<signed char, kMaxAxes> approach{};
    for (std::size_t k = 0; k < kMaxAxes; ++k) {
      const double course = diagonal.to[k] - diagonal.from[k];
      q[k] += target / length * course;
      approach[k] = static_cast<signed char>(course > 0 ? sense : course < 0 ? -sense : 0);
    }
    row.pose = pose_at(q, approach, diagonal.instrument);
    row.direction = way / length;
    row.terms = {{offset, 1}};
    if (scaled) row.terms.push_back({scale, target});
    return row;
  });
  finish_set(std::move(set));
}

void Equations::add_points(const FitPoints& points) {
  constexpr double kLargestDeviation = 10 * mm;
  const std::size_t count = points.poses.size();
  Eigen::Matrix3Xd nominal(3, static_cast<Eigen::Index>(count)),
      measured(3, static_cast<Eigen::Index>(count));
  const std::size_t first_pose = all_.poses.size();
  all_.poses.reserve(first_pose + count);
  all_.rows.reserve(all_.rows.size() + 3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    if (turns_with_point_on_work(points.instrument, points.poses[i], points.file)) return;
    const std::size_t pose = pose_at(points.poses[i], {}, points.instrument);
    nominal.col(static_cast<Eigen::Index>(i)) = nominal_tip(plan_, all_.poses[pose]);
    measured.col(static_cast<Eigen::Index>(i)) = points.measured[i];
  }
  if (points.planned) measured = nominal;
  if (!points.fixed && count >= 3) {
    // The frame of the instrument may lie anywhere: first the nearest rigid motion, then small ones as
    // unknowns.
    const Eigen::Matrix4d motion = Eigen::umeyama(measured, nominal, false);
    measured = (motion.topLeftCorner<3, 3>() * measured).colwise() + motion.topRightCorner<3, 1>();
  }
  const Vec3 centre = nominal.rowwise().mean();
  const double size = std::max((nominal.colwise() - centre).colwise().norm().maxCoeff(), 1e-3);
  const double most = (measured - nominal).colwise().norm().maxCoeff();
  if (!(most < kLargestDeviation)) {
    findings_.error(
        "E-JOB-POINTS", 0, fmt::format("{}: a point is {:.4g} mm from its pose", points.file, most),
        "points and poses do not belong together", "check the axes, their units and the measuring point");
    return;
  }
  ObservationSet set{points.file, false, !points.instrument.noise.has_value(), all_.rows.size(), 0};
  const double noise = points.instrument.noise.value_or(kAssumedLength);
  const std::size_t frame = all_.nuisances.size();
  for (int k = 0; !points.fixed && k < 6; ++k)
    nuisance(fmt::format("{} of the frame of {}", k < 3 ? "position" : "orientation", points.file));
  for (std::size_t i = 0; i < count; ++i) {
    const auto c = static_cast<Eigen::Index>(i);
    const Vec3 arm = (nominal.col(c) - centre) / size;
    for (int k = 0; k < 3; ++k) {
      Observation row;
      row.pose = first_pose + i;
      row.direction = Vec3::Unit(k);
      row.value = measured(k, c) - nominal(k, c);
      row.sigma = noise;
      if (!points.fixed) {
        row.terms.push_back({frame + static_cast<std::size_t>(k), 1});
        for (int j = 0; j < 3; ++j)
          row.terms.push_back({frame + 3 + static_cast<std::size_t>(j), Vec3(Vec3::Unit(j).cross(arm))[k]});
      }
      all_.rows.push_back(std::move(row));
    }
  }
  finish_set(std::move(set));
}

void Equations::add_balls(const FitPoints& points) {
  constexpr double kLargestWander = 5 * mm;
  std::map<int, std::pair<std::size_t, Vec3>> balls;  // first nuisance, where the first pose puts it
  ObservationSet set{points.file, false, !points.instrument.noise.has_value(), all_.rows.size(), 0};
  for (std::size_t i = 0; i < points.poses.size(); ++i) {
    const std::size_t pose = pose_at(points.poses[i], {}, points.instrument);
    const Vec3 tip = nominal_tip(plan_, all_.poses[pose]);
    auto known = balls.find(points.ball[i]);
    if (known == balls.end()) {
      known = balls.emplace(points.ball[i], std::pair(all_.nuisances.size(), tip)).first;
      for (int k = 0; k < 3; ++k) nuisance(fmt::format("place of ball {}", points.ball[i]));
    }
    const auto& [place, first] = known->second;
    if (!((tip - first).norm() < kLargestWander)) {
      findings_.error("E-JOB-BALL", 0,
                      fmt::format("{}: row {} is {:.4g} mm from where ball {} was first", points.file, i + 1,
                                  (tip - first).norm(), points.ball[i]),
                      "the commands do not hold the tip in one ball",
                      "check the chain, the tool length and the units");
      return;
    }
    Vec3 reading = points.readings.empty() ? Vec3(Vec3::Zero()) : points.readings[i];
    if (!points.nest_on_work) reading = nominal_pose(plan_, all_.poses[pose]).R * reading;
    for (int k = 0; k < 3; ++k) {
      // nominal + deviation = place of the ball + reading
      Observation row;
      row.pose = pose;
      row.direction = Vec3::Unit(k);
      row.value = first[k] - tip[k] + points.instrument.sign * reading[k];
      row.sigma = points.instrument.noise.value_or(kAssumedLength);
      row.terms = {{place + static_cast<std::size_t>(k), -1}};
      all_.rows.push_back(std::move(row));
    }
  }
  finish_set(std::move(set));
}

}  // namespace

Vec3 relative_direction(const Body& axis) {
  return axis.branch == Branch::tool ? axis.direction : Vec3(-axis.direction);
}

Parsed<Observations> observations_of(const FitJob& job) { return Equations(job).write(); }

}  // namespace abbe
