#pragma once

// What the benches of poses share: an error table of 100 nodes, and path data.

#include <cmath>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"

namespace abbe::bench {

inline constexpr std::size_t kPoses = 1024;

inline std::string table(const std::string& name, int seed, double amplitude, double lo, double hi) {
  std::string text = name + " = { interpolation = \"cubic\", table = [";
  for (int i = 0; i < 100; ++i) {
    const double x = lo + (hi - lo) * i / 99;
    text += (i > 0 ? ", [" : "[") + std::to_string(x) + ", " +
            std::to_string(amplitude * std::sin(0.07 * i + seed)) + "]";
  }
  return text + "] }\n";
}

/// A smooth path of kPoses poses away from the singular pose, `step` rad of its parameter apart.
inline std::vector<Query> path(const Machine& machine, double step) {
  std::vector<Query> queries;
  for (std::size_t i = 0; i < kPoses; ++i) {
    const double t = static_cast<double>(i) * step;
    Query query;
    query.tool = tool_of(machine);
    const auto set = [&](const char* name, double value) {
      if (const int k = machine.find_axis(name); k >= 0) query.q[static_cast<std::size_t>(k)] = value;
    };
    set("X", 200 * std::sin(t));
    set("Y", 150 * std::cos(1.3 * t));
    set("Z", 60 * std::sin(0.7 * t) - 40);
    set("A", 0.6 + 0.4 * std::sin(0.9 * t));
    set("C", 1.5 * std::sin(0.5 * t));
    queries.push_back(query);
  }
  return queries;
}

}  // namespace abbe::bench
