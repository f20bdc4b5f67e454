#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// Longer moves are always looked into, mm.
constexpr double kShort = 5;
// Smaller changes of a reading are rounding of double arithmetic, mm.
constexpr double kSameReading = 1e-9;

std::optional<int> whole(const Word* word) {
  if (!word || word->value < 0 || word->value > 1e6 || word->value != std::floor(word->value))
    return std::nullopt;
  return static_cast<int>(word->value);
}

}  // namespace

bool Rewriter::change_tool(std::optional<int> number) {
  loaded_tool_ = number;
  const GaugeLength gauge = gauge_length(job_.setup, machine_, number);
  gauge_ = gauge.length;
  const Tool tool = tool_of(machine_, gauge.length);
  field_.set_tool(tool);
  packet_.set_tool(tool);
  bend_ = field_.turning_bend();
  packet_.set_rotations(bend_.rotations());
  short_enough_ = std::max(2 * interpolation_ / job_.max_gradient,
                           std::min(kShort, field_.straight_length(interpolation_)));
  last_correction_.reset();
  datum_dirty_ = true;
  if (gauge.touch_off && angular_) {
    refuse_block("E-GAUGE",
                 fmt::format("tool {}: the table's Z offset {:.4f} is a touch-off value, not a gauge length",
                             *number, job_.setup.tools.at(*number).offset[2]),
                 "the machine's angular errors act through the tool's length",
                 "give the gauge length: --gauge T3=112.4, or gauge=112.4 in the tool table's comment");
    return false;
  }
  if (gauge.source == GaugeLength::Source::machine_file && number && angular_) {
    warn("W-GAUGE",
         fmt::format("tool {} has no known gauge length: the machine file's {:.4f} mm is used", *number,
                     gauge.length),
         "the machine's angular errors act through the tool's length", "give it: --gauge T3=112.4");
  }
  return true;
}

bool Rewriter::settings() {
  const GCode zero = instruction_.zero;
  const bool ends_turn = (zero == 521 || zero == 681 || zero == 683 || zero == 685) &&
                         plane_ == PlaneStage::none;  // they replace other frames, no plane
  if ((in_.frames.turned() || in_.frames.placed()) &&
      ((zero >= 0 && zero != 40 && !ends_turn) || instruction_.wcs >= 0 || modal_.plane != Plane::xy)) {
    refuse_block("E-ROTATION",
                 "a frame, plane or reference position is chosen while a rotation, scale, mirror or tilted "
                 "plane is in force",
                 "controls refuse it, or differ in what it means",
                 profile_.text.conversational
                     ? "end it before (PLANE RESET, ROT+0, 8.1 without axes, 26.1 X1 Y1 Z1)"
                     : "end it before (G69, G50, G50.1)");
    return false;
  }
  if (const Word* t = instruction_.find(*block_, 'T')) {
    selected_tool_ = tool_number(*t);
    if (!selected_tool_) {
      refuse(*t, "E-TOOL", "the tool is no whole number, and its name is not in the tool table",
             "the tool in the spindle is not known otherwise",
             "correct it, or put name=\"..\" behind ; in its line of the tool table (--tools)");
      return false;
    }
  }
  if (instruction_.set_tool) {
    const auto number = whole(instruction_.find(*block_, 'Q'));
    if (!number) {
      refuse_block("E-TOOL", "M61 without a tool number Q", "the tool in the spindle is not known",
                   "write M61 Q1");
      return false;
    }
    if (!change_tool(number)) return false;
  }
  if (instruction_.tool_change) {
    if (!selected_tool_) {
      refuse_block("E-TOOL", "M6 without a tool selected by T", "the tool in the spindle is not known",
                   "write T1 M6");
      return false;
    }
    // The control may have moved to its place for changing tools, and it stays there.
    if (!job_.setup.tool_change_keeps_place) {
      // a rotary axis that no block has commanded yet is where it was from the start
      known_ = needed_ & ~7u & ~(turned_ << 3);
      withheld_ = 0;
      start_corrected_ = false;
    }
    if (!change_tool(selected_tool_)) return false;
  }
  if (instruction_.tool_length >= 0 && !tool_length()) return false;
  if ((instruction_.retracts || instruction_.way != 0) && !retract()) return false;
  if (instruction_.tcp == 1 && !machine_.control.declared) {
    refuse_block("E-TCP", "tool centre point control is switched on",
                 "the machine file does not say where the control takes its rotary axes to be",
                 "declare [control] in the machine file");
    return false;
  }
  if (instruction_.tcp == 0 && tcp_ && instruction_.moves_axes && profile_.text.conversational) {
    refuse_block("E-TCP", "tool centre point control is switched off beside a motion",
                 "this control does so when the motion is done", "write the code into a block of its own");
    return false;
  }
  if (instruction_.tcp >= 0 && in_.frames.placed()) {
    refuse_block("E-TCP", "tool centre point control is switched in a tilted, scaled or mirrored frame",
                 "what its points then are is not followed",
                 profile_.text.conversational ? "end the frame before (PLANE RESET, ROT+0, 8.1 without axes)"
                                              : "end the frame before (G69, G50, G50.1)");
    return false;
  }
  if (instruction_.tcp >= 0) switch_tcp(instruction_.tcp == 1);
  if (instruction_.wcs >= 0 && !choose_work_offset()) return false;
  if (profile_.tools.follows_plane && modal_.plane != Plane::xy && in_.frames.tool_offset() != Vec3::Zero()) {
    refuse_block("E-TOOL", "another plane than G17 with a tool offset",
                 "the control lets the length act along the axis across the plane",
                 "write D0 before, or post in G17");
    return false;
  }
  if (!end_stretch() || !change_frame()) return false;
  if (const Word* d = instruction_.find(*block_, 'D');
      d && profile_.tools.edges != Profile::Tools::Edges::none)
    edge_ = whole(d).value_or(-1);
  return (instruction_.cutter < 0 && !cutter_.acts()) || cutter_settings();
}

// M140 leaves the tool somewhere along its axis; M126 and M127 must say what the machine file says.
bool Rewriter::retract() {
  for (int k = 0; k < 3 && instruction_.way != 0; ++k) {
    const Turning needed = instruction_.way == 1 ? Turning::shortest : Turning::linear;
    if (axes_.rotary[static_cast<std::size_t>(k)] < 0 || turning_of(k) == needed) continue;
    refuse_block("E-ROTARY", fmt::format("{} turns another way than the machine file says", "ABC"[k]),
                 "a rotary axis that goes the other way round moves the tool through the part",
                 "state in [control] of the machine file how the axis turns, or leave the code out");
    return false;
  }
  if (!instruction_.retracts) return true;
  if (instruction_.moves_axes) {
    refuse_block("E-MCODE", "M140 beside a motion", "in which order they act is not sure",
                 "give it a block of its own");
    return false;
  }
  // without rotary axes the tool's axis is Z
  const unsigned lost = (needed_ & ~7u) != 0 ? 7u : 4u;
  known_ &= ~lost;
  withheld_ &= ~lost;
  last_correction_.reset();
  start_corrected_ = false;
  return true;
}

// TOOL DEF n L.. R..: read as long as it says what the tool table (or --radius) says. Which of them holds
// depends on whether the control uses its tool table.
void Rewriter::define_tool(std::string& out) {
  const auto number = whole(&block_->words[0]);
  const auto entry = number ? job_.setup.tools.find(*number) : job_.setup.tools.end();
  const Word& length = block_->words[1];
  const bool said = length.letter == 'L';
  const double given = said ? length.value * modal_.unit() : 0;
  if (entry == job_.setup.tools.end()) {
    const std::string fix =
        fmt::format("put it into the tool table (--tools): T{0} P{0} Z{1:g}", number.value_or(0), given);
    refuse_block("E-TOOL", "TOOL DEF of a tool that is in no tool table",
                 "whether the control uses the length of the program depends on its parameters", fix.c_str());
    return;
  }
  if (said && std::abs(given - entry->second.offset[2]) > kSameReading) {
    refuse(
        length, "E-TOOL",
        fmt::format("TOOL DEF says another length than the tool table, {:.4f} mm", entry->second.offset[2]),
        "which of them the control uses depends on its parameters",
        "put the same length into both, or write TOOL DEF n");
    return;
  }
  const auto words = std::span(block_->words).first(static_cast<std::size_t>(block_->count));
  const auto radius = std::find_if(words.begin(), words.end(), [](const Word& w) { return w.letter == 'R'; });
  const auto known = cutter_radius(job_.setup, *number);
  if (radius != words.end() && known && std::abs(radius->value * modal_.unit() - *known) > kSameReading) {
    refuse(*radius, "E-TOOL",
           fmt::format("TOOL DEF says another radius than the tool table or --radius, {:.4f} mm", *known),
           "which of them the control offsets by depends on its parameters",
           "put the same radius into both, or write TOOL DEF n");
    return;
  }
  pass(out);
}

// A number, or the name of a tool of the table. Nothing: to be refused.
std::optional<int> Rewriter::tool_number(const Word& word) const {
  const std::string_view said =
      block_->text.substr(word.number, static_cast<std::size_t>(word.end - word.number));
  const bool named = said.size() >= 2 && said.front() == '"';
  return named ? tool_named(job_.setup.tools, said.substr(1, said.size() - 2)) : whole(&word);
}

bool Rewriter::choose_work_offset() {
  if (!profile_.offsets.keeps_shift && in_.frames.g92() != Vec3::Zero()) {
    refuse_block("E-FRAME", "a work offset is chosen while a shift of the program is in force",
                 "whether the shift outlives it is not sure", "end the shift before (TRANS, CYCL DEF 7)");
    return false;
  }
  const Vec3 reading = in_.p();
  const Turns zeros = in_.frames.turn_offset();
  drop_pole();
  in_.frames.select(instruction_.wcs);
  out_.frames.select(instruction_.wcs);
  note_shift(reading, zeros);
  datum_dirty_ = true;
  return true;
}

// Which axes read something else than before without having moved: X Y Z `reading`, A B C zero at `zeros`.
void Rewriter::note_shift(const Vec3& reading, const Turns& zeros) {
  if (profile_.offsets.increments_sure) return;
  const Vec3 shift = in_.p() - reading;
  const Turns now = in_.frames.turn_offset();
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::abs(shift[static_cast<Eigen::Index>(k)]) > kSameReading) shifted_ |= 1u << k;
    if (now[k] != zeros[k]) shifted_ |= 8u << k;
  }
}

bool Rewriter::tool_length() {
  Vec3 tlo = in_.frames.tool_offset();
  const bool by_edge = profile_.tools.edges == Profile::Tools::Edges::table;
  const Word* number_word = instruction_.find(*block_, by_edge ? 'D' : 'H');
  offset_doubtful_ = false;
  if (profile_.tools.moves && (!axis_word(2) || modal_.incremental)) {
    // Parameters say whether the axis moves at once: it is known again when the program commands it.
    known_ &= ~4u;
    withheld_ &= ~4u;
    last_correction_.reset();
    start_corrected_ = false;
  }
  if (instruction_.tool_length == 490 ||
      (profile_.tools.h_needed && number_word && number_word->value == 0)) {
    tlo.setZero();
  } else if (instruction_.tool_length == 431) {
    for (int k = 0; k < 3; ++k) {
      if (const Word* word = axis_word(k)) tlo[k] = word->value * modal_.unit();
    }
  } else {
    const auto number = number_word               ? whole(number_word)
                        : profile_.tools.h_needed ? std::nullopt
                                                  : loaded_tool_;
    const auto entry = number ? job_.setup.tools.find(*number) : job_.setup.tools.end();
    if (entry == job_.setup.tools.end()) {
      const std::string what = number ? fmt::format("tool {} is in no tool table", *number)
                                      : std::string("G43 without H, or without a tool in the spindle");
      refuse_block("E-TOOL", what, "the control would move by an offset that is not known here",
                   "give the control's tool table: --tools tool.tbl");
      return false;
    }
    tlo = Vec3(entry->second.offset[0], entry->second.offset[1], entry->second.offset[2]);
    if (profile_.tools.z_only) tlo.head<2>().setZero();
    if (instruction_.tool_length == 440) tlo = -tlo;
  }
  // With TCP the control reckons with the new length from where the axes stand. On a plane it acts along the
  // plane's Z: the coordinates stay.
  const bool tcp = tcp_, keeps = plane_ != PlaneStage::none;
  const Vec3 p_in = in_.p(), p_out = out_.p();
  if (!keeps) switch_tcp(false);
  in_.frames.set_tool_offset(tlo);
  out_.frames.set_tool_offset(tlo);
  field_.set_control_length(tlo.z());
  if (keeps) {
    in_.m = in_.frames.to_machine(p_in);
    out_.m = out_.frames.to_machine(p_out);
  } else {
    switch_tcp(tcp);
  }
  datum_dirty_ = true;
  return true;
}

void Rewriter::refresh_datum() {
  if (!datum_dirty_) return;
  datum_dirty_ = false;
  field_.set_datum_point(in_.frames.datum_point());
  last_correction_.reset();
}

bool Rewriter::zero_group(std::string& out, bool& done) {
  const auto copy = [&] {
    pass(out);
    done = true;
    return true;
  };
  switch (instruction_.zero) {
    case 280:
    case 300: {
      // The reference position is the control's own: nothing is known of these axes afterwards.
      unsigned named = 0;
      for (int k = 0; k < 3; ++k) named |= (axis_word(k) ? 1u << k : 0u) | (turn_word_of(k) ? 8u << k : 0u);
      if (named == 0) named = needed_;
      // a point of the tip is a matter of all axes
      if (tcp_) named |= 7u;
      turned_ |= named >> 3;
      offset_doubtful_ = offset_doubtful_ || (profile_.tools.home_cancels && (named & 4u) != 0);
      known_ &= ~named;
      withheld_ &= ~named;
      last_correction_.reset();
      start_corrected_ = false;
      ++report_.blocks.passed;
      move_text_ = "reference position: copied; these axes are unknown until they are commanded again";
      return copy();
    }
    case 520: {
      const Vec3 reading = in_.p();
      drop_pole();
      for (auto* side : {&in_, &out_}) {
        Vec3 g92 = side->frames.g92();
        for (int k = 0; k < 3; ++k) {
          if (const Word* word = axis_word(k)) g92[k] = word->value * modal_.unit();
        }
        side->frames.set_g92(g92);
        side->g92_saved = g92;
      }
      saved_g92_ = true;
      note_shift(reading, in_.frames.turn_offset());
      return copy();
    }
    case 521:
    case 522:
    case 681:
    case 682:
      return make_frame();
    case 683:
    case 684:
    case 685:
    case 686:
      return stretch_frame();
    case 920:
      return set_g92();
    case 921:
    case 922:
      for (auto* side : {&in_, &out_}) {
        if (instruction_.zero == 921) side->g92_saved.setZero();
        side->frames.set_g92(Vec3::Zero());
      }
      saved_g92_ = saved_g92_ || instruction_.zero == 921;
      return true;
    case 923:
      if (!saved_g92_) {
        refuse_block("E-G92", "G92.3 restores an offset from before this program",
                     "its value is not known here", "set it in the program with G92 or G52");
        return false;
      }
      for (auto* side : {&in_, &out_}) side->frames.set_g92(side->g92_saved);
      return true;
    case 100:
      return set_work_offset();
    default:
      return true;
  }
}

// G92 X v at a corrected position becomes v + c: the frame afterwards is the same in both programs.
bool Rewriter::set_g92() {
  if (!instruction_.moves_axes) {
    refuse_block("E-G92", "G92 without an axis word", "it has no meaning", "remove it, or name an axis");
    return false;
  }
  Vec3 g92_in = in_.frames.g92(), g92_out = out_.frames.g92();
  const Vec3 p_in = in_.p(), p_out = out_.p();
  const unsigned needed = in_.frames.rotated() ? 3u : 0u;
  for (int k = 0; k < 3; ++k) {
    const Word* word = axis_word(k);
    if (!word) continue;
    const unsigned need = (1u << k) | (k < 2 ? needed : 0u);
    if ((known_ & need) != need || !in_.frames.known()) {
      refuse(*word, "E-POS", fmt::format("G92 {}: where the axis stands is not known", "XYZ"[k]),
             "the new frame depends on it", "command the axis before, or give its position with --start");
      return false;
    }
    // p + g92 = const: g92' = g92 + p - v
    g92_in[k] += p_in[k] - word->value * modal_.unit();
    const int decimals = decimals_of(word) + 2;
    double v = word->value + (p_out[k] - p_in[k]) / modal_.unit();
    if (std::abs(v - word->value) > half_digit(decimals)) {
      v = edit_.replace(*word, v, decimals);
    } else {
      v = word->value;
    }
    g92_out[k] += p_out[k] - v * modal_.unit();
  }
  in_.frames.set_g92(g92_in);
  out_.frames.set_g92(g92_out);
  in_.g92_saved = g92_in;
  out_.g92_saved = g92_out;
  saved_g92_ = true;
  move_text_ =
      "G92: the present correction is added to its values, so that both programs have the same frame";
  return true;
}

bool Rewriter::set_work_offset() {
  const auto l = whole(instruction_.find(*block_, 'L'));
  const auto p = whole(instruction_.find(*block_, 'P'));
  const Word* rotation = instruction_.find(*block_, 'R');
  if (l != 2 && l != 20) {
    refuse_block("E-G10", "only G10 L2 and G10 L20 are followed",
                 "other forms change the control's tool data", "set tool data outside the program");
    return false;
  }
  // L20 with a further offset's number, where the control has those; else the offset numbered as G54 = 1.
  const bool further = l == 20 && !profile_.offsets.l20_reads;
  const int last = further ? profile_.offsets.further : profile_.offsets.fixed;
  const int first = profile_.offsets.p0_active && !further ? 0 : 1;
  if (!p || *p < first || *p > last || ((l == 2 || further) && modal_.incremental) || (l == 20 && rotation)) {
    refuse_block("E-G10",
                 l == 2 && modal_.incremental ? "G10 L2 in G91" : "this form of G10 is not understood",
                 "the work offset that results is not known", "write G90 G10 L2 P1 X.. Y.. Z..");
    return false;
  }
  const int index = *p == 0 ? in_.frames.active() : further ? kFixedWorkOffsets - 1 + *p : *p - 1;
  const auto known = in_.frames.work_offset(index);
  unsigned named = 0;
  for (int k = 0; k < 3; ++k) named |= axis_word(k) ? 1u << k : 0u;
  if (!known && named != 7) {
    refuse_block("E-WCS", fmt::format("G10 sets part of work offset {} whose other values are not known", *p),
                 "where the axes go depends on them", "give it with --offset, or set X, Y and Z together");
    return false;
  }
  WorkOffset in = known.value_or(WorkOffset{}), out = out_.frames.work_offset(index).value_or(WorkOffset{});
  if (l == 20 && !further && in.rotation != 0) {
    refuse_block("E-G10", "G10 L20 in a rotated work offset", "the offset that results is not followed",
                 "use G10 L2");
    return false;
  }
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Word* word = axis_word(k);
    if (!word) continue;
    const double value = word->value * modal_.unit();
    if (l == 2 || further) {
      in.origin[i] = out.origin[i] = value;
      continue;
    }
    if (!(known_ & (1u << k))) {
      refuse(*word, "E-POS", fmt::format("G10 L20 {}: where the axis stands is not known", "XYZ"[k]),
             "the new frame depends on it", "command the axis before, or give its position with --start");
      return false;
    }
    // m = p + g92 + g5x + tlo with p = v
    in.origin[i] = in_.m[k] - in_.frames.tool_offset()[k] - in_.frames.g92()[k] - value;
    const double at_out = out_.m[k] - out_.frames.tool_offset()[k] - out_.frames.g92()[k];
    const int decimals = decimals_of(word) + 2;
    double v = (at_out - in.origin[i]) / modal_.unit();
    if (std::abs(v - word->value) > half_digit(decimals)) {
      v = edit_.replace(*word, v, decimals);
    } else {
      v = word->value;
    }
    out.origin[i] = at_out - v * modal_.unit();
  }
  if (rotation) in.rotation = out.rotation = rotation->value * deg;
  in_.frames.set_work_offset(index, in);
  out_.frames.set_work_offset(index, out);
  datum_dirty_ = true;
  move_text_ =
      l == 20 && !further ? "G10 L20: the present correction is added to its values" : "G10 L2: followed";
  return true;
}

}  // namespace abbe
