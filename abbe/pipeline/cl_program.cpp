#include "abbe/pipeline/cl_program.h"

#include <fmt/format.h>

#include <utility>

#include "abbe/cl/rewrite_cl.h"
#include "abbe/cl/verify_cl.h"

namespace abbe {
namespace {

/// "(TEXT)" of a program header as the text of a remark.
std::string without_brackets(const std::string& line) {
  return line.size() >= 2 && line.front() == '(' && line.back() == ')' ? line.substr(1, line.size() - 2)
                                                                       : line;
}

std::string axes_text(const Machine& machine, const cl::Commands& q) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i)
    text += fmt::format("{}{} {:.5f}", i == 0 ? "" : "  ", machine.axis(i).name,
                        q[static_cast<std::size_t>(i)] / machine.axis_unit(i));
  return text;
}

BlockTrace trace_of(const Machine& machine, const ClTrace& cl) {
  BlockTrace trace;
  trace.frame = "CL data";
  trace.frame_origin = cl.frame_origin;
  trace.datum = cl.datum;
  trace.tool = cl.tool;
  trace.gauge_length = cl.gauge_length;
  trace.start = cl.start.tip;
  trace.end = cl.end.tip;
  trace.correction = cl.written.tip - cl.end.tip;
  const Vec3& axis = cl.written.axis;
  trace.decision =
      fmt::format("{}; tool axis {:.8f} {:.8f} {:.8f}; axes {} instead of {}", cl.decision, axis.x(),
                  axis.y(), axis.z(), axes_text(machine, cl.corrected), axes_text(machine, cl.commanded));
  trace.before = cl.before;
  trace.after = cl.after;
  return trace;
}

DeviationSummary summary_of(const ClDeviation& cl) {
  DeviationSummary summary;
  summary.max = cl.max;
  summary.rms = cl.rms;
  summary.max_line = cl.max_line;
  summary.max_component = cl.max_component;
  return summary;
}

}  // namespace

RewriteReport rewrite_cl_program(const Plan& plan, const ProgramJob& job, const RewriteJob& rewrite,
                                 SpoolFile& out, const Progress& progress) {
  ClJob cl;
  cl.path = rewrite.path;
  cl.name = rewrite.name;
  cl.setup = job.setup;
  cl.conventions = job.cl->conventions;
  cl.start = job.cl->start;
  cl.probed_datum = rewrite.probed_datum;
  cl.tolerance = rewrite.tolerance;
  cl.max_correction = rewrite.max_correction;
  cl.max_gradient = rewrite.max_gradient;
  for (const std::string& line : rewrite.header) cl.header.push_back(without_brackets(line));
  cl.trace_line = rewrite.trace_line;
  ClReport done = rewrite_cl(plan, cl, out, progress);

  RewriteReport report;
  report.complete = done.complete;
  report.stopped = done.stopped;
  report.diagnostics = std::move(done.diagnostics);
  report.identity = done.identity;
  report.lines_in = done.lines_in;
  report.bytes_in = done.bytes_in;
  report.lines_out = done.lines_out;
  report.blocks = {done.motions, done.rewritten, done.split, done.passed};
  report.arcs_in = done.arcs_in;
  report.arcs_out = done.arcs_out;
  report.max_correction = done.max_correction;
  report.max_line = done.max_line;
  report.max_gradient = done.max_gradient;
  report.cycle_residual = done.cycle_residual;
  report.held_blocks = done.singular;
  report.shortest_split = done.shortest_split;
  report.compensated_input = done.compensated_input;
  report.out_of_volume = done.out_of_volume;
  if (done.trace) report.trace = trace_of(plan.machine(), *done.trace);
  return report;
}

VerifyReport verify_cl_program(const Plan& plan, const ProgramJob& job, const VerifyJob& verify,
                               const Progress& progress) {
  ClVerifyJob cl;
  cl.original_path = verify.original_path;
  cl.output_path = verify.output_path;
  cl.original_name = verify.original_name;
  cl.output_name = verify.output_name;
  cl.setup = verify.setup;
  cl.conventions = job.cl->conventions;
  cl.start = job.cl->start;
  cl.probed_datum = verify.datum == DatumRule::probed;
  cl.tolerance = verify.tolerance;
  cl.max_correction = verify.max_correction;
  cl.samples = verify.samples;
  ClVerifyReport done = verify_cl(plan, cl, progress);

  VerifyReport report;
  report.agrees = done.agrees;
  report.stopped = done.stopped;
  report.diagnostics = std::move(done.diagnostics);
  report.original = {done.original.lines, done.original.bytes, done.original.sha256};
  report.output = {done.output.lines, done.output.bytes, done.output.sha256};
  report.original_identity = done.original_identity;
  report.before = summary_of(done.before);
  report.after = summary_of(done.after);
  report.direction_before = done.before.max_angle;
  report.direction_after = done.after.max_angle;
  report.quantisation = done.quantisation;
  report.allowed = done.allowed;
  report.feed_motions = done.feed_motions;
  report.rapid_motions = done.rapid_motions;
  report.points = done.points;
  report.events = done.records;
  report.path_length = done.path_length;
  for (const auto& [tool, removed] : done.datums)
    report.datums.push_back({job.setup.work_offsets[0] ? "G54" : "workpiece", tool, removed});
  for (const ClSample& s : done.samples)
    report.samples.push_back({s.line, s.position, s.travelled, s.before, s.after, s.rapid});
  return report;
}

}  // namespace abbe
