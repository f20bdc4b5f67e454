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
/// units    mm or rad per mm or rad of the error
/// laws     EffectsAddUpToThePrediction
/// cost     one first-order prediction per error and pose
class UnitEffects {
 public:
  /// nullopt: a name does not belong to this machine.
  [[nodiscard]] static std::optional<UnitEffects> make(const Machine& machine,
                                                       const std::vector<std::string>& names);

  [[nodiscard]] std::size_t count() const { return plans_.size(); }
  /// Deviation of the tip of query.tool in workpiece axes, and rotation of the tool in workpiece axes.
  [[nodiscard]] Twist at(std::size_t error, const Query& query) const;

 private:
  std::vector<Plan> plans_;
};

}  // namespace abbe
