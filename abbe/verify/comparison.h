#pragma once

#include <map>
#include <optional>
#include <string>

#include "abbe/core/path_tally.h"
#include "abbe/verify/nominal_path.h"
#include "abbe/verify/plain_lane.h"
#include "abbe/verify/reader.h"
#include "abbe/verify/tip_model.h"
#include "abbe/verify/verify.h"

namespace abbe::verifying {

/// "Z leaves its travel: 12.3456 mm"; axes 0 1 2 = X Y Z (mm), 3 4 5 = A B C (rad).
[[nodiscard]] std::string travel_message(int axis, double at);

/// Walks through original and output in lockstep and writes what differs into a report
/// (docs/theory/verification.md). One comparison per pair of readers.
class Comparison {
 public:
  Comparison(const VerifyJob& job, TipModel& model, ProgramReader& original, ProgramReader& output,
             VerifyReport& report);

  /// Called now and then; false stops the work.
  using KeepGoing = std::function<bool()>;
  void run(const KeepGoing& keep_going);

  /// Puts sums and samples into the report.
  void finish();

 private:
  using Item = ProgramReader::Item;

  // comparison.cpp: items and events
  void compare_event();
  void compare_frames();
  void note_direction(const Motion& original);
  void compare_motion();
  Item pull();         ///< the output's next item
  bool pull_motion();  ///< the output's next item must be a motion
  void put_back(Item item) { put_back_ = item; }
  [[gnu::cold]] void explain_disorder(Item found, const Event* expected);
  [[gnu::cold]] void disagree(const char* code, std::string message);
  [[gnu::cold]] void disagree_and_stop(const char* code, std::string message);
  [[gnu::cold]] void refused(const ProgramReader& reader);
  void update_context();

  // compare_point.cpp: motions of which only points count
  void compare_rapid(const Motion& original, const Motion& output, Axes unjudged = 0);
  void compare_words(const Motion& original, const Motion& output);
  void compare_machine_move(const Motion& original, const Motion& output);
  void compare_cycle(const Motion& original, const Motion& output);
  void compare_hole(const Motion& original, const Motion& output, const Vec3& shift,
                    const Vec3& output_shift);
  bool skip_step_to_hole(const Motion& expected);
  void compare_stroke(const Motion& original, const Motion& output, const Vec3& shift,
                      const Vec3& output_shift);
  [[nodiscard]] Axes commanded(const Motion& original) const;
  void follow_known(const Motion& original);
  bool check_withheld(const Motion& original, const Motion& output);
  void check_reach(const Vec3& original, const Vec3& output);
  void measure_lost_motion(const Vec3& command);

  // cover.cpp: feed motions
  struct Cover;
  void look_up_straight_reach();
  void cover(const Motion& original);
  bool cover_piece(Cover& cover, const Motion& piece);
  void follow_along(const Cover& cover, double t);
  void follow_at(const Cover& cover, double s);
  void check_time(const Motion& piece, double length);
  void disagree_on_time(double time);
  bool take_up(Cover& cover, const Motion& piece);
  void sample_interval(Cover& cover, const Motion& piece, double from, const Vec3& error_from, double to,
                       const Vec3& error_to, const Vec3& tip_to, int depth);
  void account(Cover& cover, const Motion& piece, double t, const Vec3& command, const Vec3& tip);
  void conclude(Cover& cover);

  // cover_drill.cpp: drilling cycles that the output has as lines and rapids
  void cover_drill(const Motion& original);
  bool drill_hole(const Motion& stroke, const Vec3& clear, Vec3& stood);
  bool rapid_to(const Vec3& place, const Vec3& way, Vec3& stood);
  bool stops_at_bottom(const Motion& original);
  bool rise(const Motion& stroke, Vec3& stood);
  bool pull_rapid(Vec3& end);
  bool take_rapid();
  // cover_cutter.cpp: under cutter radius compensation
  Vec3 tip_beside(const Motion& piece, double t, const Vec3& command, bool* outside);
  [[nodiscard]] Vec3 centre_of(const Motion& piece, double t, const Vec3& command) const;
  void check_beside(const Motion& original, const Motion& piece, double s);
  void compare_change(const Motion& original);
  // compare_nurbs.cpp: curves by control points
  void compare_nurbs(const Motion& original, const Motion& output);
  void sample_nurbs(const Motion& original, const Motion& output);

  // cover_turning.cpp: feed motions with rotary axes
  struct TurnCover;
  void cover_turning(const Motion& original);
  bool turn_piece(TurnCover& cover, const Motion& piece);
  void turn_sample(TurnCover& cover, const Motion& piece, double t);
  void find_foot(TurnCover& cover, const TipAndAxis& is, const Turns& turns);
  TipAndAxis meant(const TurnCover& cover, double s);
  TipAndAxis done(TurnCover& cover, const Motion& piece, double t);
  void conclude_turning(TurnCover& cover);
  [[nodiscard]] double times_per_minute(const Motion& original) const;
  void check_turning_time(const TurnCover& cover, double share);
  void check_share(TurnCover& cover, const Motion& piece, double share, bool whole);
  void check_turning_feed(const TurnCover& cover);
  bool begins_timed(const Event& found) const;
  void end_timed(const Motion& original);
  bool stand(const Turns& original, const Turns& output);
  bool check_turns(const Motion& original, const Motion& output);
  [[nodiscard]] double direction_allowed(const Motion& original, double before) const;
  [[gnu::cold]] void disagree_direction(double after, double before);
  void check_direction(const Motion& original, double after, double before);

  // comparison_plain.cpp: runs of plain motions
  bool compare_plain();
  [[nodiscard]] bool lane_is_open() const;
  void find_poses();
  void find_start();
  void enter_end(std::size_t at);
  void plain_end(std::size_t i, std::size_t j, PlainLane::End& end) const;
  [[nodiscard]] bool commands_agree(const PlainLane::End& from, const PlainLane::End& to) const;
  [[nodiscard]] bool stays_within(std::size_t first, std::size_t last) const;
  void count_run(std::size_t count);
  void count_plain(const PlainLane::End& from, const PlainLane::End& to, std::uint64_t line);

  /// Tip at the start of a motion: mostly where the last one ended, and then already known.
  [[nodiscard]] Vec3 start_tip(const Vec3& command);
  [[nodiscard]] double half_digit() const;  ///< in the units in force, mm
  [[nodiscard]] double quantum() const;     ///< allowance for the digits of a point, mm
  double allowed_for(double quantisation);
  void follow(const Vec3& direction);  ///< approach after a motion in this direction
  void keep_sample(const Vec3& position, const Vec3& before, const Vec3& after, bool rapid);

  const VerifyJob& job_;
  TipModel& model_;
  ProgramReader& original_;
  ProgramReader& output_;
  VerifyReport& report_;
  double half_digit_mm_, half_digit_inch_;  ///< half of the last digit that the control resolves, mm

  bool stop_ = false;
  std::optional<Item> put_back_;  ///< the output's present item, to be pulled once more
  std::size_t disagreements_ = 0;
  bool context_changed_ = true;
  Vec3 datum_ = Vec3::Zero();
  double straight_reach_ = 0;  ///< lines up to here need no look inside, mm
  Axes withheld_ = 0;          ///< left in machine coordinates by G53
  Approach approach_{};
  struct Reached {
    bool valid = false;
    Vec3 command = Vec3::Zero(), tip = Vec3::Zero();
    Approach approach{};
  } reached_;  ///< end of the output's last motion
  struct Beside {
    Vec3 direction = Vec3::Zero();
    double length = 0, narrowing = 1;
  } last_beside_;         ///< the output's last motion in XY under cutter compensation
  double travelled_ = 0;  ///< feed path so far, mm
  bool tcp_ = false;
  bool timed_ = false;    ///< the output has switched to G93 for a motion that the original feeds in G94
  Turns output_turns_{};  ///< of the output after its last motion
  PlainLane lane_;
  DeviationTally before_, after_;
  SampleKeeper samples_;
};

}  // namespace abbe::verifying
