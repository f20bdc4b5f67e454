#include "abbe/compensate/rewriter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "abbe/core/number.h"
#include "abbe/program/named_block.h"

namespace abbe {
namespace {

constexpr std::string_view kMark = "ABBE COMPENSATED";
// Half a digit, mm: finer ones need no allowance of their own.
constexpr double kFineDigits = 0.2 * um;

// F AUTO: the feed is the one of TOOL CALL, which the words since then do not tell.
bool feeds_by_tool_call(const Profile& profile, const Block& block) {
  const Profile::Keyword* automatic = find_keyword(profile, "AUTO");
  if (automatic == nullptr) return false;
  const double code = static_cast<double>(automatic->index) / 10;
  return std::any_of(block.words.begin(), block.words.begin() + block.count,
                     [&](const Word& word) { return word.letter == 'G' && word.value == code; });
}

}  // namespace

Rewriter::Rewriter(const Plan& plan, const AddressedAxes& axes, const RewriteJob& job, RewriteReport& report)
    : job_(job),
      shared_profile_(profile_of(job.setup)),
      profile_(*shared_profile_),
      report_(report),
      machine_(plan.machine()),
      field_(plan, axes, job.probed_datum),
      vectors_(plan.machine(), axes),
      findings_(job.name),
      interpolation_(job.tolerance / 2),
      angular_(machine_.has_angular_errors()),
      modal_(start_of(profile_)),
      in_(job.setup),
      out_(job.setup),
      tcp_(machine_.control.tcp),
      axes_(axes),
      frame_reported_(static_cast<std::size_t>(in_.frames.count())),
      packet_(plan, axes),
      bend_(field_.turning_bend()) {
  modal_.tcp_codes = machine_.control.codes;
  in_.turns = out_.turns = job.setup.start_turns;
  for (unsigned k = 0; k < 3; ++k) {
    if (axes.rotary[k] >= 0) needed_ |= 8u << k;
  }
  known_ = needed_ & ~7u;
  for (std::size_t k = 0; k < 3; ++k) {
    if (!job.setup.start[k]) continue;
    known_ |= 1u << k;
    in_.m[static_cast<Eigen::Index>(k)] = out_.m[static_cast<Eigen::Index>(k)] = *job.setup.start[k];
  }
  stand(in_.turns, out_.turns);
  change_tool(job.setup.loaded_tool);
}

void Rewriter::refuse(const Word& word, const char* code, std::string message, const char* why,
                      const char* fix) {
  findings_.add(Severity::error, code, number_, block_->text, word.begin,
                static_cast<std::size_t>(word.end - word.begin), std::move(message), why, fix);
}

void Rewriter::refuse_block(const char* code, std::string message, const char* why, const char* fix) {
  const std::size_t begin = block_->count > 0 ? block_->words[0].begin : 0;
  findings_.add(Severity::error, code, number_, block_->text, begin,
                std::max<std::size_t>(1, block_->words_end - begin), std::move(message), why, fix);
}

void Rewriter::warn(const char* code, std::string message, const char* why, const char* fix) {
  findings_.add(Severity::warning, code, number_, block_->text, 0, 1, std::move(message), why, fix);
}

int Rewriter::decimals_of(int written) const {
  // What the control resolves; where it reads finer numbers, a word that has more digits keeps them.
  const int profile = modal_.inch ? profile_.numbers.decimals_inch : profile_.numbers.decimals_mm;
  return profile_.numbers.finer ? std::max(profile, written) : profile;
}

double Rewriter::half_digit(int decimals) const {
  static constexpr std::array<double, 10> kHalf = {0.5,    0.5e-1, 0.5e-2, 0.5e-3, 0.5e-4,
                                                   0.5e-5, 0.5e-6, 0.5e-7, 0.5e-8, 0.5e-9};
  // the last part keeps a tie from being written again and again
  return kHalf[static_cast<std::size_t>(std::min(decimals, 9))] * (1 + 1e-6);
}

/// How far words rounded to the control's increment may take an arc from its places: its ends and its centre
/// are rounded. Finer digits are within the tolerance.
double Rewriter::digit_room() const {
  const double half = half_digit(decimals_of(nullptr)) * modal_.unit();
  return half > kFineDigits ? 2 * std::numbers::sqrt2 * half : 0;
}

void Rewriter::end_line(std::string& out, std::size_t begin) {
  check_length(out.size() - begin);
  out += eol_;
  ++report_.lines_out;
}

void Rewriter::check_length(std::size_t bytes) {
  if (bytes <= profile_.text.block_bytes) return;
  refuse_block("E-LINELEN",
               fmt::format("the compensated block would have {} bytes, {} is the limit", bytes,
                           profile_.text.block_bytes),
               "the control refuses longer lines", "shorten the comment, or break the block into two");
}

void Rewriter::add_block(std::string_view words, std::string_view eol, std::string& tail) {
  const std::size_t begin = tail.size();
  tail += block_->slash_text();
  tail += words.substr(block_->slash ? 0 : 1);
  check_length(tail.size() - begin);
  tail += eol;
  ++report_.lines_out;
}

void Rewriter::pass(std::string& out) {
  out += block_->text;
  out += eol_;
  ++report_.lines_out;
}

void Rewriter::write_header(std::string& out) {
  header_written_ = true;
  const std::string_view eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  for (const auto& line : job_.header) {
    out += line;
    out += eol;
    ++report_.lines_out;
  }
}

// A program number may begin with ':' instead of O: it is read as one, and copied as it stands.
std::optional<BlockError> Rewriter::read_line(std::string_view bytes, Block& block) {
  if (profile_.text.conversational) return read_klartext_block(bytes, profile_, klartext_, block);
  if (profile_.text.names) return read_named_block(bytes, profile_, block);
  const bool numbered_skip = profile_.text.skip == Profile::Skip::numbered;
  if (!profile_.text.colon || any_block_) return read_block(bytes, block, numbered_skip);
  const std::size_t first = bytes.find_first_not_of(" \t");
  if (first == std::string_view::npos || bytes[first] != ':') return read_block(bytes, block, numbered_skip);
  std::string spelled(bytes);
  spelled[first] = 'O';
  auto error = read_block(spelled, block, numbered_skip);
  block.text = without_eol(bytes);
  block.eol = bytes.substr(block.text.size());
  return error;
}

void Rewriter::lines(std::span<const std::string_view> texts, std::uint64_t number, bool too_long,
                     std::string& out) {
  while (!texts.empty()) {
    std::size_t done = too_long ? 0 : lane(texts, number, out);
    if (done == 0) {
      // Behind this line a run of plain ones may begin.
      const bool run_next =
          packet_.usable() && texts.size() > 1 && texts[1].find_first_of("ABC") != std::string_view::npos;
      done = run_next ? 1 : std::min(texts.size(), kRows);
      block_lines(texts.first(done), number, too_long, out);
    }
    texts = texts.subspan(done);
    number += done;
  }
}

void Rewriter::block_lines(std::span<const std::string_view> texts, std::uint64_t number, bool too_long,
                           std::string& out) {
  // What a colon means depends on whether there was a block before.
  if (profile_.text.colon && !any_block_ && texts.size() > 1) {
    block_lines(texts.first(1), number, false, out);
    return block_lines(texts.subspan(1), number + 1, too_long, out);
  }
  std::array<std::optional<BlockError>, kRows> errors;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::string_view bytes = texts[i];
    // A tape leader of NUL bytes is not part of the first line's text.
    if (number + i == 1) {
      const std::size_t leader = std::min(bytes.find_first_not_of('\0'), bytes.size());
      out += bytes.substr(0, leader);
      bytes.remove_prefix(leader);
    }
    errors[i] = read_line(bytes, blocks_[i]);
  }
  look_ahead(texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) {
    number_ = number + i;
    block_ = &blocks_[i];
    std::string& to = holds_ ? held_ : out;
    const std::size_t begin = to.size();
    line_begin_ = holds_ ? 0 : begin;
    line(errors[i], too_long, to);
    if (profile_.text.conversational) count_blocks(begin, to);
    if (profile_.text.conversational || profile_.text.names) keep_held(begin, to, out);
  }
}

// Where the axes will be sent if nothing but these words tells: what else the blocks say may lead elsewhere.
void Rewriter::look_ahead(std::size_t rows) {
  if (rows < 2 || (known_ & 7u) != 7u || !in_.frames.known()) return;
  std::array<Vec3, kRows> places;
  std::size_t count = 0;
  Vec3 p = in_.p(), m = in_.m;
  for (std::size_t i = 0; i < rows; ++i) {
    unsigned named = 0;
    for (int w = 0; w < blocks_[i].count; ++w) {
      const Word& word = blocks_[i].words[static_cast<std::size_t>(w)];
      const int k = word.letter - 'X';
      if (k < 0 || k > 2) continue;
      const bool distance = modal_.incremental || (blocks_[i].increments & 1u << k) != 0;
      p[k] = word.value * modal_.unit() + (distance ? p[k] : 0.0);
      named |= 1u << k;
    }
    if (named == 0) continue;
    const Vec3 there = in_.frames.to_machine(p);
    for (int k = 0; k < 3; ++k)
      if ((named & (1u << k)) != 0) m[k] = there[k];
    places[count++] = m;
  }
  field_.look_ahead(std::span(places).first(count), approach_);
}

// Blocks that we have added are counted, and all behind them.
void Rewriter::count_blocks(std::size_t begin, std::string& out) {
  if (block_->continues || std::exchange(counted_, false)) return;
  if (block_numbers_.renumber(block_->text, begin, out)) return;
  findings_.add(Severity::error, "E-BLOCK", number_, block_->text, 0, 1,
                "the number of the block is not above that of the block before",
                "blocks that are added must be counted", "let the control number the program anew");
}

void Rewriter::line(const std::optional<BlockError>& error, bool too_long, std::string& out) {
  eol_ = block_->eol;
  if (file_eol_.empty()) file_eol_ = std::string(eol_);
  if (held_pole_ && block_->pole != Block::Pole::used) release_pole(out);
  if (ended_ && !too_long) return pass_behind_end(out);  // the control does not read on
  if (motion_lost_ && error && error->code == std::string_view("E-EXPR")) return;  // said already
  if (too_long || error) {
    motion_lost_ = motion_lost_ || (error && error->code == std::string_view("E-GCODE"));
    findings_.add(
        error.value_or(BlockError{"E-LINELEN", kMaxBlockBytes, 1, "the line is longer than 64 KiB",
                                  "the control refuses such lines", "break the block into several"}),
        number_, block_->text);
    return;
  }
  if (number_ <= kMarkLines && block_->text.find(kMark) != std::string_view::npos) {
    report_.compensated_input = true;
    findings_.add(Severity::error, "E-COMPENSATED", number_, block_->text, block_->text.find(kMark),
                  kMark.size(), "this program has been compensated already",
                  "compensating twice doubles the correction", "use the original program");
  }
  const bool plain_text = block_->text.size() <= profile_.text.block_bytes && !block_->has_semicolon &&
                          !block_->percent && !block_->slash;
  if (!plain_text && !read_text_rules()) return;
  if (block_->percent) {
    if (!percent_seen_ && !any_block_) {
      percent_first_ = percent_seen_ = true;
    } else if (percent_first_) {
      ended_ = true;
    } else {
      refuse_block("E-CHAR", "'%' in a program that does not start with '%'",
                   "the control stops reading here", "remove it");
    }
    return pass(out);
  }
  const bool program_number = profile_.text.program_number && !any_block_ && block_->count == 1 &&
                              block_->words[0].letter == 'O' && !block_->slash;
  const bool begins = profile_.text.conversational && !any_block_;  // BEGIN PGM: the header follows it
  if (!header_written_ && block_->count > 0 && !program_number && !begins) write_header(out);
  if (block_->count > 0) any_block_ = true;
  if (program_number) {
    pass(out);
    return write_header(out);
  }
  if (block_->cycle != 0) return profile_.text.conversational ? define_hole(out) : define_bracket(out);
  if (spline_ && block_->count == 0) return hold_line(false);
  if (block_->tool_data) return define_tool(out);
  if (block_->flow != Block::Flow::none) return follow_label(out);
  if (block_->count == 0) return pass(out);
  if (block_->pole == Block::Pole::set) return set_pole();
  if (block_->slash && profile_.text.skip != Profile::Skip::ignored) {
    using BlockDelete = ControlSetup::BlockDelete;
    if (job_.setup.block_delete == BlockDelete::on) return spline_ ? hold_line(false) : pass(out);
    if (job_.setup.block_delete == BlockDelete::unknown) {
      refuse_block("E-SKIP", "a block with '/' runs or not, as the operator's switch stands",
                   "the corrections that follow depend on it",
                   "state it: --block-delete on (skipped) or off (executed)");
      return;
    }
  }
  if (!read_known_instruction()) return;
  if (instruction_.turns_axes && !turn_words_allowed()) return;
  if (instruction_.directs_tool && !vector_words_allowed()) return;
  execute(out);
  if (begins) write_header(out);
  if (instruction_.flow != 0) [[unlikely]]
    follow_flow();
}

// After a code that was refused its words are not judged, line by line: what they belong to is not known.
bool Rewriter::read_known_instruction() {
  if (!motion_lost_) [[likely]] {
    const bool known = read_instruction(profile_, *block_, modal_, number_, findings_, instruction_);
    motion_lost_ = !known && findings_.list().back().code == "E-GCODE";
    return known;
  }
  ProgramFindings here(job_.name);
  const bool good = read_instruction(profile_, *block_, modal_, number_, here, instruction_);
  motion_lost_ = !instruction_.states_motion;
  findings_.add_all_but(here, motion_lost_ ? "E-WORD" : "");
  return good;
}

void Rewriter::execute(std::string& out) {
  apply_modal(*block_, instruction_, modal_);
  if (profile_.text.conversational && feeds_by_tool_call(profile_, *block_)) modal_.has_feed = false;
  if (profile_.numbers.integer_words != Profile::IntegerWords::units || !profile_.numbers.finer) {
    if (!settle_numbers()) return;
  }
  edit_.reset(*block_);
  if (number_ == job_.trace_line) move_text_ = "no motion: copied";
  const Vec3 start = in_.m;
  const std::size_t out_begin = out.size();
  bool done = false;
  const bool moves = instruction_.motion >= 0 && instruction_.motion != 800 &&
                     (instruction_.moves_axes || is_arc(instruction_.motion) ||
                      is_cycle(instruction_.motion) || instruction_.motion == kNurbs);
  if (profile_.text.conversational ? !call_hole(moves) : !call_bracket(moves)) return;
  if (instruction_.plain || (settings() && zero_group(out, done) && !done)) {
    if (!is_cycle(modal_.motion)) cycle_.code = -1;
    if (spline_ && instruction_.motion != kNurbs) {
      refuse_block("E-SPLINE", "a block inside a curve that has not all its knots yet",
                   "the control stops, or makes another curve", "complete the knots of the curve before it");
      ended_ = instruction_.ends;
      return abandon_spline();
    }
    if (moves) {
      const bool sure =
          modal_.stated && !offset_doubtful_ && instruction_.zero != 530 && !instruction_.tool_change;
      if (!sure && !may_move()) return;
      ++report_.blocks.motion;
      motion(out);
    } else {
      const std::size_t begin = out.size();
      edit_.append_to(out);
      end_line(out, begin);
      if (edit_.changed()) ++report_.blocks.rewritten;
    }
    if (drills_) drill(out, out_begin);
  }
  if ((instruction_.smooths || instruction_.path_control) && !smoothing_said_) warn_of_smoothing();
  if (instruction_.ends) ended_ = true;
  if (number_ == job_.trace_line) {
    BlockTrace trace;
    const int active = in_.frames.active();
    trace.frame = work_offset_label(active);
    if (const auto& work = in_.frames.work_offset(active))
      trace.frame_origin = Vec3(work->origin[0], work->origin[1], work->origin[2]);
    trace.g92 = in_.frames.g92();
    trace.tool_offset = in_.frames.tool_offset();
    trace.datum = field_.datum();
    trace.tool = loaded_tool_;
    trace.gauge_length = gauge_;
    trace.start = start;
    trace.end = in_.m;
    trace.correction = out_.m - in_.m;
    trace.decision = move_text_;
    trace.before = std::string(block_->text);
    trace.after = out.substr(out_begin);
    report_.trace = std::move(trace);
  }
}

void Rewriter::finish(std::string& out) {
  release_hole(out);
  if (spline_)
    refuse_block("E-SPLINE", "the program ends inside a curve", "the control stops there",
                 "complete the knots of the curve");
  if (held_pole_) {
    const std::size_t begin = out.size();
    release_pole(out);
    count_blocks(begin, out);
  }
  if (!header_written_ && !job_.header.empty() && !findings_.refused()) write_header(out);
  if (!ended_ && any_block_) {
    findings_.add(Severity::warning, "W-END", 0, "", 0, 1,
                  "the program ends without M2, M30 or a closing '%'",
                  profile_.title + " runs it to here and then reports an error", "end it with M2");
  }
  if (!findings_.refused()) report_.sensitivity = sensitivity();
}

}  // namespace abbe
