#include "abbe/compensate/rewrite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "abbe/compensate/rewriter.h"

namespace abbe {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::uint64_t kLinesPerLook = 4096;

Diagnostic whole_file(const std::string& name, const char* code, std::string message, const char* fix) {
  Diagnostic d;
  d.code = code;
  d.place.file = name;
  d.message = std::move(message);
  d.fix = fix;
  return d;
}

/// A control reads a number of blocks ahead: the more there are, the less of the way it sees.
std::optional<Diagnostic> growth_warning(const std::string& name, const RewriteReport& report) {
  constexpr std::uint64_t kFewLines = 5000, kMuch = 2;
  if (report.lines_out < kFewLines || report.lines_out <= kMuch * report.lines_in) return std::nullopt;
  Diagnostic d =
      whole_file(name, "W-GROWTH",
                 fmt::format("{} lines became {}: motions were split so that the correction follows",
                             report.lines_in, report.lines_out),
                 "allow more with --tolerance-um if the control slows down");
  d.severity = Severity::warning;
  d.why = "the control reads a number of blocks ahead, and of these the way is shorter now";
  return d;
}

}  // namespace

RewriteReport rewrite_program(const Plan& plan, const RewriteJob& job, SpoolFile& out,
                              const Progress& progress) {
  RewriteReport report;
  const AddressedAxes axes = addressed_axes(plan.machine());
  const auto missing = std::find(axes.linear.begin(), axes.linear.end(), -1);
  if (missing != axes.linear.end()) {
    report.diagnostics.push_back(whole_file(job.name, "E-MACHINE",
                                            fmt::format("the machine has no linear axis with the address {}",
                                                        "XYZ"[missing - axes.linear.begin()]),
                                            "describe X, Y and Z, or set `address` in the machine file"));
    return report;
  }
  for (const int axis : axes.linear) {
    if (plan.machine().axis(axis).correctable) continue;
    report.diagnostics.push_back(whole_file(
        job.name, "E-MACHINE", fmt::format("axis {} is not correctable", plan.machine().axis(axis).name),
        "a program is corrected by X, Y and Z together: allow it (`correctable`), or ask `abbe correct`"));
    return report;
  }
  auto opened = LineReader::open(job.path, false);
  if (auto* error = std::get_if<FileError>(&opened)) {
    report.diagnostics.push_back(
        whole_file(job.name, "E-FILE", error->message, "check the path and the permissions"));
    return report;
  }
  auto& reader = std::get<LineReader>(opened);
  report.identity = reader.identity();
  Rewriter rewriter(plan, axes, job, report);
  std::string text;
  text.reserve(2 * kBlock);
  bool written = true;
  std::array<std::string_view, Rewriter::kMostLines> lines;
  std::uint64_t looked = 0;
  while (const std::size_t rows = reader.next(lines)) {
    rewriter.lines(std::span(lines).first(rows), reader.line_number() - rows + 1, reader.too_long(), text);
    if (text.size() >= kBlock) {
      // after a refusal nothing will be published: read on for the other findings only
      if (!rewriter.findings().refused()) written = out.write(text);
      text.clear();
      if (!written) break;
    }
    if (!progress || reader.line_number() - looked < kLinesPerLook) continue;
    looked = reader.line_number();
    if (!progress(reader.bytes_read(), report.identity.size)) {
      report.stopped = true;
      return report;
    }
  }
  rewriter.finish(text);
  report.lines_in = reader.line_number();
  report.bytes_in = reader.bytes_read();
  if (report.lines_in == 0) {
    report.diagnostics.push_back(
        whole_file(job.name, "E-EMPTY", "the program is empty", "check that the right file is named"));
    return report;
  }
  const bool refused = rewriter.findings().refused();
  report.diagnostics = rewriter.findings().take();
  if (reader.error()) {
    report.diagnostics.push_back(
        whole_file(job.name, "E-FILE", reader.error()->message, "check the file and its medium"));
    return report;
  }
  if (refused) return report;
  if (written) written = out.write(text) && out.flush();
  if (!written) {
    report.diagnostics.push_back(
        whole_file(job.name, "E-WRITE", out.error() ? out.error()->message : "the output cannot be written",
                   "free space, or name another folder"));
    return report;
  }
  report.complete = true;
  if (auto grown = growth_warning(job.name, report)) report.diagnostics.push_back(std::move(*grown));
  return report;
}

}  // namespace abbe
