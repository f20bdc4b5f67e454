#include <fmt/core.h>

#include <cmath>
#include <string>
#include <string_view>

#include "abbe/core/units.h"
#include "abbe/report/program_report.h"

namespace abbe {
namespace {

/// Enough digits to read, no more: 41.2, 0.312, 0.
std::string length_um(double length) {
  const double value = length / um;
  if (value == 0) return "0";
  return std::abs(value) >= 10 ? fmt::format("{:.1f}", value) : fmt::format("{:.3f}", value);
}

std::string line(std::string_view name, std::string_view text) {
  return fmt::format("  {:<12} {}\n", name, text);
}

std::string deviation_text(const DeviationSummary& summary) {
  std::string text = fmt::format("max {} um", length_um(summary.max));
  if (summary.max_line > 0) text += fmt::format(" (line {})", summary.max_line);
  return text + fmt::format(", rms {} um, worst x {} y {} z {} um", length_um(summary.rms),
                            length_um(summary.max_component[0]), length_um(summary.max_component[1]),
                            length_um(summary.max_component[2]));
}

std::string signed_um(const Vec3& v) {
  return fmt::format("x {:+.1f} y {:+.1f} z {:+.1f} um", v.x() / um, v.y() / um, v.z() / um);
}

std::string verify_text(const ProgramReport& report, const VerifyReport& verify) {
  std::string text = line("before", deviation_text(verify.before));
  text += line("after", deviation_text(verify.after));
  if (verify.direction_before > 0) {
    text += line("tool axis",
                 fmt::format("at most {:.1f} urad askew before, {:.1f} urad after, while rotary axes turn",
                             verify.direction_before / urad, verify.direction_after / urad));
  }
  text += line("allowed", fmt::format("{} um ({} um tolerance, {} um for the digits of the program)",
                                      length_um(verify.allowed), length_um(report.tolerance),
                                      length_um(verify.quantisation)));
  for (const DatumShift& datum : verify.datums) {
    const std::string tool = datum.tool >= 0 ? fmt::format(" T{}", datum.tool) : std::string();
    text += line("datum", fmt::format("{}{}: {} belong to the position of the part and stay", datum.frame,
                                      tool, signed_um(datum.removed)));
  }
  if (verify.lost_motion > 0 && !report.reversal) {
    text += line("lost motion", fmt::format("up to {} um depend on the direction of approach and stay",
                                            length_um(verify.lost_motion)));
  }
  text += line("compared",
               fmt::format("{} feed motions over {:.0f} mm, {} rapids, {} other events", verify.feed_motions,
                           verify.path_length, verify.rapid_motions, verify.events));
  return text;
}

std::string rewrite_text(const RewriteReport& rewrite) {
  std::string text =
      line("blocks", fmt::format("{} move: {} rewritten, {} split, {} passed; arcs {} -> {}",
                                 rewrite.blocks.motion, rewrite.blocks.rewritten, rewrite.blocks.split,
                                 rewrite.blocks.passed, rewrite.arcs_in, rewrite.arcs_out));
  std::string most;
  for (std::size_t i = 0; i < 3; ++i) {
    most += fmt::format("{}{} {} um (line {})", i == 0 ? "" : ", ", "xyz"[i],
                        length_um(rewrite.max_correction[i]), rewrite.max_line[i]);
  }
  text +=
      line("corrections", fmt::format("{}; steepest {:.0f} um/m", most, rewrite.max_gradient / um * metre));
  if (rewrite.sensitivity) {
    text += line("sensitivity",
                 fmt::format("per mm that a work offset is wrong {:.2g} um, per mm of gauge length {:.2g} um",
                             rewrite.sensitivity->offset / um, rewrite.sensitivity->length / um));
  }
  if (rewrite.held_blocks > 0) {
    text += line("held", fmt::format("in {} blocks a rotary axis stays near a singularity, where it would "
                                     "turn too far for a correction",
                                     rewrite.held_blocks));
  }
  if (rewrite.cutter_radius > 0) {
    text +=
        line("cutter", fmt::format("the control offsets the contour by up to {:g} mm: {} um stay across it",
                                   rewrite.cutter_radius, length_um(rewrite.cutter_residual)));
  }
  if (rewrite.cycle_residual > 0) {
    text += line("cycles",
                 fmt::format("inside drilling cycles up to {} um remain", length_um(rewrite.cycle_residual)));
  }
  if (rewrite.shortest_split > 0) {
    const double seconds = rewrite.shortest_split_time;
    const bool brief = seconds < 0.1;
    const std::string time = seconds > 0 ? fmt::format(", {:.3g} {} at its feed",
                                                       brief ? seconds * 1e3 : seconds, brief ? "ms" : "s")
                                         : std::string();
    text += line("split", fmt::format("shortest new piece {:.3g} mm{}", rewrite.shortest_split, time));
  }
  if (rewrite.held_splits > 0) {
    text += line("not split", fmt::format("{} times, for the time of a block: up to {} um remain there",
                                          rewrite.held_splits, length_um(rewrite.held_residual)));
  }
  if (rewrite.expanded_holes > 0) {
    text +=
        line("expanded", fmt::format("{} holes are written as G0 and G1, for the correction changes inside "
                                     "their cycle",
                                     rewrite.expanded_holes));
  }
  return text;
}

std::string machine_text(const Machine& machine) {
  const Calibration& calibration = machine.calibration;
  std::string text = machine.name;
  if (!calibration.machine_id.empty()) text += " id " + calibration.machine_id;
  if (!calibration.date.empty()) text += ", calibrated " + calibration.date;
  if (!calibration.valid_to.empty()) text += ", valid to " + calibration.valid_to;
  return text;
}

/// The sentence a person needs first.
std::string verdict(const ProgramReport& report) {
  switch (result_of(report)) {
    case ProgramResult::refused:
      return "refused, for the reasons above; nothing is written";
    case ProgramResult::outside:
      return "outside the calibrated volume or the travels; nothing is written";
    case ProgramResult::disagrees:
      return "the programs DISAGREE: do not run the output";
    case ProgramResult::stopped:
      return "stopped; nothing is written";
    case ProgramResult::verified:
      break;
  }
  return "verified: path, events and feeds agree with the original";
}

}  // namespace

std::string human_report(const ProgramReport& report) {
  std::string text = report.output_name.empty()
                         ? report.input_name
                         : fmt::format("{} -> {}", report.input_name, report.output_name);
  text += fmt::format("\n  {}\n", verdict(report));
  const ProgramResult result = result_of(report);
  const bool has_numbers = result == ProgramResult::verified || result == ProgramResult::disagrees;
  if (has_numbers && report.verify != nullptr) text += verify_text(report, *report.verify);
  if (has_numbers && report.rewrite != nullptr) text += rewrite_text(*report.rewrite);
  text += line("machine", machine_text(*report.machine));
  std::size_t errors = 0, warnings = 0;
  const auto count = [&](const Diagnostics& diagnostics) {
    for (const Diagnostic& d : diagnostics) {
      if (d.severity == Severity::error) ++errors;
      if (d.severity == Severity::warning) ++warnings;
    }
  };
  if (report.rewrite != nullptr) count(report.rewrite->diagnostics);
  if (report.verify != nullptr) count(report.verify->diagnostics);
  if (errors + warnings > 0)
    text += line("look at", fmt::format("{} errors, {} warnings above", errors, warnings));
  return text;
}

}  // namespace abbe
