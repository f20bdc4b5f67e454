#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "abbe/chain/control_kinematics.h"
#include "abbe/verify/block.h"
#include "abbe/verify/frames.h"
#include "abbe/verify/nurbs.h"

namespace abbe::verifying {

/// The axes with a word in a block. X Y Z are neighbours among the letters, as among the axes.
[[nodiscard]] constexpr Axes named_axes(const Block& block) { return block.words >> ('X' - 'A') & kAllAxes; }

/// home: G28 and G30, which end at a position that only the control knows.
enum class MotionKind : std::uint8_t { rapid, line, arc, cycle, home, nurbs };

/// A circular, helical or spiral arc in axis commands (mm), s from 0 to 1:
///   point(s) = centre + r(s) (first cos a(s) + second sin a(s)) + normal rise s
///   a(s) = start_angle + sweep s,   r(s) = start_radius + (end_radius - start_radius) s
/// centre has the start's coordinate along `normal`. sweep > 0 is counter-clockwise seen from the tip
/// of `normal` (G3) and holds all turns.
struct Arc {
  Vec3 centre = Vec3::Zero();
  Vec3 first = Vec3::UnitX(), second = Vec3::UnitY(), normal = Vec3::UnitZ();
  double start_radius = 0, end_radius = 0;
  double start_angle = 0, sweep = 0;
  double rise = 0;
  int plane = 17;  ///< 17, 18, 19
  int turns = 1;   ///< P word
};

/// A canned cycle: the holes of one block, in axis commands (mm). Hole k is `step * k` from the first.
struct Cycle {
  int plane = 17;
  int holes = 1;                ///< L word
  bool retracts_to_r = false;   ///< G99
  Vec3 lifted = Vec3::Zero();   ///< the start point, moved straight to R if the sequence began below R
  Vec3 travel = Vec3::Zero();   ///< first hole at the height at which the tool gets there
  Vec3 retract = Vec3::Zero();  ///< first hole at the R level
  Vec3 bottom = Vec3::Zero();   ///< first hole at its bottom
  Vec3 clear = Vec3::Zero();    ///< first hole at the level where the cycle ends
  Vec3 step = Vec3::Zero();
  double dwell = 0;  ///< P, s
  double peck = 0;   ///< Q, mm
  double aside = 0;  ///< Q of a fine bore, mm
  double reach = 0;  ///< how far the tool goes to the side of the hole's axis, mm
  std::array<Vec3, 2> aside_axes{Vec3::UnitX(), Vec3::UnitY()};  ///< to which sides: X, Y of the frame
  const HoleWords* words = nullptr;  ///< of CYCL DEF 200 .. 209; valid until the next block is read
};

/// Cutter radius compensation, of the control and of a motion. `begins` and `ends`: the code has been given,
/// the motion in XY that belongs to it is this one or has not come yet.
struct CutterUse {
  enum class Phase : std::uint8_t { off, begins, on, ends } phase = Phase::off;
  double offset = 0;  ///< of the cutter's centre to the left of the contour, mm: r with G41, -r with G42
};

/// One motion as the control executes it. Positions are points in machine coordinates, mm: axis commands of
/// X Y Z, or with tool centre point control those of the tip.
struct Motion {
  MotionKind kind = MotionKind::rapid;
  int code = 0;                ///< 10 times the G code: 0 10 20 30, 280 300 (M91 at F: 290), 730 .. 890,
                               ///< CYCL DEF 2000 .. 2090
  bool machine_words = false;  ///< G53: the words are axis commands
  bool to_hole = false;        ///< a rapid at whose end a cycle runs: the hole judges X and Y
  bool with_height = false;    ///< and Z, too
  bool incremental = false;    ///< G91
  Axes named = 0;              ///< axes with a word in the block
  Vec3 words = Vec3::Zero();   ///< their values, mm, as written
  Position start, end;         ///< home: end is the intermediate point
  bool tcp = false;            ///< positions are of the tip (ControlKinematics), not axis commands
  Axes named_turns = 0;        ///< A B C with a word in the block: bits 0 1 2
  Turns turn_words{};          ///< their values, deg, as written
  bool by_direction = false;   ///< A B C follow from a tool direction; turn_words are its components
  Turns turns_start{}, turns_end{};  ///< rotary positions, rad, counted through whole turns
  int feed_mode = 940;               ///< 930, 940, 950
  double feed = 0;                   ///< F in force, program units (G93: 1/min)
  CutterUse cutter;                  ///< positions are of the contour, not of the cutter's centre
  Arc arc;
  Cycle cycle;
  const Nurbs* nurbs = nullptr;  ///< of the control, until it reads on

  [[nodiscard]] bool turns() const { return turns_start != turns_end; }
  [[nodiscard]] bool feeds() const { return kind == MotionKind::line || kind == MotionKind::arc; }
};

/// Anything a program says that is not a motion, in the order in which the control does it.
enum class EventKind : std::uint8_t {
  delimiter,       ///< a line with %
  program_number,  ///< O word
  block_number,    ///< N word
  comment,
  feed,   ///< F, except on G93 motions, where it belongs to the motion
  speed,  ///< S
  tool,   ///< T
  m_code,
  g_code,        ///< every G code that is not a motion; frames and their values included
  skipped_line,  ///< a block with '/' that is not executed
  after_end,     ///< a line behind the end of the program
};

struct Event {
  EventKind kind = EventKind::comment;
  int code = 0;                ///< G codes times 10, M codes as they are
  bool sets_position = false;  ///< G92, G10 L20: the values may differ, the frames may not
  bool sets_frames = false;
  Letters words = 0;               ///< the words that belong to it
  std::array<double, 8> values{};  ///< theirs, in the order of the alphabet
  std::string_view text;           ///< comments and lines; valid until the next block is read
};

/// Point of a line or arc at s in [0, 1], axis commands, mm.
[[nodiscard]] Vec3 point_at(const Motion& motion, double s);

/// d point / d s, mm.
[[nodiscard]] Vec3 derivative_at(const Motion& motion, double s);

/// Length of a line or arc, mm (of a spiral: with the mean radius).
[[nodiscard]] double length_of_arc(const Arc& arc);
[[nodiscard]] inline double length_of(const Motion& motion) {
  return motion.kind == MotionKind::arc ? length_of_arc(motion.arc)
                                        : (motion.end.at - motion.start.at).norm();
}

}  // namespace abbe::verifying
