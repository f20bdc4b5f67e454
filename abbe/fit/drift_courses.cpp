#include "abbe/fit/drift_courses.h"

#include <fmt/format.h>

#include <Eigen/QR>

#include "abbe/evaluate/text_findings.h"
#include "abbe/fit/independent_columns.h"
#include "abbe/fit/unit_effects.h"

namespace abbe {
namespace {

constexpr double kTolerance = 1e-3;

double unit_of(bool rotation) { return rotation ? urad : um; }

/// S: readings in um or urad per um or urad of each error.
Eigen::MatrixXd effects_on_readings(const FitJob& job, const FitDrift& drift, const UnitEffects& effects) {
  Eigen::MatrixXd S(static_cast<Eigen::Index>(drift.readings.size()),
                    static_cast<Eigen::Index>(effects.count()));
  for (Eigen::Index r = 0; r < S.rows(); ++r) {
    const DriftReading& reading = drift.readings[static_cast<std::size_t>(r)];
    Query query;
    query.q = drift.at;
    query.tool = {reading.point, job.machine.tool.axis};
    for (Eigen::Index k = 0; k < S.cols(); ++k) {
      const Twist twist = effects.at(static_cast<std::size_t>(k), query);
      const bool rotation = read_error_name(job.thermal.errors[static_cast<std::size_t>(k)])->is_rotation();
      S(r, k) = reading.direction.dot(reading.rotation ? twist.e : twist.d) * unit_of(rotation) /
                unit_of(reading.rotation);
    }
  }
  return S;
}

void report_rank(const FitJob& job, const FitDrift& drift, const IndependentColumns& columns,
                 TextFindings& findings) {
  for (const DependentColumn& dependent : columns.dependent) {
    std::string like;
    for (const auto& [other, share] : dependent.like)
      like += (like.empty() ? "" : " and ") + job.thermal.errors[static_cast<std::size_t>(other)];
    findings.error("E-THERMAL-RANK", 0,
                   fmt::format("{}: {} is not determined", drift.file,
                               job.thermal.errors[static_cast<std::size_t>(dependent.column)]),
                   like.empty() ? "no reading shows it" : "the readings cannot tell it from " + like,
                   "add a sensor at another height or direction, or leave the error out");
  }
}

}  // namespace

Parsed<std::vector<DriftCourse>> drift_courses(const FitJob& job) {
  Parsed<std::vector<DriftCourse>> out;
  TextFindings findings(job.file);
  const auto effects = UnitEffects::make(job.machine, job.thermal.errors);
  std::vector<DriftCourse> courses;
  for (const FitDrift& drift : job.drifts) {
    if (!effects) break;  // names are checked by the reader
    const Eigen::MatrixXd S = effects_on_readings(job, drift, *effects);
    const IndependentColumns columns = independent_columns(S, kTolerance);
    report_rank(job, drift, columns, findings);
    if (!columns.dependent.empty()) continue;
    Eigen::MatrixXd readings(S.rows(), static_cast<Eigen::Index>(drift.times.size()));
    for (Eigen::Index r = 0; r < S.rows(); ++r) {
      const DriftReading& reading = drift.readings[static_cast<std::size_t>(r)];
      for (Eigen::Index i = 0; i < readings.cols(); ++i)
        readings(r, i) = reading.values[static_cast<std::size_t>(i)] / unit_of(reading.rotation);
    }
    courses.push_back({drift.validation, drift.settled, drift.times, drift.temperatures,
                       S.householderQr().solve(readings).transpose()});
  }
  out.diagnostics = findings.take();
  if (!has_errors(out.diagnostics)) out.value = std::move(courses);
  return out;
}

}  // namespace abbe
