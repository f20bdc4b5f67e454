#pragma once

#include <string>
#include <vector>

#include "abbe/chain/plan.h"

namespace abbe {

/// Pose of the tool in the workpiece: T_wt. In the linear and first-order models R need not be
/// orthonormal.
struct Pose {
  Mat3 R = Mat3::Identity();
  Vec3 p = Vec3::Zero();  ///< mm
};

/// Translation (mm) and small rotation (rad), in the axes and at the origin the owner names.
struct Twist {
  Vec3 d = Vec3::Zero();
  Vec3 e = Vec3::Zero();
};

struct TipAndAxis {
  Vec3 position = Vec3::Zero();   ///< of the tip in workpiece axes, mm
  Vec3 tool_axis = Vec3::Zero();  ///< rotation * tool axis; not normalised in linear and first-order
};

/// Everything the model says about one query (docs/theory/chain.md for the formulas).
struct Prediction {
  TipAndAxis nominal, actual, deviation;  ///< deviation = actual - nominal
  Twist tool_twist;                       ///< of T_wt_nominal^-1 T_wt_actual, ideal tool frame, at the tip
  std::vector<std::string> extrapolated;  ///< names of errors held beyond their ends, in file order
  bool finite = true;                     ///< false: overflow; every number above is then 0
};

[[nodiscard]] Prediction predict(const Plan& plan, const Query& query);

[[nodiscard]] Pose nominal_pose(const Plan& plan, const Query& query);

/// `outside` (may be null) is set when an error was held beyond its ends; never cleared.
[[nodiscard]] Pose actual_pose(const Plan& plan, const Query& query, bool* outside = nullptr);

/// Tip position only, in workpiece axes: the hot path of programs. No allocation.
[[nodiscard]] Vec3 nominal_tip(const Plan& plan, const Query& query);
[[nodiscard]] Vec3 actual_tip(const Plan& plan, const Query& query, bool* outside = nullptr);

/// First-order effect of a unit of each moving axis on the tip, nominal chain:
/// column i = d position_w / d q_i (mm per mm or mm per rad) and d tool_axis_w / d q_i.
struct Jacobian {
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxAxes> position;
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxAxes> tool_axis;
};
[[nodiscard]] Jacobian jacobian(const Plan& plan, const Query& query);

}  // namespace abbe
