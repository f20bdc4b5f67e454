#include "abbe/pipeline/compensate_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "abbe/core/file.h"
#include "abbe/pipeline/cl_program.h"
#include "abbe/report/figure.h"
#include "abbe/report/header.h"

namespace abbe {
namespace {

// Enough for a picture, little enough for a page.
constexpr std::size_t kFigureSamples = 6000;
constexpr std::size_t kSidecarLimit = std::size_t{1} << 24;

Diagnostic about(const std::string& file, const char* code, std::string message, std::string why,
                 std::string fix) {
  Diagnostic d;
  d.code = code;
  d.place.file = file;
  d.message = std::move(message);
  d.why = std::move(why);
  d.fix = std::move(fix);
  return d;
}

/// One run: what is known so far.
struct Run {
  const Plan& plan;
  const ProgramJob& job;
  ProgramOutcome outcome;

  void fail(ProgramEnd end, Diagnostic d) {
    outcome.end = end;
    outcome.diagnostics.push_back(std::move(d));
  }
  void fail(const std::string& path, const FileError& error) {
    fail(error.missing || error.unsuitable ? ProgramEnd::invalid : ProgramEnd::io,
         about(path, "E-FILE", error.message, "", "check the path, the permissions and the free space"));
  }
  void add(const Diagnostics& list) {
    outcome.diagnostics.insert(outcome.diagnostics.end(), list.begin(), list.end());
  }

  [[nodiscard]] ProgramReport report(const char* verb, const std::string& output) const {
    ProgramReport report;
    report.verb = verb;
    report.program_version = job.version;
    report.input_name = job.program;
    report.output_name = output;
    report.machine = &plan.machine();
    report.model = job.model;
    report.environment = job.environment;
    report.setup = job.setup;
    report.datum = job.datum;
    report.reversal = job.reversal;
    report.tolerance = job.tolerance;
    report.max_correction = job.max_correction;
    report.limit = job.limit;
    if (job.cl) report.dialect = "cl";
    return report;
  }
};

std::string named(const std::string& path) { return path == "-" ? std::string("standard input") : path; }

/// The program as a file with a path, and what it was before anything else was done.
struct Input {
  std::optional<SpooledInput> spooled;
  std::string path, name;
  FileIdentity identity;
  std::uint64_t lines = 0;
  std::string sha256;
};

std::optional<Input> open_input(Run& run) {
  Input input;
  input.path = run.job.program;
  input.name = named(run.job.program);
  if (input.path == "-") {
    auto spooled = SpooledInput::from_standard_input();
    if (const auto* error = std::get_if<FileError>(&spooled)) {
      run.fail(input.name, *error);
      return std::nullopt;
    }
    input.spooled.emplace(std::move(std::get<SpooledInput>(spooled)));
    input.path = input.spooled->path();
  }
  auto opened = LineReader::open(input.path);
  if (const auto* error = std::get_if<FileError>(&opened)) {
    run.fail(input.name, *error);
    return std::nullopt;
  }
  auto& reader = std::get<LineReader>(opened);
  input.identity = reader.identity();
  reader.read_on();
  if (reader.error()) {
    run.fail(input.name, *reader.error());
    return std::nullopt;
  }
  input.lines = reader.line_number();
  input.sha256 = reader.sha256();
  return input;
}

/// Files that would be read and written at once, or written twice.
bool paths_are_apart(Run& run, const Input& input) {
  std::vector<std::pair<std::string, const char*>> outputs;
  const ProgramJob& job = run.job;
  if (!job.output.empty() && job.output != "-") outputs.emplace_back(job.output, "-o");
  if (!job.report.empty() && job.report != "-") outputs.emplace_back(job.report, "--report");
  if (!job.figure.empty() && job.figure != "-") outputs.emplace_back(job.figure, "--figure");
  if (job.header == HeaderForm::sidecar && !job.output.empty()) {
    if (job.output == "-") {
      run.fail(ProgramEnd::invalid, about("--header", "E-USAGE", "a sidecar needs an output with a name", "",
                                          "name the output with -o"));
      return false;
    }
    outputs.emplace_back(job.output + ".abbe.json", "--header sidecar");
  }
  std::vector<std::string> inputs = run.plan.machine().files;
  inputs.push_back(input.path);
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    for (const auto& read : inputs) {
      if (!same_file(outputs[i].first, read)) continue;
      run.fail(ProgramEnd::refused, about(outputs[i].first, "E-SAME",
                                          fmt::format("{} names an input ({})", outputs[i].second, read),
                                          "an input is never overwritten", "name another file"));
      return false;
    }
    for (std::size_t k = 0; k < i; ++k) {
      if (outputs[i].first != outputs[k].first && !same_file(outputs[i].first, outputs[k].first)) continue;
      run.fail(ProgramEnd::invalid,
               about(outputs[i].first, "E-SAME",
                     fmt::format("{} and {} name the same file", outputs[k].second, outputs[i].second), "",
                     "name different files"));
      return false;
    }
  }
  return true;
}

/// A program without our mark in it may still be one of ours: its sidecar says so.
bool is_fresh(Run& run, const Input& input) {
  if (input.spooled) return true;
  const std::string path = input.path + ".abbe.json";
  if (!identity_of(path)) return true;
  const auto text = read_file(path, kSidecarLimit);
  const auto* json = std::get_if<std::string>(&text);
  if (!json) return true;
  const std::size_t output = json->find("\"output\"");
  if (output == std::string::npos || json->find(input.sha256, output) == std::string::npos) return true;
  run.outcome.rewrite.compensated_input = true;
  run.fail(ProgramEnd::refused,
           about(input.name, "E-COMPENSATED", "this program has been compensated already",
                 "compensating twice doubles the correction", "use the original program"));
  return false;
}

/// Errors that are true of one test only must not move the machine.
bool errors_are_of_the_machine(Run& run) {
  const std::optional<Diagnostic> refusal = refusal_of_one_test(run.plan.machine());
  if (refusal) run.fail(ProgramEnd::refused, *refusal);
  return !refusal;
}

bool calibration_holds(Run& run) {
  const auto& calibration = run.plan.machine().calibration;
  if (run.job.today.empty() || calibration.valid_to.empty() || run.job.today <= calibration.valid_to)
    return true;
  run.fail(
      ProgramEnd::refused,
      about(run.plan.machine().files.empty() ? "machine" : run.plan.machine().files.front(), "E-VALIDITY",
            fmt::format("the calibration was valid to {}, today is {}", calibration.valid_to, run.job.today),
            "the machine may have changed since it was measured",
            "measure it again, or extend valid_to in [calibration]"));
  return false;
}

bool unchanged(Run& run, const Input& input) {
  const auto now = identity_of(input.path);
  if (run.outcome.rewrite.identity == input.identity && run.outcome.verify.original.sha256 == input.sha256 &&
      now && *now == input.identity)
    return true;
  run.fail(ProgramEnd::refused,
           about(input.name, "E-CHANGED", "the program changed while it was read",
                 "what was verified is not what stands there now", "run it again when nobody writes to it"));
  return false;
}

struct Extra {
  std::string path, text;
};

/// Side files first: if one cannot be written the program does not appear either.
bool publish(Run& run, SpoolFile* program, const std::vector<Extra>& extras) {
  std::vector<SpoolFile> ready;
  for (const auto& extra : extras) {
    auto created = SpoolFile::create(extra.path);
    if (const auto* error = std::get_if<FileError>(&created)) return run.fail(extra.path, *error), false;
    auto& file = std::get<SpoolFile>(created);
    if (!file.write(extra.text) || !file.flush()) return run.fail(extra.path, *file.error()), false;
    ready.push_back(std::move(file));
  }
  for (std::size_t i = 0; i < ready.size(); ++i) {
    if (!ready[i].publish()) return run.fail(extras[i].path, *ready[i].error()), false;
  }
  if (program && !program->publish()) return run.fail(run.job.output, *program->error()), false;
  return true;
}

ProgramEnd end_of_refusal(const RewriteReport& report) {
  bool other = false;
  for (const auto& d : report.diagnostics) {
    if (d.severity != Severity::error) continue;
    if (d.code == "E-FILE" || d.code == "E-WRITE") return ProgramEnd::io;
    if (d.code == "E-MACHINE" || d.code == "E-EMPTY") return ProgramEnd::invalid;
    other = other || (d.code != "E-VOL" && d.code != "E-TRAVEL");
  }
  return report.out_of_volume && !other ? ProgramEnd::outside : ProgramEnd::refused;
}

VerifyJob verify_job(const ProgramJob& job) {
  VerifyJob verify;
  verify.setup = job.setup;
  verify.datum = job.datum;
  verify.reversal = job.reversal;
  verify.tolerance = job.tolerance;
  verify.max_correction = job.max_correction;
  verify.block_time = job.block_time;
  verify.samples = job.figure.empty() ? 0 : kFigureSamples;
  return verify;
}

VerifyReport verified(const Run& run, const VerifyJob& verify, const Progress& progress) {
  return run.job.cl ? verify_cl_program(run.plan, run.job, verify, progress)
                    : verify_program(run.plan, verify, progress);
}

RewriteReport rewritten(const Run& run, const RewriteJob& rewrite, SpoolFile& spool,
                        const Progress& progress) {
  return run.job.cl ? rewrite_cl_program(run.plan, run.job, rewrite, spool, progress)
                    : rewrite_program(run.plan, rewrite, spool, progress);
}

/// Tells the verification that nothing more will come, whatever happens.
struct EndOfWriting {
  FileGrowth& growth;
  ~EndOfWriting() { growth.finish(); }
};

/// Rewrites the program into the spool file and verifies that file: at once in two threads, or in turn. Fills
/// both reports; that of the verification only if the rewriting was completed. `growth` lives as long as the
/// spool file, which tells it of every byte.
void rewrite_and_verify(Run& run, const RewriteJob& rewrite, VerifyJob verify, SpoolFile& spool,
                        FileGrowth& growth, const Progress& progress) {
  const unsigned processors = run.job.threads != 0 ? run.job.threads : std::thread::hardware_concurrency();
  spool.tell(growth);
  verify.output_growth = &growth;
  std::atomic<bool> stop = false;
  std::atomic<std::uint64_t> done = 0, total = 0;
  const Progress aside = [&](std::uint64_t done_now, std::uint64_t total_now) {
    done = done_now;
    total = total_now;
    return !stop;
  };
  const auto task = [&run, &verify](const Progress& steps) { return verified(run, verify, steps); };
  // Where no thread can be started the library defers the task, too: it then runs in get().
  std::future<VerifyReport> verification =
      processors > 1 ? std::async(std::launch::async | std::launch::deferred, task, std::cref(aside))
                     : std::async(std::launch::deferred, task, std::cref(progress));
  RewriteReport report;
  {
    const EndOfWriting end{growth};
    report = rewritten(run, rewrite, spool, progress);
  }
  run.outcome.rewrite = std::move(report);
  if (!run.outcome.rewrite.complete) stop = true;
  constexpr std::chrono::milliseconds kLook{20};
  while (run.outcome.rewrite.complete && verification.wait_for(kLook) == std::future_status::timeout)
    if (progress && !progress(done, total)) stop = true;
  if (run.outcome.rewrite.complete) run.outcome.verify = verification.get();
}

void finish_reports(Run& run, ProgramReport report, std::vector<Extra>& extras) {
  run.outcome.json = json_report(report);
  run.outcome.text = human_report(report);
  if (!run.job.report.empty()) extras.push_back({run.job.report, run.outcome.json});
  if (!run.job.figure.empty()) extras.push_back({run.job.figure, figure_before_after(report)});
}

}  // namespace

ProgramOutcome compensate_program(const Plan& plan, const ProgramJob& job, const Progress& progress) {
  Run run{plan, job, {}};
  ProgramOutcome& outcome = run.outcome;
  const char* verb = job.output.empty() ? "check" : "compensate";
  const auto input = open_input(run);
  if (!input || !paths_are_apart(run, *input) || !is_fresh(run, *input) || !calibration_holds(run))
    return std::move(run.outcome);
  if (!errors_are_of_the_machine(run)) return std::move(run.outcome);
  FileGrowth growth;
  auto created = SpoolFile::create(job.output.empty() ? "-" : job.output);
  if (const auto* error = std::get_if<FileError>(&created)) {
    run.fail(job.output, *error);
    return std::move(run.outcome);
  }
  auto& spool = std::get<SpoolFile>(created);

  RewriteJob rewrite;
  rewrite.path = input->path;
  rewrite.name = input->name;
  rewrite.setup = job.setup;
  rewrite.probed_datum = job.datum == DatumRule::probed;
  rewrite.reversal = job.reversal;
  rewrite.tolerance = job.tolerance;
  rewrite.max_correction = job.max_correction;
  rewrite.expand_drill = job.expand_drill;
  rewrite.block_time = job.block_time;
  rewrite.trace_line = job.trace_line;
  ProgramReport report = run.report(verb, job.output);
  if (job.header == HeaderForm::inline_comments) {
    // what is known before the first line is rewritten: where the program comes from
    RewriteReport source;
    source.lines_in = input->lines;
    source.sha256_in = input->sha256;
    report.rewrite = &source;
    rewrite.header = header_lines(report);
  }
  VerifyJob verify = verify_job(job);
  verify.original_path = input->path;
  verify.original_name = input->name;
  verify.output_path = spool.temporary_path();
  verify.output_name =
      job.output.empty() || job.output == "-" ? std::string("(compensated program)") : job.output;
  rewrite_and_verify(run, rewrite, std::move(verify), spool, growth, progress);
  run.add(outcome.rewrite.diagnostics);
  outcome.rewrite.sha256_in = input->sha256;
  report.rewrite = &outcome.rewrite;
  const auto without_output = [&](ProgramEnd end) {
    outcome.end = end;
    report.output_name.clear();
    outcome.json = json_report(report);
    outcome.text = human_report(report);
    return std::move(run.outcome);
  };
  if (outcome.rewrite.stopped) return without_output(ProgramEnd::stopped);
  if (!outcome.rewrite.complete) return without_output(end_of_refusal(outcome.rewrite));

  run.add(outcome.verify.diagnostics);
  report.verify = &outcome.verify;
  if (outcome.verify.stopped) return without_output(ProgramEnd::stopped);
  if (!unchanged(run, *input)) return std::move(run.outcome);
  if (!outcome.verify.agrees) {
    // What the second reader does not understand in the original is no disagreement.
    const bool refused = std::any_of(
        outcome.verify.diagnostics.begin(), outcome.verify.diagnostics.end(), [&](const Diagnostic& d) {
          return d.severity == Severity::error && d.code.starts_with("E-") && d.place.file == input->name;
        });
    return without_output(refused ? ProgramEnd::refused : ProgramEnd::disagrees);
  }
  std::vector<Extra> extras;
  finish_reports(run, report, extras);
  if (job.header == HeaderForm::sidecar && !job.output.empty())
    extras.push_back({job.output + ".abbe.json", outcome.json});
  if (publish(run, job.output.empty() ? nullptr : &spool, extras)) {
    outcome.end = ProgramEnd::done;
  } else {
    // Nothing says "verified" about a program that did not appear.
    outcome.text.clear();
    outcome.json.clear();
  }
  return std::move(run.outcome);
}

ProgramOutcome verify_programs(const Plan& plan, const ProgramJob& job, const std::string& output,
                               const Progress& progress) {
  Run run{plan, job, {}};
  VerifyJob verify = verify_job(job);
  verify.original_path = verify.original_name = job.program;
  verify.output_path = verify.output_name = output;
  for (const auto& path : {job.program, output}) {
    auto opened = LineReader::open(path);
    if (const auto* error = std::get_if<FileError>(&opened)) run.fail(path, *error);
  }
  if (!run.outcome.diagnostics.empty()) return std::move(run.outcome);
  run.outcome.verify = verified(run, verify, progress);
  run.add(run.outcome.verify.diagnostics);
  ProgramReport report = run.report("verify", output);
  report.verify = &run.outcome.verify;
  if (run.outcome.verify.stopped) {
    run.outcome.end = ProgramEnd::stopped;
    run.outcome.json = json_report(report);
    run.outcome.text = human_report(report);
    return std::move(run.outcome);
  }
  std::vector<Extra> extras;
  finish_reports(run, report, extras);
  if (!publish(run, nullptr, extras)) return std::move(run.outcome);
  bool understood = true;
  for (const auto& d : run.outcome.verify.diagnostics)
    understood = understood && (d.severity != Severity::error || d.code.rfind("E-", 0) != 0);
  run.outcome.end = run.outcome.verify.agrees ? ProgramEnd::done
                    : understood              ? ProgramEnd::disagrees
                                              : ProgramEnd::refused;
  return std::move(run.outcome);
}

}  // namespace abbe
