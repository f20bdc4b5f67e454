#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/chain/turning_bend.h"
#include "abbe/compensate/arc.h"
#include "abbe/compensate/block_numbers.h"
#include "abbe/compensate/correction_field.h"
#include "abbe/compensate/cutter.h"
#include "abbe/compensate/lane_line.h"
#include "abbe/compensate/line_edit.h"
#include "abbe/compensate/line_split.h"
#include "abbe/compensate/nurbs_curve.h"
#include "abbe/compensate/rewrite.h"
#include "abbe/compensate/tool_vectors.h"
#include "abbe/compensate/turn_word.h"
#include "abbe/compensate/turning_packet.h"
#include "abbe/program/block.h"
#include "abbe/program/bracket_cycle.h"
#include "abbe/program/frames.h"
#include "abbe/program/hole_cycle.h"
#include "abbe/program/klartext_block.h"
#include "abbe/program/modal.h"
#include "abbe/program/program_findings.h"
#include "abbe/program/subprogram.h"

namespace abbe {

/// Follows a program on two controls at once: the one that runs the original and the one that runs the
/// output. Each line is read once, its effect on both is worked out, and the output line is written such
/// that the second control stands at the corrected position. What the output's control believes is always
/// what its words, as rounded, say: rounding never accumulates.
class Rewriter {
 public:
  Rewriter(const Plan& plan, const AddressedAxes& axes, const RewriteJob& job, RewriteReport& report);

  /// The gradient between two points closer than this is dominated by rounding, mm.
  static constexpr double kGradientBase = 0.05;
  /// More lines of one call of lines() save nothing.
  static constexpr std::size_t kMostLines = TurningPacket::kMost;
  /// The next lines, with their end-of-line bytes; the first one has this number. Output lines are appended
  /// to `out`. A line that was cut (`too_long`) comes alone.
  void lines(std::span<const std::string_view> texts, std::uint64_t number, bool too_long, std::string& out);
  /// After the last line.
  void finish(std::string& out);
  [[nodiscard]] ProgramFindings& findings() { return findings_; }

 private:
  /// One of the two controls.
  struct Side {
    explicit Side(const ControlSetup& setup) : frames(setup) {}
    Frames frames;
    Vec3 m = Vec3::Zero();  ///< point in machine coordinates, mm; meaningless for unknown axes
    Turns turns{};          ///< of A B C, rad, counted through whole turns
    Vec3 g92_saved = Vec3::Zero();
    double cycle_level = 0;  ///< height before a series of cycles, program frame
    [[nodiscard]] Vec3 p() const { return frames.to_program(m); }
  };
  struct Move {
    Vec3 m0 = Vec3::Zero(), m1 = Vec3::Zero();   ///< of the original
    unsigned known0 = 0, known1 = 0, named = 0;  ///< bits 0 1 2 = X Y Z, 3 4 5 = A B C
    Turns turns0{}, turns1{};                    ///< of the original
    unsigned turning = 0;                        ///< rotary axes that move, bits 0 1 2 = A B C
    bool by_vector = false;                      ///< the block states the tool's direction
    [[nodiscard]] bool turns() const { return turning != 0; }
  };
  /// A block of the output that does part of a straight move.
  struct Piece {
    double s0 = 0, s1 = 1;                 ///< of the original move
    Vec3 want = Vec3::Zero();              ///< program coordinates of the output
    Turns turns{};                         ///< as their words say
    std::array<double, 3> turn_numbers{};  ///< those words, or the components of the tool's direction
  };

  /// Lines that are read at once where they are not plain.
  static constexpr std::size_t kRows = 8;

  // rewriter.cpp: lines and blocks
  void block_lines(std::span<const std::string_view> texts, std::uint64_t number, bool too_long,
                   std::string& out);
  void line(const std::optional<BlockError>& error, bool too_long, std::string& out);
  bool read_known_instruction();
  void execute(std::string& out);
  std::optional<BlockError> read_line(std::string_view bytes, Block& block);
  void look_ahead(std::size_t rows);
  bool read_text_rules();
  bool settle_numbers();
  bool may_move();
  // rewriter_smoothing.cpp
  [[nodiscard]] std::optional<double> smoothing_tolerance() const;
  void warn_of_smoothing();
  void pass(std::string& out);
  void write_header(std::string& out);
  /// Axes whose word in this block is a distance, bits 0 1 2 = X Y Z.
  [[nodiscard]] unsigned increments() const { return modal_.incremental ? 7U : block_->increments; }
  [[gnu::cold]] void refuse(const Word& word, const char* code, std::string message, const char* why,
                            const char* fix);
  [[gnu::cold]] void refuse_block(const char* code, std::string message, const char* why, const char* fix);
  [[gnu::cold]] void warn(const char* code, std::string message, const char* why, const char* fix);
  void count_blocks(std::size_t begin, std::string& out);
  void end_line(std::string& out, std::size_t begin);
  void check_length(std::size_t bytes);
  /// A block of its own behind the one that is split: " X1.5 Y2.", with the block delete of the original.
  void add_block(std::string_view words, std::string_view eol, std::string& tail);

  // rewriter_sensitivity.cpp
  [[nodiscard]] std::optional<RewriteReport::Sensitivity> sensitivity();

  /// A subprogram that was run: its lines first .. end - 1, rewritten.
  struct Called {
    struct Line {
      std::string original;
      std::size_t begin = 0;   ///< in `text`
      bool continues = false;  ///< its block began in the line before
    };
    std::uint64_t first = 0, end = 0;
    std::string text;
    std::vector<Line> lines;  ///< of conversational programs, which have numbers
  };
  // rewriter_subprogram.cpp
  void follow_flow();
  bool only_changes_flow(std::string_view words);
  std::optional<int> called_number();
  void run_subprogram();
  void run_found(const Subprogram& found, const std::string& name);
  void follow_label(std::string& out);
  void call_label();
  void renumber_called(const Called& called, std::string& out);
  void pass_behind_end(std::string& out);

  // rewriter_setting.cpp: tools and frames
  bool settings();
  bool change_tool(std::optional<int> number);
  bool tool_length();
  void define_tool(std::string& out);
  bool retract();
  bool zero_group(std::string& out, bool& done);
  bool set_g92();
  bool choose_work_offset();
  void note_shift(const Vec3& reading, const Turns& zeros);
  [[nodiscard]] std::optional<int> tool_number(const Word& word) const;
  bool set_work_offset();
  void refresh_datum();

  // rewriter_frame.cpp: frames that the program makes
  void forget(unsigned axes);
  bool change_frame();
  bool make_frame();
  bool turn_frame();
  bool stretch_frame();
  bool scale_frame();
  bool mirror_frame(bool on);
  bool end_stretch();
  std::optional<double> scale_factor(const Word& word);
  void turn_about(const Vec3& centre, double angle);
  [[nodiscard]] bool may_place() const;
  void place(const Mat3& matrix, const Vec3& at);
  void leave_place();

  // rewriter_datum.cpp: the same in conversational programs
  bool datum_turn();
  bool datum_mirror();
  bool datum_scale();
  std::optional<Vec3> stated_factors();
  // Beyond these a scale is more likely a wrong unit.
  static constexpr double kSmallestScale = 0.01, kLargestScale = 100;

  // rewriter_plane.cpp: tilted planes
  bool tilt_plane();
  bool declare_plane(const Mat3& turn, const Vec3& origin);
  bool spatial_plane();
  bool swivel_plane();
  bool reset_plane();
  bool tool_to_plane(std::optional<int> side, bool stands = false);
  bool stand_on_plane();
  bool stands_on_plane(const Turns& turns);
  void end_plane();
  bool plane_allows(const Move& move);

  // rewriter_motion.cpp: lines and rapids
  void motion(std::string& out);
  bool read_move(Move& move);
  bool check_travel(const Move& move);
  /// False: refused.
  bool straight(const Move& move, std::string& out);
  void uncorrected(const Move& move, std::string& out);
  bool sample_line(const Move& move, const Vec3& end_correction, const std::array<signed char, 3>& approach);
  std::optional<Vec3> correction_at(const Vec3& m, unsigned withheld,
                                    const std::array<signed char, 3>& approach);
  bool feed_allowed(const Move& move);
  bool feed_above_zero();
  /// `what` cuts at m (original). False, and said: an axis there stands where G53 put it, and its correction
  /// is more than the tolerance.
  bool holds_withheld(const Vec3& m, const char* what);
  void note_correction(const Vec3& m, const Vec3& c);
  /// A number for a word: what stands there if that is right to half its last digit, else one to be rounded.
  struct Value {
    double number = 0;     ///< program units
    bool written = false;  ///< differs from what is in force
  };
  [[nodiscard]] Value value_for(double wanted, const Word* word, double present, int decimals) const;
  /// Where axis k stands after commanding it to `want` (mm) from p_out.
  [[nodiscard]] Value axis_value(int k, const Vec3& want, const Vec3& p_out, bool first, double& base) const;
  /// Returns the number as it will be read.
  double put(char letter, const Word* word, double number, int decimals, bool first, std::string* extra);
  /// Commands program position `want` (output side); the first piece edits the line, others add blocks.
  /// Axes in `skip` (bits) are left alone.
  void command(const Vec3& want, bool first, Vec3& p_out, std::string* extra, unsigned skip = 0);
  void put_feed_share(double fraction, bool first, std::string* extra);
  void stops_to_last(bool first, std::string* extra);

  // rewriter_time.cpp: how long the pieces of a motion last
  void measure_split(double length, double angle = 0);
  bool keep_block_time(std::vector<std::size_t>& ends);
  void note_piece(double share);
  void hold_splits(double residual);
  bool refuse_short_blocks(double residual);

  void write_pieces(const Move& move, const std::vector<Piece>& pieces, std::string& out);

  // rewriter_turning.cpp: rotary axes and tool centre point control
  [[nodiscard]] const Word* turn_word_of(int axis) const { return instruction_.find(*block_, "ABC"[axis]); }
  [[nodiscard]] Turning turning_of(int axis) const;
  [[nodiscard]] int turn_decimals(int axis) const;
  [[nodiscard]] int turn_decimals(int axis, int written) const;
  bool turn_words_allowed();
  bool read_turns(Move& move);
  void keep_turns(const Move& move);
  void command_turns(const Move& move, const Piece& piece, bool first, std::string* extra);
  void switch_tcp(bool on);
  bool stand(const Turns& commanded, const Turns& standing);
  bool turn(const Move& move, std::string& out);
  /// A place of a turning move, solved: what the output must command there.
  struct Stop {
    double s = 0;
    Vec3 m = Vec3::Zero();
    Turns turns{};
    std::array<double, 3> numbers{};  ///< of the words, or components of the tool's direction
    Turns cut_short{};                ///< corrections that would have turned an axis another way, rad
    double direction = 0;             ///< what is left between the tool axes, rad
    bool held = false;
  };
  std::optional<Stop> stop_at(const Move& move, double s, const Turns& from);
  bool bends(const Move& move, const Stop& a, const Stop& b, double tolerance);
  [[nodiscard]] bool sure_of(const Move& move, const Stop& a, const Stop& b) const;
  bool split_turn(const Move& move, const Stop& a, const Stop& b, int depth, std::vector<Stop>& stops);
  /// `meant`: way of the linear axes in the original, `done`: in the output.
  void note_turning_gradient(const Vec3& meant, const Vec3& done);

  // rewriter_vector.cpp: the tool's direction as a vector
  [[nodiscard]] const Word& direction_word(std::size_t k) const {
    return block_->words[static_cast<std::size_t>(instruction_.direction[k])];
  }
  [[nodiscard]] Vec3 written_direction() const;
  [[nodiscard]] int direction_decimals() const;
  bool vector_words_allowed();
  bool read_vector(Move& move);
  std::optional<Turns> turns_of_vector(const Vec3& words, const Turns& from);
  bool settle_vector(double s, const Turns& meant, const Turns& wanted, const Turns& from, Stop& stop);
  void command_vector(const Piece& piece, bool first, std::string* extra);

  // rewriter_between.cpp: how rotary axes go from end to end of a block
  [[nodiscard]] bool says_how_it_turns() const;
  [[nodiscard]] bool turns_evenly() const;
  [[nodiscard]] bool evenly_enough(const Move& move) const;
  /// Refuses or reports a block whose way is not sure. It is then followed as if each axis went evenly.
  void judge_way(const Move& move);

  bool choose_turning_feed(const Move& move, const Stop& start, const std::vector<Stop>& stops);
  void write_timed(const Move& move, const std::vector<Piece>& pieces, std::string& out);

  // rewriter_cutter.cpp
  [[nodiscard]] double shortest_end() const;
  bool cutter_settings();
  bool cutter_permits();
  std::optional<double> stated_radius();
  bool cutter_allows(const Move& move);
  bool cutter_moved(const Vec3& wanted);
  bool follow_offset(const std::optional<PlaneWay>& way, const Vec3& meant);
  std::optional<double> left_at_centre(const Vec3& m, const Vec3& tangent);
  bool within_tolerance(double left, double bend);
  bool keep_ends_whole(const Move& move, std::vector<std::size_t>& ends);
  [[nodiscard]] double bend_between(const std::vector<std::size_t>& ends) const;
  bool arc_beside(const Arc& nominal);

  // rewriter_lane.cpp: runs of plain lines
  /// Does the first lines, as many as it may: how many.
  std::size_t lane(std::span<const std::string_view> texts, std::uint64_t number, std::string& out);
  [[nodiscard]] bool lane_is_open(std::uint64_t number, std::size_t rows) const;
  std::size_t read_ahead(std::span<const std::string_view> texts);
  [[nodiscard]] LaneDigits digits_of_lane() const;
  void choose_turns(std::size_t i, const Turns& offsets);
  [[nodiscard]] bool turns_are_sure(std::size_t i) const;
  void choose_all_turns(std::size_t count);
  bool choose_places(std::size_t i, const Vec3& place, const Vec3& p_before);
  bool choose_line(std::size_t i, const LaneReach& before);
  void enter(std::size_t at, const Vec3& meant, const Turns& meant_turns, const Vec3& done,
             const Turns& done_turns);
  [[nodiscard]] bool run_is_straight(std::size_t first, std::size_t end) const;
  [[nodiscard]] bool is_straight(const TurningBend::Bound& bound, double at_start) const;
  void count_line(const LaneLine& ahead);
  std::size_t take_run(std::size_t first, std::size_t count, std::uint64_t number, std::string& out);
  char* write_plain(const LaneLine& ahead, char* to) const;
  void one_line(std::string_view text, std::string& out);
  /// The output, going evenly from one place to another, stays within the interpolation of the original, if
  /// it is off by `at_start` at the first and by nothing at the second: a bound (TurningBend). Axis mode.
  [[nodiscard]] bool surely_straight(const Move& move, const Vec3& from, const Turns& from_turns,
                                     const Vec3& to, const Turns& to_turns, double at_start) const;
  /// How far the rounding of words may take the tip, mm.
  [[nodiscard]] double rounded_away() const;

  // rewriter_arc.cpp
  /// The directions in which the axes have moved last, after they went `way` (machine axes); `known` axes
  /// only.
  void follow(const Vec3& way, unsigned known);
  /// A motion up to this length is too short for a block before it that takes up lost motion, mm.
  [[nodiscard]] double shortest_take_up() const;
  bool arc(const Move& move, std::string& out);
  /// A part of an arc along which no axis turns round.
  struct Stretch {
    double s0 = 0, s1 = 1;
    std::array<signed char, 3> approach{};
  };
  bool read_stretches(const Arc& nominal);
  bool write_arc(const Arc& nominal, std::string& out, Vec3& p_out);
  std::optional<Vec3> place_to_take_up(const Arc& nominal, double s, const Vec3& p_out);
  /// Commands the place `want` by a straight move; the first block of an arc becomes that move.
  void take_up_on_arc(const Vec3& want, bool first, Vec3& p_out, std::string* extra);
  std::optional<Arc> nominal_arc(const Vec3& p0, const Vec3& p1);
  struct ArcPiece {
    double s0 = 0, s1 = 1;
    Vec3 end = Vec3::Zero();  ///< wanted, output program coordinates
    Centre centre;
    bool first = true;  ///< written into the block of the original
    bool keeps_radius = false;
  };
  bool fit_part(const Arc& nominal, double s0, double end, const Vec3& start, ArcPiece& piece);
  bool fit_piece(const Arc& nominal, double s0, double s1, const Vec3& start, bool whole, ArcPiece& piece);
  Vec3 rounded_end(const Vec3& want, const Vec3& p_out, bool first) const;
  /// The centre word of axis k is a place (G90.1, I=AC(..)).
  [[nodiscard]] bool places_centre(int k) const {
    return modal_.absolute_centre || (block_->places >> (3 + k) & 1) != 0;
  }
  [[nodiscard]] Value centre_value(int k, double centre, const Vec3& start, bool first, double& base) const;
  [[nodiscard]] std::optional<PlaneWay> written_way(const ArcPiece& piece, const Vec3& start,
                                                    const Vec3& end) const;
  void command_centre(const ArcPiece& piece, const Vec3& start, bool first, std::string* extra);

  // rewriter_spline.cpp: curves by control points
  void spline(std::string& out);
  bool hold_spline_block();
  void hold_line(bool has_point);
  void abandon_spline();
  std::optional<std::vector<Vec3>> moved_points();
  std::optional<double> spline_miss(const NurbsCurve& output);
  bool write_spline(std::string& out);

  // rewriter_pole.cpp: conversational programs, whose arcs go about a pole
  void set_pole();
  void release_pole(std::string& out);
  void drop_pole();
  void place_pole(const Centre& centre, std::string& before);
  void begin_pole_arc(const ArcPiece& piece, std::string& before, std::string& extra);
  void end_pole_arc(bool first, std::string& extra);
  std::optional<bool> leaves_plane(const Arc& nominal, double height);
  bool chords(const Arc& nominal, std::string& out, Vec3& p_out);

  // rewriter_cycle.cpp
  void cycle(std::string& out);
  /// The holes of one block, program coordinates, mm.
  struct Holes {
    int a = 0, b = 1, n = 2;  ///< axes of the plane and of the holes
    int count = 1;
    int times = 1;  ///< that the control drills: in G90 a count repeats the same hole
    double r = 0, z = 0;
    Vec3 first = Vec3::Zero(), step = Vec3::Zero();
    [[nodiscard]] Vec3 last() const { return first + (count - 1) * step; }
  };
  bool read_holes(Holes& holes);
  bool keep_depth(int n);
  /// How far the correction at both ends of the holes is from the shift of all, mm. nullopt: refused.
  std::optional<double> shift_of(const Holes& holes, Vec3& shift);
  void note_way_out(const Holes& holes, const Vec3& shift);
  bool keeps_shape(double residual);
  [[nodiscard]] bool keeps_levels() const { return profile_.cycles.sticky == Profile::Sticky::levels; }
  double write_holes(const Holes& holes, const Vec3& shift, std::string& out, Vec3& p_out);

  // rewriter_drill.cpp: a drilling cycle as the motions that it makes
  /// The output of one block with holes: the block itself and those behind it, the place after them.
  struct Expansion {
    std::vector<std::string> blocks;  ///< words of those behind the first
    Vec3 at = Vec3::Zero();           ///< of the original, program coordinates
    Vec3 p_out = Vec3::Zero();        ///< of the output
    bool first = true;                ///< the block of the original is not yet used up
  };
  void take_dwell();
  /// G81, G82: what others do beside, like breaking chips, is the control's.
  [[nodiscard]] bool drills() const { return cycle_.code == 810 || cycle_.code == 820; }
  bool may_expand(const Holes& holes);
  bool expand_holes(const Holes& holes, std::string& out);
  bool drill(const Holes& holes, const Vec3& hole, Expansion& expansion);
  bool go_rapidly(const Vec3& to, const Vec3& way, Expansion& expansion);
  void write_first(const Vec3& want, Expansion& expansion);
  void write_stroke(std::string words, const Vec3& want, Expansion& expansion);
  void write_expansion(const Expansion& expansion, std::string& out);
  // rewriter_hole.cpp: drilling cycles of conversational programs, defined in one block and called in others
  void define_hole(std::string& out);
  void keep_held(std::size_t begin, std::string& to, std::string& out);
  void release_hole(std::string& out);
  bool call_hole(bool moves);
  bool call_allowed(bool moves);
  [[nodiscard]] double hole_height(double height, const Vec3& p) const;
  [[nodiscard]] Vec3 present_shift() const;
  std::optional<Vec3> hole_shift(const Vec3& m);
  std::optional<double> left_in_hole(const Vec3& shift);
  bool lead_to_hole(const Vec3& m, Vec3& correction);
  void drill(std::string& out, std::size_t begin);
  bool call_once(std::string& out, std::size_t begin);
  bool drill_at(const Vec3& wanted, Vec3& shift, std::string& before);
  void set_surface(double shift, std::string& before);
  std::string spelled_surface(double& number) const;
  void append_definition(std::string& to, const std::string& surface);
  void step_aside(const Vec3& wanted, Vec3& shift, std::string& before);

  // rewriter_bracket.cpp: drilling cycles with their numbers in brackets, modal or called where they stand
  void define_bracket(std::string& out);
  bool bracket_allowed();
  bool hole_allowed();
  bool call_bracket(bool moves);
  void run_bracket(std::string& out);
  void set_levels(double shift, std::string& before);

  [[nodiscard]] int decimals_of(const Word* word) const { return decimals_of(word ? word->decimals : -1); }
  [[nodiscard]] int decimals_of(int written) const;  ///< those of the word; -1: there is none
  [[nodiscard]] double digit_room() const;
  [[nodiscard]] double half_digit(int decimals) const;  ///< program units
  [[nodiscard]] const Word* axis_word(int axis) const { return instruction_.find(*block_, "XYZ"[axis]); }

  const RewriteJob& job_;
  const std::shared_ptr<const Profile> shared_profile_;
  const Profile& profile_;
  RewriteReport& report_;
  const Machine& machine_;
  CorrectionField field_;
  ToolVectors vectors_;
  ProgramFindings findings_;
  double interpolation_;     ///< mm
  double short_enough_ = 0;  ///< mm: a move up to this length is not looked into
  bool angular_;

  // Our mark stands in the header, never deeper.
  static constexpr std::uint64_t kMarkLines = 40;

  std::array<Block, kRows> blocks_;  ///< of the lines read last
  Block* block_ = blocks_.data();    ///< the one that is executed
  Instruction instruction_;
  ModalState modal_;
  std::uint64_t number_ = 0;
  std::string_view eol_;
  std::string file_eol_;
  LineEdit edit_;

  Side in_, out_;                      ///< the control of the original, of the output
  unsigned known_ = 0, withheld_ = 0;  ///< bits 0 1 2 = X Y Z, 3 4 5 = A B C
  unsigned needed_ = 7;                ///< axes whose position the correction depends on
  unsigned shifted_ = 0;               ///< axes whose zero has moved since they were commanded, bits 0 to 5
  unsigned turned_ = 0;                ///< rotary axes that the program has commanded, bits 0 1 2 = A B C
  /// Of a tilted plane: it is declared, then the rotary axes stand on it and points are of the tip.
  enum class PlaneStage : std::uint8_t { none, declared, stands };
  PlaneStage plane_ = PlaneStage::none;
  bool turned_by_words_ = false;                ///< the program turns the rotary axes to the plane itself
  FrameChange frame_kind_ = FrameChange::none;  ///< scale or mirror, while one is in force
  Vec3 mirror_at_ = Vec3::Zero();
  bool scaled_evenly_ = false;  ///< by one factor for all (CYCL DEF 11)
  bool tcp_ = false;
  double timed_feed_ = 0;  ///< 1/min: the block's time is stated by G93 in its output; 0: not
  AddressedAxes axes_;
  bool start_corrected_ = false;           ///< the output stands where the correction wants it
  std::optional<Vec3> last_correction_;    ///< at in_.m, for the current datum
  std::array<signed char, 3> approach_{};  ///< in which each axis moved last, -1 0 +1
  std::array<signed char, 3> stands_{};    ///< for which the output's place is corrected
  std::optional<int> selected_tool_, loaded_tool_;
  double gauge_ = 0;
  CutterState cutter_;
  std::optional<PlaneWay> last_way_;  ///< of the output, under cutter compensation
  unsigned still_ = 0;                ///< X and Y (bits 0 1) must not move in this block
  bool slopes_ = false;  ///< the block goes along Z as well: it may not be split beside a contour
  int edge_ = -1;        ///< D that was said last, where it chooses the edge of a tool
  bool saved_g92_ = false;
  bool offset_doubtful_ = false;  ///< the control may have dropped the tool offset
  bool smoothing_said_ = false;
  bool way_said_ = false;  ///< that how the tool turns is left to machine data
  bool datum_dirty_ = true;
  std::vector<bool> frame_reported_;

  bool percent_first_ = false, percent_seen_ = false, any_block_ = false, ended_ = false,
       header_written_ = false;

  struct Cycle {
    GCode code = -1;
    bool has_r = false, has_z = false;
    bool refused = false;         ///< said once, not for every hole
    double r = 0, z = 0;          ///< sticky words of the original, program units
    double r_out = 0, z_out = 0;  ///< of the output
    bool incremental = false;     ///< in which mode they were written
    std::string dwell;            ///< P as the program spells it
    bool dwells = false;          ///< and it is not zero
    bool expanded = false;        ///< the output has written the last holes as G0 and G1
  } cycle_;

  /// The drilling cycle that was defined last.
  struct Hole {
    HoleDefinition definition;
    HoleSpan span;
    double surface_out = 0;  ///< Q203 of the output, program units
    bool sure = false;       ///< the span is known
    bool modal = false;      ///< M89: every positioning block calls it
    bool each = false;       ///< in the output by an M99 of its own
    std::optional<BracketCycle>
        bracket;  ///< of a control with names; its surface stands in `definition`, too
  } hole_;
  bool drills_ = false;           ///< the block being executed calls it
  bool holds_ = false;            ///< the definition is not written yet: its Q203 may still be set
  std::string held_;              ///< what has been written since
  std::size_t held_from_ = 0;     ///< where the definition begins in it
  std::size_t line_begin_ = 0;    ///< of the present line in the text it is written to, if that will be held
  std::string held_surface_;      ///< what Q203 becomes in it
  std::size_t held_spelled_ = 0;  ///< bytes of its number (of the whole cycle in brackets) there

  /// Where a correction was larger than before, and what it was reckoned with.
  struct Extreme {
    Vec3 m = Vec3::Zero(), datum = Vec3::Zero();
    double gauge = 0;
    bool set = false;
  };
  std::array<Extreme, 4> extremes_;  ///< of X, Y, Z, and of the gradient

  std::map<std::uint64_t, Called> run_;  ///< by first line
  std::set<int> called_;                 ///< numbers
  std::set<std::string> called_labels_;
  bool counted_ = false;         ///< the lines written last have their numbers already
  std::size_t depth_ = 0;        ///< of calls now running
  std::uint64_t call_line_ = 0;  ///< of the one in the main program
  bool returned_ = false;        ///< the running subprogram came to its M99
  std::uint64_t behind_ = 0;     ///< lines before this one are already written

  /// The pole CC of the original and of the output, program coordinates, mm; nothing: none that is sure.
  std::optional<Centre> pole_in_, pole_out_;
  /// A line CC that is held back until the arc about it is known.
  struct HeldPole {
    std::string text, eol;
    Block block;
  };
  std::unique_ptr<HeldPole> held_pole_;
  KlartextContext klartext_;
  BlockNumbers block_numbers_;

  std::array<LaneLine, TurningPacket::kMost> ahead_;
  LaneDigits lane_digits_;
  std::optional<LetterSet> line_words_;  ///< ModalState::motion_words of G1, once there was one
  MoveRun lane_run_;
  std::string lane_text_;
  TurningPacket packet_;
  TurningBend bend_;
  /// The blocks of a curve that has not all its knots yet, and what they say, program coordinates.
  struct HeldSpline {
    struct Line {
      std::string text, eol;
      Block block;
      Instruction instruction;
      std::uint64_t number = 0;
      bool has_point = false;
    };
    std::vector<std::unique_ptr<Line>> blocks;
    NurbsCurve curve;        ///< of the original, mm
    Vec3 at = Vec3::Zero();  ///< its last control point
    unsigned axes = 0;       ///< named in its first block, bits 0 1 2 = X Y Z
  };
  std::unique_ptr<HeldSpline> spline_;
  bool motion_lost_ = false;  ///< a refused code may have been one of motions: words of it are not judged

  std::vector<MoveSample> samples_;
  std::vector<ArcTarget> targets_;
  std::vector<Stretch> stretches_;
  std::vector<Piece> pieces_;
  /// The feed motion that is being written.
  struct Splitting {
    double length = 0;  ///< mm
    double time = 0;    ///< s, at least; 0: not known
    double least = 0;   ///< share of the motion that no piece may be shorter than
  } splitting_;
  std::string move_text_;  ///< decision in words, for the trace
};

}  // namespace abbe
