#include "capture_summary.h"

#include <fmt/core.h>

#include "abbe/capture/decode.h"
#include "abbe/report/json_writer.h"

namespace abbe::app {
namespace {

using Layout = JsonWriter::Layout;

std::string_view state_name(int state) {
  switch (state) {
    case 1:
      return "INIT";
    case 2:
      return "PREOP";
    case 3:
      return "BOOT";
    case 4:
      return "SAFEOP";
    case 8:
      return "OP";
    default:
      return "?";
  }
}

std::string_view direction_name(PdoDirection direction) {
  return direction == PdoDirection::input ? "input" : "output";
}

std::string type_name(const PdoObject& object) {
  switch (object.type) {
    case PdoType::signed_integer:
      return fmt::format("int{}", object.bits);
    case PdoType::real:
      return fmt::format("real{}", object.bits);
    case PdoType::unsigned_integer:
      break;
  }
  return fmt::format("uint{}", object.bits);
}

double seconds(const CaptureSurvey& s) { return static_cast<double>(s.last_ns - s.first_ns) * 1e-9; }

std::string commands_text(const CaptureSurvey& s) {
  std::string text;
  for (std::size_t c = 0; c < s.commands.size(); ++c) {
    if (s.commands[c] > 0)
      text += fmt::format("  {} {}", to_string(static_cast<EcatCommand>(c)), s.commands[c]);
  }
  if (s.unknown_commands > 0) text += fmt::format("  unknown {}", s.unknown_commands);
  return text;
}

std::string process_text(const CaptureSurvey& s) {
  std::string text;
  for (const ProcessDatagram& p : s.process) {
    text += fmt::format("  {} at {:#x}, {} bytes: {} sent, {} returned, working counter",
                        to_string(p.command), p.address, p.length, p.sent, p.returned);
    for (const auto& [counter, frames] : p.counters) text += fmt::format(" {} ({} times)", counter, frames);
    text += '\n';
  }
  return text;
}

std::string map_text(const ProcessMap& map) {
  std::string text = fmt::format("signals ({}):\n", map.origin);
  for (const PdoObject& o : map.objects)
    text += fmt::format("  {:<32} {:<6} {:<6} at {:#x}.{}  {}\n", o.name, direction_name(o.direction),
                        type_name(o), o.bit / 8, o.bit % 8, o.unit.empty() ? "counts" : o.unit);
  return text;
}

void write_process(JsonWriter& json, const CaptureSurvey& s) {
  json.key("process_data").begin_array();
  for (const ProcessDatagram& p : s.process) {
    json.begin_object(Layout::one_line);
    json.member("command", to_string(p.command)).member("address", std::uint64_t{p.address});
    json.member("bytes", std::uint64_t{p.length}).member("sent", p.sent).member("returned", p.returned);
    json.member("expected_working_counter", static_cast<int>(p.expected()));
    json.key("working_counters").begin_object();
    for (const auto& [counter, frames] : p.counters) json.member(std::to_string(counter), frames);
    json.end().end();
  }
  json.end();
}

void write_map(JsonWriter& json, const ProcessMap& map) {
  json.member("map", map.origin);
  json.key("signals").begin_array();
  for (const PdoObject& o : map.objects) {
    json.begin_object(Layout::one_line);
    json.member("name", o.name).member("station", static_cast<int>(o.station));
    json.member("object", fmt::format("{:04X}:{:02X}", o.index, o.subindex))
        .member("pdo", fmt::format("{:04X}", o.pdo));
    json.member("direction", direction_name(o.direction)).member("type", type_name(o));
    json.member("address", o.bit / 8)
        .member("bit", o.bit % 8)
        .member("scale", o.scale)
        .member("unit", o.unit);
    json.end();
  }
  json.end();
}

}  // namespace

std::string summary_text(const CaptureSurvey& s, const ProcessMap& map) {
  std::string text = fmt::format("{} packets in {:.6f} s: {} EtherCAT, {} other\n", s.packets, seconds(s),
                                 s.ethercat, s.other + s.other_ethercat);
  text += fmt::format("bad frames {}, packets cut by the recorder {}, VLAN {}, UDP {}\n", s.bad, s.cut,
                      s.vlan, s.udp);
  for (const BadFrame& f : s.faults) text += fmt::format("  packet {}: {}\n", f.number, f.fault);
  if (s.esl > 0) {
    text += fmt::format("switch link: {} frames, {} with a time, {} with errors, ports", s.esl, s.esl_timed,
                        s.esl_errors);
    for (std::size_t port = 0; port < s.esl_ports.size(); ++port) {
      if (s.esl_ports[port] > 0) text += fmt::format(" {} ({})", port, s.esl_ports[port]);
    }
    text += '\n';
  }
  text += fmt::format("frames: {} on their way out, {} returning, {} of them with the one that went out\n",
                      s.sent, s.returned, s.paired);
  text += "datagrams:" + commands_text(s) + "\n";
  if (!s.process.empty()) text += "process data:\n" + process_text(s);
  if (s.cycle) text += fmt::format("cycle: {:.3f} us (median)\n", *s.cycle * 1e6);
  text += fmt::format("best clock: {}\n", to_string(best_time_base(s)));
  for (const auto& [station, state] : s.states)
    text += fmt::format("slave {}: {}\n", station, state_name(state));
  if (s.sdo_values > 0) text += fmt::format("mailbox: {} values, {} aborted\n", s.sdo_values, s.sdo_aborts);
  if (!map.objects.empty()) text += map_text(map);
  return text;
}

std::string summary_json(const CaptureSurvey& s, const ProcessMap& map) {
  JsonWriter json;
  json.begin_object();
  json.member("format", 1).member("verb", "capture");
  json.member("packets", s.packets)
      .member("seconds", seconds(s))
      .member("first_ns", std::to_string(s.first_ns));
  json.member("ethercat", s.ethercat).member("other", s.other).member("other_ethercat", s.other_ethercat);
  json.member("bad", s.bad).member("cut", s.cut).member("vlan", s.vlan).member("udp", s.udp);
  json.key("faults").begin_array();
  for (const BadFrame& f : s.faults)
    json.begin_object(Layout::one_line).member("packet", f.number).member("fault", f.fault).end();
  json.end();
  json.key("esl").begin_object(Layout::one_line);
  json.member("frames", s.esl).member("timed", s.esl_timed).member("errors", s.esl_errors).end();
  json.member("sent", s.sent).member("returned", s.returned).member("paired", s.paired);
  json.key("datagrams").begin_object();
  for (std::size_t c = 0; c < s.commands.size(); ++c)
    if (s.commands[c] > 0) json.member(to_string(static_cast<EcatCommand>(c)), s.commands[c]);
  json.end();
  write_process(json, s);
  if (s.cycle) json.member("cycle_s", *s.cycle);
  json.member("best_time_base", to_string(best_time_base(s)));
  json.key("slaves").begin_array();
  for (const auto& [station, state] : s.states)
    json.begin_object(Layout::one_line)
        .member("station", static_cast<int>(station))
        .member("state", state_name(state))
        .end();
  json.end();
  json.member("sdo_values", s.sdo_values).member("sdo_aborts", s.sdo_aborts);
  write_map(json, map);
  json.member("complete", !s.error && s.complete).end();
  return json.take();
}

}  // namespace abbe::app
