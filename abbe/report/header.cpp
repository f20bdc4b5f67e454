#include "abbe/report/header.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>

#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr std::string_view kMark = "(ABBE COMPENSATED - DO NOT EDIT - DO NOT RE-COMPENSATE)";
constexpr std::size_t kLongest = 60;
constexpr std::size_t kHashDigits = 12;

/// Text as every control shows it: capitals, other characters become blanks or minus signs.
std::string plain(std::string_view text) {
  static constexpr std::string_view kAllowed = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.,:/+-= ";
  std::string result;
  for (const char c : text) {
    const char upper = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
    if (kAllowed.find(upper) != std::string_view::npos) {
      result += upper;
    } else if (static_cast<unsigned char>(c) < 0x80) {
      result += c == '_' ? '-' : ' ';
    } else if (result.empty() || result.back() != '-') {
      result += '-';  // one for the bytes of a letter that is not ASCII
    }
  }
  return result;
}

/// Adds comments that hold `text`, broken between words; words too long for a line are cut.
void add_comment(std::vector<std::string>& lines, std::string_view text) {
  constexpr std::string_view kStart = "(ABBE";
  std::string line(kStart);
  std::size_t at = 0;
  const std::string words = plain(text);
  while (at < words.size()) {
    const std::size_t start = words.find_first_not_of(' ', at);
    if (start == std::string::npos) break;
    const std::size_t blank = words.find(' ', start);
    std::string word = words.substr(start, blank == std::string::npos ? blank : blank - start);
    at = blank == std::string::npos ? words.size() : blank;
    word.resize(std::min(word.size(), kLongest - kStart.size() - 2));
    if (line.size() + 1 + word.size() + 1 > kLongest) {
      lines.push_back(line + ')');
      line = kStart;
    }
    line += ' ' + word;
  }
  if (line.size() > kStart.size()) lines.push_back(line + ')');
}

std::string name_of_file(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == std::string::npos ? path : path.substr(slash + 1);
}

}  // namespace

std::vector<std::string> header_lines(const ProgramReport& report) {
  const Machine& machine = *report.machine;
  const Calibration& calibration = machine.calibration;
  std::vector<std::string> lines = {std::string(kMark)};

  std::string source = fmt::format("{} SRC {}", report.program_version, name_of_file(report.input_name));
  const bool rewritten = report.rewrite != nullptr;
  if (rewritten && report.rewrite->lines_in > 0) {
    source += fmt::format(" LINES {} SHA256 {}", report.rewrite->lines_in,
                          report.rewrite->sha256_in.substr(0, kHashDigits));
  }
  add_comment(lines, source);
  add_comment(lines, fmt::format("MACHINE {} {}{} SHA256 {}", machine.name,
                                 calibration.machine_id.empty() ? "" : "ID ", calibration.machine_id,
                                 machine.sha256.substr(0, kHashDigits)));
  if (!calibration.date.empty() || !calibration.valid_to.empty()) {
    add_comment(lines, fmt::format("CALIBRATED {} {}{}", calibration.date,
                                   calibration.valid_to.empty() ? "" : "VALID TO ", calibration.valid_to));
  }
  if (!calibration.control_compensation.empty()) {
    add_comment(lines, fmt::format("CONTROL AS CALIBRATED: {}", calibration.control_compensation));
  }
  for (std::size_t i = 0; i < report.setup.work_offsets.size(); ++i) {
    if (!report.setup.work_offsets[i]) continue;
    const WorkOffset& offset = *report.setup.work_offsets[i];
    std::string text = fmt::format("{} X{:.3f} Y{:.3f} Z{:.3f}", work_offset_name(i), offset.origin[0],
                                   offset.origin[1], offset.origin[2]);
    if (offset.rotation != 0) text += fmt::format(" R{:.4f}", offset.rotation / deg);
    add_comment(lines, text);
  }
  // Only lengths that somebody stated: the others are the machine file's, which the hash names.
  for (const auto& [number, gauge] : report.setup.gauges)
    add_comment(lines, fmt::format("T{} GAUGE {:.3f} MM", number, gauge));
  for (const auto& [number, tool] : report.setup.tools) {
    if (report.setup.gauges.contains(number)) continue;
    add_comment(lines, fmt::format("T{} GAUGE {:.3f} MM", number,
                                   gauge_length(report.setup, machine, number).length));
  }
  for (const auto& [name, value] : report.environment)
    add_comment(lines, fmt::format("{} = {:.6g}", name, value));
  std::string terms =
      fmt::format("DATUM {} TOLERANCE {:g} UM", report.datum == DatumRule::probed ? "PROBED" : "IDEAL",
                  report.tolerance / um);
  if (calibration.temperature) terms = fmt::format("TEMP {:.1f} C {}", *calibration.temperature, terms);
  add_comment(lines, terms);
  if (!profile_of(report.setup)->text.parentheses) {
    for (std::string& line : lines) line = ';' + line.substr(1, line.size() - 2);
  }
  return lines;
}

}  // namespace abbe
