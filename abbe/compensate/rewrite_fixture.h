#pragma once

// For tests: a program as text in, the compensated text out.

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "abbe/compensate/rewrite.h"
#include "abbe/core/test_files.h"
#include "abbe/machine/machine.h"

namespace abbe::testing {

/// A three-axis machine "w b X Y Z t" whose errors are given as (name, function) in mm and rad.
inline Machine three_axes(std::vector<std::pair<std::string, ErrorFunction>> errors) {
  Machine machine;
  machine.name = "test";
  machine.chain = "w b X Y Z t";
  machine.units = FileUnits{1, 1, 1, 1};
  for (int k = 0; k < 3; ++k) {
    Body body;
    body.name = body.address = std::string(1, "XYZ"[k]);
    body.direction = Vec3::Unit(k);
    body.order = line_order();
    body.axis = k;
    machine.bodies.push_back(body);
    machine.axes.push_back(k);
    machine.variables.push_back({Variable::Kind::position, body.name, k});
  }
  for (auto& [name, function] : errors) {
    ErrorTerm term;
    term.name = *read_error_name(name);
    term.body = term.name.axis == "X" ? 0 : term.name.axis == "Y" ? 1 : 2;
    term.function = std::move(function);
    machine.errors.push_back(std::move(term));
  }
  return machine;
}

inline ErrorFunction poly(int variable, std::vector<double> coefficients) {
  return *ErrorFunction::polynomial(variable, std::move(coefficients));
}

struct Rewritten {
  RewriteReport report;
  std::string text;
  [[nodiscard]] bool has(const std::string& code) const {
    for (const auto& d : report.diagnostics) {
      if (d.code == code) return true;
    }
    return false;
  }
  [[nodiscard]] std::string findings() const {
    std::string all;
    for (const auto& d : report.diagnostics) all += to_text(d) + "\n";
    return all;
  }
};

/// Work offset G54 at machine zero and an ideal datum unless the job says otherwise.
inline RewriteJob plain_job() {
  RewriteJob job;
  job.probed_datum = false;
  job.setup.work_offsets[0] = WorkOffset{};
  return job;
}

inline Rewritten rewrite(const Machine& machine, const std::string& program, RewriteJob job = plain_job()) {
  const TestFile original(program);
  job.path = original.path();
  job.name = "part.ngc";
  auto spool = SpoolFile::create("-");
  auto plan = make_plan(machine, {});
  Rewritten result;
  auto& file = std::get<SpoolFile>(spool);
  result.report = rewrite_program(std::get<Plan>(plan), job, file);
  if (file.flush()) result.text = slurp(file.temporary_path());
  return result;
}

}  // namespace abbe::testing
