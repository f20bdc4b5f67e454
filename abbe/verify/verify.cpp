#include "abbe/verify/verify.h"

#include <algorithm>
#include <utility>

#include "abbe/verify/comparison.h"
#include "abbe/verify/reader.h"
#include "abbe/verify/tip_model.h"

namespace abbe {
namespace {

using verifying::Comparison;
using verifying::ProgramReader;
using verifying::TipModel;

Diagnostic unreadable(const std::string& name, const FileError& error) {
  return {Severity::error,        "E-FILE",        {name, 0, 0, 0, {}}, error.message,
          "it could not be read", "check the path"};
}

/// Reads what is left, for the size and the checksum of the whole file.
ProgramFacts facts_of(ProgramReader& reader) {
  LineReader& file = reader.file();
  file.read_on();
  ProgramFacts facts;
  facts.lines = file.line_number();
  facts.bytes = file.bytes_read();
  facts.sha256 = file.sha256();
  return facts;
}

struct Pass {
  ProgramReader::Options options;
  std::uint64_t number = 0, count = 1;
  bool saw_deletable = false;
};

/// Compares the two files once. Facts and identity are filled in as well.
void run_pass(TipModel model, const VerifyJob& job, Pass& pass, VerifyReport& report,
              const Progress& progress) {
  auto original = ProgramReader::open(job.original_path, job.original_name, job.setup, pass.options);
  ProgramReader::Options output_options = pass.options;
  output_options.looks_ahead = true;
  output_options.growth = job.output_growth;
  auto output = ProgramReader::open(job.output_path, job.output_name, job.setup, output_options);
  if (const auto* error = std::get_if<FileError>(&original))
    report.diagnostics.push_back(unreadable(job.original_name, *error));
  if (const auto* error = std::get_if<FileError>(&output))
    report.diagnostics.push_back(unreadable(job.output_name, *error));
  if (!report.diagnostics.empty()) return;
  auto& first = std::get<ProgramReader>(original);
  auto& second = std::get<ProgramReader>(output);
  report.original_identity = first.file().identity();

  const auto keep_going = [&] {
    if (!progress) return true;
    const std::uint64_t size = first.file().identity().size;
    return progress(pass.number * size + first.file().bytes_read(), pass.count * size);
  };
  Comparison comparison(job, model, first, second, report);
  comparison.run(keep_going);
  comparison.finish();
  pass.saw_deletable = first.saw_deletable() || second.saw_deletable();
  if (report.stopped) return;
  if (!pass.options.hashed) return;
  report.original = facts_of(first);
  report.output = facts_of(second);
}

}  // namespace

VerifyReport verify_program(const Plan& plan, const VerifyJob& job, const Progress& progress) {
  VerifyReport report;
  auto model = TipModel::make(plan, job.setup);
  if (auto* fault = std::get_if<Diagnostic>(&model)) {
    report.diagnostics.push_back(std::move(*fault));
    return report;
  }
  const TipModel& tips = std::get<TipModel>(model);
  const bool skip = job.setup.block_delete == ControlSetup::BlockDelete::on;
  Pass pass;
  pass.options.skip_deletable = pass.options.report_skipped = skip;
  pass.options.rotary = &tips.rotary();
  run_pass(tips, job, pass, report, progress);

  // Nobody said whether '/' blocks run: both ways must agree.
  const bool unknown = job.setup.block_delete == ControlSetup::BlockDelete::unknown;
  if (unknown && pass.saw_deletable && !report.stopped && report.diagnostics.empty()) {
    Pass skipped;
    skipped.options.skip_deletable = true;
    skipped.options.hashed = false;
    skipped.options.rotary = &tips.rotary();
    skipped.number = 1;
    skipped.count = 2;
    VerifyReport second;
    run_pass(tips, job, skipped, second, progress);
    report.stopped = second.stopped;
    for (Diagnostic& d : second.diagnostics) {
      d.message = "with the blocks marked '/' skipped: " + d.message;
      report.diagnostics.push_back(std::move(d));
    }
    report.quantisation = std::max(report.quantisation, second.quantisation);
  }
  report.allowed = job.tolerance + report.quantisation;
  report.agrees = !report.stopped && !has_errors(report.diagnostics);
  return report;
}

}  // namespace abbe
