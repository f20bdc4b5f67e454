#pragma once

#include "abbe/pipeline/compensate_program.h"

namespace abbe {

/// The two passes of CL data in the terms of programs: what `compensate_program` runs when the job says so.
/// `rewrite` and `verify` hold the paths; the rest is taken from `job`.
[[nodiscard]] RewriteReport rewrite_cl_program(const Plan& plan, const ProgramJob& job,
                                               const RewriteJob& rewrite, SpoolFile& out,
                                               const Progress& progress);
[[nodiscard]] VerifyReport verify_cl_program(const Plan& plan, const ProgramJob& job, const VerifyJob& verify,
                                             const Progress& progress);

}  // namespace abbe
