#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"

namespace abbe {

/// Axes as a bit set: bit i = moving axis i.
using AxisSet = std::uint32_t;

/// How the commands are found (docs/theory/correction.md, section 10 says which to take when):
enum class Method {
  newton,       ///< iterates on the model; any chain
  one_step,     ///< the differential step at the command: first order; any chain
  closed_form,  ///< exact for frozen errors, repeated with errors at the corrected commands
  printed,      ///< the first-order equations printed in seed 003, for that chain only
};
[[nodiscard]] std::string_view to_string(Method method);

/// docs/machine-file.md, section Correction. partial: an axis is missing or locked for part of the
/// position; degraded: an axis was held near a singularity or limit; failed: corrected = commanded.
enum class Status { ok, partial, degraded, failed };
[[nodiscard]] std::string_view to_string(Status status);

struct CorrectOptions {
  Method method = Method::newton;
  AxisSet locked = 0;  ///< in addition to axes that are not correctable
  /// Redundant free axes only: sum (weight_i dq_i)^2 (mm, rad) is minimised; 0 stands for 1.
  std::array<double, kMaxAxes> weights{};
  double max_rotary_correction = 0.5 * deg;  ///< beyond it the axis is held at its command
  /// The pose that is wanted, workpiece axes; null: the nominal pose of the command. The caller keeps it.
  const TipAndAxis* target = nullptr;
  Vec3 target_shift = Vec3::Zero();  ///< workpiece axes, mm: the tip shall reach nominal + shift (datum)
  /// The iteration ends when the next step is bound to be smaller, by the measured rate of contraction
  /// (by 1/16 after the first step). With a close start and a loose tolerance that is one evaluation.
  double position_tolerance = 1e-9;   ///< mm
  double rotation_tolerance = 1e-12;  ///< rad
  int max_iterations = 20;
};

struct Correction {
  std::array<double, kMaxAxes> corrected{};  ///< commands that bring the tool where it was meant to be
  double residual_position =
      0;  ///< mm, distance of the tip from its target (with what the last step may leave)
  double residual_direction = 0;  ///< rad, angle between actual and target tool axes
  Status status = Status::failed;
  int iterations = 0;    ///< model evaluations
  bool outside = false;  ///< an error was held beyond its measured ends
  AxisSet held = 0;      ///< axes held at their command (singularity) or at the end of their travel
};

/// Which axes `correct` may move, after the rule for redundant ones (more than three linear or two
/// rotary correctable axes: names with a digit, then U V W, are locked). nullopt: still ambiguous, the
/// caller must lock some.
[[nodiscard]] std::optional<AxisSet> free_axes(const Machine& machine, AxisSet locked);

/// Corrects one command: rotary axes restore the tool direction, linear axes the position.
/// start     a first guess of the corrected commands, or null (= the command). On a path the best guess
///           is the command plus the correction of the point before. Ignored for redundant axes.
/// status    of one_step and printed: ok means that the whole step could be made; its second-order rest is
///           in the residual, whatever its size. Others: ok means residual_position <= 1e-6 mm.
/// errors    failed for non-finite input, when the iteration does not converge or the method does not fit
///           (ask method_obstacle of method_fit.h first); never NaN. Commands that are no numbers come
///           back as 0
/// laws      ActualOfCorrectedIsNominal, ZeroErrorsChangeNothing, WarmStartGivesTheSameAnswer,
///           ClosedFormEqualsNewton
/// cost      no allocation; one model evaluation per iteration, closed_form one more. printed allocates
/// source    docs/theory/correction.md
[[nodiscard]] Correction correct(const Plan& plan, const Query& query, AxisSet free,
                                 const CorrectOptions& options,
                                 const std::array<double, kMaxAxes>* start = nullptr);

}  // namespace abbe
