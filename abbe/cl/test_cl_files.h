#pragma once

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/cl/rewrite_cl.h"
#include "abbe/cl/verify_cl.h"
#include "abbe/core/test_files.h"

/// Machines, files and runs for the tests of CL data.
namespace abbe::cl {

using abbe::testing::kPerfect;
using abbe::testing::plan_of;
using abbe::testing::slurp;
using abbe::testing::TestFile;

/// A machine of three linear axes whose errors can be inverted on paper: tip = (x + a x, y + b x, z).
inline constexpr double kScale = 1e-4, kShear = 2e-4;
inline const char* const kThreeAxes = R"(format = 1
[machine]
name = "three"
chain = "w b X Y Z t"
[axis.X]
range = [-500, 500]
[axis.Y]
range = [-500, 500]
[axis.Z]
range = [-500, 500]
[errors]
EXX = { poly = [0, 0.1] }
EYX = { poly = [0, 0.2] }
)";

/// A table that tilts about X and turns about Z, tool 150 mm.
inline std::string five_axes(const std::string& errors) {
  return R"(format = 1
[machine]
name = "five"
chain = "w C A Y b X Z t"
[axis.C]
direction = [0, 0, -1]
[axis.A]
direction = [-1, 0, 0]
range = [-120, 120]
origin = [0, 0, -60]
[axis.X]
range = [-1000, 1000]
[axis.Y]
range = [-1000, 1000]
[axis.Z]
range = [-600, 900]
[tool]
origin = [0, 0, 150]
length = 150
)" + errors;
}
inline std::string five_axes_with_errors() {
  std::string text = five_axes(R"([errors]
EXX = { poly = [0, 0.05, 2e-5] }
EYX = { table = [[-600, 3], [-200, -2], [100, 4], [600, 1]], interpolation = "cubic" }
EA0C = 30
EB0C = -20
EX0C = 12
EY0A = -15
EZ0A = 8
EC0A = 25
ECC = { sine = [20, 0.0174533, 0.4] }
EAA = { poly = [0, 0.5] }
EB0Z = -30
)");
  for (const char* axis : {"[axis.C]\n", "[axis.A]\n", "[axis.Y]\n"})
    text.insert(text.find(axis) + std::string(axis).size(), "errors_seen = \"body\"\n");
  return text;
}

struct Options {
  Conventions conventions;
  bool probed = false;
  double tolerance = 1 * um, max_correction = 500 * um;
  std::optional<WorkOffset> g54;
  std::map<int, double> gauges;
  Commands start{};
  std::vector<std::string> header;
  std::uint64_t trace_line = 0;
};

struct ClRun {
  RewriteReport rewrite;
  VerifyReport verify;
  std::string output;  ///< empty: refused

  [[nodiscard]] std::string findings() const {
    std::string text;
    for (const auto* list : {&rewrite.diagnostics, &verify.diagnostics}) {
      for (const Diagnostic& d : *list) text += to_text(d);
    }
    return text;
  }
  /// The first error of the rewriter, "" for none.
  [[nodiscard]] std::string refusal() const {
    for (const Diagnostic& d : rewrite.diagnostics) {
      if (d.severity == Severity::error) return d.code;
    }
    return {};
  }
  [[nodiscard]] std::string disagreement() const {
    for (const Diagnostic& d : verify.diagnostics) {
      if (d.severity == Severity::error) return d.code;
    }
    return {};
  }
  [[nodiscard]] bool warns(const std::string& code) const {
    for (const Diagnostic& d : rewrite.diagnostics) {
      if (d.code == code && d.severity == Severity::warning) return true;
    }
    return false;
  }
};

inline ControlSetup setup_of(const Options& options) {
  ControlSetup setup;
  setup.work_offsets[0] = options.g54;
  setup.gauges = options.gauges;
  return setup;
}

/// What the rewriter and the verifier are told alike.
template <class Job>
void set_options(const Options& options, Job& job) {
  job.setup = setup_of(options);
  job.conventions = options.conventions;
  job.start = options.start;
  job.probed_datum = options.probed;
  job.tolerance = options.tolerance;
  job.max_correction = options.max_correction;
}

inline VerifyReport verify_texts(const Plan& plan, const std::string& original, const std::string& output,
                                 const Options& options = {}) {
  const TestFile a(original), b(output);
  ClVerifyJob job;
  job.original_path = a.path();
  job.output_path = b.path();
  job.original_name = "part.cls";
  job.output_name = "out.cls";
  set_options(options, job);
  return verify_cl(plan, job);
}

inline ClRun run_cl(const Plan& plan, const std::string& text, const Options& options = {}) {
  const TestFile file(text);
  ClJob job;
  job.path = file.path();
  job.name = "part.cls";
  set_options(options, job);
  job.header = options.header;
  job.trace_line = options.trace_line;
  auto spool = SpoolFile::create("-");
  ClRun run;
  run.rewrite = rewrite_cl(plan, job, std::get<SpoolFile>(spool));
  if (!run.rewrite.complete) return run;
  run.output = slurp(std::get<SpoolFile>(spool).temporary_path());
  run.verify = verify_texts(plan, text, run.output, options);
  return run;
}

}  // namespace abbe::cl
