// Drilling cycles of conversational programs. A block defines the cycle, others call it where they leave the
// tool. The control makes the motions itself, so a hole is shifted as a whole by the correction at its
// mid-depth: sideways by the block that goes there, along Z by Q203, the place of the surface.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

constexpr int kOnce = 1, kFromHereOn = 2;
constexpr int kBoring = 202, kBackBoring = 204;
// A definition may be followed by so much before it is called the first time, bytes.
constexpr std::size_t kMostHeld = std::size_t{1} << 16;
constexpr double kNoShift = 1e-9;  // mm: rounding of a correction that is none

/// Places at the edge of a hole that are looked at.
constexpr double kDiagonal = 0.70710678118654752;
constexpr std::array<std::array<double, 2>, 9> kAround = {{{0, 0},
                                                           {1, 0},
                                                           {-1, 0},
                                                           {0, 1},
                                                           {0, -1},
                                                           {kDiagonal, kDiagonal},
                                                           {kDiagonal, -kDiagonal},
                                                           {-kDiagonal, kDiagonal},
                                                           {-kDiagonal, -kDiagonal}}};

}  // namespace

// A line of a definition. It is written where it stands; what it says counts when it is called.
void Rewriter::define_hole(std::string& out) {
  if (block_->defines) {
    if (hole_.modal)
      refuse_block("E-CYCLE", "a cycle is defined while M89 calls one behind every block",
                   "whether the control goes on calling is not sure", "end M89 with M99 before");
    hole_ = Hole{};
    hole_.definition.cycle = block_->cycle;
    const std::size_t begin = block_->text.find("CYCL");
    hole_.definition.title = std::string(block_->text.substr(begin, block_->words_end - begin));
    // One inside a subprogram is written elsewhere; what is held is then written as it is.
    if (depth_ == 0) held_from_ = holds_ ? out.size() : 0;
    holds_ = depth_ == 0 && !has_parts(block_->cycle);
  }
  if (hole_.definition.cycle != block_->cycle)
    return refuse_block("E-CYCLE", "a line of a cycle without its first one",
                        "the control takes the lines of a cycle together", "write them from .0 on");
  for (int i = 0; i < block_->count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Word& word = block_->words[k];
    const int parameter = block_->parameters[k];
    if (hole_.definition.find(parameter) != nullptr)
      refuse(word, "E-CYCLE", fmt::format("Q{} twice in one cycle", parameter),
             "which of them holds is not sure", "keep one");
    hole_.definition.words.push_back(
        {parameter, word.value, word.decimals,
         std::string(block_->text.substr(word.number, static_cast<std::size_t>(word.end - word.number)))});
    if (parameter == kSurface) hole_.surface_out = word.value;
  }
  hole_.sure = false;
  pass(out);
}

// While a definition is held everything is written behind it.
void Rewriter::keep_held(std::size_t begin, std::string& to, std::string& out) {
  if (holds_ && &to == &out) {
    held_ = out.substr(begin);
    out.resize(begin);
  }
  if (held_.size() > kMostHeld) holds_ = false;
  if (!holds_ && !held_.empty()) release_hole(out);
}

void Rewriter::release_hole(std::string& out) {
  if (hole_.bracket && !held_surface_.empty()) {
    held_.replace(held_from_, held_spelled_, held_surface_);
    held_surface_.clear();
    ++report_.blocks.rewritten;
  }
  for (std::size_t at = held_from_; !held_surface_.empty() && at < held_.size();) {
    const std::size_t end = std::min(held_.find('\n', at), held_.size());
    const std::string_view words =
        std::string_view(held_).substr(at, std::min(end, held_.find(';', at)) - at);
    if (const std::size_t found = words.find("Q203"); found != std::string_view::npos) {
      const std::size_t number = held_.find_first_not_of(" \t=", at + found + 4);
      held_.replace(number, held_spelled_, held_surface_);
      ++report_.blocks.rewritten;
      break;
    }
    at = end + 1;
  }
  out += held_;
  held_.clear();
  held_surface_.clear();
  holds_ = false;
}

// Does the block call the cycle? False: refused.
bool Rewriter::call_hole(bool moves) {
  drills_ = false;
  const int call = instruction_.cycle_call;
  const bool positions = moves || instruction_.zero == 280;
  if (call == 0 && (!hole_.modal || !positions)) return true;
  if (!call_allowed(moves)) return false;
  if (call == kFromHereOn) hole_.modal = true;
  if (call == kOnce) hole_.modal = false;
  drills_ = true;
  return true;
}

bool Rewriter::call_allowed(bool moves) {
  const auto bad = [&](const char* code, std::string what, const char* why, const char* fix) {
    refuse_block(code, std::move(what), why, fix);
    return false;
  };
  if (!modal_.units_stated)
    return bad("E-START", "a cycle before the program says inches or millimetres", "its numbers mean nothing",
               "begin with BEGIN PGM .. MM");
  if (hole_.definition.cycle == 0)
    return bad("E-CYCLE", "a cycle is called before one is defined", "what the control does is not known",
               "put its CYCL DEF before the call");
  if (!hole_.sure) {
    const HoleAnswer answer = span_of(hole_.definition);
    if (!answer.span)
      return bad("E-CYCLE", answer.message,
                 "where the hole is, or where the tool stands behind it, is not sure",
                 has_parts(hole_.definition.cycle)
                     ? "write all lines of the cycle, with a set-up clearance that is not negative and a "
                       "negative depth"
                     : "write the cycle with Q200, a negative Q201, Q203 and Q204 (0, or not below Q200)");
    hole_.span = *answer.span;
    hole_.sure = true;
  }
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const bool call = word.letter == 'M' && (word.value == 99 || word.value == 89);
    if (!call && acts_after_motion(profile_, word))
      return bad("E-AUX", "a cycle is called beside a code that acts behind the motion",
                 "whether it acts before or behind the cycle is not sure",
                 "give the code a block of its own");
  }
  if (instruction_.zero == 280 || (moves && is_arc(instruction_.motion)))
    return bad("E-CYCLE", "a cycle is called beside an arc or M91", "where the hole is, is not sure",
               "call it beside L X.. Y.. FMAX");
  const bool on_plane = plane_ == PlaneStage::stands;
  if (frame_kind_ == FrameChange::scale)
    return bad("E-CYCLE", "a cycle is called while a scale is in force",
               "which of its numbers are scaled is not sure",
               "post the holes as L blocks, or scale in the CAM system");
  const int cycle = hole_.definition.cycle;
  if (frame_kind_ == FrameChange::mirror && (cycle == kBoring || cycle == kBackBoring))
    return bad("E-CYCLE", "a bore is called in a mirrored frame",
               "to which side the tool is moved away is not sure",
               "post the hole as L blocks, or mirror in the CAM system");
  if (plane_ != PlaneStage::none && !on_plane)
    return bad("E-CYCLE", "a cycle is called on a plane before X, Y and Z have been commanded there",
               "where the hole is, is not known", "go over the hole first: L X.. Y.. FMAX, L Z.. FMAX");
  if ((tcp_ && !on_plane) || instruction_.tcp == 1)
    return bad("E-TCP", "a cycle is called while tool centre point control is on",
               "along which axis the control drills then is not sure", "switch it off before (M129)");
  const bool repeats = instruction_.cycle_call == 0 || instruction_.cycle_call == kFromHereOn || hole_.modal;
  const bool to_hole =
      moves && instruction_.motion == 0 && (axis_word(0) != nullptr || axis_word(1) != nullptr);
  if (repeats && !to_hole)
    return bad("E-CYCLE", "M89 beside a block that is not L X.. Y.. FMAX",
               "whether the control drills behind it is not sure", "call each hole with M99");
  return true;
}

// A height of the hole for a tool that stands at this place of the program, mm.
double Rewriter::hole_height(double height, const Vec3& p) const {
  return height * modal_.unit() + (hole_.span.from_start ? p.z() : 0.0);
}

// How far the output's hole is from the original's as things stand, mm.
Vec3 Rewriter::present_shift() const {
  const Vec3 stands = out_.p() - in_.p();
  if (hole_.span.from_start) return stands;
  const double surface = hole_.definition.find(kSurface)->value;
  return {stands.x(), stands.y(), (hole_.surface_out - surface) * modal_.unit()};
}

// The correction at mid-depth below (or above) a place, on the way down. Nothing: refused.
std::optional<Vec3> Rewriter::hole_shift(const Vec3& m) {
  Vec3 middle = in_.frames.to_program(m);
  middle.z() = hole_height((hole_.span.top + hole_.span.bottom) / 2, middle);
  std::array<signed char, 3> approach = approach_;
  if (job_.reversal) approach[2] = -1;
  const auto c = correction_at(in_.frames.to_machine(middle), 0, approach);
  if (!c) return std::nullopt;
  return in_.frames.vector_to_program(*c);
}

// How far the correction is from `shift` where the cycle moves, mm. Nothing: refused.
std::optional<double> Rewriter::left_in_hole(const Vec3& shift) {
  const double unit = modal_.unit();
  const std::size_t places = hole_.span.aside > 0 ? kAround.size() : 1;
  double left = 0;
  for (std::size_t i = 0; i < places; ++i) {
    for (const double height : {hole_.span.top, hole_.span.bottom}) {
      Vec3 p = in_.p() + hole_.span.aside * unit * Vec3(kAround[i][0], kAround[i][1], 0);
      p.z() = hole_height(height, p);
      const auto c = correction_at(in_.frames.to_machine(p), 0, approach_);
      if (!c) return std::nullopt;
      left = std::max(left, (in_.frames.vector_to_program(*c) - shift).norm());
    }
  }
  return left;
}

// The rapid to a hole ends over it as the hole needs it; its height is its own unless the hole counts from
// it.
bool Rewriter::lead_to_hole(const Vec3& m, Vec3& correction) {
  const auto shift = hole_shift(m);
  if (!shift) return false;
  Vec3 own = in_.frames.vector_to_program(correction);
  own.head<2>() = shift->head<2>();
  if (hole_.span.from_start) own = *shift;
  correction = in_.frames.vector_to_machine(own);
  return true;
}

// The cycle runs where the block has left the tool. What it needs before that goes in front of the block.
void Rewriter::drill(std::string& out, std::size_t begin) {
  if (findings_.refused()) return;
  if (known_ != needed_ || !in_.frames.known()) {
    refuse_block("E-POS", "a cycle where the position of an axis is not known",
                 "the correction depends on all axes",
                 "begin with rapid moves that name X, Y and Z, or give the machine's position with --start");
    return;
  }
  refresh_datum();
  follow(Vec3(0, 0, -1), 4);
  const auto wanted = hole_shift(in_.m);
  if (!wanted) return;
  Vec3 shift = present_shift();
  std::string before;
  if (!drill_at(*wanted, shift, before)) return;
  const bool own_height = !hole_.bracket && !hole_.span.from_start;  // in the definition
  const bool first_to_differ = own_height && hole_.modal && !hole_.each && wanted->norm() > kNoShift;
  if (first_to_differ && instruction_.cycle_call == 0 && !before.empty()) {
    refuse_block("E-CYCLE", "a hole behind M89 needs another height than those before it",
                 "it needs a definition of its own, which may end M89", "call each hole with M99");
    return;
  }
  hole_.each = hole_.each || first_to_differ;
  if (hole_.each && hole_.modal && !call_once(out, begin)) return;
  if (hole_.bracket) withheld_ &= ~4U;
  out.insert(begin, before);
  report_.lines_out += static_cast<std::uint64_t>(std::count(before.begin(), before.end(), '\n'));
  Vec3 end = in_.p();
  end.z() = hole_height(hole_.span.clear, end);
  in_.m = in_.frames.to_machine(end);
  out_.m = out_.frames.to_machine(end + shift);
  stands_ = approach_;
  follow(Vec3(0, 0, 1), 4);
  last_correction_.reset();
  start_corrected_ = true;
}

// A definition for a single hole may put an end to M89, so every block calls for itself. False: refused.
bool Rewriter::call_once(std::string& out, std::size_t begin) {
  std::size_t end = std::min(out.find(';', begin), out.find_last_not_of(" \t\r\n") + 1);
  while (end > begin && (out[end - 1] == ' ' || out[end - 1] == '\t')) --end;
  const std::size_t always = out.find("M89", begin);
  if (always < end) {
    out.replace(always, 3, "M99");
  } else if (instruction_.cycle_call == kFromHereOn) {
    refuse_block("E-CYCLE", "M89 is spelled another way",
                 "it becomes M99, because its holes may need cycles of their own", "write M89");
    return false;
  } else {
    out.insert(end, " M99");
  }
  check_length(out.size() - begin);
  return true;
}

// Makes `shift` of the hole good enough: as things stand, or with another Q203 or place. False: refused.
bool Rewriter::drill_at(const Vec3& wanted, Vec3& shift, std::string& before) {
  auto left = left_in_hole(shift);
  if (!left) return false;
  const bool may_go = hole_.bracket ? !hole_.modal && modal_.motion == 0 && !modal_.incremental
                                    : instruction_.motion < 0 || !instruction_.moves_axes;
  if (*left > interpolation_ || holds_) {
    if (!hole_.span.from_start) {
      set_surface(wanted.z() / modal_.unit(), before);
      shift = present_shift();
      left = left_in_hole(shift);
    }
    if (*left > interpolation_ && may_go) {
      step_aside(wanted, shift, before);
      left = left_in_hole(shift);
    }
  }
  report_.cycle_residual = std::max(report_.cycle_residual, *left);
  if (*left > job_.tolerance) {
    refuse_block("E-CYCLE", fmt::format("the correction changes by {:.2f} um inside this cycle", *left / um),
                 "the control makes the motions of the cycle itself, so it can only be shifted as a whole",
                 hole_.bracket
                     ? "go to the hole with G0 X.. Y.. behind MCALL, post it as G0 and G1, or allow more "
                       "with --tolerance-um"
                     : "go to the hole with L X.. Y.. FMAX M99, post it as L, or allow more with "
                       "--tolerance-um");
    return false;
  }
  if (number_ == job_.trace_line)
    move_text_ = fmt::format("cycle: shifted as a whole by the correction at mid-depth; {:.2f} um are left",
                             *left / um);
  return true;
}

std::string Rewriter::spelled_surface(double& number) const {
  const int decimals = std::max(decimals_of(nullptr), hole_.definition.find(kSurface)->decimals);
  std::string text;
  number = append_number(text, number, decimals, block_->style);
  return text;
}

// Q203 of the output becomes that of the original plus the shift, program units: in the definition while it
// is not written, else in another one.
void Rewriter::set_surface(double shift, std::string& before) {
  if (hole_.bracket) return set_levels(shift, before);
  double number = hole_.definition.find(kSurface)->value + shift;
  const bool same = std::abs(number - hole_.surface_out) <= half_digit(decimals_of(nullptr));
  if (!same) {
    const std::string text = spelled_surface(number);
    if (holds_) {
      held_surface_ = text;
      held_spelled_ = hole_.definition.find(kSurface)->spelled.size();
    } else {
      append_definition(before, text);
    }
    hole_.surface_out = number;
  }
  holds_ = false;  // what follows needs it as it stands now
}

// The definition again, one Q word a line, with another Q203.
void Rewriter::append_definition(std::string& to, const std::string& surface) {
  const std::string_view eol = file_eol_.empty() ? std::string_view("\n") : std::string_view(file_eol_);
  std::string_view title = hole_.definition.title;
  title = title.substr(0, title.find_last_not_of(" \t~") + 1);
  to += title;
  for (const HoleDefinition::Word& word : hole_.definition.words) {
    to += " ~";
    to += eol;
    to += fmt::format(" Q{}={}", word.parameter, word.parameter == kSurface ? surface : word.spelled);
  }
  to += eol;
}

// A rapid over the hole in front of a call that does not go there itself; in Z where the hole counts from it.
void Rewriter::step_aside(const Vec3& wanted, Vec3& shift, std::string& before) {
  const double unit = modal_.unit();
  const int decimals = decimals_of(nullptr);
  const Vec3 to = in_.p() + wanted, from = out_.p();
  Vec3 p_out = from;
  std::string words;
  for (int k = 0; k < (hole_.span.from_start ? 3 : 2); ++k) {
    if (std::abs(to[k] - from[k]) <= half_digit(decimals) * unit) continue;
    words += fmt::format(" {}", "XYZ"[k]);
    p_out[k] = append_number(words, to[k] / unit, decimals, block_->style) * unit;
    shift[k] = p_out[k] - in_.p()[k];
  }
  if (words.empty()) return;
  before += hole_.bracket ? "G0" + words : "L" + words + " FMAX";
  before += file_eol_.empty() ? std::string("\n") : file_eol_;
  out_.m = out_.frames.to_machine(p_out);
}

}  // namespace abbe
