#pragma once

#include <array>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"

namespace abbe {

/// What a dial should show if the machine file states one error with the right sign: a short move of one
/// axis, and the change of the deviation at the tool tip that this error alone causes between its ends.
struct SignCheck {
  std::string error;                    ///< "EYX"
  int axis = -1;                        ///< moving axis of the test move; -1: no move shows the error
  double from = 0, to = 0;              ///< its commands, mm or rad, from < to
  std::array<double, kMaxAxes> pose{};  ///< where all axes stand, `axis` at `from`
  Vec3 travel = Vec3::Zero();           ///< nominal move of the tip, workpiece axes, mm
  Vec3 position = Vec3::Zero();         ///< change of the tip's deviation, workpiece axes, mm
  Vec3 rotation = Vec3::Zero();         ///< change of the tool's rotation, workpiece axes, rad
  std::string words;                    ///< the same as an instruction in one or two sentences
};

/// One check per error of the machine, in file order, in the environment of the plan, with the machine's
/// own tool and mean of both directions of approach. Own axis first, then axes that show the error
/// better; the others stand at zero (or mid travel, or where the error shows). First order.
[[nodiscard]] std::vector<SignCheck> sign_checks(const Plan& plan);

}  // namespace abbe
