#include "abbe/cl/rewrite_cl.h"

#include "abbe/cl/rewriter.h"

namespace abbe {
namespace {

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::uint64_t kLinesPerLook = 1024;

Diagnostic whole_file(const std::string& name, const char* code, std::string message, const char* fix) {
  return {Severity::error, code, Place{name, 0, 0, 1, {}}, std::move(message), {}, fix};
}

/// Copies what is ready to the output; after a refusal nothing will be published.
bool flush(std::string& text, bool refused, SpoolFile& out) {
  const bool written = refused || out.write(text);
  text.clear();
  return written;
}

}  // namespace

RewriteReport rewrite_cl(const Plan& plan, const ClJob& job, SpoolFile& out, const Progress& progress) {
  RewriteReport report;
  const auto fail = [&](Diagnostic d) {
    report.diagnostics.push_back(std::move(d));
    return report;
  };
  const auto free = free_axes(plan.machine(), 0);
  if (!free)
    return fail(whole_file(job.name, "E-MACHINE", "more than three linear or two rotary axes could be moved",
                           "set correctable = false in the machine file for those that rest"));
  auto opened = LineReader::open(job.path, false);
  if (const auto* error = std::get_if<FileError>(&opened))
    return fail(whole_file(job.name, "E-FILE", error->message, "check the path and the permissions"));
  auto& reader = std::get<LineReader>(opened);
  report.identity = reader.identity();
  cl::Rewriter rewriter(plan, *free, job, report);
  std::string text;
  bool written = true;
  while (const auto line = reader.next()) {
    rewriter.line(*line, reader.line_number(), reader.too_long(), text);
    if (text.size() >= kBlock && !(written = flush(text, rewriter.findings().refused(), out))) break;
    if (progress && reader.line_number() % kLinesPerLook == 0 &&
        !progress(reader.bytes_read(), report.identity.size)) {
      report.stopped = true;
      return report;
    }
  }
  rewriter.finish(text);
  report.lines_in = reader.line_number();
  report.bytes_in = reader.bytes_read();
  const bool refused = rewriter.findings().refused();
  report.diagnostics = rewriter.findings().take();
  if (report.lines_in == 0)
    return fail(whole_file(job.name, "E-EMPTY", "the file is empty", "check that the right file is named"));
  if (reader.error())
    return fail(whole_file(job.name, "E-FILE", reader.error()->message, "check the file and its medium"));
  if (refused) return report;
  if (!written || !flush(text, false, out) || !out.flush())
    return fail(whole_file(job.name, "E-WRITE",
                           out.error() ? out.error()->message : "the output cannot be written",
                           "free space, or name another folder"));
  report.complete = true;
  return report;
}

}  // namespace abbe
