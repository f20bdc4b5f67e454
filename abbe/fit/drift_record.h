#pragma once

#include <array>
#include <string>
#include <vector>

#include "abbe/core/linear_algebra.h"
#include "abbe/machine/machine.h"

namespace abbe {

/// One sensor of displacement or tilt beside a warm machine.
struct DriftReading {
  std::string column;  ///< in the log
  Vec3 direction =
      Vec3::Zero();  ///< bed axes: along it a displacement, about it a tilt, of tool relative to work
  bool rotation = false;
  Vec3 point = Vec3::Zero();   ///< bed frame at home, carried by the tool
  double sign = 1;             ///< -1: the instrument shows the opposite
  std::vector<double> values;  ///< mm or rad, one per time
};

/// A log: temperatures, and what a machine at rest in one pose did meanwhile.
struct FitDrift {
  std::string file;
  std::array<double, kMaxAxes> at{};              ///< mm or rad
  bool validation = false;                        ///< only judges what the other records say
  bool settled = false;                           ///< the machine was in equilibrium when it began
  bool planned = false;                           ///< not measured yet: no times, no values
  std::vector<double> times;                      ///< s, increasing
  std::vector<std::vector<double>> temperatures;  ///< degC, of every sensor of FitThermal at every time
  std::vector<DriftReading> readings;
};

/// What a thermal fit looks for, and how.
struct FitThermal {
  std::vector<std::string> errors;  ///< names that drift: TXS, TAS ..
  std::vector<std::string>
      sensors;            ///< columns of the logs; if the job names none, all in degC of the first log
  double reference = 20;  ///< degC: at these temperatures the errors are zero
  enum class Model { automatic, linear, lag } model = Model::automatic;
  enum class Selection { stepwise, ridge, all } selection = Selection::stepwise;
  int most_sensors = 3;      ///< of a stepwise choice
  double correlated = 0.95;  ///< sensors whose correlation is above this form a group
};

}  // namespace abbe
