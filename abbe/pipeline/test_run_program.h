#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/test_files.h"
#include "abbe/pipeline/compensate_program.h"

/// One program through the whole way, on the disk for the time of a test.
namespace abbe::testing {

inline std::string findings(const ProgramOutcome& outcome) {
  std::string all;
  for (const auto& d : outcome.diagnostics) all += to_text(d) + "\n";
  return all;
}

struct ProgramRun {
  ProgramOutcome outcome;
  std::string output;
};

/// A work offset, one tool of this length and no header.
inline ProgramJob plain_program_job(double tool_length = 80) {
  ProgramJob job;
  job.header = HeaderForm::none;
  job.setup.work_offsets[0] = WorkOffset{{30, -20, 15}, 0, {}};
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, tool_length}, tool_length, 10, ""};
  return job;
}

/// Compensates the program; `look` sees the job, with its files, and may change what comes of it.
inline ProgramRun run_program(const Plan& plan, const std::string& program, ProgramJob job,
                              const std::function<void(const ProgramJob&, ProgramOutcome&)>& look = {}) {
  const TestFile original(program), corrected("");
  job.program = original.path();
  job.output = corrected.path();
  ProgramRun run;
  run.outcome = compensate_program(plan, job);
  run.output = slurp(job.output);
  if (look) look(job, run.outcome);
  return run;
}

/// What the verification says of the output after its first `from` has become `to`.
inline ProgramOutcome judge_spoiled(const Plan& plan, const ProgramJob& job, const std::string& from,
                                    const std::string& to) {
  std::string text = slurp(job.output);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in\n" << text;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  const TestFile spoiled(text);
  return verify_programs(plan, job, spoiled.path());
}

}  // namespace abbe::testing
