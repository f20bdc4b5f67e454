#include "point_source.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>
#include <variant>

namespace abbe::app {

void add_point_options(Command& verb, PointArguments& arguments) {
  Option* at = verb.add_option("--at", arguments.at, "axis positions: X=1,A=30; axes not named stand at 0")
                   ->type_name("AXIS=VALUE,..")
                   ->allow_extra_args(false);
  verb.add_option("--points", arguments.points,
                  "CSV with a header: a column for every moving axis, optionally sensors, v.X, a.X, X.dir")
      ->type_name("FILE")
      ->excludes(at);
}

PointSource::PointSource(const Setting& setting)
    : setting_(&setting), environment_(setting.environment), approach_(setting.approach) {}

std::optional<PointSource> PointSource::open(const PointArguments& arguments, const Setting& setting,
                                             Session& session) {
  PointSource source(setting);
  if (arguments.at.empty() && arguments.points.empty()) {
    session.report(option_error("--at", "no point is given", "give --at X=..,Y=.. or --points FILE"));
    return std::nullopt;
  }
  if (!arguments.points.empty()) {
    source.file_ = arguments.points == "-" ? "<stdin>" : arguments.points;
    FileResult<CsvReader> csv = CsvReader::open(arguments.points);
    if (const auto* error = std::get_if<FileError>(&csv)) {
      session.report(*error, arguments.points);
      return std::nullopt;
    }
    source.csv_.emplace(std::move(std::get<CsvReader>(csv)));
    if (source.csv_->failed()) {
      session.report(*source.csv_->failure(), source.csv_->broken() ? Exit::internal : Exit::invalid);
      return std::nullopt;
    }
    if (!source.use_columns(source.csv_->header(), session)) return std::nullopt;
    return source;
  }

  Diagnostics diagnostics;
  const Machine& machine = setting.machine;
  for (const Assignment& given : split_assignments("--at", arguments.at, diagnostics)) {
    const NameMeaning meaning = meaning_of(machine, given.name);
    if (meaning.kind == NameMeaning::Kind::unknown) {
      std::string axes;
      for (int i = 0; i < machine.axis_count(); ++i) axes += (i == 0 ? "" : " ") + machine.axis(i).name;
      const std::string like = suggestion(machine, given.name);
      diagnostics.push_back(option_error("--at", fmt::format("this machine has no '{}'", given.name),
                                         like.empty() ? "its moving axes are " + axes : like));
    } else if (meaning.kind == NameMeaning::Kind::approach) {
      const std::optional<signed char> direction = read_approach(given.text);
      if (direction) {
        source.approach_[static_cast<std::size_t>(meaning.axis)] = *direction;
      } else {
        diagnostics.push_back(
            option_error("--at", fmt::format("{}={} is not one of + - 0", given.name, given.text)));
      }
    } else if (setting.environment.contains(given.name)) {
      diagnostics.push_back(
          option_error("--at", fmt::format("'{}' is also given with --set or --environment", given.name),
                       "leave out one of the two"));
    } else if (const auto value = option_number("--at", given.name, given.text, diagnostics)) {
      source.put(meaning, given.name, *value);
    }
  }
  session.report(diagnostics);
  if (has_errors(diagnostics) || !source.remake_plan(session)) return std::nullopt;
  return source;
}

bool PointSource::use_columns(const std::vector<std::string>& header, Session& session) {
  const Machine& machine = setting_->machine;
  std::vector<bool> present(static_cast<std::size_t>(machine.axis_count()), false);
  bool valid = true;
  for (std::size_t i = 0; i < header.size(); ++i) {
    const NameMeaning meaning = meaning_of(machine, header[i]);
    if (meaning.kind == NameMeaning::Kind::unknown) {
      Diagnostic ignored = csv_->error_at(i, "W-COLUMN", fmt::format("column '{}' is ignored", header[i]));
      ignored.severity = Severity::warning;
      ignored.why = "it is neither an axis nor a variable of this machine";
      ignored.fix = suggestion(machine, header[i]);
      session.report(ignored);
      continue;
    }
    if (meaning.kind == NameMeaning::Kind::position) present[static_cast<std::size_t>(meaning.axis)] = true;
    if (setting_->environment.contains(header[i])) {
      Diagnostic twice =
          csv_->error_at(i, "E-COLUMN", fmt::format("'{}' is also given on the command line", header[i]));
      twice.fix = "leave out one of the two";
      session.report(twice);
      valid = false;
    }
    columns_.push_back({i, meaning, header[i]});
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (present[static_cast<std::size_t>(i)]) continue;
    Diagnostic missing =
        csv_->error_at_line("E-COLUMN", fmt::format("no column for the axis '{}'", machine.axis(i).name));
    missing.fix = fmt::format("add a column '{}'; 0 where the axis stands at its zero", machine.axis(i).name);
    session.report(missing);
    valid = false;
  }
  if (!valid) return false;
  // Sensors that come with the rows count as given; their values are put in row by row.
  for (const Column& column : columns_) {
    if (column.meaning.kind == NameMeaning::Kind::sensor) environment_.insert_or_assign(column.name, 0.0);
  }
  return remake_plan(session);
}

void PointSource::put(const NameMeaning& meaning, const std::string& name, double value) {
  using Kind = NameMeaning::Kind;
  const auto axis = static_cast<std::size_t>(std::max(meaning.axis, 0));
  if (meaning.kind == Kind::position) {
    q_[axis] = value * setting_->machine.axis_unit(meaning.axis);
  } else if (meaning.kind == Kind::sensor) {
    const auto [entry, is_new] = environment_.try_emplace(name, value);
    if (!is_new && entry->second == value) return;
    entry->second = value;
    plan_is_old_ = true;
  } else if (meaning.kind == Kind::velocity || meaning.kind == Kind::acceleration) {
    if (!has_rates_) {
      // Rates given for some axes per point: the others keep those of --set, or 0.
      has_rates_ = true;
      for (int i = 0; i < setting_->machine.axis_count(); ++i) {
        const auto held = [&](const char* prefix) {
          const auto found = setting_->environment.find(prefix + setting_->machine.axis(i).name);
          return found == setting_->environment.end() ? 0.0 : found->second;
        };
        velocity_.push_back(held("v."));
        acceleration_.push_back(held("a."));
      }
    }
    (meaning.kind == Kind::velocity ? velocity_ : acceleration_)[axis] = value;
  }
}

bool PointSource::remake_plan(Session& session) {
  std::optional<Plan> plan = plan_or_report(*setting_, environment_, session);
  if (!plan) return false;
  plan_ = std::move(plan);
  plan_is_old_ = false;
  return true;
}

bool PointSource::take_row(Session& session) {
  for (const Column& column : columns_) {
    if (column.meaning.kind == NameMeaning::Kind::approach) {
      const std::optional<signed char> direction = read_approach(csv_->text(column.index));
      if (!direction) {
        csv_->fail_at(column.index, "E-CELL", fmt::format("not a direction in column '{}'", column.name),
                      "write + for increasing, - for decreasing, 0 for unknown");
        return false;
      }
      approach_[static_cast<std::size_t>(column.meaning.axis)] = *direction;
      continue;
    }
    const std::optional<double> value = csv_->number(column.index);
    if (!value) return false;
    put(column.meaning, column.name, *value);
  }
  return !plan_is_old_ || remake_plan(session);
}

bool PointSource::next(Session& session) {
  if (!csv_) return !std::exchange(done_, true);
  if (csv_->next() && take_row(session)) return true;
  if (csv_->failed()) session.report(*csv_->failure(), csv_->broken() ? Exit::internal : Exit::invalid);
  return false;
}

Query PointSource::query() const {
  Query query;
  query.q = q_;
  query.approach = approach_;
  query.tool = tool_of(setting_->machine);
  query.velocity = velocity_;
  query.acceleration = acceleration_;
  return query;
}

std::string PointSource::where() const { return csv_ ? fmt::format("{}:{}", file_, csv_->line()) : "--at"; }

}  // namespace abbe::app
