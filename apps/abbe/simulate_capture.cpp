#include <fmt/core.h>

#include <memory>

#include "abbe/capture/write_capture.h"
#include "capture_source.h"
#include "column_output.h"
#include "csv.h"
#include "number_check.h"
#include "simulate.h"

namespace abbe::app {
namespace {

constexpr std::size_t kMostCells = std::size_t{1} << 27;

struct SimulateCaptureArguments {
  std::string signals, output, esl = "trailer";
  MapArguments map;
  double cycle_us = 1000;
  bool no_startup = false, no_forward = false, no_clock = false;
};

/// The columns of a CSV file, the time column left out.
struct SignalTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;
};

/// A column "X.position_actual_mm", as `capture` writes it, is the signal X.position_actual.
std::string signal_name(const std::string& column, const ProcessMap& map) {
  for (const PdoObject& o : map.objects) {
    if (ColumnName{o.name, o.unit}.label() == column) return o.name;
  }
  return column;
}

std::optional<SignalTable> read_signals(const std::string& path, const ProcessMap& map, Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, path);
    return std::nullopt;
  }
  auto& csv = std::get<CsvReader>(opened);
  SignalTable table;
  std::vector<std::size_t> columns;
  for (std::size_t c = 0; c < csv.header().size(); ++c) {
    if (csv.header()[c] == "t_s") continue;
    columns.push_back(c);
    table.names.push_back(signal_name(csv.header()[c], map));
  }
  table.values.resize(columns.size());
  while (csv.next() && !interrupted()) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (const auto value = csv.number(columns[i])) table.values[i].push_back(*value);
    }
    if (!table.values.empty() && table.values.front().size() * table.values.size() > kMostCells) {
      session.report(
          option_error("--signals", "more samples than fit into memory here", "write shorter captures"));
      return std::nullopt;
    }
  }
  if (csv.failed()) {
    session.report(*csv.failure(), csv.broken() ? Exit::internal : Exit::invalid);
    return std::nullopt;
  }
  return table;
}

CaptureSettings settings_of(const SimulateCaptureArguments& arguments) {
  CaptureSettings settings;
  settings.cycle = arguments.cycle_us * 1e-6;
  settings.esl = arguments.esl == "none"     ? EslPlace::none
                 : arguments.esl == "header" ? EslPlace::header
                                             : EslPlace::trailer;
  settings.startup = !arguments.no_startup;
  settings.forward = !arguments.no_forward;
  settings.clock = !arguments.no_clock;
  return settings;
}

void simulate_capture(const SimulateCaptureArguments& arguments, Session& session) {
  const auto given = load_map(arguments.map, session);
  if (!given) return;
  if (!given->layout && given->axes.empty()) {
    session.report(option_error("--axis", "neither axes nor a layout are given",
                                "name the axes, as in --axis X=1001:10000/mm, or give --map or --eni"));
    return;
  }
  const ProcessMap map = given->layout ? named(*given->layout, given->axes) : servo_map(given->axes);
  for (const std::string* input : {&arguments.signals, &arguments.map.map, &arguments.map.eni}) {
    if (!same_file(arguments.output, *input)) continue;
    session.report(
        option_error("--output", fmt::format("'{}' is an input", arguments.output), "name another file"));
    return;
  }
  const auto table = read_signals(arguments.signals, map, session);
  if (!table || interrupted()) return;
  std::vector<CaptureColumn> columns;
  for (std::size_t i = 0; i < table->names.size(); ++i)
    columns.push_back({table->names[i], table->values[i]});
  FileResult<SpoolFile> created = SpoolFile::create(arguments.output);
  if (const auto* error = std::get_if<FileError>(&created)) {
    session.report(*error, arguments.output);
    return;
  }
  auto& out = std::get<SpoolFile>(created);
  if (const auto misfit = write_capture(map, columns, settings_of(arguments), out)) {
    session.report(*misfit, misfit->code == "E-FILE" ? Exit::internal : Exit::invalid);
    return;
  }
  if (!out.publish()) session.report(*out.error(), arguments.output);
}

}  // namespace

Verb simulate_capture_verb(Command& simulate, Session& session) {
  Command* command = simulate.add_subcommand("capture", "an EtherCAT capture that carries given signals");
  auto arguments = std::make_shared<SimulateCaptureArguments>();
  command
      ->add_option("--signals", arguments->signals,
                   "CSV: one column per signal, one row per cycle; t_s is not used")
      ->required()
      ->type_name("FILE");
  command->add_option("-o,--output", arguments->output, "the capture (pcap)")->required()->type_name("FILE");
  add_map_options(*command, arguments->map);
  command->add_option("--cycle-us", arguments->cycle_us, "time between cycles (1000)")
      ->check(number_in(1.0, 1e6));
  command->add_option("--esl", arguments->esl, "where the switch link's time is: trailer, header, none")
      ->check(one_of({"trailer", "header", "none"}));
  command->add_flag("--no-startup", arguments->no_startup, "without the traffic that tells the map");
  command->add_flag("--no-forward", arguments->no_forward, "returning frames only");
  command->add_flag("--no-clock", arguments->no_clock, "without readings of the reference clock");
  return {command, [arguments, &session] { simulate_capture(*arguments, session); }};
}

}  // namespace abbe::app
