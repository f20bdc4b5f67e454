#include <unistd.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "abbe/capture/decode.h"
#include "abbe/capture/read_map.h"

// Any bytes as a capture: it is read, learned from and decoded, or refused; no number is none. And as a map
// file and an ENI file: a value or an error, never both.

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

struct Scratch {
  std::string path =
      (std::filesystem::temp_directory_path() / ("abbe_fuzz_capture_" + std::to_string(::getpid()))).string();
  ~Scratch() { std::filesystem::remove(path); }
};

void decode(const std::string& path, const abbe::CaptureSurvey& survey) {
  abbe::Diagnostics findings;
  const abbe::ProcessMap map = abbe::named(abbe::map_of(survey.slaves, findings), {{"X", 1001, -7, "mm"}});
  if (abbe::map_mistake(map)) return;
  abbe::DecodeOptions options;
  options.base = abbe::best_time_base(survey);
  options.keep_short = true;
  const auto decoded = abbe::decode_capture(path, abbe::plan_columns(map, survey), survey, options,
                                            [](const abbe::ColumnBlock& block) {
                                              for (const double t : block.time) require(std::isfinite(t));
                                              for (const auto& column : block.columns) {
                                                for (const double value : column)
                                                  require(std::isfinite(value));
                                              }
                                              return true;
                                            });
  require(std::holds_alternative<abbe::DecodeReport>(decoded));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scratch scratch;
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::ofstream(scratch.path, std::ios::binary | std::ios::trunc) << text;
  const auto surveyed = abbe::survey_capture(scratch.path);
  if (const auto* survey = std::get_if<abbe::CaptureSurvey>(&surveyed)) decode(scratch.path, *survey);

  const auto map = abbe::read_map("map.toml", text);
  require(map.value.has_value() != abbe::has_errors(map.diagnostics));
  const auto eni = abbe::read_eni("eni.xml", text);
  require(eni.value.has_value() != abbe::has_errors(eni.diagnostics));
  if (eni.value) require(!abbe::map_mistake(*eni.value));
  return 0;
}
