#include "abbe/machine/profile.h"

#include <fmt/format.h>

#include <algorithm>

namespace abbe {
namespace {

constexpr LetterSet kAxes = letter_set("XYZ");
constexpr LetterSet kMoves = letter_set("XYZABC");
constexpr LetterSet kCentre = letter_set("IJK");

using M = Meaning;
constexpr MeaningInfo kMeaningInfo[] = {
    {M::unknown, "unknown", 'G', "R", 0, "refused"},
    {M::rapid, "rapid", 'G', "E", kMoves, "rapid: its end is corrected, never split"},
    {M::line, "line", 'G', "X", kMoves, "feed in a straight line"},
    {M::arc_cw, "arc-cw", 'G', "A", kMoves | kCentre | letter_set("RP"), "arc clockwise"},
    {M::arc_ccw, "arc-ccw", 'G', "A", kMoves | kCentre | letter_set("RP"), "arc counter-clockwise"},
    {M::nurbs, "nurbs", 'G', "S", kAxes | letter_set("PKR"), "curve by control points, one block each"},
    {M::no_motion, "no-motion", 'G', "P", 0, "ends a cycle or the motion mode"},
    {M::chip_break, "chip-break", 'G', "S", kAxes | letter_set("RLQ"), "drill, breaking chips"},
    {M::tap_left, "tap-left", 'G', "S", kAxes | letter_set("RLP"), "tap a left-hand thread"},
    {M::fine_bore, "fine-bore", 'G', "S", kAxes | letter_set("RLPQ"), "bore, step aside at the bottom"},
    {M::drill, "drill", 'G', "S", kAxes | letter_set("RL"), "drill"},
    {M::drill_dwell, "drill-dwell", 'G', "S", kAxes | letter_set("RLP"), "drill, dwell at the bottom"},
    {M::peck, "peck", 'G', "S", kAxes | letter_set("RLQ"), "drill in pecks"},
    {M::tap, "tap", 'G', "S", kAxes | letter_set("RLP"), "tap a right-hand thread"},
    {M::bore, "bore", 'G', "S", kAxes | letter_set("RL"), "bore, feed out"},
    {M::bore_stop, "bore-stop", 'G', "S", kAxes | letter_set("RLP"), "bore, stop the spindle, rapid out"},
    {M::bore_dwell, "bore-dwell", 'G', "S", kAxes | letter_set("RLP"), "bore, dwell, feed out"},
    {M::dwell, "dwell", 'G', "P", letter_set("P"), "dwell"},
    {M::set_data, "set-data", 'G', "P X", kAxes | letter_set("LPR"), "sets a work offset"},
    {M::home, "home", 'G', "P", kMoves, "goes to the reference position"},
    {M::other_home, "other-home", 'G', "P", kMoves, "goes to a further reference position"},
    {M::local_shift, "local-shift", 'G', "X", kAxes, "shifts all work offsets"},
    {M::machine_coordinates, "machine-coordinates", 'G', "P", kMoves, "this block is in machine coordinates"},
    {M::set_position, "set-position", 'G', "X", kAxes, "the present position gets these coordinates"},
    {M::clear_position, "clear-position", 'G', "P", 0, "clears what set-position made"},
    {M::suspend_position, "suspend-position", 'G', "P", 0, "clears it, but remembers"},
    {M::restore_position, "restore-position", 'G', "P", 0, "puts it back"},
    {M::exact_stop_once, "exact-stop-once", 'G', "P", 0, "exact stop at the end of this block"},
    {M::plane_xy, "plane-xy", 'G', "X", 0, "arcs in the XY plane"},
    {M::plane_zx, "plane-zx", 'G', "X", 0, "arcs in the ZX plane"},
    {M::plane_yz, "plane-yz", 'G', "X", 0, "arcs in the YZ plane"},
    {M::absolute, "absolute", 'G', "X", 0, "coordinates are places"},
    {M::incremental, "incremental", 'G', "X", 0, "coordinates are distances"},
    {M::centre_absolute, "centre-absolute", 'G', "X", 0, "I J K are places"},
    {M::centre_incremental, "centre-incremental", 'G', "X", 0, "I J K count from the start"},
    {M::inverse_time, "inverse-time", 'G', "X", 0, "F is 1 / minutes of the block"},
    {M::per_minute, "per-minute", 'G', "P", 0, "F is a feed per minute"},
    {M::per_turn, "per-turn", 'G', "P", 0, "F is a feed per turn"},
    {M::units_inch, "inch", 'G', "X", 0, "inches"},
    {M::units_mm, "mm", 'G', "X", 0, "millimetres"},
    {M::cutter_off, "cutter-off", 'G', "P", 0, "no cutter radius compensation"},
    {M::cutter_left, "cutter-left", 'G', "X", letter_set("D"),
     "the cutter runs left of the path, at the radius of D"},
    {M::cutter_right, "cutter-right", 'G', "X", letter_set("D"), "right of the path, at the radius of D"},
    {M::cutter_left_direct, "cutter-left-direct", 'G', "X", letter_set("D"),
     "left of the path, D is the diameter"},
    {M::cutter_right_direct, "cutter-right-direct", 'G', "X", letter_set("D"),
     "right of the path, D is the diameter"},
    {M::tool_length, "tool-length", 'G', "X", letter_set("H"), "tool offset of H"},
    {M::tool_length_minus, "tool-length-minus", 'G', "X", letter_set("H"), "tool offset of H, subtracted"},
    {M::tool_length_direct, "tool-length-direct", 'G', "X", kAxes, "tool offset as written"},
    {M::tool_length_off, "tool-length-off", 'G', "X", 0, "no tool offset"},
    {M::retract_initial, "retract-initial", 'G', "P", 0, "cycles end at the height before"},
    {M::retract_r, "retract-r", 'G', "P", 0, "cycles end at R"},
    {M::work_offset, "work-offset", 'G', "X", 0, "work offset"},
    {M::numbered_work_offset, "numbered-work-offset", 'G', "X", letter_set("P"), "further work offset P"},
    {M::path_control, "path-control", 'G', "P", 0, "how exactly the path is followed"},
    {M::spindle_mode, "spindle-mode", 'G', "P", 0, "what S means"},
    {M::radius_mode, "radius-mode", 'G', "P", 0, "X is a radius"},
    {M::rotate, "rotate", 'G', "X", letter_set("XYR"), "turns coordinates about a point"},
    {M::rotate_off, "rotate-off", 'G', "X", 0, "ends the turn"},
    {M::transformation_off, "transformation-off", 'G', "P", 0, "ends a transformation that would be refused"},
    {M::smoothing, "smoothing", 'G', "P!", 0, "smoothing by the control, not modelled"},
    {M::copy, "copy", 'G', "P", 0, "without effect on the path"},
    {M::frame_shift, "frame-shift", 'G', "X", kAxes, "shifts the work offset; alone: ends shift and turn"},
    {M::frame_shift_further, "frame-shift-further", 'G', "X", kAxes, "shifts it further"},
    {M::frame_turn, "frame-turn", 'G', "X", letter_set("R"),
     "turns coordinates about their zero; alone: ends shift and turn"},
    {M::frame_turn_further, "frame-turn-further", 'G', "X", letter_set("R"), "turns what is shifted"},
    {M::frame_scale, "frame-scale", 'G', "X", kAxes, "scales coordinates about their zero; alone: ends it"},
    {M::frame_scale_further, "frame-scale-further", 'G', "X", kAxes, "scales what is shifted"},
    {M::frame_mirror, "frame-mirror", 'G', "X", kAxes, "mirrors coordinates at their zero; alone: ends it"},
    {M::frame_mirror_further, "frame-mirror-further", 'G', "X", kAxes, "mirrors what is shifted"},
    {M::scale, "scale", 'G', "X", letter_set("XYZP"), "scales coordinates about a point"},
    {M::scale_off, "scale-off", 'G', "X", 0, "ends the scale"},
    {M::mirror, "mirror", 'G', "X", letter_set("XY"), "mirrors coordinates at a place"},
    {M::mirror_off, "mirror-off", 'G', "X", letter_set("XY"), "ends the mirror of the axes named"},
    {M::tilted_plane, "tilted-plane", 'G', "X", letter_set("XYZIJK"),
     "coordinates of a plane in space: its origin, and Euler angles about Z, X, Z"},
    {M::tool_to_plane, "tool-to-plane", 'G', "X", 0,
     "turns the rotary axes until the tool stands on the plane"},
    {M::spatial_plane, "spatial-plane", 'G', "X", letter_set("IJKPQ"),
     "coordinates of a plane in space, by angles about the fixed X, Y, Z"},
    {M::plane_off, "plane-off", 'G', "X", letter_set("P"), "ends the plane in space"},
    {M::swivel_plane, "swivel-plane", 'G', "X", 0,
     "coordinates of a plane in space, from numbers in brackets"},
    {M::datum_turn, "datum-turn", 'G', "X", letter_set("R"), "turns coordinates about the datum; 0 ends it"},
    {M::datum_mirror, "datum-mirror", 'G', "X", letter_set("XY"),
     "mirrors coordinates at the datum; alone: ends it"},
    {M::datum_scale, "datum-scale", 'G', "X", letter_set("XYZIJK"),
     "scales each axis about a place; factors of 1 end it"},
    {M::datum_scale_evenly, "datum-scale-evenly", 'G', "X", letter_set("P"),
     "scales coordinates about the datum; 1 ends it"},
    {M::tcp_on, "tcp-on", 'G', "X", 0, "tool centre point control begins"},
    {M::tcp_off, "tcp-off", 'G', "X", 0, "tool centre point control ends"},
    {M::turns_of_workpiece, "turns-of-workpiece", 'G', "X", 0, "the tool turns in the workpiece's frame"},
    {M::turns_of_machine, "turns-of-machine", 'G', "X", 0, "the tool turns as the machine's axes do"},
    {M::axes_evenly, "axes-evenly", 'G', "X", 0, "from end to end each rotary axis goes evenly"},
    {M::tool_evenly, "tool-evenly", 'G', "X", 0, "from end to end the tool turns in one plane"},
    {M::bracket_cycle, "bracket-cycle", 'G', "S", 0, "a drilling cycle with its numbers in brackets"},
    {M::modal_call, "modal-call", 'G', "S", 0,
     "the cycle beside it runs behind every positioning block; alone: ends that"},
    {M::stop, "stop", 'M', "P", 0, "program stop, after the motion"},
    {M::end, "end", 'M', "P", 0, "end of the program"},
    {M::tool_change, "tool-change", 'M', "P", 0, "puts the selected tool into the spindle"},
    {M::set_tool, "set-tool", 'M', "P", letter_set("Q"), "names the tool in the spindle"},
    {M::spindle, "spindle", 'M', "P", 0, "spindle"},
    {M::coolant, "coolant", 'M', "P", 0, "coolant"},
    {M::override_switch, "override", 'M', "P", 0, "feed and speed overrides"},
    {M::signal, "signal", 'M', "P", 0, "outputs and inputs"},
    {M::call_subprogram, "call", 'M', "X", letter_set("PL"), "runs subprogram P of this file, once"},
    {M::end_subprogram, "return", 'M', "P", 0, "ends a subprogram"},
    {M::hole_cycle, "hole-cycle", 'G', "S", 0, "defines a drilling cycle that is called later"},
    {M::cycle_call, "cycle-call", 'M', "S", 0, "calls the cycle that was defined last, behind the motion"},
    {M::cycle_call_modal, "cycle-call-modal", 'M', "S", 0, "calls it behind every positioning block"},
    {M::retract_tool, "retract-tool", 'M', "P", 0, "takes the tool back along its axis"},
    {M::shortest_way, "shortest-way", 'M', "P", 0, "rotary axes go the shortest way from here on"},
    {M::straight_way, "straight-way", 'M', "P", 0, "rotary axes go as the numbers say from here on"},
    {M::auxiliary, "auxiliary", 'M', "P", 0, "without effect on the path"},
};

constexpr bool in_order() {
  for (std::size_t i = 0; i < kMeanings; ++i)
    if (static_cast<std::size_t>(kMeaningInfo[i].meaning) != i) return false;
  return std::size(kMeaningInfo) == kMeanings;
}
static_assert(in_order());

}  // namespace

const MeaningInfo& about(Meaning meaning) { return kMeaningInfo[static_cast<std::size_t>(meaning)]; }
std::span<const MeaningInfo> all_meanings() { return kMeaningInfo; }

const Profile::Keyword* find_keyword(const Profile& profile, std::string_view name) {
  const auto at =
      std::lower_bound(profile.keywords.begin(), profile.keywords.end(), name,
                       [](const auto& keyword, std::string_view key) { return keyword.name < key; });
  return at == profile.keywords.end() || at->name != name ? nullptr : &*at;
}

char find_address(const Profile& profile, std::string_view name) {
  const auto at =
      std::lower_bound(profile.addresses.begin(), profile.addresses.end(), name,
                       [](const auto& address, std::string_view key) { return address.name < key; });
  return at == profile.addresses.end() || at->name != name ? '\0' : at->letter;
}

std::string g_name(const Profile& profile, std::size_t index) {
  for (const Profile::Keyword& keyword : profile.keywords) {
    if (keyword.index == index) return keyword.name;
  }
  return index % 10 == 0 ? fmt::format("G{}", index / 10) : fmt::format("G{}.{}", index / 10, index % 10);
}

CodeName read_code_name(std::string_view text) {
  const auto digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.size() < 2 || text.size() > 6 || (text[0] != 'G' && text[0] != 'M') || !digit(text[1])) return {};
  std::size_t at = 1, number = 0;
  while (at < text.size() && digit(text[at]))
    number = 10 * number + static_cast<std::size_t>(text[at++] - '0');
  CodeName name{text[0], text[0] == 'G' ? 10 * number : number};
  if (at < text.size()) {
    if (text[0] == 'M' || text[at] != '.' || at + 2 != text.size() || !digit(text[at + 1])) return {};
    name.index += static_cast<std::size_t>(text[at + 1] - '0');
  }
  if (name.index >= (text[0] == 'G' ? Profile::kGCodes : Profile::kMCodes)) return {};
  return name;
}

}  // namespace abbe
