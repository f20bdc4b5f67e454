#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "abbe/chain/predict.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// What one unit of each of some errors does to the tool at a pose, by the chain's own first-order model: the
/// columns of every fit. Where an error is seen (errors_seen), on which line it is stated (measured_at) and
/// in which order it acts (location) is the machine file's.
///
/// Where no axis turns, an effect is affine in positions and tip, and is asked for once:
///
///   displacement = c + G (q, tip),   rotation constant
///
/// units    mm or rad per mm or rad of the error
/// laws     EffectsAddUpToThePrediction, AffineEffectsAreThePredictions
/// cost     one first-order prediction per error and pose; without rotary axes 3 (axes + 3) multiplications
class UnitEffects {
 public:
  /// nullopt: a name does not belong to this machine.
  [[nodiscard]] static std::optional<UnitEffects> make(const Machine& machine,
                                                       const std::vector<std::string>& names);

  [[nodiscard]] std::size_t count() const { return plans_.size(); }
  /// Deviation of the tip of query.tool in workpiece axes, and rotation of the tool in workpiece axes.
  [[nodiscard]] Twist at(std::size_t error, const Query& query) const;

 private:
  /// G: a column per axis, then three of the tip.
  struct Affine {
    Twist constant;
    Eigen::Matrix3Xd gradient;
  };
  static Twist predicted(const Plan& plan, const Query& query);
  static Affine affine_of(const Plan& plan, Eigen::Index axes);

  std::vector<Plan> plans_;
  std::vector<Affine> affine_;  ///< empty if an axis turns
};

}  // namespace abbe
