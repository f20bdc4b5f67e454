#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// How error matrices enter the chain (docs/theory/chain.md).
enum class ErrorModel {
  rigid,        ///< Err(d,e) = [Exp([e]x), d]
  linear,       ///< Err(d,e) = [I + [e]x, d], inverted as a general affine matrix
  first_order,  ///< actual = nominal + sum of adjoints
};

/// Values of sensors and `t`, and velocities or accelerations held for the whole run ("v.X"), by
/// name, in the units of the machine file.
using Environment = std::map<std::string, double, std::less<>>;

/// The tool as the chain sees it: tip and axis in the bed frame at home.
struct Tool {
  Vec3 tip = Vec3::Zero();    ///< mm
  Vec3 axis = Vec3::UnitZ();  ///< unit vector from the tip to the spindle
};

/// The machine file's tool, or the same mount with another gauge length (mm).
[[nodiscard]] Tool tool_of(const Machine& machine);
[[nodiscard]] Tool tool_of(const Machine& machine, double gauge_length);

/// One question to the model: commanded positions and what else errors may depend on.
struct Query {
  std::array<double, kMaxAxes> q{};              ///< per moving axis, mm or rad
  std::array<signed char, kMaxAxes> approach{};  ///< -1, 0, +1: direction of the last motion
  Tool tool;
  std::span<const double> velocity{};  ///< per moving axis in file units/s; empty = Environment or 0
  std::span<const double> acceleration{};
};

/// A machine compiled for repeated questions in one environment: an immutable value, shared by
/// threads. Axes ordered per branch, absent factors left out, constant errors folded.
class Plan {
 public:
  struct Impl;
  explicit Plan(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  [[nodiscard]] const Machine& machine() const;
  [[nodiscard]] ErrorModel model() const;
  [[nodiscard]] const Impl& impl() const { return *impl_; }

 private:
  std::shared_ptr<const Impl> impl_;
};

/// Sensors that errors need and the environment does not give.
struct MissingSensors {
  std::vector<std::string> names;
};

/// errors   MissingSensors; names in `environment` that no error uses are ignored
[[nodiscard]] std::variant<Plan, MissingSensors> make_plan(const Machine& machine,
                                                           const Environment& environment,
                                                           ErrorModel model = ErrorModel::rigid);

}  // namespace abbe
