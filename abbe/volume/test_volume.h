#pragma once

#include <string>
#include <utility>
#include <variant>

#include "abbe/chain/plan.h"
#include "abbe/machine/test_machines.h"
#include "abbe/volume/map.h"

namespace abbe::test {

/// Column machine, tool side only: the tip is at the commanded position. `errors` in um and urad.
inline Machine column_machine(const std::string& errors) {
  const Parsed<Machine> parsed = read(
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n"
      "[axis.X]\nrange = [0, 500]\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [0, 300]\n"
      "[errors]\n" +
      errors);
  return parsed.value.value_or(Machine{});
}

inline Plan plan_of(const Machine& machine, ErrorModel model = ErrorModel::first_order,
                    const Environment& environment = {}) {
  return std::get<Plan>(make_plan(machine, environment, model));
}

/// `count` positions of every axis over its range.
inline VolumeQuestion question_of(const Machine& machine, std::size_t count) {
  VolumeQuestion question;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const std::array<double, 2> range = machine.axis(i).range.value_or(std::array<double, 2>{-1, 1});
    question.grid.positions.push_back(*spaced(range[0], range[1], count));
  }
  question.circumstances.tool = tool_of(machine);
  question.datum = default_datum(question.grid);
  return question;
}

}  // namespace abbe::test
