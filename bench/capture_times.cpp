// capture_times FILE FRAMES ROUNDS
//
// Writes FILE, a synthetic capture of FRAMES frames (three drives, 60 bytes of process data and the reference
// clock; half of them on their way out), unless it is there, then decodes all its columns and prints the
// processor time of the best round: "decode SECONDS survey SECONDS". bench/compare_tshark.sh holds tshark
// beside it.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "abbe/capture/decode.h"
#include "abbe/capture/write_capture.h"

namespace {

const std::vector<abbe::ServoAxis> kAxes = {
    {"X", 1001, 10000, "mm"}, {"Y", 1002, 10000, "mm"}, {"Z", 1003, 20000, "mm"}};

bool write(const std::string& path, std::size_t frames) {
  std::vector<double> x, y;
  for (std::size_t i = 0; i < frames / 2; ++i) {
    x.push_back(100 * std::cos(1e-3 * static_cast<double>(i)));
    y.push_back(100 * std::sin(1e-3 * static_cast<double>(i)));
  }
  const std::vector<abbe::CaptureColumn> columns = {{"X.position_actual", x}, {"Y.position_actual", y}};
  abbe::CaptureSettings settings;
  settings.esl = abbe::EslPlace::none;
  auto created = abbe::SpoolFile::create(path);
  auto* out = std::get_if<abbe::SpoolFile>(&created);
  return out != nullptr && !abbe::write_capture(abbe::servo_map(kAxes), columns, settings, *out) &&
         out->publish();
}

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

int main(int count, char** words) {
  if (count != 4) {
    std::fprintf(stderr, "usage: capture_times FILE FRAMES ROUNDS\n");
    return 2;
  }
  const std::string path = words[1];
  if (!std::filesystem::exists(path) && !write(path, std::strtoul(words[2], nullptr, 10))) {
    std::fprintf(stderr, "%s: cannot be written\n", path.c_str());
    return 1;
  }
  double decode = 1e9, survey_time = 1e9, sum = 0;
  std::size_t rows = 0;
  for (int round = 0; round < std::atoi(words[3]); ++round) {
    const double begin = seconds();
    const auto surveyed = abbe::survey_capture(path);
    const auto* survey = std::get_if<abbe::CaptureSurvey>(&surveyed);
    if (survey == nullptr) return 1;
    const double middle = seconds();
    const auto plan = abbe::plan_columns(abbe::servo_map(kAxes), *survey);
    rows = 0;
    const auto decoded = abbe::decode_capture(path, plan, *survey, {}, [&](const abbe::ColumnBlock& block) {
      rows += block.time.size();
      sum += block.columns[0].back();
      return true;
    });
    if (!std::holds_alternative<abbe::DecodeReport>(decoded)) return 1;
    survey_time = std::min(survey_time, middle - begin);
    decode = std::min(decode, seconds() - middle);
  }
  std::printf("decode %.6f survey %.6f rows %zu (%.3g)\n", decode, survey_time, rows, sum);
}
