#include <algorithm>
#include <cctype>

#include "abbe/chain/correct.h"

namespace abbe {
namespace {

[[nodiscard]] bool has_digit(const std::string& name) {
  return std::any_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

[[nodiscard]] bool is_secondary(const std::string& name) { return name == "U" || name == "V" || name == "W"; }

[[nodiscard]] int count(AxisSet set) {
  int n = 0;
  for (; set != 0; set &= set - 1) ++n;
  return n;
}

template <class Predicate>
[[nodiscard]] AxisSet without(const Machine& machine, AxisSet set, Predicate locked) {
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (locked(machine.axis(i).name)) set &= ~(AxisSet{1} << i);
  }
  return set;
}

/// nullopt if more than `most` remain after the rule for redundant axes.
[[nodiscard]] std::optional<AxisSet> reduce(const Machine& machine, AxisSet set, int most) {
  if (count(set) > most) set = without(machine, set, has_digit);
  if (count(set) > most) set = without(machine, set, is_secondary);
  if (count(set) > most) return std::nullopt;
  return set;
}

}  // namespace

std::optional<AxisSet> free_axes(const Machine& machine, AxisSet locked) {
  AxisSet linear = 0, rotary = 0;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const AxisSet bit = AxisSet{1} << i;
    const Body& body = machine.axis(i);
    if (!body.correctable || (locked & bit) != 0) continue;
    (body.type == AxisType::rotary ? rotary : linear) |= bit;
  }
  const std::optional<AxisSet> few_linear = reduce(machine, linear, 3),
                               few_rotary = reduce(machine, rotary, 2);
  if (!few_linear.has_value() || !few_rotary.has_value()) return std::nullopt;
  return *few_linear | *few_rotary;
}

}  // namespace abbe
