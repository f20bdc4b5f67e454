#include "abbe/cl/emit_gcode.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "abbe/cl/emit_events.h"
#include "abbe/cl/record.h"
#include "abbe/core/number.h"

namespace abbe {
namespace cl {
namespace {

constexpr int kLinearDecimals = 4, kRotaryDecimals = 5;
constexpr int kDeepest = 12;    // 4096 pieces
constexpr double kSpacing = 5;  // mm between looks along a piece
constexpr double kTurnSpacing = 2 * deg;
constexpr double kAtRest = 1e-6;                      // mm
constexpr double kSamePlace = 1e-4;                   // mm: what a correction may leave of the tip
constexpr double kLeastFeed = 1e-3, kMostFeed = 1e6;  // mm/min, mm per turn, 1/min: beyond is a wrong number
constexpr std::string_view kAddresses = "XYZABCUVW";

/// One moving axis as a word.
struct Word {
  int axis = 0;
  char letter = 'X';
  bool rotary = false;
  double offset = 0;  ///< taken off the command, internal units
  std::string last;   ///< digits written last
};

/// Turns motions into blocks.
class Emitter {
 public:
  Emitter(const Plan& plan, AxisSet free, const GcodeJob& job, GcodeReport& report)
      : job_(job),
        report_(report),
        machine_(plan.machine()),
        findings_(job.name),
        interpreter_(job.conventions, job.setup.loaded_tool),
        field_(plan, placement_of(plan, job.setup.work_offsets[0]), job.probed_datum && !job.ideal, free,
               job.start) {}

  [[nodiscard]] Findings& findings() { return findings_; }
  [[nodiscard]] bool make_words();
  void begin(std::string& out) const;
  void line(std::string_view bytes, std::uint64_t number, std::string& out);
  void finish(std::string& out);

 private:
  struct Node {
    double s = 0;
    PoseField::Place place;
    Commands q{};
  };

  void record(const Record& record, std::string& out);
  [[nodiscard]] bool use_tool(const Record& record);
  [[nodiscard]] bool motion(const Record& record, const Motion& motion, std::string& out);
  [[nodiscard]] bool drill(const Record& record, std::string& out);
  [[nodiscard]] bool command(const Record& record, Node& node);
  [[nodiscard]] bool feed_is_known(const Record& record, bool turns);
  [[nodiscard]] double bend(const Motion& motion, const Node& a, const Node& b) const;
  [[nodiscard]] bool pieces(const Record& record, const Motion& motion, const Node& a, const Node& b,
                            int depth, std::string& out);
  void block(const char* code, const Node& node, const std::string& feed, std::string& out);
  [[nodiscard]] std::string feed_word(const Motion& motion, const Node& a, const Node& b);
  [[nodiscard]] double turn_between(const Node& a, const Node& b) const;
  void forget_place();
  /// While a cycle drills, its own feed.
  [[nodiscard]] const Feed& feed_in_force() const {
    const auto& own = interpreter_.cycle_feed();
    return interpreter_.motion().kind == MotionKind::hole && own ? *own : interpreter_.feed();
  }

  const GcodeJob& job_;
  GcodeReport& report_;
  const Machine& machine_;
  Findings findings_;
  RecordReader reader_;
  Interpreter interpreter_;
  PoseField field_;
  std::vector<Word> words_;
  EventWriter events_;
  std::optional<Node> last_;
  std::optional<int> tool_;
  bool tool_used_ = false, ended_ = false;
  std::string feed_, mode_ = "G94";
};

bool Emitter::make_words() {
  for (int i = 0; i < machine_.axis_count(); ++i) {
    const Body& axis = machine_.axis(i);
    const std::string& address = axis.address.empty() ? axis.name : axis.address;
    if (address.size() != 1 || kAddresses.find(address[0]) == std::string_view::npos) {
      findings_.refuse_file(
          {"E-MACHINE", fmt::format("axis {} has no address of a program (X Y Z A B C U V W)", axis.name),
           "its position cannot be written", "set `address` in the machine file"});
      continue;
    }
    Word word{i, address[0], axis.type == AxisType::rotary, 0, {}};
    if (job_.setup.work_offsets[0] && address[0] >= 'X')
      word.offset = job_.setup.work_offsets[0]->origin[static_cast<std::size_t>(address[0] - 'X')];
    words_.push_back(word);
  }
  std::sort(words_.begin(), words_.end(), [](const Word& a, const Word& b) {
    return kAddresses.find(a.letter) < kAddresses.find(b.letter);
  });
  return !findings_.refused();
}

void Emitter::begin(std::string& out) const {
  for (const std::string& text : job_.header) out += text + '\n';
  out += job_.setup.work_offsets[0] ? "" : "(WORDS ARE AXIS POSITIONS OF THE MACHINE: G54 MUST BE ZERO)\n";
  out += "(Z WORDS ARE THOSE OF THE SPINDLE NOSE: NO TOOL LENGTH IS ADDED)\n";
  out += "G21 G17 G90 G40 G49 G80 G54 G94\n";
}

void Emitter::line(std::string_view bytes, std::uint64_t number, std::string& out) {
  const auto state = reader_.add(bytes, number);
  if (state == RecordReader::State::wants_more) return;
  if (state == RecordReader::State::complete) return record(reader_.record(), out);
  const RecordError& error = reader_.error();
  findings_.add(Severity::error, reader_.record(), error.begin, error.length,
                {error.code.c_str(), error.message, error.why, error.fix});
}

void Emitter::finish(std::string& out) {
  if (reader_.finish() == RecordReader::State::error)
    findings_.refuse(reader_.record(), {"E-CONTINUE", "the file ends in a record that '$' continues",
                                        "what follows is missing", "write the CL file again"});
  if (!ended_) out += "M2\n";
}

void Emitter::record(const Record& record, std::string& out) {
  if (ended_) return;
  switch (interpreter_.take(record, findings_)) {
    case Interpreter::Outcome::motion:
      ++report_.motions;
      if (!(interpreter_.motion().kind == MotionKind::hole ? drill(record, out)
                                                           : motion(record, interpreter_.motion(), out)))
        last_.reset();
      return;
    case Interpreter::Outcome::copied:
      if (record.major == "CUTCOM" && interpreter_.cutter_compensated())
        findings_.refuse(record, {"E-CUTCOM", "cutter compensation of axis words",
                                  "the control would offset the path of the axes, not of the tip",
                                  "post the tool-centre path"});
      else if (!record.is_remark())
        out += events_.words_of(record, findings_);
      // where the axes stand after a tool change is the control's affair
      if (record.major == "LOADTL" || record.major == "LOAD" || record.major == "TURRET") forget_place();
      ended_ = interpreter_.ended();
      return;
    default:
      return;
  }
}

/// The next block names every axis: what the words before it said does not hold any more.
void Emitter::forget_place() {
  last_.reset();
  for (Word& word : words_) word.last.clear();
}

bool Emitter::use_tool(const Record& record) {
  if (tool_used_ && tool_ == interpreter_.tool()) return true;
  tool_used_ = true;
  tool_ = interpreter_.tool();
  const GaugeLength gauge = gauge_length(job_.setup, machine_, tool_);
  // Here the length is part of every word, not only the lever of rotation errors.
  if (gauge.touch_off) {
    findings_.refuse(
        record,
        {"E-GAUGE", fmt::format("the length of tool {} in the tool table is negative", tool_.value_or(-1)),
         "it is a touch-off value, and the words are those of the spindle nose",
         fmt::format("--gauge T{}=..", tool_.value_or(-1))});
    return false;
  }
  if (gauge.source == GaugeLength::Source::machine_file && tool_)
    findings_.warn(record,
                   {"W-GAUGE",
                    fmt::format("the length of tool {} is not known: the machine file's {:.3f} mm is used",
                                *tool_, gauge.length),
                    "every word depends on it", fmt::format("--gauge T{}=.., or --tools FILE", *tool_)});
  field_.set_tool(tool_of(machine_, gauge.length));
  return true;
}

/// Fills in the commands of a node.
bool Emitter::command(const Record& record, Node& node) {
  using Trouble = PoseField::Trouble;
  const auto refused = [&](const char* code, std::string what) {
    findings_.refuse(record, {code, std::move(what), "the axes cannot, or must not, go there",
                              "check the part's place (--offset), the tool and the machine file"});
    return false;
  };
  if (node.place.trouble == Trouble::unreachable)
    return refused("E-REACH", "the machine cannot bring the tool there");
  bool outside = false;
  node.q = node.place.q;
  if (node.place.trouble == Trouble::none && !job_.ideal) {
    // Indexed positions stay: the rule of the rewriter.
    const AxisRule rule = job_.conventions.axis_rule;
    const bool turn = rule == AxisRule::correct || (rule == AxisRule::automatic && interpreter_.multax());
    const Correction corrected = field_.corrected_commands(node.place, turn);
    if (corrected.status == Status::failed || corrected.residual_position > kSamePlace)
      return refused("E-SOLVE", "no correction was found");
    node.q = corrected.corrected;
    outside = corrected.outside;
  }
  report_.out_of_volume = report_.out_of_volume || outside || node.place.trouble == Trouble::travel;
  if (node.place.trouble == Trouble::travel)
    return refused("E-TRAVEL", fmt::format("outside the travel of {}", machine_.axis(node.place.axis).name));
  if (outside) return refused("E-VOL", "outside the calibrated volume");
  for (const Word& word : words_) {
    const auto i = static_cast<std::size_t>(word.axis);
    const double change = std::abs(node.q[i] - node.place.q[i]);
    double& most = word.rotary ? report_.max_turn : report_.max_correction;
    most = std::max(most, change);
    if (!word.rotary && change > job_.max_correction)
      return refused("E-CORRECTION",
                     fmt::format("the correction of {} is {:.1f} um", word.letter, change / um));
  }
  return true;
}

double Emitter::turn_between(const Node& a, const Node& b) const {
  double most = 0;
  for (const Word& word : words_) {
    const auto i = static_cast<std::size_t>(word.axis);
    if (word.rotary) most = std::max(most, std::abs(b.q[i] - a.q[i]));
  }
  return most;
}

/// How far all axes moving evenly from a to b take the tip off the motion, mm.
double Emitter::bend(const Motion& motion, const Node& a, const Node& b) const {
  const double looks = length_of(motion) * (b.s - a.s) / kSpacing + turn_between(a, b) / kTurnSpacing;
  const int count = std::clamp(static_cast<int>(std::ceil(std::min(looks, 1e3))),
                               motion.kind == MotionKind::arc ? 4 : 2, 64);
  double most = 0;
  for (int i = 1; i < count; ++i) {
    const double t = static_cast<double>(i) / count;
    Commands q;
    for (std::size_t k = 0; k < q.size(); ++k) q[k] = a.q[k] + t * (b.q[k] - a.q[k]);
    PoseField::Place place;
    place.pose = pose_at(motion, a.s + t * (b.s - a.s));
    most = std::max(most, field_.off_at(place, q, job_.ideal).norm());
  }
  return most;
}

bool Emitter::pieces(const Record& record, const Motion& motion, const Node& a, const Node& b, int depth,
                     std::string& out) {
  if (bend(motion, a, b) <= job_.tolerance / 2) {
    block("G1", b, feed_word(motion, a, b), out);
    return true;
  }
  if (depth >= kDeepest) {
    findings_.refuse(record, {"E-TOL", "the axes cannot follow this motion within the tolerance",
                              "near the singularity of the rotary axes, or at a step of the error tables",
                              "tilt the tool or the part, or --tolerance-um"});
    return false;
  }
  Node middle;
  middle.s = 0.5 * (a.s + b.s);
  middle.place = field_.between(pose_at(motion, middle.s), a.place, b.place, 0.5);
  return command(record, middle) && pieces(record, motion, a, middle, depth + 1, out) &&
         pieces(record, motion, middle, b, depth + 1, out);
}

/// mm/min or mm per turn; of inverse time 1/min.
double value_of(const Feed& feed) {
  return feed.inch && feed.mode != FeedMode::inverse_time ? feed.value * 25.4 : feed.value;
}

/// The F of G93 in 1/min. A long way at a slow feed is a small number, and F0 would be none.
std::string inverse_time_word(double value) { return fmt::format("F{:.{}f}", value, value < 0.01 ? 9 : 5); }

bool Emitter::feed_is_known(const Record& record, bool turns) {
  const Feed& feed = feed_in_force();
  const bool by_time = feed.mode == FeedMode::per_minute || feed.mode == FeedMode::inverse_time;
  const double value = value_of(feed);
  if (value > 0 && !(value >= kLeastFeed && value <= kMostFeed)) {
    findings_.refuse(record, {"E-FEED", fmt::format("a feed of {:.6g}", value),
                              "so slow or fast a motion can only be a wrong number or unit",
                              "correct FEDRAT or the feed of CYCLE"});
    return false;
  }
  if (feed.value > 0 && (by_time || (feed.mode == FeedMode::per_revolution && !turns))) return true;
  findings_.refuse(record,
                   {"E-FEED",
                    feed.value > 0 ? "a feed per revolution or tooth while rotary axes turn"
                                   : "a feed motion before any FEDRAT",
                    "how long the motion takes is not known", "write FEDRAT/f,MMPM (or IPM, INVERS) before"});
  return false;
}

/// G94 F along the tip; G93 F = 1 / time, where the control's own length is not the tip's.
std::string Emitter::feed_word(const Motion& motion, const Node& a, const Node& b) {
  const Feed& feed = feed_in_force();
  const double value = value_of(feed), turn = turn_between(a, b), length = length_of(motion) * (b.s - a.s);
  std::string mode, number;
  if (feed.mode == FeedMode::inverse_time) {
    mode = "G93";
    number = inverse_time_word(value / (b.s - a.s));
  } else if (turn > 0.5e-5 * deg && feed.mode == FeedMode::per_minute) {
    const double minutes = length > kAtRest ? length / value : turn / deg / value;
    mode = "G93";
    number = inverse_time_word(1 / minutes);
  } else {
    mode = feed.mode == FeedMode::per_revolution ? "G95" : "G94";
    number = fmt::format("F{:.4f}", value);
  }
  std::string text;
  if (mode != mode_) text += ' ' + mode;
  if (mode != mode_ || mode == "G93" || number != feed_) text += ' ' + number;
  mode_ = mode;
  feed_ = number;
  return text;
}

void Emitter::block(const char* code, const Node& node, const std::string& feed, std::string& out) {
  std::string words;
  for (Word& word : words_) {
    const double q = node.q[static_cast<std::size_t>(word.axis)];
    std::string digits;
    append_fixed(digits, word.rotary ? q / deg : q - word.offset,
                 word.rotary ? kRotaryDecimals : kLinearDecimals);
    if (digits == word.last) continue;
    words += fmt::format(" {}{}", word.letter, digits);
    word.last = digits;
  }
  if (words.empty()) return;  // nothing moves
  ++report_.blocks;
  out += code + words + feed + '\n';
}

bool Emitter::motion(const Record& record, const Motion& motion, std::string& out) {
  if (!use_tool(record)) return false;
  Node end;
  end.s = 1;
  end.place = field_.follow(motion.end);
  if (!command(record, end)) return false;
  if (motion.kind == MotionKind::from) {  // where the tool stands, whatever was written before
    forget_place();
    last_ = end;
    return true;
  }
  report_.arcs += motion.kind == MotionKind::arc ? 1 : 0;
  if (!motion.start_known) forget_place();
  bool good = true;
  if (motion.kind == MotionKind::rapid) {
    block("G0", end, {}, out);
  } else if (!feed_is_known(record, last_ && turn_between(*last_, end) > 0)) {
    good = false;
  } else if (!last_) {
    // From a place that only the control knows: no path to keep, and so no time to state.
    findings_.refuse(record, {"E-POS", "a feed motion from a position that is not known",
                              "how far the tip goes, and so its feed, is not known",
                              "write RAPID before the first motion, or FROM"});
    good = false;
  } else {
    Node start = *last_;
    start.s = 0;
    good = pieces(record, motion, start, end, 0, out);
  }
  last_ = std::move(end);
  return good;
}

/// CYCLE/DRILL as motions: to the clearance, to the depth, back.
bool Emitter::drill(const Record& record, std::string& out) {
  Motion hole = interpreter_.motion();
  if (interpreter_.cycle_kind() != "DRILL") {
    findings_.refuse(record, {"E-CYCLE", fmt::format("CYCLE/{} as axis words", interpreter_.cycle_kind()),
                              "only DRILL is written as motions", "post the holes as GOTO records"});
    return false;
  }
  if (!interpreter_.cycle_extra().empty()) {
    findings_.refuse(
        record,
        {"E-CYCLE", fmt::format("{} in CYCLE/DRILL as axis words", interpreter_.cycle_extra()),
         "only a depth, a clearance and a feed are written as motions", "post the holes as GOTO records"});
    return false;
  }
  const ToolPose bottom{hole.end.tip - hole.below * hole.end.axis, hole.end.axis},
      top{hole.end.tip + hole.above * hole.end.axis, hole.end.axis};
  Motion step = hole;
  const auto go = [&](MotionKind kind, const ToolPose& to) {
    step.kind = kind;
    step.end = to;
    const bool good = motion(record, step, out);
    step.start = to;
    step.start_known = true;
    return good;
  };
  return go(MotionKind::rapid, top) && go(MotionKind::line, bottom) && go(MotionKind::rapid, top);
}

}  // namespace
}  // namespace cl

GcodeReport emit_gcode(const Plan& plan, const GcodeJob& job, SpoolFile& out, const Progress& progress) {
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  constexpr std::uint64_t kLinesPerLook = 1024;
  GcodeReport report;
  const auto fail = [&](const char* code, std::string message, const char* fix) {
    report.diagnostics.push_back(
        {Severity::error, code, Place{job.name, 0, 0, 1, {}}, std::move(message), {}, fix});
    return report;
  };
  const auto free = free_axes(plan.machine(), 0);
  if (!free)
    return fail("E-MACHINE", "more than three linear or two rotary axes could be moved",
                "set correctable = false in the machine file for those that rest");
  auto opened = LineReader::open(job.path, false);
  if (const auto* error = std::get_if<FileError>(&opened))
    return fail("E-FILE", error->message, "check the path and the permissions");
  auto& reader = std::get<LineReader>(opened);
  cl::Emitter emitter(plan, *free, job, report);
  std::string text;
  bool written = true;
  if (emitter.make_words()) emitter.begin(text);
  while (const auto line = reader.next()) {
    emitter.line(*line, reader.line_number(), text);
    if (text.size() >= kBlock) {
      written = emitter.findings().refused() || out.write(text);
      text.clear();
      if (!written) break;
    }
    if (progress && reader.line_number() % kLinesPerLook == 0 &&
        !progress(reader.bytes_read(), reader.identity().size)) {
      report.stopped = true;
      return report;
    }
  }
  emitter.finish(text);
  const bool refused = emitter.findings().refused();
  report.diagnostics = emitter.findings().take();
  if (reader.error()) return fail("E-FILE", reader.error()->message, "check the file and its medium");
  if (refused) return report;
  if (report.motions == 0)
    return fail("E-EMPTY", "the file moves nothing", "check that the right file is named");
  if (!written || !out.write(text) || !out.flush())
    return fail("E-WRITE", out.error() ? out.error()->message : "the output cannot be written",
                "free space, or name another folder");
  report.complete = true;
  return report;
}

}  // namespace abbe
