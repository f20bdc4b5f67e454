#include "abbe/chain/inverse.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "common.h"
#include "csv.h"
#include "progress.h"
#include "text.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

constexpr std::size_t kWriteAt = std::size_t{1} << 16;
constexpr std::array<const char*, 6> kColumns = {"x", "y", "z", "i", "j", "k"};

struct InverseArguments {
  CommonArguments common;
  std::string pose, poses;
  bool ideal = false;
  std::vector<std::string> lock, near;
};

/// Tip in workpiece axes (mm) and tool axis from the tip to the spindle, as given.
struct ToolPose {
  Vec3 position = Vec3::Zero(), direction = Vec3::UnitZ();
};

/// --pose, or the rows of --poses.
class PoseSource {
 public:
  [[nodiscard]] static std::optional<PoseSource> open(const InverseArguments& arguments, double length_unit,
                                                      Session& session);
  [[nodiscard]] bool next(Session& session);
  [[nodiscard]] const ToolPose& pose() const { return pose_; }
  [[nodiscard]] bool single() const { return !csv_.has_value(); }
  [[nodiscard]] std::string where() const {
    return csv_ ? fmt::format("{}:{}", file_, csv_->line()) : "--pose";
  }
  [[nodiscard]] std::uint64_t bytes_read() const { return csv_ ? csv_->bytes_read() : 0; }
  [[nodiscard]] std::uint64_t bytes_total() const { return csv_ ? csv_->bytes_total() : 0; }

 private:
  explicit PoseSource(double length_unit) : length_unit_(length_unit) {}
  /// False if the direction is no direction.
  [[nodiscard]] bool take(const std::array<double, 6>& numbers);

  double length_unit_;
  std::optional<CsvReader> csv_;
  std::string file_;
  std::array<std::size_t, 6> columns_{};
  ToolPose pose_;
  bool done_ = false;
};

bool PoseSource::take(const std::array<double, 6>& numbers) {
  pose_.position = Vec3(numbers[0], numbers[1], numbers[2]) * length_unit_;
  pose_.direction = Vec3(numbers[3], numbers[4], numbers[5]);
  return pose_.direction.stableNorm() > 0;
}

std::optional<PoseSource> PoseSource::open(const InverseArguments& arguments, double length_unit,
                                           Session& session) {
  PoseSource source(length_unit);
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
  const std::vector<std::string>& header = source.csv_->header();
  std::array<bool, 6> present{};
  for (std::size_t column = 0; column < header.size(); ++column) {
    const auto* const known = std::find(kColumns.begin(), kColumns.end(), header[column]);
    if (known == kColumns.end()) {
      Diagnostic ignored =
          source.csv_->error_at(column, "W-COLUMN", fmt::format("column '{}' is ignored", header[column]));
      ignored.severity = Severity::warning;
      session.report(ignored);
      continue;
    }
    const auto which = static_cast<std::size_t>(known - kColumns.begin());
    source.columns_[which] = column;
    present[which] = true;
  }
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    if (present[i]) continue;
    Diagnostic missing = source.csv_->error_at_line("E-COLUMN", fmt::format("no column '{}'", kColumns[i]));
    missing.fix = "the columns are x,y,z (tip) and i,j,k (tool axis from the tip to the spindle)";
    session.report(missing);
  }
  if (session.has(Exit::invalid)) return std::nullopt;
  return source;
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

void write_json_point(JsonWriter& json, const Machine& machine, const ToolPose& pose,
                      const InverseResult& result, const std::vector<std::string>& outside, bool pass,
                      bool limits) {
  json.begin_object(Layout::one_line);
  const std::array<double, 6> numbers = {pose.position.x(),  pose.position.y(),  pose.position.z(),
                                         pose.direction.x(), pose.direction.y(), pose.direction.z()};
  json.member("pose", std::span<const double>(numbers));
  write_positions(json, "q", machine, result.q);
  json.key("residual").begin_object();
  json.member("position_mm", result.residual_position)
      .member("direction_rad", result.residual_direction)
      .end();
  json.member("status", abbe::to_string(result.status)).member("branch", result.branch);
  json.member("outside_travel", outside);
  if (limits) json.member("pass", pass);
  json.end();
}

std::string point_text(const Machine& machine, const ToolPose& pose, const InverseResult& result,
                       const std::vector<std::string>& outside) {
  std::string text = fmt::format("tip {:.6f} {:.6f} {:.6f} mm, tool axis {:.9f} {:.9f} {:.9f}\n",
                                 pose.position.x(), pose.position.y(), pose.position.z(), pose.direction.x(),
                                 pose.direction.y(), pose.direction.z());
  text += fmt::format("  commands  {}\n", positions_text(machine, result.q));
  text += fmt::format("  {}, branch {}, remains {:.6f} um and {:.3f} urad", abbe::to_string(result.status),
                      result.branch, result.residual_position / um, result.residual_direction / urad);
  for (std::size_t i = 0; i < outside.size(); ++i)
    text += (i == 0 ? ", outside the travel of " : " ") + outside[i];
  return text + '\n';
}

/// Positions of --near: where the machine stands, so that the nearest solution is taken.
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

void inverse_poses(const InverseArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_setting(arguments.common, session);
  if (!setting) return;
  const Machine& machine = setting->machine;
  Diagnostics diagnostics;
  InverseOptions options;
  options.ideal = arguments.ideal;
  options.locked = read_lock(machine, arguments.lock, diagnostics);
  std::array<double, kMaxAxes> start = read_near(machine, arguments.near, diagnostics);
  session.report(diagnostics);
  if (has_errors(diagnostics)) return;
  const std::optional<AxisSet> free = free_axes_or_report(machine, options.locked, session);
  if (!free) return;
  const std::optional<Plan> plan = plan_or_report(*setting, setting->environment, session);
  if (!plan) return;
  std::optional<PoseSource> source = PoseSource::open(arguments, machine.units.length, session);
  if (!source) return;

  const bool as_json = arguments.common.json;
  const Tool tool = tool_of(machine);
  JsonWriter json;
  if (as_json) {
    json.begin_object();
    write_preamble(json, "inverse", machine);
    json.member("model", to_string(setting->model))
        .member("ideal", arguments.ideal)
        .key("points")
        .begin_array();
  }
  std::uint64_t points = 0, failed = 0, outside_points = 0, passed = 0;
  std::string first_failed, first_outside;
  ProgressBar bar("inverse", as_json && !source->single());
  while (!interrupted() && session.out.ok() && source->next(session)) {
    const ToolPose& pose = source->pose();
    const InverseResult result = inverse(*plan, tool, pose.position, pose.direction, start, *free, options);
    const std::vector<std::string> outside = outside_travel(machine, result.q);
    const bool solved = result.status != Status::failed;
    const bool pass = solved && setting->limits.pass(result.residual_position, result.residual_direction);
    ++points;
    if (pass) ++passed;
    if (!solved && failed++ == 0) first_failed = source->where();
    if (solved && !outside.empty() && outside_points++ == 0) first_outside = source->where();
    if (as_json) {
      write_json_point(json, machine, pose, result, outside, pass, setting->limits.given());
      if (json.pending() > kWriteAt) session.out.write(json.take());
    } else {
      session.out.write(point_text(machine, pose, result, outside));
      if (setting->limits.given()) session.out.write(pass ? "  pass\n" : "  FAIL\n");
    }
    // A path goes on from where it is: the next pose takes the solution nearest to this one.
    if (solved) start = result.q;
    bar.show(source->bytes_read(), source->bytes_total());
  }

  const auto finding = [](const std::string& where, const char* code, std::string message) {
    Diagnostic diagnostic;
    diagnostic.code = code;
    diagnostic.place.file = where;
    diagnostic.message = std::move(message);
    return diagnostic;
  };
  if (failed > 0) {
    Diagnostic unreachable =
        finding(first_failed, "E-REACH",
                fmt::format("no commands found for {} of {} poses, the first here", failed, points));
    unreachable.why = "the axes of this machine cannot bring the tool there, or not within their travels";
    session.report(unreachable, Exit::outside);
  }
  if (outside_points > 0) {
    session.report(finding(first_outside, "E-TRAVEL",
                           fmt::format("{} of {} poses need positions outside the travels, the first here",
                                       outside_points, points)),
                   Exit::outside);
  }
  const bool complete = !interrupted() && !session.has(Exit::invalid) && !session.has(Exit::internal);
  if (session.strict && setting->limits.given() && passed != points) session.note(Exit::warnings);
  if (as_json) {
    json.end();
    if (setting->limits.given()) json.member("pass", passed == points && complete);
    json.member("complete", complete).end();
    session.out.write(json.take());
  }
}

}  // namespace

Verb inverse_verb(CLI::App& program, Session& session) {
  CLI::App* command = program.add_subcommand("inverse", "commands that bring the tool to a given pose");
  auto arguments = std::make_shared<InverseArguments>();
  add_common_options(*command, arguments->common, session);
  CLI::Option* pose = command->add_option("--pose", arguments->pose, "tip and tool axis in workpiece axes")
                          ->type_name("x,y,z,i,j,k");
  command->add_option("--poses", arguments->poses, "CSV with the columns x,y,z,i,j,k")
      ->type_name("FILE")
      ->excludes(pose);
  command->add_flag("--ideal", arguments->ideal, "of the ideal machine: errors are ignored");
  command->add_option("--lock", arguments->lock, "axes that stay where --near says: Z1,B1")
      ->type_name("AXIS,..")
      ->allow_extra_args(false);
  command
      ->add_option("--near", arguments->near,
                   "where the machine stands: the nearest solution is taken (all axes at 0)")
      ->type_name("AXIS=VALUE,..")
      ->allow_extra_args(false);
  return {command, [arguments, &session] { inverse_poses(*arguments, session); }};
}

}  // namespace abbe::app
