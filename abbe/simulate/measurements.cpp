#include "abbe/simulate/measurements.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/core/number.h"
#include "abbe/evaluate/monte_carlo.h"

namespace abbe {
namespace {

Plan rigid_plan(const Machine& machine) { return std::get<Plan>(make_plan(machine, {}, ErrorModel::rigid)); }

/// Rotation vector of a rotation matrix.
Vec3 rotation_vector(const Mat3& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// Reads off the hidden machine, one file after the other.
class Campaign {
 public:
  Campaign(const Observations& planned, const FitJob& job, const Machine& hidden, const SimulatedNoise& noise,
           std::uint64_t seed)
      : planned_(planned),
        ideal_(rigid_plan(without_errors(job.machine))),
        hidden_(rigid_plan(hidden)),
        noise_(noise),
        random_(seed) {
    for (const Nuisance& nuisance : planned.nuisances) drawn_.push_back(draw(nuisance));
  }

  /// Fills the runs of the set: rows are the targets forward, then backward.
  RunTable read(const ObservationSet& set, RunTable runs, const FitInstrument& instrument) {
    std::size_t row = set.begin;
    const double noise = instrument.noise.value_or(set.angle ? noise_.angle : noise_.length);
    for (Eigen::MatrixXd* values : {&runs.forward, &runs.backward}) {
      for (Eigen::Index i = 0; values->cols() > 0 && i < values->rows(); ++i, ++row) {
        // What the equation takes off a reading of 0 (a warm scale, the known angle of a square) was in it.
        const double value = reading(planned_.rows[row]) - planned_.rows[row].value;
        for (Eigen::Index j = 0; j < values->cols(); ++j)
          (*values)(i, j) = instrument.sign * value + noise * random_.normal();
      }
    }
    return runs;
  }

  std::string read_points(const ObservationSet& set, const FitPoints& points, const Machine& machine) {
    std::string text;
    for (int i = 0; i < machine.axis_count(); ++i) text += machine.axis(i).name + " [mm],";
    text += "x [mm],y [mm],z [mm]\n";
    const double noise = points.instrument.noise.value_or(noise_.length);
    for (std::size_t i = 0; i < points.poses.size(); ++i) {
      for (int k = 0; k < machine.axis_count(); ++k)
        text += to_shortest(points.poses[i][static_cast<std::size_t>(k)]) + ",";
      for (std::size_t k = 0; k < 3; ++k) {
        const Observation& row = planned_.rows[set.begin + 3 * i + k];
        const double nominal = nominal_tip(ideal_, planned_.poses[row.pose])[static_cast<Eigen::Index>(k)];
        text += to_shortest(nominal + reading(row) + noise * random_.normal()) + (k < 2 ? "," : "\n");
      }
    }
    return text;
  }

  /// An R-test: commands that hold the ideal tip in the ball, and where the true one is.
  std::string read_balls(const ObservationSet& set, const FitPoints& points, const Machine& machine) {
    std::string text;
    for (int i = 0; i < machine.axis_count(); ++i)
      text += machine.axis(i).name + (machine.axis(i).type == AxisType::rotary ? " [deg]," : " [mm],");
    text += "ball,x [mm],y [mm],z [mm]\n";
    const double noise = points.instrument.noise.value_or(noise_.length);
    for (std::size_t i = 0; i < points.poses.size(); ++i) {
      for (int k = 0; k < machine.axis_count(); ++k)
        text += to_shortest(points.poses[i][static_cast<std::size_t>(k)] /
                            (machine.axis(k).type == AxisType::rotary ? deg : mm)) +
                ",";
      text += fmt::format("{}", points.ball[i]);
      Vec3 seen;
      for (Eigen::Index k = 0; k < 3; ++k)
        seen[k] = reading(planned_.rows[set.begin + 3 * i + static_cast<std::size_t>(k)]);
      const Query& query = planned_.poses[planned_.rows[set.begin + 3 * i].pose];
      if (!points.nest_on_work) seen = nominal_pose(ideal_, query).R.transpose() * seen;
      for (Eigen::Index k = 0; k < 3; ++k)
        text += "," + to_shortest(points.instrument.sign * seen[k] + noise * random_.normal());
      text += '\n';
    }
    return text;
  }

 private:
  static Machine without_errors(Machine machine) {
    machine.errors.clear();
    return machine;
  }

  double draw(const Nuisance& nuisance) {
    if (nuisance.u) return nuisance.value + *nuisance.u * random_.normal();
    return noise_.alignment * random_.normal();
  }

  /// direction . (displacement or rotation) + what is not the machine's
  double reading(const Observation& row) const {
    const Query& query = planned_.poses[row.pose];
    double value = row.rotation
                       ? row.direction.dot(rotation_vector(actual_pose(hidden_, query).R *
                                                           nominal_pose(ideal_, query).R.transpose()))
                       : row.direction.dot(actual_tip(hidden_, query) - nominal_tip(ideal_, query));
    for (const Observation::Term& term : row.terms) value += term.coefficient * drawn_[term.nuisance];
    return value;
  }

  const Observations& planned_;
  Plan ideal_, hidden_;
  SimulatedNoise noise_;
  RandomStream random_;
  std::vector<double> drawn_;
};

}  // namespace

std::vector<SimulatedFile> simulate_measurements(const FitJob& job, const Observations& planned,
                                                 const Machine& hidden, const SimulatedNoise& noise,
                                                 std::uint64_t seed) {
  Campaign campaign(planned, job, hidden, noise, seed);
  std::vector<SimulatedFile> files;
  auto set = planned.sets.begin();
  for (const FitRun& run : job.runs)
    files.push_back({run.file, write_runs(campaign.read(*set++, run.runs, run.instrument))});
  for (const FitDiagonal& diagonal : job.diagonals)
    files.push_back({diagonal.file, write_runs(campaign.read(*set++, diagonal.runs, diagonal.instrument))});
  for (const FitPoints& points : job.points)
    files.push_back({points.file, points.ball.empty() ? campaign.read_points(*set++, points, job.machine)
                                                      : campaign.read_balls(*set++, points, job.machine)});
  return files;
}

}  // namespace abbe
