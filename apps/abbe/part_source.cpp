#include "part_source.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <string_view>
#include <utility>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/surface/read_surface.h"
#include "common.h"
#include "csv.h"
#include "progress.h"

namespace abbe::app {
namespace {

constexpr std::size_t kMostCells = 1000000;
constexpr std::size_t kMostPoints = 1000000;
constexpr std::size_t kReport = 256;  // points between two looks at the clock
constexpr double kShown = 0.001 * um;

/// Indices of three columns; nullopt if one is missing, which is then named.
std::optional<std::array<std::size_t, 3>> find_columns(const std::vector<std::string>& header,
                                                       const std::string& names, std::string& missing) {
  const std::vector<std::string> wanted = split_list(names);
  std::array<std::size_t, 3> found{};
  missing = names;
  if (wanted.size() != found.size()) return std::nullopt;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto at = std::find(header.begin(), header.end(), wanted[k]);
    if (at == header.end()) {
      missing = wanted[k];
      return std::nullopt;
    }
    found[k] = static_cast<std::size_t>(at - header.begin());
  }
  return found;
}

std::optional<Vec3> read_point(CsvReader& csv, const std::array<std::size_t, 3>& columns) {
  Vec3 point;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = csv.number(columns[k]);
    if (!value) return std::nullopt;
    if (std::abs(*value) > NurbsSurface::kLongest) {
      csv.fail_at(columns[k], "E-RANGE", "a point more than 1 km away", "points are in mm");
      return std::nullopt;
    }
    point[static_cast<Eigen::Index>(k)] = *value;
  }
  return point;
}

}  // namespace

std::optional<NurbsSurface> load_surface(const std::string& path, Session& session) {
  const std::optional<std::string> text = read_input(path, session);
  if (!text) return std::nullopt;
  Parsed<NurbsSurface> read = read_surface(*text, path);
  session.report(read.diagnostics);
  return std::move(read.value);
}

std::optional<Cutter> read_cutter(const std::string& text, double length, Session& session) {
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  std::vector<std::optional<double>> numbers;
  if (colon != std::string::npos)
    for (const std::string& piece : split_list(std::string_view(text).substr(colon + 1)))
      numbers.push_back(read_number(piece));
  Cutter cutter;
  const std::size_t wanted = kind == "bull" ? 2 : 1;
  bool good = (kind == "ball" || kind == "flat" || kind == "bull") && numbers.size() == wanted;
  for (const auto& number : numbers) good = good && number;
  if (good) {
    cutter.radius = *numbers[0];
    cutter.corner = kind == "ball" ? cutter.radius : kind == "flat" ? 0 : *numbers[1];
    cutter.length = length > 0 ? length : 10 * cutter.radius;
  }
  if (good && cutter.is_valid()) return cutter;
  session.report(option_error(
      "--cutter", fmt::format("'{}' is no cutter", text),
      "write ball:3, flat:10 or bull:10,2 (radius, corner radius), and a length of at least the corner"));
  return std::nullopt;
}

std::optional<GridSize> read_grid(const std::string& text, Session& session) {
  GridSize size;
  const char* const end = text.data() + text.size();
  const auto rows = std::from_chars(text.data(), end, size.rows);
  const bool has_rows = rows.ec == std::errc() && rows.ptr != end && *rows.ptr == 'x';
  const auto columns = has_rows ? std::from_chars(rows.ptr + 1, end, size.columns) : rows;
  const bool good =
      has_rows && columns.ec == std::errc() && columns.ptr == end && size.rows > 0 && size.columns > 0;
  if (good && size.rows <= kMostCells && size.columns <= kMostCells / size.rows) return size;
  session.report(option_error("--grid", fmt::format("'{}' is no grid", text),
                              "write 10x10: rows along u, columns along v, at most a million points"));
  return std::nullopt;
}

std::optional<std::vector<TouchedPoint>> load_points(const std::string& path, const PointColumns& columns,
                                                     const NearestPoint& nominal, Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, path);
    return std::nullopt;
  }
  CsvReader& csv = std::get<CsvReader>(opened);
  std::vector<TouchedPoint> points;
  std::string missing, no_target;
  const auto measured = csv.failed() ? std::nullopt : find_columns(csv.header(), columns.measured, missing);
  const auto target = find_columns(csv.header(), columns.target, no_target);
  if (!csv.failed() && (!measured || (columns.target_needed && !target))) {
    Diagnostic error =
        csv.error_at_line("E-COLUMN", fmt::format("no column '{}'", measured ? no_target : missing));
    error.fix = measured ? "--target-columns with the names of three columns"
                         : "a header row with x,y,z in mm, or --columns with the names of three columns";
    session.report(error);
    return std::nullopt;
  }
  ProgressBar bar(fmt::format("read {}", path));
  while (!csv.failed() && csv.next()) {
    if (points.size() % kReport == 0) bar.show(csv.bytes_read(), csv.bytes_total());
    if (interrupted()) return std::nullopt;
    const auto point = read_point(csv, *measured);
    const auto should = point && target ? read_point(csv, *target) : std::nullopt;
    if (csv.failed()) break;
    if (points.size() == kMostPoints)
      csv.fail_at((*measured)[0], "E-RANGE", "more than a million points", "split the file");
    TouchedPoint& added = points.emplace_back(TouchedPoint{*point, std::nullopt});
    if (should) added.target = nominal(*should).place;
  }
  if (csv.failed()) session.report(*csv.failure(), csv.broken() ? Exit::internal : Exit::invalid);
  if (!csv.failed() && points.empty()) session.report(csv.error_at_line("E-CSV", "no points"));
  return csv.failed() || points.empty() ? std::nullopt : std::optional(std::move(points));
}

std::string figures_text(const InspectionFigures& f) {
  const auto row = [](const char* name, double value, const char* meaning) {
    const double shown = std::abs(value) < kShown / 2 ? 0 : value;  // no -0.000
    return fmt::format("  {:<9}{:>10.3f} um{}{}\n", name, shown / um, *meaning != 0 ? "   " : "", meaning);
  };
  return fmt::format("deviation along the outward normal at {} points, + = material left on\n", f.count) +
         row("mean", f.mean, "") + row("rms", f.rms, "about 0") + row("least", f.least, "") +
         row("most", f.most, "") +
         row("profile", f.profile, "2 max |d|: zone equally disposed about the nominal surface (ISO 1101)") +
         row("range", f.range, "most - least: zone of the same form anywhere") +
         row("linear", f.linear, "total linear error: mean distance of measured and target point");
}

void write_figures(JsonWriter& json, const InspectionFigures& f) {
  json.key("deviation").begin_object();
  json.member("points", static_cast<std::uint64_t>(f.count))
      .member("beside", static_cast<std::uint64_t>(f.beside));
  json.member("mean_mm", f.mean)
      .member("rms_mm", f.rms)
      .member("least_mm", f.least)
      .member("most_mm", f.most);
  json.member("profile_mm", f.profile)
      .member("profile_definition", "2 max |deviation|, zone equally disposed (ISO 1101)");
  json.member("range_mm", f.range).member("linear_mm", f.linear).member("linear_most_mm", f.linear_most);
  json.end();
}

}  // namespace abbe::app
