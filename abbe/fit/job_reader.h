#pragma once

#include <array>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/fit/fit_job.h"
#include "abbe/machine/findings.h"
#include "abbe/machine/toml_document.h"

namespace abbe {

/// What the readers of the entries of a job share: the machine, the units, the files.
class JobReader {
 public:
  JobReader(FitJob& job, FileUnits units, std::string folder, const FileFetcher& fetch,
            const std::optional<MeasurementPlan>& plan, Findings& findings, Diagnostics& out)
      : job_(job),
        units_(units),
        folder_(std::move(folder)),
        fetch_(fetch),
        plan_(plan),
        findings_(findings),
        out_(out) {}

  void read_run(const TomlNode& entry);
  void read_diagonal(const TomlNode& entry);
  void read_points(const TomlNode& entry, bool balls);
  void read_value(const TomlNode& entry);
  void read_square(const TomlNode& entry);
  void read_functions(const TomlNode& table);
  void read_reference(const TomlNode& table);
  void read_locations(const TomlNode& list);
  void read_thermal(const TomlNode& table);
  void read_drift(const TomlNode& entry);

 private:
  using Pose = std::array<double, kMaxAxes>;

  [[nodiscard]] double error_unit(bool rotation) const {
    return rotation ? units_.error_angle : units_.error_length;
  }
  /// Keys of the instrument, which every kind of measurement has, and those of one kind.
  static std::vector<std::string> instrument_keys_and(std::initializer_list<const char*> more);
  std::optional<std::string> text_of(const TomlNode& entry, const char* key, bool needed);
  std::optional<ErrorName> error_of(const TomlNode& entry, const char* key);
  std::optional<Pose> pose_of(const TomlNode& entry, const char* key);
  std::optional<FitInstrument> instrument_of(const TomlNode& entry, bool rotation);
  std::optional<std::string> fetch(const TomlNode& entry, std::string& path);
  /// What a course would be measured over if it is only planned.
  struct Course {
    std::optional<std::array<double, 2>> ends;  ///< of the targets; none: not known
    Quantity targets = Quantity::length, readings = Quantity::length;
  };
  std::optional<RunTable> runs_of_entry(const TomlNode& entry, std::string& path, const Course& course);
  std::optional<RunTable> planned_runs(const TomlNode& entry, std::string& path, const Course& course);
  void plan_points(const TomlNode& entry, FitPoints points);
  void plan_ball_entry(const TomlNode& entry, FitPoints points);
  bool plan_file(const TomlNode& entry, std::string& path);
  [[nodiscard]] Course course_of(const ErrorName& error) const;
  double thermal_of(const TomlNode& entry);
  bool kind_fits(const TomlNode& entry, const FitRun& run);
  void warn_outside(const TomlNode& entry, const FitRun& run);
  void take_points(const TomlNode& entry, const MeasuredTable& table, bool balls, FitPoints points);
  void read_function(const TomlEntry& entry);
  std::optional<DriftReading> drift_reading(const TomlEntry& entry);
  bool take_log(const TomlNode& entry, const MeasuredTable& log, FitDrift& drift);
  bool take_temperatures(const TomlNode& entry, const MeasuredTable& log, FitDrift& drift);

  FitJob& job_;
  FileUnits units_;
  std::string folder_;
  const FileFetcher& fetch_;
  std::optional<MeasurementPlan> plan_;  ///< the measurements do not exist yet
  Findings& findings_;
  Diagnostics& out_;
  std::set<std::string> contents_;  ///< of the measurements read, to notice copies
};

}  // namespace abbe
