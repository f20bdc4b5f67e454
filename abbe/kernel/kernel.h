#pragma once

#include <cstddef>
#include <string_view>

#include "abbe/kernel/flat_view.h"

namespace abbe::kernel {

/// The tool and the axes of a batch.
struct Setting {
  double tip[3] = {0, 0, 0};                  ///< of the tool, bed frame at home, mm
  double axis[3] = {0, 0, 1};                 ///< from the tip to the spindle
  double shift[3] = {0, 0, 0};                ///< the tip shall reach nominal + shift, workpiece axes, mm
  signed char approach[kMaxFlatAxes] = {};    ///< -1, 0, +1 per axis: direction of the last motion
  std::uint32_t free = 0;                     ///< axes that correct_poses may move
  int exact_steps = 1;                        ///< 0: first order only
  double max_rotary = 8.726646259971648e-03;  ///< larger rotary corrections are unusual; 0.5 deg
};

/// How a lane ended.
enum Lane : unsigned char {
  ordinary = 0,
  outside = 1,  ///< an error was held beyond its ends
  unusual = 2,  ///< near a singularity, or not finite: ask abbe::correct
};

/// What the first half of a correction leaves for the second (Kernel::estimate_poses). Of one machine.
struct PoseWork {
  static constexpr std::size_t kMost = 16;
  alignas(64) double nominal[6][kMost];    ///< tip and tool axis where they are meant to be
  alignas(64) double turn_rows[6][kMost];  ///< of the inverse Jacobian, by components: two rotary axes
  alignas(64) double move_rows[9][kMost];  ///< three linear axes
  alignas(64) double follow[6][kMost];  ///< ways of the linear axes, tip at rest, by radian of a rotary one
  Place places[kPlaces];
};

/// What one instruction set offers. Positions and results are arrays per axis or component (structure of
/// arrays): q[axis][i], mm and rad. No call allocates, locks or throws.
struct Kernel {
  const char* name = "";
  int width = 1;  ///< poses side by side
  /// The actual tip of one pose: q[axis], tip[0..2]. *lane |= outside.
  void (*one_tip)(const FlatView&, const double* tool_tip, const signed char* approach, const double* q,
                  double* tip, unsigned char* lane) = nullptr;
  /// The actual tips of `count` poses with one tool and approach: tip[0..2][pose]. lanes[pose] |= outside.
  void (*tips)(const FlatView&, const double* tool_tip, const signed char* approach, const double* const* q,
               std::size_t count, double* const* tip, unsigned char* lanes) = nullptr;
  /// The actual tips and tool axes of `count` poses: pose[0..2][i] and pose[3..5][i]. lanes[i] |= outside.
  void (*poses)(const FlatView&, const Setting&, const double* const* q, std::size_t count,
                double* const* pose, unsigned char* lanes) = nullptr;
  /// Corrected commands of `count` poses (all axes): a first-order step, then Setting::exact_steps Newton
  /// steps on the exact model. last[i]: length of the last step, mm (rotary steps count 300 mm per rad). An
  /// unusual lane's commands mean nothing. Needs corrects(view, free). Batches do what they may in single
  /// precision (docs/theory/kernels.md): a first-order correction was found off by up to 1e-8 mm and 1e-6 of
  /// itself and of the way by which its rotary part moves the tip; more of itself where large errors cancel.
  void (*correct_poses)(const FlatView&, const Setting&, const double* const* q, std::size_t count,
                        double* const* corrected, double* last, unsigned char* lanes) = nullptr;
  /// The first half of a correction of PoseWork::kMost poses of which two rotary axes are free, a step of
  /// first order: estimate[axis][i] of all axes. `work` is for the second half. lanes[i] |= flags.
  void (*estimate_poses)(const FlatView&, const Setting&, const double* const* q, double* const* estimate,
                         PoseWork& work, unsigned char* lanes) = nullptr;
  /// The second half, a Newton step on the exact model: found[axis][i] are the rotary axes of the corrected
  /// pose, and the linear axes that bring the tip there while the rotary ones (free, in the order of their
  /// numbers) stand at stand[0..1][i], near their estimates. turn_left[i] (rad) and way_left[i] (mm): lengths
  /// of the two parts of the step.
  void (*refine_poses)(const FlatView&, const Setting&, const PoseWork& work, const double* const* estimate,
                       const double* const* stand, double* const* found, double* turn_left, double* way_left,
                       unsigned char* lanes) = nullptr;
};

/// Three linear axes and up to two rotary ones are free: what correct_poses can do.
[[nodiscard]] bool corrects(const FlatView& view, std::uint32_t free);

/// The best kernel for this processor.
[[nodiscard]] const Kernel& best();
/// "baseline", "avx2", "avx512"; null if this processor (or build) has none of that name.
[[nodiscard]] const Kernel* named(std::string_view name);

}  // namespace abbe::kernel
