#include "abbe/program/modal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "abbe/program/meaning_role.h"

namespace abbe {
namespace {

using namespace roles;

/// Of Instruction::wcs while its P word has not been looked at.
constexpr int kNumbered = -2;

constexpr std::uint32_t bit(char letter) { return 1u << (letter - 'A'); }
constexpr std::uint32_t kAxisBits = bit('X') | bit('Y') | bit('Z');
constexpr std::uint32_t kTurnBits = bit('A') | bit('B') | bit('C');
constexpr char kTurnLetters[] = {'A', 'B', 'C'};
constexpr std::uint32_t kCentreBits = bit('I') | bit('J') | bit('K');
constexpr std::uint32_t kValueBits = kAxisBits | kTurnBits | kCentreBits | bit('R') | bit('P') | bit('Q') |
                                     bit('L') | bit('F') | bit('S') | bit('T') | bit('H') | bit('D') |
                                     bit('E') | bit('N') | letter_set(kVectorLetters);

void refuse(ProgramFindings& findings, std::uint64_t line, const Block& block, const Word& word,
            const char* code, std::string message, const char* why, const char* fix) {
  findings.add(Severity::error, code, line, block.text, word.begin,
               static_cast<std::size_t>(word.end - word.begin), std::move(message), why, fix);
}

std::string spelled(const Block& block, const Word& word) {
  return std::string(block.text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin)));
}

std::optional<int> scaled(double value, double factor, int limit) {
  const double v = value * factor;
  const double n = std::nearbyint(v);
  if (std::abs(v - n) > 1e-9 || n < 0 || n >= limit) return std::nullopt;
  return static_cast<int>(n);
}

/// What the profile says of a G or M word; `unknown` for numbers that are no code.
const CodeUse& use_of(const Profile& profile, const Word& word) {
  static constexpr CodeUse kUnknown{};
  const auto code = word.letter == 'G'
                        ? scaled(word.value, 10, static_cast<int>(Profile::kGCodes + Profile::kKeywords))
                        : scaled(word.value, 1, static_cast<int>(Profile::kMCodes));
  if (!code) return kUnknown;
  return word.letter == 'G' ? profile.g[static_cast<std::size_t>(*code)]
                            : profile.m[static_cast<std::size_t>(*code)];
}

/// The machine's control switches tool centre point control with this word: its code times ten, 0 and 1 for
/// off and on; nullptr: it does not.
const TcpCode* tcp_code(const ModalState& state, const Word& word) {
  const auto code = scaled(word.value, 10, 10000);
  for (const TcpCode& known : state.tcp_codes) {
    if (code && known.letter == word.letter && known.code == *code) return &known;
  }
  return nullptr;
}

/// One block on its way to an Instruction.
struct Reading {
  const Profile& profile;
  const Block& block;
  std::uint64_t line;
  ProgramFindings& findings;
  Instruction& out;
  const ModalState& state;
  std::array<bool, kGroups> seen{};
  LetterSet used = letter_set("NFST");  ///< letters that some code of the block uses
  bool dwell_x = false;                 ///< X is the time of a dwell

  void refuse(const Word& word, const char* code, std::string message, std::string why,
              std::string fix) const {
    findings.add(Severity::error, code, line, block.text, word.begin,
                 static_cast<std::size_t>(word.end - word.begin), std::move(message), std::move(why),
                 std::move(fix));
  }

  bool refuse_unknown(const Word& word, const CodeUse& use) const {
    const char* usual = word.letter == 'G' ? "E-GCODE" : "E-MCODE";
    if (use.refusal == 0) {
      refuse(word, usual, spelled(block, word) + " is not known to the " + profile.title + " profile",
             word.letter == 'G' ? "a code that is not understood may move the machine or change a frame"
                                : "an M code that is not understood may move the machine or call a program",
             word.letter == 'G' ? "remove it, or post without it"
                                : "remove it, or run it outside the compensated program");
      return false;
    }
    const CodeRefusal& refusal = profile.refusals[use.refusal - 1U];
    refuse(word, refusal.error.empty() ? usual : refusal.error.c_str(),
           spelled(block, word) + " cannot be compensated", refusal.why, refusal.fix);
    return false;
  }

  void switch_tcp(const TcpCode& code) const {
    out.tcp = code.on ? 1 : 0;
    out.vectors = code.vectors;
  }
  bool note_g(const Word& word);
  bool note_m(const Word& word);
  void put_in_force(const Role& role, const CodeUse& use);
};

bool Reading::note_g(const Word& word) {
  static constexpr CodeUse kTcpLength{Meaning::tool_length, false, 0, 0, letter_set("H")};
  const TcpCode* tcp = tcp_code(state, word);
  if (tcp != nullptr) switch_tcp(*tcp);
  // G43.4 H and G43.5 H apply a tool length like G43
  const bool with_length = tcp != nullptr && (tcp->code == 434 || tcp->code == 435);
  const CodeUse& use = with_length ? kTcpLength : use_of(profile, word);
  if (use.meaning == Meaning::unknown) return tcp != nullptr || refuse_unknown(word, use);
  const Role role = role_of(use.meaning);
  used |= use.words;
  if (role.group == motion && seen[motion] && (role.code == 800 || out.motion == 800)) {
    if (role.code != 800) put_in_force(role, use);  // G80 beside another motion code: that one counts
    return true;
  }
  if (role.group != loose && seen[role.group]) {
    refuse(word, "E-BLOCK", spelled(block, word) + ": a second code of the same group in one block",
           "which of them holds is not defined", "split the block");
    return false;
  }
  seen[role.group] = true;
  put_in_force(role, use);
  return true;
}

void Reading::put_in_force(const Role& role, const CodeUse& use) {
  switch (role.group) {
    case zero:
      out.zero = role.code;
      dwell_x = use.meaning == Meaning::dwell && (use.words & bit('X')) != 0;
      out.dwell_by_f = use.meaning == Meaning::dwell && (use.words & bit('F')) != 0;
      break;
    case motion:
      out.motion = role.code;
      out.states_motion = true;
      out.motion_words = use.words;
      break;
    case plane:
      out.plane = role.code;
      break;
    case distance:
      out.distance = role.code;
      break;
    case arc_distance:
      out.arc_distance = role.code;
      break;
    case feed_mode:
      out.feed_mode = role.code;
      break;
    case units:
      out.units = role.code;
      break;
    case cutter:
      out.cutter = role.code;
      break;
    case tool_length:
      out.tool_length = role.code;
      break;
    case retract:
      out.retract = role.code;
      break;
    case wcs:
      out.wcs = use.meaning == Meaning::work_offset ? use.number - 1 : kNumbered;
      break;
    case rotation:
      out.frame = static_cast<FrameChange>(role.code);
      break;
    case path:
      out.path_control = true;
      break;
    case turn_frame:
      out.turn_codes.frame = static_cast<TurnCodes::Frame>(role.code);
      break;
    case turn_way:
      out.turn_codes.way = static_cast<TurnCodes::Way>(role.code);
      break;
    case loose:
      out.smooths = out.smooths || use.meaning == Meaning::smoothing;
      out.ends_call = out.ends_call || use.meaning == Meaning::modal_call;
      out.ends_scale = out.ends_scale || use.meaning == Meaning::scale_off;
      out.ends_mirror = out.ends_mirror || use.meaning == Meaning::mirror_off;
      out.exact_stop = out.exact_stop || use.meaning == Meaning::exact_stop_once;
      if (use.meaning == Meaning::tcp_on || use.meaning == Meaning::tcp_off)
        out.tcp = use.meaning == Meaning::tcp_on ? 1 : 0;
      break;
    default:
      break;
  }
}

bool Reading::note_m(const Word& word) {
  if (const TcpCode* tcp = tcp_code(state, word)) {
    switch_tcp(*tcp);
    return true;
  }
  const CodeUse& use = use_of(profile, word);
  if (use.meaning == Meaning::unknown) return refuse_unknown(word, use);
  used |= use.words;
  out.tool_change = out.tool_change || use.meaning == Meaning::tool_change;
  out.set_tool = out.set_tool || use.meaning == Meaning::set_tool;
  out.ends = out.ends || use.meaning == Meaning::end;
  if (use.meaning == Meaning::call_subprogram) out.flow = 1;
  if (use.meaning == Meaning::end_subprogram) out.flow = 2;
  if (use.meaning == Meaning::shortest_way) out.way = 1;
  if (use.meaning == Meaning::straight_way) out.way = 2;
  out.retracts = out.retracts || use.meaning == Meaning::retract_tool;
  if (use.meaning == Meaning::cycle_call) out.cycle_call = 1;
  if (use.meaning == Meaning::cycle_call_modal) out.cycle_call = 2;
  out.after = out.after || use.after;
  return true;
}

bool axis_words_taken(GCode zero_code) {
  return zero_code == 100 || zero_code == 280 || zero_code == 300 || (zero_code >= 520 && zero_code <= 522) ||
         (zero_code >= 683 && zero_code <= 686) || zero_code == 920;
}

/// The axis words of the block are of the frame.
bool takes_words(FrameChange frame) {
  return frame == FrameChange::turn || frame == FrameChange::scale || frame == FrameChange::mirror ||
         frame == FrameChange::plane || frame == FrameChange::datum_mirror ||
         frame == FrameChange::datum_scale;
}

/// TRANS, ATRANS, ROT, AROT, SCALE, ASCALE, MIRROR, AMIRROR.
bool makes_frame(GCode zero_code) {
  return zero_code == 521 || zero_code == 522 || (zero_code >= 681 && zero_code <= 686);
}

const char* letter_code(char letter) {
  if (letter == 'U' || letter == 'V' || letter == 'W') return "E-AXIS";
  return letter == 'O' ? "E-OWORD" : "E-WORD";
}

void refuse_letter(ProgramFindings& findings, std::uint64_t line, const Block& block, const Word& word) {
  const char* code = letter_code(word.letter);
  const std::string_view kind = code;
  if (kind == "E-AXIS") {
    refuse(findings, line, block, word, code, spelled(block, word) + ": only X Y Z and A B C are compensated",
           "a further axis moves the tool in a way that is not followed", "post for X Y Z and A B C");
  } else if (kind == "E-OWORD") {
    refuse(findings, line, block, word, code,
           spelled(block, word) + ": subprograms and flow control are not followed",
           "where the axes go depends on how the program runs", "post the program without loops and calls");
  } else {
    refuse(findings, line, block, word, code, spelled(block, word) + ": unknown word",
           "a word that is not understood may move the machine", "remove it, or post without it");
  }
}

}  // namespace

namespace {

constexpr Instruction nothing() {
  Instruction instruction;
  for (auto& index : instruction.word) index = -1;
  return instruction;
}
constexpr Instruction kNothing = nothing();

/// Most blocks: a line or rapid in force, its axes, perhaps a feed. False: `out` means nothing.
bool is_plain_line(const Block& block, const ModalState& state, Instruction& out) {
  if ((state.motion != 0 && state.motion != 10) || !state.stated || block.places != 0) return false;
  out = kNothing;
  std::uint32_t present = 0;
  for (int i = 0; i < block.count; ++i) {
    const char letter = block.words[static_cast<std::size_t>(i)].letter;
    if ((bit(letter) & (kAxisBits | bit('F')) & ~present) == 0) return false;
    present |= bit(letter);
    out.word[static_cast<std::size_t>(letter - 'A')] = static_cast<std::int8_t>(i);
  }
  if ((present & kAxisBits) == 0) return false;
  out.moves_axes = out.plain = true;
  out.motion = state.motion;
  return true;
}

}  // namespace

bool acts_after_motion(const Profile& profile, const Word& word) {
  if (word.letter != 'G' && word.letter != 'M') return false;
  const CodeUse& use = use_of(profile, word);
  return use.after || use.meaning == Meaning::exact_stop_once;
}

bool all_stated(const ModalState& state) {
  return state.units_stated && state.distance_stated && state.offset_stated && state.edge_stated;
}

ModalState start_of(const Profile& profile) {
  ModalState state;
  state.inch = profile.start.units == Profile::Units::imperial;
  state.incremental = profile.start.distance == Profile::Distance::incremental;
  state.retract_to_r = profile.start.retract_to_r;
  state.units_stated = profile.start.units != Profile::Units::stated;
  state.distance_stated = profile.start.distance != Profile::Distance::stated;
  state.offset_stated = profile.start.first_offset;
  state.edges = profile.tools.edges != Profile::Tools::Edges::none;
  state.edge_stated = !state.edges;
  state.stated = all_stated(state);
  return state;
}

namespace {

/// Sorts all words. False: some were refused.
bool sort_words(Reading& reading) {
  const Block& block = reading.block;
  LetterSet present = 0;
  bool good = true;
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    if (word.letter == 'G') {
      good = reading.note_g(word) && good;
    } else if (word.letter == 'M') {
      good = reading.note_m(word) && good;
    } else if (!(kValueBits & bit(word.letter))) {
      refuse_letter(reading.findings, reading.line, block, word);
      good = false;
    } else if (present & bit(word.letter)) {
      reading.refuse(word, "E-BLOCK", fmt::format("{} stands twice in one block", word.letter),
                     "which of them holds is not defined", "keep one");
      good = false;
    } else {
      present |= bit(word.letter);
      reading.out.word[static_cast<std::size_t>(word.letter - 'A')] = static_cast<std::int8_t>(i);
    }
  }
  return good;
}

/// D of controls whose tools have edges: the offset of the tool in the spindle, or none. False: refused.
bool read_edge(Reading& reading) {
  using Edges = Profile::Tools::Edges;
  const Edges edges = reading.profile.tools.edges;
  const Word* d = edges == Edges::none ? nullptr : reading.out.find(reading.block, 'D');
  if (d == nullptr) return true;
  reading.used |= bit('D');
  reading.out.tool_length = d->value == 0 ? 490 : 430;
  if (edges == Edges::table || d->value == 0 || d->value == 1) return true;
  reading.refuse(
      *d, "E-TOOL", fmt::format("{}: only the first edge of a tool is known", spelled(reading.block, *d)),
      "the offsets of further edges are in no tool table",
      "use D1; where D numbers name rows of the table, set tools.edges = \"table\" in a profile of your own");
  return false;
}

/// The further work offset that P names. False: refused.
bool number_work_offset(Reading& reading) {
  Instruction& out = reading.out;
  if (out.wcs != kNumbered) return true;
  const Word* p = out.find(reading.block, 'P');
  const auto number = p == nullptr ? std::nullopt : scaled(p->value, 1, reading.profile.offsets.further + 1);
  if (number && *number >= 1) {
    out.wcs = 8 + *number;
    return true;
  }
  reading.findings.add(
      Severity::error, "E-WCS", reading.line, reading.block.text, p ? p->begin : 0, 1,
      fmt::format("the number of the work offset is not a P from 1 to {}", reading.profile.offsets.further),
      "the frame of what follows is not known", "correct the P word");
  return false;
}

/// The three words that state the tool's direction: those with names of their own (A3=), or I J K of a line
/// or rapid where the control's mode says so. False: refused.
bool read_direction(Reading& reading, GCode motion) {
  Instruction& out = reading.out;
  const bool straight = motion == 0 || motion == 10;
  const bool by_centre_words = straight && (out.tcp >= 0 ? out.vectors : reading.state.vectors);
  const Word* first = nullptr;
  int count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto named = static_cast<std::size_t>(kVectorLetters[k] - 'A'),
               centre = static_cast<std::size_t>("IJK"[k] - 'A');
    out.direction[k] = out.word[out.word[named] >= 0 || !by_centre_words ? named : centre];
    if (out.direction[k] < 0) continue;
    first = &reading.block.words[static_cast<std::size_t>(out.direction[k])];
    ++count;
  }
  if (first == nullptr) return true;
  out.directs_tool = true;
  const bool angles = std::any_of(std::begin(kTurnLetters), std::end(kTurnLetters),
                                  [&](char letter) { return out.find(reading.block, letter) != nullptr; });
  const char* wrong = count < 3   ? "the tool's direction without all of its three components"
                      : angles    ? "the tool's direction beside words of rotary axes"
                      : !straight ? "the tool's direction in a block that is no line and no rapid"
                                  : nullptr;
  if (wrong == nullptr) return true;
  reading.refuse(*first, "E-VECTOR", wrong, "where the rotary axes go is not sure",
                 "post all three components, in blocks of G0 and G1");
  return false;
}

}  // namespace

bool read_instruction(const Profile& profile, const Block& block, const ModalState& state, std::uint64_t line,
                      ProgramFindings& findings, Instruction& out) {
  if (is_plain_line(block, state, out)) return true;
  out = kNothing;
  Reading reading{profile, block, line, findings, out, state};
  if (!sort_words(reading) || !number_work_offset(reading) || !read_edge(reading)) return false;
  LetterSet present = 0;
  for (std::size_t i = 0; i < out.word.size(); ++i) present |= out.word[i] >= 0 ? LetterSet{1} << i : 0;
  out.after = out.after || out.exact_stop;
  out.turns_axes = (present & kTurnBits) != 0;
  if (!read_direction(reading, out.states_motion ? out.motion : state.motion)) return false;
  out.moves_axes = out.turns_axes || out.directs_tool || (present & kAxisBits) != 0;
  const bool beside_motion = profile.home_beside_motion && (out.zero == 280 || out.zero == 300);
  const bool taken = axis_words_taken(out.zero) || out.tool_length == 431 || reading.dwell_x ||
                     takes_words(out.frame) || (out.ends_mirror && out.moves_axes);
  const auto whole_block = [&](const char* code, std::string message, const char* why, const char* fix) {
    findings.add(Severity::error, code, line, block.text, block.count > 0 ? block.words[0].begin : 0,
                 block.text.size(), std::move(message), why, fix);
    return false;
  };
  if (taken && out.states_motion && out.motion != 800 && !beside_motion) {
    return whole_block("E-BLOCK", "a motion code and a code that uses the axis words stand in one block",
                       "which of them the axis words belong to is not defined", "split the block");
  }
  if (taken && out.tool_length == 431 && axis_words_taken(out.zero)) {
    return whole_block("E-BLOCK", "two codes of this block use the axis words",
                       "which of them they belong to is not defined", "split the block");
  }
  const bool beside_frame = out.states_motion || out.zero >= 0 || out.wcs >= 0 || out.turns_axes ||
                            (out.moves_axes && !takes_words(out.frame));
  const bool switches_tools = out.frame >= FrameChange::scale &&
                              (out.tool_length >= 0 || out.tcp >= 0 || out.tool_change || out.set_tool);
  if (out.frame != FrameChange::none && (beside_frame || switches_tools)) {
    return whole_block("E-BLOCK", "a rotation, scale, mirror or plane together with other codes or words",
                       "in which order the control takes them is not sure", "give it a block of its own");
  }
  const bool alone = !out.states_motion && out.wcs < 0 && out.tool_length < 0 && out.tcp < 0;
  if (makes_frame(out.zero) && (!alone || ((out.zero == 681 || out.zero == 682) && out.moves_axes))) {
    return whole_block("E-BLOCK", "a frame together with other codes or words",
                       "in which order the control takes them is not sure",
                       "give the frame a block of its own");
  }
  const bool incremental = out.distance >= 0 ? out.distance == 910 : state.incremental;
  const bool stated = profile.text.names && (block.increments | block.places) != 0;
  if (stated && (taken || makes_frame(out.zero) || out.zero == 530 || (block.places != 0 && incremental))) {
    return whole_block("E-BLOCK", "AC() or IC() in a block that is no plain motion, or AC() in G91",
                       "what the word means there is not sure", "give the block G90 and its words places");
  }
  if (out.smooths && out.moves_axes) {
    return whole_block("E-BLOCK", "axis words beside a smoothing code",
                       "whether they move the machine is not known", "split the block");
  }
  const bool centre_alone = is_arc(state.motion) && (present & kCentreBits) != 0;  // a full circle
  const bool knot_alone = state.motion == kNurbs && (present & bit('K')) != 0;
  if (!out.states_motion && (out.moves_axes || centre_alone || knot_alone) && !taken) {
    out.motion = state.motion;
    out.motion_words = state.motion_words;
  }
  if (out.motion == 800 && out.moves_axes && !taken) {
    return whole_block("E-MODE", "axis words without a motion in force",
                       "the control refuses them, or moves in a way the program does not state",
                       "write G0, G1, G2 or G3");
  }
  if (out.zero == 530 && out.motion != 0 && out.motion != 10) {
    if (out.states_motion || (state.motion != 0 && state.motion != 10)) {
      return whole_block("E-G53", "G53 without G0 or G1",
                         "only lines can be commanded in machine coordinates", "write G53 G0 or G53 G1");
    }
    out.motion = state.motion;
    out.motion_words = state.motion_words;
  }
  if (beside_motion && taken && (present & kAxisBits) == 0) {
    return whole_block("E-BLOCK", "a reference return without an axis",
                       "which axes go there depends on the control", "write G28 G91 Z0");
  }
  LetterSet unused = present & ~(reading.used | (out.states_motion ? 0 : out.motion_words));
  for (const std::int8_t index : out.direction)
    if (index >= 0) unused &= ~bit(block.words[static_cast<std::size_t>(index)].letter);
  if (unused != 0) {
    for (int i = 0; i < block.count; ++i) {
      const Word& word = block.words[static_cast<std::size_t>(i)];
      if (word.letter == 'G' || word.letter == 'M' || !(unused & bit(word.letter))) continue;
      reading.refuse(word, "E-WORD", spelled(block, word) + ": no code of this block uses this word",
                     "the control refuses it, or gives it a meaning that is not known here",
                     "remove it, or add the code it belongs to");
    }
    return false;
  }
  return true;
}

void apply_modal(const Block& block, const Instruction& in, ModalState& state) {
  if (in.plain) {
    if (const Word* f = in.find(block, 'F')) {
      state.feed = f->value;
      state.has_feed = true;
    }
    return;
  }
  if (in.feed_mode >= 0) {
    if (in.feed_mode != state.feed_mode) state.has_feed = false;
    state.feed_mode = in.feed_mode;
  }
  if (const Word* f = in.find(block, 'F'); f != nullptr && !in.dwell_by_f) {
    state.feed = f->value;
    state.has_feed = true;
  }
  if (in.plane >= 0) state.plane = in.plane == 170 ? Plane::xy : in.plane == 180 ? Plane::zx : Plane::yz;
  if (in.units >= 0) state.inch = in.units == 200;
  if (in.tcp >= 0) state.vectors = in.vectors;
  if (in.turn_codes.frame != TurnCodes::Frame::unsaid) state.turn_codes.frame = in.turn_codes.frame;
  if (in.turn_codes.way != TurnCodes::Way::unsaid) state.turn_codes.way = in.turn_codes.way;
  if (in.distance >= 0) state.incremental = in.distance == 910;
  if (in.arc_distance >= 0) state.absolute_centre = in.arc_distance == 901;
  if (in.retract >= 0) state.retract_to_r = in.retract == 990;
  state.units_stated = state.units_stated || in.units >= 0;
  state.distance_stated = state.distance_stated || in.distance >= 0;
  if (state.edges) state.edge_stated = in.tool_length >= 0 || (state.edge_stated && !in.tool_change);
  state.offset_stated = state.offset_stated || in.wcs >= 0;
  state.stated = all_stated(state);
  if (in.states_motion) {
    state.motion = in.motion;
    state.motion_words = in.motion_words;
  }
}

}  // namespace abbe
