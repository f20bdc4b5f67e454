#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"
#include "command_line.h"
#include "csv.h"
#include "expansion_options.h"
#include "session.h"

namespace abbe::app {

struct PoseArguments {
  std::string pose, poses;
  std::vector<std::string> near;
  ExpansionArguments expansion;
};

/// --pose, --poses, --near, and those of the workpiece's expansion.
void add_pose_options(Command& verb, PoseArguments& arguments);

/// Positions of --near: where the machine stands, so that the nearest solution is taken.
[[nodiscard]] std::array<double, kMaxAxes> read_near(const Machine& machine,
                                                     const std::vector<std::string>& near,
                                                     Diagnostics& diagnostics);

/// Tip in workpiece axes (mm) and tool axis from the tip to the spindle, as given.
struct ToolPose {
  Vec3 position = Vec3::Zero(), direction = Vec3::UnitZ();
};

/// --pose, or the rows of --poses, expanded about the workpiece's origin if the workpiece is warm. Columns x
/// y z (the machine file's length unit) or x_mm y_mm z_mm, and i j k.
class PoseSource {
 public:
  /// also   further columns that the verb reads; others are ignored with a warning
  [[nodiscard]] static std::optional<PoseSource> open(const PoseArguments& arguments, double length_unit,
                                                      const std::vector<std::string>& also, Session& session);
  [[nodiscard]] bool next(Session& session);
  [[nodiscard]] const ToolPose& pose() const { return pose_; }
  /// Which of `also` are there, and their values in this row, in the order of `also`.
  [[nodiscard]] bool has(std::size_t also) const { return also < also_.size() && also_[also].has_value(); }
  [[nodiscard]] double value(std::size_t also) const { return values_[also]; }
  [[nodiscard]] bool single() const { return !csv_.has_value(); }
  [[nodiscard]] std::string where() const;
  [[nodiscard]] std::uint64_t bytes_read() const { return csv_ ? csv_->bytes_read() : 0; }
  [[nodiscard]] std::uint64_t bytes_total() const { return csv_ ? csv_->bytes_total() : 0; }

 private:
  explicit PoseSource(double length_unit) : length_unit_({length_unit, length_unit, length_unit}) {}
  [[nodiscard]] bool use_columns(const std::vector<std::string>& also, Session& session);
  /// False if the direction is no direction.
  [[nodiscard]] bool take(const std::array<double, 6>& numbers);

  std::array<double, 3> length_unit_;
  WorkpieceExpansion expansion_;
  std::optional<CsvReader> csv_;
  std::string file_;
  std::array<std::size_t, 6> columns_{};
  std::vector<std::optional<std::size_t>> also_;
  std::vector<double> values_;
  ToolPose pose_;
  bool done_ = false;
};

}  // namespace abbe::app
