#include "abbe/cl/emit_events.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <set>

#include "abbe/core/number.h"

namespace abbe::cl {
namespace {

/// Followed by the interpreter, or about the CAM system: no words.
const std::set<std::string_view> kSilent = {"UNITS",
                                            "UNIT",
                                            "MULTAX",
                                            "TRANS",
                                            "ORIGIN",
                                            "MSYS",
                                            "CSYS",
                                            "TRNTYP",
                                            "TLAXIS",
                                            "RAPID",
                                            "FEDRAT",
                                            "CYCLE",
                                            "CUTCOM",
                                            "CUTTER",
                                            "TLDATA",
                                            "TOOL PATH",
                                            "END-OF-PATH",
                                            "PAINT",
                                            "DISPLY",
                                            "TOOLNO",
                                            "SELECT",
                                            "SETUP",
                                            "SEQNO",
                                            "INTOL",
                                            "OUTTOL",
                                            "TOLER",
                                            "LINTOL",
                                            "MCHTOL",
                                            "MACHIN",
                                            "CSI_SET_FLUTE_LENGTH",
                                            "CSI_SET_EXTENSION_LENGTH",
                                            "LEADER",
                                            "CLEARP",
                                            "CHECK",
                                            "AIR",
                                            "PRINT",
                                            "LETTER",
                                            "TITLES"};
const std::set<std::string_view> kComments = {"PARTNO", "PPRINT", "REMARK", "TPRINT", "INSERT"};

std::string comment(std::string_view text) {
  constexpr std::size_t kLongest = 60;
  std::string plain;
  for (const char c : text.substr(0, kLongest))
    plain += std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                     std::string_view(" .,:=+-/").find(c) != std::string_view::npos
                 ? c
                 : ' ';
  const std::size_t first = plain.find_first_not_of(" /");
  return first == std::string::npos ? std::string() : fmt::format("({})\n", plain.substr(first));
}

std::optional<double> number_of(const Record& record) {
  const auto item =
      std::find_if(record.items.begin(), record.items.end(), [](const Item& i) { return i.is_number; });
  return item == record.items.end() ? std::nullopt : std::optional(item->value);
}

constexpr double kMostValue = 1e7;  // of a speed in 1/min or a time in s: more is a wrong number

bool can_be_meant(double value) { return value >= 0 && value <= kMostValue; }

/// Words have no exponent. Without zeros at the end.
std::string digits_of(double value) {
  std::string text;
  append_fixed(text, value, 4);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

bool says(const Record& record, std::initializer_list<std::string_view> words) {
  return std::any_of(record.items.begin(), record.items.end(), [&](const Item& item) {
    return std::find(words.begin(), words.end(), item.word) != words.end() && !item.is_number;
  });
}

bool only(const Record& record, const std::set<std::string_view>& words) {
  return std::all_of(record.items.begin(), record.items.end(),
                     [&](const Item& item) { return item.is_number || words.contains(item.word); });
}

std::string refused(const Record& record, Findings& findings) {
  findings.refuse(record, {"E-RECORD", fmt::format("{} has no word of a program", record.major),
                           "what the control shall do is not known",
                           "remove it, or post this file with its post-processor"});
  return {};
}

}  // namespace

std::string EventWriter::spindle(const Record& record, Findings& findings) {
  if (!only(record, {"RPM", "CLW", "CCLW", "ON", "OFF"})) return refused(record, findings);
  if (says(record, {"OFF"})) return "M5\n";
  if (says(record, {"CLW"})) turning_ = "M3";
  if (says(record, {"CCLW"})) turning_ = "M4";
  const auto speed = number_of(record);
  if (turning_.empty() || (!speed && !says(record, {"ON"})) || (speed && !can_be_meant(*speed))) {
    findings.refuse(record,
                    {"E-RECORD", "SPINDL without a sense, or without a speed that can be meant",
                     "a spindle that turns the wrong way breaks the tool", "write SPINDL/RPM,2000,CLW"});
    return {};
  }
  return speed ? fmt::format("S{} {}\n", digits_of(*speed), turning_) : turning_ + '\n';
}

std::string EventWriter::coolant(const Record& record, Findings& findings) {
  if (!only(record, {"ON", "OFF", "FLOOD", "MIST"})) return refused(record, findings);
  if (says(record, {"OFF"})) return "M9\n";
  return says(record, {"MIST"}) ? "M7\n" : "M8\n";
}

std::string EventWriter::words_of(const Record& record, Findings& findings) {
  const std::string_view major = record.major;
  if (kSilent.contains(major)) return {};
  if (kComments.contains(major)) return comment(record.text);
  if (major == "SPINDL") return spindle(record, findings);
  if (major == "COOLNT") return coolant(record, findings);
  if (major == "LOADTL" || major == "LOAD" || major == "TURRET")
    return fmt::format("T{} M6\n", static_cast<int>(number_of(record).value_or(0)));
  if (major == "STOP") return "M0\n";
  if (major == "OPSTOP") return "M1\n";
  if (major == "FINI" || major == "END") return major == "FINI" ? "M2\n" : "";
  if (major == "DELAY") {
    const auto seconds = number_of(record);
    if (seconds && can_be_meant(*seconds) && record.items.size() == 1)
      return fmt::format("G4 P{}\n", digits_of(*seconds));
  }
  return refused(record, findings);
}

}  // namespace abbe::cl
