#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "abbe/machine/control_model.h"
#include "abbe/machine/profile.h"
#include "abbe/program/block.h"
#include "abbe/program/program_findings.h"

namespace abbe {

/// G codes are named by ten times the number they have in RS274/NGC, whatever the control calls them: G1 =
/// 10, G92.1 = 921.
using GCode = int;

enum class Plane : std::uint8_t { xy, zx, yz };

/// First, second and third (normal) axis of a plane, 0 1 2 = X Y Z; right-handed in this order.
[[nodiscard]] constexpr std::array<int, 3> plane_axes(Plane plane) {
  switch (plane) {
    case Plane::zx:
      return {2, 0, 1};
    case Plane::yz:
      return {1, 2, 0};
    default:
      return {0, 1, 2};
  }
}

/// What a program has said of how its tool turns from end to end of a block (ORIMKS ORIWKS, ORIAXES ORIVECT).
struct TurnCodes {
  enum class Frame : std::uint8_t { unsaid, workpiece, machine } frame = Frame::unsaid;
  enum class Way : std::uint8_t { unsaid, axes, tool } way = Way::unsaid;
};

/// What stays in force from block to block.
struct ModalState {
  GCode motion = 800;  ///< G0 G1 G2 G3, a cycle, or G80
  Plane plane = Plane::xy;
  bool inch = false;
  bool incremental = false;      ///< G91
  bool absolute_centre = false;  ///< G90.1
  GCode feed_mode = 940;         ///< G93 G94 G95
  bool retract_to_r = true;      ///< G99; so LinuxCNC starts
  double feed = 0;               ///< F in program units
  bool has_feed = false;         ///< F given since the feed mode changed
  LetterSet motion_words = 0;    ///< letters that belong to the motion in force
  bool units_stated = true,
       distance_stated = true;  ///< false: the profile assumes nothing, and the program has said nothing
  bool offset_stated = true;    ///< false: the profile assumes no work offset, and none has been chosen
  bool edges =
      false;  ///< the control wants the tool offset stated after M6 and at the start (Profile::Tools::edges)
  bool edge_stated = true;               ///< and it is
  bool stated = true;                    ///< all of these
  bool vectors = false;                  ///< I J K of lines and rapids are the tool's direction (G43.5)
  TurnCodes turn_codes;                  ///< how rotary axes go from end to end
  std::span<const TcpCode> tcp_codes{};  ///< codes of this control that switch tool centre point control
  [[nodiscard]] double unit() const { return inch ? 25.4 : 1.0; }
};

/// Nothing that a motion depends on is left to what ran before the program.
[[nodiscard]] bool all_stated(const ModalState& state);
/// What holds before the first block.
[[nodiscard]] ModalState start_of(const Profile& profile);

/// How a block changes the frame that the program is written in (G68 G69, G51, G51.1, G68.2 G53.1
/// and their like).
enum class FrameChange : std::int8_t {
  none,
  end_turn,  ///< and a tilted plane
  turn,
  scale,
  mirror,
  plane,          ///< by Euler angles
  tool_to_plane,  ///< the control turns the rotary axes
  spatial_plane,  ///< by angles I J K about the fixed axes; P1: the control turns the rotary axes, Q: to
                  ///< which side
  end_plane,      ///< P1: and turns them back
  swivel_plane,   ///< by the numbers in the brackets of the code
  datum_turn,     ///< about the datum, by R; 0 ends it
  datum_mirror,   ///< of X, Y or both at the datum; alone: ends it
  datum_scale,    ///< X Y Z about I J K, or P for all about the datum; factors of 1 end it
};

/// What the words of one block ask for, checked against the list of known codes and against each other.
struct Instruction {
  GCode motion = -1;  ///< motion code in force for this block, -1: the block does not move by a motion code
  bool states_motion = false;  ///< the code is written in this block
  GCode zero = -1;             ///< group 0: G4 G10 G28 G30 G52 G53 G92 ..
  std::array<std::int8_t, 29>
      word{};  ///< index of each value word by letter (to kVectorLetters), -1 = absent
  std::array<std::int8_t, 3> direction{-1, -1, -1};  ///< indices of the components of the tool's direction
  bool moves_axes = false;                           ///< X, Y, Z or A, B, C is written
  bool turns_axes = false;                           ///< A, B or C is written
  bool directs_tool = false;                         ///< the tool's direction is written as a vector
  std::int8_t tcp = -1;                              ///< 1, 0: tool centre point control is switched on, off
  bool vectors = false;  ///< and from there on I J K of lines and rapids are the tool's direction
  bool plain = false;    ///< X Y Z and F only: a line or rapid that was in force
  int wcs = -1;          ///< work offset: 0 = G54 .. 8 = G59.3, then the further ones
  GCode tool_length = -1, plane = -1, units = -1, distance = -1, arc_distance = -1, feed_mode = -1,
        retract = -1;
  GCode cutter = -1;        ///< G40, G41 G42, 411 421: D is the diameter
  bool dwell_by_f = false;  ///< F is the time of a dwell, no feed
  TurnCodes turn_codes;     ///< those of this block
  FrameChange frame = FrameChange::none;
  bool ends_scale = false, ends_mirror = false;  ///< G50, G50.1, if one is in force
  LetterSet motion_words = 0;
  bool path_control = false;  ///< G61, G64
  bool smooths = false;       ///< a smoothing that is not modelled is switched
  bool exact_stop = false;    ///< G9
  bool tool_change = false;   ///< M6
  bool set_tool = false;      ///< M61 Q
  std::int8_t flow = 0;       ///< 1: a subprogram is called, 2: one ends
  std::int8_t cycle_call =
      0;                   ///< a drilling cycle is called: 1: here (M99, CYCL CALL), 2: from here on (M89)
  bool ends_call = false;  ///< MCALL alone
  bool retracts = false;   ///< M140
  std::int8_t way = 0;     ///< rotary axes go 1: the shortest way (M126), 2: as the numbers say (M127)
  bool ends = false;       ///< M2 M30
  bool after = false;      ///< a code acts when the motion is done: M0 M1 M2 M30, on some controls M5 M9, G9

  [[nodiscard]] const Word* find(const Block& block, char letter) const {
    const int i = word[static_cast<std::size_t>(letter - 'A')];
    return i < 0 ? nullptr : &block.words[static_cast<std::size_t>(i)];
  }
};

[[nodiscard]] constexpr bool is_cycle(GCode code) {
  return (code >= 810 && code <= 890) || code == 730 || code == 740 || code == 760;
}
/// G6.2: blocks of control points and knots that make one curve.
inline constexpr GCode kNurbs = 62;
[[nodiscard]] constexpr bool is_arc(GCode code) { return code == 20 || code == 30; }
/// The word's code acts when the motion of its block is done.
[[nodiscard]] bool acts_after_motion(const Profile& profile, const Word& word);

/// Sorts the words of a block. Everything not known to the control's profile is a finding.
/// errors   false when the block was refused; `state` is not changed here
[[nodiscard]] bool read_instruction(const Profile& profile, const Block& block, const ModalState& state,
                                    std::uint64_t line, ProgramFindings& findings, Instruction& instruction);

/// Puts the modal codes of the instruction in force, in the control's order of execution.
void apply_modal(const Block& block, const Instruction& instruction, ModalState& state);

}  // namespace abbe
