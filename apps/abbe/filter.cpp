#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/report/json_writer.h"
#include "abbe/signal/align.h"
#include "abbe/signal/fit_figures.h"
#include "abbe/signal/sine_fit.h"
#include "column_output.h"
#include "common.h"
#include "csv.h"
#include "filter_steps.h"
#include "number_check.h"
#include "verbs.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

struct FilterArguments {
  std::string file, output, format, circle, angles, delay;
  std::vector<std::string> columns, steps;
  std::optional<double> dt;
  bool json = false, sine = false;
};

/// The chosen columns of a CSV file, with the times (t_s, or --dt).
std::optional<FilteredRecord> read_record(const FilterArguments& arguments, Session& session) {
  FileResult<CsvReader> opened = CsvReader::open(arguments.file);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, arguments.file);
    return std::nullopt;
  }
  auto& csv = std::get<CsvReader>(opened);
  std::vector<std::string> wanted;
  for (const std::string& list : arguments.columns) {
    for (const std::string& name : split_list(list)) wanted.push_back(name);
  }
  FilteredRecord record;
  std::vector<std::size_t> places;
  std::optional<std::size_t> time;
  for (std::size_t c = 0; c < csv.header().size(); ++c) {
    const std::string& name = csv.header()[c];
    if (name == "t_s") time = c;
    const bool chosen =
        wanted.empty() ? name != "t_s" : std::find(wanted.begin(), wanted.end(), name) != wanted.end();
    if (!chosen) continue;
    places.push_back(c);
    record.columns.push_back({name, {}, {}});
  }
  while (csv.next() && !interrupted()) {
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (const auto value = csv.number(places[i])) record.columns[i].samples.push_back(*value);
    }
    if (time && !arguments.dt) {
      if (const auto value = csv.number(*time)) record.times.push_back(*value);
    } else {
      record.times.push_back(static_cast<double>(record.times.size()) * arguments.dt.value_or(1));
    }
  }
  if (csv.failed()) {
    session.report(*csv.failure(), csv.broken() ? Exit::internal : Exit::invalid);
    return std::nullopt;
  }
  for (const std::string& name : wanted) {
    if (std::find(csv.header().begin(), csv.header().end(), name) != csv.header().end()) continue;
    const auto like = closest(name, csv.header());
    session.report(option_error("--columns", fmt::format("no column '{}'", name),
                                like ? fmt::format("did you mean {}?", *like) : std::string()));
    return std::nullopt;
  }
  if (!time && !arguments.dt) {
    session.report(
        signal_error(arguments.file, "no column t_s", "give the time between samples: --dt 0.001"));
    return std::nullopt;
  }
  if (record.columns.empty() || record.times.empty()) {
    session.report(signal_error(arguments.file, "no samples"));
    return std::nullopt;
  }
  record.spacing = equal_spacing(record.times);
  return record;
}

/// How far the filtered columns are from the measured ones, where they can be compared sample by sample.
std::vector<std::optional<FitFigures>> figures_of(const FilteredRecord& before, const FilteredRecord& after) {
  std::vector<std::optional<FitFigures>> figures;
  for (std::size_t c = 0; c < before.columns.size(); ++c) {
    figures.emplace_back();
    if (before.columns[c].name != after.columns[c].name) continue;  // a derivative is another quantity
    const auto result = fit_figures(before.columns[c].samples, after.columns[c].samples);
    if (const auto* f = std::get_if<FitFigures>(&result)) figures.back() = *f;
  }
  return figures;
}

std::string closing_members(const FilteredRecord& record,
                            const std::vector<std::optional<FitFigures>>& figures) {
  JsonWriter json;
  json.begin_object();
  json.key("figures").begin_array();
  for (std::size_t c = 0; c < record.columns.size(); ++c) {
    json.begin_object(Layout::one_line).member("column", record.columns[c].name);
    if (figures[c]) {
      json.member("sse", figures[c]->sse).member("rmse", figures[c]->rmse);
      if (figures[c]->r2) json.member("r2", *figures[c]->r2);
    }
    for (const Denoised& d : record.columns[c].denoised) {
      json.member("sigma", std::span<const double>(d.sigma))
          .member("threshold", std::span<const double>(d.threshold));
      json.key("kept").begin_array();
      for (const std::size_t kept : d.kept) json.value(static_cast<std::uint64_t>(kept));
      json.end();
    }
    json.end();
  }
  json.end();
  json.member("row_count", static_cast<std::uint64_t>(record.times.size())).member("complete", true).end();
  // The members only: they end an object that is open already.
  const std::string text = json.take();
  const std::size_t first = text.find('{') + 1, last = text.rfind('}');
  return "," + text.substr(first, last - first);
}

void write_record(const FilterArguments& arguments, const FilteredRecord& record, const std::string& closing,
                  Session& session) {
  ColumnHeader header;
  header.verb = "filter";
  header.source = arguments.file;
  header.time_base = "file";
  ColumnBlock block;
  block.time = record.times;
  for (const FilteredColumn& column : record.columns) {
    header.columns.push_back({column.name, ""});
    block.columns.emplace_back(column.samples);
  }
  const ColumnFormat format = column_format(arguments.json ? "json" : arguments.format, arguments.output);
  auto output = ColumnOutput::create(arguments.output, format, std::move(header), session);
  if (output && output->write(block)) static_cast<void>(output->finish(closing));
}

void report_sines(const FilterArguments& arguments, const FilteredRecord& record, Session& session) {
  JsonWriter json;
  if (arguments.json)
    json.begin_object().member("format", 1).member("verb", "filter").key("sines").begin_array();
  std::string text;
  for (const FilteredColumn& column : record.columns) {
    const auto result = fit_sine(record.times, column.samples);
    if (const auto* problem = std::get_if<SignalProblem>(&result)) {
      session.report(
          signal_error(arguments.file, fmt::format("{}: {}", column.name, abbe::to_string(*problem))));
      return;
    }
    const auto& fit = std::get<SineFit>(result);
    if (arguments.json) {
      const auto member = [&](const char* name, double value, double uncertainty) {
        json.member(name, value).member(std::string("u_") + name, uncertainty);
      };
      json.begin_object(Layout::one_line).member("column", column.name);
      member("amplitude", fit.sine.amplitude, fit.uncertainty.amplitude);
      member("omega_rad_per_s", fit.sine.omega, fit.uncertainty.omega);
      member("phase_rad", fit.sine.phase, fit.uncertainty.phase);
      member("offset", fit.sine.offset, fit.uncertainty.offset);
      json.member("sse", fit.sse).member("iterations", fit.iterations).end();
    }
    text += fmt::format(
        "{}: {:.9g} sin({:.9g} t {:+.9g}) {:+.9g}\n  standard uncertainties {:.2g}, {:.2g} rad/s, {:.2g} "
        "rad, {:.2g}; SSE "
        "{:.6g}\n",
        column.name, fit.sine.amplitude, fit.sine.omega, fit.sine.phase, fit.sine.offset,
        fit.uncertainty.amplitude, fit.uncertainty.omega, fit.uncertainty.phase, fit.uncertainty.offset,
        fit.sse);
  }
  if (arguments.json) json.end().member("complete", true).end();
  session.out.write(arguments.json ? json.take() : text);
}

const FilteredColumn* find_column(const FilteredRecord& record, const std::string& name, const char* option,
                                  Session& session) {
  for (const FilteredColumn& column : record.columns) {
    if (column.name == name) return &column;
  }
  session.report(option_error(option, fmt::format("no column '{}' after the steps", name)));
  return nullptr;
}

void report_delay(const FilterArguments& arguments, const FilteredRecord& record, Session& session) {
  const auto names = split_list(arguments.delay);
  if (names.size() != 2) {
    session.report(option_error("--delay", "two columns are needed", "--delay A,B"));
    return;
  }
  const FilteredColumn* a = find_column(record, names[0], "--delay", session);
  const FilteredColumn* b = find_column(record, names[1], "--delay", session);
  if (a == nullptr || b == nullptr) return;
  if (record.spacing == 0) {
    session.report(signal_error(arguments.file, "the times are not equally spaced",
                                "begin with --step resample=SECONDS"));
    return;
  }
  const auto result = find_delay(a->samples, b->samples);
  if (const auto* problem = std::get_if<SignalProblem>(&result)) {
    session.report(signal_error(arguments.file, std::string(abbe::to_string(*problem))));
    return;
  }
  const auto& delay = std::get<Delay>(result);
  const double seconds = delay.samples * record.spacing;
  if (arguments.json) {
    JsonWriter json;
    json.begin_object()
        .member("format", 1)
        .member("verb", "filter")
        .member("a", a->name)
        .member("b", b->name);
    json.member("delay_s", seconds)
        .member("delay_samples", delay.samples)
        .member("coefficient", delay.coefficient);
    json.member("complete", true).end();
    session.out.write(json.take());
  } else {
    session.out.write(fmt::format("{} is {:.9g} s ({:.4f} samples) behind {}; correlation {:.6f}\n", b->name,
                                  seconds, delay.samples, a->name, delay.coefficient));
  }
}

/// The record at the angles of another file: --circle names the columns of the position and the centre.
std::optional<FilteredRecord> at_angles(const FilterArguments& arguments, const FilteredRecord& record,
                                        Session& session) {
  const auto circle = split_list(arguments.circle);
  const auto cx = circle.size() == 4 ? read_number(circle[2]) : std::optional(0.0);
  const auto cy = circle.size() == 4 ? read_number(circle[3]) : std::optional(0.0);
  if ((circle.size() != 2 && circle.size() != 4) || !cx || !cy) {
    session.report(option_error("--circle", fmt::format("'{}' is not understood", arguments.circle),
                                "two columns and the centre in mm: --circle X_mm,Y_mm,0,0"));
    return std::nullopt;
  }
  const FilteredColumn* x = find_column(record, circle[0], "--circle", session);
  const FilteredColumn* y = find_column(record, circle[1], "--circle", session);
  FilterArguments other;
  other.file = arguments.angles;
  other.columns = {"angle_deg"};
  other.dt = 1;
  const auto wanted = x != nullptr && y != nullptr ? read_record(other, session) : std::nullopt;
  if (!wanted) return std::nullopt;
  Samples angles = wanted->columns.front().samples;
  for (double& angle : angles) angle *= deg;

  const auto fail = [&](SignalProblem problem) {
    session.report(signal_error(arguments.file, std::string(abbe::to_string(problem))));
    return std::nullopt;
  };
  const auto turned = unwrapped_angles(x->samples, y->samples, *cx, *cy);
  if (const auto* problem = std::get_if<SignalProblem>(&turned)) return fail(*problem);
  const auto aligned = align_by_angle(std::get<Samples>(turned), angles);
  if (const auto* problem = std::get_if<SignalProblem>(&aligned)) return fail(*problem);
  Samples numbers(record.times.size());
  std::iota(numbers.begin(), numbers.end(), 0.0);
  const Samples& index = std::get<AngleAlignment>(aligned).index;
  const auto pick = [&](const Samples& from) {
    return interpolate(numbers, from, index, Interpolation::cubic);
  };
  FilteredRecord out;
  const auto times = pick(record.times);
  if (const auto* problem = std::get_if<SignalProblem>(&times)) return fail(*problem);
  out.times = std::get<Samples>(times);
  out.columns.push_back({"angle_deg", wanted->columns.front().samples, {}});
  for (const FilteredColumn& column : record.columns) {
    const auto samples = pick(column.samples);
    if (const auto* problem = std::get_if<SignalProblem>(&samples)) return fail(*problem);
    out.columns.push_back({column.name, std::get<Samples>(samples), column.denoised});
  }
  return out;
}

void filter(const FilterArguments& arguments, Session& session) {
  Diagnostics diagnostics;
  std::vector<FilterStep> steps;
  for (const std::string& text : arguments.steps) {
    if (const auto step = read_step(text, diagnostics)) steps.push_back(*step);
  }
  if (arguments.circle.empty() != arguments.angles.empty())
    diagnostics.push_back(option_error("--angles", "--circle and --angles belong together"));
  for (const std::string* input : {&arguments.file, &arguments.angles}) {
    if (!arguments.output.empty() && same_file(arguments.output, *input))
      diagnostics.push_back(option_error("--output", fmt::format("'{}' is an input", arguments.output)));
  }
  session.report(diagnostics);
  if (has_errors(diagnostics)) return;
  const auto measured = read_record(arguments, session);
  if (!measured || interrupted()) return;
  FilteredRecord record = *measured;
  for (const FilterStep& step : steps) {
    if (const auto misfit = apply_step(step, arguments.file, record)) return session.report(*misfit);
  }
  if (arguments.sine) return report_sines(arguments, record, session);
  if (!arguments.delay.empty()) return report_delay(arguments, record, session);
  if (!arguments.circle.empty()) {
    const auto aligned = at_angles(arguments, record, session);
    if (aligned)
      write_record(arguments, *aligned,
                   fmt::format(",\"row_count\":{},\"complete\":true", aligned->times.size()), session);
    return;
  }
  write_record(arguments, record, closing_members(record, figures_of(*measured, record)), session);
}

}  // namespace

Verb filter_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("filter", "smooth, denoise, differentiate, align records of signals");
  auto arguments = std::make_shared<FilterArguments>();
  command->add_option("FILE", arguments->file, "CSV with a header, one row per sample; - is standard input")
      ->required();
  command
      ->add_option(
          "--step", arguments->steps,
          "smooth[=PASSES], savitzky-golay=WINDOW,ORDER[,DERIVATIVE], wavelet=sym5[,..], derivative, "
          "resample=SECONDS; repeatable, in order")
      ->allow_extra_args(false);
  command->add_option("--columns", arguments->columns, "only these")
      ->type_name("NAME,..")
      ->allow_extra_args(false);
  command->add_option("--dt", arguments->dt, "seconds between samples, in place of the column t_s")
      ->check(above_zero());
  Option* sine = command->add_flag("--sine", arguments->sine, "fit A sin(w t + phi) + c to each column");
  Option* delay =
      command->add_option("--delay", arguments->delay, "by how much the second column is behind the first")
          ->type_name("A,B")
          ->excludes(sine);
  command
      ->add_option("--circle", arguments->circle,
                   "columns of a position that goes round, and its centre in mm")
      ->type_name("X,Y[,CX,CY]")
      ->excludes(sine)
      ->excludes(delay);
  command->add_option("--angles", arguments->angles, "CSV with angle_deg: the rows at those angles")
      ->type_name("FILE");
  // What --sine and --delay find goes to standard output.
  command->add_option("-o,--output", arguments->output, "file instead of standard output")
      ->type_name("FILE")
      ->excludes(sine)
      ->excludes(delay);
  command
      ->add_option("--format", arguments->format,
                   "csv, json, binary (else by the ending: .csv .json .abbecol)")
      ->check(one_of({"csv", "json", "binary"}))
      ->excludes(sine)
      ->excludes(delay);
  command->add_flag("--json", arguments->json, "JSON, with figures");
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [arguments, &session] { filter(*arguments, session); }};
}

}  // namespace abbe::app
