#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <regex>

#include "abbe/core/units.h"
#include "abbe/report/figure.h"
#include "abbe/report/header.h"
#include "abbe/report/program_report.h"
#include "abbe/report/test_svg.h"

namespace abbe {
namespace {

using nlohmann::json;

/// A run as compensate would hand it over: 40 um before, 0.3 um after, on a dome of 120 x 80 mm.
class Report : public ::testing::Test {
 protected:
  void SetUp() override {
    machine_.name = "VMC 850 (line 2)";
    machine_.chain = "w X b Y Z t";
    machine_.sha256 = std::string(64, 'a');
    machine_.calibration.date = "2026-03-02";
    machine_.calibration.machine_id = "17";
    machine_.calibration.valid_to = "2026-09-02";
    machine_.calibration.control_compensation = "pitch on, volumetric off";
    machine_.calibration.temperature = 20.5;
    machine_.tool.length = 80;

    rewrite_.complete = true;
    rewrite_.lines_in = 5204;
    rewrite_.bytes_in = 123456;
    rewrite_.sha256_in = std::string(64, 'b');
    rewrite_.blocks = {5000, 4990, 3, 200};
    rewrite_.arcs_in = 12;
    rewrite_.arcs_out = 14;
    rewrite_.max_correction = {18.4 * um, 11.0 * um, 22.7 * um};
    rewrite_.max_line = {88, 99, 111};
    rewrite_.max_gradient = 41e-6;
    rewrite_.cycle_residual = 0.75 * um;
    rewrite_.sensitivity = {0.12 * um, 0.03 * um};
    Diagnostic warning;
    warning.severity = Severity::warning;
    warning.code = "W-SMOOTH";
    warning.place.line = 17;
    warning.message = "path blending is active";
    rewrite_.diagnostics = {warning, warning};

    verify_.agrees = true;
    verify_.original = {5204, 123456, std::string(64, 'b')};
    verify_.output = {5220, 130000, std::string(64, 'c')};
    verify_.before = {41.2 * um, 27.9 * um, 1834, {30.1 * um, 12.0 * um, 25.2 * um}};
    verify_.after = {0.31 * um, 0.12 * um, 212, {0.2 * um, 0.2 * um, 0.1 * um}};
    verify_.quantisation = 0.05 * um;
    verify_.allowed = 1.05 * um;
    verify_.lost_motion = 0.5 * um;
    verify_.datums = {{"G54", 1, Vec3(12.1, -4.0, 8.8) * um}};

    report_.verb = "compensate";
    report_.program_version = "0.1.0";
    report_.input_name = "parts/Teil_\xC3\xA4(1).ngc";
    report_.output_name = "out/part.ngc";
    report_.machine = &machine_;
    report_.rewrite = &rewrite_;
    report_.verify = &verify_;
    report_.setup.work_offsets[0] = WorkOffset{{-412, -201.5, -388.25}, 0};
    report_.setup.gauges[3] = 112.4;
    report_.tolerance = 1 * um;
    report_.max_correction = 500 * um;
  }

  /// A zigzag over a dome; the deviation grows to one corner.
  void fill_samples(std::size_t count, double depth) {
    double travelled = 0;
    verify_.samples.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const double part = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
      const double row = std::floor(part * 40), along = part * 40 - row;
      PathSample sample;
      sample.line = i;
      const double x = (static_cast<int>(row) % 2 == 0 ? along : 1 - along) * 120, y = row * 2;
      sample.position = Vec3(x, y, -depth * (std::pow(x / 60 - 1, 2) + std::pow(y / 40 - 1, 2)));
      if (i > 0) travelled += (sample.position - verify_.samples.back().position).norm();
      sample.travelled = travelled;
      sample.before = Vec3(10 + 0.2 * x, 5 - 0.1 * y, -8 + 0.05 * x + 0.1 * y) * um;
      sample.after = Vec3(0.2 * std::sin(x), 0.15 * std::cos(3 * y), 0.1 * std::sin(x + y)) * um;
      verify_.samples.push_back(sample);
    }
  }

  Machine machine_;
  RewriteReport rewrite_;
  VerifyReport verify_;
  ProgramReport report_;
};

TEST_F(Report, JsonHasTheMembersThatScriptsRelyOn) {
  const json read = json::parse(json_report(report_));
  EXPECT_EQ(read["format"], 1);
  EXPECT_EQ(read["result"], "verified");
  EXPECT_EQ(read["input"]["lines"], 5204);
  EXPECT_EQ(read["input"]["bytes"], 123456);
  EXPECT_EQ(read["input"]["sha256"], std::string(64, 'b'));
  EXPECT_EQ(read["output"]["sha256"], std::string(64, 'c'));
  EXPECT_EQ(read["machine"]["name"], "VMC 850 (line 2)");
  EXPECT_EQ(read["machine"]["id"], "17");
  EXPECT_DOUBLE_EQ(read["before"]["max_um"], 41.2);
  EXPECT_DOUBLE_EQ(read["before"]["rms_um"], 27.9);
  EXPECT_EQ(read["before"]["max_line"], 1834);
  EXPECT_DOUBLE_EQ(read["after"]["max_um"], 0.31);
  EXPECT_DOUBLE_EQ(read["quantisation_um"], 0.05);
  EXPECT_DOUBLE_EQ(read["tolerance_um"], 1);
  EXPECT_DOUBLE_EQ(read["datum"]["removed_um"][1], -4.0);
  EXPECT_EQ(read["datum"]["frames"][0]["frame"], "G54");
  EXPECT_EQ(read["blocks"],
            json::parse(R"({"motion":5000,"rewritten":4990,"split":3,"passed":200,"held":0})"));
  EXPECT_EQ(read["arcs"], json::parse(R"({"in":12,"out":14})"));
  EXPECT_DOUBLE_EQ(read["corrections"]["max_um"][2], 22.7);
  EXPECT_EQ(read["corrections"]["lines"], json::array({88, 99, 111}));
  EXPECT_DOUBLE_EQ(read["corrections"]["max_gradient_um_per_m"], 41);
  EXPECT_DOUBLE_EQ(read["cycle_residual_um"], 0.75);
  EXPECT_DOUBLE_EQ(read["sensitivity"]["offset_um_per_mm"], 0.12);
  EXPECT_DOUBLE_EQ(read["sensitivity"]["length_um_per_mm"], 0.03);
  EXPECT_DOUBLE_EQ(read["lost_motion_um"], 0.5);
  EXPECT_EQ(read["calibration"]["control_compensation"], "pitch on, volumetric off");
  // The same finding of both passes is one finding.
  ASSERT_EQ(read["warnings"].size(), 1U);
  EXPECT_EQ(read["warnings"][0]["code"], "W-SMOOTH");
  EXPECT_EQ(read["warnings"][0]["line"], 17);
}

TEST_F(Report, SameReportSameBytes) {
  fill_samples(500, 10);
  EXPECT_EQ(json_report(report_), json_report(report_));
  EXPECT_EQ(figure_before_after(report_), figure_before_after(report_));
  EXPECT_EQ(human_report(report_), human_report(report_));
}

TEST_F(Report, SaysHowTheRunEnded) {
  EXPECT_EQ(result_of(report_), ProgramResult::verified);
  verify_.agrees = false;
  EXPECT_EQ(result_of(report_), ProgramResult::disagrees);
  Diagnostic unknown;
  unknown.code = "E-CODE";
  verify_.diagnostics = {unknown};
  EXPECT_EQ(result_of(report_), ProgramResult::refused);
  rewrite_.complete = false;
  report_.verify = nullptr;
  EXPECT_EQ(result_of(report_), ProgramResult::refused);
  rewrite_.out_of_volume = true;
  EXPECT_EQ(result_of(report_), ProgramResult::outside);
  rewrite_.stopped = true;
  EXPECT_EQ(result_of(report_), ProgramResult::stopped);
  EXPECT_TRUE(json::accept(json_report(report_)));
  EXPECT_NE(human_report(report_).find("stopped"), std::string::npos);
}

TEST_F(Report, LimitDecidesPass) {
  EXPECT_FALSE(json::parse(json_report(report_)).contains("pass"));
  report_.limit = 0.4 * um;
  EXPECT_TRUE(json::parse(json_report(report_))["pass"]);
  report_.limit = 0.3 * um;
  EXPECT_FALSE(json::parse(json_report(report_))["pass"]);
}

TEST_F(Report, HumanReportTellsBeforeAndAfter) {
  const std::string text = human_report(report_);
  EXPECT_NE(text.find("max 41.2 um (line 1834)"), std::string::npos) << text;
  EXPECT_NE(text.find("max 0.310 um (line 212)"), std::string::npos) << text;
  EXPECT_NE(text.find("x +12.1 y -4.0 z +8.8 um"), std::string::npos) << text;
  if (std::getenv("ABBE_SHOW") != nullptr) std::fputs(text.c_str(), stdout);
}

TEST_F(Report, FirstHeaderLineIsTheMark) {
  EXPECT_EQ(header_lines(report_).front(), "(ABBE COMPENSATED - DO NOT EDIT - DO NOT RE-COMPENSATE)");
}

TEST_F(Report, EveryHeaderLineIsShortAndPlain) {
  machine_.name = std::string(300, 'x') + " ;(M3) %\n\xFF\xC3\xA4";
  machine_.calibration.control_compensation = "(((;%M30\r\n";
  const std::regex plain(R"(\(ABBE [A-Z0-9 .,:/+=-]*\))");
  for (const std::string& line : header_lines(report_)) {
    EXPECT_LE(line.size(), 60U) << line;
    EXPECT_TRUE(std::regex_match(line, plain)) << line;
  }
}

TEST_F(Report, HeaderNamesItsOrigins) {
  std::string all;
  for (const std::string& line : header_lines(report_)) all += line + "\n";
  for (const char* part :
       {"SRC TEIL- 1 .NGC", "LINES 5204", "SHA256 BBBBBBBBBBBB", "ID 17", "CALIBRATED 2026-03-02",
        "VALID TO 2026-09-02", "PITCH ON, VOLUMETRIC OFF", "G54 X-412.000 Y-201.500 Z-388.250",
        "T3 GAUGE 112.400 MM", "TEMP 20.5 C", "TOLERANCE 1 UM"}) {
    EXPECT_NE(all.find(part), std::string::npos) << part << " in\n" << all;
  }
}

/// Tags of the picture balance, and no number in it is nan or inf.
TEST_F(Report, FigureIsWellFormedForAnySamples) {
  std::mt19937_64 random{3};
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 60; ++k) {
    verify_.samples.clear();
    const double size = std::pow(10, 6 * unit(random)), where = std::pow(10, 5 * unit(random));
    for (std::size_t i = 0, n = random() % 30; i < n; ++i) {
      PathSample s;
      s.position =
          Vec3(where + size * unit(random), size * unit(random) * (k % 3), size * unit(random) * (k % 2));
      s.travelled = static_cast<double>(i) * size;
      s.before = Vec3(unit(random), unit(random), 0) * (k % 5 == 0 ? 0 : 1e-2);
      if (k % 7 == 0 && i % 4 == 0) s.before.x() = std::numeric_limits<double>::quiet_NaN();
      s.after = 0.01 * s.before;
      s.rapid = random() % 4 == 0;
      verify_.samples.push_back(s);
    }
    EXPECT_TRUE(test::well_formed(figure_before_after(report_)));
  }
  report_.verify = nullptr;
  EXPECT_TRUE(test::well_formed(figure_before_after(report_)));
}

TEST_F(Report, FigureOfALongPathStaysSmall) {
  fill_samples(200000, 10);
  EXPECT_LT(figure_before_after(report_).size(), 1500000U);
}

/// The pictures for a look: ABBE_FIGURES=folder abbe_report_test --gtest_filter='*Looks*'.
TEST_F(Report, FigureLooks) {
  const char* folder = std::getenv("ABBE_FIGURES");
  if (folder == nullptr) GTEST_SKIP() << "ABBE_FIGURES is not set";
  const auto save = [&](const char* name) {
    std::ofstream(std::string(folder) + "/" + name) << figure_before_after(report_);
  };
  fill_samples(4000, 5);
  save("plan.svg");
  fill_samples(4000, 40);
  save("isometric.svg");
  fill_samples(1, 5);
  save("point.svg");
  fill_samples(30, 0);
  for (PathSample& s : verify_.samples) s.position.y() = s.position.z() = 0;
  save("straight.svg");
  verify_.samples.clear();
  save("empty.svg");
}

}  // namespace
}  // namespace abbe
