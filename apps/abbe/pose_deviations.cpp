#include "pose_deviations.h"

#include <fmt/core.h>

#include <algorithm>
#include <variant>

#include "abbe/core/units.h"
#include "csv.h"

namespace abbe::app {
namespace {

constexpr std::array<const char*, 4> kGroups = {"gear_static", "gear_motion", "tool_static", "tool_motion"};
constexpr std::array<char, 6> kComponents = {'x', 'y', 'z', 'a', 'b', 'c'};

struct NamedUnit {
  const char* name;
  double value;
};
constexpr std::array<NamedUnit, 2> kLengths = {{{"um", um}, {"mm", mm}}};
constexpr std::array<NamedUnit, 3> kAngles = {{{"urad", urad}, {"rad", 1.0}, {"arcsec", arcsec}}};

[[nodiscard]] Diagnostic column_error(std::string file, std::string message, std::string fix) {
  Diagnostic error;
  error.code = "E-COLUMN";
  error.place.file = std::move(file);
  error.message = std::move(message);
  error.fix = std::move(fix);
  return error;
}

}  // namespace

DeviationColumns::DeviationColumns() {
  for (std::size_t n = 0; n < kNumbers; ++n) {
    const std::size_t component = n % kComponents.size();
    const auto add = [&](const NamedUnit& unit) {
      names_.push_back(
          fmt::format("{}_{}_{}", kGroups[n / kComponents.size()], kComponents[component], unit.name));
      number_.push_back(n);
      unit_.push_back(unit.value);
    };
    if (component < 3)
      std::for_each(kLengths.begin(), kLengths.end(), add);
    else
      std::for_each(kAngles.begin(), kAngles.end(), add);
  }
}

bool DeviationColumns::read_row(const std::string& path, Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, path);
    return false;
  }
  CsvReader csv = std::move(std::get<CsvReader>(opened));
  const std::string file = path == "-" ? "<stdin>" : path;
  if (!csv.failed() && csv.next()) {
    for (std::size_t column = 0; column < csv.header().size() && !csv.failed(); ++column) {
      const auto known = std::find(names_.begin(), names_.end(), csv.header()[column]);
      if (known == names_.end()) {
        csv.fail_at(column, "E-COLUMN", fmt::format("'{}' is no deviation", csv.header()[column]),
                    "the columns are gear_static_x_um .. tool_motion_c_urad");
        break;
      }
      const auto name = static_cast<std::size_t>(known - names_.begin());
      if (const std::optional<double> number = csv.number(column)) {
        if (constant_[number_[name]].has_value())
          csv.fail_at(column, "E-COLUMN", fmt::format("'{}' is given a second time", *known));
        constant_[number_[name]] = *number * unit_[name];
      }
    }
    if (!csv.failed() && csv.next()) {
      Diagnostic more = csv.error_at_line("E-CSV", "a second row");
      more.why = "the deviations of this file are those of all poses";
      more.fix = "deviations that change from pose to pose are columns of the --poses file";
      session.report(more);
      return false;
    }
  } else if (!csv.failed()) {
    session.report(csv.error_at_line("E-CSV", "no row below the header"));
    return false;
  }
  if (csv.failed()) {
    session.report(*csv.failure(), csv.broken() ? Exit::internal : Exit::invalid);
    return false;
  }
  return true;
}

bool DeviationColumns::open(const std::string& path, const PoseSource& poses, Session& session) {
  if (!path.empty() && !read_row(path, session)) return false;
  for (std::size_t name = 0; name < names_.size(); ++name) {
    if (!poses.has(name)) continue;
    const std::size_t n = number_[name];
    if (column_[n].has_value() || constant_[n].has_value()) {
      session.report(column_error("--poses", fmt::format("'{}' is given a second time", names_[name]),
                                  "leave out one of them"));
      return false;
    }
    column_[n] = name;
  }
  return check_groups(session);
}

bool DeviationColumns::check_groups(Session& session) {
  bool whole = true, any = false;
  for (std::size_t g = 0; g < kGroups.size(); ++g) {
    std::string missing;
    std::size_t given = 0;
    for (std::size_t k = 0; k < kComponents.size(); ++k) {
      const std::size_t n = g * kComponents.size() + k;
      if (column_[n].has_value() || constant_[n].has_value())
        ++given;
      else
        missing += fmt::format(" {}_{}_{}", kGroups[g], kComponents[k], k < 3 ? "um" : "urad");
    }
    groups_[g] = given == kComponents.size();
    any = any || given > 0;
    if (given == 0 || groups_[g]) continue;
    session.report(column_error("--deviations", "columns are missing:" + missing,
                                "give all six of a group (0 where nothing was found), or none"));
    whole = false;
  }
  if (!any) {
    session.report(option_error("--deviations", "no deviation is given",
                                "columns gear_static_x_um .. tool_motion_c_urad in --deviations FILE or in "
                                "--poses FILE"));
  }
  return whole && any;
}

DeviationColumns::Values DeviationColumns::values(const PoseSource& poses) const {
  Values values;
  const std::array<Twist*, 4> twists = {&values.fixed.gear, &values.moving.gear, &values.fixed.tool,
                                        &values.moving.tool};
  for (std::size_t n = 0; n < kNumbers; ++n) {
    const double value =
        column_[n] ? poses.value(*column_[n]) * unit_[*column_[n]] : constant_[n].value_or(0.0);
    Twist& twist = *twists[n / kComponents.size()];
    const auto component = static_cast<int>(n % kComponents.size());
    (component < 3 ? twist.d[component] : twist.e[component - 3]) = value;
  }
  return values;
}

}  // namespace abbe::app
