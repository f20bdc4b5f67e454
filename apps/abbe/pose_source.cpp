#include "pose_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <variant>

#include "abbe/chain/expanded_prediction.h"
#include "abbe/core/units.h"
#include "common.h"

namespace abbe::app {
namespace {

constexpr std::array<const char*, 6> kColumns = {"x", "y", "z", "i", "j", "k"};

}  // namespace

void add_pose_options(Command& verb, PoseArguments& arguments) {
  Option* pose = verb.add_option("--pose", arguments.pose, "tip and tool axis in workpiece axes")
                     ->type_name("x,y,z,i,j,k");
  verb.add_option("--poses", arguments.poses, "CSV with the columns x,y,z (or x_mm,y_mm,z_mm) and i,j,k")
      ->type_name("FILE")
      ->excludes(pose);
  verb.add_option("--near", arguments.near,
                  "where the machine stands: the nearest solution is taken (all axes at 0)")
      ->type_name("AXIS=VALUE,..")
      ->allow_extra_args(false);
  add_expansion_options(verb, arguments.expansion);
}

std::array<double, kMaxAxes> read_near(const Machine& machine, const std::vector<std::string>& near,
                                       Diagnostics& diagnostics) {
  std::array<double, kMaxAxes> q{};
  for (const Assignment& given : split_assignments("--near", near, diagnostics)) {
    const int axis = machine.find_axis(given.name);
    if (axis < 0) {
      diagnostics.push_back(option_error("--near",
                                         fmt::format("this chain has no moving axis '{}'", given.name),
                                         suggestion(machine, given.name)));
    } else if (const auto value = option_number("--near", given.name, given.text, diagnostics)) {
      q[static_cast<std::size_t>(axis)] = *value * machine.axis_unit(axis);
    }
  }
  return q;
}

std::string PoseSource::where() const { return csv_ ? fmt::format("{}:{}", file_, csv_->line()) : "--pose"; }

bool PoseSource::take(const std::array<double, 6>& numbers) {
  for (int k = 0; k < 3; ++k)
    pose_.position[k] = numbers[static_cast<std::size_t>(k)] * length_unit_[static_cast<std::size_t>(k)];
  pose_.position = expanded(pose_.position, expansion_);
  pose_.direction = Vec3(numbers[3], numbers[4], numbers[5]);
  return pose_.direction.stableNorm() > 0;
}

std::optional<PoseSource> PoseSource::open(const PoseArguments& arguments, double length_unit,
                                           const std::vector<std::string>& also, Session& session) {
  PoseSource source(length_unit);
  const auto expansion = expansion_or_report(arguments.expansion, session);
  if (!expansion) return std::nullopt;
  source.expansion_ = *expansion;
  if (arguments.poses.empty()) {
    if (arguments.pose.empty()) {
      session.report(option_error("--pose", "no pose is given", "give --pose x,y,z,i,j,k or --poses FILE"));
      return std::nullopt;
    }
    const std::vector<std::string> pieces = split_list(arguments.pose);
    Diagnostics diagnostics;
    std::array<double, 6> numbers{};
    if (pieces.size() != numbers.size()) {
      diagnostics.push_back(
          option_error("--pose", fmt::format("{} numbers instead of the six x,y,z,i,j,k", pieces.size()),
                       "x,y,z is the tip, i,j,k the tool axis from the tip to the spindle"));
    }
    for (std::size_t i = 0; i < numbers.size() && diagnostics.empty(); ++i) {
      const std::optional<double> number = option_number("--pose", kColumns[i], pieces[i], diagnostics);
      if (number) numbers[i] = *number;
    }
    if (diagnostics.empty() && !source.take(numbers)) {
      diagnostics.push_back(option_error("--pose", "the tool axis i,j,k has no length"));
    }
    session.report(diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    return source;
  }

  source.file_ = arguments.poses == "-" ? "<stdin>" : arguments.poses;
  FileResult<CsvReader> csv = CsvReader::open(arguments.poses);
  if (const auto* error = std::get_if<FileError>(&csv)) {
    session.report(*error, arguments.poses);
    return std::nullopt;
  }
  source.csv_.emplace(std::move(std::get<CsvReader>(csv)));
  if (source.csv_->failed()) {
    session.report(*source.csv_->failure(), source.csv_->broken() ? Exit::internal : Exit::invalid);
    return std::nullopt;
  }
  if (!source.use_columns(also, session)) return std::nullopt;
  return source;
}

bool PoseSource::use_columns(const std::vector<std::string>& also, Session& session) {
  const std::vector<std::string>& header = csv_->header();
  also_.assign(also.size(), std::nullopt);
  values_.assign(also.size(), 0.0);
  std::array<bool, 6> present{};
  for (std::size_t column = 0; column < header.size(); ++column) {
    std::string name = header[column];
    const bool in_mm = name.size() == 4 && name.ends_with("_mm");
    if (in_mm) name.resize(1);
    const auto known = std::find(kColumns.begin(), in_mm ? kColumns.begin() + 3 : kColumns.end(), name);
    const auto other = std::find(also.begin(), also.end(), header[column]);
    if (other != also.end()) {
      also_[static_cast<std::size_t>(other - also.begin())] = column;
    } else if (known == (in_mm ? kColumns.begin() + 3 : kColumns.end())) {
      Diagnostic ignored =
          csv_->error_at(column, "W-COLUMN", fmt::format("column '{}' is ignored", header[column]));
      ignored.severity = Severity::warning;
      session.report(ignored);
    } else {
      const auto which = static_cast<std::size_t>(known - kColumns.begin());
      if (present[which]) {
        session.report(csv_->error_at(column, "E-COLUMN", fmt::format("'{}' a second time", name)));
      }
      columns_[which] = column;
      present[which] = true;
      if (in_mm) length_unit_[which] = mm;
    }
  }
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (present[i]) continue;
    Diagnostic missing = csv_->error_at_line("E-COLUMN", fmt::format("no column '{}'", kColumns[i]));
    missing.fix =
        "the columns are x,y,z (tip; or x_mm,y_mm,z_mm) and i,j,k (tool axis from the tip to the spindle)";
    session.report(missing);
  }
  return !session.has(Exit::invalid);
}

bool PoseSource::next(Session& session) {
  if (!csv_) return !std::exchange(done_, true);
  const bool row = csv_->next();
  if (row) {
    std::array<double, 6> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const std::optional<double> number = csv_->number(columns_[i]);
      if (!number) break;
      numbers[i] = *number;
    }
    for (std::size_t i = 0; i < also_.size() && !csv_->failed(); ++i) {
      if (!also_[i]) continue;
      if (const std::optional<double> number = csv_->number(*also_[i])) values_[i] = *number;
    }
    if (!csv_->failed() && !take(numbers)) {
      csv_->fail_at(columns_[3], "E-CELL", "the tool axis i,j,k has no length");
    }
  }
  if (csv_->failed()) {
    session.report(*csv_->failure(), csv_->broken() ? Exit::internal : Exit::invalid);
    return false;
  }
  return row;
}

}  // namespace abbe::app
