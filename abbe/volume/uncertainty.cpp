#include "abbe/volume/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/evaluate/monte_carlo.h"
#include "abbe/volume/parallel.h"

namespace abbe {
namespace {

constexpr std::size_t kTrialsPerChunk = 8;

std::optional<Plan> plan_of(Machine machine, std::vector<ErrorTerm> errors, const UncertaintyModes& modes,
                            const Environment& environment, ErrorModel model) {
  machine.errors = std::move(errors);
  machine.variables = modes.variables;
  auto plan = make_plan(machine, environment, model);
  if (auto* made = std::get_if<Plan>(&plan)) return std::move(*made);
  return std::nullopt;
}

Query query_at(const VolumeQuestion& volume, const std::array<double, kMaxAxes>& q) {
  Query query;
  query.q = q;
  query.approach = volume.circumstances.approach;
  query.tool = volume.circumstances.tool;
  return query;
}

/// (1): squares of the deviations by every mode, at the points and against the datum.
VolumeUncertainty first_order(const std::vector<Plan>& plans, const VolumeQuestion& volume,
                              const Progress& progress) {
  VolumeUncertainty out;
  const std::size_t points = volume.grid.size(), chunks = chunk_count(points);
  out.u.assign(points, Vec3::Zero());
  out.u_from_datum.assign(points, Vec3::Zero());
  std::vector<Vec3> at_datum;
  for (const Plan& plan : plans)
    at_datum.push_back(predict(plan, query_at(volume, volume.datum)).deviation.position);
  const bool complete = for_each_chunk(
      chunks, volume.circumstances.threads,
      [&](std::size_t chunk) {
        const ChunkRange range = chunk_range(chunk, points);
        for (std::size_t i = range.first; i < range.last; ++i) {
          const Query query = query_at(volume, volume.grid.at(i));
          for (std::size_t m = 0; m < plans.size(); ++m) {
            const Vec3 d = predict(plans[m], query).deviation.position;
            out.u[i] += d.cwiseAbs2();
            out.u_from_datum[i] += (d - at_datum[m]).cwiseAbs2();
          }
          out.u[i] = out.u[i].cwiseSqrt();
          out.u_from_datum[i] = out.u_from_datum[i].cwiseSqrt();
        }
      },
      progress, 0, chunks);
  if (!complete) out.status = VolumeUncertainty::Status::stopped;
  for (const Vec3& u : out.u)
    if (!u.allFinite()) out.status = VolumeUncertainty::Status::overflow;
  return out;
}

/// Distance of the tip over the volume: the largest and the root mean square.
struct Distances {
  double max = 0, rms = 0;
};

/// Sums over some draws at every point, about the deviation as stated so that no digits are lost.
struct Sums {
  std::vector<Vec3> first, second;
};

/// Draws errors and looks at the volume.
class Draws {
 public:
  Draws(const Machine& machine, const UncertaintyModes& modes, const UncertaintyQuestion& question)
      : machine_(machine), modes_(modes), question_(question), points_(question.volume.grid.size()) {}

  /// Deviations at all points with the modes weighted by z; false if a number is too large.
  bool deviations(const std::vector<double>& z, std::vector<Vec3>& out) const {
    std::vector<ErrorTerm> errors = machine_.errors;
    for (std::size_t m = 0; m < z.size(); ++m)
      for (ErrorTerm term : modes_.modes[m]) {
        term.scale *= z[m];
        errors.push_back(std::move(term));
      }
    const auto plan = plan_of(machine_, std::move(errors), modes_, question_.environment, ErrorModel::rigid);
    if (!plan) return false;
    out.resize(points_);
    for (std::size_t i = 0; i < points_; ++i) {
      const Query query = query_at(question_.volume, question_.volume.grid.at(i));
      out[i] = actual_tip(*plan, query) - nominal_tip(*plan, query);
      if (!out[i].allFinite()) return false;
    }
    return true;
  }

  [[nodiscard]] std::vector<double> draw(std::size_t trial) const {
    // An odd multiplier keeps seeds of neighbouring trials apart.
    RandomStream random(question_.seed + 0x9e3779b97f4a7c15U * (trial + 1));
    std::vector<double> z(modes_.modes.size());
    for (double& value : z) value = random.normal();
    return z;
  }

  static Distances distances(const std::vector<Vec3>& deviations) {
    Distances out;
    for (const Vec3& d : deviations) {
      out.max = std::max(out.max, d.norm());
      out.rms += d.squaredNorm();
    }
    out.rms = std::sqrt(out.rms / static_cast<double>(std::max<std::size_t>(deviations.size(), 1)));
    return out;
  }

  /// Fills u_drawn and the figures.
  void run(VolumeUncertainty& out, const Progress& progress) const {
    std::vector<Vec3> stated;
    if (!deviations({}, stated)) {
      out.status = VolumeUncertainty::Status::overflow;
      return;
    }
    const std::size_t trials = question_.trials, chunks = (trials + kTrialsPerChunk - 1) / kTrialsPerChunk;
    std::vector<Distances> figures(trials);
    std::vector<Sums> sums(chunks);
    std::vector<char> bad(chunks, 0);
    const bool complete = for_each_chunk(
        chunks, question_.volume.circumstances.threads,
        [&](std::size_t chunk) { bad[chunk] = run_chunk(chunk, stated, figures, sums[chunk]) ? 0 : 1; },
        progress, 0, chunks);
    if (!complete) out.status = VolumeUncertainty::Status::stopped;
    if (std::find(bad.begin(), bad.end(), 1) != bad.end()) out.status = VolumeUncertainty::Status::overflow;
    if (out.status != VolumeUncertainty::Status::done) return;
    out.u_drawn = spread(sums);
    const Distances as_stated = distances(stated);
    std::vector<double> max, rms;
    for (const Distances& d : figures) {
      max.push_back(d.max);
      rms.push_back(d.rms);
    }
    out.max = summary(as_stated.max, std::move(max));
    out.rms = summary(as_stated.rms, std::move(rms));
  }

 private:
  bool run_chunk(std::size_t chunk, const std::vector<Vec3>& stated, std::vector<Distances>& figures,
                 Sums& sums) const {
    sums.first.assign(points_, Vec3::Zero());
    sums.second.assign(points_, Vec3::Zero());
    std::vector<Vec3> drawn;
    const std::size_t end = std::min(question_.trials, (chunk + 1) * kTrialsPerChunk);
    for (std::size_t trial = chunk * kTrialsPerChunk; trial < end; ++trial) {
      if (!deviations(draw(trial), drawn)) return false;
      figures[trial] = distances(drawn);
      for (std::size_t i = 0; i < points_; ++i) {
        const Vec3 change = drawn[i] - stated[i];
        sums.first[i] += change;
        sums.second[i] += change.cwiseAbs2();
      }
    }
    return true;
  }

  /// Standard deviation of all draws at every point; chunks are added in their order.
  [[nodiscard]] std::vector<Vec3> spread(const std::vector<Sums>& sums) const {
    std::vector<Vec3> out(points_);
    const auto n = static_cast<double>(question_.trials);
    for (std::size_t i = 0; i < points_; ++i) {
      Vec3 first = Vec3::Zero(), second = Vec3::Zero();
      for (const Sums& part : sums) {
        first += part.first[i];
        second += part.second[i];
      }
      out[i] = ((second - first.cwiseAbs2() / n) / std::max(n - 1, 1.0)).cwiseMax(0).cwiseSqrt();
    }
    return out;
  }

  static DrawnFigure summary(double value, std::vector<double> drawn) {
    const MonteCarloResult result = summarise(std::move(drawn), 0.95);
    return {value, result.mean, result.u, result.symmetric[0], result.symmetric[1]};
  }

  const Machine& machine_;
  const UncertaintyModes& modes_;
  const UncertaintyQuestion& question_;
  std::size_t points_;
};

}  // namespace

VolumeUncertainty volume_uncertainty(const Machine& machine, const UncertaintyModes& modes,
                                     const UncertaintyQuestion& question, const Progress& progress) {
  VolumeUncertainty out;
  std::vector<Plan> plans;
  for (const auto& mode : modes.modes) {
    auto plan = plan_of(machine, mode, modes, question.environment, ErrorModel::first_order);
    if (!plan) {
      out.status = VolumeUncertainty::Status::missing_sensor;
      return out;
    }
    plans.push_back(std::move(*plan));
  }
  out = first_order(plans, question.volume, progress);
  if (out.status == VolumeUncertainty::Status::done && question.trials > 1)
    Draws(machine, modes, question).run(out, progress);
  return out;
}

}  // namespace abbe
