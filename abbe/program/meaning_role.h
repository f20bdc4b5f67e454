#pragma once

#include <array>
#include <cstdint>

#include "abbe/machine/profile.h"
#include "abbe/program/modal.h"

/// What a meaning of a code is to the reader of blocks: its modal group, and the code by which it goes on.
/// Only for modal.cpp.
namespace abbe::roles {

/// Modal groups of RS274/NGC: one code of each in a block; codes in `loose` stand beside each other.
enum Group : std::uint8_t {
  loose,
  zero,
  motion,
  plane,
  distance,
  arc_distance,
  feed_mode,
  units,
  cutter,
  tool_length,
  retract,
  wcs,
  path,
  spindle,
  lathe,
  rotation,
  turn_frame,
  turn_way,
  bracket,
  kGroups
};

/// What a meaning is to this reader.
struct Role {
  Meaning meaning;
  Group group;
  GCode code;
};
inline constexpr Role kRoles[] = {
    {Meaning::rapid, motion, 0},
    {Meaning::line, motion, 10},
    {Meaning::arc_cw, motion, 20},
    {Meaning::arc_ccw, motion, 30},
    {Meaning::nurbs, motion, kNurbs},
    {Meaning::no_motion, motion, 800},
    {Meaning::chip_break, motion, 730},
    {Meaning::tap_left, motion, 740},
    {Meaning::fine_bore, motion, 760},
    {Meaning::drill, motion, 810},
    {Meaning::drill_dwell, motion, 820},
    {Meaning::peck, motion, 830},
    {Meaning::tap, motion, 840},
    {Meaning::bore, motion, 850},
    {Meaning::bore_stop, motion, 860},
    {Meaning::bore_dwell, motion, 890},
    {Meaning::dwell, zero, 40},
    {Meaning::set_data, zero, 100},
    {Meaning::home, zero, 280},
    {Meaning::other_home, zero, 300},
    {Meaning::local_shift, zero, 520},
    {Meaning::machine_coordinates, zero, 530},
    {Meaning::set_position, zero, 920},
    {Meaning::clear_position, zero, 921},
    {Meaning::suspend_position, zero, 922},
    {Meaning::restore_position, zero, 923},
    {Meaning::exact_stop_once, loose, 90},
    {Meaning::plane_xy, plane, 170},
    {Meaning::plane_zx, plane, 180},
    {Meaning::plane_yz, plane, 190},
    {Meaning::absolute, distance, 900},
    {Meaning::incremental, distance, 910},
    {Meaning::centre_absolute, arc_distance, 901},
    {Meaning::centre_incremental, arc_distance, 911},
    {Meaning::inverse_time, feed_mode, 930},
    {Meaning::per_minute, feed_mode, 940},
    {Meaning::per_turn, feed_mode, 950},
    {Meaning::units_inch, units, 200},
    {Meaning::units_mm, units, 210},
    {Meaning::cutter_off, cutter, 400},
    {Meaning::cutter_left, cutter, 410},
    {Meaning::cutter_left_direct, cutter, 411},
    {Meaning::cutter_right, cutter, 420},
    {Meaning::cutter_right_direct, cutter, 421},
    {Meaning::tool_length, tool_length, 430},
    {Meaning::tool_length_minus, tool_length, 440},
    {Meaning::tool_length_direct, tool_length, 431},
    {Meaning::tool_length_off, tool_length, 490},
    {Meaning::retract_initial, retract, 980},
    {Meaning::retract_r, retract, 990},
    {Meaning::work_offset, wcs, 540},
    {Meaning::numbered_work_offset, wcs, 541},
    {Meaning::path_control, path, 610},
    {Meaning::spindle_mode, spindle, 970},
    {Meaning::radius_mode, lathe, 80},
    {Meaning::rotate, rotation, static_cast<GCode>(FrameChange::turn)},
    {Meaning::rotate_off, rotation, static_cast<GCode>(FrameChange::end_turn)},
    {Meaning::scale, rotation, static_cast<GCode>(FrameChange::scale)},
    {Meaning::scale_off, loose, 0},
    {Meaning::mirror, rotation, static_cast<GCode>(FrameChange::mirror)},
    {Meaning::mirror_off, loose, 0},
    {Meaning::tilted_plane, rotation, static_cast<GCode>(FrameChange::plane)},
    {Meaning::tool_to_plane, rotation, static_cast<GCode>(FrameChange::tool_to_plane)},
    {Meaning::spatial_plane, rotation, static_cast<GCode>(FrameChange::spatial_plane)},
    {Meaning::plane_off, rotation, static_cast<GCode>(FrameChange::end_plane)},
    {Meaning::swivel_plane, rotation, static_cast<GCode>(FrameChange::swivel_plane)},
    {Meaning::datum_turn, rotation, static_cast<GCode>(FrameChange::datum_turn)},
    {Meaning::datum_mirror, rotation, static_cast<GCode>(FrameChange::datum_mirror)},
    {Meaning::datum_scale, rotation, static_cast<GCode>(FrameChange::datum_scale)},
    {Meaning::datum_scale_evenly, rotation, static_cast<GCode>(FrameChange::datum_scale)},
    {Meaning::frame_scale, zero, 683},
    {Meaning::frame_scale_further, zero, 684},
    {Meaning::frame_mirror, zero, 685},
    {Meaning::frame_mirror_further, zero, 686},
    {Meaning::transformation_off, loose, 0},
    {Meaning::smoothing, loose, 1},
    {Meaning::copy, loose, 0},
    {Meaning::frame_shift, zero, 521},
    {Meaning::frame_shift_further, zero, 522},
    {Meaning::frame_turn, zero, 681},
    {Meaning::frame_turn_further, zero, 682},
    {Meaning::tcp_on, loose, 0},
    {Meaning::tcp_off, loose, 0},
    {Meaning::turns_of_workpiece, turn_frame, static_cast<GCode>(TurnCodes::Frame::workpiece)},
    {Meaning::turns_of_machine, turn_frame, static_cast<GCode>(TurnCodes::Frame::machine)},
    {Meaning::axes_evenly, turn_way, static_cast<GCode>(TurnCodes::Way::axes)},
    {Meaning::tool_evenly, turn_way, static_cast<GCode>(TurnCodes::Way::tool)},
    {Meaning::bracket_cycle, bracket, 0},
    {Meaning::modal_call, loose, 0},
};

constexpr std::array<Role, kMeanings> make_roles() {
  std::array<Role, kMeanings> roles{};
  for (const Role& role : kRoles) roles[static_cast<std::size_t>(role.meaning)] = role;
  return roles;
}
inline constexpr std::array<Role, kMeanings> kRoleOf = make_roles();
constexpr Role role_of(Meaning meaning) { return kRoleOf[static_cast<std::size_t>(meaning)]; }

}  // namespace abbe::roles
