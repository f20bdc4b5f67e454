#pragma once

#include <string>

#include "abbe/cl/verify_cl.h"
#include "abbe/cl/verify_machine.h"
#include "abbe/cl/verify_path.h"
#include "abbe/core/path_tally.h"

namespace abbe::cl::verifying {

/// Holds the steps of the output against those of the original.
class Comparison {
 public:
  Comparison(const Plan& plan, AxisSet free, const ClVerifyJob& job, VerifyReport& report);

  /// True while it makes sense to go on.
  [[nodiscard]] bool run(PathReader& original, PathReader& output, const Progress& progress);
  /// Puts sums and samples into the report.
  void finish();

 private:
  /// Where a motion of the original begins: the commands there.
  struct Stand {
    bool known = false;
    std::array<double, kMaxAxes> commands{};
    int side = 0;  ///< of the singularity
  };

  void disagree(const char* code, const Step& original, const Step* output, std::string message);
  [[nodiscard]] std::optional<Step> next_step(PathReader& output);
  [[nodiscard]] bool record(const Step& original, PathReader& output);
  [[nodiscard]] bool motion(const Step& original, PathReader& output);
  [[nodiscard]] bool same_sort(const Step& original, const Step& output, bool first);
  [[nodiscard]] bool next_piece(const Step& original, PathReader& output, Step& piece);
  [[nodiscard]] bool end_of(const Step& original, const Step& piece, const Outcome& there,
                            const Outcome& nominal);
  [[nodiscard]] bool inside(const Step& original, const Step& piece, double from, double to,
                            const Stand& begin, const Outcome& there);
  [[nodiscard]] bool hole(const Step& original, const Step& piece, const Outcome& nominal);
  [[nodiscard]] bool fit_to_run(const Step& original, const Step& piece, const Outcome& there);
  [[nodiscard]] bool direction_agrees(const Step& original, const Step& piece, const Outcome& there,
                                      const Outcome& nominal);
  [[nodiscard]] double progress_of(const Step& original, const Vec3& tip, const Vec3& axis) const;
  [[nodiscard]] bool close_to_end(const Step& original, const Outcome& there) const;
  void use_tool(const Step& original);
  void count(const Step& original, const Vec3& nominal, const Vec3& before, const Vec3& after, double way);

  const Plan& plan_;
  const ClVerifyJob& job_;
  VerifyReport& report_;
  ForwardMachine machine_;
  Stand stand_;
  bool tool_used_ = false, header_over_ = false, going_on_ = true;
  std::optional<int> tool_;
  std::optional<std::string> circle_skeleton_;
  double worst_turn_ = 0;  ///< rad: largest tilt of the uncorrected tool so far
  DeviationTally before_, after_;
  SampleKeeper samples_;
  int disagreements_ = 0;
};

/// Tip and tool axis of a step at s in [0, 1].
struct TipAxis {
  Vec3 tip, axis;
};
[[nodiscard]] TipAxis on_step(const Step& step, double s);

}  // namespace abbe::cl::verifying
