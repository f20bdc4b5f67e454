#pragma once

#include "abbe/core/units.h"
#include "abbe/evaluate/run_table.h"

namespace abbe::test {

/// Five targets, five runs in both directions: published with the acceptance report of a slit axis of the
/// ESS "ecmc" project (actual positions in mm, directions as labelled there).
inline RunTable slit_axis() {
  RunTable table;
  table.targets = {15.0, 25.2, 35.4, 45.6, 55.8};
  Eigen::MatrixXd up(5, 5), down(5, 5);
  up << 15.00335, 15.00233, 15.00172, 15.00213, 15.00172, 25.19974, 25.20015, 25.20096, 25.20056, 25.20056,
      35.40102, 35.39960, 35.40225, 35.40306, 35.40449, 45.59151, 45.59090, 45.59212, 45.59090, 45.58947,
      55.80583, 55.80624, 55.80685, 55.80562, 55.80562;
  down << 15.00518, 15.00518, 15.00416, 15.00335, 15.00314, 25.19628, 25.19607, 25.19567, 25.19587, 25.19526,
      35.39817, 35.39837, 35.39980, 35.39939, 35.40000, 45.59232, 45.59191, 45.59293, 45.59191, 45.59151,
      55.80705, 55.80725, 55.80705, 55.80705, 55.80644;
  const Eigen::Map<const Eigen::VectorXd> targets(table.targets.data(), 5);
  table.forward = up.colwise() - targets;
  table.backward = down.colwise() - targets;
  return table;
}

}  // namespace abbe::test
