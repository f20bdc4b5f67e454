#include "abbe/ballbar/ballbar_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "abbe/ballbar/run_checks.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::size_t kMostFindings = 50;
constexpr double kPerMinute = 1.0 / 60;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

bool is_known_key(std::string_view key) {
  static constexpr std::array<std::string_view, 9> kKeys = {"plane",    "radius_mm",  "feed_mm_per_min",
                                                            "noise_um", "centre_mm",  "setup",
                                                            "machine",  "instrument", "date"};
  return std::find(kKeys.begin(), kKeys.end(), key) != kKeys.end();
}

bool differ(double a, double b) { return std::abs(a - b) > 1e-9 * std::abs(a); }
bool differ(const TestPlane& a, const TestPlane& b) { return !(a == b); }

/// What a column holds; `none` is ignored.
enum class Column {
  none,
  angle,
  deviation_um,
  deviation_mm,
  length,
  time,
  run,
  direction,
  actual,
  commanded
};

struct ColumnMeaning {
  Column column = Column::none;
  int axis = 0;  ///< of positions
};

ColumnMeaning meaning_of(std::string_view name) {
  static constexpr std::array<std::pair<std::string_view, ColumnMeaning>, 13> kColumns = {{
      {"angle_deg", {Column::angle}},
      {"deviation_um", {Column::deviation_um}},
      {"deviation_mm", {Column::deviation_mm}},
      {"radius_mm", {Column::length}},
      {"time_s", {Column::time}},
      {"run", {Column::run}},
      {"direction", {Column::direction}},
      {"x_mm", {Column::actual, 0}},
      {"y_mm", {Column::actual, 1}},
      {"z_mm", {Column::actual, 2}},
      {"x_cmd_mm", {Column::commanded, 0}},
      {"y_cmd_mm", {Column::commanded, 1}},
      {"z_cmd_mm", {Column::commanded, 2}},
  }};
  for (const auto& [text, meaning] : kColumns)
    if (name == text) return meaning;
  return {};
}

/// One reading of one text.
class Reader {
 public:
  Reader(const std::string& file, std::string_view text, const BallbarDefaults& defaults)
      : text_(text), defaults_(defaults) {
    test_.file = file;
  }

  Parsed<BallbarTest> read() {
    if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
    while (next_line() && !give_up_) take_line();
    finish();
    Parsed<BallbarTest> out;
    out.diagnostics = std::move(findings_);
    if (!has_errors(out.diagnostics)) out.value = std::move(test_);
    return out;
  }

 private:
  bool next_line() {
    if (text_.empty()) return false;
    const std::size_t end = text_.find('\n');
    line_ = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    ++number_;
    return true;
  }

  void take_line() {
    const std::string_view line = trimmed(line_);
    if (line.empty()) return;
    if (line.front() == '#') {
      if (columns_.empty()) take_key(trimmed(line.substr(1)));
      return;
    }
    split(line);
    if (columns_.empty()) {
      take_header();
    } else {
      take_row();
    }
  }

  void split(std::string_view line) {
    if (separator_ == 0) {
      separator_ = line.find(',') != std::string_view::npos   ? ','
                   : line.find(';') != std::string_view::npos ? ';'
                                                              : '\t';
    }
    cells_.clear();
    for (std::size_t at = 0; at <= line.size();) {
      const std::size_t end = std::min(line.find(separator_, at), line.size());
      cells_.push_back(trimmed(line.substr(at, end - at)));
      at = end + 1;
    }
  }

  void take_key(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) return;  // a remark
    const std::string key = lower(trimmed(line.substr(0, colon)));
    const std::string_view value = trimmed(line.substr(colon + 1));
    if (is_known_key(key) && std::exchange(key_lines_[key], number_) != 0)
      return error("E-BALLBAR", fmt::format("a second line '{}'", key), "one of the two is of another test",
                   "remove the wrong one");
    if (key == "plane") {
      test_plane_ = read_plane(value);
      if (!test_plane_) wrong_key(key, value, "two of the letters X Y Z, such as XY");
    } else if (key == "radius_mm") {
      radius_ = positive(key, value, mm);
    } else if (key == "feed_mm_per_min") {
      feed_ = positive(key, value, kPerMinute);
    } else if (key == "noise_um") {
      test_.noise = positive(key, value, um);
    } else if (key == "centre_mm") {
      take_centre(value);
    } else if (key == "setup") {
      test_.setup = value;
    } else if (key == "machine") {
      test_.machine = value;
    } else if (key == "instrument") {
      test_.instrument = value;
    } else if (key == "date") {
      test_.date = value;
    }
  }

  std::optional<double> positive(const std::string& key, std::string_view value, double unit) {
    const std::optional<double> number = read_number(value);
    if (number && *number > 0 && *number < 1e9) return *number * unit;
    wrong_key(key, value, "a number above 0");
    return std::nullopt;
  }

  void take_centre(std::string_view value) {
    std::string_view rest = value;
    for (int i = 0; i < 3; ++i) {
      rest = trimmed(rest);
      const std::size_t end = std::min(rest.find_first_of(" \t,;"), rest.size());
      const std::optional<double> number = read_number(rest.substr(0, end));
      if (!number || std::abs(*number) > 1e9) return wrong_key("centre_mm", value, "three numbers X Y Z");
      test_.centre[i] = *number;
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    if (!trimmed(rest).empty()) wrong_key("centre_mm", value, "three numbers X Y Z");
  }

  void take_header() {
    std::vector<std::string> seen;
    bool any = false;
    for (const std::string_view cell : cells_) {
      const std::string name = lower(cell);
      const ColumnMeaning meaning = meaning_of(name);
      const bool twice = std::find(seen.begin(), seen.end(), name) != seen.end();
      if (twice && meaning.column != Column::none)
        error("E-COLUMN", fmt::format("two columns '{}'", name), "", "remove one of them");
      seen.push_back(name);
      columns_.push_back(meaning);
      any = any || meaning.column != Column::none;
    }
    const auto has = [&](Column column, int axis = 0) {
      return std::any_of(columns_.begin(), columns_.end(),
                         [&](const ColumnMeaning& m) { return m.column == column && m.axis == axis; });
    };
    if (!any) {
      error("E-CSV", "no header row with names of columns", "without names nobody knows what the numbers are",
            "begin the table with: angle_deg,deviation_um");
      give_up_ = true;
      return;
    }
    if (!has(Column::angle))
      error("E-COLUMN", "no column angle_deg", "the deviation is a function of the angle", "add it");
    const int lengths = has(Column::deviation_um) + has(Column::deviation_mm) + has(Column::length);
    if (lengths != 1)
      error("E-COLUMN",
            lengths == 0 ? "no column deviation_um, deviation_mm or radius_mm"
                         : "more than one of the columns deviation_um, deviation_mm and radius_mm",
            "", "give the measured deviation once");
    for (const auto& [column, name] : {std::pair{Column::actual, "_mm"}, {Column::commanded, "_cmd_mm"}}) {
      const int given = has(column, 0) + has(column, 1) + has(column, 2);
      if (given != 0 && given != 3)
        error("E-COLUMN", fmt::format("only {} of the columns x{} y{} z{}", given, name, name, name),
              "a position has three coordinates", "add the others; 0 where an axis is missing");
    }
    is_length_ = has(Column::length);
    has_time_ = has(Column::time);
    has_actual_ = has(Column::actual);
    has_commanded_ = has(Column::commanded);
    give_up_ = has_errors(findings_);
  }

  /// The numbers of one row, before they are put into a run.
  struct Row {
    double angle = 0, deviation = 0, time = 0;
    Vec3 actual = Vec3::Zero(), commanded = Vec3::Zero();
    std::string_view run;
    std::optional<int> direction;
  };

  void take_row() {
    if (cells_.size() != columns_.size()) {
      error("E-CSV", fmt::format("{} cells, but {} columns", cells_.size(), columns_.size()), "",
            "complete the row");
      return;
    }
    Row row;
    for (std::size_t i = 0; i < cells_.size(); ++i)
      if (!take_cell(row, columns_[i], cells_[i])) return;
    if (test_.runs.empty() || row.run != run_name_ || row.direction != declared_.back()) {
      test_.runs.emplace_back();
      declared_.push_back(row.direction);
      run_lines_.push_back(number_);
      run_name_ = row.run;
    }
    BallbarRun& run = test_.runs.back();
    run.angle.push_back(row.angle * deg);
    run.deviation.push_back(row.deviation);
    if (has_time_) run.time.push_back(row.time);
    if (has_actual_) run.actual.push_back(row.actual);
    if (has_commanded_) run.commanded.push_back(row.commanded);
  }

  bool take_cell(Row& row, const ColumnMeaning& meaning, std::string_view cell) {
    if (meaning.column == Column::none) return true;
    if (meaning.column == Column::run) {
      row.run = cell;
      return true;
    }
    if (meaning.column == Column::direction) {
      const std::string word = lower(cell);
      if (word == "ccw" || word == "cw") row.direction = word == "ccw" ? +1 : -1;
      if (!row.direction)
        error("E-CELL", "a direction that is neither CCW nor CW", "", "write CCW (the angle grows) or CW");
      return row.direction.has_value();
    }
    const std::optional<double> number = read_number(cell);
    if (!number || std::abs(*number) > 1e12) {
      error("E-CELL", cell.empty() ? "an empty cell" : "a cell that is not a finite number of usual size", "",
            "write the value, or leave out the row");
      return false;
    }
    switch (meaning.column) {
      case Column::angle:
        row.angle = *number;
        break;
      case Column::deviation_um:
        row.deviation = *number * um;
        break;
      case Column::deviation_mm:
        row.deviation = *number;
        break;
      case Column::length:
        row.deviation = *number;
        break;
      case Column::time:
        row.time = *number;
        break;
      case Column::actual:
        row.actual[meaning.axis] = *number;
        break;
      case Column::commanded:
        row.commanded[meaning.axis] = *number;
        break;
      default:
        break;
    }
    return true;
  }

  void finish() {
    number_ = 0;
    line_ = {};
    if (give_up_ || findings_.size() > kMostFindings) return;
    const auto required = [&](auto& from_file, const auto& from_user, const char* what, const char* fix) {
      if (from_file && from_user && differ(*from_file, *from_user))
        add(Severity::warning, "W-BALLBAR",
            fmt::format("the file says another {} than the command line, which is not used", what),
            "the options are for what files do not say", "leave the option out, or correct the file");
      if (!from_file) from_file = from_user;
      if (!from_file) error("E-BALLBAR", fmt::format("the file does not say the {}", what), "", fix);
      return from_file.has_value();
    };
    bool complete =
        required(test_plane_, defaults_.plane, "plane of the test", "add '# plane: XY' or --plane XY");
    complete &=
        required(radius_, defaults_.radius, "nominal radius", "add '# radius_mm: 150' or --radius 150");
    complete &= required(feed_, defaults_.feed, "feed", "add '# feed_mm_per_min: 1000' or --feed 1000");
    if (!complete || has_errors(findings_)) return;
    test_.plane = *test_plane_;
    test_.radius = *radius_;
    test_.feed = *feed_;
    if (test_.runs.empty()) {
      error("E-BALLBAR", "no samples", "", "the table of angles and deviations is missing");
      return;
    }
    for (std::size_t i = 0; i < test_.runs.size(); ++i) {
      BallbarRun& run = test_.runs[i];
      if (is_length_)
        for (double& x : run.deviation) x -= test_.radius;
      if (!declared_[i]) declared_[i] = defaults_.direction;
      for (RunFinding& finding : complete_run(test_, run, declared_[i])) {
        number_ = run_lines_[i];
        add(finding.severity, std::move(finding.code), fmt::format("run {}: {}", i + 1, finding.message),
            std::move(finding.why), std::move(finding.fix));
      }
    }
  }

  void wrong_key(std::string_view key, std::string_view value, std::string_view expected) {
    error("E-BALLBAR",
          fmt::format("{} is '{}', expected {}", key, std::string(value.substr(0, 60)), expected), "",
          "correct the line");
  }
  void error(std::string code, std::string message, std::string why, std::string fix) {
    add(Severity::error, std::move(code), std::move(message), std::move(why), std::move(fix));
  }
  void add(Severity severity, std::string code, std::string message, std::string why, std::string fix) {
    if (findings_.size() > kMostFindings) {
      give_up_ = true;
      return;
    }
    Diagnostic finding;
    finding.severity = severity;
    finding.code = std::move(code);
    finding.place = {test_.file, number_, number_ == 0 ? 0U : 1U, 1,
                     std::string(trimmed(line_).substr(0, 200))};
    finding.message = std::move(message);
    finding.why = std::move(why);
    finding.fix = std::move(fix);
    findings_.push_back(std::move(finding));
  }

  std::string_view text_;
  const BallbarDefaults& defaults_;
  BallbarTest test_;
  Diagnostics findings_;
  std::string_view line_;
  std::size_t number_ = 0;
  bool give_up_ = false;

  std::map<std::string, std::size_t> key_lines_;
  std::optional<TestPlane> test_plane_;
  std::optional<double> radius_, feed_;
  char separator_ = 0;
  std::vector<std::string_view> cells_;
  std::vector<ColumnMeaning> columns_;
  bool has_time_ = false, has_actual_ = false, has_commanded_ = false, is_length_ = false;
  std::string_view run_name_;
  std::vector<std::optional<int>> declared_;  ///< direction per run, where the file says it
  std::vector<std::size_t> run_lines_;
};

void append_vector(std::string& out, const Vec3& v) {
  for (int i = 0; i < 3; ++i) out += ',' + to_shortest(v[i]);
}

}  // namespace

Parsed<BallbarTest> read_ballbar(const std::string& file, std::string_view text,
                                 const BallbarDefaults& defaults) {
  return Reader(file, text, defaults).read();
}

std::string write_ballbar(const BallbarTest& test) {
  std::string out = "# abbe ballbar 1\n";
  const auto key = [&](const char* name, const std::string& value) {
    if (!value.empty()) out += fmt::format("# {}: {}\n", name, value);
  };
  key("plane", to_string(test.plane));
  key("radius_mm", to_shortest(test.radius));
  key("feed_mm_per_min", to_shortest(test.feed / kPerMinute));
  key("centre_mm", fmt::format("{} {} {}", to_shortest(test.centre.x()), to_shortest(test.centre.y()),
                               to_shortest(test.centre.z())));
  if (test.noise) key("noise_um", to_shortest(*test.noise / um));
  key("setup", test.setup);
  key("machine", test.machine);
  key("instrument", test.instrument);
  key("date", test.date);
  const bool time = !test.runs.empty() && !test.runs.front().time.empty();
  const bool actual = !test.runs.empty() && !test.runs.front().actual.empty();
  const bool commanded = !test.runs.empty() && !test.runs.front().commanded.empty();
  out += "run,direction,angle_deg,deviation_um";
  if (time) out += ",time_s";
  if (actual) out += ",x_mm,y_mm,z_mm";
  if (commanded) out += ",x_cmd_mm,y_cmd_mm,z_cmd_mm";
  out += '\n';
  for (std::size_t k = 0; k < test.runs.size(); ++k) {
    const BallbarRun& run = test.runs[k];
    for (std::size_t i = 0; i < run.angle.size(); ++i) {
      out += fmt::format("{},{},{},{}", k + 1, run.direction > 0 ? "CCW" : "CW",
                         to_shortest(run.angle[i] / deg), to_shortest(run.deviation[i] / um));
      if (time) out += ',' + to_shortest(run.time[i]);
      if (actual) append_vector(out, run.actual[i]);
      if (commanded) append_vector(out, run.commanded[i]);
      out += '\n';
    }
  }
  return out;
}

}  // namespace abbe
