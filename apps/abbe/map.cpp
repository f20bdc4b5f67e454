#include "abbe/volume/map.h"

#include <fmt/core.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "abbe/core/file.h"
#include "abbe/report/volume_figure.h"
#include "common.h"
#include "map_report.h"
#include "map_uncertainty.h"
#include "map_volume.h"
#include "number_check.h"
#include "progress.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr std::size_t kRowsAtOnce = 512;

struct MapArguments {
  CommonArguments common;
  VolumeArguments volume;
  MapUncertaintyArguments uncertainty;
  std::string csv, svg;
  int most = 15;
};

/// False after reporting an output that would overwrite an input or the other output.
bool outputs_are_apart(const MapArguments& arguments, const Machine& machine, Session& session) {
  bool apart = true;
  const auto check = [&](const char* option, const std::string& path) {
    if (path.empty()) return;
    if (path == "-") {
      session.report(option_error(option, "standard output is taken by the report", "name a file"));
      apart = false;
    }
    std::vector<std::string> inputs = machine.files;
    if (!arguments.common.environment.empty()) inputs.push_back(arguments.common.environment);
    for (const std::string& input : inputs) {
      if (!same_file(path, input)) continue;
      session.report(option_error(option, fmt::format("'{}' is an input", path), "name another file"));
      apart = false;
    }
  };
  check("--csv", arguments.csv);
  check("--svg", arguments.svg);
  const bool same = arguments.csv == arguments.svg || same_file(arguments.csv, arguments.svg);
  if (apart && !arguments.csv.empty() && !arguments.svg.empty() && same) {
    session.report(option_error("--svg", "the same file as --csv", "name another file"));
    apart = false;
  }
  return apart;
}

bool write_csv(SpoolFile& file, const MapAnswer& answer) {
  std::string rows = csv_header(answer);
  const std::size_t points = answer.map.field.deviation.size();
  for (std::size_t i = 0; i < points; ++i) {
    append_csv_row(rows, answer, i);
    if (i % kRowsAtOnce != kRowsAtOnce - 1) continue;
    if (interrupted() || !file.write(rows)) return false;
    rows.clear();
  }
  return file.write(rows);
}

/// Both files are complete before the first of them appears.
bool write_files(const MapArguments& arguments, const MapAnswer& answer, Session& session) {
  std::vector<std::pair<SpoolFile, std::string>> files;
  for (const std::string& path : {arguments.csv, arguments.svg}) {
    if (path.empty()) continue;
    FileResult<SpoolFile> created = SpoolFile::create(path);
    if (const auto* error = std::get_if<FileError>(&created)) {
      session.report(*error, path);
      return false;
    }
    auto& [file, name] = files.emplace_back(std::move(std::get<SpoolFile>(created)), path);
    const bool written =
        path == arguments.csv
            ? write_csv(file, answer)
            : file.write(figure_of_volume(answer.setting.machine, answer.question, answer.map));
    if (interrupted()) return false;
    if (!written || !file.flush()) {
      session.report(file.error().value_or(FileError{"cannot be written"}), name);
      return false;
    }
  }
  for (auto& [file, name] : files) {
    if (file.publish()) continue;
    session.report(file.error().value_or(FileError{"cannot be written"}), name);
    return false;
  }
  return true;
}

void run_map(const MapArguments& arguments, Session& session) {
  const std::optional<Setting> setting = load_setting(arguments.common, session);
  if (!setting || !outputs_are_apart(arguments, setting->machine, session)) return;
  const std::optional<VolumeQuestion> question = read_volume(arguments.volume, *setting, session);
  if (!question) return;
  const std::optional<Plan> plan = plan_or_report(*setting, setting->environment, session);
  if (!plan) return;

  ProgressBar bar("map", true, "M poses");
  const VolumeMap map = map_volume(*plan, *question, bar.callback());
  if (map.status == VolumeMap::Status::stopped) return;
  if (map.status == VolumeMap::Status::overflow) {
    Diagnostic overflow = option_error("--range", "the numbers are too large to calculate with");
    overflow.code = "E-RANGE";
    session.report(overflow);
    return;
  }

  std::optional<VolumeUncertainty> uncertainty;
  if (arguments.uncertainty.wanted) {
    uncertainty =
        uncertainty_or_report(arguments.uncertainty, *setting, *question, arguments.common.errors, session);
    if (!uncertainty) return;
  }
  MapAnswer answer{*setting, *question, map, uncertainty ? &*uncertainty : nullptr};
  for (std::size_t i = 0; i < map.field.deviation.size(); ++i)
    if (setting->limits.pass(map.field.deviation[i].norm(), map.field.tilt[i])) ++answer.within;
  answer.pass = answer.within == map.field.deviation.size();
  if (!write_files(arguments, answer, session)) return;
  if (session.strict && setting->limits.given() && !answer.pass) session.note(Exit::warnings);
  session.out.write(arguments.common.json ? map_json(answer)
                                          : map_text(answer, static_cast<std::size_t>(arguments.most)));
}

}  // namespace

Verb map_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("map", "deviation over the work volume: figures, diagonals, error budget");
  auto arguments = std::make_shared<MapArguments>();
  add_common_options(*command, arguments->common, session);
  add_volume_options(*command, arguments->volume);
  add_uncertainty_options(*command, arguments->uncertainty);
  command->add_option("--csv", arguments->csv, "every point of the grid: CSV")->type_name("FILE");
  command->add_option("--svg", arguments->svg, "overview: slices, error budget, diagonals (SVG)")
      ->type_name("FILE");
  command->add_option("--most", arguments->most, "errors listed in the budget, 0 = all (15)")
      ->check(not_negative())
      ->type_name("N");
  return {command, [arguments, &session] { run_map(*arguments, session); }};
}

}  // namespace abbe::app
