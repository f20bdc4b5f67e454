#include "abbe/cl/interpreter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "abbe/cl/words.h"
#include "abbe/core/units.h"

namespace abbe::cl {
namespace {

constexpr double kMaxTool = 1e6;

bool one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// "G0", "G 53": text that would be a code once it stands in the program.
bool looks_like_code(std::string_view text) {
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    const bool word_begins = i == 0 || !std::isalnum(static_cast<unsigned char>(text[i - 1]));
    if (word_begins && (text[i] == 'G' || text[i] == 'g') && text[i + 1] >= '0' && text[i + 1] <= '9')
      return true;
  }
  return false;
}

}  // namespace

Interpreter::Interpreter(const Conventions& conventions, std::optional<int> loaded_tool)
    : conventions_(conventions), tool_(loaded_tool) {
  if (conventions.unit) {
    frame_.unit = *conventions.unit;
    unit_known_ = true;
  }
}

Interpreter::Outcome Interpreter::take(const Record& record, Findings& findings) {
  if (ended_) return Outcome::copied;
  if (record.is_remark()) return remark(record, findings) ? Outcome::copied : Outcome::refused;
  const auto rule = rule_of(record.major);
  const bool passed = conventions_.pass_words.contains(record.major);
  if (!record.is_plain && !passed) {
    findings.refuse(
        record,
        {"E-RECORD", fmt::format("'{}' is followed by neither '/' nor the end of the record", record.major),
         "it is no record of CL data, or APT source", "write CL data: records such as GOTO/x,y,z"});
    return Outcome::refused;
  }
  if (!rule || rule->policy == Policy::refuse) {
    if (passed) return Outcome::copied;
    findings.refuse(
        record, {"E-RECORD",
                 rule ? fmt::format("{} cannot be compensated", record.major)
                      : fmt::format("'{}' is not a record that Abbe knows", record.major),
                 std::string(rule ? rule->why : "it might move the tool or change a frame"),
                 fmt::format("write the path as GOTO records; if it surely does neither, --pass-record {}",
                             record.major)});
    return Outcome::refused;
  }
  if (arc_waits_ && record.major != "GOTO" && rule->policy != Policy::pass) {
    arc_waits_ = false;
    findings.refuse(record, {"E-ARC", fmt::format("{} between a circle and its GOTO", record.major),
                             "the circle has no end", "write the GOTO directly behind the circle"});
    return Outcome::refused;
  }
  switch (rule->policy) {
    case Policy::motion:
      return move(record, findings);
    case Policy::follow:
      return follow(record, findings);
    default:
      return Outcome::copied;
  }
}

Interpreter::Outcome Interpreter::follow(const Record& record, Findings& findings) {
  const std::string_view major = record.major;
  bool good = true;
  if (one_of(major, {"UNIT", "UNITS"}))
    good = units(record, findings);
  else if (major == "FEDRAT")
    good = feed_rate(record, findings);
  else if (major == "CYCLE")
    good = cycle(record, findings);
  else if (major == "CUTCOM")
    good = cutter_compensation(record, findings);
  else if (one_of(major, {"TRANS", "ORIGIN", "MSYS", "CSYS", "TRNTYP"}))
    good = frame_record(record, findings);
  else if (major == "TLAXIS")
    good = tool_axis_record(record, findings);
  else if (one_of(major, {"LOAD", "LOADTL", "TURRET", "CUTTER", "TLDATA"}))
    good = tool_record(record, findings);
  else
    return mode(record, findings);
  return good ? Outcome::copied : Outcome::refused;
}

/// RAPID, MULTAX, GOHOME, FINI, TOOL PATH, INSERT.
Interpreter::Outcome Interpreter::mode(const Record& record, Findings& findings) {
  const std::string_view major = record.major;
  if (major == "RAPID") {
    rapid_ = true;
    rapid_unclear_ = false;
  } else if (major == "GOHOME") {
    at_known_ = rapid_ = false;
  } else if (major == "FINI") {
    ended_ = true;
  } else if (major == "TOOL PATH") {
    nx_ = true;
    forget_axis();
  } else if (major == "INSERT") {
    insert(record, findings);
  } else if (major == "MULTAX") {
    const std::string_view word = record.items.empty() ? std::string_view("ON") : record.items[0].word;
    if (record.items.size() > 1 || !one_of(word, {"ON", "OFF"})) {
      findings.refuse(record, {"E-RECORD", "MULTAX is followed by neither ON nor OFF",
                               "whether tool axes count depends on it", "write MULTAX/ON or MULTAX/OFF"});
      return Outcome::refused;
    }
    multax_ = word == "ON";
    if (!*multax_) forget_axis();
  }
  return Outcome::copied;
}

/// What the tool axis is once nobody states it any more differs between readers, unless it is Z.
void Interpreter::forget_axis() { axis_sure_ = at_.axis == Vec3(Vec3::UnitZ()); }

void Interpreter::insert(const Record& record, Findings& findings) {
  if (looks_like_code(record.text))
    findings.warn(record, {"W-INSERT", "INSERT puts what looks like a G code into the program",
                           "Abbe copies the text and does not follow it",
                           "check that it neither moves nor changes a frame"});
}

bool Interpreter::units(const Record& record, Findings& findings) {
  const std::string_view word =
      record.items.size() == 1 ? std::string_view(record.items[0].word) : std::string_view();
  const double unit = one_of(word, {"MM", "MILLIMETERS"})      ? mm
                      : one_of(word, {"INCH", "INCHES", "IN"}) ? inch
                                                               : 0;
  if (unit == 0) {
    findings.refuse(record, {"E-UNITS", "the unit is neither MM nor INCHES", "every coordinate depends on it",
                             "write UNITS/MM or UNITS/INCHES"});
    return false;
  }
  frame_.unit = unit;
  unit_known_ = true;
  refresh_frame();
  return true;
}

bool Interpreter::has_unit(const Record& record, Findings& findings) {
  if (unit_known_) return true;
  unit_known_ = true;  // said once
  findings.refuse(record, {"E-UNITS", "the file does not state its unit before this record",
                           "every coordinate depends on it",
                           "add UNITS/MM or UNITS/INCHES, or say it: --units mm or --units inch"});
  return false;
}

/// What a word says of a feed; PERMIN and PERREV count in the units of the file.
void Interpreter::note_feed_word(std::string_view word, Feed& feed) const {
  if (one_of(word, {"MMPM", "IPM", "PERMIN"}))
    feed.mode = FeedMode::per_minute;
  else if (one_of(word, {"MMPR", "IPR", "PERREV"}))
    feed.mode = FeedMode::per_revolution;
  else if (one_of(word, {"MMPT", "IPT"}))
    feed.mode = FeedMode::per_tooth;
  else if (word == "INVERS")
    feed.mode = FeedMode::inverse_time;
  feed.inch = feed.inch || one_of(word, {"IPM", "IPR", "IPT"}) ||
              (one_of(word, {"PERMIN", "PERREV"}) && frame_.unit == inch);
}

bool Interpreter::feed_rate(const Record& record, Findings& findings) {
  Feed feed;
  bool has_value = false, has_mode = false;
  for (const Item& item : record.items) {
    if (item.is_number && !has_value) {
      feed.value = item.value;
      has_value = true;
    } else if (item.is_number) {
      continue;  // a maximum feed
    } else if (!one_of(item.word, {"MMPM", "IPM", "PERMIN", "MMPR", "IPR", "PERREV", "MMPT", "IPT", "INVERS",
                                   "ON", "OFF", "AUTO"})) {
      findings.refuse(record, item,
                      {"E-FEED", fmt::format("'{}' is not understood in FEDRAT", item.word),
                       "how long a motion takes depends on it", "write FEDRAT/f,MMPM and its like"});
      return false;
    }
    if (!item.is_number) {
      has_mode = true;
      note_feed_word(item.word, feed);
    }
  }
  if (has_value && !(feed.value >= 0)) {
    findings.refuse(record,
                    {"E-FEED", "a negative feed", "no control moves backwards in time", "correct FEDRAT"});
    return false;
  }
  if (!has_mode) {
    feed.mode = feed_.mode;
    feed.inch = feed_.inch;
  }
  if (!has_value) feed.value = feed_.value;
  feed_ = feed;
  // Some readers end RAPID here, others at the next motion.
  rapid_unclear_ = rapid_unclear_ || rapid_;
  return true;
}

bool Interpreter::cutter_compensation(const Record& record, Findings& findings) {
  bool on = false, off = false;
  for (const Item& item : record.items) {
    if (item.is_number || one_of(item.word, {"XYPLAN", "YZPLAN", "ZXPLAN"})) continue;
    if (one_of(item.word, {"LEFT", "RIGHT", "ON"})) {
      on = true;
    } else if (item.word == "OFF") {
      off = true;
    } else {
      findings.refuse(record, item,
                      {"E-CUTCOM", fmt::format("'{}' is not understood in CUTCOM", item.word),
                       "it may move the path by an offset that Abbe does not know",
                       "post without it; LEFT, RIGHT, ON and OFF are followed"});
      return false;
    }
  }
  if (on == off) {
    findings.refuse(record,
                    {"E-CUTCOM", "CUTCOM says neither LEFT, RIGHT or ON, nor OFF",
                     "whether the control offsets the path depends on it", "write CUTCOM/LEFT and its like"});
    return false;
  }
  cutcom_ = on;
  cutcom_edge_ = true;
  return true;
}

void Interpreter::note_cycle_word(const Item& item) {
  const std::string_view word = item.word;
  if (one_of(word, {"MMPM", "MMPR", "IPM", "IPR", "PERMIN", "PERREV"}))
    note_feed_word(word, cycle_feed_.emplace());
  else if (cycle_extra_.empty() && !one_of(word, {"FEDTO", "DEPTH", "THRU", "RAPTO", "CLEAR"}))
    cycle_extra_ = word;
}

bool Interpreter::cycle(const Record& record, Findings& findings) {
  const std::string_view type =
      record.items.empty() ? std::string_view() : std::string_view(record.items[0].word);
  if (type == "OFF" || type == "INIT") {
    if (type == "OFF") cycle_on_ = false;
    return true;
  }
  if (type == "ON" && cycle_defined_) {
    cycle_on_ = true;
    return true;
  }
  if (!one_of(type, {"DRILL", "DEEP", "DEEP2", "BRKCHP", "TAP", "BORE", "REAM", "FACE", "CSINK", "CBORE",
                     "SPOT"})) {
    findings.refuse(record,
                    {"E-CYCLE", fmt::format("the cycle '{}' is not understood", type),
                     "what the tool does around each point is not known", "post the holes as GOTO records"});
    return false;
  }
  if (!has_unit(record, findings)) return false;
  above_ = below_ = 0;
  cycle_feed_.reset();
  cycle_extra_.clear();
  std::string_view tag = type;
  for (std::size_t i = 1; i < record.items.size(); ++i) {
    const Item& item = record.items[i];
    if (!item.is_number) {
      tag = item.word;
      note_cycle_word(item);
      continue;
    }
    const double reach = std::abs(item.value) * frame_.unit;
    if (one_of(tag, {"MMPM", "MMPR", "IPM", "IPR", "PERMIN", "PERREV"}) && cycle_feed_)
      cycle_feed_->value = item.value;
    if (tag == type || one_of(tag, {"FEDTO", "DEPTH", "CSINK", "THRU"}))
      below_ = std::max(below_, reach);
    else if (one_of(tag, {"RAPTO", "CLEAR"}))
      above_ = std::max(above_, reach);
    // retracts are rapids; pecks are part of the depth; the others are times and feeds
    else if (!one_of(tag, {"RTRCTO", "MMPM", "MMPR", "IPM", "IPR", "PERMIN", "PERREV", "DWELL", "REV",
                           "1STPECK", "SUBPECK", "STEP", "INCR", "TPI", "DIAMET", "ORIENT", "CAM"})) {
      above_ = std::max(above_, reach);
      below_ = std::max(below_, reach);
    } else if (one_of(tag, {"MMPM", "MMPR", "IPM", "IPR"})) {
      tag = "CLEAR";  // the number behind the feed is the clearance: DRILL,depth,MMPM,feed,clearance
    }
  }
  cycle_on_ = cycle_defined_ = true;
  cycle_kind_ = type;
  return true;
}

bool Interpreter::tool_record(const Record& record, Findings& findings) {
  if (record.major == "CUTTER" || record.major == "TLDATA") {
    for (const Item& item : record.items) {
      if (!item.is_number) continue;
      cutter_diameter_ = std::max(0.0, item.value * frame_.unit);
      break;
    }
    return true;
  }
  // LOAD/TOOL,5 and LOADTL/5,.. and TURRET/5
  if (record.major == "LOAD" && (record.items.empty() || record.items[0].word != "TOOL")) {
    findings.refuse(record, {"E-RECORD", "LOAD of something else than a TOOL",
                             "where the axes then stand is not known", "write LOAD/TOOL,n"});
    return false;
  }
  const auto number =
      std::find_if(record.items.begin(), record.items.end(), [](const Item& item) { return item.is_number; });
  if (number == record.items.end() || number->value != std::floor(number->value) || number->value < 0 ||
      number->value > kMaxTool) {
    findings.refuse(record,
                    {"E-TOOL", "the tool change names no tool number",
                     "the tool's length decides how rotation errors act", "write LOADTL/n or LOAD/TOOL,n"});
    return false;
  }
  tool_ = static_cast<int>(number->value);
  if (!conventions_.tool_change_keeps_place) at_known_ = false;
  return true;
}

}  // namespace abbe::cl
