#include "abbe/verify/comparison.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "abbe/core/units.h"

namespace abbe::verifying {
namespace {

constexpr std::size_t kMaxDisagreements = 20;
/// How far to look for an event that came too late.
constexpr int kLookAhead = 16;
/// Differences of frames and ways of axes that are rounding of double arithmetic.
constexpr double kRounding = 1e-8;  // mm

const char* why_of(std::string_view code) {
  if (code == "V-PATH" || code == "V-END")
    return "the tool would not cut where the original program means it to";
  if (code == "V-CLASS")
    return "a rapid in place of a feed, or a feed in place of a rapid, moves at the wrong speed";
  if (code == "V-FEED") return "the output must cut with the feeds of the original";
  if (code == "V-FRAME") return "every later position would be off by the difference";
  if (code == "V-LIMIT")
    return "a correction this large is more likely a mistake than an error of the machine";
  if (code == "V-TURN") return "a rotary axis that turns otherwise moves the tool through the part";
  if (code == "V-AXIS") return "the tool would stand more askew than without compensation";
  if (code == "V-VOL") return "the errors are not known there, so the correction is a guess";
  if (code == "V-TRAVEL") return "the control would stop there";
  return "the output must do everything that the original does, in the same order";
}

std::string describe(const Event& event) {
  const auto code10 = [](int code) {
    return code % 10 == 0 ? fmt::format("G{}", code / 10) : fmt::format("G{}.{}", code / 10, code % 10);
  };
  std::string text;
  switch (event.kind) {
    case EventKind::delimiter:
      text = "%";
      break;
    case EventKind::program_number:
      break;
    case EventKind::block_number:
      break;
    case EventKind::feed:
      break;
    case EventKind::speed:
      break;
    case EventKind::tool:
      break;
    case EventKind::comment:
      text = fmt::format("the comment \"{}\"", event.text);
      break;
    case EventKind::skipped_line:
      text = fmt::format("the deleted block \"{}\"", event.text);
      break;
    case EventKind::after_end:
      text = fmt::format("\"{}\" behind the end", event.text);
      break;
    case EventKind::m_code:
      text = fmt::format("M{}", event.code);
      break;
    case EventKind::g_code:
      text = event.text.empty() ? code10(event.code) : std::string(event.text);
      break;
  }
  std::size_t n = 0;
  for (char letter = 'A'; letter <= 'Z'; ++letter)
    if ((event.words & letter_bit(letter)) != 0 && n < event.values.size())
      text += fmt::format("{}{}{:g}", text.empty() ? "" : " ", letter, event.values[n++]);
  return text;
}

bool same_values(const Event& a, const Event& b) {
  return a.words == b.words && a.text == b.text && (a.sets_position || a.values == b.values);
}
bool same_kind(const Event& a, const Event& b) { return a.kind == b.kind && a.code == b.code; }

}  // namespace

Comparison::Comparison(const VerifyJob& job, TipModel& model, ProgramReader& original, ProgramReader& output,
                       VerifyReport& report)
    : job_(job),
      model_(model),
      original_(original),
      output_(output),
      report_(report),
      half_digit_mm_(0.5 * std::pow(10.0, -output.profile().numbers.decimals_mm)),
      half_digit_inch_(0.5 * std::pow(10.0, -output.profile().numbers.decimals_inch) * abbe::inch),
      output_turns_(job.setup.start_turns),
      lane_(model.turning_bend()),
      samples_(job.samples) {}

void Comparison::run(const KeepGoing& keep_going) {
  std::uint32_t count = 0;
  while (!stop_) {
    if ((++count & 0xfffu) == 0 && !keep_going()) {
      report_.stopped = true;
      return;
    }
    if (compare_plain()) continue;
    lane_.follows = false;
    switch (original_.next()) {
      case Item::refused:
        return refused(original_);
      case Item::event:
        compare_event();
        break;
      case Item::motion:
        compare_motion();
        break;
      case Item::end:
        switch (pull()) {
          case Item::refused:
            return refused(output_);
          case Item::end:
            return;
          case Item::event:
            return disagree("V-EXTRA", fmt::format("{} behind the end", describe(output_.event())));
          case Item::motion:
            return disagree("V-EXTRA", "a motion behind the end of the original");
        }
    }
  }
}

void Comparison::finish() {
  report_.before = before_.summary();
  report_.after = after_.summary();
  report_.samples = samples_.take();
  report_.path_length = travelled_;
}

void Comparison::compare_event() {
  const Event& expected = original_.event();
  if (timed_ && expected.kind == EventKind::feed) return;  // held against the output's in end_timed()
  Item item = pull();
  if (item == Item::event && begins_timed(output_.event()) && !same_kind(expected, output_.event())) {
    timed_ = true;
    if (expected.kind == EventKind::feed) return;
    item = pull();
  }
  if (item != Item::event || !same_kind(expected, output_.event())) return explain_disorder(item, &expected);
  const Event& found = output_.event();
  ++report_.events;
  if (!same_values(expected, found))
    disagree(expected.kind == EventKind::feed ? "V-FEED" : "V-EVENT",
             fmt::format("expected {}, found {}", describe(expected), describe(found)));
  else if (original_.deletable() != output_.deletable())
    disagree("V-EVENT",
             fmt::format("{}: one of the blocks can be deleted with '/', the other not", describe(found)));
  if (expected.sets_frames) {
    compare_frames();
    context_changed_ = true;
  }
  if (expected.kind == EventKind::m_code && (expected.code == 6 || expected.code == 61))
    context_changed_ = true;
}

/// G93 that the original does not have: the output states the time of the turning motion that follows.
bool Comparison::begins_timed(const Event& found) const {
  constexpr int inverse_time = 930;
  return output_.profile().feed_of_linear && !timed_ && found.kind == EventKind::g_code &&
         found.code == inverse_time;
}

/// Behind such a motion the output must restore feed mode and feed of the original.
void Comparison::end_timed(const Motion& original) {
  constexpr int per_minute = 940;
  timed_ = false;
  const bool mode = pull() == Item::event && output_.event().kind == EventKind::g_code &&
                    output_.event().code == per_minute;
  const bool feed = mode && pull() == Item::event && output_.event().kind == EventKind::feed &&
                    output_.event().values[0] == original.feed;
  if (!feed)
    disagree_and_stop(
        "V-FEED", fmt::format("G94 F{:g} is not restored behind a motion in inverse time", original.feed));
}

void Comparison::compare_frames() {
  const Frames& a = original_.frames();
  const Frames& b = output_.frames();
  const double allowed = half_digit() + kRounding;
  const auto check = [&](const std::string& name, const Vec3& expected, const Vec3& found) {
    for (int i = 0; i < 3; ++i)
      if (!(std::abs(expected[i] - found[i]) <= allowed)) {
        disagree(
            "V-FRAME",
            fmt::format("{} {} is {:.5f} mm in the original and {:.5f} mm here: {:.2f} um apart", name,
                        static_cast<char>('X' + i), expected[i], found[i], (found[i] - expected[i]) / um));
        return;
      }
  };
  if (a.active != b.active) disagree("V-FRAME", "another work offset is active");
  for (std::size_t k = 0; k < a.systems.size(); ++k) {
    if (a.systems[k].defined != b.systems[k].defined || a.systems[k].rotation != b.systems[k].rotation)
      disagree("V-FRAME", fmt::format("{} differs", work_offset_label(static_cast<int>(k))));
    check(work_offset_label(static_cast<int>(k)), a.systems[k].origin, b.systems[k].origin);
  }
  if (a.turn != b.turn || a.pivot != b.pivot) disagree("V-FRAME", "the rotation made by the program differs");
  if (a.placement.kind != b.placement.kind || a.placement.axes != b.placement.axes)
    disagree("V-FRAME", "the tilted plane, scale or mirror differs");
  check("the origin of the frame", a.placement.origin, b.placement.origin);
  check("G92", a.g92, b.g92);
  check("the tool offset", a.tool_offset, b.tool_offset);
}

/// On a tilted plane the rotary axes are the control's: what the errors leave of the tool's direction stays.
void Comparison::note_direction(const Motion& original) {
  const bool on_plane = original_.frames().placement.kind == Placement::Kind::plane && original_.tcp();
  if (!on_plane || (!original.feeds() && original.kind != MotionKind::cycle)) return;
  const Vec3 meant = model_.nominal_pose(original.end.at).tool_axis;
  const Vec3 is = model_.actual_pose(original.end.at, nullptr).tool_axis;
  const double angle = std::atan2(meant.cross(is).norm(), meant.dot(is));
  report_.direction_before = std::max(report_.direction_before, angle);
  report_.direction_after = std::max(report_.direction_after, angle);
}

void Comparison::compare_motion() {
  const Motion& expected = original_.motion();
  if (context_changed_) update_context();
  if (expected.tcp != tcp_) withheld_ = 0;  // what stood in machine coordinates has become a point of the tip
  tcp_ = expected.tcp;
  const bool turns = model_.rotary().any();
  if (stop_ || (turns && !stand(expected.turns_end, output_turns_))) return;
  if (turns) note_direction(expected);
  if (timed_ && !(expected.kind == MotionKind::line && expected.turns() && expected.feed_mode == 940))
    return disagree_and_stop("V-FEED", "G93 in the output for a motion that needs no time of its own");
  using Phase = CutterUse::Phase;
  if (expected.cutter.phase == Phase::off || expected.cutter.phase == Phase::begins) last_beside_ = {};
  const bool changes = expected.cutter.phase == Phase::begins || expected.cutter.phase == Phase::ends;
  if (changes || (expected.cutter.phase == Phase::on && expected.kind == MotionKind::rapid))
    return compare_change(expected);
  if (expected.feeds() && !expected.machine_words)
    return expected.turns() || (expected.by_direction && length_of(expected) > 0) ? cover_turning(expected)
                                                                                  : cover(expected);
  if (!pull_motion() || !skip_step_to_hole(expected)) return;
  const Motion& found = output_.motion();
  const bool drills = expected.kind == MotionKind::cycle && (expected.code == 810 || expected.code == 820);
  if (drills && !found.machine_words && (found.kind == MotionKind::rapid || found.kind == MotionKind::line)) {
    put_back(Item::motion);
    return cover_drill(expected);
  }
  output_turns_ = found.turns_end;
  if (turns && (!stand(expected.turns_end, output_turns_) || !check_turns(expected, found))) return;
  if (expected.kind != found.kind || expected.machine_words != found.machine_words ||
      expected.code != found.code) {
    if (expected.kind == MotionKind::cycle || found.kind == MotionKind::cycle)
      return disagree_and_stop("V-CYCLE", "another kind of motion than in the original");
    return disagree_and_stop("V-CLASS", "another kind of motion than in the original");
  }
  if (original_.deletable() != output_.deletable())
    disagree("V-EVENT", "one of the blocks can be deleted with '/', the other not");
  switch (expected.kind) {
    case MotionKind::rapid:
    case MotionKind::line:
      ++(expected.kind == MotionKind::rapid ? report_.rapid_motions : report_.feed_motions);
      if (expected.kind == MotionKind::line && expected.feed_mode == 930 && expected.feed != found.feed)
        disagree("V-FEED", fmt::format("expected F{:g}, found F{:g}", expected.feed, found.feed));
      if (expected.machine_words) return compare_machine_move(expected, found);
      if (expected.end.known != kAllAxes) return compare_words(expected, found);
      return compare_rapid(expected, found);
    case MotionKind::home:
      ++report_.rapid_motions;
      return compare_words(expected, found);
    case MotionKind::cycle:
      return compare_cycle(expected, found);
    case MotionKind::nurbs:
      return compare_nurbs(expected, found);
    case MotionKind::arc:
      return;  // covered above
  }
}

ProgramReader::Item Comparison::pull() {
  if (put_back_) return *std::exchange(put_back_, std::nullopt);
  const Item item = output_.next();
  if (const auto places = output_.ahead(); !places.empty()) model_.look_ahead(places, approach_);
  return item;
}

bool Comparison::pull_motion() {
  const Item item = pull();
  if (item == Item::motion) return true;
  explain_disorder(item, nullptr);
  return false;
}

/// The output's item is not of the kind expected (an event, or a motion if null): says what it may be.
void Comparison::explain_disorder(Item found, const Event* expected) {
  if (found == Item::refused) {
    stop_ = true;
    return refused(output_);
  }
  const std::string wanted = expected != nullptr ? describe(*expected) : std::string("a motion");
  if (found == Item::end)
    return disagree_and_stop("V-MISSING", fmt::format("the program ends before {}", wanted));
  const std::string here = found == Item::motion ? std::string("a motion") : describe(output_.event());
  if (expected == nullptr)
    return disagree_and_stop("V-ORDER",
                             fmt::format("expected a motion, found {}: a motion is missing, or the order "
                                         "of motions and events is another",
                                         here));
  disagree_and_stop("V-EVENT", fmt::format("expected {}, found {}", wanted, here));
  // Is the event there, but later? Its text does not outlive the line of the original, which stays.
  for (int i = 0; i < kLookAhead; ++i) {
    const Item item = pull();
    if (item == Item::end || item == Item::refused) return;
    if (item != Item::event || !same_kind(*expected, output_.event()) ||
        !same_values(*expected, output_.event()))
      continue;
    report_.diagnostics.back().code = "V-ORDER";
    report_.diagnostics.back().message += fmt::format("; it comes later, at line {}", output_.line());
    return;
  }
}

void Comparison::disagree(const char* code, std::string message) {
  Diagnostic d;
  d.severity = Severity::error;
  d.code = code;
  d.place = {output_.name(), static_cast<std::size_t>(output_.line()), 1, 1, output_.source_line()};
  d.message = fmt::format("{} ({} line {}: {})", message, original_.name(), original_.line(),
                          original_.source_line());
  d.why = why_of(code);
  d.fix = "do not use this output; report it with both programs and the machine file";
  report_.diagnostics.push_back(std::move(d));
  if (++disagreements_ >= kMaxDisagreements) stop_ = true;
}

void Comparison::disagree_and_stop(const char* code, std::string message) {
  disagree(code, std::move(message));
  stop_ = true;
}

void Comparison::refused(const ProgramReader& reader) {
  report_.diagnostics.push_back(reader.refusal());
  stop_ = true;
}

/// Takes tool, frame and datum of the current block.
void Comparison::update_context() {
  context_changed_ = false;
  reached_.valid = false;
  const std::optional<int> tool = original_.tool();
  if (auto fault = model_.use_tool(tool)) {
    fault->place = {original_.name(), static_cast<std::size_t>(original_.line()), 1, 1,
                    original_.source_line()};
    report_.diagnostics.push_back(std::move(*fault));
    stop_ = true;
    return;
  }
  look_up_straight_reach();
  lane_.bend = model_.turning_bend();
  lane_.original_serial = lane_.output_serial = 0;
  datum_ = Vec3::Zero();
  if (job_.datum != DatumRule::probed) return;
  const Frames& frames = original_.frames();
  if (frames.system().defined != kAllAxes) return;
  // D0 = actual(m0) - nominal(m0) at the work-offset origin, rotary axes at zero
  const Vec3 origin = frames.system().origin + frames.tool_offset;
  model_.stand({{}, {}, false, 0});
  datum_ = model_.actual(origin, Approach{}, nullptr) - model_.nominal(origin);
  note_datum(report_.datums, {work_offset_label(frames.active), tool.value_or(-1), datum_});
}

/// Where the rotary axes of both programs stand from now on. False: the tip cannot be followed there
/// (reported).
bool Comparison::stand(const Turns& original, const Turns& output) {
  if (!model_.rotary().any()) return true;
  const Stance stance{original, output, original_.tcp(), original_.frames().tool_offset.z()};
  if (stance == model_.stance()) return true;
  reached_.valid = false;
  if (model_.stand(stance)) return true;
  disagree_and_stop("V-TURN",
                    "with the rotary axes at these positions the linear axes cannot follow the tip");
  return false;
}

/// sqrt(3) half digits: each coordinate is rounded by at most half a digit. A scale makes them larger.
double Comparison::quantum() const {
  const Placement& placement = output_.frames().placement;
  double longest = 1;
  if (placement.kind == Placement::Kind::scale)
    for (const Vec3& axis : placement.axes) longest = std::max(longest, axis.norm());
  return std::sqrt(3.0) * half_digit() * longest;
}

double Comparison::half_digit() const { return output_.inch() ? half_digit_inch_ : half_digit_mm_; }

double Comparison::allowed_for(double quantisation) {
  report_.quantisation = std::max(report_.quantisation, quantisation);
  return job_.tolerance + quantisation;
}

void Comparison::follow(const Vec3& direction) {
  if (!job_.reversal) return;
  for (std::size_t i = 0; i < 3; ++i) {
    const double d = direction[static_cast<Eigen::Index>(i)];
    if (std::abs(d) > kRounding) approach_[i] = d > 0 ? 1 : -1;
  }
}

void Comparison::keep_sample(const Vec3& position, const Vec3& before, const Vec3& after, bool rapid) {
  samples_.add({original_.line(), position, travelled_, before, after, rapid});
}

}  // namespace abbe::verifying
