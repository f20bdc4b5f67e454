#include "abbe/program/modal.h"

#include <fmt/format.h>

#include <cmath>

namespace abbe {
namespace {

/// Modal groups of RS274/NGC; `unknown` codes are refused.
enum Group : std::uint8_t {
  unknown, zero, motion, plane, distance, arc_distance, feed_mode, units, cutter, tool_length, retract, wcs, path, spindle, lathe,
  kGroups
};

struct CodeGroup {
  GCode code;
  Group group;
};
constexpr CodeGroup kKnown[] = {
    {40, zero},       {100, zero},     {280, zero},     {300, zero},     {520, zero},     {530, zero},
    {920, zero},      {921, zero},     {922, zero},     {923, zero},     {0, motion},     {10, motion},
    {20, motion},     {30, motion},    {800, motion},   {730, motion},   {740, motion},   {810, motion},
    {820, motion},    {830, motion},   {840, motion},   {850, motion},   {860, motion},   {890, motion},
    {170, plane},     {180, plane},    {190, plane},    {900, distance}, {910, distance}, {901, arc_distance},
    {911, arc_distance}, {930, feed_mode}, {940, feed_mode}, {950, feed_mode}, {200, units}, {210, units},
    {400, cutter},    {430, tool_length}, {431, tool_length}, {490, tool_length}, {980, retract}, {990, retract},
    {540, wcs},       {550, wcs},      {560, wcs},      {570, wcs},      {580, wcs},      {590, wcs},
    {591, wcs},       {592, wcs},      {593, wcs},      {610, path},     {611, path},     {640, path},
    {960, spindle},   {970, spindle},  {80, lathe}};

constexpr std::array<Group, 1000> make_groups() {
  std::array<Group, 1000> groups{};
  for (const auto& known : kKnown) groups[static_cast<std::size_t>(known.code)] = known.group;
  return groups;
}
constexpr std::array<Group, 1000> kGroupOf = make_groups();

constexpr std::uint32_t bit(char letter) { return 1u << (letter - 'A'); }
constexpr std::uint32_t kAxisBits = bit('X') | bit('Y') | bit('Z');
constexpr std::uint32_t kTurnBits = bit('A') | bit('B') | bit('C');
constexpr std::uint32_t kCentreBits = bit('I') | bit('J') | bit('K');
constexpr std::uint32_t kValueBits = kAxisBits | kTurnBits | kCentreBits | bit('R') | bit('P') | bit('Q') | bit('L') | bit('F') |
                                     bit('S') | bit('T') | bit('H') | bit('D') | bit('E') | bit('N');

/// Refusals of codes that users meet, with what to do.
struct Advice {
  GCode from, to;
  const char* code;
  const char* why;
  const char* fix;
};
constexpr Advice kAdvice[] = {
    {410, 423, "E-CUTCOM", "the control offsets the path by the cutter radius, so the correction must be made there",
     "post the tool-centre path (cutter compensation in the CAM system)"},
    {50, 53, "E-GCODE", "the control generates the spline itself", "post lines and arcs"},
    {330, 331, "E-GCODE", "the motion follows the spindle", "keep threads out of the compensated program"},
    {382, 389, "E-GCODE", "probing reads positions of the compensated machine", "probe in a program of its own"},
    {281, 281, "E-GCODE", "it stores the present position in the control", "store reference positions outside the program"},
    {301, 301, "E-GCODE", "it stores the present position in the control", "store reference positions outside the program"},
    {432, 432, "E-GCODE", "added tool offsets are not tracked", "use G43 H or G43.1"},
    {70, 70, "E-GCODE", "lathe diameters count twice", "lathe programs are not covered"},
    {680, 683, "E-FRAME", "a rotated or tilted frame is not part of the LinuxCNC dialect", "post in the machine's frame"},
    {434, 435, "E-TCP", "the machine file does not say that this code switches tool centre point control",
     "declare it: [control] codes = { \"G43.4\" = \"tcp\", \"G49\" = \"axis\" }"},
};

void refuse(ProgramFindings& findings, std::uint64_t line, const Block& block, const Word& word, const char* code,
            std::string message, const char* why, const char* fix) {
  findings.add(Severity::error, code, line, block.text, word.begin, static_cast<std::size_t>(word.end - word.begin),
               std::move(message), why, fix);
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

/// Notes a code that switches tool centre point control; false: it is none.
bool note_tcp(const ModalState& state, char letter, std::optional<int> code, Instruction& out) {
  for (const TcpCode& known : state.tcp_codes) {
    if (!code || known.letter != letter || known.code != *code) continue;
    out.tcp = known.on ? 1 : 0;
    return true;
  }
  return false;
}

bool note_g(const Block& block, const Word& word, const ModalState& state, std::uint64_t line, ProgramFindings& findings,
            Instruction& out, std::array<bool, kGroups>& seen) {
  const auto code = scaled(word.value, 10, 1000);
  const bool switches = note_tcp(state, 'G', code, out);
  // G43.4 H applies a tool length like G43
  const bool tcp_length = switches && *code == 434;
  const Group group = tcp_length ? tool_length : code ? kGroupOf[static_cast<std::size_t>(*code)] : unknown;
  if (switches && group == unknown) return true;
  if (group == unknown) {
    for (const auto& advice : kAdvice) {
      if (code && *code >= advice.from && *code <= advice.to) {
        refuse(findings, line, block, word, advice.code, spelled(block, word) + " cannot be compensated", advice.why, advice.fix);
        return false;
      }
    }
    refuse(findings, line, block, word, "E-GCODE", spelled(block, word) + " is not known to the LinuxCNC profile",
           "a code that is not understood may move the machine or change a frame", "remove it, or post without it");
    return false;
  }
  if (group == motion && seen[group] && (*code == 800 || out.motion == 800)) {
    if (*code != 800) out.motion = *code;  // G80 beside another motion code: that one counts
    return true;
  }
  if (seen[group]) {
    refuse(findings, line, block, word, "E-BLOCK", spelled(block, word) + ": a second code of the same group in one block",
           "which of them holds is not defined", "split the block");
    return false;
  }
  seen[group] = true;
  switch (group) {
    case zero: out.zero = *code; break;
    case motion: out.motion = *code; out.states_motion = true; break;
    case plane: out.plane = *code; break;
    case distance: out.distance = *code; break;
    case arc_distance: out.arc_distance = *code; break;
    case feed_mode: out.feed_mode = *code; break;
    case units: out.units = *code; break;
    case tool_length: out.tool_length = tcp_length ? 430 : *code; break;
    case retract: out.retract = *code; break;
    case wcs: out.wcs = *code; break;
    default: break;
  }
  return true;
}

bool note_m(const Block& block, const Word& word, const ModalState& state, std::uint64_t line, ProgramFindings& findings,
            Instruction& out) {
  if (note_tcp(state, 'M', scaled(word.value, 10, 10000), out)) return true;
  const auto code = scaled(word.value, 1, 1000);
  const int m = code.value_or(-1);
  const bool known = m == 0 || m == 1 || m == 2 || m == 30 || m == 60 || (m >= 3 && m <= 9) || m == 19 ||
                     (m >= 48 && m <= 53) || m == 61 || (m >= 62 && m <= 68);
  if (!known) {
    refuse(findings, line, block, word, "E-MCODE", spelled(block, word) + " is not known to the LinuxCNC profile",
           m == 98 || m == 99 ? "a subprogram may be called at several places that need different corrections"
                              : "an M code that is not understood may move the machine or call a program",
           m == 98 || m == 99 ? "post without subprograms" : "remove it, or run it outside the compensated program");
    return false;
  }
  if (m == 6) out.tool_change = true;
  if (m == 61) out.set_tool = true;
  if (stops_after_motion(m)) {
    out.stops = true;
    out.ends = out.ends || m == 2 || m == 30;
  } else if (m != 6) {
    out.other_m = true;
  }
  return true;
}

/// The value letters that the codes of this block use.
std::uint32_t used_letters(const Instruction& in, const Block& block) {
  std::uint32_t used = bit('N') | bit('F') | bit('S') | bit('T');
  switch (in.zero) {
    case 40: used |= bit('P'); break;
    case 100: used |= bit('L') | bit('P') | bit('R') | kAxisBits; break;
    case 280: case 300: case 530: used |= kAxisBits | kTurnBits; break;
    case 520: case 920: used |= kAxisBits; break;
    default: break;
  }
  if (in.tool_length == 430) used |= bit('H');
  if (in.tool_length == 431) used |= kAxisBits;
  if (in.motion == 0 || in.motion == 10) used |= kAxisBits | kTurnBits;
  if (is_arc(in.motion)) used |= kAxisBits | kTurnBits | kCentreBits | bit('R') | bit('P');
  if (is_cycle(in.motion)) used |= kAxisBits | bit('R') | bit('L');
  if (in.motion == 730 || in.motion == 830) used |= bit('Q');
  if (in.motion == 740 || in.motion == 820 || in.motion == 840 || in.motion == 860 || in.motion == 890) used |= bit('P');
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    if (word.letter != 'G' && word.letter != 'M') continue;
    if (word.letter == 'G' && word.value == 64) used |= bit('P') | bit('Q');
    if (word.letter == 'G' && word.value == 96) used |= bit('D');
    if (word.letter == 'M' && word.value == 61) used |= bit('Q');
    if (word.letter == 'M' && word.value == 66) used |= bit('P') | bit('E') | bit('L') | bit('Q');
    if (word.letter == 'M' && (word.value == 67 || word.value == 68)) used |= bit('E') | bit('Q');
    if (word.letter == 'M' && word.value >= 62 && word.value <= 65) used |= bit('P');
    if (word.letter == 'M' && (word.value == 19 || (word.value >= 50 && word.value <= 53))) used |= bit('R') | bit('P') | bit('Q');
    if (word.letter == 'M' && word.value >= 3 && word.value <= 5) used |= bit('D');
  }
  return used;
}

bool axis_words_taken(GCode zero_code) {
  return zero_code == 100 || zero_code == 280 || zero_code == 300 || zero_code == 520 || zero_code == 920;
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
    refuse(findings, line, block, word, code, spelled(block, word) + ": subprograms and flow control are not followed",
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
  if (state.motion != 0 && state.motion != 10) return false;
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

bool stops_after_motion(int m_code) { return m_code <= 2 || m_code == 30 || m_code == 60; }

bool read_instruction(const Block& block, const ModalState& state, std::uint64_t line, ProgramFindings& findings,
                      Instruction& out) {
  if (is_plain_line(block, state, out)) return true;
  out = kNothing;
  std::array<bool, kGroups> seen{};
  bool good = true;
  std::uint32_t present = 0;
  for (int i = 0; i < block.count; ++i) {
    const Word& word = block.words[static_cast<std::size_t>(i)];
    if (word.letter == 'G') {
      good = note_g(block, word, state, line, findings, out, seen) && good;
    } else if (word.letter == 'M') {
      good = note_m(block, word, state, line, findings, out) && good;
    } else if (!(kValueBits & bit(word.letter))) {
      refuse_letter(findings, line, block, word);
      good = false;
    } else if (present & bit(word.letter)) {
      refuse(findings, line, block, word, "E-BLOCK", fmt::format("{} stands twice in one block", word.letter),
             "which of them holds is not defined", "keep one");
      good = false;
    } else {
      present |= bit(word.letter);
      out.word[static_cast<std::size_t>(word.letter - 'A')] = static_cast<std::int8_t>(i);
    }
  }
  if (!good) return false;
  out.turns_axes = (present & kTurnBits) != 0;
  out.moves_axes = out.turns_axes || (present & kAxisBits) != 0;
  const bool taken = axis_words_taken(out.zero) || out.tool_length == 431;
  const auto whole_block = [&](const char* code, std::string message, const char* why, const char* fix) {
    findings.add(Severity::error, code, line, block.text, block.count > 0 ? block.words[0].begin : 0, block.text.size(),
                 std::move(message), why, fix);
    return false;
  };
  if (taken && out.states_motion && out.motion != 800) {
    return whole_block("E-BLOCK", "a motion code and a code that uses the axis words stand in one block",
                       "which of them the axis words belong to is not defined", "split the block");
  }
  if (taken && out.tool_length == 431 && axis_words_taken(out.zero)) {
    return whole_block("E-BLOCK", "two codes of this block use the axis words", "which of them they belong to is not defined",
                       "split the block");
  }
  const bool centre_alone = is_arc(state.motion) && (present & kCentreBits) != 0;  // a full circle
  if (!out.states_motion && (out.moves_axes || centre_alone) && !taken) out.motion = state.motion;
  if (out.motion == 800 && out.moves_axes && !taken) {
    return whole_block("E-MODE", "axis words without a motion in force",
                       "the control refuses them, or moves in a way the program does not state", "write G0, G1, G2 or G3");
  }
  if (out.zero == 530 && out.motion != 0 && out.motion != 10) {
    if (!out.states_motion && (state.motion == 0 || state.motion == 10)) out.motion = state.motion;
    else return whole_block("E-G53", "G53 without G0 or G1", "only lines can be commanded in machine coordinates", "write G53 G0 or G53 G1");
  }
  const std::uint32_t unused = present & ~used_letters(out, block);
  if (unused != 0) {
    for (int i = 0; i < block.count; ++i) {
      const Word& word = block.words[static_cast<std::size_t>(i)];
      if (word.letter == 'G' || word.letter == 'M' || !(unused & bit(word.letter))) continue;
      refuse(findings, line, block, word, "E-WORD", spelled(block, word) + ": no code of this block uses this word",
             "the control refuses it, or gives it a meaning that is not known here", "remove it, or add the code it belongs to");
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
  if (const Word* f = in.find(block, 'F')) {
    state.feed = f->value;
    state.has_feed = true;
  }
  if (in.plane >= 0) state.plane = in.plane == 170 ? Plane::xy : in.plane == 180 ? Plane::zx : Plane::yz;
  if (in.units >= 0) state.inch = in.units == 200;
  if (in.distance >= 0) state.incremental = in.distance == 910;
  if (in.arc_distance >= 0) state.absolute_centre = in.arc_distance == 901;
  if (in.retract >= 0) state.retract_to_r = in.retract == 990;
  if (in.states_motion) state.motion = in.motion;
}

}  // namespace abbe
