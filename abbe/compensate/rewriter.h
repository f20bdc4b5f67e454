#pragma once

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

#include "abbe/compensate/arc.h"
#include "abbe/compensate/block_numbers.h"
#include "abbe/compensate/correction_field.h"
#include "abbe/compensate/cutter.h"
#include "abbe/compensate/line_edit.h"
#include "abbe/compensate/line_split.h"
#include "abbe/compensate/rewrite.h"
#include "abbe/compensate/turn_word.h"
#include "abbe/program/block.h"
#include "abbe/program/frames.h"
#include "abbe/program/klartext_block.h"
#include "abbe/program/modal.h"
#include "abbe/program/program_findings.h"

namespace abbe {

/// Follows a program on two controls at once: the one that runs the original and the one that runs the
/// output. Each line is read once, its effect on both is worked out, and the output line is written such
/// that the second control stands at the corrected position. What the output's control believes is always
/// what its words, as rounded, say: rounding never accumulates.
class Rewriter {
 public:
  Rewriter(const Plan& plan, const AddressedAxes& axes, const RewriteJob& job, RewriteReport& report);

  /// Most lines of one call of lines().
  static constexpr std::size_t kRows = 8;
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
    [[nodiscard]] bool turns() const { return turning != 0; }
  };
  /// A block of the output that does part of a straight move.
  struct Piece {
    double s0 = 0, s1 = 1;                 ///< of the original move
    Vec3 want = Vec3::Zero();              ///< program coordinates of the output
    Turns turns{};                         ///< as their words say
    std::array<double, 3> turn_numbers{};  ///< those words
  };

  // rewriter.cpp: lines and blocks
  void line(const std::optional<BlockError>& error, bool too_long, std::string& out);
  void execute(std::string& out);
  std::optional<BlockError> read_line(std::string_view bytes, Block& block);
  void look_ahead(std::size_t rows);
  bool read_text_rules();
  bool settle_numbers();
  bool may_move();
  [[nodiscard]] bool smooths_more_than_tolerance() const;
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

  // rewriter_subprogram.cpp
  void follow_flow();
  bool only_changes_flow(std::string_view words);
  std::optional<int> called_number();
  void run_subprogram();
  void pass_behind_end(std::string& out);

  // rewriter_setting.cpp: tools and frames
  bool settings();
  bool change_tool(std::optional<int> number);
  bool tool_length();
  bool zero_group(std::string& out, bool& done);
  bool set_g92();
  bool make_frame();
  bool choose_work_offset();
  void note_shift(const Vec3& reading, const Turns& zeros);
  [[nodiscard]] std::optional<int> tool_number(const Word& word) const;
  bool turn_frame();
  bool set_work_offset();
  void refresh_datum();

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

  void write_pieces(const Move& move, const std::vector<Piece>& pieces, std::string& out);

  // rewriter_turning.cpp: rotary axes and tool centre point control
  [[nodiscard]] const Word* turn_word_of(int axis) const { return instruction_.find(*block_, "ABC"[axis]); }
  [[nodiscard]] Turning turning_of(int axis) const;
  [[nodiscard]] int turn_decimals(int axis) const;
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
    std::array<double, 3> numbers{};
    Turns cut_short{};     ///< corrections that would have turned an axis another way, rad
    double direction = 0;  ///< what is left between the tool axes, rad
    bool held = false;
  };
  std::optional<Stop> stop_at(const Move& move, double s, const Turns& from);
  bool bends(const Move& move, const Stop& a, const Stop& b);
  bool split_turn(const Move& move, const Stop& a, const Stop& b, int depth, std::vector<Stop>& stops);
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
  bool fit_piece(const Arc& nominal, double s0, double s1, const Vec3& start, bool whole, ArcPiece& piece);
  Vec3 rounded_end(const Vec3& want, const Vec3& p_out, bool first) const;
  [[nodiscard]] Value centre_value(int k, double centre, const Vec3& start, bool first, double& base) const;
  [[nodiscard]] std::optional<PlaneWay> written_way(const ArcPiece& piece, const Vec3& start,
                                                    const Vec3& end) const;
  void command_centre(const ArcPiece& piece, const Vec3& start, bool first, std::string* extra);

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
    double r = 0, z = 0;
    Vec3 first = Vec3::Zero(), step = Vec3::Zero();
    [[nodiscard]] Vec3 last() const { return first + (count - 1) * step; }
  };
  bool read_holes(Holes& holes);
  bool keep_depth(int n);
  bool shift_of(const Holes& holes, Vec3& shift);
  [[nodiscard]] bool keeps_levels() const { return profile_.cycles.sticky == Profile::Sticky::levels; }
  double write_holes(const Holes& holes, const Vec3& shift, std::string& out, Vec3& p_out);

  [[nodiscard]] int decimals_of(const Word* word) const;
  [[nodiscard]] double digit_room() const;
  [[nodiscard]] double half_digit(int decimals) const;  ///< program units
  [[nodiscard]] const Word* axis_word(int axis) const { return instruction_.find(*block_, "XYZ"[axis]); }

  const RewriteJob& job_;
  const std::shared_ptr<const Profile> shared_profile_;
  const Profile& profile_;
  RewriteReport& report_;
  const Machine& machine_;
  CorrectionField field_;
  ProgramFindings findings_;
  double interpolation_;     ///< mm
  double short_enough_ = 0;  ///< mm: a move up to this length is not looked into
  bool angular_;

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
  } cycle_;

  /// Where a correction was larger than before, and what it was reckoned with.
  struct Extreme {
    Vec3 m = Vec3::Zero(), datum = Vec3::Zero();
    double gauge = 0;
    bool set = false;
  };
  std::array<Extreme, 4> extremes_;  ///< of X, Y, Z, and of the gradient

  /// A subprogram that was run: its lines first .. end - 1, rewritten.
  struct Called {
    std::uint64_t first = 0, end = 0;
    std::string text;
  };
  std::map<std::uint64_t, Called> run_;  ///< by first line
  std::set<int> called_;                 ///< numbers
  std::size_t depth_ = 0;                ///< of calls now running
  std::uint64_t call_line_ = 0;          ///< of the one in the main program
  bool returned_ = false;                ///< the running subprogram came to its M99
  std::uint64_t behind_ = 0;             ///< lines before this one are already written

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

  std::vector<MoveSample> samples_;
  std::vector<ArcTarget> targets_;
  std::vector<Stretch> stretches_;
  std::vector<Piece> pieces_;
  std::string move_text_;  ///< decision in words, for the trace
};

}  // namespace abbe
