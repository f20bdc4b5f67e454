#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "abbe/cl/findings.h"
#include "abbe/cl/motion.h"
#include "abbe/cl/record.h"

namespace abbe::cl {

/// Which tool axes of a CL file may be corrected.
enum class AxisRule : std::uint8_t {
  automatic,  ///< those of six-number records while MULTAX is on
  correct,    ///< those of all six-number records
  keep,       ///< none
};

/// On which hand the axis of a CIRCLE record counts its sense; unknown: NX files are refused.
enum class CircleHand : std::uint8_t { unknown, right, left };

/// What the file does not say.
struct Conventions {
  std::optional<double> unit;  ///< mm per unit, for files without UNITS
  AxisRule axis_rule = AxisRule::automatic;
  CircleHand circle_hand = CircleHand::unknown;
  std::set<std::string, std::less<>> pass_words;  ///< major words that neither move nor change a frame
  bool tool_change_keeps_place = false;
};

/// program = rotation (unit x) + origin: numbers of records to the frame of the program.
struct Frame {
  Mat3 rotation = Mat3::Identity();
  Vec3 origin = Vec3::Zero();  ///< mm
  double unit = 1;             ///< mm
  [[nodiscard]] Vec3 to_program(const Vec3& numbers) const { return rotation * (unit * numbers) + origin; }
  [[nodiscard]] Vec3 to_numbers(const Vec3& program) const {
    return rotation.transpose() * (program - origin) / unit;
  }
};

enum class FeedMode : std::uint8_t { none, per_minute, per_revolution, per_tooth, inverse_time };

struct Feed {
  FeedMode mode = FeedMode::none;
  double value = 0;   ///< as written
  bool inch = false;  ///< IPM, IPR
};

/// Follows a CL file record by record: what each one means, and whether Abbe surely understands it.
/// errors   E-... in the findings, each with its place; what follows is still read
/// source   docs/cl-data.md
class Interpreter {
 public:
  Interpreter(const Conventions& conventions, std::optional<int> loaded_tool);

  enum class Outcome : std::uint8_t {
    copied,  ///< no motion
    held,    ///< CIRCLE, MOVARC: the GOTO that follows makes it a motion
    motion,  ///< see motion()
    refused,
  };
  [[nodiscard]] Outcome take(const Record& record, Findings& findings);

  [[nodiscard]] const Motion& motion() const { return motion_; }
  [[nodiscard]] const Frame& frame() const { return frame_; }
  [[nodiscard]] const Feed& feed() const { return feed_; }
  [[nodiscard]] std::optional<int> tool() const { return tool_; }
  [[nodiscard]] double cutter_diameter() const { return cutter_diameter_; }  ///< mm, 0 = unknown
  [[nodiscard]] bool multax() const { return multax_.value_or(false); }
  [[nodiscard]] bool cutter_compensated() const { return cutcom_; }
  [[nodiscard]] const std::string& cycle_kind() const { return cycle_kind_; }          ///< DRILL, ..
  [[nodiscard]] const std::optional<Feed>& cycle_feed() const { return cycle_feed_; }  ///< nothing: FEDRAT's
  /// The first word of the cycle that is neither its depth, its clearance nor its feed; "": none.
  [[nodiscard]] const std::string& cycle_extra() const { return cycle_extra_; }
  [[nodiscard]] bool ended() const { return ended_; }
  /// The arc of the motion just read has more than one turn, or states its angle: it stays one record.
  [[nodiscard]] int arc_turns() const { return arc_turns_; }

 private:
  [[nodiscard]] Outcome follow(const Record& record, Findings& findings);
  [[nodiscard]] Outcome mode(const Record& record, Findings& findings);
  [[nodiscard]] bool units(const Record& record, Findings& findings);
  [[nodiscard]] bool feed_rate(const Record& record, Findings& findings);
  [[nodiscard]] bool cycle(const Record& record, Findings& findings);
  void note_cycle_word(const Item& item);
  void note_feed_word(std::string_view word, Feed& feed) const;
  [[nodiscard]] bool cutter_compensation(const Record& record, Findings& findings);
  [[nodiscard]] bool frame_record(const Record& record, Findings& findings);
  [[nodiscard]] bool shift(const Record& record, Findings& findings);
  [[nodiscard]] bool msys(const Record& record, Findings& findings);
  [[nodiscard]] bool csys(const Record& record, Findings& findings);
  [[nodiscard]] bool tool_axis_record(const Record& record, Findings& findings);
  [[nodiscard]] bool tool_record(const Record& record, Findings& findings);
  [[nodiscard]] bool remark(const Record& record, Findings& findings);
  void insert(const Record& record, Findings& findings);
  void forget_axis();

  [[nodiscard]] Outcome move(const Record& record, Findings& findings);
  [[nodiscard]] Outcome hold_arc(const Record& record, Findings& findings);
  [[nodiscard]] bool make_arc_motion(const Record& record, Findings& findings);
  [[nodiscard]] bool read_target(const Record& record, Findings& findings);
  [[nodiscard]] bool read_axis(const Record& record, Findings& findings);
  [[nodiscard]] bool continues_circle() const;
  [[nodiscard]] bool has_unit(const Record& record, Findings& findings);
  void refresh_frame();

  Conventions conventions_;
  Motion motion_;
  Frame frame_;
  // frames
  Vec3 trans_ = Vec3::Zero(), origin_ = Vec3::Zero();  ///< mm
  Mat3 msys_rotation_ = Mat3::Identity();              ///< of the first MSYS
  Vec3 msys_origin_ = Vec3::Zero();
  bool msys_seen_ = false, unit_known_ = false, world_ = false;
  Mat3 relative_rotation_ = Mat3::Identity();
  Vec3 relative_origin_ = Vec3::Zero();
  std::string catia_matrix_, catia_first_;
  int catia_numbers_ = -1;
  // the tool
  std::optional<int> tool_;
  double cutter_diameter_ = 0;
  ToolPose at_;
  bool at_known_ = false, axis_sure_ = true, axis_warned_ = false;
  std::optional<bool> multax_;
  // modes
  Feed feed_;
  bool rapid_ = false, rapid_unclear_ = false, ended_ = false, nx_ = false;
  bool cutcom_ = false, cutcom_edge_ = false;
  bool cycle_on_ = false, cycle_defined_ = false;
  double above_ = 0, below_ = 0;
  std::string cycle_kind_, cycle_extra_;
  std::optional<Feed> cycle_feed_;
  // an arc that waits for its GOTO, and the last one
  bool arc_waits_ = false, arc_just_made_ = false;
  Vec3 arc_centre_ = Vec3::Zero(), arc_normal_ = Vec3::UnitZ();
  double arc_radius_ = 0, arc_angle_ = 0;
  int arc_turns_ = 1;
  Arc last_arc_;
};

}  // namespace abbe::cl
