#include "abbe/cl/verify_cl.h"

#include <algorithm>
#include <utility>

#include "abbe/cl/verify_compare.h"

namespace abbe {
namespace {

using cl::verifying::PathReader;

cl::verifying::Reading reading_of(const ClVerifyJob& job) {
  cl::verifying::Reading reading;
  reading.unit = job.conventions.unit;
  reading.turn_all = job.conventions.axis_rule == cl::AxisRule::correct;
  reading.turn_none = job.conventions.axis_rule == cl::AxisRule::keep;
  reading.hand = job.conventions.circle_hand == cl::CircleHand::right  ? 1
                 : job.conventions.circle_hand == cl::CircleHand::left ? -1
                                                                       : 0;
  reading.pass_words = job.conventions.pass_words;
  reading.tool_change_keeps_place = job.conventions.tool_change_keeps_place;
  reading.tool = job.setup.loaded_tool;
  return reading;
}

Diagnostic about_file(const std::string& name, const char* code, std::string message) {
  return {Severity::error,    code, Place{name, 0, 0, 1, {}},
          std::move(message), {},   "check the path and the machine file"};
}

ProgramFacts facts_of(LineReader& file) {
  file.read_on();
  return {file.line_number(), file.bytes_read(), file.sha256()};
}

}  // namespace

VerifyReport verify_cl(const Plan& plan, const ClVerifyJob& job, const Progress& progress) {
  VerifyReport report;
  const auto free = free_axes(plan.machine(), 0);
  if (!free) {
    report.diagnostics.push_back(about_file(job.original_name, "E-MACHINE",
                                            "more than three linear or two rotary axes could be moved"));
    return report;
  }
  auto original_file = LineReader::open(job.original_path),
       output_file = LineReader::open(job.output_path, true, job.output_growth);
  for (const auto* opened : {&original_file, &output_file}) {
    if (const auto* error = std::get_if<FileError>(opened))
      report.diagnostics.push_back(about_file(job.original_name, "E-FILE", error->message));
  }
  if (!report.diagnostics.empty()) return report;
  const auto reading = reading_of(job);
  PathReader original(std::move(std::get<LineReader>(original_file)), job.original_name, reading);
  PathReader output(std::move(std::get<LineReader>(output_file)), job.output_name, reading);
  report.original_identity = original.file().identity();
  cl::verifying::Comparison comparison(plan, *free, job, report);
  const bool same = comparison.run(original, output, progress);
  comparison.finish();
  for (const auto* fault : {&original.fault(), &output.fault()}) {
    if (*fault) report.diagnostics.push_back(**fault);
  }
  report.original = facts_of(original.file());
  report.output = facts_of(output.file());
  report.agrees = same && !has_errors(report.diagnostics);
  return report;
}

}  // namespace abbe
