#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <span>

#include "abbe/machine/control_setup.h"
#include "abbe/verify/block.h"
#include "abbe/verify/motion.h"
#include "abbe/verify/plain_motion.h"
#include "abbe/verify/rotary.h"

namespace abbe::verifying {

/// What the control remembers from block to block, and what a block makes it do.
///
/// execute() does one block: the events before its motion, at most one motion, the events after it.
/// A block is done whole or refused; after a refusal the state must not be used again.
///
/// errors   false with `fault` filled: E-BLOCK E-WORD E-MODE E-WCS E-G10 E-POS E-G92 E-TOOL E-G53 E-ARC
///          E-CYCLE E-FEED E-ROTARY E-TURN E-TCP E-VECTOR E-ROTATION E-FRAME E-PLANE E-DECIMAL
/// cost     no allocation unless refused
class Control {
 public:
  /// `rotary` (kept by the caller) may be null: then rotary words are refused.
  explicit Control(const ControlSetup& setup, const Rotary* rotary = nullptr);

  [[nodiscard]] bool execute(const Block& block, Fault& fault);

  [[nodiscard]] std::span<const Event> before() const { return {events_.data(), event_count_}; }
  [[nodiscard]] const Motion* motion() const { return moves_ ? &motion_ : nullptr; }
  /// A drilling cycle that runs behind the motion, where that ends.
  [[nodiscard]] const Motion* hole() const { return drills_ ? &hole_ : nullptr; }
  [[nodiscard]] std::span<const Event> after() const { return {after_.data(), after_count_}; }

  /// Where the axis words of a block lead from u (both with g92 in them), in the modes in force: u = word +
  /// g92, or u + word in G91. Inline, so that coordinates stay in registers: stored one by one and loaded
  /// together they would have to be waited for.
  [[nodiscard]] Position led(const Block& block, const Position& u) const {
    const auto coordinate = [&](int i, char letter) {
      if (!block.has(letter)) return u.at[i];
      const double word = block[letter] * unit_;
      if (!incremental_ && (block.increments >> i & 1) == 0) return word + frames_.g92[i];
      return (u.known >> i & 1) != 0 ? u.at[i] + word : u.at[i];
    };
    return {Vec3(coordinate(0, 'X'), coordinate(1, 'Y'), coordinate(2, 'Z')),
            incremental_ ? u.known : u.known | (named_axes(block) & ~block.increments)};
  }
  [[nodiscard]] const Position& position() const { return u_; }  ///< u

  // control_plain.cpp
  /// Plain blocks that come now have no effect but to lead on.
  [[nodiscard]] bool goes_plainly() const;
  [[nodiscard]] PlainMotion here() const;
  /// Where a block leads `from` another one's end. False: it is not plain.
  [[nodiscard]] bool leads_plainly(const Block& block, const PlainMotion& from, PlainMotion& to) const;
  /// The block with this motion was executed.
  void take(const PlainMotion& motion);

  [[nodiscard]] const Frames& frames() const { return frames_; }
  [[nodiscard]] std::optional<int> tool() const { return tool_; }
  [[nodiscard]] const Profile& profile() const { return profile_; }
  [[nodiscard]] const Turns& turns() const { return turns_; }
  [[nodiscard]] bool tcp() const { return tcp_; }
  [[nodiscard]] bool inch() const { return unit_ != 1; }
  [[nodiscard]] bool ended() const { return ended_; }
  /// The subprogram that the block calls, 0: none, -1: the running one ends. Asked once per block.
  [[nodiscard]] int flow() const { return flow_; }
  /// Of a conversational program: LBL was called (label() says which), LBL 0, or LBL stands here.
  static constexpr int kCallLabel = 10001, kEndLabel = -2, kLabel = 10002;
  [[nodiscard]] std::string_view label() const { return block_->label; }
  void flow_followed() { flow_ = 0; }

 private:
  [[gnu::cold]] bool refuse(std::size_t column, const char* code, std::string message, std::string why,
                            std::string fix);
  [[gnu::cold]] bool refuse_at(char letter, const char* code, std::string message, std::string why,
                               std::string fix);
  bool use(char letter);  ///< false (refused) if another code already used this word
  bool use_all(Letters letters);
  bool execute_settled();
  bool use_optional(char letter) { return !block_->has(letter) || use(letter); }
  bool whole_word(char letter, int& out, const char* code);
  Event& add(EventKind kind, int code, Letters words = 0);
  void add_comments();
  void fill(Event& event, EventKind kind, int code, Letters words) const;
  [[nodiscard]] double length_word(char letter) const { return (*block_)[letter] * unit_; }
  bool frame_known();

  bool choose_motion();
  bool settings();  // feed mode .. M62..M68, dwell
  bool feed_words();
  bool m_codes();
  bool tool_codes(int code);
  bool modes();  // plane .. G98/G99
  bool tool_offset(int code);
  bool edge();
  bool select_tool();
  bool make_frame(int code);
  void move_zero(const Vec3& before);
  bool increments_sure();
  bool non_modal();  // G10 G28 G30 G52 G92
  bool move();
  bool straight();
  bool arc();
  bool arc_centre(const Vec3& start, const Vec3& end, int a, int b, Vec3& centre);
  bool canned_cycle();
  bool nurbs_block();
  bool nurbs_point();
  bool end_nurbs();
  bool cycle_words(int axis);
  void begin_motion(MotionKind kind);
  void turn(int code);

  // control_offsets.cpp
  bool set_system();
  bool set_g92(int code);
  void go_home(int code);
  // control_frame.cpp
  bool change_frame(int code);
  bool begin_plane();
  bool begin_spatial_plane();
  bool swivel();
  bool read_swivel(std::array<double, 16>& numbers, std::size_t& count) const;
  bool stretch(int code);
  void end_stretch();
  bool end_stretches();
  bool place_plane(const Vec3& origin);
  bool tool_to_plane();
  bool lay_tool(std::optional<int> side, bool stands = false);
  bool reset_plane();
  bool stand_on_plane();
  bool scale();
  bool mirror(bool on);
  void end_placement(Placement::Kind kind);
  // control_datum.cpp
  bool turn_about_datum();
  bool mirror_at_datum();
  bool scale_at_datum();
  bool datum_allows();
  bool frame_is_bare(std::size_t column);
  bool placement_allows();
  bool placement_allows_motion();
  void forget_positions();

  bool settle_numbers();
  bool extras(bool after);
  bool m_code(int group);
  bool stops();
  bool change_flow(int code);
  bool leftovers();

  // control_holes.cpp
  bool define_hole();
  bool check_tool();
  bool ways_agree();
  bool retract();
  static constexpr int kOnceHere = 99;
  bool drill();
  bool may_drill(int call);
  bool run_hole();
  // control_bracket.cpp
  [[nodiscard]] bool names_modal_call() const;
  bool ends_modal_call();
  bool define_bracket();
  bool bracket_may_run();
  // control_cutter.cpp
  bool cutter_permits();
  bool switch_cutter(int code);
  [[nodiscard]] std::optional<double> radius_in_force(int code) const;
  bool move_beside();

  // control_turns.cpp
  bool turn_words_allowed();
  bool read_turns(bool machine_words);
  [[nodiscard]] bool direction_named() const;
  [[nodiscard]] std::array<char, 3> direction_letters() const;
  bool read_direction(bool machine_words);
  void forget_turns();
  bool switch_tcp(bool on);
  [[nodiscard]] bool turns_known() const;
  // control_between.cpp
  void note_turn_codes();
  [[nodiscard]] bool axes_go_evenly() const;
  [[nodiscard]] bool one_way(const Turns& from, const Turns& to) const;
  bool way_is_sure();

  // What the block being executed says.
  const Block* block_ = nullptr;
  Fault* fault_ = nullptr;
  Letters used_ = 0;
  int motion_code_ = -1;  ///< of this block, -1 = no motion
  bool covets_ = false;   ///< axis words belong to G10 G28 G30 G52 G92 G43.1

  // What the control is and remembers.
  std::shared_ptr<const Profile> shared_profile_;
  const Profile& profile_;
  Block settled_;  ///< the block with its numbers in units, where it needs that
  Frames frames_;
  std::map<int, ToolEntry> tools_;
  std::map<int, double> radii_;     ///< of cutters, by the number of a D or a tool
  std::optional<int> edge_number_;  ///< D that was said last, where it is the edge of a tool
  CutterUse cutter_;
  int cutter_code_ = 0;  ///< that switched it on
  std::optional<int> tool_, selected_;
  bool tool_change_keeps_place_;
  Position u_, m_;        ///< program position + g92, and axis commands
  Axes moved_zeros_ = 0;  ///< axes whose zero is another one than when they were commanded
  double unit_ = 1;       ///< mm per program unit
  int plane_ = 170, feed_mode_ = 940, mode_ = 800;
  bool feed_stated_ = false;
  double feed_ = 0;
  bool set_pole();
  std::optional<std::array<double, 2>> pole_;                                   ///< of CC, in u
  bool incremental_ = false, absolute_centres_ = false, retracts_to_r_ = true;  // G99: so LinuxCNC starts
  std::optional<Vec3> saved_g92_;
  std::optional<double> cycle_r_, cycle_z_, cycle_p_, cycle_q_;
  HoleWords hole_words_;               ///< CYCL DEF 200 .. 209
  bool drills_always_ = false;         ///< M89
  std::optional<double> cycle_level_;  ///< p along the cycle's axis before the first block of the sequence
  bool ended_ = false;
  int flow_ = 0;
  const Rotary* rotary_;
  Turns turns_{};               ///< rad, counted through whole turns
  Axes unknown_turns_ = 0;      ///< bits 0 1 2 = A B C
  Axes commanded_turns_ = 0;    ///< named by some block so far
  bool laid_by_words_ = false;  ///< the program turns the rotary axes to the plane itself
  bool scaled_by_one_ = false;  ///< the scale in force has one factor for all axes
  bool on_plane_ = false;       ///< the rotary axes stand on the tilted plane in force
  bool tcp_ = false;
  /// Meanings of the codes given last (ORIWKS ORIMKS; ORIAXES ORIVECT); unknown: none was.
  Meaning turns_of_ = Meaning::unknown, turning_ = Meaning::unknown;
  bool directs_by_centre_words_ = false;  ///< I J K of a straight motion are the tool's direction
  bool edge_stated_;  ///< which tool offset is in force does not depend on the control's settings

  // What the block did.
  std::array<Event, Block::kMaxComments + 40> events_;
  std::size_t event_count_ = 0;
  std::array<Event, Block::kMGroups + Block::kMaxExtras> after_;
  std::size_t after_count_ = 0;
  bool moves_ = false, drills_ = false;
  Motion motion_, hole_;
  Nurbs nurbs_;              ///< as far as its blocks have been read
  bool nurbs_open_ = false;  ///< knots are missing
  Position nurbs_at_;        ///< its last control point, u
  Axes nurbs_axes_ = 0;      ///< named in its first block
};

}  // namespace abbe::verifying
