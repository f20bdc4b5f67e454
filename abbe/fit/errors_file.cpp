#include "abbe/fit/errors_file.h"

#include <fmt/format.h>

#include "abbe/fit/function_model.h"

namespace abbe {
namespace {

/// A text in TOML's quotes; control bytes would not be TOML.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += '?';
      continue;
    }
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string comment(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return "# " + text + "\n";
}

std::string function_text(const FoundFunction& found) {
  std::string text = found.unknown.mean.text(found.mean);
  if (found.reversal.size() == 0) return text.find("}, {") == std::string::npos ? text : "[" + text + "]";
  // mean + approach * reversal / 2
  const std::string forward = found.unknown.reversal->text(found.reversal / 2);
  const std::string backward = found.unknown.reversal->text(-found.reversal / 2);
  return fmt::format("[{}, {{ forward = {}, backward = {} }}]", text, forward, backward);
}

std::string calibration_text(const Calibration& calibration) {
  std::string text;
  if (!calibration.date.empty()) text += fmt::format("date = {}\n", calibration.date);
  if (!calibration.valid_to.empty()) text += fmt::format("valid_to = {}\n", calibration.valid_to);
  if (!calibration.machine_id.empty())
    text += fmt::format("machine_id = {}\n", quoted(calibration.machine_id));
  if (calibration.temperature)
    text += fmt::format("temperature = {}\n", file_number(*calibration.temperature));
  if (!calibration.control_compensation.empty())
    text += fmt::format("control_compensation = {}\n", quoted(calibration.control_compensation));
  return text.empty() ? text : "\n[calibration]\n" + text;
}

}  // namespace

std::string write_errors_file(const FitJob& job, const FitResult& result) {
  std::string text =
      comment("Written by abbe fit from " + job.file + ": errors of " + job.machine.name + ".");
  for (const SetResidual& set : result.sets)
    text += comment(fmt::format("  {}: {} equations, rms of what is left {:.3g} {}", set.name, set.rows,
                                set.rms / (set.angle ? urad : um), set.angle ? "urad" : "um"));
  text += comment(
      "All functions are zero at the reference position. Straightness has no trend: it is squareness.");
  text +=
      "format = 1\n\n[units]\nlength = \"mm\"\nangle = \"deg\"\nerror_length = \"um\"\nerror_angle = "
      "\"urad\"\n";
  text += calibration_text(job.calibration);
  text += "\n[errors]\n";
  for (const FoundFunction& found : result.functions)
    text += fmt::format("{} = {}\n", found.unknown.name, function_text(found));
  for (const FoundValue& value : result.locations)
    text += fmt::format("{} = {}\n", value.name, file_number(value.value));
  text += "\n[uncertainty]\n" +
          comment("standard; of functions the largest over their range, of the mean of both directions");
  for (const FoundFunction& found : result.functions)
    text += fmt::format("{} = {}\n", found.unknown.name, file_number(found.u));
  for (const FoundValue& value : result.locations)
    text += fmt::format("{} = {}\n", value.name, file_number(value.u));
  return text;
}

}  // namespace abbe
