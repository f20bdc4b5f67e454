#include <fmt/format.h>

#include <iterator>
#include <memory>
#include <set>

#include "abbe/capture/bus_reader.h"
#include "abbe/capture/decode.h"
#include "capture_source.h"
#include "capture_summary.h"
#include "column_output.h"
#include "common.h"
#include "progress.h"
#include "verbs.h"

namespace abbe::app {
namespace {

constexpr std::size_t kWriteAt = std::size_t{1} << 16;

struct CaptureArguments {
  std::string file, output, format, time;
  std::vector<std::string> columns;
  MapArguments map;
  bool summary = false, json = false, datagrams = false, keep_short = false;
};

Diagnostic finding(Severity severity, const char* code, const std::string& file, std::string message,
                   std::string why = {}, std::string fix = {}) {
  Diagnostic d;
  d.severity = severity;
  d.code = code;
  d.place.file = file;
  d.message = std::move(message);
  d.why = std::move(why);
  d.fix = std::move(fix);
  return d;
}

std::string listed(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 8;
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kMost; ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kMost ? fmt::format("{} and {} more", text, names.size() - kMost) : text;
}

// Every datagram as a line, as the recording has it: for comparison with other programs.

void append_datagram(std::string& text, const BusFrame& frame, std::size_t place, const Datagram& d) {
  const auto out = std::back_inserter(text);
  const auto& esl = frame.ethernet.esl;
  fmt::format_to(out, "{},{},{}.{:09},{},{},", frame.number, place, frame.packet.time_ns / 1'000'000'000,
                 frame.packet.time_ns % 1'000'000'000, frame.returning ? "back" : "out", frame.partner);
  if (esl) fmt::format_to(out, "{},{}", esl->port, esl->timestamp_ns);
  if (!esl) text += ',';
  fmt::format_to(out, ",{},{},", static_cast<int>(d.command), d.index);
  if (d.logical()) {
    fmt::format_to(out, ",,{}", d.address);
  } else {
    fmt::format_to(out, "{},{},", d.station(), d.offset());
  }
  fmt::format_to(out, ",{},{},", d.data.size(), d.working_counter);
  for (const std::uint8_t byte : d.data) fmt::format_to(out, "{:02x}", byte);
  text += '\n';
}

void list_datagrams(const CaptureArguments& arguments, Session& session) {
  FileResult<BusReader> opened = BusReader::open(arguments.file);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    session.report(*error, arguments.file);
    return;
  }
  auto& reader = std::get<BusReader>(opened);
  std::string text =
      "packet,datagram,time_s,way,partner,esl_port,esl_ns,command,index,adp,ado,lad,bytes,wkc,data\n";
  for (BusFrame frame; !interrupted() && session.out.ok() && reader.next(frame);) {
    std::size_t place = 0;
    for (const Datagram& d : frame.datagrams) append_datagram(text, frame, ++place, d);
    if (text.size() < kWriteAt) continue;
    session.out.write(text);
    text.clear();
  }
  session.out.write(text);
  if (reader.error())
    session.report(finding(Severity::warning, "W-CAPTURE-END", arguments.file, *reader.error()));
}

// What a survey says that the user has to know.

void report_survey(const CaptureSurvey& survey, const std::string& file, Session& session) {
  if (survey.error)
    session.report(finding(Severity::warning, "W-CAPTURE-END", file, *survey.error,
                           "what was recorded behind it is not seen", "record again if it is needed"));
  if (survey.bad > 0) {
    std::string first;
    if (!survey.faults.empty())
      first = fmt::format("; the first is packet {}: {}", survey.faults.front().number,
                          survey.faults.front().fault);
    session.report(finding(
        Severity::warning, "W-CAPTURE-BAD", file,
        fmt::format("{} EtherCAT frames are damaged{}", survey.bad, first), "their process data is not used",
        survey.cut > 0 ? "the recorder cut packets: record with a snap length of 65535" : ""));
  }
}

/// False after reporting why no rows can be made.
bool can_decode(const CaptureSurvey& survey, const std::string& file, Session& session) {
  if (survey.ethercat == 0) {
    session.report(finding(Severity::error, "E-CAPTURE-EMPTY", file, "no EtherCAT frame in this capture",
                           "there is nothing to decode", "record at the port of the EtherCAT master"));
    return false;
  }
  if (survey.process_returned == 0) {
    session.report(finding(Severity::error, "E-CAPTURE-RETURN", file,
                           survey.process.empty() ? "no process data (LRD, LWR, LRW) in this capture"
                                                  : "no returning frame with process data in this capture",
                           "what the drives say is in frames that come back from them",
                           "record while the machine moves, at a place that both ways pass"));
    return false;
  }
  return true;
}

std::optional<TimeBase> choose_time(const CaptureArguments& arguments, const CaptureSurvey& survey,
                                    Session& session) {
  if (arguments.time.empty()) return best_time_base(survey);
  TimeBase base = TimeBase::recorder;
  bool there = true;
  if (arguments.time == "esl") {
    base = TimeBase::esl;
    there = survey.esl_timed > 0;
  } else if (arguments.time == "clock") {
    base = TimeBase::clock;
    there = survey.clock_returned > 0;
  }
  if (there) return base;
  session.report(finding(Severity::error, "E-CAPTURE-TIME", arguments.file,
                         fmt::format("no frame carries the clock '{}'", arguments.time), "",
                         fmt::format("--time {} is there", to_string(best_time_base(survey)))));
  return std::nullopt;
}

std::optional<DecodePlan> choose_columns(const CaptureArguments& arguments, const ProcessMap& map,
                                         const CaptureSurvey& survey, Session& session) {
  DecodePlan plan = plan_columns(map, survey);
  if (!plan.hidden.empty())
    session.report(finding(Severity::warning, "W-CAPTURE-MAP", arguments.file,
                           fmt::format("outputs left out: {}", listed(plan.hidden)),
                           "inputs lie at the same addresses, and no frame on its way out is recorded"));
  std::vector<PdoObject> chosen;
  for (const std::string& list : arguments.columns) {
    for (const std::string& name : split_list(list)) {
      std::vector<std::string> known;
      for (const PdoObject& o : plan.columns) {
        known.push_back(o.name);
        if (o.name == name) chosen.push_back(o);
      }
      if (!chosen.empty() && chosen.back().name == name) continue;
      const auto like = closest(name, known);
      session.report(option_error("--columns", fmt::format("this capture carries no '{}'", name),
                                  like ? fmt::format("did you mean {}?", *like) : "see --summary"));
    }
  }
  if (session.has(Exit::invalid)) return std::nullopt;
  if (!arguments.columns.empty()) plan.columns = std::move(chosen);
  if (plan.columns.empty()) {
    session.report(finding(
        Severity::error, "E-CAPTURE-MAP", arguments.file,
        fmt::format("no frame carries the signals of the map ({}): {}", map.origin, listed(plan.missing)),
        "map and capture are of different configurations, or the slaves never ran",
        "compare addresses with --summary"));
    return std::nullopt;
  }
  if (!plan.missing.empty())
    session.report(finding(Severity::warning, "W-CAPTURE-MAP", arguments.file,
                           fmt::format("not in this capture: {}", listed(plan.missing))));
  return plan;
}

/// An axis whose drive has no signal is a mistyped station: its columns would have other names.
void report_axes(const std::vector<ServoAxis>& axes, const ProcessMap& map, const std::string& file,
                 Session& session) {
  std::set<std::uint16_t> stations;
  for (const PdoObject& o : map.objects) stations.insert(o.station);
  std::vector<std::string> known;
  for (const std::uint16_t station : stations) known.push_back(fmt::format("{}", station));
  for (const ServoAxis& axis : axes) {
    if (stations.count(axis.station) != 0) continue;
    session.report(finding(
        Severity::warning, "W-CAPTURE-MAP", file,
        fmt::format("axis {}: no signal of a drive {} in the map ({})", axis.name, axis.station, map.origin),
        fmt::format("no column is named or scaled for {}", axis.name),
        fmt::format("slaves with signals: {}", listed(known))));
  }
}

std::string report_json(const DecodeReport& r, const CaptureSurvey& survey, bool complete) {
  std::string text = fmt::format(
      ",\n\"row_count\":{},\"dropped\":{{\"short\":{},\"incomplete\":{},\"untimed\":{}}},\"bad_frames\":{},"
      "\"backward\":{},\"first_ns\":\"{}\",\"cycle_s\":{},\"gap_count\":{},\"gaps\":[",
      r.rows, r.short_rows, r.incomplete_rows, r.untimed_rows, r.bad_frames, r.backward, r.first_ns,
      survey.cycle ? fmt::format("{}", *survey.cycle) : "null", r.gap_count);
  for (std::size_t i = 0; i < r.gaps.size(); ++i)
    text += fmt::format("{}{{\"row\":{},\"t_s\":{},\"length_s\":{}}}", i == 0 ? "" : ",", r.gaps[i].row,
                        r.gaps[i].time, r.gaps[i].length);
  return text + fmt::format("],\"complete\":{}", complete);
}

void report_rows(const DecodeReport& r, const CaptureArguments& arguments,
                 const std::vector<std::string>& constant, Session& session) {
  const auto warn = [&](const char* code, std::string message, const char* why, const char* fix = "") {
    session.report(finding(Severity::warning, code, arguments.file, std::move(message), why, fix));
  };
  if (r.short_rows > 0)
    warn("W-CAPTURE-SHORT",
         fmt::format("in {} cycles a slave did not take part{}", r.short_rows,
                     arguments.keep_short ? "" : "; they are left out"),
         "its signals are old or zero then", arguments.keep_short ? "" : "--keep-short keeps them");
  if (r.incomplete_rows + r.untimed_rows > 0)
    warn("W-CAPTURE-SHORT",
         fmt::format("{} cycles left out because a frame of them is missing, {} because they have no time",
                     r.incomplete_rows, r.untimed_rows),
         "a row needs all its signals of one moment",
         r.rows == 0 ? "choose signals that go together with --columns; see --summary" : "");
  if (r.gap_count > 0) {
    const Gap& g = r.gaps.front();
    warn("W-CAPTURE-GAP",
         fmt::format(
             "{} gaps of more than 1.5 cycles; the first is {:.6f} s long before t = {:.6f} s (row {})",
             r.gap_count, g.length, g.time, g.row + 1),
         "filters and derivatives across a gap are wrong",
         "cut the record there, or resample it by its times");
  }
  if (r.backward > 0)
    warn("W-CAPTURE-GAP", fmt::format("{} rows whose time does not rise", r.backward),
         "the clock is not steady", "choose another one with --time");
  if (!constant.empty())
    warn("W-CAPTURE-CONSTANT", fmt::format("never changing: {}", listed(constant)),
         "either nothing moved, or the map is of another configuration");
}

void decode(const CaptureArguments& arguments, const DecodePlan& plan, const CaptureSurvey& survey,
            TimeBase base, Session& session) {
  ColumnHeader header;
  header.verb = "capture";
  header.source = arguments.file;
  header.time_base = to_string(base);
  for (const PdoObject& o : plan.columns) header.columns.push_back({o.name, o.unit});
  const ColumnFormat format = column_format(arguments.json ? "json" : arguments.format, arguments.output);
  auto output = ColumnOutput::create(arguments.output, format, std::move(header), session);
  if (!output) return;
  DecodeOptions options;
  options.base = base;
  options.keep_short = arguments.keep_short;
  ProgressBar bar("capture", !arguments.output.empty());
  const auto decoded = decode_capture(
      arguments.file, plan, survey, options, [&](const ColumnBlock& block) { return output->write(block); },
      bar.callback());
  if (const auto* error = std::get_if<FileError>(&decoded)) {
    session.report(*error, arguments.file);
    return;
  }
  const auto& report = std::get<DecodeReport>(decoded);
  report_rows(report, arguments, output->constant_columns(), session);
  if (report.stopped || interrupted()) return;
  static_cast<void>(output->finish(report_json(report, survey, !report.error)));
}

void capture(const CaptureArguments& arguments, Session& session) {
  if (arguments.datagrams) return list_datagrams(arguments, session);
  if (!arguments.output.empty() && same_file(arguments.output, arguments.file)) {
    session.report(option_error("--output", "the capture itself is named", "name another file"));
    return;
  }
  const auto given = load_map(arguments.map, session);
  if (!given) return;
  FileResult<CaptureSurvey> surveyed = survey_capture(arguments.file, 0, ProgressBar("survey").callback());
  if (const auto* error = std::get_if<FileError>(&surveyed)) {
    session.report(*error, arguments.file);
    return;
  }
  const auto& survey = std::get<CaptureSurvey>(surveyed);
  if (interrupted()) return;
  report_survey(survey, arguments.file, session);
  if (arguments.summary) {
    Diagnostics ignored;
    const ProcessMap map = named(given->layout ? *given->layout : learned_map(survey, ignored), given->axes);
    session.out.write(arguments.json ? summary_json(survey, map) : summary_text(survey, map));
    return;
  }
  if (!can_decode(survey, arguments.file, session)) return;
  const auto map = map_for(*given, survey, arguments.file, session);
  if (!map) return;
  report_axes(given->axes, *map, arguments.file, session);
  const auto plan = choose_columns(arguments, *map, survey, session);
  const auto base = choose_time(arguments, survey, session);
  if (plan && base) decode(arguments, *plan, survey, *base, session);
}

}  // namespace

Verb capture_verb(Command& program, Session& session) {
  Command* command =
      program.add_subcommand("capture", "signals of drives from an EtherCAT capture (pcap, pcapng)");
  auto arguments = std::make_shared<CaptureArguments>();
  command->add_option("FILE", arguments->file, "capture, as Wireshark or tcpdump record it")->required();
  add_map_options(*command, arguments->map);
  // What these two print is all of it, and goes to standard output.
  Option* summary = command->add_flag("--summary", arguments->summary, "what is in the capture, no signals");
  Option* datagrams =
      command->add_flag("--datagrams", arguments->datagrams, "every datagram as a line of CSV")
          ->excludes(summary);
  command->add_option("--columns", arguments->columns, "only these signals")
      ->type_name("NAME,..")
      ->allow_extra_args(false)
      ->excludes(summary)
      ->excludes(datagrams);
  command
      ->add_option("--time", arguments->time, "whose clock: recorder, esl (switch link), clock (of the bus)")
      ->check(one_of({"recorder", "esl", "clock"}));
  command->add_flag("--keep-short", arguments->keep_short, "keep cycles in which a slave did not take part");
  command->add_option("-o,--output", arguments->output, "file instead of standard output")
      ->type_name("FILE")
      ->excludes(summary)
      ->excludes(datagrams);
  command
      ->add_option("--format", arguments->format,
                   "csv, json, binary (else by the ending: .csv .json .abbecol)")
      ->check(one_of({"csv", "json", "binary"}))
      ->excludes(summary)
      ->excludes(datagrams);
  command->add_flag("--json", arguments->json, "JSON on standard output")->excludes(datagrams);
  command->add_flag("--strict", session.strict, "warnings end with exit code 4");
  return {command, [arguments, &session] { capture(*arguments, session); }};
}

}  // namespace abbe::app
