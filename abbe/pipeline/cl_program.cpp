#include "abbe/pipeline/cl_program.h"

#include <string>

#include "abbe/cl/rewrite_cl.h"
#include "abbe/cl/verify_cl.h"

namespace abbe {
namespace {

/// "(TEXT)" of a program header as the text of a remark.
std::string without_brackets(const std::string& line) {
  return line.size() >= 2 && line.front() == '(' && line.back() == ')' ? line.substr(1, line.size() - 2)
                                                                       : line;
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
  return rewrite_cl(plan, cl, out, progress);
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
  cl.output_growth = verify.output_growth;
  return verify_cl(plan, cl, progress);
}

}  // namespace abbe
