#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/chain/plan.h"

namespace abbe {

/// A circular test that a machine is to perform.
struct PlannedCircle {
  TestPlane plane;
  double radius = 0;           ///< mm
  double feed = 0;             ///< along the path, mm/s
  double acceleration = 1000;  ///< along the path while it starts and stops, mm/s^2
  double from = 0, to = 0;     ///< rad, counter-clockwise; to > from
  double overshoot = 0;        ///< rad run in before and out behind the arc, so that the feed is steady on it
  bool counter_clockwise = true, clockwise = true;
  int samples = 1000;          ///< of the ball bar, per direction, on the arc
  Vec3 centre = Vec3::Zero();  ///< axis positions X Y Z, mm
  std::string setup;
};

/// What follows the commands, and what listens.
struct SimulationSettings {
  std::array<double, 3> lag{};   ///< time constant of the position loop of X Y Z, s; first order
  double noise = 0;              ///< standard deviation of a deviation, mm
  double colour = 0;             ///< correlation of neighbouring noise, 0 (white) to below 1
  double clock_offset = 0;       ///< standard deviation of the clock of a run, s
  Vec3 mounting = Vec3::Zero();  ///< how far the workpiece ball is off the stated centre, mm
  double bar_length = 0;         ///< how much longer the bar is than stated, mm
  bool positions = false;        ///< record commanded and actual axis positions beside each deviation
  std::uint64_t seed = 1;
};

/// The bus beside one run, cycle by cycle, from rest to rest.
struct BusRecord {
  std::vector<Vec3> commanded, actual;  ///< X Y Z, mm
};

struct SimulatedCircle {
  BallbarTest test;
  std::vector<BusRecord> bus;  ///< per run
};

/// How long one run takes from rest to rest, s.
[[nodiscard]] double duration_of(const PlannedCircle& circle);

/// A machine with all its errors (those of `plan`, any chain with linear axes named as the plane's) performs
/// the test: runs in, goes round and runs out, with acceleration on the arc; the axes follow with their lag;
/// the distance of the balls is that of the model at actual positions, velocities and accelerations:
///
///     dR(t) = |tip(q(t + clock)) - centre| - R + noise,     angle = commanded angle at t
///
/// cycle    s between bus samples, > 0
/// laws     IdealMachineDrawsACircle, LagShrinksAndTurnsTheTrace, SameSeedSameTrace
/// cost     one evaluation of the model per sample
[[nodiscard]] SimulatedCircle simulate_circle(const Plan& plan, const PlannedCircle& circle,
                                              const SimulationSettings& settings, double cycle = 1e-3);

}  // namespace abbe
